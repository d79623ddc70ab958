"""Any smooth parametric curve as a cubic spline through enough of its points."""

from collections.abc import Callable

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.geometry.curves import Splines, turning

SEAM = 1e-4  # of a closed curve's parameter, beside its start
SMOOTH_TURN = 0.01  # radians over the seam
ACCURACY = 1e-6  # of the curve's extent: how far the spline may be from it
FEWEST, MOST_DOUBLINGS = 8, 9  # of the intervals between points
PANELS = 8  # of the table of arc lengths in an interval: enough to compare distances


def splines(curve: Callable[[Floats], Floats]) -> list[Floats]:
    """Points of one or more cubic splines that follow ``curve`` over [0, 1], one after the other.

    A curve that ends in a corner at its own start is cut in two: a closed spline would be smooth there.
    """
    points = curve(np.array([0, SEAM, 1 - SEAM, 1]))
    extent = float(np.ptp(curve(np.linspace(0, 1, FEWEST)), axis=0).max())
    closed = np.hypot(*(points[-1] - points[0])) <= ACCURACY * extent
    (turn,) = np.abs(turning(points[-1:] - points[-2:-1], points[1:2] - points[:1]))
    if not closed or turn < SMOOTH_TURN:
        return [_through(curve)]
    return [_through(lambda t: curve(t / 2)), _through(lambda t: curve((1 + t) / 2))]


def _through(curve: Callable[[Floats], Floats]) -> Floats:
    """Points (k, 2) of a smooth curve over [0, 1], the ends included, whose cubic spline follows it."""
    for doublings in range(MOST_DOUBLINGS + 1):
        t = np.linspace(0, 1, FEWEST * 2**doublings + 1)
        points, between = curve(t), curve((t[1:] + t[:-1]) / 2)
        if _departure(points, between) <= ACCURACY * np.ptp(points, axis=0).max():
            break
    return points


def _departure(points: Floats, between: Floats) -> float:
    """Largest distance from the spline of points of the curve between its knots."""
    from scipy.spatial import cKDTree

    if (np.diff(points, axis=0) == 0).all(axis=1).any():
        return 0.0
    spline = Splines([points], panels=PANELS)
    samples = 64 * (len(points) - 1)
    s = np.linspace(0, spline.lengths[0], samples + 1)
    dense = spline.points(np.zeros(len(s), int), s)
    _, near = cKDTree(dense).query(between)
    before, after = (_to_lines(between, dense, np.clip(near + shift, 0, samples - 1)) for shift in (-1, 0))
    return float(np.minimum(before, after).max())


def _to_lines(points: Floats, line: Floats, k: Integers) -> Floats:
    """Distances (m,) of points (m, 2) from the straight lines through points k (m,) and k + 1 of ``line``."""
    (ax, ay), (bx, by) = (line[k + 1] - line[k]).T, (points - line[k]).T
    return np.abs(ax * by - ay * bx) / np.hypot(ax, ay)
