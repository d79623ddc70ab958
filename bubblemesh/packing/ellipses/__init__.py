"""Packing of ellipses: the multilevel method in a metric.

References
----------
K. Shimada, A. Yamada, T. Itoh, "Anisotropic triangulation of parametric surfaces via close packing of ellipsoids",
Int. J. Comput. Geom. Appl. 10 (2000) 417-440, for the idea; neighbours, flips, levels and smoothing are others here.
"""
