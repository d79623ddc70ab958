"""Cycles of annealing in a metric at once: the twin goes through them one by one, in `packing.ellipses.annealing`."""

from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.kernels.annealing import Cycles
from bubblemesh.kernels.ellipse_flips import FLATTEST, MOST_PASSES, SURE
from bubblemesh.kernels.ellipse_motion import KEEP, MOST_MOVE, SHORTEST
from bubblemesh.kernels.library import Library
from bubblemesh.kernels.linking import room_of_edges, shortened
from bubblemesh.kernels.relaxing import CUTOFF


class Tensors(NamedTuple):
    """Tensors that ellipses keep through some cycles."""

    entries: Floats  # (n, 3)
    roots: Floats  # (n, 3): as in `tensors.roots`


class Relaxing(NamedTuple):
    """How ellipses are relaxed in each cycle: arguments of `ellipse_motion.relaxed`."""

    fixed: int  # the first ones, which stay
    steps: int
    dt: float
    c: float


def annealed(
    compiled: Library,
    x: Floats,
    triangles: Integers,
    facets: Integers,
    tensors: Tensors,
    relaxing: Relaxing,
    cycles: Cycles,
) -> tuple[Floats, Integers, Integers]:
    """Places (n, 2), triangles (t, 3) and edges (e, 2) of ellipses after cycles of annealing from x (n, 2).

    Displacements are those of `Cycles` in the metric, shortened where they would invert a triangle. After each cycle
    edges are flipped, but not the facets (f, 2).
    """
    places, result = np.array(x, order="C"), np.array(triangles, order="C")
    edges, count = room_of_edges(triangles)
    net = len(x), len(result), result, len(facets), np.ascontiguousarray(facets), places
    known = (np.ascontiguousarray(part) for part in tensors)
    displacing = cycles.calm, len(cycles.inside), cycles.inside, cycles.beside, cycles.seed, cycles.first
    fixed, *motion = relaxing
    bounds = CUTOFF, MOST_MOVE, KEEP, SHORTEST, MOST_PASSES, SURE, FLATTEST
    compiled.call("metric_anneal", *net, *known, fixed, *displacing, *motion, *bounds, edges, count)
    return places, result, shortened(edges, count)
