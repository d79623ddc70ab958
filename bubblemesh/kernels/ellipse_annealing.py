"""Cycles of annealing in a metric at once: the twin goes through them one by one, in `packing.ellipses.annealing`."""

from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.kernels.annealing import Cycles
from bubblemesh.kernels.ellipse_flips import FLATTEST_FLIP, MOST_FLIP_PASSES, SURE
from bubblemesh.kernels.ellipse_motion import KEEP, MOST_MOVE, SHORTEST_EDGE
from bubblemesh.kernels.library import call
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
    call(
        "metric_anneal",
        n=len(x),
        t=len(result),
        triangles=result,
        f=len(facets),
        facets=np.ascontiguousarray(facets),
        x=places,
        m=np.ascontiguousarray(tensors.entries),
        roots=np.ascontiguousarray(tensors.roots),
        fixed=relaxing.fixed,
        calm=cycles.calm,
        cycles=len(cycles.inside),
        inside=cycles.inside,
        beside=cycles.beside,
        seed=cycles.seed,
        first=cycles.first,
        steps=relaxing.steps,
        dt=relaxing.dt,
        c=relaxing.c,
        cutoff=CUTOFF,
        most=MOST_MOVE,
        keep=KEEP,
        shortest=SHORTEST_EDGE,
        passes=MOST_FLIP_PASSES,
        sure=SURE,
        flattest=FLATTEST_FLIP,
        edges=edges,
        count=count,
    )
    return places, result, shortened(edges, count)
