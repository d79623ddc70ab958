"""Curves of the shapes of an SVG drawing, one for each subpath; y is reversed to point up."""

from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
import svgelements

from bubblemesh.arrays import Floats
from bubblemesh.geometry.beziers import Beziers
from bubblemesh.geometry.paths import Point, as_point
from bubblemesh.geometry.rings import ArcTo, BezierTo, LineTo, Piece, SplineTo, end_of
from bubblemesh.readers.features import CompoundCurve, finite_points
from bubblemesh.readers.sampling import Parametric, splines
from bubblemesh.readers.svg.source import Element

ROUND = 1e-9  # relative difference of an arc's radii that counts as rounding
PIXELS = 96  # in an inch
SHAPES = {
    "path": svgelements.Path,
    "rect": svgelements.Rect,
    "circle": svgelements.Circle,
    "ellipse": svgelements.Ellipse,
    "line": svgelements.SimpleLine,
    "polyline": svgelements.Polyline,
    "polygon": svgelements.Polygon,
}

Size = tuple[float, float]  # width and height of a drawing, that lengths in percent are of


def curves_of(element: Element, transform: str, size: Size, name: str, label: str | None) -> list[CompoundCurve]:
    """The curves of a shape's subpaths, in the units of the drawing; messages call them ``name``."""
    path = path_of(element, transform, size)
    subpaths = [_without_flat_arcs(subpath.segments(transformed=False)) for subpath in path.as_subpaths()]
    bent = [segment for segments in subpaths for segment in segments if _is_bent(segment)]
    found = iter(_bent(bent, name))
    curves = []
    for segments in subpaths:
        pieces, start = _pieces(segments, found, name)
        if pieces:
            pieces[-1] = _ending(pieces[-1], start)
            curves.append(CompoundCurve(start, tuple(piece._replace(label=label) for piece in pieces), name))
    return curves


def path_of(element: Element, transform: str | svgelements.Matrix, size: Size) -> Any:
    """The path of a shape under a transform; its arcs have the axes of their ellipses as radii."""
    sizes = {"width": "0", "height": "0"} if element.tag == "rect" else {}
    given = {key: value for key, value in element.attributes.items() if key != "style" and value != "auto"}
    matrix = _matrix(transform) if isinstance(transform, str) else transform
    values = {**sizes, **given, "transform": matrix, "attributes": element.attributes}
    if element.tag == "path":
        shape = svgelements.Path(values, pathd_loaded=True)
        shape.parse(element.attributes.get("d", ""))
    else:
        shape = SHAPES[element.tag](values)
    shape.render(ppi=PIXELS, width=size[0], height=size[1])
    path = svgelements.Path(shape).reify()
    for segment in path:
        if isinstance(segment, svgelements.Arc):
            _find_axes(segment)
    return path


@lru_cache(1000)
def _matrix(transform: str) -> svgelements.Matrix:
    """The matrix of a transform, which many shapes may share: change only a copy."""
    return svgelements.Matrix(transform)


def _find_axes(arc: Any) -> None:
    """Give an arc the semi-axes of its ellipse as radii: after a skew these are two conjugate radii only.

    The points are c + u cos t + v sin t. By a singular value decomposition, (u, v) = U S V^T: the columns of U S are
    the semi-axes, and V rotates the parameter, so that the sweep of the arc is the same.
    """
    radii = np.array([[p.x - arc.center.x, p.y - arc.center.y] for p in (arc.prx, arc.pry)]).T
    lengths = np.hypot(*radii)
    if not np.isfinite(radii).all() or abs(radii[:, 0] @ radii[:, 1]) <= ROUND * lengths.prod():
        return
    left, axes, _ = np.linalg.svd(radii)
    arc.prx, arc.pry = (arc.center + svgelements.Point(*axis) for axis in (left * axes).T.tolist())


def _without_flat_arcs(segments: Sequence[Any]) -> list[Any]:
    """Segments with lines in place of arcs without a radius, and no arcs from a place to itself, as SVG prescribes."""
    found = []
    for segment in segments:
        if isinstance(segment, svgelements.Arc):
            if not segment.rx or not segment.ry:
                segment = svgelements.Line(segment.start, segment.end)
            elif not segment.sweep:
                continue
        found.append(segment)
    return found


def _bent(segments: Sequence[Any], name: str) -> Iterator[list[Piece]]:
    """Pieces of each Bézier curve or part of an ellipse: exact ones where possible, else splines."""
    beziers = [k for k, segment in enumerate(segments) if not isinstance(segment, svgelements.Arc)]
    points = finite_points([_up(point) for k in beziers for point in _controls(segments[k])], name)
    start, first, second, end = (points[n::4] for n in range(4))
    regular = Beziers(*(np.array(some, float).reshape(-1, 2) for some in (start, first, second, end))).regular
    made = map(BezierTo, end, first, second)
    exact = {k: piece for k, piece, can_be in zip(beziers, made, regular.tolist(), strict=True) if can_be}
    sampled = iter(splines([_parametric(one, name) for k, one in enumerate(segments) if k not in exact]))
    for k in range(len(segments)):
        yield [exact[k]] if k in exact else [SplineTo(list(map(as_point, knots[1:]))) for knots in next(sampled)]


def _controls(segment: Any) -> list[Any]:
    """The four control points of a Bézier curve; those of a quadratic one, which has three, are computed."""
    if isinstance(segment, svgelements.CubicBezier):
        return [segment.start, segment.control1, segment.control2, segment.end]
    start, control, end = segment.start, segment.control, segment.end
    return [start, start + (control - start) * (2 / 3), end + (control - end) * (2 / 3), end]


def _pieces(segments: list[Any], bent: Iterator[list[Piece]], name: str) -> tuple[list[Piece], Point]:
    """Pieces of a subpath, and its start; for segments that are neither straight nor circular, the next of ``bent``."""
    pieces: list[Piece] = []
    start = here = (0.0, 0.0)
    drawn = [segment for segment in segments if segment.end is not None]
    for segment, end in zip(drawn, finite_points([_up(one.end) for one in drawn], name), strict=True):
        if isinstance(segment, svgelements.Move):
            start = end
        elif _same(end, here) and isinstance(segment, svgelements.Line | svgelements.Close):
            continue
        else:
            pieces += next(bent) if _is_bent(segment) else _plain(segment, end, name)
        here = end
    return pieces, start


def _is_bent(segment: Any) -> bool:
    """Whether a segment is neither straight nor part of a circle."""
    straight = isinstance(segment, svgelements.Move | svgelements.Line | svgelements.Close)
    return segment.end is not None and not straight and not _is_round(segment)


def _is_round(segment: Any) -> bool:
    return isinstance(segment, svgelements.Arc) and abs(segment.rx - segment.ry) <= ROUND * segment.rx


def _plain(segment: Any, end: Point, name: str) -> list[Piece]:
    """Pieces of a segment that is a straight line or part of a circle."""
    if isinstance(segment, svgelements.Line | svgelements.Close):
        return [LineTo(end)]
    (center,) = finite_points([_up(segment.center)], name)
    # A sweep is clockwise as seen on a screen, whose y points down, and stays so as seen after y is reversed.
    # A full turn would have the same point at both ends.
    middle = [] if abs(segment.sweep) < 1.9 * np.pi else [_up(segment.point(0.5))]
    stops = [*finite_points(middle, name), end]
    return [ArcTo(stop, center, segment.sweep < 0) for stop in stops]


def _parametric(segment: Any, name: str) -> Parametric:
    """Points of a segment as a function of its parameter."""

    def points(t: Floats) -> Floats:
        x, y = segment.npoint(t).T
        return np.array(finite_points(np.column_stack([x, 0.0 - y]), name))  # no negative zero

    return points


def _ending(piece: Piece, start: Point) -> Piece:
    """The last piece, with its end exactly at the start if they differ by rounding."""
    if not _same(end_of(piece), start):
        return piece
    return (
        piece._replace(through=[*piece.through[:-1], start])
        if isinstance(piece, SplineTo)
        else piece._replace(to=start)
    )


def _same(a: Point, b: Point) -> bool:
    return max(abs(a[0] - b[0]), abs(a[1] - b[1])) <= ROUND * max(1.0, abs(a[0]), abs(a[1]))


def _up(point: Any) -> Point:
    return float(point.x), 0.0 - float(point.y)  # no negative zero
