"""Pinch-outs: corners so sharp that nodes on both of their sides have to be opposite to each other.

Where the sides are nearer to each other than bubbles are large, these push each other into the gaps of the other side,
and triangles between them are as flat as the sides are near. Between nodes at the same distances from the corner no
angle is much above 90 degrees.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple, Self

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, complement
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.corners import PINCH_OUT
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.quality import angles
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.net import Net, connect_inside
from bubblemesh.packing.smoothing import NoSmoothing, Smoothing
from bubblemesh.spacing.spacing import Spacing

NARROW = 0.5  # spacings between two sides, below which nodes in each other's gaps have angles above 90 degrees
BESIDE = 0.5  # spacings: distance that other nodes have from the last of those that are opposite to each other
AROUND_OPPOSITE = 4  # rings of nodes around these that are smoothed
SMOOTHING_PASSES = 3
POWER = 16


class Leg(NamedTuple):
    """A side of a pinch-out."""

    piece: int
    forward: bool  # whether the piece starts at the corner, rather than ends there
    length: float

    def turned(self, s: Floats) -> Floats:
        """Distances (m,) from the corner of arc lengths (m,) of the piece, and the other way round."""
        return s if self.forward else self.length - s

    def places(self, domain: Domain, away: Floats) -> tuple[Floats, Integers, Floats]:
        """Points (m, 2), pieces (m,) and arc lengths (m,) at distances (m,) from the corner."""
        piece, s = np.full(len(away), self.piece), self.turned(away)
        return domain.boundary.points(piece, s), piece, s


class Occupied(NamedTuple):
    """A side of a pinch-out with its sliding bubbles, in order from the corner."""

    leg: Leg
    number: Integers  # (k,), of the bubbles
    away: Floats  # (k,): distances from the corner along the side
    d: Floats  # (k,): spacings
    touched: Booleans  # (k,)

    @classmethod
    def by(cls, bubbles: Bubbles, leg: Leg) -> Self:
        """A side with those of some bubbles that are on it."""
        mine = np.flatnonzero(bubbles.piece == leg.piece)
        away = leg.turned(bubbles.s[mine])
        order = np.argsort(away)
        number = bubbles.corners + mine[order]
        return cls(leg, number, away[order], bubbles.d[number], bubbles.touched[number])

    def narrow(self, domain: Domain, other: Leg) -> int:
        """How many of the bubbles follow each other from the corner on that are near to the other side."""
        inside = self.away + BESIDE * self.d < other.length
        away, d = self.away[inside], self.d[inside]
        width = np.hypot(*(self.leg.places(domain, away)[0] - other.places(domain, away)[0]).T)
        return int(np.logical_and.accumulate(width < NARROW * d).sum())

    def narrow_end(self, domain: Domain, spacing: Spacing, longer: Leg) -> float | None:
        """The spacing at the end of this side; None unless it is narrow up to there, and the other one is longer."""
        length = self.leg.length
        end, opposite = (leg.places(domain, np.array([length]))[0] for leg in (self.leg, longer))
        d, width = float(spacing(end)[0]), float(np.hypot(*(end - opposite)[0]))
        narrow = width < NARROW * d and self.narrow(domain, longer) == len(self.number)
        return d if narrow and length + BESIDE * d < longer.length else None


class Opposites(NamedTuple):
    """What makes bubbles on both sides of a pinch-out opposite to each other."""

    gone: Integers  # (k,): numbers of bubbles that go
    new: tuple[tuple[Leg, Floats], ...]  # sides, and the distances (m,) from the corner of bubbles that come there
    stay: Integers = np.zeros(0, np.int64)  # (l,): numbers of those that get others opposite to them

    def put(self, bubbles: Bubbles, domain: Domain, spacing: Spacing) -> Bubbles:
        """Bubbles with those that come, without those that go; those that come or stay are touched."""
        touched = bubbles.touched.copy()
        touched[self.stay] = True
        bubbles = replace(bubbles, touched=touched).select(complement(len(bubbles), self.gone))
        for leg, away in self.new:
            x, piece, s = leg.places(domain, away)
            bubbles = bubbles.append(x, spacing(x), piece, s)
        return bubbles


def with_opposite_nodes(net: Net, domain: Domain, spacing: Spacing, smoothing: NoSmoothing | Smoothing) -> Net:
    """The net with nodes opposite to each other in pinch-outs, if that makes flat triangles fewer.

    Without smoothing it stays as it is.
    """
    found = list(pinch_outs(domain)) if smoothing.shape_steps else []
    if not found:
        return net
    bubbles = replace(net.bubbles, touched=np.zeros(len(net.bubbles), bool))
    for both in found:
        one, other = (Occupied.by(bubbles, leg) for leg in both)
        opposites = _opposites(domain, spacing, one, other)
        bubbles = bubbles if opposites is None else opposites.put(bubbles, domain, spacing)
    if not bubbles.touched.any():
        return net
    try:
        tried = _smoothed(connect_inside(bubbles, domain, spacing), domain, spacing, smoothing)
    except GeometryError:  # another wall is near
        return net
    return tried if _flatness(tried) < _flatness(net) else net


def pinch_outs(domain: Domain) -> Iterator[tuple[Leg, Leg]]:
    """Both sides of each pinch-out, but for those whose nodes are held or match those of periodic sides."""
    fans, lengths = domain.corner_fans, domain.boundary.lengths
    sharp = fans.within(domain.boundary) & (np.degrees(fans.angle_to(fans.following)) < PINCH_OUT)
    for row in np.flatnonzero(sharp).tolist():
        both = [row, int(fans.following[row])]
        piece = fans.piece[both]
        if piece[0] != piece[1] and not domain.tied[piece].any():
            one, other = map(Leg, piece.tolist(), fans.forward[both].tolist(), lengths[piece].tolist())
            yield one, other


def _opposites(domain: Domain, spacing: Spacing, one: Occupied, other: Occupied) -> Opposites | None:
    """What makes bubbles on two sides opposite to each other as far as it is narrow there; None if nothing is to do.

    Where some on one side are touched already, these stay. If they would have to go, nothing is to do.
    """
    shorter, longer = sorted((one, other), key=lambda side: side.leg.length)
    d = shorter.narrow_end(domain, spacing, longer.leg)
    if d is not None and not shorter.touched.any():
        return _up_to_end(shorter, longer, d)
    if other.touched.any():
        one, other = other, one
    count = one.narrow(domain, other.leg)
    return _up_to(one, other, count) if count else None


def _up_to(one: Occupied, other: Occupied, count: int) -> Opposites | None:
    """Likewise for so many bubbles on one side."""
    narrow = slice(count)
    away, d, number = one.away[narrow], one.d[narrow], one.number[narrow]
    beside = other.away < away[-1] + BESIDE * d[-1]
    gone = other.number[beside]
    if other.touched[beside].any():
        return None
    if one.touched[narrow].any():
        return Opposites(gone, ((other.leg, away),), stay=number)
    away = _even(away, d)
    return Opposites(np.append(gone, number), ((one.leg, away), (other.leg, away)))


def _up_to_end(shorter: Occupied, longer: Occupied, d: float) -> Opposites | None:
    """Likewise where it is narrow up to the end of the shorter side: a node is opposite to this corner, of spacing d.

    Two pinch-outs may have this one in common, as at the crown of a lens. Where others are in the way, nothing is
    to do.
    """
    end, beside = shorter.leg.length, BESIDE * d
    if longer.touched[longer.away <= end - beside].any():
        return None
    at_end = longer.away < end + beside
    away = _even(np.append(shorter.away, end), np.append(shorter.d, d))
    gone = np.append(shorter.number, longer.number[at_end & ~longer.touched])
    opposite = away[:-1] if longer.touched[at_end].any() else away
    return Opposites(gone, ((shorter.leg, away[:-1]), (longer.leg, opposite)))


def _even(away: Floats, d: Floats) -> Floats:
    """Distances (m,) of which the last one is that of some (k,), and which are as far apart as their spacings (k,)."""
    away = np.append(0.0, away)
    passed = np.append(0.0, np.cumsum(np.diff(away) / d))
    count = max(round(passed[-1]), 1)
    return np.interp(passed[-1] * np.arange(1, count + 1) / count, passed, away)


def _smoothed(net: Net, domain: Domain, spacing: Spacing, smoothing: NoSmoothing | Smoothing) -> Net:
    """The net with bubbles around those that are touched, which stay, moved to better shapes."""
    for _ in range(SMOOTHING_PASSES):
        stay = net.bubbles.touched
        free = net.within(np.flatnonzero(stay), AROUND_OPPOSITE) & ~stay
        free[: net.bubbles.corners] = False
        net = connect_inside(smoothing.moved(net, domain, free), domain, spacing, net)
    return net


def _flatness(net: Net) -> float:
    """How many triangles are flat, and how flat: the largest angles count by far the most."""
    return float(((angles(net.bubbles.x, net.triangles).max(axis=1) / 90) ** POWER).sum())
