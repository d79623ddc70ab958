"""Cubic splines that follow smooth parametric curves, through enough points of these."""

from collections.abc import Callable, Sequence
from itertools import islice

import numpy as np

from bubblemesh.arrays import Floats, Integers, members
from bubblemesh.geometry.cubic_splines import CubicSpline
from bubblemesh.geometry.curves import Splines, turning

SEAM = 1e-4  # of a closed curve's parameter, beside its start
SMOOTH_TURN = 0.01  # radians over the seam
ACCURACY = 1e-6  # of the curve's extent: how far the spline may be from it
MOST_TOGETHER = 200_000  # samples of splines in a block, to bound the memory
FEWEST, MOST_DOUBLINGS = 8, 9  # of the intervals between points
SAMPLES = 64  # of the spline in an interval
PANELS = 8  # of the table of arc lengths in an interval: enough to compare distances

Parametric = Callable[[Floats], Floats]  # points (m, 2) at parameters (m,) in [0, 1]


def splines(curves: Sequence[Parametric]) -> list[list[Floats]]:
    """For each curve over [0, 1], the points of one or more cubic splines that follow it, one after the other.

    A curve that ends in a corner at its own start is cut in two: a closed spline would be smooth there.
    """
    parts = [_smooth_parts(curve) for curve in curves]
    found = iter(_through([part for some in parts for part in some]))
    return [list(islice(found, len(some))) for some in parts]


def _smooth_parts(curve: Parametric) -> list[Parametric]:
    """The curve itself, or its halves if it is closed with a corner at its start."""
    points = curve(np.array([0, SEAM, 1 - SEAM, 1]))
    extent = float(np.ptp(curve(np.linspace(0, 1, FEWEST)), axis=0).max())
    closed = np.hypot(*(points[-1] - points[0])) <= ACCURACY * extent
    (turn,) = np.abs(turning(points[-1:] - points[-2:-1], points[1:2] - points[:1]))
    if not closed or turn < SMOOTH_TURN:
        return [curve]
    return [lambda t: curve(t / 2), lambda t: curve((1 + t) / 2)]


def _through(curves: Sequence[Parametric]) -> list[Floats]:
    """For each smooth curve over [0, 1], points (k, 2), ends included, through which a cubic spline follows it."""
    found, open_ = [np.zeros((0, 2)) for _ in curves], list(range(len(curves)))
    for doublings in range(MOST_DOUBLINGS + 1):
        if not open_:
            break
        t = np.linspace(0, 1, FEWEST * 2**doublings + 1)
        together = max(1, MOST_TOGETHER // (SAMPLES * len(t)))
        far = list[int]()
        for some in (open_[k : k + together] for k in range(0, len(open_), together)):
            points = np.stack([curves[k](t) for k in some])
            between = np.stack([curves[k]((t[1:] + t[:-1]) / 2) for k in some])
            follows = _departures(points, between) <= ACCURACY * np.ptp(points, axis=1).max(axis=1)
            for k, own in zip(some, points, strict=True):
                found[k] = own
            far += [k for k, near in zip(some, follows.tolist(), strict=True) if not near]
        open_ = far
    return found


def _departures(points: Floats, between: Floats) -> Floats:
    """Largest distances (n,) of curves, given by points between knots (n, k - 1, 2), from splines through (n, k, 2).

    They are zero if points coincide.
    """
    largest = np.zeros(len(points))
    different = np.flatnonzero((np.diff(points, axis=1) != 0).any(axis=2).all(axis=1))
    if len(different) == 0:
        return largest
    points, between = points[different], between[different]
    curves, intervals = between.shape[:2]
    family = Splines([CubicSpline.through(some) for some in points], panels=PANELS)
    samples = SAMPLES * intervals
    s = np.linspace(0, family.lengths, samples + 1, axis=1)
    dense = family.points(np.repeat(np.arange(curves), samples + 1), s.ravel())
    first = np.repeat(np.arange(curves) * (samples + 1), intervals)
    knots = np.stack([family.lengths_at(k)[::PANELS] for k in range(curves)]) * (samples / family.lengths)[:, None]
    near = _nearest(between.reshape(-1, 2), dense, first, knots, samples)
    lines = (first + np.clip(near - first + shift, 0, samples - 1) for shift in (-1, 0))
    before, after = (_to_lines(between.reshape(-1, 2), dense, k) for k in lines)
    largest[different] = np.minimum(before, after).reshape(curves, intervals).max(axis=1)
    return largest


def _nearest(between: Floats, dense: Floats, start: Integers, knots: Floats, samples: int) -> Integers:
    """Numbers (m,) of the dense points that are nearest to points (m, 2), each of them between two knots of its curve.

    The dense points of a curve begin with number ``start`` (m,) and have ``samples`` steps; ``knots`` (n, k) are
    measured in these steps.
    """
    first = np.maximum(np.floor(knots[:, :-1]).astype(np.int64) - 1, 0).ravel()
    last = np.minimum(np.ceil(knots[:, 1:]).astype(np.int64) + 1, samples).ravel()
    owner, rank = members(last - first + 1)
    sample = (start + first)[owner] + rank
    away = ((dense[sample] - between[owner]) ** 2).sum(axis=1)
    least = np.minimum.reduceat(away, np.flatnonzero(rank == 0))
    found = np.flatnonzero(away == least[owner])
    return sample[found[np.diff(owner[found], prepend=-1) > 0]]


def _to_lines(points: Floats, line: Floats, k: Integers) -> Floats:
    """Distances (m,) of points (m, 2) from the straight lines through points k (m,) and k + 1 of ``line``."""
    (ax, ay), (bx, by) = (line[k + 1] - line[k]).T, (points - line[k]).T
    return np.abs(ax * by - ay * bx) / np.hypot(ax, ay)
