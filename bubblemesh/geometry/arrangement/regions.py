"""Inner parts of a domain: regions, embedded lines and points, matching sides; and the check that regions fit."""

from collections.abc import Sequence
from functools import cached_property
from itertools import pairwise

import numpy as np
import shapely

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import GeometryError, Key, about
from bubblemesh.geometry.arrangement import NEARLY, TOUCHING
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.paths import Area, InnerPoint, Line, OpenPath, Point, Ring
from bubblemesh.geometry.validity import explained, first_place, simple_polygon
from bubblemesh.records import Uncached, record

RIM_OF_A_CURVE = 1e-4  # of a region's extent: bound for the error of the chords of its polygonal copy
BELLY = 0.01  # of the square of a chord's length: bound for the area between it and its curve


@record
class Region(Uncached):
    """A part of the domain: an area with a name, and a label for those of its sides that have none."""

    area: Area
    name: str
    label: str
    entry: int = 0  # number, from 0, of the case's entry that gives it: a file gives several

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
        straight = all(isinstance(side.curve, Line) for ring in self.area.rings for side in ring.sides)
        x0, y0, x1, y1 = self.polygon.bounds
        width = (TOUCHING if straight else RIM_OF_A_CURVE) * max(x1 - x0, y1 - y0)
        bands = self.polygon.buffer(-width, join_style="mitre"), self.polygon.buffer(width, join_style="mitre")
        for band in bands:
            shapely.prepare(band)
        return bands


@record
class InnerParts:
    """Regions, embedded lines and points, and periodic sides: everything in a domain apart from its rings.

    Regions are numbered from 1; region 0 is the rest of the domain. Where regions are nested, the innermost counts.
    Several regions may have the same name.
    """

    regions: tuple[Region, ...] = ()
    rest: str = "domain"  # name of region 0
    lines: tuple[OpenPath, ...] = ()
    points: tuple[InnerPoint, ...] = ()
    periodic: tuple[tuple[str, str], ...] = ()  # pairs of labels of sides whose nodes match
    remarks: tuple[str, ...] = ()  # notes on lines and points that were left out

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on what was changed on reading."""
        inside = (*(ring.notes for ring in self.rings), *(path.notes for path in self.lines))
        return (*self.remarks, *(note for some in inside for note in some))

    def __bool__(self) -> bool:
        return bool(self.regions or self.lines or self.points)

    @cached_property
    def paths(self) -> tuple[OpenPath, ...]:
        """Embedded lines, then the rings of regions: the inner pieces of path k have the ring number -1 - k."""
        around = [OpenPath.around(ring, region.label) for region in self.regions for ring in region.area.rings]
        return *self.lines, *around

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


def region_polygons(boundary: Boundary, parts: InnerParts) -> list[shapely.Polygon]:
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


def slack_of(boundary: Boundary, parts: InnerParts, size: float) -> Floats:
    """Possible error (r,) of the area of each region's polygon, along its rim."""
    piece, _, step = boundary.stations()
    off = NEARLY * size * step + np.where(boundary.curved[piece], BELLY * step**2, 0)
    inner = boundary.inner[piece]
    number = parts.region_of_path[-1 - boundary.ring[piece[inner]]]
    total = np.bincount(number, off[inner], minlength=len(parts.regions) + 1)
    return np.asarray(total[1:], float)


def require_regions_apart(areas: Sequence[shapely.Polygon], names: Sequence[str], slack: Floats) -> None:
    """Check that regions overlap only by one being inside the other; GeometryError with the names and a place."""
    shapes = np.array(areas, dtype=object)
    i, j = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    i, j = i[i < j], j[i < j]
    common = shapely.intersection(shapes[i], shapes[j])
    off = slack[i] + slack[j]
    shared = shapely.area(common)
    size = shapely.area(shapes)
    overlapping = (shared > off) & (shared < np.minimum(size[i], size[j]) - off)
    same = shared >= np.maximum(size[i], size[j]) - off
    for k in np.flatnonzero(overlapping | same):
        names_of_both = f"regions {names[i[k]]!r} and {names[j[k]]!r}"
        where = first_place(shapely.point_on_surface(common[k]))
        if same[k]:
            raise GeometryError(f"{names_of_both} at {where} are the same: remove one of them")
        raise GeometryError(f"{names_of_both} overlap at {where}: give them a common side")


def region_at(points: Floats, areas: Sequence[shapely.Polygon]) -> Integers:
    """Number (n,) of the innermost region at points (n, 2); 0 outside of all regions."""
    found = np.zeros(len(points), np.int64)
    if len(areas) == 0:
        return found
    number, point = shapely.STRtree(shapely.points(points)).query(np.array(areas, dtype=object), predicate="contains")
    order = np.argsort(-shapely.area(areas)[number], kind="stable")  # smaller areas are written later
    found[point[order]] = number[order] + 1
    return found
