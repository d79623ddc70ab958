"""Clips of drawings are applied: only what is visible through a clip stays.

Rings, and lines that form rings, are cut as the areas that they bound, nested within each other; other lines are cut as
lines. Features that are completely within their clips stay as they are.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from itertools import chain
from operator import add

import numpy as np
import shapely

from bubblemesh.arrays import ROUNDING, Booleans, Floats
from bubblemesh.errors import GeometryError, LimitError, prefixed
from bubblemesh.geometry import rings
from bubblemesh.geometry.arrangement.overlay import overlaid
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.nesting import nested, polygons_of, shapes_of
from bubblemesh.geometry.paths import Area, Line, OpenPath, Point, Ring, as_point
from bubblemesh.geometry.repair import THIN
from bubblemesh.geometry.rings import BezierTo, LineTo, Piece, SplineTo, end_of
from bubblemesh.messages import counted
from bubblemesh.readers.features import Clip, CompoundCurve, Feature, vertices_of
from bubblemesh.readers.rings.duplicates import without_copies, without_same_circles
from bubblemesh.readers.rings.joining import Joining, meeting, rings_of_curves
from bubblemesh.readers.rings.open_curves import on_rings

MOST_POINTS = 500_000  # of clips, counted for each area that they cut: more would take over a minute


@dataclass
class _Tally:
    """Counts of the effects of clips."""

    cut: int = 0  # areas and lines
    gone: int = 0
    crossing: int = 0  # areas whose rings cross, which are not clipped
    straight: int = 0  # areas that were cut along chords
    points: int = 0  # of clips

    @property
    def notes(self) -> list[str]:
        done = {"cut": self.cut, "left out": self.gone, "used whole, since their rings cross": self.crossing}
        done_by_clips = [f"{counted(number, 'shape')} {what}" for what, number in done.items() if number]
        done_by_clips += [f"curves of {self.straight} are straight lines now"] if self.straight else []
        return [f"by clips: {', '.join(done_by_clips)}"] if done_by_clips else []


def clipped(features: Sequence[Feature], joining: Joining) -> tuple[list[Feature], list[str]]:
    """The features after clipping, and notes; features cut by the same clips become one.

    LimitError if clips with very many points cut very many areas.
    """
    tally = _Tally()
    found = list(features)
    while depth := max((len(one.clips) for one in found), default=0):  # innermost first
        groups: dict[tuple[object, ...], list[Feature]] = {}
        for one in found:
            if len(one.clips) == depth:
                groups.setdefault((one.spare, *map(id, one.clips)), []).append(one)
        seen = {name: left for group in groups.values() for name, left in _seen(group, joining, tally).items()}
        kept = (seen.get(id(one)) if len(one.clips) == depth else one for one in found)
        found = [one for one in kept if one is not None]
    return found, tally.notes


def _seen(group: Sequence[Feature], joining: Joining, tally: _Tally) -> dict[int, Feature]:
    """Parts of features, all with the same clips, that are visible through the innermost clip, by the features' ids.

    All parts of cut features are under the id of the first one.
    """
    *others, clip = group[0].clips
    points = vertices_of(group)
    if len(points) == 0:
        return {id(one): replace(one, clips=tuple(others)) for one in group}
    # So far beyond a clip, points still count as within.
    rounding = ROUNDING * float(np.ptp(points, axis=0).max())
    window = _window(clip, points)
    shapely.prepare(window)
    inside = _inside(group, window.buffer(rounding))
    opens = [any(curve.start != curve.end for curve in one.curves) for one in group]
    together = all(held for held, is_open in zip(inside, opens, strict=True) if is_open)  # lines may form rings
    whole = [held and (together or not is_open) for held, is_open in zip(inside, opens, strict=True)]
    found = {id(one): replace(one, clips=tuple(others)) for one, free in zip(group, whole, strict=True) if free}
    rest = [one for one, free in zip(group, whole, strict=True) if not free]
    if rest and not (merged := _merged(rest, window, joining, tally)).is_empty:
        found[id(rest[0])] = merged
    return found


def _window(clip: Clip, points: Floats) -> shapely.MultiPolygon:
    """The part of the plane around points (n, 2) that is visible through a clip."""
    (x0, y0), (x1, y1) = points.min(axis=0), points.max(axis=0)
    margin = 1.0 + x1 - x0 + y1 - y0
    window: shapely.Geometry = shapely.box(x0 - margin, y0 - margin, x1 + margin, y1 + margin)
    shape = shapely.union_all(shapely.make_valid(shapes_of(clip.areas)))
    window = shapely.difference(window, shape) if clip.outside else shapely.intersection(window, shape)
    return shapely.MultiPolygon(polygons_of(window))


def _inside(features: Sequence[Feature], window: shapely.Geometry) -> list[bool]:
    """For each feature, whether it surely is within a window, with all areas that it may bound."""
    if shapely.get_num_interior_rings(shapely.get_parts(window)).any():  # rings may be around hidden parts
        return [False] * len(features)
    shapely.prepare(window)
    paths = [[*map(_path_around, one.rings), *map(_path, one.curves)] for one in features]
    owner = np.repeat(np.arange(len(features)), list(map(len, paths)))
    outside = np.zeros(len(features), np.int64)
    if len(owner):
        boundary = Boundary.empty().with_inner(tuple(chain.from_iterable(paths)))
        chords = boundary.chords()
        lines = shapely.linestrings(np.stack([chords.start, chords.end], axis=1))
        out: Booleans = ~shapely.covers(window, lines)
        outside += np.bincount(owner[-1 - boundary.ring[chords.piece[out]]], minlength=len(features))
    at = [np.array(one.points, float).reshape(-1, 2) for one in features]
    seen = [bool(shapely.covers(window, shapely.points(some)).all()) for some in at]
    return [held and not count for held, count in zip(seen, outside.tolist(), strict=True)]


def _path_around(ring: Ring) -> OpenPath:
    return OpenPath.around(ring, "")


def _path(curve: CompoundCurve) -> OpenPath:
    with prefixed(curve.name):
        return rings.open_path(curve.start, curve.pieces, "")


def _merged(features: Sequence[Feature], window: shapely.MultiPolygon, joining: Joining, tally: _Tally) -> Feature:
    """The visible parts of several features as one feature."""
    first = features[0]
    *others, clip = first.clips
    curves, slips = without_copies([curve for one in features for curve in one.curves])
    closing, lines = _parted(curves, joining)
    joined = rings_of_curves(closing, Joining(joining.reach))
    loops, copies = without_same_circles([*(ring for one in features for ring in one.rings), *joined.rings])
    areas = nested(list(map(Area, loops)))
    left = [ring for area in areas for seen in _cut_area(area, clip, window, tally) for ring in seen.rings]
    parts = [part for line in lines for part in _cut_line(line, window, tally)]
    points = [point for one in features for point in one.points if shapely.covers(window, shapely.Point(point))]
    tally.gone += sum(len(one.points) for one in features) - len(points)
    notes = dict.fromkeys((*(note for one in features for note in one.notes), *joined.notes))
    dropped = reduce(add, (one.slips for one in features), slips + joined.slips + copies)
    kept = replace(first, rings=tuple(left), curves=tuple(parts), points=tuple(points))
    return replace(kept, notes=tuple(notes), slips=dropped, clips=tuple(others))


def _parted(curves: Sequence[CompoundCurve], joining: Joining) -> tuple[list[CompoundCurve], list[CompoundCurve]]:
    """Curves that form rings, and the others."""
    closed = [curve for curve in curves if curve.start == curve.end]
    open_ = [curve for curve in curves if curve.start != curve.end]
    if not open_:
        return closed, []
    node = meeting(open_, joining.reach)[1].reshape(-1, 2)
    kept = on_rings(node)
    crowded = np.bincount(node[kept].ravel(), minlength=node.max() + 1) > 2
    if crowded.any():  # more than two ends meet: the rings are not unique
        return closed, open_
    pairs = list(zip(open_, kept.tolist(), strict=True))
    return closed + [curve for curve, keep in pairs if keep], [curve for curve, keep in pairs if not keep]


def _cut_area(area: Area, clip: Clip, window: shapely.MultiPolygon, tally: _Tally) -> list[Area]:
    """Visible parts of an area; sides along a clip have its label, if it has only one."""
    (shape,) = shapes_of([area])
    if not shape.is_valid:
        tally.crossing += 1
        return [area]
    if shapely.covers(window, shape):
        return [area]
    if shapely.disjoint(window, shape):
        tally.gone += 1
        return []
    tally.cut += 1
    tally.points += shapely.get_num_coordinates(window)
    if tally.points > MOST_POINTS:
        raise LimitError(f"clips with many points cut {tally.cut:,} shapes and more: simplify the clips")
    labels = {side.label for ring in area.rings for side in ring.sides}
    label = labels.pop() if len(labels) == 1 else None
    borders = [one.mapped(lambda ring: ring.labelled(label)) for one in clip.areas]
    try:
        found = overlaid("minus" if clip.outside else "intersection", [[area], borders])
    except GeometryError:  # curves nearly side by side
        found = _cut_by_chords(shape, window, label)
        tally.straight += not all(isinstance(side.curve, Line) for ring in area.rings for side in ring.sides)
    return [one.mapped(lambda ring: replace(ring, origin=area.outer.origin)) for one in found]


def _cut_by_chords(shape: shapely.Polygon, window: shapely.MultiPolygon, label: str | None) -> list[Area]:
    """The visible areas of a polygonal copy, without those that are thin by rounding."""
    thin = THIN * float(np.ptp(shapely.get_coordinates(shape), axis=0).max())
    polygons = [part for part in polygons_of(shapely.intersection(shape, window)) if part.area > thin * part.length]
    return [
        Area(*_area_rings([shapely.get_coordinates(loop) for loop in (part.exterior, *part.interiors)], label))
        for part in polygons
    ]


def _area_rings(loops: Sequence[Floats], label: str | None) -> tuple[Ring, tuple[Ring, ...]]:
    outer, *holes = (rings.polygon(loop.tolist(), label=label) for loop in loops)
    return outer, tuple(holes)


def _cut_line(curve: CompoundCurve, window: shapely.MultiPolygon, tally: _Tally) -> list[CompoundCurve]:
    """The visible parts of a line."""
    found = list[CompoundCurve]()
    here, whole = curve.start, True
    for piece in curve.pieces:
        for start, part in _cut_piece(here, piece, window):
            whole &= part is piece
            if found and found[-1].end == start:
                found[-1] = replace(found[-1], pieces=(*found[-1].pieces, part))
            else:
                found.append(CompoundCurve(start, (part,), curve.name))
        here = end_of(piece)
    tally.gone += not found
    tally.cut += bool(found) and not (whole and len(found[0].pieces) == len(curve.pieces))
    return found


def _cut_piece(start: Point, piece: Piece, window: shapely.MultiPolygon) -> list[tuple[Point, Piece]]:
    """The visible parts of a piece, with their starts."""
    path = rings.open_path(start, [piece], "")
    chords = Boundary.empty().with_inner((path,)).chords()
    line = shapely.LineString(np.vstack([chords.start, chords.end[-1:]]))
    if shapely.covers(window, line):
        return [(start, piece)]
    found = list[tuple[float, Floats]]()
    for part in shapely.get_parts(shapely.intersection(line, window)).tolist():
        if part.length > 0:
            run = shapely.get_coordinates(part)
            begin, end = shapely.line_locate_point(line, shapely.points(run[[0, -1]])).tolist()
            found.append((min(begin, end), run if begin < end else run[::-1]))
    return [_along(piece, run) for _, run in sorted(found, key=lambda one: one[0])]


def _along(piece: Piece, run: Floats) -> tuple[Point, Piece]:
    """The part of a piece along points (k, 2) of its polygonal copy, with its start."""
    start, end = as_point(run[0]), as_point(run[-1])
    if isinstance(piece, LineTo):
        return start, piece._replace(to=end)
    if isinstance(piece, BezierTo | SplineTo):
        return start, SplineTo(list(map(as_point, run[1:])), piece.label)
    center = np.array(piece.center)
    radius = np.hypot(*(np.array(piece.to) - center))
    ends = (center + (point - center) * (radius / np.hypot(*(point - center))) for point in run[[0, -1]])
    start, end = map(as_point, ends)
    return start, piece._replace(to=end)
