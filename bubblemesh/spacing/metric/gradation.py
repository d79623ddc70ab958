"""Gradation: a metric at the nodes of a mesh that grows no faster than by some part over a length of 1 in it."""

import numpy as np

from bubblemesh.arrays import Floats, Integers, members
from bubblemesh.kernels.tensors import lengths
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.tensors import intersected_at

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
    counts = np.bincount(pairs[:, 0], minlength=len(points))
    first = np.cumsum(counts) - counts
    result, told, news = tensors.copy(), tensors.copy(), np.arange(len(points))
    while len(news):  # it goes on from node to node; each time a size is less by more than what counts as none
        told[news] = result[news]
        of, rank = members(counts[news])
        origin, end = news[of], ends[first[news][of] + rank]
        length = lengths(told[origin], points[end] - points[origin])
        result = intersected_at(result, end, told[origin] / ((1 + growth * length) ** 2)[:, None])
        reached = np.unique(end)
        change = np.abs(result[reached] - told[reached]).max(axis=1)
        news = reached[change > SETTLED * (told[reached, 0] + told[reached, 2])]
    return result
