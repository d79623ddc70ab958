"""Inner parts of a domain: regions, embedded lines and points, matching sides; and the check that regions fit."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import field, replace
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Floats, Integers, each_once, ring_area
from bubblemesh.errors import GeometryError, Key, about
from bubblemesh.geometry.arrangement import TOUCHING
from bubblemesh.geometry.arrangement.bellies import bellies
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.paths import Area, InnerPoint, Line, OpenPath, Point, Ring
from bubblemesh.geometry.similarity import Similarity
from bubblemesh.geometry.validity import explained, simple_polygon
from bubblemesh.records import Uncached, record

RIM_OF_A_CURVE = 1e-4  # of a region's extent: bound for the error of the chords of its polygonal copy


class RegionsAround(NamedTuple):
    """Points, and indices of the regions around them."""

    point: Integers  # (m,)
    region: Integers  # (m,)


@record
class Region(Uncached):
    """A part of the domain: an area with a name, and a label for those of its sides that have none."""

    area: Area
    name: str
    label: str
    entry: int = 0  # number, from 0, of the case's entry that gives it: a file gives several
    named: bool = True  # whether the labels of its sides were given for them: those of neighbours in a file name these
    order: int = 0  # among the regions of its entry
    cut: bool = False  # whether it is a part of what a case gives, of which later regions cover the rest

    @property
    def key(self) -> Key:
        """Key of the case that gives the region."""
        return self.area.outer.key

    @cached_property
    def polygon(self) -> shapely.Polygon:
        """Fine polygonal copy."""
        outer, *holes = (self._checked(ring) for ring in self.area.rings)
        polygon = shapely.Polygon(outer.exterior, [hole.exterior for hole in holes])
        if not polygon.is_valid:
            with about(self.key):
                where = explained(polygon)[1]
                raise GeometryError(f"holes of region {self.name!r} cross its ring or each other at {where}: move them")
        shapely.prepare(polygon)
        return polygon

    def _checked(self, ring: Ring) -> shapely.Polygon:
        origin = f" ({ring.origin})" if ring.origin else ""
        with about(ring.key):
            return simple_polygon(ring.outline, f"the ring of region {self.name!r}{origin}")

    @property
    def paths(self) -> Iterator[OpenPath]:
        """The rings as paths, whose edges belong to the inside of the region."""
        for ring in self.area.rings:
            is_hole = ring is not self.area.outer
            clockwise = ring_area(ring.outline) < 0
            path = OpenPath.around(ring, self.label)
            yield replace(path, sides_named=self.named, turned=clockwise != is_hole)

    @property
    def straight(self) -> bool:
        """Whether it has straight sides only."""
        return all(isinstance(side.curve, Line) for ring in self.area.rings for side in ring.sides)

    @property
    def core(self) -> shapely.Geometry:
        """The region without its rim."""
        return self._bands[0]

    @property
    def reach(self) -> shapely.Geometry:
        """The region with its rim."""
        return self._bands[1]

    @cached_property
    def _bands(self) -> tuple[shapely.Geometry, shapely.Geometry]:
        """Core and reach; the rim of a curved region is as wide as the error of its chords."""
        x0, y0, x1, y1 = self.polygon.bounds
        width = (TOUCHING if self.straight else RIM_OF_A_CURVE) * max(x1 - x0, y1 - y0)
        bands = self.polygon.buffer(-width, join_style="mitre"), self.polygon.buffer(width, join_style="mitre")
        for band in bands:
            shapely.prepare(band)
        return bands


@record
class Seed:
    """A point in a region that rings and lines enclose around it. Errors are about its key in the case."""

    at: Point
    name: str  # of the region
    key: Key = field(default=Key(), compare=False)
    entry: int = 0  # number, from 0, of the case's entry that gives it
    optional: bool = False  # whether it is left out where it lies outside of the domain
    notes: tuple[str, ...] = ()  # on what was changed on reading, for the user to know

    def moved(self, by: Similarity) -> "Seed":
        """The point where a similarity takes it."""
        return replace(self, at=by.point(self.at))

    def relabelled(self, name: Callable[[str | None], str]) -> "Seed":
        """The point with another name of its region."""
        return replace(self, name=name(self.name))

    def as_optional(self) -> "Seed":
        """The point, which may lie outside of the domain."""
        return replace(self, optional=True)


class RestPart(NamedTuple):
    """A part of the domain that no region is in, between lines and rings: a place in it, and its area."""

    at: Point
    area: float


class RestParts(NamedTuple):
    """The parts that no region is in: their number, and of very many the largest ones and the smallest, in order."""

    number: int
    parts: tuple[RestPart, ...]


NOTHING = RestParts(0, ())


@record
class InnerParts:
    """Regions, embedded lines and points, and periodic sides: everything in a domain apart from its rings.

    Regions are numbered from 1; region 0 is the rest of the domain. Where regions are nested, the innermost counts.
    Several regions may have the same name.
    """

    regions: tuple[Region, ...] = ()
    rest: str = "domain"  # name of region 0
    rest_named: bool = False  # whether that was given
    rest_parts: RestParts = NOTHING  # of region 0, if there were seeds
    lines: tuple[OpenPath, ...] = ()
    points: tuple[InnerPoint, ...] = ()
    periodic: tuple[tuple[str, str], ...] = ()  # pairs of labels of sides whose nodes match
    periodic_tolerance: float = 0.0  # by how much these may differ: the second one becomes the first one moved
    seeds: tuple[Seed, ...] = ()  # points in further regions, of which the domain makes regions
    remarks: tuple[str, ...] = ()  # notes on lines and points that were left out
    left_out: dict[str, Point] = field(default_factory=dict)  # labels of these, with a place of each

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on what was changed on reading."""
        inside = (*(ring.notes for ring in self.rings), *(path.notes for path in self.lines))
        return (*self.remarks, *(note for some in inside for note in some))

    def __bool__(self) -> bool:
        return bool(self.regions or self.lines or self.points or self.seeds)

    @cached_property
    def paths(self) -> tuple[OpenPath, ...]:
        """Embedded lines, then the rings of regions: the inner pieces of path k have the ring number -1 - k."""
        return *self.lines, *(path for region in self.regions for path in region.paths)

    @property
    def rings(self) -> list[Ring]:
        """Rings of all regions."""
        return [ring for region in self.regions for ring in region.area.rings]

    @property
    def region_of_path(self) -> Integers:
        """Number (k,) of the region that each of the paths is a ring of, and 0 for embedded lines."""
        rings = [len(region.area.rings) for region in self.regions]
        return np.repeat(np.arange(len(rings) + 1), [len(self.lines), *rings])

    @cached_property
    def keys_at(self) -> dict[Point, Key]:
        """Keys of the case that give the vertices and embedded points, by their coordinates."""
        vertices = {vertex: path.key for path in self.paths for vertex in path.vertices}
        return vertices | {point.at: point.key for point in self.points}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of region 0 and the others, each once."""
        return tuple(dict.fromkeys((self.rest, *(region.name for region in self.regions))))

    @property
    def name_indices(self) -> Integers:
        """Index (r + 1,) into ``names`` for region 0 and the others."""
        number = {name: k for k, name in enumerate(self.names)}
        return np.array([0, *(number[region.name] for region in self.regions)])


def _region_polygons(boundary: Boundary, parts: InnerParts) -> list[shapely.Polygon]:
    """The regions as polygons of the chords of the noded pieces, so that common sides are the same in each."""
    chords = boundary.chords()
    path = -1 - boundary.ring[chords.piece]
    order = np.argsort(path, kind="stable")
    bounds = np.searchsorted(path[order], np.arange(len(parts.lines), len(parts.paths) + 1))
    rings = iter([chords.start[order[a:b]] for a, b in pairwise(bounds)])
    areas = [shapely.Polygon(next(rings), [next(rings) for _ in region.area.holes]) for region in parts.regions]
    for area in areas:
        shapely.prepare(area)
    return areas


def regions_around(points: Floats, boundary: Boundary, parts: InnerParts) -> RegionsAround:
    """The regions around points (n, 2), by the pieces of a noded boundary.

    Points that are between a chord and its curve are on the other side of the region's rim than in its polygon.
    """
    areas = np.array(_region_polygons(boundary, parts), dtype=object)
    region, point = shapely.STRtree(shapely.points(points)).query(areas, predicate="contains")
    beside = bellies(boundary, points)
    inner = boundary.inner[beside.piece]
    of = parts.region_of_path[-1 - boundary.ring[beside.piece[inner]]] - 1
    pairs = np.append(point * len(areas) + region, (beside.point[inner] * len(areas) + of)[of >= 0])
    pair, count = np.unique(pairs, return_counts=True)
    return RegionsAround(*np.divmod(pair[count % 2 == 1], max(len(areas), 1)))


def overlapping(around: RegionsAround, count: int) -> tuple[int, int, bool] | None:
    """The first two of ``count`` regions that overlap, but not by one being inside the other; whether they are equal.

    ``around`` has the regions on the sides of all pieces: two of them have something in common if a side is in both,
    and each has something of its own if a side is in it, but not in the other.
    """
    if len(around.point) == len(each_once(around.point)):
        return None
    from scipy.sparse import csr_array  # takes longer to load than most cases take to mesh

    sides = int(around.point.max()) + 1
    inside = csr_array((np.ones(len(around.point), np.int64), around), shape=(sides, count))
    common = (inside.T @ inside).tocoo()
    i, j, both = common.row, common.col, common.data
    rest_i, rest_j = (np.bincount(around.region, minlength=count)[number] - both for number in (i, j))
    found = np.flatnonzero((i < j) & ((rest_i > 0) == (rest_j > 0)))
    if len(found) == 0:
        return None
    k = found[np.lexsort((j[found], i[found]))[0]]
    return int(i[k]), int(j[k]), not rest_i[k]


def region_at(points: Floats, areas: Sequence[shapely.Polygon]) -> Integers:
    """Number (n,) of the innermost region at points (n, 2); 0 outside of all regions."""
    region, point = shapely.STRtree(shapely.points(points)).query(np.array(areas, dtype=object), predicate="contains")
    return innermost(RegionsAround(point, region), len(points), shapely.area(areas))


def innermost(around: RegionsAround, count: int, sizes: Floats | Integers) -> Integers:
    """Number (n,) of the smallest of the regions around each of ``count`` points, by sizes (r,); 0 outside of all."""
    found = np.zeros(count, np.int64)
    order = np.argsort(-sizes[around.region], kind="stable")  # smaller ones are written later
    found[around.point[order]] = around.region[order] + 1
    return found
