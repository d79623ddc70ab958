"""Periodic sides of a mesh: two sides with the same nodes, moved across the domain."""

from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers, different_rows

ROUNDING = 1e-9  # of a shift: a component below this share of it counts as 0


class PeriodicSides(NamedTuple):
    """Two sides, by their labels, of which the second is the first one moved to the right, or else upwards."""

    first: int
    second: int
    shift: Floats  # (2,) from the first side to the second
    nodes: Integers  # (k, 2) of the first side, and their counterparts on the second


def periodic_sides(
    points: Floats, facets: Integers, facet_labels: Integers, periodic: Integers
) -> tuple[PeriodicSides, ...]:
    """Pairs of sides whose nodes match.

    Parameters
    ----------
    points : (n, 2)
        The nodes.
    facets : (f, 2) or (f, 3)
        Node indices of labelled edges.
    facet_labels : (f,)
        Index of each facet's label.
    periodic : (p, 2)
        Facets that match: the second is the first one moved across the domain, and runs the other way.
    """
    if len(periodic) == 0:
        return ()
    labels, which = np.unique(facet_labels[periodic], axis=0, return_inverse=True)
    return tuple(_matching(points, facets, a, b, periodic[which == k]) for k, (a, b) in enumerate(labels.tolist()))


def _matching(points: Floats, facets: Integers, first: int, second: int, pairs: Integers) -> PeriodicSides:
    """The two sides with the given labels, from the matching pairs (p, 2) of their facets."""
    here, there = facets[pairs[:, 0]], facets[pairs[:, 1]].copy()
    there[:, :2] = there[:, 1::-1]
    nodes, _ = different_rows(np.column_stack([here.ravel(), there.ravel()]))
    shift = (points[nodes[:, 1]] - points[nodes[:, 0]]).mean(axis=0)
    shift[np.abs(shift) < ROUNDING * np.abs(shift).max()] = 0
    if tuple(shift) > (0, 0):
        return PeriodicSides(first, second, shift, nodes)
    # All pairs have the same direction, so that chains of counterparts, as at the corners of a hexagon, end.
    return PeriodicSides(second, first, 0 - shift, nodes[:, ::-1])
