"""Spacings that count within regions: their own ones, and limits by their names."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers, members
from bubblemesh.errors import Key
from bubblemesh.geometry.arrangement.regions import Region
from bubblemesh.records import Uncached, record
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.terms.combination import Term

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


class Found(NamedTuple):
    """Points, in order, and regions that they are in or on the rim of."""

    point: Integers  # (m,)
    region: Integers  # (m,)
    inside: Booleans  # (m,): off the rim


@record
class Located(Uncached):
    """Regions, of which there may be hundreds, that are found at points."""

    regions: tuple[Region, ...]

    @cached_property
    def _cores(self) -> Floats:
        return np.array([region.core for region in self.regions], dtype=object)

    @cached_property
    def _reaches(self) -> Floats:
        return np.array([region.reach for region in self.regions], dtype=object)

    @cached_property
    def _boxes(self) -> Boxes:
        return Boxes.of(shapely.bounds(self._reaches))

    def __call__(self, x: Floats, y: Floats) -> Found:
        """The regions at points with coordinates x (n,) and y (n,)."""
        if not self.regions:
            return Found(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0, bool))
        point, region = self._boxes.holding(x, y)
        within = shapely.contains_xy(self._reaches[region], x[point], y[point])
        point, region = point[within], region[within]
        return Found(point, region, shapely.contains_xy(self._cores[region], x[point], y[point]))


class RegionLimit(NamedTuple):
    """The largest spacing within all regions of a name, and its key in the case."""

    name: str
    spacing: Spacing
    key: Key


@record
class RegionLimits(Uncached):
    """Largest spacings within regions by their names, of which none counts within smaller regions of another name.

    On the rim the smaller one of both sides counts. The limit of a name that no region has counts outside of all.
    """

    located: Located
    limits: tuple[RegionLimit, ...]  # at least one

    @cached_property
    def _names(self) -> Integers:
        """Number (r,) of the name of each region."""
        numbers: dict[str, int] = {}
        return np.array([numbers.setdefault(region.name, len(numbers)) for region in self.located.regions], np.int64)

    @cached_property
    def _limit_of(self) -> Integers:
        """Limit (r,) of the name of each region, -1 for none."""
        known = {limit.name: number for number, limit in enumerate(self.limits)}
        return np.array([known.get(region.name, -1) for region in self.located.regions], np.int64)

    @cached_property
    def _areas(self) -> Floats:
        return np.array([region.polygon.area for region in self.located.regions])

    @cached_property
    def _widest(self) -> Floats:
        """Area (r,) of the largest region that has the name of each region."""
        widest = np.zeros(len(self._names))
        np.maximum.at(widest, self._names, self._areas)
        return widest[self._names]

    @cached_property
    def _outside(self) -> list[int]:
        """Limits that count outside of all regions."""
        names = {region.name for region in self.located.regions}
        return [number for number, limit in enumerate(self.limits) if limit.name not in names]

    @cached_property
    def _functions(self) -> Integers:
        """Number of each limit's function among those that differ."""
        return _numbered(limit.spacing.function for limit in self.limits)

    @property
    def costly(self) -> bool:
        """Whether one of the limits takes long."""
        return any(limit.spacing.costly for limit in self.limits)

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Values (n,) at x (n,) and y (n,), infinite where there is no limit."""
        point, limit = self._found(x, y)
        values = np.full(len(x), np.inf)
        with np.errstate(invalid="ignore"):  # what is no number stays none
            np.minimum.at(values, point, self._values(x[point], y[point], limit))
        return values

    def keys(self, points: Floats) -> list[Key]:
        """Keys (n) of the limits that have the value at points (n, 2)."""
        x, y = points.T
        point, limit = self._found(x, y)
        d, mine = self(x, y)[point], self._values(x[point], y[point], limit)
        having = (mine == d) | (np.isnan(mine) & np.isnan(d))
        keys = [self.limits[0].key] * len(points)
        for k, number in zip(point[having].tolist(), limit[having].tolist(), strict=True):
            keys[k] = self.limits[number].key
        return keys

    def _found(self, x: Floats, y: Floats) -> tuple[Integers, Integers]:
        """Points and the limits (m,) that count there."""
        point, region, inside = self.located(x, y)
        name = self._names[region]
        # The smallest region around each point, and the smallest one of another name.
        smallest, next_one, of = np.full(len(x), np.inf), np.full(len(x), np.inf), np.full(len(x), -1)
        at, area = point[inside], self._areas[region[inside]]
        np.minimum.at(smallest, at, area)
        first = area == smallest[at]
        of[at[first]] = name[inside][first]
        other = name[inside] != of[at]
        np.minimum.at(next_one, at[other], area[other])
        others = np.where(of[point] == name, next_one[point], smallest[point])
        mine = (self._limit_of[region] >= 0) & (others >= self._widest[region])
        points, limits = [point[mine]], [self._limit_of[region[mine]]]
        for number in self._outside:
            points.append(np.flatnonzero(np.isinf(smallest)))
            limits.append(np.full(len(points[-1]), number))
        return np.concatenate(points), np.concatenate(limits)

    def _values(self, x: Floats, y: Floats, limit: Integers) -> Floats:
        return _each(x, y, self._functions[limit], lambda k: self.limits[int(limit[k])].spacing.function)


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
    def _located(self) -> Located:
        return Located(tuple(one.region for one in self.own))

    @cached_property
    def _functions(self) -> Integers:
        """Number of each region's function among those that differ."""
        return _numbered(one.spacing.function for one in self.own)

    @property
    def costly(self) -> bool:
        """Whether one of the spacings takes long."""
        return self.rest.costly or any(one.spacing.costly for one in self.own)

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Values (n,) at points with coordinates x (n,) and y (n,)."""
        d = np.broadcast_to(np.asarray(self.rest.function(x, y), float), np.shape(x)).copy()
        point, region, inside = self._located(x, y)
        own = self._values(x[point], y[point], region)
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
        point, region, _ = self._located(x, y)
        d, own = self(x, y)[point], self._values(x[point], y[point], region)
        having = (own == d) | (np.isnan(own) & np.isnan(d))
        keys = list(self.rest.keys(points))
        for k, number in zip(point[having].tolist(), region[having].tolist(), strict=True):
            keys[k] = self.own[number].key  # of several the last one, which is the innermost
        return keys

    def _values(self, x: Floats, y: Floats, region: Integers) -> Floats:
        return _each(x, y, self._functions[region], lambda k: self.own[int(region[k])].spacing.function)


def _numbered(functions: Iterable[Term]) -> Integers:
    """Number (f,) of each function among those that differ."""
    numbers: dict[int, int] = {}
    return np.array([numbers.setdefault(id(function), len(numbers)) for function in functions], np.int64)


def _each(x: Floats, y: Floats, number: Integers, function_of: Callable[[int], Term]) -> Floats:
    """Values (m,) at x (m,) and y (m,) of functions by their numbers (m,), each evaluated once.

    ``function_of`` returns the function of a point by the point's number.
    """
    values = np.empty(len(number))
    for each, first in zip(*np.unique(number, return_index=True), strict=True):
        mine = number == each
        values[mine] = function_of(int(first))(x[mine], y[mine])
    return values
