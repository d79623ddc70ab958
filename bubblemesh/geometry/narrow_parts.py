"""Narrow parts of a domain: gaps between lines that face each other at necks, thin walls, layers and strips."""

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import (
    ROUNDING,
    Booleans,
    Floats,
    Integers,
    concatenated,
    median,
    members,
    select,
    taken,
    turned_left,
)
from bubblemesh.geometry.boundary import Chords
from bubblemesh.geometry.curves import shares_before
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.segments import segments_meet
from bubblemesh.records import record

BEND = 1.5  # length along a line over the distance, above which it counts as another wall; half a circle: pi / 2
WEDGE = 2.0  # widths: lines that meet are not walls of a gap so near to their meeting point
PARALLEL = np.cos(np.radians(15))  # lines that meet at a larger angle are not walls of a gap either
SHARPEST_BEND = np.cos(np.radians(120))  # of lines that just go on, without a tip
BEHIND = 0.9  # cosine of the angle to the lines of a tip, above which something counts as a part of these
PARTS = (0.05, 0.5, 0.95)  # shares of the way across at which it must be in the domain
MANY_CHORDS, FEWEST_PARTS = 1000, 4  # of a domain, and on the average of them, to look for parts of chords
GENEROUS = 1e-3  # of a chord's length: far more than the rounding error of a meeting point
PADDED = 1.01  # factor by which rays are longer than needed
MOST_DISTANCES = 10_000  # of corners from lines: of more it takes less time to look for gaps
DOUBLINGS = 8  # of the reach, so that near walls are found without a search among far ones


class Gaps(NamedTuple):
    """Gaps from places on lines, or from points, to lines and points that face them."""

    number: Integers  # (k,), number of the place among the given ones
    places: Floats  # (k, 2)
    feet: Floats  # (k, 2), nearest points on the lines that face the places
    widths: Floats  # (k,), distances of the two
    inner: Booleans  # (k,), whether a line or point inside the domain is at one end


NO_GAPS = Gaps(np.zeros(0, np.int64), np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0), np.zeros(0, bool))


class ReentrantCorners(NamedTuple):
    """Corners (k,) that stand out into the domain, and directions (k, 2) of the lines there.

    Both are the same at the end of a line, and zero for an embedded point.
    """

    corner: Integers
    first: Floats
    second: Floats


@record
class FacingWalls:
    """All lines of a domain, its rings and those inside, as chords among which to look for gaps."""

    domain: Domain

    @cached_property
    def chords(self) -> Chords:
        """The chords."""
        return self.domain.boundary.chords()

    @cached_property
    def reentrant(self) -> ReentrantCorners:
        """Corners that stand out into the domain."""
        return reentrant_corners(self.domain)

    @cached_property
    def least_width(self) -> float:
        """Width that no gap is below: the least distance of a corner from a straight line that does not end there.

        It is 0 where it is not known, as where lines are curved.
        """
        boundary = self.domain.boundary
        if boundary.curved.any() or len(boundary.corners) * len(boundary.kind) > MOST_DISTANCES:
            return 0.0
        corners, start, end = boundary.corners[:, None], *boundary.corners[np.stack([boundary.start, boundary.end])]
        ways = start + shares_before(corners, start, end)[..., None] * (end - start) - corners
        distance = np.hypot(ways[..., 0], ways[..., 1])
        for own in (boundary.start, boundary.end):
            distance[own, np.arange(len(own))] = np.inf
        return float(distance.min(initial=np.inf))

    @cached_property
    def tree(self) -> shapely.STRtree:
        """The chords in space."""
        return shapely.STRtree(shapely.linestrings(np.stack([self.chords.start, self.chords.end], axis=1)))

    def facing(self, piece: Integers, s: Floats, reach: Floats, room: Floats) -> Gaps:
        """Gaps between places on the lines and the lines across: on the left of rings, on both sides of inner lines.

        For places at arc lengths s (m,) on pieces (m,), it is the nearest gap within ``reach`` (m,), perpendicular to
        the lines, on each side that has one. Lines that meet at both ends are walls only farther than ``room`` (m,)
        from these ends.
        """
        boundary, chords = self.domain.boundary, self.chords
        both = np.flatnonzero(boundary.inner[piece])
        number = np.append(np.arange(len(piece)), both)
        side = np.repeat([1.0, -1.0], [len(piece), len(both)])
        piece, s, reach, room = piece[number], s[number], reach[number], room[number]
        points, tangents = boundary.tracks(piece).places(s)
        normals = side[:, None] * turned_left(tangents)
        rays = np.stack([points, points + reach[:, None] * normals], axis=1)
        beyond = np.full(len(points), np.inf)
        left = np.arange(len(points))
        found = []
        for share in self._shares(reach):
            near = share * reach if share < 1 else np.full(len(reach), np.inf)
            ray, chord = self._met(taken(points, left), taken(normals, left), PADDED * share * reach[left])
            ray = left[ray]
            begin = chords.s[chord]
            own = (chords.piece[chord] == piece[ray]) & (begin <= s[ray]) & (s[ray] <= begin + chords.step[chord])
            may = ~own & self._may_meet(taken(points, ray), taken(normals, ray), chord)
            ray, chord = ray[may], chord[may]
            if len(ray) == 0:
                continue
            met = segments_meet(rays[ray], np.stack([chords.start[chord], chords.end[chord]], axis=1))
            ray, chord = ray[met], chord[met]
            at, leaves = self._crossings(points[ray], normals[ray], chord)
            np.minimum.at(beyond, ray[leaves], at[leaves])
            seen = (at <= beyond[ray]) & (at <= near[ray])
            ray, chord, at = ray[seen], chord[seen], at[seen]
            foot = self._feet(points[ray], chord)
            feet = boundary.points(chords.piece[chord], foot)
            widths = np.hypot(*(feet - points[ray]).T)
            apart = self._opposite(piece[ray], s[ray], tangents[ray], chord, foot, widths, room[ray])
            inner = boundary.inner[piece[ray]] | boundary.inner[chords.piece[chord]]
            gaps = select(Gaps(number[ray], points[ray], feet, widths, inner), apart)
            ray = ray[apart]
            nearest = np.lexsort((at[apart], ray))
            nearest = nearest[np.diff(ray[nearest], prepend=-1) != 0]
            found.append((ray[nearest], select(gaps, nearest)))
            left = _without(left[beyond[left] > near[left]], ray, len(points))
        if not found:
            return NO_GAPS
        ray = np.concatenate([rays_found for rays_found, _ in found])
        return gaps_inside(self.domain, select(concatenated([gaps for _, gaps in found]), np.argsort(ray)))

    def _shares(self, reach: Floats) -> Floats:
        """Shares of the reach (m,) to search, one after the other; most chords are shorter than the least of them."""
        shares = 4.0 ** np.arange(-DOUBLINGS // 2, 1)
        lengths = np.hypot(*(self.chords.end - self.chords.start).T)
        useful = shares * median(reach) > median(lengths) if len(reach) else shares > 1
        return np.asarray(shares[useful | (shares == 1)], float)

    def _met(self, points: Floats, directions: Floats, lengths: Floats) -> tuple[Integers, Integers]:
        """Rays (k,), from ``points`` (m, 2), and the chords (k,) that they may meet, each pair once."""
        ends = points + lengths[:, None] * directions
        rays = shapely.linestrings(np.stack([points, ends], axis=1))
        chord_of, tree = self._parts
        ray, part = tree.query(rays)
        if chord_of is None:
            return ray, part
        order = self.tree.query(
            shapely.box(*shapely.total_bounds(self.tree.geometries))
        )  # in which the tree tells chords
        rank = np.argsort(order)
        pairs = np.sort(ray * len(order) + rank[chord_of[part]])
        ray, place = np.divmod(pairs[np.diff(pairs, prepend=-1) != 0], len(order))
        return ray, order[place]

    def _may_meet(self, points: Floats, directions: Floats, chord: Integers) -> Booleans:
        """Whether lines through ``points`` (m, 2) may meet the chords (m,): a quick look, which is generous."""
        (dx, dy), (ax, ay) = directions.T, (taken(self.chords.start, chord) - points).T
        cx, cy = (taken(self.chords.end, chord) - taken(self.chords.start, chord)).T
        sine, across = dx * cy - dy * cx, ax * dy - ay * dx
        aslant = np.abs(sine) > GENEROUS * np.hypot(cx, cy)
        return ~aslant | (np.abs(across - sine / 2) <= (0.5 + GENEROUS) * np.abs(sine))

    @cached_property
    def _parts(self) -> tuple[Integers | None, shapely.STRtree]:
        """Parts of the chords in space, and the chord of each, or the chords as they are (None).

        The boxes around long lines side by side, such as the walls of a star, overlap each other: parts of these lines
        as long as the mean of their lengths and distances, in powers of both, are found much faster.
        """
        start, end = self.chords.start, self.chords.end
        length = np.hypot(*(end - start).T)
        apart = self.domain.polygon.area / length.sum()
        parts = np.ceil(length / np.sqrt(length.mean() * apart)).astype(np.int64)
        if len(length) < MANY_CHORDS or parts.mean() < FEWEST_PARTS:
            return None, self.tree
        chord, part = members(parts)
        ends = [start[chord] + ((part + k) / parts[chord])[:, None] * (end - start)[chord] for k in (0, 1)]
        return chord, shapely.STRtree(shapely.linestrings(np.stack(ends, axis=1)))

    def _crossings(self, points: Floats, directions: Floats, chord: Integers) -> tuple[Floats, Booleans]:
        """Distances (m,) of chords along rays from ``points`` (m, 2), and which rays leave the domain there."""
        (dx, dy), (ax, ay) = directions.T, (taken(self.chords.start, chord) - points).T
        cx, cy = (taken(self.chords.end, chord) - taken(self.chords.start, chord)).T
        sine = dx * cy - dy * cx
        ring = ~self.domain.boundary.inner[self.chords.piece[chord]]
        with np.errstate(divide="ignore", invalid="ignore"):  # along the ray: no number, and nothing that it meets
            return (ax * cy - ay * cx) / sine, ring & (sine > 0)

    def _feet(self, points: Floats, chord: Integers) -> Floats:
        """Arc lengths (m,) of the points of the curves beside the nearest points of their chords."""
        chords = self.chords
        share = shares_before(points, chords.start[chord], chords.end[chord])
        return np.asarray(chords.s[chord] + share * chords.step[chord])

    def _opposite(
        self,
        piece: Integers,
        s: Floats,
        tangents: Floats,
        chord: Integers,
        foot: Floats,
        widths: Floats,
        room: Floats,
    ) -> Booleans:
        """Whether feet (m,) on the chords belong to another wall than the places, not to its bend or next corner."""
        boundary, chords = self.domain.boundary, self.chords
        other = chords.piece[chord]
        length = boundary.lengths[piece]
        along = np.abs(foot - s)
        along = np.where(boundary.closed[piece], np.minimum(along, length - along), along)
        start, end = boundary.start[piece], boundary.end[piece]
        ends = np.stack([boundary.start[other], boundary.end[other]])
        at_start, at_end = ((mine == ends).any(axis=0) & (mine >= 0) for mine in (start, end))  # -1 is not a corner
        dx, dy = (chords.end[chord] - chords.start[chord]).T
        cosine = np.abs(tangents[:, 0] * dx + tangents[:, 1] * dy) / np.hypot(dx, dy)
        slender = (cosine > PARALLEL) & (np.minimum(s, length - s) > np.maximum(room, WEDGE * widths))
        bent = (along > BEND * widths + ROUNDING * length) & ((start != end) | boundary.closed[piece] | slender)
        return np.where(piece == other, bent, ~(at_start | at_end) | (at_start & at_end & slender))

    def facing_corners(self, some: ReentrantCorners, reach: Floats) -> Gaps:
        """Gaps from corners to the nearest line or embedded point within reach (k,) that is not behind them."""
        domain, boundary = self.domain, self.domain.boundary
        if len(some.corner) == 0:
            return NO_GAPS
        open_ = ~boundary.closed
        ends = np.append(boundary.start[open_], boundary.end[open_])
        alone = _without(np.arange(len(boundary.corners)), ends, len(boundary.corners))
        things = np.append(self.tree.geometries, shapely.points(boundary.corners[alone]))
        inner = np.append(boundary.inner[self.chords.piece], np.ones(len(alone), bool))
        on_ring = np.isin(some.corner, [boundary.start[~boundary.inner], boundary.end[~boundary.inner]])
        tree = shapely.STRtree(things) if len(alone) else self.tree
        spots = shapely.points(boundary.corners[some.corner])
        left, found = np.arange(len(spots)), []
        for share in 2.0 ** np.arange(-DOUBLINGS, 1):
            tip, thing = tree.query(spots[left], predicate="dwithin", distance=share * reach[left])
            tip = left[tip]
            ways = shapely.get_coordinates(shapely.shortest_line(spots[tip], things[thing])).reshape(-1, 2, 2)
            place, foot = ways[:, 0], ways[:, 1]
            width = np.hypot(*(foot - place).T)
            behind = np.max([(line[tip] * (foot - place)).sum(axis=1) for line in (some.first, some.second)], axis=0)
            gaps = Gaps(tip, place, foot, width, inner[thing] | ~on_ring[tip])
            gaps = gaps_inside(domain, select(gaps, (width > 0) & (behind < BEHIND * width)), PARTS)
            order = np.lexsort((gaps.widths, gaps.number))
            found.append(select(gaps, order[np.diff(gaps.number[order], prepend=-1) != 0]))
            left = _without(left, gaps.number, len(spots))
        return concatenated(found)


def _without(some: Integers, others: Integers, count: int) -> Integers:
    """Numbers of ``some`` (k,), all below ``count``, without the ``others`` (m,)."""
    gone = np.zeros(count, bool)
    gone[others] = True
    return some[~gone[some]]


def reentrant_corners(domain: Domain) -> ReentrantCorners:
    """Embedded points, ends of lines, and sharp bends of lines and of rings into the domain."""
    boundary = domain.boundary
    leaving = domain.corner_fans
    direction = np.column_stack([np.cos(leaving.direction), np.sin(leaving.direction)])
    count = np.bincount(leaving.corner, minlength=len(boundary.corners))
    start = np.cumsum(count) - count
    alone, open_end, bend = (np.flatnonzero(count == number) for number in (0, 1, 2))
    a, b = start[bend], start[bend] + 1
    sharp = (direction[a] * direction[b]).sum(axis=1) > SHARPEST_BEND
    # The domain is on the left of a ring, and so all of it is that is not between the lines.
    ring = ~boundary.inner[leaving.piece[a]] & ~boundary.inner[leaving.piece[b]]
    ahead = np.where(leaving.forward[a], leaving.angle_to(leaving.following)[a], leaving.angle_to(leaving.following)[b])
    bend, a, b = (column[sharp & (~ring | (ahead > np.pi))] for column in (bend, a, b))
    corner = np.concatenate([alone, open_end, bend])
    none = np.zeros((len(alone), 2))
    first, second = (np.vstack([none, direction[start[open_end]], direction[which]]) for which in (a, b))
    return ReentrantCorners(corner, first, second)


def gaps_inside(domain: Domain, gaps: Gaps, shares: Sequence[float] = (0.5,)) -> Gaps:
    """Gaps of which some parts of the way are in the domain, not across what is outside of it."""
    between = [domain.contains(gaps.places + share * (gaps.feet - gaps.places)) for share in shares]
    return select(gaps, np.all(between, axis=0))
