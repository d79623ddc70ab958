"""Region terms: spacings that count within regions."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers, members
from bubblemesh.errors import Key
from bubblemesh.geometry.arrangement.regions import Region
from bubblemesh.geometry.uncached import Uncached
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.terms.combination import Term, costly

Inside = Callable[[Floats, Floats], Booleans]  # which points, given as x (n,) and y (n,), lie in some set
FINEST = 256  # cells along each side of the grid
PER_BOX = 2  # cells along each side for each box along it


@record
class Boxes:
    """Boxes, listed by the cells of a grid that they reach into."""

    bounds: Floats  # (b, 4): x0, y0, x1, y1 of each box
    low: Floats  # (2,): corner of the grid
    step: Floats  # (2,): size of its cells
    cells: int  # number along each side
    first: Integers  # (cells**2 + 1,): where the boxes of each cell begin
    box: Integers  # (e,): boxes, cell by cell

    @classmethod
    def of(cls, bounds: Floats) -> "Boxes":
        """Grid over boxes (b, 4), at least one."""
        low, high = bounds[:, :2].min(axis=0), bounds[:, 2:].max(axis=0)
        cells = min(PER_BOX * int(np.ceil(np.sqrt(len(bounds)))), FINEST)
        step = np.maximum((high - low) / cells, np.finfo(float).tiny)
        begin, end = (np.clip((edge - low) // step, 0, cells - 1).astype(int) for edge in np.split(bounds, 2, axis=1))
        wide, tall = (end - begin + 1).T
        count = wide * tall
        box, number = members(count)
        cell = (begin[box, 0] + number // tall[box]) * cells + begin[box, 1] + number % tall[box]
        order = np.argsort(cell, kind="stable")
        first = np.searchsorted(cell[order], np.arange(cells**2 + 1))
        return cls(bounds, low, step, cells, first, box[order])

    def holding(self, x: Floats, y: Floats) -> tuple[Integers, Integers]:
        """Numbers (m,) of points, in order, and of boxes that hold them; points have coordinates x (n,) and y (n,)."""
        i, j = (np.floor((c - low) / step) for c, low, step in zip((x, y), self.low, self.step, strict=True))
        i, j = (np.where(k == self.cells, self.cells - 1, k) for k in (i, j))  # the grid's own edge
        near = np.flatnonzero((i >= 0) & (i < self.cells) & (j >= 0) & (j < self.cells))
        cell = (i[near] * self.cells + j[near]).astype(int)
        count = self.first[cell + 1] - self.first[cell]
        entry, rank = members(count)
        point, box = near[entry], self.box[self.first[cell[entry]] + rank]
        x0, y0, x1, y1 = self.bounds[box].T
        held = (x[point] >= x0) & (x[point] <= x1) & (y[point] >= y0) & (y[point] <= y1)
        return point[held], box[held]


@record
class ShapeUnion:
    """The places inside any of some shapes, of which there may be hundreds."""

    shapes: tuple[shapely.Geometry, ...]

    def __reduce__(self) -> tuple[Any, ...]:
        return ShapeUnion.prepared, (self.shapes,)

    @classmethod
    def prepared(cls, shapes: tuple[shapely.Geometry, ...]) -> "ShapeUnion":
        """The union of shapes that are prepared here: those of another process come as mere shapes."""
        for shape in shapes:
            shapely.prepare(shape)
        return cls(shapes)

    @cached_property
    def _boxes(self) -> Boxes:
        return Boxes.of(shapely.bounds(np.array(self.shapes, dtype=object)))

    def __call__(self, x: Floats, y: Floats) -> Booleans:
        """Whether each of the points with coordinates x (n,) and y (n,) is there."""
        inside = np.zeros(len(x), bool)
        if self.shapes:
            point, shape = self._boxes.holding(x, y)
            held = shapely.contains_xy(np.array(self.shapes, dtype=object)[shape], x[point], y[point])
            inside[point[held]] = True
        return inside


@record
class RegionTerm:
    """A term that asks for nothing outside a region."""

    term: Term  # values (n,) at x (n,) and y (n,)
    reach: Inside | None  # points in the region or on its rim; all if there is none
    others: Inside | None = None  # those in other regions, off their rims, that count before this one

    @property
    def costly(self) -> bool:
        """Whether the term takes long."""
        return costly(self.term)

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Values (n,) at x (n,) and y (n,), infinite outside the region and off its rim."""
        mine = np.arange(len(x)) if self.reach is None else np.flatnonzero(self.reach(x, y))
        if self.others is not None:
            mine = mine[~self.others(x[mine], y[mine])]
        values = np.full(len(x), np.inf)
        values[mine] = self.term(x[mine], y[mine])
        return values


class RegionSpacing(NamedTuple):
    """The spacing of a region, and its key in the case."""

    region: Region
    spacing: Spacing
    key: Key


def by_region(rest: Spacing, own: Sequence[RegionSpacing]) -> Spacing:
    """Spacing that is another one in some regions.

    In a region its own spacing counts; on the rim the finest of those that meet there. Of nested regions the innermost
    counts.
    """
    if not own:
        return rest
    regions = _Regions(rest, tuple(sorted(own, key=lambda one: -one.region.polygon.area)))
    return replace(rest, function=regions, keys=regions.keys, costly=regions.costly)


@record
class _Regions(Uncached):
    """Regions with spacings of their own, those within others after them."""

    rest: Spacing
    own: tuple[RegionSpacing, ...]

    @cached_property
    def _cores(self) -> Floats:
        return np.array([one.region.core for one in self.own], dtype=object)

    @cached_property
    def _reaches(self) -> Floats:
        return np.array([one.region.reach for one in self.own], dtype=object)

    @cached_property
    def _boxes(self) -> Boxes:
        return Boxes.of(shapely.bounds(self._reaches))

    @cached_property
    def _functions(self) -> Integers:
        """Number of each region's function among those that differ."""
        numbers: dict[int, int] = {}
        return np.array([numbers.setdefault(id(one.spacing.function), len(numbers)) for one in self.own])

    @property
    def costly(self) -> bool:
        """Whether one of the spacings takes long."""
        return self.rest.costly or any(one.spacing.costly for one in self.own)

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Values (n,) at points with coordinates x (n,) and y (n,)."""
        d = np.broadcast_to(np.asarray(self.rest.function(x, y), float), np.shape(x)).copy()
        point, region = self._found(x, y)
        own = self._own_values(x[point], y[point], region)
        inside = shapely.contains_xy(self._cores[region], x[point], y[point])
        # One region after the other where several have a point: nested ones, or neighbours at their common rim.
        _, rank = members(np.bincount(point))
        for k in range(int(rank.max(initial=-1)) + 1):
            mine = rank == k
            at = point[mine]
            d[at] = np.where(inside[mine], own[mine], np.fmin(d[at], own[mine]))
        return d

    def keys(self, points: Floats) -> list[Key]:
        """Keys (n) of what has the value at points (n, 2)."""
        x, y = points.T
        point, region = self._found(x, y)
        d, own = self(x, y)[point], self._own_values(x[point], y[point], region)
        having = (own == d) | (np.isnan(own) & np.isnan(d))
        keys = list(self.rest.keys(points))
        for k, number in zip(point[having].tolist(), region[having].tolist(), strict=True):
            keys[k] = self.own[number].key  # of several the last one, which is the innermost
        return keys

    def _found(self, x: Floats, y: Floats) -> tuple[Integers, Integers]:
        """Points and the regions (m,) that they are in or on the rim of, in order."""
        point, region = self._boxes.holding(x, y)
        within = shapely.contains_xy(self._reaches[region], x[point], y[point])
        return point[within], region[within]

    def _own_values(self, x: Floats, y: Floats, region: Integers) -> Floats:
        """Values (m,) of the regions' own spacings; regions with the same one are evaluated together."""
        values = np.empty(len(region))
        number = self._functions[region]
        for k in np.unique(number):
            mine = number == k
            function = self.own[int(region[mine][0])].spacing.function
            values[mine] = function(x[mine], y[mine])
        return values
