"""The lines of a domain: smooth pieces between corners, addressed by piece and arc length."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from bubblemesh.arrays import ROUNDING, Booleans, Floats, Integers, each_once
from bubblemesh.geometry.curves import FEWEST_CHORDS, Family, Lines
from bubblemesh.geometry.paths import CurveSection, OpenPath, Point, Ring, WholeCurve, family
from bubblemesh.geometry.tracks import CurveNodes, Tracks, along_curves, points_of, tangents_of
from bubblemesh.records import record

COLUMNS = ("kind", "index", "offset", "lengths", "start", "end", "label", "ring", "left", "right", "named", "turned")


class Chords(NamedTuple):
    """Straight lines that follow pieces of a boundary."""

    piece: Integers  # (m,)
    s: Floats  # (m,), arc length at which the chord starts
    step: Floats  # (m,), how much of the piece it follows
    start: Floats  # (m, 2)
    end: Floats  # (m, 2)


@record
class Boundary:
    """Smooth pieces, each between two corners or closed in itself.

    The rings have the domain on their left. Inner pieces have it on both sides: interfaces of two regions, and lines
    that are embedded in one.
    """

    families: tuple[Family, ...]  # the curves, by kind
    kind: Integers  # (p,), family of each piece's curve
    index: Integers  # (p,), of the curve in its family
    offset: Floats  # (p,), arc length on the curve at which the piece starts
    lengths: Floats  # (p,)
    start: Integers  # (p,), corner, or -1 for a closed curve without any
    end: Integers  # (p,), likewise
    label: Integers  # (p,), index into ``labels``
    ring: Integers  # (p,), outer rings first, from 0; inner pieces have a negative one, line k of a domain -1 - k
    left: Integers  # (p,), number of the region on that side, -1 outside the domain
    right: Integers  # (p,), likewise
    named: Booleans  # (p,), whether the label was given, not made up
    turned: Booleans  # (p,), whether the side that an inner piece belongs to is its right one
    corners: Floats  # (k, 2), fixed nodes; one that is not the end of a piece is an embedded point
    labels: tuple[str, ...]
    area_of_ring: tuple[int, ...] = ()  # number of the area that each ring bounds

    @classmethod
    def of(cls, rings: Sequence[Ring], area_of_ring: Sequence[int] | None = None) -> "Boundary":
        """Boundary of rings that have the domain on their left; vertices with equal coordinates are one corner.

        The outer rings of all areas come first, in the order of these; ``area_of_ring`` has the area of each ring, by
        default the same one.
        """
        owner = tuple(area_of_ring or [0] * len(rings))
        areas = 1 + max(owner)
        paths = [OpenPath.around(ring, default_label(number, areas)) for number, ring in enumerate(rings)]
        return replace(cls.empty()._extended(paths, range(len(paths)), right=-1), area_of_ring=owner)

    @classmethod
    def empty(cls) -> "Boundary":
        """Boundary without pieces."""
        none = np.zeros(0, np.int64)
        neither = np.zeros(0, bool)
        ends = none, none, none, none, none, none
        return cls((), none, none, np.zeros(0), np.zeros(0), *ends, neither, neither, np.zeros((0, 2)), ())

    def with_inner(self, paths: Sequence[OpenPath], points: Sequence[Point] = ()) -> "Boundary":
        """The boundary with inner pieces along paths, whose vertices may be corners already, and embedded points.

        The pieces of the first path have the ring number -1, those of the next one -2, and so on.
        """
        return self._extended(paths, range(-1, -len(paths) - 1, -1), right=0, points=points)

    def _extended(
        self, paths: Sequence[OpenPath], rings: Sequence[int], right: int, points: Sequence[Point] = ()
    ) -> "Boundary":
        """The boundary with pieces along paths, which have these ring numbers and the region ``right`` beside them."""
        kinds: dict[type, int] = {}
        sections: dict[int, CurveSection] = {}  # by row
        corners = {(float(x), float(y)): number for number, (x, y) in enumerate(self.corners)}
        labels = {name: number for number, name in enumerate(self.labels)}
        # Lists for each column: rows of a table would take several times as long, of files with very many sides.
        curves = list[WholeCurve]()
        start, end, label = (list[int]() for _ in range(3))
        named = list[bool]()
        for path in paths:
            ends = [corners.setdefault(vertex, len(corners)) for vertex in path.vertices] or [-1, -1]
            start += ends[:-1]
            end += ends[1:]
            label += [labels.setdefault(name or path.label, len(labels)) for _, name in path.sides]
            named += [path.sides_named if name else path.named for _, name in path.sides]
            found = [curve for curve, _ in path.sides]
            sections |= {row: curve for row, curve in enumerate(found, len(curves)) if isinstance(curve, CurveSection)}
            curves += [curve.curve if isinstance(curve, CurveSection) else curve for curve in found]
        known = len(self.families)
        kind = np.array([kinds.setdefault(type(curve), known + len(kinds)) for curve in curves], np.int64)
        for point in points:
            corners.setdefault(point, len(corners))
        rows = len(kind)
        counts = [len(path.sides) for path in paths]
        ring, turned = np.repeat(np.array(rings, np.int64), counts), np.repeat([path.turned for path in paths], counts)
        (index, left), (offset, lengths) = np.zeros((2, rows), np.int64), np.zeros((2, rows))
        families = self.families
        for number in kinds.values():
            mine = np.flatnonzero(kind == number)
            families = *families, family([curves[row] for row in mine])
            index[mine], lengths[mine] = np.arange(len(mine)), families[number].lengths
        beside = left, left + right, np.array(named, bool), turned.astype(bool)
        given = kind, index, offset, lengths, *_integers(start, end, label), ring, *beside
        columns: dict[str, Any] = dict(zip(COLUMNS, given, strict=True))
        for row, section in sections.items():
            columns["offset"][row], columns["lengths"][row] = section.offset, section.length
        both: dict[str, Any] = {name: np.concatenate([getattr(self, name), column]) for name, column in columns.items()}
        vertices = np.array(list(corners), float).reshape(-1, 2)
        return replace(self, **both, families=families, corners=vertices, labels=tuple(labels))

    def select(self, pieces: Integers) -> "Boundary":
        """The boundary with these pieces (k,) only; corners and labels stay."""
        columns: dict[str, Any] = {name: getattr(self, name)[pieces] for name in COLUMNS}
        return replace(self, **columns)

    @cached_property
    def inner(self) -> Booleans:
        """Mask (p,) of the pieces that have the domain on both sides."""
        return self.ring < 0

    def stations(self) -> tuple[Integers, Floats, Floats]:
        """Piece, arc length and length (m,) of the chords of a fine polygonal copy of all pieces."""
        return self._chords

    def chords(self) -> Chords:
        """Chords of the polygonal copy; those of a piece follow each other without a gap."""
        return self._chords_in_place

    @cached_property
    def _chords_in_place(self) -> Chords:
        """The chords, with the points between which they lie."""
        piece, s, step = self.stations()
        start = self.chord_starts(piece, s)
        last = np.flatnonzero(np.diff(piece, append=-1))
        end = np.roll(start, -1, axis=0)
        end[last] = start[np.append(0, last[:-1] + 1)]
        last = last[~self.closed[piece[last]]]
        end[last] = self.corners[self.end[piece[last]]]
        return Chords(piece, s, step, start, end)

    def chord_starts(self, piece: Integers, s: Floats) -> Floats:
        """Points (m, 2) at the places where chords start: exactly the corners at the starts of pieces."""
        points = self.points(piece, s)
        at_corner = (s == 0) & ~self.closed[piece]
        points[at_corner] = self.corners[self.start[piece[at_corner]]]
        return points

    def end_steps(self) -> tuple[Floats, Floats]:
        """Lengths (p,) of the first and of the last chord of each piece."""
        piece, _, step = self.stations()
        return step[np.diff(piece, prepend=-1) != 0], step[np.diff(piece, append=-1) != 0]

    def ring_corners(self) -> tuple[Integers, Integers]:
        """Corners (k,) of rings, and the ring (k,) of each; one at which rings touch comes once for each of them."""
        mine, rings = ~self.closed & ~self.inner, len(self.area_of_ring)
        corner, ring = np.divmod(each_once(self.start[mine] * rings + self.ring[mine]), rings)
        return corner, ring

    @cached_property
    def closed(self) -> Booleans:
        """Mask (p,) of the pieces that are closed curves without a corner."""
        return self.start < 0

    @cached_property
    def curved(self) -> Booleans:
        """Mask (p,) of the pieces that are not straight."""
        return ~np.array([isinstance(f, Lines) for f in self.families])[self.kind]

    @cached_property
    def approximated(self) -> Booleans:
        """Mask (p,) of the pieces that the polygonal copy follows nearly, but not exactly."""
        return ~np.array([f.exact for f in self.families])[self.kind]

    @cached_property
    def _chords(self) -> tuple[Integers, Floats, Floats]:
        """Pieces, arc lengths and steps (m,) of the chords of the polygonal copy, in order."""
        parts = []
        for k, f in enumerate(self.families):
            curve, s = f.stations()
            mine = np.flatnonzero(self.kind == k)
            uncut = (self.offset[mine] == 0) & (self.lengths[mine] == f.lengths[self.index[mine]])
            piece_of = np.full(len(f.lengths), -1)
            piece_of[self.index[mine[uncut]]] = mine[uncut]
            whole = piece_of[curve] >= 0
            parts.append((piece_of[curve[whole]], s[whole]))
            first = np.searchsorted(curve, np.arange(len(f.lengths) + 1))
            for piece in mine[~uncut].tolist():
                begin, end = first[self.index[piece]], first[self.index[piece] + 1]
                local = self._stations_within(piece, s[begin:end])
                parts.append((np.full(len(local), piece), local))
        return self.in_order(*(np.concatenate(column) for column in zip(*parts, strict=True)))

    def _stations_within(self, piece: int, s: Floats) -> Floats:
        """Arc lengths on a part of a curve where its chords begin; ``s`` are those of the whole curve."""
        length, offset, period = (float(column[piece]) for column in (self.lengths, self.offset, self.periods))
        local = np.mod(s - offset, period)
        if not self.approximated[piece]:
            return np.append(0.0, np.sort(local[(local > ROUNDING * length) & (local < (1 - ROUNDING) * length)]))
        # As dense as on the whole curve, but from the end on: the rest of a cut chord would be too short there.
        along = np.concatenate([s - period, s, s + period])
        begin, end = np.interp([offset, offset + length], along, np.arange(len(along)))
        chords = max(int(np.ceil((end - begin) * (1 - ROUNDING))), FEWEST_CHORDS)
        stations = np.interp(begin + np.arange(chords) / chords * (end - begin), np.arange(len(along)), along) - offset
        return np.append(0.0, stations[1:])

    def in_order(self, piece: Integers, s: Floats) -> tuple[Integers, Floats, Floats]:
        """Pieces, arc lengths and steps to the next one (m,) in order."""
        order = np.lexsort((s, piece))
        piece, s = piece[order], s[order]
        last = np.diff(piece, append=-1) != 0
        return piece, s, np.where(last, self.lengths[piece], np.roll(s, -1)) - s

    @cached_property
    def periods(self) -> Floats:
        """Length (p,) of each piece's whole curve, which a piece of a split closed curve may run past."""
        return np.concatenate([f.lengths for f in self.families])[self._row]

    @cached_property
    def _row(self) -> Integers:
        """Row (p,) of each piece's curve in the families, one after the other."""
        first = np.cumsum([0, *(len(f.lengths) for f in self.families)])
        return first[self.kind] + self.index

    def tracks(self, piece: Integers) -> Tracks:
        """The pieces (m,) under m nodes, for many evaluations."""
        groups = self._curve_nodes(piece)
        return Tracks(self.offset[piece], self.periods[piece], self.lengths[piece], self.closed[piece], groups)

    def points(self, piece: Integers, s: Floats) -> Floats:
        """Points (m, 2) on the pieces (m,) at arc length s (m,) from their starts."""
        return points_of(self._curve_nodes(piece), along_curves(self.offset[piece], self.periods[piece], s))

    def tangents(self, piece: Integers, s: Floats) -> Floats:
        """Unit tangents (m, 2); the domain is on their left."""
        return tangents_of(self._curve_nodes(piece), along_curves(self.offset[piece], self.periods[piece], s))

    def _curve_nodes(self, piece: Integers) -> tuple[CurveNodes, ...]:
        """Nodes on the pieces (m,), by the kinds of their curves."""
        return CurveNodes.all_of(self.families, self.kind[piece], self.index[piece])

    def foot(self, points: Floats, piece: Integers, s: Floats, steps: int, longest: Floats | float = np.inf) -> Floats:
        """Arc lengths (m,) of the feet of points (m, 2) on the pieces (m,), by Newton's method from s (m,) near them.

        Curvature is left out: the points are next to the curves. No step is longer than ``longest`` (m,).
        """
        tracks = self.tracks(piece)
        for _ in range(steps if len(s) else 0):
            here, tangents = tracks.places(s)
            ahead = np.einsum("ij,ij->i", points - here, tangents)
            s = tracks.wrapped(s + np.clip(ahead, -longest, longest))
        return s

    def wrapped(self, piece: Integers, s: Floats) -> Floats:
        """Arc length s (m,) brought back to the piece: modulo its length if it is closed, else to its ends."""
        length = self.lengths[piece]
        return np.where(self.closed[piece], np.mod(s, length), np.clip(s, 0, length))

    def edges(self, piece: Integers, s: Floats) -> tuple[Integers, Integers]:
        """Boundary edges (e, 2) and their pieces (e,), between corners and the nodes (m,) at arc lengths s on pieces.

        Edges are numbers of nodes, corners first, then the given nodes; the domain is on the left of each edge.
        """
        number = len(self.corners) + np.arange(len(piece))
        pieces = np.arange(len(self.kind))
        open_ = pieces[~self.closed]
        first = np.lexsort((s, piece))[np.searchsorted(np.sort(piece), pieces[self.closed])]
        chain_piece = np.concatenate([open_, piece, open_, piece[first]])
        chain_s = np.concatenate([np.full(len(open_), -1.0), s, np.full(len(open_) + len(first), np.inf)])
        chain = np.concatenate([self.start[open_], number, self.end[open_], number[first]])
        order = np.lexsort((chain_s, chain_piece))
        chain, chain_piece = chain[order], chain_piece[order]
        linked = chain_piece[:-1] == chain_piece[1:]
        return np.column_stack([chain[:-1], chain[1:]])[linked], chain_piece[:-1][linked]

    def arcs(self, edges: Integers, edge_piece: Integers, s: Floats) -> tuple[Floats, Floats]:
        """Arc lengths (e,) at which edges begin and end; across a closed piece's start, the end is past its length.

        ``s`` (m,) are those of the nodes after the corners; edges (e, 2) and their pieces (e,) are those of `edges`.
        """
        corners, length = len(self.corners), self.lengths[edge_piece]
        along = np.concatenate([np.zeros(corners), s])
        first, last = edges.T
        begin, end = along[first], np.where(last < corners, length, along[last])
        across_the_start = self.closed[edge_piece] & ((end < begin) | (first == last))
        return begin, np.where(across_the_start, end + length, end)

    def split(self, piece: Integers, s: Floats, points: Floats) -> "Boundary":
        """The boundary with corners at different ``points`` (m, 2) on the pieces (m,) at arc lengths ``s`` (m,).

        Existing corners there are kept; a closed piece becomes one that starts and ends at its first corner.
        """
        known = {corner: number for number, corner in enumerate(map(tuple, self.corners.tolist()))}
        numbers = [known.setdefault(point, len(known)) for point in map(tuple, points.tolist())]
        corners = np.array(list(known), float).reshape(-1, 2)
        return replace(self, corners=corners).cut(piece, s, np.array(numbers))

    def cut(self, piece: Integers, s: Floats, corner: Integers) -> "Boundary":
        """The boundary with its pieces (m,) cut at the arc lengths s (m,), where the corners (m,) stand.

        A closed piece is opened by its first cut. Pieces keep their order, and parts of one come in its direction.
        """
        order = np.lexsort((s, piece))
        piece, s, corner = piece[order], s[order], corner[order]
        first = np.flatnonzero(np.diff(piece, prepend=-1))
        first = first[self.closed[piece[first]]]
        opened = piece[first]
        columns = {name: getattr(self, name).copy() for name in COLUMNS}
        columns["start"][opened] = columns["end"][opened] = corner[first]
        columns["offset"][opened] += s[first]
        shift = np.zeros(len(self.kind))
        shift[opened] = s[first]
        s = np.delete(s - shift[piece], first)
        piece, corner = np.delete(piece, first), np.delete(corner, first)
        order = np.sort(np.concatenate([np.arange(len(self.kind)), piece]))
        columns = {name: column[order] for name, column in columns.items()}
        begins = np.diff(order, prepend=-1) == 0
        ends = np.append(begins[1:], False)
        begin = np.zeros(len(order))
        begin[begins] = s
        columns["lengths"][ends] = s
        columns["lengths"] -= begin
        columns["offset"] += begin
        columns["start"][begins] = columns["end"][ends] = corner
        return replace(self, **columns)


def _integers(*columns: list[int]) -> list[Integers]:
    """Arrays of lists, which may be empty."""
    return [np.array(column, np.int64) for column in columns]


def default_label(ring: int, areas: int) -> str:
    """Default label of a ring's sides: outer, outer-2, hole-1 and so on; ``areas`` is the number of outer rings."""
    return (f"outer-{ring + 1}" if ring else "outer") if ring < areas else f"hole-{ring - areas + 1}"
