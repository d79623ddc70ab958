"""Cover of a domain: triangles and intervals up to a fraction of its size, over which spacings are looked at."""

from collections.abc import Callable
from functools import cached_property

import numpy as np

from bubblemesh.arrays import Floats, Integers, different_rows, largest_of_rows, members, taken
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.triangulation import triangulated
from bubblemesh.records import record

LARGEST_PART = 1 / 32  # of the domain's size: parts that large are divided before they are trusted


@record(eq=False)
class Cover:
    """Parts of a domain that are up to a fraction of its size; inner pieces lie in the area and count there.

    They are made when they are asked for: a constant spacing needs none.
    """

    domain: Domain

    @property
    def points(self) -> Floats:
        """Corners (n, 2) of the triangles."""
        return self._in_area[0]

    @property
    def triangles(self) -> Integers:
        """Triangles (t, 3) that cover the domain."""
        return self._in_area[1]

    @cached_property
    def intervals(self) -> Floats:
        """Piece, begin and end arc length (k, 3) of parts of the boundary but for its inner pieces."""
        return _intervals(self.domain)

    @cached_property
    def _in_area(self) -> tuple[Floats, Integers]:
        return _triangles(self.domain)

    @property
    def corners(self) -> Floats:
        """Corners (t, 3, 2) of the triangles."""
        return taken(self.points, self.triangles)


def _triangles(domain: Domain) -> tuple[Floats, Integers]:
    """Points (n, 2) and triangles (t, 3) that cover the domain, with edges up to a fraction of its size."""
    longest = LARGEST_PART * domain.size
    outline, edges = _outline(domain, longest)
    points = np.vstack([outline, _lattice(domain, 0.99 * longest)])
    triangles = triangulated(points, edges)
    small = _longest_edge(taken(points, triangles)) <= longest
    parts, number = different_rows(
        _refined(taken(points, triangles[~small]), _halved_triangles, _longest_edge, longest).reshape(-1, 2)
    )
    return np.vstack([points, parts]), np.vstack([triangles[small], number.reshape(-1, 3) + len(points)])


def _outline(domain: Domain, longest: float) -> tuple[Floats, Integers]:
    """Points (m, 2) along the boundary, and edges (e, 2) between them that are no longer than ``longest``."""
    line = domain.polygonal_copy
    corners, number = different_rows(line.points)
    begin, end = number, number[line.successor]
    parts = np.ceil(np.hypot(*(corners[end] - corners[begin]).T) / longest).astype(np.int64)
    chord, rank = members(parts)
    inner = rank > 0
    share = (rank / parts[chord])[inner, None]
    between = corners[begin[chord[inner]]] * (1 - share) + corners[end[chord[inner]]] * share
    first = np.where(inner, len(corners) + np.cumsum(inner) - 1, begin[chord])
    last = np.where(rank + 1 < parts[chord], np.roll(first, -1), end[chord])
    return np.vstack([corners, between]), np.column_stack([first, last])


def _lattice(domain: Domain, step: float) -> Floats:
    """Points (m, 2) of a hexagonal lattice inside; without them triangles would reach from wall to wall."""
    x0, y0, x1, y1 = domain.bounds
    i, j = np.meshgrid(np.arange(int((x1 - x0) / step) + 2), np.arange(int((y1 - y0) / (step * np.sqrt(0.75))) + 1))
    points = np.column_stack([x0 + step * (i + j % 2 / 2).ravel(), y0 + step * np.sqrt(0.75) * (j + 0.5).ravel()])
    return points[domain.surely_inside(points, np.full(len(points), step / 2))]


def _intervals(domain: Domain) -> Floats:
    """Boundary intervals (k, 3) as piece, begin and end arc length, without inner pieces."""
    piece = np.flatnonzero(~domain.boundary.inner)
    whole = np.column_stack([piece, np.zeros(len(piece)), domain.boundary.lengths[piece]])
    return _refined(whole, _halved_intervals, lambda p: p[:, 2] - p[:, 1], LARGEST_PART * domain.size)


def _refined(
    parts: Floats, halved: Callable[[Floats], Floats], lengths: Callable[[Floats], Floats], longest: float
) -> Floats:
    done = [parts[:0]]
    while len(parts):
        short = lengths(parts) <= longest
        done.append(taken(parts, short))
        parts = halved(parts[~short])
    return np.concatenate(done)


def _halved_triangles(triangles: Floats) -> Floats:
    """Halves (2 t, 3, 2) of triangles (t, 3, 2) cut across their longest edge, all first halves first."""
    longest = _edge_lengths(triangles).argmax(axis=1)
    a, b, c = (triangles[np.arange(len(triangles)), (longest + k) % 3] for k in range(3))
    middle = (a + b) / 2
    return np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])


def _longest_edge(triangles: Floats) -> Floats:
    """Length (t,) of the longest edge of each triangle (t, 3, 2)."""
    return largest_of_rows(_edge_lengths(triangles))


def _edge_lengths(triangles: Floats) -> Floats:
    """Lengths (t, 3) of the edges from each corner to the next."""
    delta = triangles - triangles.take([1, 2, 0], axis=1)
    return np.hypot(delta[..., 0], delta[..., 1])


def _halved_intervals(intervals: Floats) -> Floats:
    first, last = intervals.copy(), intervals.copy()
    first[:, 2] = last[:, 1] = (intervals[:, 1] + intervals[:, 2]) / 2
    return np.concatenate([first, last])
