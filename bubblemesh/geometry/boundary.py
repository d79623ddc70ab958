"""The lines of a domain: smooth pieces between corners, addressed by piece and arc length."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.curves import Family
from bubblemesh.geometry.rings import Curve, Ring, Strand, family

__all__ = ["Boundary", "Polyline"]

COLUMNS = ("kind", "index", "offset", "lengths", "start", "end", "label", "ring", "left", "right")
CONTACT_GRADING = 0.8 ** np.arange(1, 25) * 0.999  # from four steps down to where the curves are a tolerance apart


@dataclass(frozen=True)
class Polyline:
    """Fine polygonal copy of the boundary.

    Attributes
    ----------
    points : (m, 2)
    piece, s : (m,)
        Piece and arc length of each point; the chord from point i to its successor follows that piece.
    step : (m,)
        Arc length of that chord.
    successor : (m,)
        Index of the next point of the same ring.
    ring : (m,)
    """

    points: Floats
    piece: Integers
    s: Floats
    step: Floats
    successor: Integers
    ring: Integers


@dataclass(frozen=True)
class Boundary:
    """Smooth pieces, each between two corners or closed in itself.

    The rings have the domain on their left. Inner pieces have it on both sides: interfaces of two regions, and lines
    that are embedded in one.

    Attributes
    ----------
    families : tuple of Family
        The curves, by kind.
    kind, index : (p,)
        Family of each piece's curve, and the curve's index in it.
    offset, lengths : (p,)
        Arc length on the curve at which the piece starts, and the piece's length.
    start, end : (p,)
        Corners at its ends, or -1 for a closed curve without any.
    label, ring : (p,)
        Index into ``labels``, and number of the ring (0 is the outer one; inner pieces have a negative one).
    left, right : (p,)
        Number of the region on either side, -1 outside the domain.
    corners : (k, 2)
        Fixed nodes; one that is no piece's end is an embedded point.
    """

    families: tuple[Family, ...]
    kind: Integers
    index: Integers
    offset: Floats
    lengths: Floats
    start: Integers
    end: Integers
    label: Integers
    ring: Integers
    left: Integers
    right: Integers
    corners: Floats
    labels: tuple[str, ...]

    @classmethod
    def of(cls, rings: Sequence[Ring]) -> "Boundary":
        """Boundary of rings that have the domain on their left; vertices with equal coordinates are one corner."""
        members: dict[type, list[Curve]] = {}
        corners: dict[tuple[float, float], int] = {}
        labels: dict[str, int] = {}
        rows = []
        for number, ring in enumerate(rings):
            ends = [corners.setdefault(vertex, len(corners)) for vertex in ring.vertices] or [-1]
            for k, side in enumerate(ring.sides):
                group = members.setdefault(type(side.curve), [])
                label = labels.setdefault(side.label or default_label(number), len(labels))
                kind = list(members).index(type(side.curve))
                rows.append((kind, len(group), ends[k], ends[(k + 1) % len(ends)], label, number))
                group.append(side.curve)
        families = tuple(family(group) for group in members.values())
        kind, index, start, end, label, ring_number = np.array(rows).T
        lengths = np.zeros(len(kind))
        for k, f in enumerate(families):
            lengths[kind == k] = f.lengths
        vertices = np.array(list(corners), float).reshape(-1, 2)
        offset = np.zeros(len(kind))
        sides = np.zeros(len(kind), np.int64), np.full(len(kind), -1)
        return cls(
            families, kind, index, offset, lengths, start, end, label, ring_number, *sides, vertices, tuple(labels)
        )

    def joined_by(self, strands: Sequence[Strand], points: Sequence[tuple[float, float]] = ()) -> "Boundary":
        """These pieces, and inner ones along strands, whose vertices may be corners already; and embedded points.

        The pieces of the first strand have the ring number -1, those of the next one -2, and so on.
        """
        members: dict[type, list[Curve]] = {}
        corners = {(float(x), float(y)): number for number, (x, y) in enumerate(self.corners)}
        labels = {name: number for number, name in enumerate(self.labels)}
        rows = []
        for number, strand in enumerate(strands, start=1):
            ends = [corners.setdefault(vertex, len(corners)) for vertex in strand.vertices]
            for k, side in enumerate(strand.sides):
                group = members.setdefault(type(side.curve), [])
                name = labels.setdefault(side.label or strand.label, len(labels))
                family_number = len(self.families) + list(members).index(type(side.curve))
                first, last = (ends[k], ends[k + 1]) if ends else (-1, -1)
                rows.append((family_number, len(group), first, last, name, -number))
                group.append(side.curve)
        for point in points:
            corners.setdefault(point, len(corners))
        added = tuple(family(group) for group in members.values())
        kind, index, start, end, label, ring = np.array(rows, np.int64).reshape(-1, 6).T
        lengths = np.zeros(len(rows))
        for k, f in enumerate(added, start=len(self.families)):
            lengths[kind == k] = f.lengths
        new = {
            "kind": kind,
            "index": index,
            "offset": np.zeros(len(rows)),
            "lengths": lengths,
            "start": start,
            "end": end,
            "label": label,
            "ring": ring,
            "left": np.zeros(len(rows), np.int64),
            "right": np.zeros(len(rows), np.int64),
        }
        columns = {name: np.concatenate([getattr(self, name), column]) for name, column in new.items()}
        vertices = np.array(list(corners), float).reshape(-1, 2)
        return replace(self, **columns, families=self.families + added, corners=vertices, labels=tuple(labels))

    def kept(self, pieces: Integers) -> "Boundary":
        """The boundary with these pieces (k,) only; corners and labels stay."""
        return replace(self, **{name: getattr(self, name)[pieces] for name in COLUMNS})

    @cached_property
    def inner(self) -> Booleans:
        """Which pieces (p,) have the domain on both sides."""
        return self.ring < 0

    def panels(self) -> tuple[Integers, Floats, Floats]:
        """Piece, arc length and length (m,) of the chords of a fine polygonal copy of all pieces."""
        piece = np.repeat(np.arange(len(self.kind)), self._chords)
        first = np.cumsum(self._chords) - self._chords
        step = (self.lengths / self._chords)[piece]
        return piece, (np.arange(len(piece)) - first[piece]) * step, step

    @cached_property
    def closed(self) -> Booleans:
        """Which pieces (p,) are closed curves without a corner."""
        return self.start < 0

    @cached_property
    def curved(self) -> Booleans:
        """Which pieces (p,) are not straight."""
        return self._chords > 1

    @cached_property
    def _chords(self) -> Integers:
        """Number (p,) of chords of the fine polygonal copy."""
        chords = np.zeros(len(self.kind), int)
        for k, f in enumerate(self.families):
            mine = self.kind == k
            share = self.lengths[mine] / f.lengths[self.index[mine]]
            whole = f.pieces[self.index[mine]]
            chords[mine] = np.where(whole > 1, np.maximum(np.ceil(whole * share), 8), 1)
        return chords

    @cached_property
    def _period(self) -> Floats:
        """Length (p,) of each piece's whole curve, which a piece of a split closed curve may run past."""
        return np.concatenate([f.lengths for f in self.families])[self._row]

    @cached_property
    def _row(self) -> Integers:
        """Row (p,) of each piece's curve in the families, one after the other."""
        first = np.cumsum([0, *(len(f.lengths) for f in self.families)])
        return first[self.kind] + self.index

    def points(self, piece: Integers, s: Floats) -> Floats:
        """Points (m, 2) on the pieces (m,) at arc length s (m,) from their starts."""
        return self._evaluated("points", piece, s)

    def tangents(self, piece: Integers, s: Floats) -> Floats:
        """Unit tangents (m, 2); the domain is on their left."""
        return self._evaluated("tangents", piece, s)

    def _evaluated(self, what: str, piece: Integers, s: Floats) -> Floats:
        along = self.offset[piece] + s
        along = np.where(along > self._period[piece], along - self._period[piece], along)
        if len(self.families) == 1:
            return getattr(self.families[0], what)(self.index[piece], along)
        result = np.empty((len(piece), 2))
        for k, f in enumerate(self.families):
            mine = self.kind[piece] == k
            if mine.any():
                result[mine] = getattr(f, what)(self.index[piece[mine]], along[mine])
        return result

    def wrapped(self, piece: Integers, s: Floats) -> Floats:
        """Arc length s (m,) brought back to the piece: modulo its length if it is closed, else to its ends."""
        length = self.lengths[piece]
        return np.where(self.closed[piece], np.mod(s, length), np.clip(s, 0, length))

    def polyline(self) -> Polyline:
        """The rings as chords, about 256 for a full turn, one for a straight piece."""
        piece, s, _ = self.panels()
        more_piece, more_s = self._graded_to_contacts()
        piece, s = np.concatenate([piece, more_piece]), np.concatenate([s, more_s])
        mine = ~self.inner[piece]
        piece, s = piece[mine], s[mine]
        order = np.lexsort((s, piece))
        piece, s = piece[order], s[order]
        last = np.diff(piece, append=-1) != 0
        step = np.where(last, self.lengths[piece], np.roll(s, -1)) - s
        points = self.points(piece, s)
        at_corner = (s == 0) & ~self.closed[piece]
        points[at_corner] = self.corners[self.start[piece[at_corner]]]
        ring = self.ring[piece]
        successor = np.arange(1, len(piece) + 1)
        ends = np.flatnonzero(np.diff(ring, append=-1))
        successor[ends] = np.concatenate([[0], ends[:-1] + 1])
        return Polyline(points, piece, s, step, successor, ring)

    def _graded_to_contacts(self) -> tuple[Integers, Floats]:
        """Piece and arc length of more points beside corners that join two rings.

        Two curves may touch there with a common tangent: only chords that shrink towards the contact keep apart.
        """
        rings = int(self.ring.max()) + 1
        corner_and_ring = np.unique((self.start * rings + self.ring)[~self.closed & ~self.inner])
        rings_at = np.bincount(corner_and_ring // rings, minlength=len(self.corners))
        contact = np.append(rings_at > 1, False)  # the last entry answers for start = -1
        curved = (self._chords > 1) & ~self.inner
        forward, backward = np.flatnonzero(contact[self.start] & curved), np.flatnonzero(contact[self.end] & curved)
        touching = np.union1d(forward, backward)
        # Equal lengths on both curves: the sharper curve's chords then turn away faster.
        s = 4 * np.min((self.lengths / self._chords)[touching], initial=np.inf) * CONTACT_GRADING
        after = np.tile(s, len(forward))
        before = (self.lengths[backward, None] - s).ravel()
        per_end = len(CONTACT_GRADING)
        return np.repeat(np.concatenate([forward, backward]), per_end), np.concatenate([after, before])

    def edges(self, piece: Integers, s: Floats) -> tuple[Integers, Integers]:
        """Boundary edges between corners and the nodes (m,) at arc length ``s`` on the pieces ``piece``.

        Returns
        -------
        edges : (e, 2)
            Node numbers, corners first, then the given nodes; the domain is on the left of each edge.
        edge_piece : (e,)
            The piece that each edge follows.
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

    def split(self, piece: int, s: float, point: Floats) -> "Boundary":
        """The boundary with a corner at ``point`` (2,), which lies on ``piece`` at arc length ``s``.

        An existing corner there is kept; a closed piece becomes one that starts and ends at the corner.
        """
        same = np.flatnonzero((self.corners == point).all(axis=1))
        corner = int(same[0]) if len(same) else len(self.corners)
        corners = self.corners if len(same) else np.vstack([self.corners, point])
        return replace(self, corners=corners).cut(np.array([piece]), np.array([s]), np.array([corner]))

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


def default_label(ring: int) -> str:
    """Label of the sides that the case does not name."""
    return "outer" if ring == 0 else f"hole-{ring}"
