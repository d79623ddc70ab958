"""Periodic sides of a mesh: two sides with the same nodes, moved across the domain or turned about a point."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers, different_rows, extent
from bubblemesh.messages import coordinate, place

SHIFT_ROUNDING = 1e-9  # of the way between counterparts: a component of the shift below this share of it counts as 0
MATCH = 1e-8  # of the mesh's size; domains allow periodic sides a tenth of that
DIGITS = 12  # of an angle in degrees after the point: the others are rounding
BETTER = 0.01  # of the distance that a shift leaves: what a turn may leave in place of it


class PeriodicSides(NamedTuple):
    """Two sides, by their labels, of which the second is the first one moved to the right, or else upwards."""

    first: int
    second: int
    motion: Floats  # (2, 3): columns of a rotation, and a shift, which take points of the first side to the second
    nodes: Integers  # (k, 2) of the first side, and their counterparts on the second

    @property
    def shift(self) -> Floats:
        """The shift (2,) of the motion, after the rotation about the origin if there is one."""
        return self.motion[:, 2]

    @property
    def angle(self) -> float:
        """Angle in degrees, counter-clockwise, by which the second side is the first one turned; 0 if it is shifted."""
        return angle_of(self.motion)

    @property
    def center(self) -> Floats:
        """Point (2,) about which the second side is the first one turned; not a number if it is shifted."""
        return center_of(self.motion)

    def moved(self, points: Floats) -> Floats:
        """Places (n, 2) to which points (n, 2) of the first side are taken: those of the second."""
        return points @ self.motion[:, :2].T + self.shift


def angle_of(motion: Floats) -> float:
    """Angle in degrees, counter-clockwise, by which a motion (2, 3) turns; 0 if it is a shift."""
    return round(math.degrees(math.atan2(motion[1, 0], motion[0, 0])), DIGITS)


def center_of(motion: Floats) -> Floats:
    """Point (2,) about which a motion (2, 3) turns; not a number if it is a shift."""
    if angle_of(motion) == 0:
        return np.full(2, np.nan)
    return np.asarray(np.linalg.solve(np.eye(2) - motion[:, :2], motion[:, 2]) + 0.0, float)  # no -0


def motion_data(motion: Floats, sign: int = 1) -> dict[str, Any]:
    """A motion (2, 3) as plain data: its shift, or the angle and the center of a turn; with the sign -1 its inverse."""
    if angle_of(motion) == 0:
        return {"shift": (0 + sign * motion[:, 2]).tolist()}
    return {"angle": sign * angle_of(motion), "center": center_of(motion).tolist()}


def side_motion(side: str, other: str, motion: Floats, size: float) -> dict[str, Any]:
    """Row of a report on the motion (2, 3) of a side to another one, in a domain of a size; rounding errors are 0."""
    data = motion_data(motion)
    rounded = {key: _rounded(np.array(data[key]), SHIFT_ROUNDING * size).tolist() for key in data if key != "angle"}
    return {"side": side, "with": other, **data, **rounded}


def motion_text(row: Mapping[str, Any], size: float) -> str:
    """A row of `side_motion` in words, with as many digits as it takes to tell places in a domain of the size apart."""
    sides = f"{row['side']} to {row['with']}"
    if "angle" in row:
        return f"{sides}: turned by {row['angle']:.10g} degrees about {place(row['center'], size)}"
    return f"{sides}: moved by ({', '.join(coordinate(step, size) for step in row['shift'])})"


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
        Facets that match: the second is the first one moved or turned across the domain, and runs the other way.
    """
    if len(periodic) == 0:
        return ()
    labels, which = np.unique(facet_labels[periodic], axis=0, return_inverse=True)
    tolerance = MATCH * extent(points)
    sides = (facets[periodic[which == k]] for k in range(len(labels)))
    return tuple(
        _matching(points, a, b, pairs, tolerance) for (a, b), pairs in zip(labels.tolist(), sides, strict=True)
    )


def rigid_motion(here: Floats, there: Floats, tolerance: float) -> Floats:
    """The motion (2, 3) that takes points (n, 2) to others (n, 2): columns of a rotation, and a shift.

    It is a mere shift if that takes them there to within the tolerance, or about as well as a rotation.
    """
    shift = np.column_stack([np.eye(2), (there - here).mean(axis=0)])
    apart = misfit(shift, here, there)
    if apart <= tolerance:
        return shift
    middle, other = here.mean(axis=0), there.mean(axis=0)
    (x, y), (u, v) = (here - middle).T, (there - other).T
    cosine, sine = x @ u + y @ v, x @ v - y @ u  # of the rotation of least squares, but for a factor
    if cosine == sine == 0:
        return shift
    rotation = np.array([[cosine, -sine], [sine, cosine]]) / np.hypot(cosine, sine)
    turn = np.column_stack([rotation, other - rotation @ middle])
    return turn if misfit(turn, here, there) < BETTER * apart else shift


def misfit(motion: Floats, here: Floats, there: Floats) -> float:
    """The largest difference of a coordinate between points (n, 2), moved, and others (n, 2)."""
    return float(np.abs(here @ motion[:, :2].T + motion[:, 2] - there).max())


def _matching(points: Floats, first: int, second: int, pairs: Integers, tolerance: float) -> PeriodicSides:
    """The two sides with the given labels, from nodes (p, 2, 2) or (p, 2, 3) of the matching pairs of their facets."""
    here, there = pairs[:, 0], pairs[:, 1].copy()
    there[:, :2] = there[:, 1::-1]
    nodes, _ = different_rows(np.column_stack([here.ravel(), there.ravel()]))
    way = points[nodes[:, 1]] - points[nodes[:, 0]]
    small = SHIFT_ROUNDING * np.abs(way).max()
    if tuple(_rounded(way.mean(axis=0), small)) <= (0, 0):
        # All pairs have the same direction, so that chains of counterparts, as at the corners of a hexagon, end.
        first, second, nodes = second, first, nodes[:, ::-1]
    motion = rigid_motion(points[nodes[:, 0]], points[nodes[:, 1]], tolerance)
    motion[:, 2] = _rounded(motion[:, 2], small)
    return PeriodicSides(first, second, motion, nodes)


def _rounded(vector: Floats, small: float) -> Floats:
    """The vector (2,) with 0 for what is below a small length."""
    return np.where(np.abs(vector) < small, 0.0, vector)
