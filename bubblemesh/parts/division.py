"""The division of a domain by cuts into parts, each a domain of its own whose bubbles along the cuts are set."""

from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, each_once
from bubblemesh.geometry.arrangement import TOUCHING
from bubblemesh.geometry.arrangement.noding import noded
from bubblemesh.geometry.arrangement.partition import clipped_to_domain
from bubblemesh.geometry.arrangement.pieces import probes, without_doubles
from bubblemesh.geometry.arrangement.regions import region_at
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.curves import Lines
from bubblemesh.geometry.domain import Domain, Held
from bubblemesh.geometry.faces import compact, face
from bubblemesh.geometry.periodic import counterparts
from bubblemesh.packing.placement.diffusion import boundary_bubbles
from bubblemesh.parts.cuts import CUT, Cuts
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing


class Places(NamedTuple):
    """Where things of a part are in the division."""

    corner: Integers  # (c,): corner of the division that each corner is
    piece: Integers  # (p,): piece that each piece is
    turned: Booleans  # (p,): those that run the other way
    on_cut: Booleans  # (p,): those with another part on the other side
    ends: Integers  # (e,): corners at which cuts meet each other, the boundary, or inner lines
    left: Integers  # (p,): region of the whole on the left of each piece
    right: Integers  # (p,): likewise, -1 outside the domain


@record
class CutDomain:
    """A domain that is cut.

    Pieces of its boundary are cut where they meet cuts, which are inner pieces themselves.
    """

    whole: Domain
    cuts: Cuts
    boundary: Boundary  # that of the whole, then its new corners; with the cuts
    origin: Integers  # (p,): piece of the whole that each piece is a part of, or -1 for a cut
    left: Integers  # (p,): cell on the left of each piece
    right: Integers  # (p,): cell on the right, -1 outside the domain
    held: Held  # bubbles on the cuts, and on periodic sides

    @property
    def on_cut(self) -> Booleans:
        """Mask (p,) of the pieces between two cells: those of cuts, and what else runs along them."""
        return self.boundary.inner & (self.left != self.right)

    @cached_property
    def ends(self) -> Integers:
        """Corners (e,) at which cuts meet each other, the boundary, or inner lines, in ascending order."""
        cuts = self.origin < 0
        fresh = np.arange(len(self.whole.boundary.corners), len(self.boundary.corners))
        return each_once(np.concatenate([self.boundary.start[cuts], self.boundary.end[cuts], fresh]))

    def part(self, cell: int) -> tuple[Domain, Places]:
        """The domain of one cell, and where its corners and pieces are in the division."""
        boundary = self.boundary
        inner = boundary.inner
        between = self.on_cut
        here, there = self.left == cell, self.right == cell
        within = inner & ~between & here
        turned = between & there
        rim = (~inner & here) | (between & here) | turned
        mine = np.flatnonzero(rim | within)
        straightened = _with_lines(boundary, np.flatnonzero(between & (here | there)), turned)
        # Bubbles know of no regions: the whole domain has them.
        left, right = np.zeros(len(rim), np.int64), np.where(rim, -1, 0)
        ready = replace(straightened, left=left, right=right, ring=np.where(between, -1, boundary.ring))
        traced, order = face(ready.select(mine), rim[mine])
        small, corners = compact(traced, self._embedded(cell))
        pieces = mine[order]
        back = turned[pieces]
        domain = Domain(small, held=self._held(pieces, back))
        ends = np.flatnonzero(np.isin(corners, self.ends))
        left, right = boundary.left[pieces], boundary.right[pieces]
        sides = np.where(back, right, left), np.where(back, left, right)
        return domain, Places(corners, pieces, back, between[pieces], ends, *sides)

    def on_whole(self, node: Integers, piece: Integers, s: Floats) -> tuple[Integers, Floats]:
        """Pieces (n,) of the whole, -1 for none, and arc lengths (n,) there, of nodes on pieces and of new corners.

        ``node`` (n,) has the numbers of corners, and more than these for others; ``piece`` (n,), -1 for none, and ``s``
        (n,) say where the latter are.
        """
        whole, boundary = self.whole.boundary, self.boundary
        at, along = piece.copy(), s.copy()
        new = np.flatnonzero((node >= len(whole.corners)) & (node < len(boundary.corners)))
        starting = np.full(len(boundary.corners), -1)
        old = np.flatnonzero((self.origin >= 0) & ~boundary.closed)
        starting[boundary.start[old]] = old
        at[new], along[new] = starting[node[new]], 0.0
        number = np.where(at >= 0, self.origin[at], -1)
        on = np.flatnonzero(number >= 0)
        here, there = at[on], number[on]
        result = along + 0.0
        result[on] = whole.wrapped(there, along[on] + (boundary.offset[here] - whole.offset[there]))
        return number, result

    def _embedded(self, cell: int) -> Integers:
        """Corners (k,) that are embedded points in a cell, and no piece's end."""
        boundary = self.boundary
        alone = np.ones(len(boundary.corners), bool)
        alone[boundary.start[~boundary.closed]] = alone[boundary.end[~boundary.closed]] = False
        numbers = np.flatnonzero(alone)
        return numbers[self.cuts.cell_of(boundary.corners[numbers]) == cell]

    def _held(self, pieces: Integers, turned: Booleans) -> Held:
        """Bubbles held on the pieces (p,) of a part, by their numbers there; some pieces run the other way."""
        place = np.full(len(self.boundary.kind), -1)
        place[pieces] = np.arange(len(pieces))
        mine = place[self.held.piece] >= 0
        piece = place[self.held.piece[mine]]
        s = self.held.s[mine]
        s = np.where(turned[piece], self.boundary.lengths[self.held.piece[mine]] - s, s)
        order = np.lexsort((s, piece))
        numbers = place[self.held.pieces]
        return Held(np.sort(numbers[numbers >= 0]), piece[order], s[order])


def _with_lines(boundary: Boundary, pieces: Integers, turned: Booleans) -> Boundary:
    """The boundary with straight lines of their own as the pieces (k,), from corner to corner, some (p,) turned."""
    start, end = boundary.start.copy(), boundary.end.copy()
    start[turned], end[turned] = boundary.end[turned], boundary.start[turned]
    lines = Lines(boundary.corners[start[pieces]], boundary.corners[end[pieces]])
    kind, index, offset, lengths = (getattr(boundary, name).copy() for name in ("kind", "index", "offset", "lengths"))
    kind[pieces], index[pieces], offset[pieces] = len(boundary.families), np.arange(len(pieces)), 0
    lengths[pieces] = lines.lengths
    families = (*boundary.families, lines)
    columns = {"kind": kind, "index": index, "offset": offset, "lengths": lengths, "start": start, "end": end}
    return replace(boundary, families=families, **columns)


def cut_domain(domain: Domain, cuts: Cuts, spacing: Spacing, *, coarsened: bool) -> CutDomain:
    """Cut a domain; the bubbles along the cuts are placed by the spacing, once for the parts on both sides.

    Where these are packed on levels that are ``coarsened``, their numbers are such that each level has every second one
    of the next: rows across a cut go on when they are refined. Else some would end there, and leave defects.
    """
    whole, size = domain.boundary, domain.size
    named = replace(whole, label=np.arange(len(whole.kind)), labels=tuple(map(str, range(len(whole.kind)))))
    fresh = named.with_inner(cuts.lines)
    # The numbers that inner pieces have are those of lines of the case, for errors about these.
    boundary = noded(fresh, size, len(whole.corners), domain.parts)
    boundary = without_doubles(boundary, TOUCHING * size)
    boundary = clipped_to_domain(boundary, domain.parts.points, TOUCHING * size)
    origin = np.where(boundary.label < len(whole.kind), boundary.label, -1)
    here, there = probes(boundary)
    left, right = cuts.cell_of(here), np.where(boundary.inner, cuts.cell_of(there), -1)
    label = np.where(origin < 0, len(whole.labels), whole.label[origin])
    # A cut has the region that it runs through on both sides.
    region = region_at(here, [region.polygon for region in domain.parts.regions])
    left_region, right_region = (np.where(origin < 0, region, side) for side in (boundary.left, boundary.right))
    names = (*whole.labels, CUT)
    boundary = replace(boundary, label=label, labels=names, left=left_region, right=right_region)
    division = _mirrored(CutDomain(domain, cuts, boundary, origin, left, right, Held()))
    held = division.on_cut | (division.origin >= 0) & domain.tied[division.origin]
    straight = _with_lines(division.boundary, np.flatnonzero(division.on_cut), np.zeros(len(held), bool))
    halved = division.on_cut & coarsened
    shell = boundary_bubbles(Domain(straight, parts=domain.parts), spacing, halved)
    order = np.lexsort((shell.s, shell.piece))
    order = order[held[shell.piece[order]]]
    return replace(division, held=Held(np.flatnonzero(held), shell.piece[order], shell.s[order]))


def _mirrored(division: CutDomain) -> CutDomain:
    """The division with a corner on a periodic side wherever a cut meets its counterpart."""
    whole = division.whole.boundary
    boundary = division.boundary
    pairs = division.whole.periodic
    new = np.arange(len(whole.corners), len(boundary.corners))
    if len(pairs) == 0 or len(new) == 0:
        return division
    number, along = division.on_whole(new, np.full(len(new), -1), np.zeros(len(new)))
    on_side = number >= 0
    _, piece, s = counterparts(whole, pairs, number[on_side], along[on_side])
    order = np.lexsort((s, piece))
    piece, s = piece[order], s[order]
    # Pieces of the division on each side, in its direction, and where they begin on it.
    parts = np.flatnonzero((division.origin >= 0) & division.whole.tied[division.origin])
    begin = boundary.offset[parts] - whole.offset[division.origin[parts]]
    order = np.lexsort((begin, division.origin[parts]))
    parts, begin = parts[order], begin[order]
    far = 1.0 + whole.lengths.max()
    found = parts[np.searchsorted(division.origin[parts] * far + begin, piece * far + s, side="right") - 1]
    local = s - (boundary.offset[found] - whole.offset[piece])
    near = TOUCHING * division.whole.size
    inside = (local > near) & (local < boundary.lengths[found] - near)
    found, local = found[inside], local[inside]
    copies = np.arange(len(boundary.kind))
    cut = replace(boundary, label=copies).split(found, local, boundary.points(found, local))
    before = cut.label
    split = replace(cut, label=boundary.label[before])
    columns = {name: getattr(division, name)[before] for name in ("origin", "left", "right")}
    return replace(division, boundary=split, **columns)
