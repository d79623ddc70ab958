"""Gradation: a metric at the nodes of a mesh that grows no faster than by some part over a length of 1 in it."""

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.kernels.grading import grown
from bubblemesh.meshes.edges import unique_edges

SETTLED = 1e-3  # relative change of the entries of a tensor that counts as none


def graded(points: Floats, triangles: Integers, tensors: Floats, growth: float) -> Floats:
    """Tensors (n, 3) of points (n, 2) of a mesh, finer where the given ones grow too fast along its edges.

    The ellipse of a node, larger by the factor 1 + growth * L at the other end of an edge of length L in its metric,
    holds the ellipse there.

    References
    ----------
    F. Alauzet, "Size gradation control of anisotropic meshes", Finite Elem. Anal. Des. 46 (2010): homogeneous growth in
    the metric.
    """
    edges, _ = unique_edges(triangles)
    pairs = np.concatenate([edges, edges[:, ::-1]])
    ends = pairs[np.argsort(pairs[:, 0], kind="stable"), 1]
    begin = np.append(0, np.cumsum(np.bincount(pairs[:, 0], minlength=len(points))))
    return grown(points, begin, ends, tensors, growth, SETTLED)
