"""Boundary layers: beside Gmsh's, in a solver for which the answer is known, and in files for two flow solvers."""
