"""Splines of a DXF drawing as pieces of a curve: straight ones and cubic Bézier curves exactly, others sampled."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from bubblemesh.arrays import Floats
from bubblemesh.geometry.beziers import Beziers
from bubblemesh.geometry.paths import Point
from bubblemesh.geometry.rings import BezierTo, LineTo, Piece, SplineTo
from bubblemesh.readers.features import CompoundCurve, finite_points
from bubblemesh.readers.sampling import Parametric, splines

CUBIC = 3
ROUNDING = 1e-9  # of a curve's length: distance from a straight line, or extent of a part, that is due to rounding

Span = tuple[float, float]  # of the parameter


def b_spline(tool: Any, name: str, label: str | None) -> CompoundCurve | None:
    """The curve of a B-spline of ezdxf, None if it is a point; a periodic one has knots outside.

    Between corners it is a straight line, a cubic Bézier curve where it is a regular one, or a spline through points.
    """
    knots, controls = np.array(tool.knots(), float), np.array(finite_points(tool.control_points, name))
    begin, end = float(knots[tool.degree]), float(knots[-tool.degree - 1])
    spans = list(pairwise([begin, *_corners(knots, controls, tool.degree, begin, end), end]))
    same = len(set(tool.weights())) < 2
    exact = dict[Span, Floats]()
    if tool.degree == CUBIC and same:
        exact = {span: four for span in spans if (four := _bezier(knots, controls, span)) is not None}
    sampled = iter(splines([through(tool.points, *span, name) for span in spans if span not in exact]))
    parts = [[exact[span]] if span in exact else next(sampled) for span in spans]
    small = _rounding(controls)
    pieces = list[Piece]()
    for span, some in zip(spans, parts, strict=True):
        pieces += _pieces(some, span in exact, small, label)
    (start,) = finite_points(parts[0][0][:1], name)
    return CompoundCurve(start, tuple(pieces), name) if pieces else None


def sampled_curve(
    points: Callable[[list[float]], Iterable[Any]], span: Span, name: str, label: str | None
) -> CompoundCurve | None:
    """A smooth curve by a library's function of a parameter in a span; None if it is a point."""
    (parts,) = splines([through(points, *span, name)])
    (start,) = finite_points(parts[0][:1], name)
    pieces = tuple(_pieces(parts, False, _rounding(np.concatenate(parts)), label))
    return CompoundCurve(start, pieces, name) if pieces else None


def through(points: Callable[[list[float]], Iterable[Any]], begin: float, end: float, name: str) -> Parametric:
    """Curve over [0, 1] from a library's function of a parameter between two values."""
    return lambda t: np.array(finite_points(list(points((begin + (end - begin) * t).tolist())), name))


def _corners(knots: Floats, controls: Floats, degree: int, begin: float, end: float) -> list[float]:
    """Knots within a B-spline at which it may have a corner, or a gap.

    These are knots that count as often as its degree, and those at which as many of its control points are one place.
    """
    inner, count = np.unique(knots[(knots > begin) & (knots < end)], return_counts=True)
    if len(inner) == 0:
        return []
    stays = (np.diff(controls, axis=0) == 0).all(axis=1)
    runs = np.zeros(0, np.int64)
    if len(stays) >= degree - 1 > 0:
        runs = np.flatnonzero(sliding_window_view(stays, degree - 1).all(axis=1))
    found: list[float] = inner[(count >= degree) | np.isin(inner, knots[degree + runs])].tolist()
    return found


def _bezier(knots: Floats, controls: Floats, span: Span) -> Floats | None:
    """The control points (4, 2) of a cubic B-spline in a span in which it is one regular Bézier curve; else None."""
    begin, end = span
    last = int(np.searchsorted(knots, begin, side="right"))  # the first knot after the begin of the span
    if knots[last] != end or knots[last - CUBIC] != begin or knots[last + CUBIC - 1] != end:
        return None
    four = controls[last - CUBIC - 1 : last]
    return four if Beziers(*four[:, None]).regular.all() else None


def _pieces(parts: Sequence[Floats], is_bezier: bool, small: float, label: str | None) -> Iterator[Piece]:
    """Pieces of parts with points (k, 2), on which they go or, of a Bézier curve, that control it.

    There are none of parts that are no larger than the rounding of their points.
    """
    for part in parts:
        points: list[Point] = [(x, y) for x, y in part.tolist()]
        if np.ptp(part, axis=0).max() <= small:
            continue
        if _is_straight(part):
            yield LineTo(points[-1], label)
        elif is_bezier:
            yield BezierTo(points[3], points[1], points[2], label)
        else:
            yield SplineTo(points[1:], label)


def _rounding(points: Floats) -> float:
    """Extent that parts of a curve have by the rounding of its points (k, 2) alone."""
    return ROUNDING * float(np.ptp(points, axis=0).max())


def _is_straight(points: Floats) -> bool:
    """Whether points (k, 2) are on the way from the first to the last one, each farther than the one before."""
    x = points - points[0]
    way, length = x[-1], float(np.hypot(*x[-1]))
    along, aside = x @ way, np.abs(x[:, 0] * way[1] - x[:, 1] * way[0])
    return bool((aside <= ROUNDING * length**2).all() and (np.diff(along) >= 0).all())
