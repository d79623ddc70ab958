"""Ends of embedded lines that nearly meet another line or a ring, joined with it."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from math import dist
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Floats, Integers, components
from bubblemesh.errors import GeometryError, about
from bubblemesh.geometry.arrangement import TOUCHING
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.curves import shares_before
from bubblemesh.geometry.paths import Curve, InnerPoint, Line, OpenPath, Point, Ring, Side, as_point
from bubblemesh.geometry.similarity import Similarity
from bubblemesh.messages import counted, place

NEWTON_STEPS = 4  # to the foot of an end on a curve, from the nearest of its chords
NO_LINE = -2  # in place of the number of a line, where an end belongs to none; -1 is that of rings


class End(NamedTuple):
    """The first or the ``last`` point of a line, which may move by ``reach``."""

    line: int
    last: bool
    at: Point
    reach: float


class Foot(NamedTuple):
    """The place ``at``, after ``s`` of the length of a ``side`` of a ``line``, on which an end comes to lie."""

    line: int
    side: int
    s: float
    at: Point


def joined(lines: Sequence[OpenPath], reaches: Sequence[float], rings: Sequence[Ring]) -> list[OpenPath]:
    """The lines with ends moved to what they nearly meet: ends of other lines, vertices, or places on sides.

    An end moves by no more than the reach of its line, 0 for lines that stay; those that meet something already stay,
    too. Of a chain of ends, each near the next, those move that are near the place; the others meet what is moved then.
    A line on whose straight side an end lies gets a vertex there. The first line that is moved has a note.
    GeometryError if a line is shorter than its reach.
    """
    made, moved, waiting = list(lines), dict[End, Point](), _ends(lines, reaches)
    while waiting:  # each round leaves fewer of them
        made, placed, waiting = _joined_once(made, waiting, rings)
        moved |= placed
    return _noted(made, moved)


def _joined_once(
    lines: Sequence[OpenPath], ends: Sequence[End], rings: Sequence[Ring]
) -> tuple[list[OpenPath], dict[End, Point], list[End]]:
    """The lines with some of the ends moved, the places of these, and the ends that may still meet what was moved."""
    around = Surroundings(lines, rings)
    met = [around.feet(end, around.tolerance, [end.line]) for end in ends]
    feet = [foot._replace(at=end.at) for end, found in zip(ends, met, strict=True) for foot in found]
    free = [end for end, found in zip(ends, met, strict=True) if end.reach > 0 and not found]
    moved, waiting = dict[End, Point](), list[End]()
    for group in _groups(free):
        at, foot = around.target(group)
        near = [end for end in group if at is not None and dist(end.at, at) <= end.reach + around.tolerance]
        if at is None or not near:
            continue
        _require_long(lines, near)
        moved |= dict.fromkeys(near, at)
        waiting += [end for end in group if end not in moved]
        feet += [] if foot is None else [foot]
    stops = {*shared_vertices(lines, rings), *(foot.at for foot in feet)}
    made = [_divided(line, [foot for foot in feet if foot.line == number]) for number, line in enumerate(lines)]
    for end, at in sorted(moved.items()):
        made[end.line] = _ending(made[end.line], end.last, at, end.reach, stops)
    return made, moved, waiting


def joined_points(
    points: Sequence[InnerPoint], lines: Sequence[OpenPath], rings: Sequence[Ring]
) -> tuple[list[InnerPoint], tuple[str, ...]]:
    """The points, each moved onto the nearest vertex within its reach of a line or a ring, else side, and a note."""
    if not (lines or rings) or not any(point.reach for point in points):
        return list(points), ()
    around, found, ways = Surroundings(lines, rings), list[InnerPoint](), list[tuple[float, str]]()
    for point in points:
        at = around.target([End(NO_LINE, False, point.at, point.reach)])[0] if point.reach else None
        found.append(point if at is None else replace(point, at=at))
        if at is not None and at != point.at:
            ways.append((dist(point.at, at), f"{point.label!r} at {place(point.at)}"))
    if not ways:
        return found, ()
    way, which = max(ways)
    return found, (f"{counted(len(ways), 'point')} joined to lines and rings, the farthest by {way:.3g}: {which}",)


def shared_vertices(lines: Sequence[OpenPath], rings: Sequence[Ring]) -> set[Point]:
    """Vertices of lines that another line has as well, or a ring, or the line itself twice."""
    seen, shared = {as_point(point) for ring in rings for point in ring.outline}, set[Point]()
    for line in lines:
        for vertex in line.vertices:
            (shared if vertex in seen else seen).add(vertex)
    return shared


def _ends(lines: Sequence[OpenPath], reaches: Sequence[float]) -> list[End]:
    """Ends of the lines that are open."""
    return [
        End(number, last, line.vertices[-last], reaches[number])
        for number, line in enumerate(lines)
        if line.vertices and line.vertices[0] != line.vertices[-1]
        for last in (False, True)
    ]


def _groups(ends: Sequence[End]) -> list[list[End]]:
    """The ends, together with those that are nearer than the reach of one of both."""
    if not ends:
        return []
    points = shapely.points(np.array([end.at for end in ends]))
    pairs = shapely.STRtree(points).query(points, predicate="dwithin", distance=[end.reach for end in ends]).T
    number = components(pairs, len(ends))
    return [[ends[k] for k in np.flatnonzero(number == one).tolist()] for one in np.unique(number).tolist()]


def _require_long(lines: Sequence[OpenPath], group: Sequence[End]) -> None:
    """Check that no line has both of its ends in a group."""
    seen = set[int]()
    for end in group:
        line = lines[end.line]
        if end.line in seen:
            with about(line.key):
                raise GeometryError(
                    f"join is too much for the line {line.name} at {place(end.at)}, whose ends are no farther apart: "
                    "make it smaller, or leave out the line"
                )
        seen.add(end.line)


class Surroundings:
    """Lines and rings that ends of the lines may meet."""

    def __init__(self, lines: Sequence[OpenPath], rings: Sequence[Ring]) -> None:
        self.boundary = (Boundary.of(rings) if rings else Boundary.empty()).with_inner(lines)
        self.chords = self.boundary.chords()
        corners = np.concatenate([self.chords.start, self.chords.end])
        self.tolerance = TOUCHING * float(np.ptp(corners, axis=0).max())
        self._tree = shapely.STRtree(shapely.linestrings(np.stack([self.chords.start, self.chords.end], axis=1)))

    @cached_property
    def _line(self) -> Integers:
        """Number (p,) of the line of each piece, and -1 on rings."""
        return np.maximum(-1 - self.boundary.ring, -1)

    @cached_property
    def _side(self) -> Integers:
        """Number (p,) of each piece within its line or ring."""
        ring = self.boundary.ring
        first = np.flatnonzero(np.diff(ring, prepend=ring[0] - 1))
        return np.arange(len(ring)) - np.repeat(first, np.diff(first, append=len(ring)))

    @cached_property
    def _vertices(self) -> tuple[Floats, Integers]:
        """Points (v, 2) at which sides end or polylines turn, and the line (v,) of each."""
        piece, s, *_ = self.chords
        begins = ((s == 0) & ~self.boundary.closed[piece]) | ~self.boundary.approximated[piece]
        ends = (np.diff(piece, append=-1) != 0) & ~self.boundary.closed[piece]
        points = np.concatenate([self.chords.start[begins], self.chords.end[ends]])
        return points, self._line[np.concatenate([piece[begins], piece[ends]])]

    def target(self, group: Sequence[End]) -> tuple[Point | None, Foot | None]:
        """The place where a group of ends meets, and the foot on a side if it is none of the vertices.

        None if one end meets nothing.
        """
        own = [end.line for end in group]
        vertices = [found for end in group for found in self._vertices_near(end, own)]
        if vertices:
            return min(vertices)[1], None
        feet = [(dist(end.at, foot.at), foot) for end in group for foot in self.feet(end, end.reach, own)]
        if feet:
            foot = min(feet)[1]
            return foot.at, foot
        others = (one.at for one in group if any(end != one and dist(end.at, one.at) <= end.reach for end in group))
        return next(others, None), None

    def _vertices_near(self, end: End, without: Sequence[int]) -> list[tuple[float, Point]]:
        """Distances and places of vertices of others within the reach of an end."""
        points, line = self._vertices
        near = self._vertex_tree.query(shapely.Point(end.at), predicate="dwithin", distance=end.reach)
        found = map(as_point, points[near[~np.isin(line[near], without)]])
        return [(dist(end.at, at), at) for at in found]

    @cached_property
    def _vertex_tree(self) -> shapely.STRtree:
        return shapely.STRtree(shapely.points(self._vertices[0]))

    def feet(self, end: End, reach: float, without: Sequence[int]) -> list[Foot]:
        """The places within some reach of an end that are next to it on the sides of others."""
        near = self._tree.query(shapely.Point(end.at), predicate="dwithin", distance=reach)
        near = near[~np.isin(self._line[self.chords.piece[near]], without)]
        piece, at = self.chords.piece[near], np.broadcast_to(end.at, (len(near), 2))
        start, along = self.chords.start[near], self.chords.end[near] - self.chords.start[near]
        share = shares_before(at, start, start + along)
        s, places = self.chords.s[near] + share * self.chords.step[near], start + share[:, None] * along
        curved = self.boundary.approximated[piece]
        s[curved] = self.boundary.foot(at[curved], piece[curved], s[curved], NEWTON_STEPS)
        places[curved] = self.boundary.points(piece[curved], s[curved])
        columns = self._line[piece].tolist(), self._side[piece].tolist(), s.tolist(), map(as_point, places)
        return [Foot(*row) for row in zip(*columns, strict=True)]


def _divided(line: OpenPath, feet: Sequence[Foot]) -> OpenPath:
    """The line with vertices at feet on its straight sides; curved ones are cut there when lines are noded."""
    sides, vertices = list[Side](), list(line.vertices[:1])
    for number, side in enumerate(line.sides):
        own = sorted({(foot.s, foot.at) for foot in feet if foot.side == number})
        end = line.vertices[number + 1] if line.vertices else None
        if isinstance(side.curve, Line) and end is not None:
            for at in dict.fromkeys(at for _, at in own if at not in (side.curve.start, end)):
                sides.append(side._replace(curve=Line(vertices[-1], at)))
                vertices.append(at)
            side = side._replace(curve=Line(vertices[-1], end))
        sides.append(side)
        vertices += [] if end is None else [end]
    return replace(line, sides=tuple(sides), vertices=tuple(vertices))


def _ending(line: OpenPath, last: bool, at: Point, reach: float, stops: Collection[Point]) -> OpenPath:
    """The line with its first or last point moved to a place, next to which no vertex that is its own stays."""
    if not last:
        return _reversed(_ending(_reversed(line), True, at, reach, stops))
    sides, vertices = list(line.sides), list(line.vertices)
    while len(sides) > 1 and _is_spare(sides, vertices[-2], at, reach, stops):
        sides.pop()
        vertices.pop(-2)
    start, end = vertices[-2:]
    if start == at:
        with about(line.key):
            raise GeometryError(f"join is too much for the line {line.name} at {place(at)}: make it smaller")
    sides[-1] = sides[-1]._replace(curve=_led(sides[-1].curve, start, end, at))
    return replace(line, sides=tuple(sides), vertices=(*vertices[:-1], at), joined=True)


def _is_spare(sides: Sequence[Side], vertex: Point, at: Point, reach: float, stops: Collection[Point]) -> bool:
    """Whether a vertex before the last side, and with it this side, can be left out for an end at a place."""
    straight = isinstance(sides[-1].curve, Line) and isinstance(sides[-2].curve, Line)
    return vertex == at or (straight and vertex not in stops and dist(vertex, at) < reach)


def _led(curve: Curve, start: Point, end: Point, at: Point) -> Curve:
    """The curve turned and stretched about its start, so that it does not end at ``end`` but at a place."""
    if isinstance(curve, Line):
        return Line(start, at)
    fixed = complex(*start)
    factor = (complex(*at) - fixed) / (complex(*end) - fixed)
    return curve.moved(Similarity(factor, fixed - factor * fixed))


def _reversed(line: OpenPath) -> OpenPath:
    """The line from its end to its start."""
    sides = tuple(side._replace(curve=side.curve.reversed()) for side in reversed(line.sides))
    return replace(line, sides=sides, vertices=line.vertices[::-1])


def _noted(lines: Sequence[OpenPath], moved: Mapping[End, Point]) -> list[OpenPath]:
    """The lines, of which the first one that was moved has a note on all."""
    gaps = sorted((end.line, dist(end.at, at), end) for end, at in moved.items() if end.at != at)
    found = list(lines)
    if gaps:
        widest, where = max((gap, end) for _, gap, end in gaps)
        note = f"{counted(len(gaps), 'end')} of lines joined, the widest gap ({widest:.3g}) at {place(where.at)}"
        first = gaps[0][0]
        found[first] = replace(found[first], notes=(*found[first].notes, note))
    return found
