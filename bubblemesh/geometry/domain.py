"""A plane domain of one or several areas with holes: what is inside, and how far the boundary is."""

from collections.abc import Sequence
from dataclasses import field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers, cross, each_once, ring_area, select, taken
from bubblemesh.errors import CaseError, GeometryError, about
from bubblemesh.files import require_name
from bubblemesh.geometry.arrangement.clipping import without_outside
from bubblemesh.geometry.arrangement.contacts import split_at_contacts
from bubblemesh.geometry.arrangement.leaps import leap_notes
from bubblemesh.geometry.arrangement.open_ends import OpenEnds
from bubblemesh.geometry.arrangement.partition import partitioned
from bubblemesh.geometry.arrangement.regions import InnerParts
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.corners import CornerFans, corner_fans, require_separation
from bubblemesh.geometry.distance.projection import Feet, Nearest, Projection, projection_onto
from bubblemesh.geometry.matched_sides import with_matched_sides as matched_sides
from bubblemesh.geometry.paths import Area, Ring, RingChange, outlines
from bubblemesh.geometry.periodic import MatchingPieces, matching_pieces
from bubblemesh.geometry.plane import Plane
from bubblemesh.geometry.polygonal_copy import PolygonalCopy
from bubblemesh.geometry.similarity import Similarity
from bubblemesh.geometry.unprojection import Unprojection
from bubblemesh.geometry.validity import require_domain, require_holes_apart, simple_polygon
from bubblemesh.messages import meant, own_places, ring_name, tell_places_of
from bubblemesh.records import Uncached, record

FEWER = 0.5  # edges that vertical lines meet in terms of those that horizontal ones do, to look along vertical ones
LOCATED_AT_A_TIME = 1 << 13  # points: a late run can end between two calls


class Held(NamedTuple):
    """Pieces of a boundary whose bubbles are set beforehand, and stay there."""

    pieces: Integers = np.zeros(0, np.int64)  # (h,)
    piece: Integers = np.zeros(0, np.int64)  # (k,): of each of their bubbles, ascending
    s: Floats = np.zeros(0)  # (k,): its arc length, ascending on each piece


NOTHING_HELD = Held()


@record(eq=False)
class Domain(Uncached):
    """A plane area, or several, each inside its outer ring and outside its holes.

    Attributes
    ----------
    boundary : Boundary
        Smooth pieces with the domain on their left.
    notes : tuple of str
        What was changed on reading the rings.
    parts : InnerParts
        Regions and embedded lines and points, which are pieces and corners of the boundary too.
    given_outlines : dict
        Outlines (m, 2) as given of the rings that are followed as curves, by ring number.
    changes : tuple of RingChange
        What the case has changed of the rings as given.
    held : Held
        Pieces whose bubbles are set beforehand.
    plane : Plane or None
        Plane to which its coordinates, places on the earth, have been projected.
    groups : dict
        Names that stand for several labels where distances are measured.
    lost : tuple of str
        Labels that only sides without length had.
    """

    boundary: Boundary
    notes: tuple[str, ...] = ()
    parts: InnerParts = field(default_factory=InnerParts)
    given_outlines: dict[int, Floats] = field(default_factory=dict)
    changes: tuple[RingChange, ...] = ()
    held: Held = NOTHING_HELD
    plane: Plane | None = None
    groups: dict[str, tuple[str, ...]] = field(default_factory=dict)
    lost: tuple[str, ...] = ()

    @classmethod
    def of(cls, outer: Ring, holes: Sequence[Ring] = (), parts: InnerParts | None = None) -> "Domain":
        """The domain of one area, bounded by rings of either orientation, with its inner parts.

        Raises
        ------
        CaseError
            If an argument is not a ring, or a label is not a name that every mesh file can hold.
        GeometryError
            If the rings cross, or a hole is not inside; the text names the ring and the coordinates.
        """
        if not isinstance(holes, Sequence):
            raise CaseError(f"Domain.of: holes: must be a list of rings (found {type(holes).__name__})")
        inner = InnerParts() if parts is None else parts
        for ring in (outer, *holes):
            if not isinstance(ring, Ring):
                found = type(ring).__name__
                raise CaseError(f"Domain.of: takes rings of bubblemesh.geometry.rings alone (found {found})")
        sides = [side.label for ring in (outer, *holes) for side in ring.sides]
        sides += [side.label for path in inner.lines for side in path.sides]
        named = [path.label for path in inner.lines] + [point.label for point in inner.points]
        for label in (*sides, *named, *(region.label for region in inner.regions)):
            if label is not None:
                require_name(label, "Domain.of: label")
        with own_places():
            return cls.of_areas([Area(outer, tuple(holes))], parts)

    @classmethod
    def of_areas(cls, areas: Sequence[Area], parts: InnerParts | None = None) -> "Domain":
        """The domain of separate areas, which may touch in points and lie in each other's holes, with its inner parts.

        Its rings are numbered from the outer ones, in the order of the areas, to the holes.

        Raises
        ------
        GeometryError
            If rings cross, a hole is not inside, or areas overlap; the text names the ring and the coordinates.
        """
        outlines(ring for area in areas for ring in area.rings)
        rings = [_turned(area.outer, +1) for area in areas]
        rings += [_turned(hole, -1) for area in areas for hole in area.holes]
        owner = [*range(len(areas)), *(number for number, area in enumerate(areas) for _ in area.holes)]
        names = [ring_name(number, ring.origin, len(areas)) for number, ring in enumerate(rings)]
        copies = outlines(rings)
        tell_places_of(float(np.ptp(np.concatenate(copies), axis=0).max()))
        keys, polygons = [ring.key for ring in rings], []
        for key, points, name in zip(keys, copies, names, strict=True):
            with about(key):
                polygons.append(simple_polygon(points, name))
        holes = slice(len(areas), None)
        require_holes_apart(polygons[holes], owner[holes], names[holes], keys[holes])
        given_outlines = {number: ring.given for number, ring in enumerate(rings) if ring.given is not None}

        def bounded_by(boundary: Boundary, inner: InnerParts) -> "Domain":
            notes = (note for ring in rings for note in ring.notes)
            every_note = tuple(dict.fromkeys((*notes, *inner.notes)))  # copies of a ring have the same ones
            changes = tuple(change for ring in (*rings, *inner.rings) for change in ring.changes)
            lost = tuple(label for known in (rings, inner.paths) for path in known for label in path.lost)
            return cls(boundary, every_note, inner, given_outlines, changes, lost=lost)

        boundary = split_at_contacts(Boundary.of(rings, owner))
        inner = InnerParts() if parts is None else parts
        domain = bounded_by(boundary, inner)
        require_domain(domain.polygonal_copy, names, keys)
        if inner:
            inner = without_outside(inner, domain.polygon, domain.signed_distance)
            remarks = (*inner.remarks, *leap_notes(inner.lines, domain.polygon))
            if inner:
                boundary, inner, overlaps = partitioned(boundary, inner, domain.polygon, rings)
                remarks = (*remarks, *overlaps)
            domain = bounded_by(boundary, replace(inner, remarks=remarks))
        require_separation(domain.boundary, domain.corner_fans)
        return domain

    @classmethod
    def with_matched_sides(cls, areas: Sequence[Area], parts: InnerParts) -> "Domain":
        """The domain, in which the second of two periodic sides is the first one moved if it nearly was.

        GeometryError as of ``of_areas``, or if the tolerance of the parts is not less than half of a piece of a side.
        """
        domain = cls.of_areas(areas, parts)
        if parts.periodic_tolerance:
            for names in parts.periodic:
                areas, parts = matched_sides(areas, parts, domain.boundary, names)
                domain = cls.of_areas(areas, parts)
        return domain

    @property
    def periodic(self) -> Integers:
        """Pairs (k, 2) of boundary pieces whose bubbles match.

        Raises
        ------
        GeometryError
            If sides that should match do not; with the place.
        """
        return self._matching.pairs

    @property
    def turn(self) -> Floats:
        """Angles (p,), in radians, by which what is beside periodic pieces is turned beside their counterparts.

        They are 0 for shifted pieces, and those that are not periodic.
        """
        return self._matching.turn

    @property
    def motions(self) -> tuple[Similarity, ...]:
        """What takes the first side of each periodic pair to the second: a shift, or a turn."""
        return self._matching.motions

    @cached_property
    def _matching(self) -> MatchingPieces:
        return matching_pieces(self.boundary, self.parts.periodic, self.parts.periodic_tolerance)

    @cached_property
    def tied(self) -> Booleans:
        """Mask (p,) of the pieces whose bubbles must not move one by one: they are held, or match those of others."""
        found = np.zeros(len(self.boundary.kind), bool)
        found[self.periodic] = True
        found[self.held.pieces] = True
        return found

    @cached_property
    def corner_fans(self) -> CornerFans:
        """Ends of the boundary's pieces around its corners."""
        return corner_fans(self.boundary)

    @cached_property
    def open_ends(self) -> OpenEnds:
        """Ends of embedded lines at which nothing else is; the key `join` of lines moves none onto a coast."""
        return OpenEnds(self.parts.lines, self.boundary, self.size, rings_joined=not self.groups)

    @cached_property
    def polygonal_copy(self) -> PolygonalCopy:
        """Fine polygonal copy of the boundary."""
        return PolygonalCopy.of(self.boundary)

    @cached_property
    def polygon(self) -> shapely.Polygon | shapely.MultiPolygon:
        """The domain bounded by that copy."""
        return self.polygonal_copy.polygon()

    @cached_property
    def bounds(self) -> tuple[float, float, float, float]:
        """Bounding box (x0, y0, x1, y1)."""
        x0, y0, x1, y1 = self.polygon.bounds
        return x0, y0, x1, y1

    @property
    def size(self) -> float:
        """The longer side of the bounding box."""
        x0, y0, x1, y1 = self.bounds
        return max(x1 - x0, y1 - y0)

    @cached_property
    def unprojection(self) -> Unprojection | None:
        """Function from places in the plane to the given coordinates; None if these are already in the plane."""
        return None if self.plane is None else Unprojection(self.plane, self.bounds)

    @property
    def piece_count(self) -> int:
        """Number of separate areas."""
        return 1 + max(self.boundary.area_of_ring)

    @property
    def hole_count(self) -> int:
        """Number of holes."""
        return len(self.boundary.area_of_ring) - self.piece_count

    @cached_property
    def euler_characteristic(self) -> int:
        """Nodes minus edges plus triangles of any mesh: areas minus holes, and one less where two areas have a node."""
        corner, ring = self.boundary.ring_corners()
        area = np.array(self.boundary.area_of_ring)[ring]
        shared = len(each_once(corner * self.piece_count + area)) - len(each_once(corner))
        return self.piece_count - self.hole_count - shared

    def nearest(self, points: Floats) -> Nearest:
        """Nearest boundary points of ``points`` (m, 2), on the true curves."""
        return self._projection(points)

    @cached_property
    def _projection(self) -> Projection:
        return Projection(self.boundary, self.polygonal_copy.chords)

    def distances(self, points: Floats) -> Floats:
        """Distances (m,) of points (m, 2) from the boundary, on curves to about 1e-7 of their radius."""
        return self._projection.distances(points)

    @property
    def region_areas(self) -> dict[str, float]:
        """Areas of the regions and of what they leave, by the chords of their sides; those alone that have sides."""
        boundary, chords, parts = self.boundary, self.boundary.chords(), self.parts
        origin = np.array(self.bounds[:2])  # near which sums have more digits
        swept = cross(chords.start - origin, chords.end - origin) / 2
        region = np.concatenate([boundary.left[chords.piece], boundary.right[chords.piece]])
        inside = region >= 0
        name = parts.name_indices[region[inside]]
        areas = np.bincount(name, np.append(swept, -swept)[inside], len(parts.names)).tolist()
        return {parts.names[k]: areas[k] for k in each_once(name).tolist()}

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """Names of the sides, lines and points of the domain, each once."""
        return tuple(dict.fromkeys([*self.side_labels, *(point.label for point in self.parts.points)]))

    @cached_property
    def side_labels(self) -> tuple[str, ...]:
        """Names of the sides and lines of the domain, each once."""
        return tuple(dict.fromkeys(self.boundary.labels[number] for number in each_once(self.boundary.label)))

    def distance_to(self, points: Floats, *labels: str) -> Floats:
        """Distance (m,) of points (m, 2) from the nearest side, line or point that has one of the ``labels``.

        On curves it is right to about 1e-7 of their radius, at the points of a spline to 1e-6.

        Raises
        ------
        GeometryError
            If there is no such label, or no label is given.
        """
        return self._projection_onto(labels).distances(points)

    def feet(self, points: Floats, *labels: str) -> Feet:
        """Nearest points to points (m, 2) on sides, lines and points that have one of the ``labels``, with tangents.

        Raises
        ------
        GeometryError
            If there is no such label, or no label is given.
        """
        return self._projection_onto(labels).feet(points)

    def _projection_onto(self, labels: tuple[str, ...]) -> Projection:
        """The projection onto everything with one of the labels; GeometryError for an unknown label."""
        for label in labels:
            if label not in self.labels:
                raise GeometryError(f"there is no side, line or point {label!r}: {meant(label, self.labels)}")
        if not labels:
            known = ", ".join(self.labels)
            raise GeometryError(f"no side, line or point is named: give at least one of {known}")
        if labels not in self._labelled:
            places = np.array([point.at for point in self.parts.points if point.label in labels], float).reshape(-1, 2)
            self._labelled[labels] = projection_onto(self.boundary, labels, places)
        return self._labelled[labels]

    @cached_property
    def _labelled(self) -> dict[tuple[str, ...], Projection]:
        """Projections that have been asked for, by labels."""
        return {}

    def contains(self, points: Floats) -> Booleans:
        """Mask (m,) of the points (m, 2) inside, to the accuracy of the polygonal copy."""
        area, first = (self.polygon, 0) if self._mirrored is None else (self._mirrored, 1)
        inside = np.empty(len(points), bool)
        for begin in range(0, len(points), LOCATED_AT_A_TIME):
            part = points[begin : begin + LOCATED_AT_A_TIME]
            inside[begin : begin + LOCATED_AT_A_TIME] = shapely.contains_xy(area, part[:, first], part[:, 1 - first])
        return inside

    @cached_property
    def _mirrored(self) -> shapely.Polygon | shapely.MultiPolygon | None:
        """The domain with x and y exchanged, if points are found faster so, with the same result.

        GEOS looks at all edges that a horizontal line through a point meets: of a zigzag along x these may be all.
        """
        low, high = np.sort(np.stack(self.polygonal_copy.chords[3:]), axis=0)
        along_x, along_y = (_stabbed(low[:, axis], high[:, axis]) for axis in (1, 0))
        if along_y >= FEWER * along_x:
            return None
        mirrored = shapely.transform(self.polygon, lambda points: points[:, ::-1])
        shapely.prepare(mirrored)
        return mirrored

    def distance_at_least(self, points: Floats) -> Floats:
        """Lower bounds (m,) of the distances of points (m, 2) from the boundary, much quicker than these."""
        return self._projection.at_least(points)

    def surely_inside(self, points: Floats, distance: Floats) -> Booleans:
        """Mask (m,) of the points (m, 2) inside that are farther than ``distance`` (m,) from the boundary."""
        result = self.contains(points)
        inside = np.flatnonzero(result)
        # Only what is not clearly so needs a distance of its own.
        unsure = inside[~(self.distance_at_least(points[inside]) > distance[inside])]
        result[unsure] = self._signed_distance(points[unsure], result[unsure]) > distance[unsure]
        return result

    def signed_distance(self, points: Floats) -> Floats:
        """Distance (m,) to the boundary, positive inside."""
        return self._signed_distance(points, self.contains(points))

    def reaches(self, points: Floats, distance: Floats) -> Booleans:
        """Mask (m,) of the points (m, 2) inside, or outside but nearer than ``distance`` (m,)."""
        reached = self.contains(points)
        outside = np.flatnonzero(~reached)
        if len(outside) == 0:
            return reached
        away, belly = self._projection.distances_beside_chords(taken(points, outside))
        reached[outside] = away < distance[outside]
        # Points between a curve and its chord may be inside after all.
        unsure = outside[(away <= belly) & ~reached[outside]]
        reached[unsure] = self._signed_distance(points[unsure], reached[unsure]) > -distance[unsure]
        return reached

    def deep_outside(self, points: Floats, depth: Floats) -> tuple[Booleans, Floats]:
        """Mask (m,) of points (m, 2) outside, as far as ``depth`` (m,), and the nearest boundary points (m, 2)."""
        nearest = self.nearest(points)
        deep = nearest.distance >= depth
        some = taken(points, deep)
        deep[deep] = -self._signed(some, self.contains(some), select(nearest, deep)) >= depth[deep]
        return deep, nearest.foot

    def _signed_distance(self, points: Floats, inside: Booleans) -> Floats:
        """Distance (m,) to the boundary, positive inside, of points that are ``inside`` (m,) the polygonal copy."""
        return self._signed(points, inside, self.nearest(points)) if len(points) else np.zeros(0)

    def _signed(self, points: Floats, inside: Booleans, nearest: Nearest) -> Floats:
        """Signed distance (m,) of `_signed_distance`, from the nearest points on the boundary."""
        piece, s, foot, distance = nearest
        boundary, inside = self.boundary, inside.copy()
        between_corners = boundary.closed[piece] | ((s > 0) & (s < boundary.lengths[piece]))
        # Close to a curve, its tangent decides the side better than its chords.
        smooth = np.flatnonzero(boundary.approximated[piece] & between_corners)
        tx, ty = boundary.tangents(piece[smooth], s[smooth]).T
        rx, ry = (points[smooth] - foot[smooth]).T
        inside[smooth] = tx * ry - ty * rx > 0
        return np.where(inside, distance, -distance)


def _stabbed(low: Floats, high: Floats) -> float:
    """Mean number of the intervals from ``low`` (m,) to ``high`` (m,) that the middle of one of them lies in."""
    middle = (low + high) / 2
    begun, ended = np.searchsorted(np.sort(low), middle, "right"), np.searchsorted(np.sort(high), middle, "left")
    return float((begun - ended).mean())


def _turned(ring: Ring, turn: int) -> Ring:
    """The ring turned counter-clockwise (+1) or clockwise (-1)."""
    return ring if ring_area(ring.outline) * turn >= 0 else ring.reversed()
