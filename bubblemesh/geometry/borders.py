"""Neighbours given one by one: slivers and overlaps between them closed, so that borders are exactly shared."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.errors import GeometryError, NeighbourError
from bubblemesh.geometry.arrangement import NEARLY, ROUNDINGS, TOUCHING
from bubblemesh.geometry.coverage import is_coverage, surely_coverage
from bubblemesh.geometry.near_vertices import without_near_vertices
from bubblemesh.geometry.neighbours import gaps_between, merged, owners
from bubblemesh.geometry.nesting import Shapes, enclosures, made_valid, polygons_of
from bubblemesh.messages import counted, just_above, place
from bubblemesh.records import record

WIDEST_JOIN = 0.02  # of the size of all: shapes farther apart are not neighbours
NEAREST = 8  # nearest vertices that are searched for one onto which a vertex moves
WIDTH_HALVINGS = 12  # of the interval that contains the width of an overlap
INNERMOST = 1e-6  # share of an area that may be outside of the area around it


class Matched(NamedTuple):
    """Shapes whose borders are exactly shared, which of them changed, and notes on gaps that were closed."""

    shapes: Shapes
    changed: Booleans
    notes: tuple[str, ...] = ()


def matched(shapes: Shapes, names: Sequence[str], join: float | None, key: str = "join") -> Matched:
    """Valid polygons (n,) with slivers and overlaps closed up to a width ``join``, by default only those by rounding.

    Of two borders, the one of the earlier shape is used. A shape within another one stays there. What is left open
    where several meet, up to that width, becomes a part of the one with the longest border to it. Vertices next to
    others of the same ring, which a domain could not have, are left out. GeometryError, with the names, the place, the
    width and the ``key`` that gives it, if wider slivers or overlaps remain between two.
    """
    x0, y0, x1, y1 = shapely.total_bounds(shapes)
    near = NEARLY * float(max(x1 - x0, y1 - y0))
    plain, changed = without_near_vertices(shapes, near)
    found = _matched_in_pairs(plain, names, join, key)
    found = found if join is None else _without_gaps(found, names, join)
    last, again = without_near_vertices(found.shapes, near)  # what is closed may leave short sides
    return Matched(last, found.changed | changed | again, (*_left_out(changed, names), *found.notes))


def _left_out(changed: Booleans, names: Sequence[str]) -> tuple[str, ...]:
    """Note on vertices next to others of the same ring, of the shapes (n,) that changed."""
    own = list(dict.fromkeys(names[number] for number in np.flatnonzero(changed).tolist()))
    if not own:
        return ()
    others = f" and {counted(len(own) - 1, 'more region')}" if len(own) > 1 else ""
    return (f"vertices next to others of the same ring left out of {own[0]!r}{others}",)


def _matched_in_pairs(shapes: Shapes, names: Sequence[str], join: float | None, key: str) -> Matched:
    """The polygons of `matched` where gaps between two of them are closed."""
    x0, y0, x1, y1 = shapely.total_bounds(shapes)
    size = float(max(x1 - x0, y1 - y0))
    rounding = max(TOUCHING * size, ROUNDINGS * float(np.spacing(np.abs([x0, y0, x1, y1]).max())))
    if join is not None and join > WIDEST_JOIN * size:
        raise GeometryError(f"{key}: {join:g} is too much for regions that are {size:g} wide together: make it smaller")
    reach = max(NEARLY * size, rounding, join or 0.0)  # a domain could not have what is nearer than the first of these
    if is_coverage(shapes, reach):
        return Matched(shapes, np.zeros(len(shapes), bool))
    if join is None:  # the widest overlap is reported before narrow slivers
        _without_overlaps(shapes, names, rounding, rounding)
    borders = _Borders.of(shapes)
    moves = borders.moves(reach)
    widest = int(moves.distance.argmax())
    width = float(moves.distance[widest])
    where = place(borders.points[widest])
    pair = _named(names, borders.owner[widest], moves.other[widest])
    if join is None and width > rounding:
        raise NeighbourError(
            f"{pair} are {width:.2g} apart at {where}, or overlap by that: set join: {just_above(width)} to close it"
        )
    found = borders.rebuilt(shapes, moves)
    found = _without_overlaps(found, names, rounding if join is None else reach, rounding)
    changed = ~shapely.equals_exact(found, shapes)
    for number in np.flatnonzero(shapely.is_empty(found)).tolist():
        raise GeometryError(f"nothing is left of {names[number]!r} with this join: make it smaller")
    if width <= rounding:
        return Matched(found, changed)
    pairs = np.column_stack([borders.owner, moves.other])[moves.distance > rounding]
    count = len(np.unique(np.sort(pairs, axis=1), axis=0))
    closed = f"slivers and overlaps between {counted(count, 'pair')} of neighbours closed"
    return Matched(found, changed, (f"{closed}, the widest ({width:.2g}) of {pair} at {where}",))


def _without_gaps(given: Matched, names: Sequence[str], width: float) -> Matched:
    """The polygons, each of the gaps up to a width between several of them given to one (see `owners`)."""
    shapes = given.shapes.copy()
    flat = np.setdiff1d(np.arange(len(shapes)), enclosures(shapes, shapes)[0])
    gaps = gaps_between(shapes[flat])
    wide = widths(gaps)
    gaps, wide = gaps[wide <= width], wide[wide <= width]
    if len(gaps) == 0:
        return given
    pieces = np.concatenate([shapes[flat], gaps])
    free = np.arange(len(pieces)) >= len(flat)
    owner = owners(pieces, free)
    shapes[flat] = merged(pieces, owner)[: len(flat)]
    widest = int(wide.argmax())
    name, where = names[flat[owner[free][widest]]], place(_inside(gaps[widest]))
    closed = f"{counted(len(gaps), 'gap')} where several neighbours meet closed"
    note = f"{closed}, the widest ({wide[widest]:.2g}) at {where}, now a part of {name!r}"
    return Matched(shapes, given.changed | (shapes != given.shapes), (*given.notes, note))


class _Moves(NamedTuple):
    """Targets of vertices, their distances and the shapes that cause them; and vertices inserted in edges, in order."""

    target: Floats  # (v, 2)
    distance: Floats  # (v,)
    other: Integers  # (v,), shape whose border they go to, -1 if they stay
    edge: Integers  # (k,)
    vertex: Integers  # (k,)


@record
class _Borders:
    """Rings of shapes as walks over common vertices and edges."""

    points: Floats  # (v, 2), each once
    owner: Integers  # (v,), first shape with the vertex
    ring_of: Integers  # (m,), ring of each step of a walk
    shape_of: Integers  # (r,), shape of each ring
    step: Integers  # (m,), vertex at which each step begins
    edge: Integers  # (m,), edge along which it goes
    backward: Booleans  # (m,), against the direction of the edge
    ends: Integers  # (e, 2), vertices of the edges, the lower one first

    @classmethod
    def of(cls, shapes: Shapes) -> "_Borders":
        rings, shape_of = shapely.get_rings(shapes, return_index=True)
        coordinates, ring_of = shapely.get_coordinates(rings, return_index=True)
        points, vertex = np.unique(coordinates, axis=0, return_inverse=True)
        vertex = vertex.ravel()
        inner = np.flatnonzero(np.diff(ring_of, append=-1) == 0)  # the last point of a ring is its first
        pairs = np.column_stack([vertex[inner], vertex[inner + 1]])
        ends, edge = np.unique(np.sort(pairs, axis=1), axis=0, return_inverse=True)
        owner = np.full(len(points), len(shapes))
        np.minimum.at(owner, vertex, shape_of[ring_of])
        return cls(
            points, owner, ring_of[inner], shape_of, vertex[inner], edge.ravel(), pairs[:, 0] > pairs[:, 1], ends
        )

    def moves(self, reach: float) -> _Moves:
        """Vertices within ``reach`` of an earlier shape's border move there; those near edges are inserted there."""
        count, shape = len(self.points), self.shape_of[self.ring_of]
        incidence = np.unique(np.column_stack([self.step, shape]), axis=0)
        has = {tuple(row) for row in incidence.tolist()}
        final, other = np.arange(count), np.full(count, -1)
        from scipy.spatial import cKDTree

        tree = cKDTree(self.points)
        distance, near = map(np.asarray, tree.query(self.points, min(NEAREST, count), distance_upper_bound=reach))
        for k in range(1, near.shape[1]):
            v = np.flatnonzero((final == np.arange(count)) & np.isfinite(distance[:, k]))
            w = near[v, k]
            earlier = self.owner[w] < self.owner[v]
            v, w = v[earlier], w[earlier]
            apart = np.array([(b, a) not in has for a, b in zip(self.owner[v].tolist(), w.tolist(), strict=True)], bool)
            final[v[apart]], other[v[apart]] = w[apart], self.owner[w[apart]]
        while (final[final] != final).any():
            final = final[final]
        return self._with_edges(final, other, reach, shape, has)

    def _with_edges(
        self, final: Integers, other: Integers, reach: float, shape: Integers, has: set[tuple[int, ...]]
    ) -> _Moves:
        """Moves of the vertices that go to others, with those of vertices that go onto edges."""
        edge_owner = np.full(len(self.ends), self.shape_of.max() + 1)
        np.minimum.at(edge_owner, self.edge, shape)
        start, end = self.points[self.ends[:, 0]], self.points[self.ends[:, 1]]
        tree = shapely.STRtree(shapely.linestrings(np.stack([start, end], axis=1)))
        v, e = tree.query(shapely.points(self.points), predicate="dwithin", distance=reach)
        alone = (final[v] == v) & (final[self.ends[e]] != v[:, None]).all(axis=1)
        v, e = v[alone], e[alone]
        sides = [tuple(row) for row in np.unique(np.column_stack([self.edge, shape]), axis=0).tolist()]
        beside: dict[int, list[int]] = {}
        for one, which in sides:
            beside.setdefault(one, []).append(which)
        strange = [not any((a, s) in has for s in beside[b]) for a, b in zip(v.tolist(), e.tolist(), strict=True)]
        v, e = v[np.array(strange, bool)], e[np.array(strange, bool)]
        along = end[e] - start[e]
        t = ((self.points[v] - start[e]) * along).sum(axis=1) / (along**2).sum(axis=1)
        within = (t > 0) & (t < 1)
        v, e, t = v[within], e[within], t[within]
        foot = start[e] + t[:, None] * (end[e] - start[e])
        gap = np.hypot(*(foot - self.points[v]).T)
        target = self.points[final]
        distance = np.hypot(*(target - self.points).T)
        order = np.lexsort((-gap, v))  # of several edges the nearest is written last
        order = order[edge_owner[e[order]] < self.owner[v[order]]]
        target[v[order]], distance[v[order]], other[v[order]] = foot[order], gap[order], edge_owner[e[order]]
        target = target[final]  # a vertex that goes to another one goes on with it to an edge
        follows = final != np.arange(len(final))
        distance[follows] = np.hypot(*(target - self.points)[follows].T)
        stays = edge_owner[e] > self.owner[v]  # the edge of a later shape bends to the vertex
        later = np.flatnonzero(stays & (gap > distance[v]))
        distance[v[later]], other[v[later]] = gap[later], edge_owner[e[later]]
        order = np.lexsort((t, e))
        return _Moves(target, distance, other, e[order], v[order])

    def rebuilt(self, shapes: Shapes, moves: _Moves) -> Shapes:
        """The shapes along the moved vertices."""
        first = np.searchsorted(moves.edge, np.arange(len(self.ends) + 1))
        more = np.diff(first)[self.edge]
        length = 1 + more
        begin = np.cumsum(length) - length
        walk = np.empty(int(length.sum()), np.int64)
        walk[begin] = self.step
        for k in np.flatnonzero(more).tolist():
            taken = moves.vertex[first[self.edge[k]] : first[self.edge[k] + 1]]
            walk[begin[k] + 1 : begin[k] + length[k]] = taken[::-1] if self.backward[k] else taken
        ring = np.repeat(self.ring_of, length)
        points = moves.target[walk]
        bounds = np.searchsorted(ring, np.arange(len(self.shape_of) + 1))
        touched = np.zeros(len(self.shape_of), bool)
        stay = (moves.target == self.points).all(axis=1)
        touched[np.unique(ring[~stay[walk]])] = True
        touched[self.ring_of[more > 0]] = True
        changed = np.unique(self.shape_of[touched])
        result = shapes.copy()
        for number in changed.tolist():
            loops = [points[bounds[k] : bounds[k + 1]] for k in np.flatnonzero(self.shape_of == number)]
            outer, *holes = map(_without_returns, loops)
            holes = [hole for hole in holes if len(hole) > 2]
            # Nothing is left of a shape that is narrower than the moves of its vertices.
            result[number] = (
                _of_valid_parts(shapely.Polygon(outer, holes)) if len(outer) > 2 else shapely.MultiPolygon()
            )
        return result


def _without_returns(loop: Floats) -> Floats:
    """The ring without points twice and without parts that go there and back."""
    kept: list[tuple[float, float]] = []
    for point in map(tuple, loop.tolist()):
        if kept and kept[-1] == point:
            continue
        if len(kept) > 1 and kept[-2] == point:
            kept.pop()
            continue
        kept.append(point)
    while len(kept) > 1 and kept[0] == kept[-1]:
        kept.pop()
    while len(kept) > 2 and kept[1] == kept[-1]:
        kept = kept[2:]
    return np.array(kept, float).reshape(-1, 2)


def _of_valid_parts(polygon: shapely.Polygon) -> shapely.Geometry:
    if polygon.is_valid:
        return polygon
    areas = polygons_of(made_valid(polygon))
    return areas[0] if len(areas) == 1 else shapely.MultiPolygon(areas)


def _without_overlaps(shapes: Shapes, names: Sequence[str], join: float, rounding: float) -> Shapes:
    """The shapes, later ones without overlaps with earlier ones that are wider than ``rounding``.

    GeometryError for the widest overlap if that is above ``join``.
    """
    shapes = shapes.copy()
    for number in np.flatnonzero(~shapely.is_valid(shapes)).tolist():  # parts that share a side
        shapes[number] = shapely.union_all(polygons_of(made_valid(shapes[number])), grid_size=rounding)
    if surely_coverage(shapes):
        return shapes
    i, j = _overlapping_pairs(shapes)
    common, size = _surely(shapely.intersection, shapes[i], shapes[j], rounding), shapely.area(shapes)
    area = shapely.area(common)
    nested = area >= (1 - INNERMOST) * np.minimum(size[i], size[j])
    over = np.flatnonzero((area > 0) & ~nested)
    width = widths(common[over])
    wide = over[width > join]
    if len(wide):
        k = int(wide[width[width > join].argmax()])
        raise _overlapping(shapes, names, (int(i[k]), int(j[k])), common[k], float(width.max()), len(wide) - 1)
    result = shapes.copy()
    for k in over[width > rounding].tolist():
        left = _surely(shapely.difference, result[j[k]], result[i[k]], rounding)
        result[j[k]] = shapely.MultiPolygon(polygons_of(left))
    return result


def _overlapping_pairs(shapes: Shapes) -> tuple[Integers, Integers]:
    """Numbers (k,) of pairs of valid polygons with interior points in common, the lower one first.

    Of both the larger one is prepared, in which only what is near the other one is looked at.
    """
    i, j = shapely.STRtree(shapes).query(shapes)
    i, j = i[i < j], j[i < j]
    size = shapely.get_num_coordinates(shapes)
    larger = size[i] >= size[j]
    one, other = shapes[np.where(larger, i, j)], shapes[np.where(larger, j, i)]
    shapely.prepare(shapes)
    over = shapely.intersects(one, other) & ~shapely.touches(one, other)
    return i[over], j[over]


def _surely(operation: Callable[..., Any], one: Any, other: Any, rounding: float) -> Any:
    """What an operation of Shapely makes of two shapes, or of many: on a grid if rounding would stop it."""
    try:
        return operation(one, other)
    except shapely.errors.GEOSException:
        return operation(one, other, grid_size=rounding)


def _overlapping(
    shapes: Shapes, names: Sequence[str], pair: tuple[int, int], common: shapely.Geometry, width: float, more: int
) -> GeometryError:
    """The error of a pair of shapes with an area in common, up to that width, beside so many ``more`` pairs."""
    most = WIDEST_JOIN * float(np.ptp(shapely.total_bounds(shapes).reshape(2, 2), axis=0).max())
    inner, outer = sorted(pair, key=lambda number: shapely.area(shapes[number]))
    beyond = shapely.difference(shapes[inner], shapes[outer])
    out = float(widths(np.array([beyond]))[0])
    if out < width and float(just_above(out)) <= most:
        return NeighbourError(
            f"{names[inner]!r} sticks out of {names[outer]!r} by {out:.2g} at {place(_inside(beyond))}: set "
            f"join: {just_above(out)} if it is to be inside, or correct the file"
        )
    others = f", and {counted(more, 'more pair')} by less" if more else ""
    both, where = _named(names, *pair), f"{place(_inside(common))}{others}"
    if names[inner] == names[outer]:
        return GeometryError(
            f"two features of {names[inner]!r} overlap by {width:.2g} at {where}: repair: true unites them",
            mendable=False,  # that is told already
        )
    if float(just_above(width)) > most:
        return GeometryError(
            f"{both} overlap by {width:.2g} at {where}, too much for a join: correct the file, leave out one, or set "
            "overlaps: later in domain, by which the later one counts"
        )
    return NeighbourError(
        f"{both} overlap by {width:.2g} at {where}: set join: {just_above(width)} if they are to share a border there, "
        "or correct the file"
    )


def widths(shapes: Shapes) -> Floats:
    """Widths (n,) of the widest places of shapes: twice how far they can be narrowed until nothing is left."""
    if len(shapes) == 0:
        return np.zeros(0)
    area = shapely.area(shapes)
    low, high = area / np.maximum(shapely.length(shapes), 1e-300), np.sqrt(area / np.pi) * (1 + 1e-9)
    low, high = np.minimum(low, high), np.maximum(high, 1e-300)
    for _ in range(WIDTH_HALVINGS):
        middle = np.sqrt(np.maximum(low, 1e-300) * high)
        gone = shapely.is_empty(shapely.buffer(shapes, -middle, quad_segs=2))
        low, high = np.where(gone, low, middle), np.where(gone, middle, high)
    return 2 * high


def _inside(shape: shapely.Geometry) -> Floats:
    parts = shapely.get_parts(shape)
    return shapely.get_coordinates(shapely.point_on_surface(parts[shapely.area(parts).argmax()]))[0]


def _named(names: Sequence[str], one: int, other: int) -> str:
    first, second = sorted([int(one), int(other)])
    return f"{names[first]!r} and {names[second]!r}" if first >= 0 else repr(names[second])
