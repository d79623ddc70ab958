"""Rings of many short edges, followed as curves between vertices that stay nodes; and the deviation of a mesh."""

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.errors import GeometryError, about
from bubblemesh.geometry.cubic_splines import CubicSpline
from bubblemesh.geometry.curves import shares_before, turning
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.line_ends import shared_vertices
from bubblemesh.geometry.paths import Area, Curve, Line, OpenPath, Point, Polyline, Ring, Side, Spline
from bubblemesh.messages import place
from bubblemesh.records import record

SEVERAL = 24  # edges or vertices of files, from which on it is advised to follow curves
SPLINE_SAMPLES = 8  # of a spline between two of its points, to see how far it departs from the polyline


@record
class Following:
    """Rule by which straight sides are followed as curves, between vertices that stay nodes.

    Vertices where the label changes or a curve ends always stay nodes.
    """

    corners: float  # degrees: vertices that turn by more stay nodes
    smooth: bool = False  # follow a spline through the vertices, not the straight lines between them
    tolerance: float | None = None  # largest distance of the mesh from the polyline: more vertices stay nodes for it

    def __call__(self, ring: Ring, stay: Set[Point] = frozenset()) -> Ring:
        """The ring with its straight sides followed as curves between the vertices that stay nodes.

        Vertices in ``stay`` also stay nodes; with such a set, the curves do not depend on the direction of a run.
        GeometryError if the spline through the vertices departs from the polyline by more than half the tolerance.
        """
        fixed = self.fixed(ring) | np.array([vertex in stay for vertex in ring.vertices], bool)
        if fixed.all():
            return ring
        if not fixed.any() and self.tolerance is None:
            points = np.array([*ring.vertices, ring.vertices[0]])
            side = Side(Spline(points) if self.smooth else Polyline(points), ring.sides[0].label)
            return replace(ring, sides=(side,), vertices=(), given=ring.outline)
        cornered = bool(fixed.any())
        fixed[0] = fixed[0] or not cornered
        sides, vertices = list[Side](), list[Point]()
        stops = np.flatnonzero(fixed).tolist()
        for begin, end in pairwise([*stops, stops[0] + len(fixed)]):
            run = ring.sides[begin]
            corners = [ring.vertices[k % len(fixed)] for k in range(begin, end + 1)]
            straight = isinstance(run.curve, Line)
            curves = (
                (self._either_way if stay else self._curves)(np.array(corners), cornered)
                if straight
                else {0: run.curve}
            )
            sides += [Side(curve, run.label) for curve in curves.values()]
            vertices += [corners[first] for first in curves]
        return replace(ring, sides=tuple(sides), vertices=tuple(vertices), given=ring.outline)

    def along(self, line: OpenPath, stay: Set[Point], *, shared: bool = False) -> OpenPath:
        """The line with its straight sides followed as curves between the vertices that stay nodes; its ends do.

        Vertices in ``stay`` also stay nodes. If some of its edges are ``shared`` with rings or other lines, the curves
        do not depend on its direction. GeometryError as for a ring.
        """
        if len(line.vertices) < 3:
            return line
        straight = np.array([isinstance(side.curve, Line) for side in line.sides])
        labels = np.array([side.label or "" for side in line.sides])
        ahead = np.diff(np.array(line.vertices), axis=0)
        inner = np.degrees(np.abs(turning(ahead[:-1], ahead[1:]))) > self.corners
        inner |= (labels[1:] != labels[:-1]) | ~straight[1:] | ~straight[:-1]
        inner |= np.array([vertex in stay for vertex in line.vertices[1:-1]])
        sides, vertices = list[Side](), list[Point]()
        stops = np.flatnonzero([True, *inner.tolist(), True]).tolist()
        for begin, end in pairwise(stops):
            run, corners = line.sides[begin], line.vertices[begin : end + 1]
            followed = self._either_way if shared else self._curves
            curves = followed(np.array(corners), True) if straight[begin] else {0: run.curve}
            sides += [Side(curve, run.label) for curve in curves.values()]
            vertices += [corners[first] for first in curves]
        return replace(line, sides=tuple(sides), vertices=(*vertices, line.vertices[-1]))

    def fixed(self, ring: Ring) -> Booleans:
        """Mask (n,) of the vertices that stay nodes whatever the tolerance."""
        straight = np.array([isinstance(side.curve, Line) for side in ring.sides])
        if len(ring.vertices) < 3 or not straight.any():
            return np.ones(len(ring.vertices), bool)
        points = np.array(ring.vertices)
        ahead = np.roll(points, -1, axis=0) - points
        turn = np.degrees(np.abs(turning(np.roll(ahead, 1, axis=0), ahead)))
        labels = np.array([side.label or "" for side in ring.sides])
        return (turn > self.corners) | (labels != np.roll(labels, 1)) | ~straight | ~np.roll(straight, 1)

    def _either_way(self, points: Floats, cornered: bool) -> dict[int, Curve]:
        """Curves of `_curves` that are the same for a run and for its reverse, as neighbours need."""
        last = len(points) - 1
        if self.tolerance is None or not cornered or points[0].tolist() <= points[-1].tolist():
            return self._curves(points, cornered)
        curves = self._curves(points[::-1], cornered)
        ends = [*list(curves)[1:], last]
        back = {last - end: curve.reversed() for end, curve in zip(ends, curves.values(), strict=True)}
        return dict(sorted(back.items()))

    def _curves(self, points: Floats, cornered: bool) -> dict[int, Curve]:
        """Curves through the points (k, 2) of a run, by the number of the first point of each.

        A closed run has a corner at its start or is smooth there.
        """
        spline = CubicSpline.through(points, cornered=cornered) if self.smooth and len(points) > 2 else None
        last = len(points) - 1
        if self.tolerance is None:
            return {0: _part(points, spline, 0, last)}
        # Both the polyline and what the nodes slide on stay in a tube around the chords of the kept vertices.
        dense, stride = points, 1
        if spline is not None:
            stride = SPLINE_SAMPLES
            dense = spline.points(np.interp(np.arange(stride * last + 1) / stride, np.arange(last + 1), spline.breaks))
            self._require_near(points, dense)
        kept = _simplified(dense, stride, self.tolerance / 2)
        return {begin: _part(points, spline, begin, end) for begin, end in pairwise(kept)}

    def _require_near(self, points: Floats, dense: Floats) -> None:
        """Check that the spline does not bulge between its points by more than the tolerance allows."""
        between = dense[:-1].reshape(-1, SPLINE_SAMPLES, 2)
        away = _from_chord(between, points[:-1, None], points[1:, None]).max(axis=1)
        if self.tolerance is not None and away.max() > self.tolerance / 2:
            raise GeometryError(
                f"the spline at {place(points[away.argmax()])} departs from the polyline by {away.max():.3g}, more "
                f"than half the tolerance of {self.tolerance:g}: raise the tolerance or leave out smooth"
            )


def all_followed(
    follow: Following, areas: Sequence[Area], regions: Sequence[Area], lines: Sequence[OpenPath]
) -> tuple[list[Area], list[Area], list[OpenPath]]:
    """Areas, regions in them and lines, followed as curves that they share where they have the same edges.

    Where such edges begin and end splines do so, too. GeometryError, about the ring or line, as for a ring.
    """
    rings = [ring for area in (*areas, *regions) for ring in area.rings]
    chains = [*(ring.vertices[-1:] + ring.vertices + ring.vertices[:1] for ring in rings), *(o.vertices for o in lines)]
    owners = dict[frozenset[Point], set[int]]()
    for number, chain in enumerate(chains):
        for edge in pairwise(chain):
            owners.setdefault(frozenset(edge), set()).add(number)
    ends = set[Point]()
    if follow.smooth or follow.tolerance is not None:  # polylines are the same wherever they begin
        ends = {vertex for chain in chains for vertex, before, after in _owned(chain, owners) if before != after}

    def of_ring(ring: Ring) -> Ring:
        with about(ring.key):
            return follow(ring, ends.intersection(ring.vertices))

    def of_line(line: OpenPath) -> OpenPath:
        within = {v for v, before, after in _owned(line.vertices, owners) if before == after and len(before) > 1}
        with about(line.key):
            return follow.along(line, touched - within, shared=bool(within))

    touched = shared_vertices(lines, rings)
    around = [area.mapped(of_ring) for area in areas]
    return around, followed_together(regions, follow, ends), [of_line(line) for line in lines]


def _owned(
    chain: Sequence[Point], owners: Mapping[frozenset[Point], set[int]]
) -> Iterator[tuple[Point, set[int], set[int]]]:
    """Inner vertices of a chain, and the owners of the edges before and after each."""
    for before, vertex, after in zip(chain, chain[1:], chain[2:], strict=False):
        yield vertex, owners[frozenset((before, vertex))], owners[frozenset((vertex, after))]


def followed_together(areas: Sequence[Area], follow: Following, ends: Set[Point] = frozenset()) -> list[Area]:
    """Areas with exactly shared borders, followed as curves that they share.

    Vertices stay nodes where they do in any of the rings, where a border between two areas begins or ends, and where
    borders with others have their ``ends``.
    """
    rings = [ring for area in areas for ring in area.rings]
    at: dict[Point, set[int]] = {}
    along: dict[frozenset[Point], set[int]] = {}
    for number, ring in enumerate(rings):
        for k, vertex in enumerate(ring.vertices):
            at.setdefault(vertex, set()).add(number)
            along.setdefault(frozenset((ring.vertices[k - 1], vertex)), set()).add(number)
    stay = {vertex for ring in rings for vertex in ring.vertices if vertex in ends}
    for ring in rings:
        corners = ring.vertices
        for before, vertex, after, fixed in zip(
            corners[-1:] + corners[:-1], corners, corners[1:] + corners[:1], follow.fixed(ring).tolist(), strict=True
        ):
            if fixed or not at[vertex] == along[frozenset((before, vertex))] == along[frozenset((vertex, after))]:
                stay.add(vertex)
    for ring in rings:  # a loop that two areas share begins in one place
        if ring.vertices and stay.isdisjoint(ring.vertices) and len(at[ring.vertices[0]]) > 1:
            stay.add(min(ring.vertices))
    return [area.mapped(lambda ring: follow(ring, stay)) for area in areas]


def _part(points: Floats, spline: CubicSpline | None, begin: int, end: int) -> Curve:
    """The polyline or the spline from one of its points to another one."""
    part = points[begin : end + 1]
    if spline is not None:
        length = np.hypot(*np.diff(points, axis=0).T).sum()
        return Spline(part, spline.rates(spline.breaks[[begin, end]]) / length)
    if len(part) > 2:
        return Polyline(part)
    (x0, y0), (x1, y1) = part.tolist()
    return Line((x0, y0), (x1, y1))


def _simplified(points: Floats, stride: int, tolerance: float) -> list[int]:
    """Numbers, divided by ``stride``, of points at multiples of it whose chords are near all of them.

    The algorithm of Ramer, Douglas and Peucker. A closed run starts with a cut at its farthest point.
    """
    last = (len(points) - 1) // stride
    kept, open_ = {0, last}, [(0, last)]
    while open_:
        begin, end = open_.pop()
        if end - begin < 2:
            continue
        part = points[stride * begin : stride * end + 1]
        away = _from_chord(part, part[0], part[-1])
        if away.max() > tolerance or (part[0] == part[-1]).all():
            own = away[stride:-stride:stride] if stride > 1 else away[1:-1]
            middle = begin + 1 + int(own.argmax())
            kept.add(middle)
            open_ += [(begin, middle), (middle, end)]
    return sorted(kept)


def _from_chord(points: Floats, a: Floats, b: Floats) -> Floats:
    """Distances of points (..., 2) from the straight lines from ``a`` to ``b``."""
    return np.linalg.norm(points - a - shares_before(points, a, b)[..., None] * (b - a), axis=-1)


class Deviation(NamedTuple):
    """Largest distance between a ring as given and the mesh's boundary, and the point (x, y) where it is."""

    largest: float
    at: tuple[float, float]


def deviation(domain: Domain, points: Floats, facets: Integers, facet_piece: Integers) -> Deviation | None:
    """Deviation of a mesh's boundary edges from the polylines that they follow; None without any such ring.

    The edges ``facets`` (b, 2) of the nodes ``points`` (n, 2) follow the boundary pieces ``facet_piece`` (b,).
    """
    found = []
    for number, given in domain.given_outlines.items():
        edges = points[facets[domain.boundary.ring[facet_piece] == number]]
        # Distances from a chord to its polyline and back are largest at the vertices, at nodes and in between.
        found.append(_farthest(given, edges))
        found.append(_farthest(np.vstack([edges[:, 0], edges.mean(axis=1)]), _closed(given)))
    return max(found) if found else None


def _closed(points: Floats) -> Floats:
    return np.stack([points, np.roll(points, -1, axis=0)], axis=1)


def _farthest(points: Floats, lines: Floats) -> Deviation:
    """Largest distance of the points (m, 2) from the nearest of the lines (k, 2, 2)."""
    _, distance = shapely.STRtree(shapely.linestrings(lines)).query_nearest(
        shapely.points(points), all_matches=False, return_distance=True
    )
    x, y = points[distance.argmax()].tolist()
    return Deviation(float(distance.max()), (x, y))
