"""Regions, interfaces and embedded lines: inner pieces, cut where they meet and named by what lies beside them."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Self

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, select
from bubblemesh.errors import GeometryError, about
from bubblemesh.geometry.arrangement import ROUNDINGS, TOUCHING
from bubblemesh.geometry.arrangement.covered_lines import covered_lines
from bubblemesh.geometry.arrangement.labels import Along, laid_on_rings, lost_notes, overlap_notes, with_given_labels
from bubblemesh.geometry.arrangement.noding import noded
from bubblemesh.geometry.arrangement.open_ends import OpenEnds
from bubblemesh.geometry.arrangement.pieces import doubles, probes
from bubblemesh.geometry.arrangement.regions import (
    NOTHING,
    InnerParts,
    Region,
    RegionsAround,
    innermost,
    overlapping,
    regions_around,
)
from bubblemesh.geometry.arrangement.rest import nothing_left, rest_between
from bubblemesh.geometry.arrangement.seeds import SeededRegions, seeded_regions
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.paths import InnerPoint, Ring
from bubblemesh.geometry.polygonal_copy import PolygonalCopy
from bubblemesh.geometry.validity import first_place
from bubblemesh.messages import place
from bubblemesh.records import record

COARSEST = 1e-6  # of the domain's size: largest rounding error with which regions and lines still work


def partitioned(
    boundary: Boundary, parts: InnerParts, polygon: shapely.Polygon, rings: Sequence[Ring]
) -> tuple[Boundary, InnerParts, tuple[str, ...]]:
    """The boundary of rings with inner pieces, noded, and with the regions on either side of all pieces, and notes.

    Rings of regions and embedded lines end at the boundary of the domain, the polygon. Where several lines run along
    each other there is one piece: that of the ring if there is one, else of an embedded line, else of the first region.
    The parts are returned with regions in place of their seeds, whose sides may be those of the ``rings``.

    Raises
    ------
    GeometryError
        If regions overlap or lie outside, a line or a point is outside of the domain, a line lies on others with other
        labels, or a vertex is next to a line but not on it; with the coordinates.
    """
    for region in parts.regions:
        _ = region.polygon  # an invalid ring is reported before it is compared with others
    size = _size(polygon)
    tolerance = TOUCHING * size
    whole = boundary.with_inner(parts.paths, [point.at for point in parts.points])
    whole = noded(whole, size, len(boundary.corners), parts)
    keep, pairs = doubles(whole, tolerance)
    along = Along(*pairs[keep[pairs[:, 1]]].T)
    laid = laid_on_rings(whole, len(parts.lines), keep, along, polygon)
    final = with_given_labels(whole, along, laid)
    single = final.select(np.flatnonzero(keep))
    sides = _Sides.of(single, whole, parts, polygon)
    seeded = seeded_regions(parts, rings, boundary, single, size, polygon)
    sides = sides.with_regions(seeded)
    sides.require_regions_apart()
    numbered = sides.numbered()
    rest = NOTHING if seeded.faces is None else rest_between(seeded.faces, numbered, sides.within)
    single = clipped_to_domain(numbered, parts.points, tolerance)
    used = laid[along.piece] & (final.label[along.piece] == final.label[along.other])
    left = {*single.ring.tolist(), *whole.ring[along.piece[used]].tolist()}
    covered, notes = covered_lines(final, parts.lines, left, along, polygon)
    sides.require_seen(single)
    seen = np.zeros(len(keep), bool)
    seen[keep] = sides.seen
    partly = select(along, ~np.isin(whole.ring[along.piece], covered))
    notes += *overlap_notes(final, parts.lines, partly), *lost_notes(whole, final, along, seen), *seeded.notes
    if parts.seeds and parts.rest_named and rest.number == 0:
        notes = *notes, nothing_left(parts.rest, OpenEnds(parts.lines, single, size))
    single = replace(single, ring=np.maximum(single.ring, -1 - len(parts.lines)))
    return *_in_order(single, replace(parts, regions=tuple(sides.regions), seeds=(), rest_parts=rest)), notes


def _in_order(boundary: Boundary, parts: InnerParts) -> tuple[Boundary, InnerParts]:
    """The boundary and the parts with the regions in the order of the case's entries, and in that of a file."""
    order = sorted(range(len(parts.regions)), key=lambda k: (parts.regions[k].entry, parts.regions[k].order))
    number = np.zeros(len(order) + 2, np.int64)
    number[np.array(order, np.int64) + 1] = np.arange(1, len(order) + 1)
    number[-1] = -1  # of what is outside
    regions = tuple(parts.regions[one] for one in order)
    return replace(boundary, left=number[boundary.left], right=number[boundary.right]), replace(parts, regions=regions)


def _size(polygon: shapely.Polygon) -> float:
    """Size to which tolerances are relative: that of the domain, or more if coordinates far from the origin need it.

    GeometryError if too few digits are left to decide which lines meet.
    """
    x0, y0, x1, y1 = polygon.bounds
    size = float(max(x1 - x0, y1 - y0))
    rounding = ROUNDINGS * float(np.spacing(max(abs(x0), abs(y0), abs(x1), abs(y1))))
    if rounding > COARSEST * size:
        raise GeometryError(
            f"the domain, {size:.3g} wide, is so far from the origin, at {place((x0, y0))}, that the rounding of its "
            "coordinates hides which regions and lines meet: move it nearer to the origin"
        )
    return max(size, rounding / TOUCHING)


def clipped_to_domain(boundary: Boundary, points: Sequence[InnerPoint], tolerance: float) -> Boundary:
    """The boundary without inner pieces outside the domain, and without the corners that only these had.

    GeometryError if an embedded point is outside, or where another one is.
    """
    domain = PolygonalCopy.of(boundary).polygon()
    middle = boundary.points(np.arange(len(boundary.kind)), boundary.lengths / 2)
    kept = boundary.select(np.flatnonzero(~boundary.inner | shapely.contains_xy(domain, middle)))
    open_ = ~kept.closed
    used = np.zeros(len(kept.corners), bool)
    used[kept.start[open_]] = used[kept.end[open_]] = True
    places = shapely.points(np.array([point.at for point in points], float).reshape(-1, 2))
    corners = shapely.STRtree(shapely.points(kept.corners))
    point, corner = corners.query(places, predicate="dwithin", distance=tolerance)
    inside = shapely.contains_xy(domain, shapely.get_coordinates(places))
    inside[point[used[corner]]] = True
    used[corner] = True
    _require_inside_once(points, corners.nearest(places).tolist() if points else [], inside)
    number = np.append(np.cumsum(used) - 1, -1)  # -1 stays: no corner
    ends = [number[end] for end in (kept.start, kept.end)]
    return replace(kept, start=ends[0], end=ends[1], corners=kept.corners[used])


def _require_inside_once(points: Sequence[InnerPoint], corners: Sequence[int], inside: Booleans) -> None:
    """Check that points, each at one of some corners, are ``inside`` (k,), and no two of them at one corner."""
    owner: dict[int, str] = {}
    for point, corner, is_inside in zip(points, corners, inside.tolist(), strict=True):
        at, label = place(point.at), point.label
        with about(point.key):
            if corner in owner:
                raise GeometryError(f"the points {owner[corner]!r} and {label!r} are both at {at}: remove one")
            if not is_inside:
                raise GeometryError(f"the point {label!r} at {at} lies outside the domain: move or remove it")
        owner[corner] = label


@record
class _Sides:
    """Both sides of the pieces (p,) of a boundary, the left ones before the right ones, and the regions there."""

    boundary: Boundary
    regions: Sequence[Region]
    around: RegionsAround
    within: Booleans  # (2 p,): in the domain

    @classmethod
    def of(cls, boundary: Boundary, noded: Boundary, parts: InnerParts, polygon: shapely.Polygon) -> Self:
        """The sides of a boundary; ``noded`` is the one with its doubles, and the polygon is the domain."""
        around = regions_around(np.vstack(probes(boundary)), noded, parts)
        middle = boundary.points(np.arange(len(boundary.kind)), boundary.lengths / 2)
        inside = boundary.inner & shapely.contains_xy(polygon, middle)
        return cls(boundary, parts.regions, around, np.append(inside | ~boundary.inner, inside))

    def with_regions(self, seeded: SeededRegions) -> Self:
        """The sides with more regions."""
        point, region = seeded.sides
        around = RegionsAround(
            np.append(self.around.point, point), np.append(self.around.region, len(self.regions) + region)
        )
        return replace(self, regions=(*self.regions, *seeded.regions), around=around)

    def numbered(self) -> Boundary:
        """The boundary with the number of the innermost region on each side."""
        sides = np.bincount(self.around.region, minlength=len(self.regions))  # fewer in a region within another one
        left, right = np.split(innermost(self.around, len(self.within), sides), 2)
        return replace(self.boundary, left=left, right=np.where(self.boundary.inner, right, -1))

    def require_regions_apart(self) -> None:
        """Check that regions overlap only by one being inside the other; GeometryError with the names and a place."""
        pair = overlapping(self.around, len(self.regions))
        if pair is None:
            return
        i, j, same = pair
        one, other = (self.around.point[self.around.region == number] for number in (i, j))
        shared = np.intersect1d(one, other)
        # Of several places the one on the longest side, if possible in the domain.
        best = shared[np.lexsort((self.boundary.lengths[shared % len(self.boundary.kind)], self.within[shared]))[-1]]
        piece = np.array([best % len(self.boundary.kind)])
        where = place(self.boundary.points(piece, self.boundary.lengths[piece] / 2)[0])
        in_case = self.regions[j].key[:1] == ("domain",)
        names = f"regions {self.regions[i].name!r} and {self.regions[j].name!r}"
        with about(self.regions[j].key):
            if same:
                raise GeometryError(f"{names} at {where} are the same: remove one of them")
            if self.regions[i].name == self.regions[j].name:
                union = "ring: {union: [...]}, of their rings or their file" if in_case else "the union of their shapes"
                raise GeometryError(
                    f"two areas of region {self.regions[i].name!r} overlap at {where}: make them one by {union}"
                )
            minus = "ring: {minus: [..., ...]}" if in_case else "the difference of their shapes"
            key = "overlaps: later in domain" if in_case else "overlaps='later'"
            raise GeometryError(
                f"{names} overlap at {where}: give them a common side, take one from the other by {minus}, or set "
                f"{key}, by which the later one counts"
            )

    @property
    def seen(self) -> Booleans:
        """Mask (p,) of the pieces that bound the domain or are inside it."""
        return self.within[: len(self.boundary.kind)]

    def require_seen(self, boundary: Boundary) -> None:
        """Check that each region is on some side of the pieces of the boundary; GeometryError about the first one."""
        seen = {*boundary.left.tolist(), *boundary.right.tolist()}
        for number, region in enumerate(self.regions, start=1):
            if number not in seen:
                sides = self.around.point[self.around.region == number - 1]
                where = f"region {region.name!r} at {first_place(region.polygon)}"
                with about(region.key):
                    if len(sides) == 0:
                        raise GeometryError(
                            f"{where} is thinner than {TOUCHING:g} of the domain, which counts as nothing: make it "
                            "wider, or remove it"
                        )
                    if not self.within[sides].any():
                        if region.cut:
                            raise GeometryError(
                                f"{where} lies outside the domain, but for what later ones cover of it: move or remove "
                                "it"
                            )
                        raise GeometryError(f"{where} lies outside the domain: move or remove it")
                    raise GeometryError(f"nothing is left of {where} beside the regions within it: remove one of them")
