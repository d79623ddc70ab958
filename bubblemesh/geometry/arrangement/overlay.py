"""Union, difference and intersection of areas; curves stay exact.

All curves are split where they meet. The pieces with the result on one side only, which is tested by a point beside
each, are joined to rings with the result on their left.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.errors import about
from bubblemesh.geometry.arrangement import ROUNDINGS, TOUCHING
from bubblemesh.geometry.arrangement.bellies import bellies
from bubblemesh.geometry.arrangement.noding import noded
from bubblemesh.geometry.arrangement.pieces import probes, without_doubles
from bubblemesh.geometry.arrangement.regions import InnerParts
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.nesting import with_holes
from bubblemesh.geometry.paths import Arc, Area, Curve, CurveSection, Line, OpenPath, Point, Ring, Side, outlines
from bubblemesh.geometry.validity import simple_polygon
from bubblemesh.records import record

BESIDE_CORNER = 0.01  # of the shortest piece at a corner: distance from it at which pieces are sorted around it
JOINED = 1e-9  # of a curve's length: pieces nearer to each other belong together

# For masks (k, m) of the operands that contain points, the mask (m,) of the points in the result.
Rule = Literal["union", "minus", "intersection"]
RULES: Mapping[Rule, Callable[[Booleans], Booleans]] = {
    "union": lambda inside: np.logical_or.reduce(inside),
    "minus": lambda inside: inside[0] & ~np.logical_or.reduce(inside[1:]),
    "intersection": lambda inside: np.logical_and.reduce(inside),
}


class Run(NamedTuple):
    """A piece of the result, against its own direction if ``backward``."""

    piece: int
    backward: bool


def overlaid(rule: Rule, operands: Sequence[Sequence[Area]], size: float | None = None) -> list[Area]:
    """Areas of the operands' union, of the first one minus the others, or of their intersection; possibly none.

    An operand is the union of its areas. Sides keep their labels; a common side of several operands has the label of
    the first one. Tolerances are relative to a ``size``, by default that of all operands. GeometryError, with the
    place, if a ring crosses itself, or if curves are next to each other, but not the same.
    """
    areas = [area for operand in operands for area in operand]
    owner = np.repeat(np.arange(len(operands)), [len(operand) for operand in operands])
    rings = [ring for area in areas for ring in area.rings]
    copies = outlines(rings)
    for ring, copy in zip(rings, copies, strict=True):
        with about(ring.key):
            simple_polygon(copy, f"the ring ({ring.origin})" if ring.origin else "the ring")
    paths = tuple(OpenPath.around(ring, "") for ring in rings)
    before = Boundary.empty().with_inner(paths)
    size = size_of(np.vstack(copies), size)
    split = noded(before, size, 0, InnerParts(lines=paths))
    shapes, area_of_ring = _shapes(areas, split), np.repeat(np.arange(len(areas)), [len(area.rings) for area in areas])
    single = without_doubles(split, TOUCHING * size)

    def inside(points: Floats) -> Booleans:
        found = _inside(points, shapes)
        # What is between a chord and its curve is on the other side of the ring than in the polygon.
        point, piece, _ = bellies(split, points)
        np.logical_xor.at(found, (area_of_ring[-1 - split.ring[piece]], point), True)
        return np.stack([np.logical_or.reduce(found[owner == k]) for k in range(len(operands))])

    left, right = (RULES[rule](inside(points)) for points in probes(single))
    return areas_beside(rings, before, single, left, right)


def areas_beside(
    rings: Sequence[Ring], before: Boundary, split: Boundary, left: Booleans, right: Booleans
) -> list[Area]:
    """Areas on the ``left`` or ``right`` of the pieces (p,) of rings that were split, with the curves of the rings.

    ``before`` has the rings' sides as they were. The first ring has the notes on all.
    """
    found = Assembly(split, before, [side.curve for ring in rings for side in ring.sides]).areas(left, right)
    if any(ring.given is not None for ring in rings):
        found = [area.mapped(lambda ring: replace(ring, given=ring.outline)) for area in found]
    notes = tuple(dict.fromkeys(note for ring in rings for note in ring.notes))
    return [replace(area, outer=replace(area.outer, notes=() if k else notes)) for k, area in enumerate(found)]


def size_of(points: Floats, size: float | None = None) -> float:
    """Size to which tolerances are relative, by default that of all points (m, 2); larger if rounding requires it."""
    rounding = ROUNDINGS * float(np.spacing(np.abs(points).max()))
    return max(float(np.ptp(points, axis=0).max()) if size is None else size, rounding / TOUCHING)


def _shapes(areas: Sequence[Area], split: Boundary) -> list[shapely.Polygon]:
    """Polygonal copies of areas with chords of the split curves, so that common sides are the same in each."""
    chords = split.chords()
    order = np.argsort(-split.ring[chords.piece], kind="stable")
    counts = np.bincount(-1 - split.ring[chords.piece])
    outlines = iter(np.split(chords.start[order], np.cumsum(counts)[:-1]))
    return [shapely.Polygon(next(outlines), [next(outlines) for _ in area.holes]) for area in areas]


def _inside(points: Floats, shapes: Sequence[shapely.Polygon]) -> Booleans:
    """Mask (a, m) of the points (m, 2) that are within each of the polygons."""
    inside = np.zeros((len(shapes), len(points)), bool)
    shape, point = shapely.STRtree(shapely.points(points)).query(np.array(shapes, dtype=object), predicate="contains")
    inside[shape, point] = True
    return inside


def _loops(boundary: Boundary, runs: Sequence[Run]) -> list[list[Run]]:
    """Closed walks around the parts of the result, from each run to the next one that bounds the same part."""
    closed = [[run] for run in runs if boundary.closed[run.piece]]
    open_ = [run for run in runs if not boundary.closed[run.piece]]
    if not open_:
        return closed
    begin, end = np.array([_ends(boundary, run) for run in open_]).T
    piece, backward = np.array(open_).T
    at_start, at_end = directions(boundary, piece)
    ahead, behind = np.where(backward, at_end, at_start), np.where(backward, at_start, at_end)
    leaving: dict[int, list[int]] = {}
    for number, corner in enumerate(begin.tolist()):
        leaving.setdefault(corner, []).append(number)
    used = np.zeros(len(open_), bool)
    loops = []
    for first in range(len(open_)):
        loop = []
        number = first
        while not used[number]:
            used[number] = True
            loop.append(open_[number])
            # The part is on the left: the next run is the first one clockwise from the direction of this one.
            after = leaving[int(end[number])]
            number = min(after, key=lambda k: (behind[number] - ahead[k]) % (2 * np.pi)) if len(after) > 1 else after[0]
        if loop:
            loops.append(loop)
    return sorted(closed + loops, key=lambda loop: min(run.piece for run in loop))


def _ends(boundary: Boundary, run: Run) -> tuple[int, int]:
    start, end = int(boundary.start[run.piece]), int(boundary.end[run.piece])
    return (end, start) if run.backward else (start, end)


def directions(boundary: Boundary, pieces: Integers) -> tuple[Floats, Floats]:
    """Angles (m,) in which open pieces (m,) are seen from the corners where they start, and where they end.

    Angles are those of places a little away, equally far on all pieces at a corner: curves may leave it side by side.
    """
    lengths = boundary.lengths[pieces]
    corners = boundary.start[pieces], boundary.end[pieces]
    shortest = np.full(len(boundary.corners), np.inf)
    for corner in corners:
        np.minimum.at(shortest, corner, lengths)
    away = [BESIDE_CORNER * shortest[corner] for corner in corners]
    seen = [boundary.points(pieces, s) for s in (away[0], lengths - away[1])]
    x, y = np.moveaxis(np.stack(seen) - boundary.corners[np.stack(corners)], -1, 0)
    at_start, at_end = np.arctan2(y, x)
    return at_start, at_end


def _simple(boundary: Boundary, loops: Sequence[list[Run]]) -> list[list[Run]]:
    """Walks that pass no corner twice: a part that touches itself gets a hole that touches its rim."""
    simple = []
    for loop in loops:
        walk: list[Run] = []
        position: dict[int, int] = {}  # of corners at which runs of the walk begin
        for run in loop:
            begin, end = _ends(boundary, run)
            position[begin] = len(walk)
            walk.append(run)
            if end in position:
                cut = position[end]
                simple.append(walk[cut:])
                for gone in walk[cut:]:
                    position.pop(_ends(boundary, gone)[0], None)
                del walk[cut:]
    return simple


@record
class Assembly:
    """Rings of pieces, with the boundary before they were split and the curve of each of its pieces."""

    split: Boundary
    before: Boundary
    curves: Sequence[Curve]

    def areas(self, left: Booleans, right: Booleans) -> list[Area]:
        """Areas on the ``left`` or ``right`` of the pieces (p,) that were split."""
        runs = [Run(int(piece), bool(right[piece])) for piece in np.flatnonzero(left != right)]
        found = [self.ring(loop) for loop in _simple(self.split, _loops(self.split, runs))]
        turns = [shapely.is_ccw(shapely.linearrings(points)) for points in outlines(found)]
        outer = [Area(ring) for ring, turn in zip(found, turns, strict=True) if turn]
        return with_holes(outer, [ring for ring, turn in zip(found, turns, strict=True) if not turn])

    @cached_property
    def _origin(self) -> Integers:
        """Piece (p,) of the boundary before it was split that each piece is a part of."""
        of_curve = {key: piece for piece, key in enumerate(zip(*self._keys(self.before), strict=True))}
        return np.array([of_curve[key] for key in zip(*self._keys(self.split), strict=True)], np.int64)

    @staticmethod
    def _keys(boundary: Boundary) -> tuple[list[int], list[int]]:
        return boundary.kind.tolist(), boundary.index.tolist()

    def ring(self, loop: Sequence[Run]) -> Ring:
        """Ring of a walk; consecutive runs on one curve are merged to one side."""
        count = len(loop)
        breaks = [k for k in range(count) if not self._continued(loop[k - 1], loop[k])]
        if not breaks:
            return Ring((self._side(loop),), ())
        groups = [[loop[k % count] for k in range(a, b)] for a, b in pairwise([*breaks, breaks[0] + count])]
        vertices = tuple(self._corner(_ends(self.split, group[0])[0]) for group in groups)
        return Ring(tuple(self._side(group) for group in groups), vertices)

    def _continued(self, run: Run, other: Run) -> bool:
        """Whether another run continues a run on the same curve, at a place without an original vertex."""
        first, second = (other, run) if run.backward else (run, other)
        origin = self._origin[run.piece]
        if run.backward != other.backward or origin != self._origin[other.piece]:
            return False
        gap = self.split.offset[second.piece] - self.split.offset[first.piece] - self.split.lengths[first.piece]
        total = self.before.lengths[origin]
        if self.before.closed[origin]:
            gap = (gap + total / 2) % total - total / 2
        return bool(abs(gap) <= JOINED * total)

    def _side(self, runs: Sequence[Run]) -> Side:
        """Side along runs that are one part of a curve."""
        split, run = self.split, runs[0]
        origin = self._origin[run.piece]
        curve, label = self.curves[origin], split.labels[split.label[run.piece]] or None
        length = float(sum(split.lengths[one.piece] for one in runs))
        if isinstance(curve, Line):
            begin, end = _ends(split, run)[0], _ends(split, runs[-1])[1]
            return Side(Line(self._corner(begin), self._corner(end)), label)
        if length < (1 - JOINED) * self.before.lengths[origin]:
            offset = float(split.offset[(runs[-1] if run.backward else run).piece])
            curve = _part(curve, offset, length, float(self.before.lengths[origin]))
        return Side(curve.reversed() if run.backward else curve, label)

    def _corner(self, number: int) -> Point:
        x, y = self.split.corners[number].tolist()
        return x, y


def _part(curve: Curve, offset: float, length: float, whole: float) -> Curve:
    """The part of a curve, from ``offset`` on and ``length`` long; ``whole`` is the length of the curve."""
    if isinstance(curve, CurveSection):
        return curve._replace(offset=offset, length=length)
    if isinstance(curve, Arc):
        turn = curve.sweep / whole
        return curve._replace(angle=curve.angle + turn * offset, sweep=turn * length)
    return CurveSection(curve, offset, length, whole)
