"""Regions, interfaces and embedded lines: inner pieces, cut where they meet and named by what lies beside them."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
import shapely
from shapely.validation import explain_validity

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.noding import NEARLY, TOUCHING, noded
from bubblemesh.geometry.rings import Line, Ring, Strand
from bubblemesh.wording import place

__all__ = ["Parts", "Region", "partitioned", "region_at"]

RIM_OF_A_CURVE = 1e-4  # of a region's extent: what the chords of its polygonal copy are off at most
ASIDE, ASIDE_OF_A_CURVE = 1e-6, 0.02  # of a chord's length: so far beside a piece its region is looked up
BELLY = 0.01  # of the square of a chord's length: more than the area between it and its curve
NOTHING = 1e-6  # part of a region's area that is none: what a curve's chords are off


@dataclass(frozen=True)
class Region:
    """A part of the domain: a ring with a name, and a label for those of its sides that have none."""

    ring: Ring
    name: str
    label: str

    @cached_property
    def polygon(self) -> shapely.Polygon:
        """Fine polygonal copy."""
        polygon = shapely.Polygon(Boundary.of([self.ring]).polyline().points)
        if not polygon.is_valid:
            where = explain_validity(polygon).partition("[")[2].rstrip("]").split()
            raise GeometryError(
                f"the ring of region {self.name!r} crosses or touches itself at {place([float(v) for v in where])}: "
                "move its points so that it does not"
            )
        shapely.prepare(polygon)
        return polygon

    def core(self, x: Floats, y: Floats) -> Booleans:
        """Which points (n,) are inside and not on the rim."""
        return _within(self._bands[0], x, y)

    def reach(self, x: Floats, y: Floats) -> Booleans:
        """Which points (n,) are inside or on the rim."""
        return _within(self._bands[1], x, y)

    @cached_property
    def _bands(self) -> tuple[shapely.Geometry, shapely.Geometry]:
        """The region without its rim and with it; the rim of a curved one is as wide as its chords are off."""
        straight = all(isinstance(side.curve, Line) for side in self.ring.sides)
        x0, y0, x1, y1 = self.polygon.bounds
        width = (TOUCHING if straight else RIM_OF_A_CURVE) * max(x1 - x0, y1 - y0)
        bands = self.polygon.buffer(-width, join_style="mitre"), self.polygon.buffer(width, join_style="mitre")
        for band in bands:
            shapely.prepare(band)
        return bands


def _within(shape: shapely.Geometry, x: Floats, y: Floats) -> Booleans:
    """Which points (n,) the prepared shape contains; most are outside its bounds."""
    x0, y0, x1, y1 = shapely.bounds(shape)
    result = (x >= x0) & (x <= x1) & (y >= y0) & (y <= y1)
    near = np.flatnonzero(result)
    result[near] = shapely.contains_xy(shape, x[near], y[near])
    return result


@dataclass(frozen=True)
class Parts:
    """What a domain holds beside its rings.

    Attributes
    ----------
    regions : tuple of Region
        Numbered from 1; region 0 is the rest of the domain. Where regions are nested the innermost counts. Several
        may have one name.
    rest : str
        Name of region 0.
    strands : tuple of Strand
        Embedded lines.
    points : tuple of ((x, y), label)
        Embedded points.
    periodic : tuple of (label, label)
        Sides whose nodes match.
    """

    regions: tuple[Region, ...] = ()
    rest: str = "domain"
    strands: tuple[Strand, ...] = ()
    points: tuple[tuple[tuple[float, float], str], ...] = ()
    periodic: tuple[tuple[str, str], ...] = ()

    def __bool__(self) -> bool:
        return bool(self.regions or self.strands or self.points)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of region 0 and the others, each once."""
        return tuple(dict.fromkeys((self.rest, *(region.name for region in self.regions))))

    @property
    def named(self) -> Integers:
        """Index (r + 1,) into ``names`` for region 0 and the others."""
        number = {name: k for k, name in enumerate(self.names)}
        return np.array([0, *(number[region.name] for region in self.regions)])


def partitioned(boundary: Boundary, parts: Parts, polygon: shapely.Polygon) -> Boundary:
    """The boundary with inner pieces, noded, and with the regions on either side of all pieces.

    Rings of regions and embedded lines end at the boundary of the domain; what of them follows it, or another one
    of them, is one piece: of the ring if it can be, else of an embedded line, else of the first region.

    Parameters
    ----------
    boundary : Boundary
        The rings.
    parts : Parts
    polygon : Polygon
        The domain.

    Raises
    ------
    GeometryError
        If regions overlap or lie outside, if nothing is left of a line or a point is not in the domain, or if a
        vertex is next to a line but not on it; with the coordinates.
    """
    x0, y0, x1, y1 = polygon.bounds
    size = max(x1 - x0, y1 - y0)
    outlines = [region.polygon for region in parts.regions]
    _require_inside(parts, outlines, polygon)
    strands = [*parts.strands, *(Strand.around(region.ring, region.label) for region in parts.regions)]
    whole = boundary.joined_by(strands, [point for point, _ in parts.points])
    whole = noded(whole, size, fixed=len(boundary.corners))
    areas = _areas(whole, len(parts.strands), outlines)
    require_apart(areas, [region.name for region in parts.regions], _slack(whole, len(parts.strands), outlines, size))
    whole = _without_doubles(whole, TOUCHING * size)
    whole = _clipped(whole, parts.points, TOUCHING * size)
    _require_lines(whole, parts.strands)
    whole = _sided(whole, areas)
    _require_seen(whole, parts.regions)
    return replace(whole, ring=np.maximum(whole.ring, -1))


def _require_inside(parts: Parts, outlines: Sequence[shapely.Polygon], polygon: shapely.Polygon) -> None:
    for region, outline in zip(parts.regions, outlines, strict=True):
        if not polygon.intersects(outline) or polygon.intersection(outline).area <= NOTHING * outline.area:
            where = place(shapely.get_coordinates(outline)[0])
            raise GeometryError(f"region {region.name!r} at {where} lies outside the domain: move or remove it")


def _areas(boundary: Boundary, lines: int, outlines: Sequence[shapely.Polygon]) -> list[shapely.Polygon]:
    """The regions as polygons of the chords of the noded pieces, so that common sides are the same in each."""
    chords = boundary.chords()
    number = -boundary.ring[chords.piece] - lines
    order = np.argsort(number, kind="stable")
    bounds = np.searchsorted(number[order], np.arange(1, len(outlines) + 2))
    areas = [shapely.Polygon(chords.start[order[a:b]]) for a, b in pairwise(bounds)]
    for area in areas:
        shapely.prepare(area)
    return areas


def _slack(boundary: Boundary, lines: int, outlines: Sequence[shapely.Polygon], size: float) -> Floats:
    """Area (r,) that the polygon of each region may be off along its rim."""
    piece, _, step = boundary.panels()
    off = NEARLY * size * step + np.where(boundary.curved[piece], BELLY * step**2, 0)
    number = -boundary.ring[piece] - lines
    total = np.bincount(np.maximum(number, 0), off, minlength=len(outlines) + 1)
    return np.asarray(total[1:], float)


def require_apart(areas: Sequence[shapely.Polygon], names: Sequence[str], slack: Floats) -> None:
    """Check that regions overlap only by one being inside the other.

    Raises
    ------
    GeometryError
        With the names and a place.
    """
    shapes = np.array(areas, dtype=object)
    i, j = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    i, j = i[i < j], j[i < j]
    common = shapely.intersection(shapes[i], shapes[j])
    off, shared, size = slack[i] + slack[j], shapely.area(common), shapely.area(shapes)
    overlapping = (shared > off) & (shared < np.minimum(size[i], size[j]) - off)
    same = shared >= np.maximum(size[i], size[j]) - off
    for k in np.flatnonzero(overlapping | same):
        names_of_both = f"regions {names[i[k]]!r} and {names[j[k]]!r}"
        where = place(shapely.get_coordinates(shapely.point_on_surface(common[k]))[0])
        if same[k]:
            raise GeometryError(f"{names_of_both} at {where} are the same: remove one of them")
        raise GeometryError(f"{names_of_both} overlap at {where}: give them a common side")


def _without_doubles(boundary: Boundary, tolerance: float) -> Boundary:
    """The boundary without inner pieces that follow another piece, nor such as have no length."""
    low, high = np.sort(np.column_stack([boundary.start, boundary.end]), axis=1).T
    numbers = np.arange(len(boundary.kind))
    middle = boundary.points(numbers, boundary.lengths / 2)
    keep = ~boundary.inner | (low != high) | (boundary.lengths > 10 * tolerance)
    seen: dict[tuple[int, int], list[int]] = defaultdict(list)
    for number in np.lexsort((numbers, np.where(boundary.inner, -boundary.ring, 0))).tolist():
        known = seen[int(low[number]), int(high[number])]
        same = [k for k in known if np.hypot(*(middle[k] - middle[number])) <= 10 * tolerance]
        if same and boundary.inner[number]:
            keep[number] = False
        else:
            known.append(number)
    return boundary.kept(np.flatnonzero(keep))


def _clipped(boundary: Boundary, points: Sequence[tuple[tuple[float, float], str]], tolerance: float) -> Boundary:
    """The boundary without inner pieces outside the domain, and without the corners that only these had.

    Raises
    ------
    GeometryError
        If an embedded point is outside, or where another one is.
    """
    line = boundary.polyline()
    rings = [line.points[line.ring == number] for number in range(int(line.ring.max()) + 1)]
    domain = shapely.Polygon(rings[0], rings[1:])
    shapely.prepare(domain)
    middle = boundary.points(np.arange(len(boundary.kind)), boundary.lengths / 2)
    kept = boundary.kept(np.flatnonzero(~boundary.inner | shapely.contains_xy(domain, middle)))
    open_ = ~kept.closed
    used = np.zeros(len(kept.corners), bool)
    used[kept.start[open_]] = used[kept.end[open_]] = True
    owner: dict[int, str] = {}
    for at, label in points:
        there = np.hypot(*(kept.corners - at).T) <= tolerance
        corner = int(there.argmax())  # a point inside is one by itself
        if corner in owner:
            raise GeometryError(f"the points {owner[corner]!r} and {label!r} are both at {place(at)}: remove one")
        if not (used[there].any() or shapely.contains_xy(domain, *at)):
            raise GeometryError(f"the point {label!r} at {place(at)} lies outside the domain: move or remove it")
        used |= there
        owner[corner] = label
    number = np.cumsum(used) - 1
    ends = [np.where(open_, number[end], -1) for end in (kept.start, kept.end)]
    return replace(kept, start=ends[0], end=ends[1], corners=kept.corners[used])


def _require_lines(boundary: Boundary, strands: Sequence[Strand]) -> None:
    left = set(boundary.ring.tolist())
    for number, strand in enumerate(strands, start=1):
        if -number not in left:
            curve = Boundary.of([Ring(strand.sides, strand.vertices[:-1])])
            where = place(curve.points(np.zeros(1, np.int64), curve.lengths[:1] / 2)[0])
            raise GeometryError(
                f"the line {strand.label!r} at {where} lies outside the domain, on its boundary, or on another line: "
                "move or remove it"
            )


def _sided(boundary: Boundary, areas: Sequence[shapely.Polygon]) -> Boundary:
    """The boundary with the numbers of the regions on both sides of its pieces."""
    numbers = np.arange(len(boundary.kind))
    piece, s, step = boundary.panels()
    # The middle of a chord is in the middle between the corners of the regions' polygons.
    first = np.searchsorted(piece, numbers)
    chord = first + np.bincount(piece) // 2
    at = s[chord] + step[chord] / 2
    middle = (boundary.points(numbers, s[chord]) + boundary.points(numbers, s[chord] + step[chord])) / 2
    tx, ty = boundary.tangents(numbers, at).T
    aside = np.where(boundary.curved, ASIDE_OF_A_CURVE, ASIDE) * step[chord]
    normal = aside[:, None] * np.column_stack([-ty, tx])
    left, right = (region_at(points, areas) for points in (middle + normal, middle - normal))
    return replace(boundary, left=left, right=np.where(boundary.inner, right, -1))


def region_at(points: Floats, areas: Sequence[shapely.Polygon]) -> Integers:
    """Number (n,) of the innermost region at points (n, 2); 0 where there is none."""
    found = np.zeros(len(points), np.int64)
    if len(areas) == 0:
        return found
    number, point = shapely.STRtree(shapely.points(points)).query(np.array(areas, dtype=object), predicate="contains")
    order = np.argsort(-shapely.area(areas)[number], kind="stable")  # the last one written stays
    found[point[order]] = number[order] + 1
    return found


def _require_seen(boundary: Boundary, regions: Sequence[Region]) -> None:
    seen = {*boundary.left.tolist(), *boundary.right.tolist()}
    for number, region in enumerate(regions, start=1):
        if number not in seen:
            where = place(shapely.get_coordinates(region.polygon)[0])
            raise GeometryError(
                f"nothing is left of region {region.name!r} at {where} beside the regions within it: remove one of them"
            )
