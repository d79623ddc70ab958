"""Motion in a metric that inverts no triangle, compiled or in NumPy alike.

Tensors are rows (m11, m12, m22).
"""

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.kernels.library import call, or_numpy
from bubblemesh.kernels.relaxing import CUTOFF, pair_force
from bubblemesh.kernels.tensors import lengths, mean_lengths

HALVINGS, MOST_TRIES = 4, 40  # of steps that would invert triangles, as in the C file
KEEP = 0.1  # of its area that each triangle keeps in a step
SHORTEST_EDGE = 1e-9  # edge
MOST_MOVE = 0.5  # in a step


def moved_in_numpy(x: Floats, move: Floats, triangles: Integers) -> tuple[Floats, Floats]:
    """The same as `moved`, in NumPy."""
    share, least = np.ones(len(x)), KEEP * _doubled_areas(x, triangles)
    for tries in range(MOST_TRIES):
        places = x + share[:, None] * move
        bad = _doubled_areas(places, triangles) < least
        if not bad.any():
            return places, share
        nodes = triangles[bad]
        share[nodes] = share[nodes] / 2 if tries < HALVINGS else 0.0
    return x, np.zeros(len(x))


@or_numpy(moved_in_numpy)
def moved(x: Floats, move: Floats, triangles: Integers) -> tuple[Floats, Floats]:
    """Nodes (n, 2) after moves (n, 2) from x (n, 2) that invert no triangle (t, 3), and the shares (n,) of them made.

    Each triangle keeps at least a tenth of its area: if it would not, the moves of its nodes are halved, `HALVINGS`
    times at most, and then left out.
    """
    places, share = np.array(x, order="C"), np.empty(len(x))
    call(
        "guarded_move",
        n=len(x),
        t=len(triangles),
        triangles=np.ascontiguousarray(triangles),
        x=places,
        move=np.ascontiguousarray(move),
        keep=KEEP,
        share=share,
    )
    return places, share


def _doubled_areas(x: Floats, triangles: Integers) -> Floats:
    a, b, c = (x[triangles[:, k]] for k in range(3))
    return np.asarray((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]))


def relaxed_in_numpy(
    x: Floats, m: Floats, triangles: Integers, edges: Integers, fixed: int, steps: int, dt: float, c: float
) -> tuple[Floats, Floats]:
    """The same as `relaxed`, in NumPy."""
    x, v, speeds, n, (i, j) = x.copy(), np.zeros_like(x), np.empty(steps), len(x), edges.T
    for step in range(steps):
        along = x[j] - x[i]
        first, last = (np.maximum(lengths(m[k], along), SHORTEST_EDGE) for k in (i, j))
        length = mean_lengths(first, last)
        force = pair_force(length) / length
        pulls = [np.bincount(j, force * part, n) - np.bincount(i, force * part, n) for part in along.T]
        v = (v + dt * np.column_stack(pulls)) / (1 + c * dt)
        v[:fixed] = 0
        v = (MOST_MOVE / np.maximum(lengths(m, dt * v), MOST_MOVE))[:, None] * v
        x, share = moved_in_numpy(x, dt * v, triangles)
        v = v * share[:, None]
        speeds[step] = np.cumsum(lengths(m, v))[-1] / n
    return x, speeds


@or_numpy(relaxed_in_numpy)
def relaxed(
    x: Floats, m: Floats, triangles: Integers, edges: Integers, fixed: int, steps: int, dt: float, c: float
) -> tuple[Floats, Floats]:
    """Nodes (n, 2) after steps of motion from rest at x (n, 2), and their mean speeds (steps,) in the metric.

    The force of equation (2.1) acts along the edges (e, 2) at their lengths in the tensors m (n, 3), damped by c; the
    first ``fixed`` nodes stay, and moves invert no triangle (t, 3).
    """
    places, speeds = np.array(x, order="C"), np.empty(steps)
    call(
        "metric_relax",
        n=len(x),
        t=len(triangles),
        triangles=np.ascontiguousarray(triangles),
        e=len(edges),
        edges=np.ascontiguousarray(edges),
        x=places,
        m=np.ascontiguousarray(m),
        fixed=fixed,
        steps=steps,
        dt=dt,
        c=c,
        cutoff=CUTOFF,
        most=MOST_MOVE,
        keep=KEEP,
        shortest=SHORTEST_EDGE,
        speeds=speeds,
    )
    return places, speeds
