"""Straight cuts of a domain into cells of about the same work: short, square to walls, far from corners."""

from collections.abc import Iterator
from itertools import chain
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.errors import CaseError, at_key
from bubblemesh.geometry.arrangement import NEARLY, TOUCHING
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.paths import Line, OpenPath, Point, Side, as_point
from bubblemesh.messages import place
from bubblemesh.parts.landings import Landings
from bubblemesh.parts.periodic_sides import CutPeriodicSides
from bubblemesh.records import record
from bubblemesh.spacing.grid.cells import Leaves, leaves
from bubblemesh.spacing.spacing import Spacing

SAMPLES = 1000.0  # leaves, about, for each cell, whose work is divided
COARSEST = 1.0  # spacings: the least side of a leaf
DIRECTIONS = 12
ANGLES = tuple(np.pi * k / DIRECTIONS for k in range(DIRECTIONS))
ORIGIN = 0.0, 0.0  # from which heights are measured
SHIFTS = np.linspace(-0.06, 0.06, 7)  # of the work: how far a cut may be from an even division
LOOKED_AT = 16  # cuts of those that cross the fewest bubbles
POINTS = 200  # on a cut, at which the spacing is taken
# What else counts, in bubbles along a cut.
CROSSING = 10.0  # of a wall, a line or another cut, square to it
OBLIQUE = 60.0  # more for one at no angle at all
NEAR = 40.0  # a corner, or a node's distance from a wall that runs along
CLEAR = 4.0  # spacings: what is farther is not near
EVEN = 0.7  # least work of a cell on one side of a cut, of that of one on the other, after it was moved
UNEVEN = 2.0  # per bubble of a perfect cut, and share of the work that is off
MEETING = 1e-6  # of a cut's length: it meets what is so near to its ends
ASIDE = 8  # times what is taken for a slip, in which a cut is moved away from corners
ASIDES = 0.0, 0.5, -0.5, 1.0, -1.0, 1.5, -1.5, 2.0, -2.0, 3.0, -3.0  # spacings, in which one beside periodic sides is
BEYOND_DOMAIN = 0.01  # of the domain's size: around it

CUT = "cut"  # label of the lines


class Cut(NamedTuple):
    """A directed line; what is on its left goes one way, the rest the other."""

    at: Point
    angle: float
    left: int  # number of the next cut there, or, as -1 - k, the cell k
    right: int


@record
class Cuts:
    """A tree of cuts of a box, and the lines along which they run."""

    cuts: tuple[Cut, ...]
    lines: tuple[OpenPath, ...]  # one for each cut, from one cut before it, or from the box, to another
    cells: int  # their number
    work: Floats  # (cells,): bubbles that each cell needs, about

    def cell_of(self, points: Floats) -> Integers:
        """Cell (n,) of each of the points (n, 2)."""
        found = np.empty(len(points), np.int64)
        queue = [(0 if self.cuts else -1, np.arange(len(points)))]
        for number, mine in queue:
            if number < 0:
                found[mine] = -1 - number
            else:
                cut = self.cuts[number]
                left = _offset(points[mine], cut.at, cut.angle) > 0
                queue += [(cut.left, mine[left]), (cut.right, mine[~left])]
        return found


def _offset(points: Floats, at: Point, angle: float) -> Floats:
    """Distance (n,) of points (n, 2) to the left of a line."""
    x, y = (points - at).T
    return np.cos(angle) * y - np.sin(angle) * x


def find_cuts(domain: Domain, spacing: Spacing, expected_nodes: float, cells: int) -> Cuts:
    """Cut a domain into cells of the same work, as nearly as short and clear cuts allow."""
    samples = leaves(domain, spacing, max(COARSEST, float(np.sqrt(expected_nodes / (SAMPLES * cells)))))
    return _Cutter(domain, spacing).cuts(samples, cells, expected_nodes)


@record
class _Piece:
    """Area that is left to cut into so many cells: its leaves, within a convex polygon (k, 2)."""

    samples: Leaves
    orders: tuple[Integers, ...]  # of the leaves, for each direction: from the left on
    polygon: Floats
    cells: int

    def part(self, mine: Booleans, polygon: Floats, cells: int) -> "_Piece":
        """The piece with some of the leaves (n,)."""
        number = np.cumsum(mine) - 1
        orders = tuple(number[order[mine[order]]] for order in self.orders)
        return _Piece(Leaves(*(column[mine] for column in self.samples)), orders, polygon, cells)


class _Choice(NamedTuple):
    """A cut that may be made."""

    at: Point
    angle: float
    length: float  # estimated, in bubbles
    off: float  # share of the work on the wrong side
    through: Floats = np.zeros((0, 2))  # (k, 2): bubbles on walls and lines that it runs through


class _Met(NamedTuple):
    """Chords that a line crosses."""

    chord: Integers  # (k,): their numbers
    at: Floats  # (k, 2): where


class _Cutter:
    def __init__(self, domain: Domain, spacing: Spacing) -> None:
        self.spacing = spacing
        chords = domain.boundary.chords()
        self._chords = np.stack([chords.start, chords.end], axis=1)
        self._corners = domain.boundary.corners
        self._sizes = spacing.extended(self._corners)
        self._area = domain.polygon
        self._domain = domain
        self._sides = CutPeriodicSides.of(domain, spacing)
        self._landings = Landings.of(domain, spacing)

    def cuts(self, samples: Leaves, cells: int, expected_nodes: float) -> Cuts:
        """The tree of cuts."""
        x0, y0, x1, y1 = self._domain.bounds
        around = BEYOND_DOMAIN * self._domain.size
        box = np.array(shapely.box(x0 - around, y0 - around, x1 + around, y1 + around).exterior.coords)[:-1]
        total = float((samples.sides**2 / samples.d**2).sum())
        made = list[Cut]()
        lines = list[OpenPath]()
        work = list[float]()
        heights = (_offset(samples.centers, ORIGIN, angle) for angle in ANGLES)
        orders = tuple(np.argsort(-height, kind="stable") for height in heights)
        queue = [(_Piece(samples, orders, box, cells), -1, True)]
        for piece, parent, left in queue:
            if piece.cells == 1:
                number = -1 - len(work)
                work.append(float((piece.samples.sides**2 / piece.samples.d**2).sum()) * expected_nodes / total)
            else:
                number = len(made)
                choice = self._chosen(piece)
                made.append(Cut(choice.at, choice.angle, 0, 0))
                parts, ends = _cut(piece, choice)
                lines.append(OpenPath((Side(Line(*ends)),), ends, CUT))
                self._add(ends)
                queue += [(parts[0], number, True), (parts[1], number, False)]
            if parent >= 0:
                before = made[parent]
                made[parent] = before._replace(left=number) if left else before._replace(right=number)
        return Cuts(tuple(made), tuple(lines), len(work), np.array(work))

    def _add(self, ends: tuple[Point, Point]) -> None:
        """A cut is a wall for those that follow."""
        self._chords = np.concatenate([self._chords, [ends]])
        crossed = shapely.get_coordinates(shapely.intersection(shapely.linestrings(ends), self._area.boundary))
        x0, y0, x1, y1 = self._domain.bounds  # the box is around these: what is within ends at another cut
        on_cuts = np.array([(x, y) for x, y in ends if x0 <= x <= x1 and y0 <= y <= y1]).reshape(-1, 2)
        self._landings = self._landings.with_ends(on_cuts, self.spacing.extended(on_cuts))
        new = np.concatenate([ends, crossed])
        self._corners = np.concatenate([self._corners, new])
        self._sizes = np.concatenate([self._sizes, self.spacing.extended(new)])
        self._sides = self._sides.with_cut(np.array(ends))

    def _chosen(self, piece: _Piece) -> _Choice:
        """The best cut of a piece; CaseError if none divides it."""
        dividing = (choice for choice in _choices(piece) if _divides(piece.polygon, choice))
        choices = sorted(dividing, key=lambda choice: choice.length)[:LOOKED_AT]
        if not choices:
            where = place(piece.polygon.mean(axis=0))
            with at_key("parts"):
                raise CaseError(f"around {where} are too few nodes for {piece.cells} parts: ask for fewer")
        choices.sort(key=lambda choice: self._cost(piece, choice))
        best, widest = choices[0], -1.0
        for near in chain.from_iterable(self._beside_sides(piece, self._clear(piece, choice)) for choice in choices):
            apart = self._sides.apart(np.array(_divided(piece.polygon, near)[2]))
            if apart > widest:
                best, widest = near, apart
            if apart == np.inf:
                break
        return best

    def _clear(self, piece: _Piece, choice: _Choice) -> _Choice:
        """The cut moved to meet walls at bubbles, or else away from corners."""
        landed = self._landed(piece, choice)
        return landed if self._clearance(landed) == 0 else _aside(choice, self._clearance(choice))

    def _beside_sides(self, piece: _Piece, choice: _Choice) -> Iterator[_Choice]:
        """The cut, and cuts near to it that may meet periodic sides better, nearest first."""
        yield choice
        middle = np.mean(_divided(piece.polygon, choice)[2], axis=0)
        d = float(self.spacing.extended(middle[None])[0])
        for shift in ASIDES:
            moved = _aside(choice, shift * d)
            if not _divides(piece.polygon, moved):
                continue
            ends = np.array(_divided(piece.polygon, moved)[2])
            for line in chain(self._sides.lines(ends), [ends] if shift else []):
                near = _through(choice, line)
                if _still_even(piece, near) and not self._slips(piece, near):
                    yield near

    def _landed(self, piece: _Piece, choice: _Choice) -> _Choice:
        """The cut moved and turned a little, to meet walls and lines at bubbles that they have without it.

        Other cuts it meets where these are met from their other side, if that is near.
        """
        met = self._met(np.array(_divided(piece.polygon, choice)[2]))
        way = np.array([np.cos(choice.angle), np.sin(choice.angle)])
        landing = self._landings.near(np.array(choice.at), way, met.at)
        if landing is None or (landing.through[:, None] == piece.polygon).all(axis=2).any():
            return choice
        turned = choice.angle + float(np.arctan(landing.slope))
        landed = choice._replace(at=as_point(landing.through[0]), angle=turned, through=landing.through)
        return landed if _still_even(piece, landed) else choice

    def _clearance(self, choice: _Choice) -> float:
        """How far a cut has to move aside to pass no corner, but those on its way, so near that it might be a slip."""
        near = ASIDE * NEARLY * self._domain.size
        others = self._corners[~(self._corners[:, None] == choice.through).all(axis=2).any(axis=1)]
        off = _offset(others, choice.at, choice.angle)
        return next(k * near for k in range(len(off) + 2) if (np.abs(off - k * near) > near / 2).all())

    def _slips(self, piece: _Piece, choice: _Choice) -> bool:
        """Whether a cut passes corners, between its ends, so near that it might be a slip, and not through them."""
        near = ASIDE * NEARLY * self._domain.size
        start, end = np.array(_divided(piece.polygon, choice)[2])
        length = float(np.hypot(*(end - start)))
        along = (self._corners - start) @ (end - start) / length
        off = np.abs(_offset(self._corners, choice.at, choice.angle))
        beside = (along > -near) & (along < length + near)
        return bool((beside & (off > TOUCHING * self._domain.size) & (off < near / 2)).any())

    def _cost(self, piece: _Piece, choice: _Choice) -> float:
        """Bubbles along a cut, and what its crossings and what is near it are worth."""
        ends = np.array(_divided(piece.polygon, choice)[2])
        share = (np.arange(POINTS) + 0.5) / POINTS
        points = ends[0] + share[:, None] * (ends[1] - ends[0])
        inside = self._domain.contains(points)
        d = self.spacing.towards(points[inside], np.broadcast_to(ends[1] - ends[0], (int(inside.sum()), 2)))
        step = float(np.hypot(*(ends[1] - ends[0]))) / POINTS
        bubbles = float((step / d).sum())
        return bubbles * (1 + UNEVEN * choice.off) + self._crossings(ends) + self._near(ends)

    def _crossings(self, ends: Floats) -> float:
        """Cost of a line's crossings between its ends (2, 2), by their angles; the line ends at earlier cuts."""
        way = ends[1] - ends[0]
        other = np.diff(self._chords[self._met(ends).chord], axis=1)[:, 0]
        cosine = np.abs(other @ way) / (np.hypot(*other.T) * np.hypot(*way))
        return float((CROSSING + OBLIQUE * cosine**2).sum())

    def _met(self, ends: Floats) -> _Met:
        """The chords that a line crosses between its ends (2, 2), or there."""
        ux, uy = ends[1] - ends[0]
        ax, ay = ends[0]
        side = ux * (self._chords[..., 1] - ay) - uy * (self._chords[..., 0] - ax)
        across = np.flatnonzero(side[:, 0] * side[:, 1] < 0)
        crossed, side = self._chords[across], side[across]
        share = side[:, :1] / (side[:, :1] - side[:, 1:])
        at = crossed[:, 0] + share * (crossed[:, 1] - crossed[:, 0])
        along = ((at - ends[0]) @ (ux, uy)) / (ux * ux + uy * uy)
        within = (along > -MEETING) & (along < 1 + MEETING)
        return _Met(across[within], at[within])

    def _near(self, ends: Floats) -> float:
        """Cost of the corners near a line between its ends (2, 2)."""
        (ux, uy), length = ends[1] - ends[0], float(np.hypot(*(ends[1] - ends[0])))
        x, y = (self._corners - ends[0]).T
        along, aside = (ux * x + uy * y) / length, np.abs(ux * y - uy * x) / length
        room = np.where((along >= 0) & (along <= length), aside / self._sizes, np.inf)
        return float(NEAR * np.clip(1 - room / CLEAR, 0, 1).sum())


def _aside(choice: _Choice, shift: float) -> _Choice:
    """The cut moved to the left."""
    x, y = choice.at
    return choice._replace(at=as_point((x - shift * np.sin(choice.angle), y + shift * np.cos(choice.angle))))


def _through(choice: _Choice, line: Floats) -> _Choice:
    """The cut along a line through two points (2, 2), in its own direction."""
    x, y = line[1] - line[0]
    angle = float(np.arctan2(y, x))
    turned = angle + np.pi * round((choice.angle - angle) / np.pi)
    return choice._replace(at=as_point(line[0]), angle=turned, through=np.zeros((0, 2)))


def _choices(piece: _Piece) -> Iterator[_Choice]:
    """Cuts that divide the work of a piece about evenly among its cells, in several directions."""
    centers, sides, d = piece.samples
    work = sides**2 / d**2
    bubbles = sides / d
    half = sides / 2
    total = work.sum()
    goal = (piece.cells // 2) / piece.cells
    for angle, order in zip(ANGLES, piece.orders, strict=True):
        height = _offset(centers, ORIGIN, angle)
        done = np.cumsum(work[order]) / total
        for shift in SHIFTS:
            first = int(np.searchsorted(done, goal + shift / piece.cells * 2))
            if not 0 < first < len(order):
                continue
            middle = float(height[order[first - 1 : first + 1]].mean())
            crossed = np.abs(height - middle) < half
            at = as_point(middle * np.array([-np.sin(angle), np.cos(angle)]))
            yield _Choice(at, angle, float(bubbles[crossed].sum()), abs(float(shift)))


def _cut(piece: _Piece, choice: _Choice) -> tuple[tuple[_Piece, _Piece], tuple[Point, Point]]:
    """The pieces on the left and on the right of a cut, and the two ends of it."""
    left = _offset(piece.samples.centers, choice.at, choice.angle) > 0
    upper, lower, ends = _divided(piece.polygon, choice)
    few = piece.cells // 2
    return (piece.part(left, upper, few), piece.part(~left, lower, piece.cells - few)), ends


def _divides(corners: Floats, choice: _Choice) -> bool:
    """Whether corners (k, 2) of a convex polygon are on both sides of a cut."""
    left = _offset(corners, choice.at, choice.angle) > 0
    return bool(left.any() and not left.all())


def _still_even(piece: _Piece, choice: _Choice) -> bool:
    """Whether a cut that was moved divides the work of a piece about as evenly among its cells as one that was not."""
    work = piece.samples.sides**2 / piece.samples.d**2
    left = _offset(piece.samples.centers, choice.at, choice.angle) > 0
    few = piece.cells // 2
    each = np.array([work[left].sum() / few, work[~left].sum() / (piece.cells - few)])
    return bool(_divides(piece.polygon, choice) and each.min() >= EVEN * each.max())


def _divided(corners: Floats, choice: _Choice) -> tuple[Floats, Floats, tuple[Point, Point]]:
    """Polygons on the left and on the right of a cut through a convex one (k, 2), and the two ends of the cut."""
    off = _offset(corners, choice.at, choice.angle)
    upper, lower, ends = list[Floats](), list[Floats](), list[Floats]()
    for k in range(len(corners)):
        (upper if off[k] > 0 else lower).append(corners[k])
        following = (k + 1) % len(corners)
        if (off[k] > 0) != (off[following] > 0):
            share = off[k] / (off[k] - off[following])
            ends.append(corners[k] + share * (corners[following] - corners[k]))
            upper.append(ends[-1])
            lower.append(ends[-1])
    return np.array(upper), np.array(lower), (as_point(ends[0]), as_point(ends[1]))
