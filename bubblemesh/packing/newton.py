"""What Newton's method needs of a net: metrics that change around its nodes, their axes, and groups of them."""

from collections.abc import Callable

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.kernels.library import or_numpy
from bubblemesh.kernels.newton import Metrics
from bubblemesh.kernels.patches import first_groups
from bubblemesh.kernels.tensors import mapped, unmapped
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.packing.neighbours import maximal_independent_set

STEP = 0.1  # length of the differences by which it is known how the metric changes

RootsAt = Callable[[Floats], Floats]  # roots (k, 3) of the metric at places (k, 2), as of `kernels.tensors.roots`


def roots_around(x: Floats, triangles: Integers, roots_at: RootsAt) -> tuple[Floats, Floats]:
    """Roots of the metric at the centroids of triangles (t, 3), and at their nodes x (n, 2).

    They are asked for at once, which takes less time.
    """
    root = roots_at(np.concatenate([x[triangles].mean(axis=1), x]))
    return root[: len(triangles)], root[len(triangles) :]


def steady_metrics(x: Floats, triangles: Integers, inside: Floats, own: Floats) -> tuple[Metrics, Metrics]:
    """Metrics that do not change, inside triangles (t, 3) and at nodes x (n, 2), of roots there, (t, 3) and (n, 3)."""
    within = Metrics(x[triangles].mean(axis=1), inside, np.zeros((len(triangles), 6)))
    return within, Metrics(x, own, np.zeros((len(x), 6)))


def metrics_around(
    x: Floats, triangles: Integers, inside: Floats, own: Floats, moving: Booleans, roots_at: RootsAt
) -> tuple[Metrics, Metrics]:
    """Metrics inside triangles (t, 3), and around their nodes x (n, 2), by their roots there, (t, 3) and (n, 3).

    Around nodes that are not moving (n,) the changes of the metric are left out.
    """
    within, around = steady_metrics(x, triangles, inside, own)
    places, root = np.concatenate([within.places, x[moving]]), np.concatenate([inside, own[moving]])
    slopes = changes_at(places, root, roots_at)
    around.slopes[moving] = slopes[len(triangles) :]
    return within._replace(slopes=slopes[: len(triangles)]), around


def changes_at(places: Floats, root: Floats, roots_at: RootsAt) -> Floats:
    """Changes (k, 6) of the metric, by differences, at places (k, 2) where it has roots (k, 3): those of `Metrics`."""
    steps = [unmapped(root, np.broadcast_to(STEP * axis, places.shape)) for axis in np.eye(2)]
    ahead, over = np.split(roots_at(np.concatenate([places + step for step in steps])), 2)
    return np.column_stack([ahead - root, over - root]) / STEP


def axes_with(own: Metrics, sliding: slice, tangents: Floats) -> Floats:
    """Axes (n, 4) of nodes by the metrics around them, of which those ``sliding`` go along tangents (b, 2) only."""
    axes = own.axes
    lengths = np.hypot(*mapped(own.roots[sliding], tangents).T)
    axes[sliding] = np.column_stack([tangents / lengths[:, None], np.zeros_like(tangents)])
    return axes


def side_weight(spacing_weight: float) -> float:
    """Weight of the term (l - 1 / l)^2 of each side of a triangle, by that of (l - 1)^2 of each edge.

    It is about 4 (l - 1)^2, and most edges are sides of two triangles.
    """
    return spacing_weight / 8


def independent_groups_in_numpy(chosen: Booleans, triangles: Integers) -> list[Integers]:
    """The same as `independent_groups`, in NumPy."""
    left, rank, edges, groups = chosen, np.arange(len(chosen)), unique_edges(triangles)[0], list[Integers]()
    while left.any():
        found = maximal_independent_set(left, edges, rank)
        groups.append(np.flatnonzero(found))
        left = left & ~found
    return groups


@or_numpy(independent_groups_in_numpy)
def independent_groups(chosen: Booleans, triangles: Integers) -> list[Integers]:
    """Groups (k,) of the chosen nodes (n,) of triangles (t, 3), no two of which are neighbours.

    Each node, in the order of their numbers, is in the first group in which none of its neighbours is.
    """
    groups = first_groups(chosen, triangles)
    return [np.flatnonzero(groups == number) for number in range(groups.max(initial=-1) + 1)]
