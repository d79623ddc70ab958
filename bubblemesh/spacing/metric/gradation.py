"""Gradation: a metric at the nodes of a mesh that grows no faster than by some part over a length of 1 in it."""

import numpy as np

from bubblemesh.arrays import Floats, Integers, members
from bubblemesh.kernels.tensors import lengths
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.tensors import intersections

SETTLED = 1e-3  # relative change of the entries of a tensor that is none


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
    pairs = pairs[np.argsort(pairs[:, 1], kind="stable")]
    _, rank = members(np.bincount(pairs[:, 1], minlength=len(points)))
    turns = [pairs[rank == turn].T for turn in range(int(rank.max(initial=-1)) + 1)]
    result, told, news = tensors.copy(), tensors.copy(), np.ones(len(points), bool)
    while news.any():  # it goes on from node to node; each time a size is less by more than what counts as none
        told[news] = result[news]
        for origins, ends in turns:  # each node is the end of one edge at most
            origin, end = (nodes[news[origins]] for nodes in (origins, ends))
            length = lengths(told[origin], points[end] - points[origin])
            reach = told[origin] / ((1 + growth * length) ** 2)[:, None]
            result[end] = intersections(result[end], reach)
        news = np.abs(result - told).max(axis=1) > SETTLED * (told[:, 0] + told[:, 2])
    return result
