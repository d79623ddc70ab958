"""Curves of the entities of a DXF drawing: lines, arcs, polylines with bulges, splines, boundaries of fills."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from ezdxf.math import arc_angle_span_deg, bulge_center, ellipse_param_span

from bubblemesh.geometry import rings
from bubblemesh.geometry.paths import Point, Ring
from bubblemesh.geometry.rings import ArcTo, LineTo, Piece, SplineTo
from bubblemesh.readers.dxf_splines import b_spline, sampled_curve
from bubblemesh.readers.features import CompoundCurve, finite_points
from bubblemesh.readers.rings.joining import reversed_curve

FLAT_BULGE = 3e-8  # bulge that is zero within rounding
FULL_TURN = 1 - 1e-9  # in turns: arcs whose ends differ by rounding
CHAINED = 1e-6  # of the extent of a fill's boundary: gap between ends of edges that is due to rounding
FRAME = 16  # flag of a polyline's vertex that is not drawn, but controls a spline
TEXT_BOX = 8  # flag of a fill's boundary around a text

Curves = list[CompoundCurve | Ring]  # of one entity; none if it has no extent


def _given(curve: CompoundCurve | None) -> Curves:
    return [] if curve is None else [curve]


def _mirrored(entity: Any) -> float:
    """-1 if the entity is drawn as seen from below, which reverses x, else 1."""
    return -1.0 if entity.dxf.get("extrusion", (0, 0, 1))[2] < 0 else 1.0


def _line(entity: Any, name: str, label: str | None) -> Curves:
    start, end = finite_points([entity.dxf.start, entity.dxf.end], name)
    return [CompoundCurve(start, (LineTo(end, label),), name)] if start != end else []


def _arc(entity: Any, name: str, label: str | None) -> Curves:
    span = arc_angle_span_deg(entity.dxf.start_angle, entity.dxf.end_angle)  # 360 for 0 to 360, but 0 for equal angles
    if span == 0 or span / 360 > FULL_TURN:
        return _circle(entity, name, label)
    center = entity.ocs().to_wcs(entity.dxf.center)
    start, end, middle = finite_points([entity.start_point, entity.end_point, center], name)
    curve = CompoundCurve(start, (ArcTo(end, middle, _mirrored(entity) > 0, label),), name)
    return [curve] if start != middle else []


def _circle(entity: Any, name: str, label: str | None) -> Curves:
    center, (radius, _) = finite_points([entity.ocs().to_wcs(entity.dxf.center), (entity.dxf.radius, 0)], name)
    return [rings.circle(center, radius, label)] if radius > 0 else []


def _ellipse(entity: Any, name: str, label: str | None) -> Curves:
    begin = entity.dxf.start_param
    sweep = ellipse_param_span(entity.dxf.start_param, entity.dxf.end_param)
    center, (x, y) = finite_points([entity.dxf.center, entity.dxf.major_axis], name)
    long = float(np.hypot(x, y))
    if long * entity.dxf.ratio == 0:
        return []
    if sweep == 0 or sweep / (2 * np.pi) > FULL_TURN:
        return [rings.ellipse(center, (long, long * entity.dxf.ratio), float(np.degrees(np.arctan2(y, x))), label)]
    return _given(sampled_curve(entity.vertices, (begin, begin + sweep), name, label))


def _spline(entity: Any, name: str, label: str | None) -> Curves:
    if entity.closed and not entity.control_point_count() and entity.fit_point_count() > 2:
        first, *_, last = entity.fit_points
        entity.fit_points = [*entity.fit_points, first] if not np.allclose(first, last) else entity.fit_points
    return _given(b_spline(entity.construction_tool(), name, label))


def _polyline(entity: Any, name: str, label: str | None) -> Curves:
    turn = 1.0 if _is_in_space(entity) else _mirrored(entity)
    return _bulged(polyline_corners(entity), entity.is_closed, turn, name, label)


def _is_in_space(entity: Any) -> bool:
    """Whether the coordinates of a polyline are those of the world."""
    return entity.dxftype() == "POLYLINE" and bool(entity.is_3d_polyline)


def polyline_corners(entity: Any) -> list[tuple[float, float, float]]:
    """Corners of a polyline (x, y, bulge)."""
    if entity.dxftype() == "LWPOLYLINE":
        return [tuple(point) for point in entity.get_points("xyb")]
    vertices = [vertex for vertex in entity.vertices if not vertex.dxf.flags & FRAME]
    solid = _is_in_space(entity)
    return [(*vertex.dxf.location.vec2, 0.0 if solid else vertex.dxf.get("bulge", 0.0)) for vertex in vertices]


def _solid(entity: Any, name: str, label: str | None) -> Curves:
    corners = finite_points(list(entity.wcs_vertices()), name)
    return _bulged([(x, y, 0.0) for x, y in corners], True, 1.0, name, label)


def _fill(entity: Any, name: str, label: str | None) -> Curves:
    """Boundaries of a hatch, each as a loop if its edges are in order."""
    found: Curves = []
    for boundary in entity.paths:
        if boundary.path_type_flags & TEXT_BOX:
            continue
        if hasattr(boundary, "vertices"):
            found += _bulged([(*vertex, 0.0)[:3] for vertex in boundary.vertices], True, _mirrored(entity), name, label)
        else:
            edges = [curve for edge in boundary.edges for curve in _edge(edge, name, label)]
            found += _chained([_turned(curve, _mirrored(entity)) for curve in edges])
    return found


def _edge(edge: Any, name: str, label: str | None) -> list[CompoundCurve]:
    """The curve of one edge of a fill's boundary, in the direction of the boundary."""
    kind = type(edge).__name__
    if kind == "LineEdge":
        start, end = finite_points([edge.start, edge.end], name)
        return [CompoundCurve(start, (LineTo(end, label),), name)] if start != end else []
    if kind == "ArcEdge":
        start, end, center = finite_points([edge.real_start_point, edge.real_end_point, edge.center], name)
        if start == center:
            return []
        end = start if np.allclose(start, end, rtol=0, atol=1e-12 * edge.radius) else end
        return [CompoundCurve(start, (ArcTo(end, center, bool(edge.ccw), label),), name)]
    if kind == "EllipseEdge":
        tool = edge.construction_tool()
        begin = tool.start_param
        sweep = ellipse_param_span(tool.start_param, tool.end_param) or 2 * np.pi
        made = sampled_curve(tool.vertices, (begin, begin + sweep), name, label)
    else:
        made = b_spline(edge.construction_tool(), name, label)
    forward = kind != "EllipseEdge" or edge.ccw
    if made is None:
        return []
    return [made if forward else reversed_curve(made)]


def _turned(curve: CompoundCurve, turn: float) -> CompoundCurve:
    """The curve, with x reversed if ``turn`` is -1."""
    if turn > 0:
        return curve

    def mirror(point: Sequence[float]) -> Point:
        return -point[0], point[1]

    def mirrored(piece: Piece) -> Piece:
        if isinstance(piece, SplineTo):
            return piece._replace(through=[mirror(point) for point in piece.through])
        if isinstance(piece, ArcTo):
            return piece._replace(to=mirror(piece.to), center=mirror(piece.center), left=not piece.left)
        return piece._replace(to=mirror(piece.to))

    return CompoundCurve(mirror(curve.start), tuple(map(mirrored, curve.pieces)), curve.name)


def _chained(curves: list[CompoundCurve]) -> Curves:
    """The curves as one loop, if each begins where the one before it ends; else as they are."""
    if not curves:
        return []
    ends = np.array([point for curve in curves for point in (curve.start, curve.end)])
    tolerance = CHAINED * float(np.ptp(ends, axis=0).max())

    def near(a: Point, b: Point) -> bool:
        return abs(a[0] - b[0]) <= tolerance and abs(a[1] - b[1]) <= tolerance

    first = curves[0]
    if len(curves) > 1 and not any(near(first.end, point) for point in (curves[1].start, curves[1].end)):
        first = reversed_curve(first)
    pieces = list(first.pieces)
    end = first.end
    for curve in curves[1:]:
        run = curve if near(curve.start, end) else reversed_curve(curve)
        if not near(run.start, end):
            return list(curves)
        pieces += run.pieces
        end = run.end
    if not near(end, first.start):
        return list(curves)
    last = pieces[-1]
    pieces[-1] = (
        last._replace(through=[*last.through[:-1], first.start])
        if isinstance(last, SplineTo)
        else last._replace(to=first.start)
    )
    return [CompoundCurve(first.start, tuple(pieces), first.name)]


def _bulged(corners: Sequence[Sequence[float]], is_closed: bool, turn: float, name: str, label: str | None) -> Curves:
    """Polyline with arcs through corners (x, y, bulge); a bulge is the tangent of a quarter of the arc's angle."""
    points = finite_points([(turn * x, y) for x, y, _ in corners], name)
    bulges = [turn * bulge for _, _, bulge in corners]
    if is_closed and points:
        points, bulges = [*points, points[0]], [*bulges, 0.0]
    pieces: list[Piece] = []
    for (begin, end), bulge in zip(pairwise(points), bulges, strict=False):
        if begin != end and abs(bulge) < FLAT_BULGE:
            pieces.append(LineTo(end, label))
        elif begin != end:
            x, y = bulge_center(begin, end, bulge)
            pieces.append(ArcTo(end, (float(x), float(y)), bulge > 0, label))
    return [CompoundCurve(points[0], tuple(pieces), name)] if pieces else []


CURVES: dict[str, Callable[[Any, str, str | None], Curves]] = {
    "LINE": _line,
    "ARC": _arc,
    "CIRCLE": _circle,
    "ELLIPSE": _ellipse,
    "SPLINE": _spline,
    "LWPOLYLINE": _polyline,
    "POLYLINE": _polyline,
}
FILLS: dict[str, Callable[[Any, str, str | None], Curves]] = {
    "HATCH": _fill,
    "MPOLYGON": _fill,
    "SOLID": _solid,
    "TRACE": _solid,
}
