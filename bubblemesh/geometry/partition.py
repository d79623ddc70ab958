"""Regions, interfaces and embedded lines: inner pieces, cut where they meet and named by what lies beside them."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import shapely
from shapely.validation import explain_validity

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.rings import Line, Ring, Strand
from bubblemesh.wording import place

__all__ = ["Parts", "Region", "partitioned", "region_at"]

TOUCHING = 1e-9  # of the domain's size: nearer is the same
NEARLY = 1e-6  # of the domain's size: nearer, but not the same, is a slip of the user's
NEWTON_STEPS = 12
RIM_OF_A_CURVE = 1e-4  # of a region's extent: what the chords of its polygonal copy are off at most
PARALLEL = 1e-6  # sine of the angle between two lines, below which they follow each other rather than cross
SAGITTA = 0.01  # of a chord's length, which the curve stays closer to
ASIDE, ASIDE_OF_A_CURVE = 1e-6, 0.02  # of a chord's length: so far beside a piece its region is looked up
COMMON = 1e-3  # part of a region's area that two polygonal copies of one curve may have in common


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
        return shapely.contains_xy(self._bands[0], x, y)

    def reach(self, x: Floats, y: Floats) -> Booleans:
        """Which points (n,) are inside or on the rim."""
        return shapely.contains_xy(self._bands[1], x, y)

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


@dataclass(frozen=True)
class Parts:
    """What a domain holds beside its rings.

    Attributes
    ----------
    regions : tuple of Region
        Numbered from 1; region 0 is the rest of the domain. Where regions are nested the innermost counts.
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


def partitioned(boundary: Boundary, parts: Parts, polygon: shapely.Polygon) -> Boundary:
    """The boundary with inner pieces, noded, and with the regions on either side of all pieces.

    Rings of regions and embedded lines end at the boundary of the domain; what of them follows it, or another one
    of them, is one piece.

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
        If regions overlap or lie outside, or a vertex is next to a line but not on it, with the coordinates.
    """
    regions = [region.polygon for region in parts.regions]
    require_apart(regions, [region.name for region in parts.regions], polygon)
    x0, y0, x1, y1 = polygon.bounds
    size = max(x1 - x0, y1 - y0)
    strands = [*(Strand.around(region.ring, region.label) for region in parts.regions), *parts.strands]
    whole = boundary.joined_by(strands, [point for point, _ in parts.points])
    whole = _cut(whole, _crossings(whole, TOUCHING * size))
    whole = _cut(whole, _corners_on_pieces(whole, size))
    whole = _without_doubles(whole, TOUCHING * size)
    whole = _clipped(whole, polygon)
    return _sided(whole, regions)


def require_apart(regions: Sequence[shapely.Polygon], names: Sequence[str], polygon: shapely.Polygon) -> None:
    """Check that no two regions overlap but by one being inside the other, and that each has a part in the domain.

    Raises
    ------
    GeometryError
        With the names and a place.
    """
    for name, region in zip(names, regions, strict=True):
        if region.intersection(polygon).area <= COMMON * region.area * COMMON:
            where = place(shapely.get_coordinates(region)[0])
            raise GeometryError(f"region {name!r} at {where} lies outside the domain: move or remove it")
    shapes = np.array(regions, dtype=object)
    for i, j in zip(*shapely.STRtree(shapes).query(shapes, predicate="intersects"), strict=True):
        if i >= j:
            continue
        common = regions[i].intersection(regions[j])
        smaller = min(regions[i].area, regions[j].area)
        if COMMON * smaller < common.area < (1 - COMMON) * smaller:
            where = place(shapely.get_coordinates(common.representative_point())[0])
            raise GeometryError(f"regions {names[i]!r} and {names[j]!r} overlap at {where}: give them a common side")
        if common.area >= (1 - COMMON) * max(regions[i].area, regions[j].area):
            where = place(shapely.get_coordinates(regions[i])[0])
            raise GeometryError(f"regions {names[i]!r} and {names[j]!r} at {where} are the same: remove one of them")


Cuts = Mapping[int, Sequence[tuple[float, tuple[float, float]]]]  # arc lengths and points, by piece


def _cut(boundary: Boundary, cuts: Cuts) -> Boundary:
    """The boundary with corners at the cuts."""
    for piece in sorted(cuts, reverse=True):  # a cut renumbers the pieces after it
        here = sorted(set(cuts[piece]), reverse=True)
        if boundary.closed[piece]:
            (first, point), *rest = here
            boundary = boundary.split(piece, first, np.array(point))
            length = boundary.lengths[piece]
            here = sorted([((s - first) % length, at) for s, at in rest], reverse=True)
        for s, point in here:
            boundary = boundary.split(piece, s, np.array(point))
    return boundary


def _chords(boundary: Boundary) -> tuple[Integers, Floats, Floats, Floats]:
    """Piece, arc length, length (m,) and ends (m, 2, 2) of the chords of a fine polygonal copy."""
    piece, s, step = boundary.panels()
    ends = np.stack([boundary.points(piece, s), boundary.points(piece, s + step)], axis=1)
    return piece, s, step, ends


def _crossings(boundary: Boundary, tolerance: float) -> Cuts:
    """Where inner pieces cross others, or each other, between their ends."""
    piece, s, step, ends = _chords(boundary)
    lines = shapely.linestrings(ends)
    mine = np.flatnonzero(boundary.inner[piece])
    i, j = shapely.STRtree(lines).query(lines[mine], predicate="intersects")
    i = mine[i]
    other = (piece[i] != piece[j]) & ((i < j) | ~boundary.inner[piece[j]])
    i, j = i[other], j[other]
    p, q = piece[i], piece[j]
    a, b = s[i] + step[i] / 2, s[j] + step[j] / 2
    for _ in range(NEWTON_STEPS):
        # Both curves as their tangents: where these meet.
        (ux, uy), (vx, vy) = boundary.tangents(p, a).T, boundary.tangents(q, b).T
        gx, gy = (boundary.points(q, b) - boundary.points(p, a)).T
        across = ux * vy - uy * vx
        with np.errstate(divide="ignore", invalid="ignore"):
            a = boundary.wrapped(p, a + np.where(across == 0, 0, (gx * vy - gy * vx) / across))
            b = boundary.wrapped(q, b + np.where(across == 0, 0, (gx * uy - gy * ux) / across))
    points = boundary.points(p, a)
    met = (np.hypot(*(points - boundary.points(q, b)).T) <= tolerance) & (np.abs(across) > PARALLEL)
    inside = [
        boundary.closed[k] | ((at > tolerance) & (at < boundary.lengths[k] - tolerance)) for k, at in ((p, a), (q, b))
    ]
    cuts: dict[int, list[tuple[float, tuple[float, float]]]] = defaultdict(list)
    known: list[tuple[float, float]] = []
    for k in np.flatnonzero(met & inside[0] & inside[1]):
        x, y = float(points[k, 0]), float(points[k, 1])
        same = [at for at in known if np.hypot(at[0] - x, at[1] - y) <= 2 * tolerance]
        point = same[0] if same else (x, y)
        known += [] if same else [point]
        for number, at in ((int(p[k]), float(a[k])), (int(q[k]), float(b[k]))):
            if all(point != place for _, place in cuts[number]):
                cuts[number].append((at, point))
    return cuts


def _corners_on_pieces(boundary: Boundary, size: float) -> Cuts:
    """Corners that lie on pieces between their ends, where one of the two is inner.

    Raises
    ------
    GeometryError
        If one lies next to a piece but not on it.
    """
    piece, s, step, ends = _chords(boundary)
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    reach = SAGITTA * float(length[boundary.curved[piece]].max(initial=0)) + NEARLY * size
    corners = shapely.points(boundary.corners)
    corner, chord = shapely.STRtree(shapely.linestrings(ends)).query(corners, predicate="dwithin", distance=reach)
    k = piece[chord]
    along = boundary.points(k, s[chord] + step[chord] / 2)
    at = s[chord] + step[chord] / 2
    target = boundary.corners[corner]
    for _ in range(NEWTON_STEPS):
        at = boundary.wrapped(k, at + np.einsum("ij,ij->i", target - along, boundary.tangents(k, at)))
        along = boundary.points(k, at)
    gap = np.hypot(*(target - along).T)
    own = (corner == boundary.start[k]) | (corner == boundary.end[k])
    touching_end = ~boundary.closed[k] & ((at <= TOUCHING * size) | (at >= boundary.lengths[k] - TOUCHING * size))
    found = ~own & (gap <= NEARLY * size) & _concerned(boundary, corner, k)
    near = np.flatnonzero(found & (gap > TOUCHING * size))
    if len(near):
        first = near[0]
        raise GeometryError(
            f"the vertex at {place(target[first])} is {gap[first]:.1g} away from the line at {place(along[first])}, "
            "next to it but not on it: give them the same coordinates, or move them apart"
        )
    cuts: dict[int, list[tuple[float, tuple[float, float]]]] = defaultdict(list)
    for number in np.flatnonzero(found & ~touching_end):
        point = (float(target[number, 0]), float(target[number, 1]))
        if all(point != known for _, known in cuts[int(k[number])]):
            cuts[int(k[number])].append((float(at[number]), point))
    return {number: places for number, places in cuts.items() if places}


def _concerned(boundary: Boundary, corner: Integers, piece: Integers) -> Booleans:
    """Whether the corners (m,) or the pieces (m,) belong to something inner: the rings are noded already."""
    of_ring = np.zeros(len(boundary.corners), bool)
    rings = np.flatnonzero(~boundary.inner & ~boundary.closed)
    of_ring[boundary.start[rings]] = True
    return boundary.inner[piece] | ~of_ring[corner]


def _without_doubles(boundary: Boundary, tolerance: float) -> Boundary:
    """The boundary without inner pieces that follow another piece, one of a ring or an earlier one."""
    low, high = np.sort(np.column_stack([boundary.start, boundary.end]), axis=1).T
    numbers = np.arange(len(boundary.kind))
    middle = boundary.points(numbers, boundary.lengths / 2)
    keep = np.ones(len(numbers), bool)
    seen: dict[tuple[int, int], list[int]] = defaultdict(list)
    for number in np.lexsort((numbers, boundary.inner)):
        key = (int(low[number]), int(high[number]))
        same = [k for k in seen[key] if np.hypot(*(middle[k] - middle[number])) <= 10 * tolerance]
        if same and boundary.inner[number]:
            keep[number] = False
        else:
            seen[key].append(int(number))
    return boundary.kept(np.flatnonzero(keep))


def _clipped(boundary: Boundary, polygon: shapely.Polygon) -> Boundary:
    """The boundary without inner pieces outside the domain, and without the corners that only these had."""
    middle = boundary.points(np.arange(len(boundary.kind)), boundary.lengths / 2)
    kept = boundary.kept(np.flatnonzero(~boundary.inner | shapely.contains_xy(polygon, middle)))
    used = shapely.contains_xy(polygon, boundary.corners)
    open_ = ~kept.closed
    used[kept.start[open_]] = used[kept.end[open_]] = True
    ends = [np.where(open_, (np.cumsum(used) - 1)[end], -1) for end in (kept.start, kept.end)]
    return replace(kept, start=ends[0], end=ends[1], corners=kept.corners[used])


def _sided(boundary: Boundary, regions: Sequence[shapely.Polygon]) -> Boundary:
    """The boundary with the numbers of the regions on both sides of its pieces."""
    numbers = np.arange(len(boundary.kind))
    at = boundary.lengths / 2
    middle, (tx, ty) = boundary.points(numbers, at), boundary.tangents(numbers, at).T
    piece, _, step = boundary.panels()
    aside = np.where(boundary.curved, ASIDE_OF_A_CURVE, ASIDE) * step[np.searchsorted(piece, numbers)]
    normal = aside[:, None] * np.column_stack([-ty, tx])
    left, right = (region_at(points, regions) for points in (middle + normal, middle - normal))
    return replace(boundary, left=left, right=np.where(boundary.inner, right, -1))


def region_at(points: Floats, regions: Sequence[shapely.Polygon]) -> Integers:
    """Number (n,) of the innermost region at points (n, 2); 0 where there is none."""
    found = np.zeros(len(points), np.int64)
    for number in sorted(range(len(regions)), key=lambda k: -regions[k].area):
        found[shapely.contains_xy(regions[number], points)] = number + 1
    return found
