"""Places where the mesh of a file is not conforming: turned or double triangles, overlaps, nodes not connected."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Floats, Integers, complement, components, contained, each_once, extent, first_rows
from bubblemesh.geometry.arrangement.winding import winding_numbers
from bubblemesh.meshes.edges import directed_sides, one_sided, unique_edges
from bubblemesh.meshes.quality import Measures, inverted
from bubblemesh.messages import place

NEAR = 1e-6  # of the shortest side of the rim at a node: nearer nodes count as in its place, nearer sides as through it
ROUNDING = 64  # rounding errors of coordinates; the tolerance is at least as large
INSIDE = 1e-3  # of the way from a side to the corner across: a place where covering triangles are counted
MOST_PROBES = 20_000  # such places, for a mesh in very many pieces


def faults(points: Floats, triangles: Integers, digits: float) -> list[str]:
    """Faults of triangles (t, 3) between points (n, 2), as a file has them, each with its first place.

    Without faults, each place is in one triangle only, all triangles turn the same way, and they share whole sides,
    within a millionth of a side's length. ``digits`` is the rounding error of coordinates near 1.
    """
    return [*_turned(points, triangles), *_faults(points, triangles, digits)]


def _turned(points: Floats, triangles: Integers) -> Iterator[str]:
    """A note on triangles (t, 3) that turn the other way than most, if there are any."""
    found = inverted(points, triangles)
    if len(found):
        what = "1 triangle turns" if len(found) == 1 else f"{len(found):,} triangles turn"
        at = place(points[triangles[found[0]]].mean(axis=0), extent(points))
        yield f"{what} the other way than the rest, the first at {at}: the mesh may lie upon itself there"


def _faults(points: Floats, triangles: Integers, digits: float) -> Iterator[str]:
    size = extent(points)
    ordered = np.sort(triangles, axis=1)
    solid = (ordered[:, :-1] != ordered[:, 1:]).all(axis=1)
    flat = triangles[~solid]
    if len(flat):
        what = "1 triangle has" if len(flat) == 1 else f"{len(flat):,} triangles have"
        yield f"{what} the same node twice, the first at {place(points[flat[0]].mean(axis=0), size)}: no area is in it"
    triangles, ordered = triangles[solid], ordered[solid]
    first = first_rows(ordered)
    again = complement(len(triangles), first)
    if len(again):
        what = "1 triangle is" if len(again) == 1 else f"{len(again):,} triangles are"
        at = place(points[triangles[again[0]]].mean(axis=0), size)
        yield f"{what} there twice, the first at {at}: figures count all"
        triangles = triangles[first]
    edges, count = unique_edges(triangles)
    crowded = edges[count > 2]
    if len(crowded):
        what = "1 edge has" if len(crowded) == 1 else f"{len(crowded):,} edges have"
        yield f"{what} more than two triangles, the first at {place(points[crowded[0]].mean(axis=0), size)}"
    rounding = ROUNDING * digits * float(np.abs(points).max())
    contacts = _contacts(points, edges[count == 1], rounding)
    for nodes, one, many in (
        (contacts.doubled, "node is in the place of another one", "nodes are in places of others"),
        (contacts.hanging, "node hangs in a side", "nodes hang in sides"),
    ):
        if len(nodes):
            what = f"1 {one}" if len(nodes) == 1 else f"{len(nodes):,} {many}"
            yield f"{what}, the first at {place(points[nodes[0]], size)}: the mesh is not connected there"
    overlap = _overlap(points, triangles, contacts.touching, rounding)
    if overlap is not None:
        yield f"the mesh lies upon itself, as at {place(overlap, size)}"


class _Contacts(NamedTuple):
    """Nodes of the rim that are on sides of which they are not ends."""

    doubled: Integers  # (d,): nodes in the place of a node with a lower number
    hanging: Integers  # (h,): nodes between the ends of a side
    touching: Integers  # (k,): all of these nodes, and the ends of the sides


def _contacts(points: Floats, rim: Integers, rounding: float) -> _Contacts:
    """Contacts of the sides (r, 2) of the rim, of coordinates with this rounding error."""
    nodes = each_once(rim.ravel())
    near = np.full(len(points), np.inf)
    np.minimum.at(near, rim.ravel(), np.repeat(NEAR * _lengths(points, rim), 2))
    near += rounding
    tree = shapely.STRtree(shapely.linestrings(points[rim]))
    at, side = tree.query(shapely.points(points[nodes]), predicate="dwithin", distance=near[nodes])
    own = (rim[side] == nodes[at][:, None]).any(axis=1)
    node, ends = nodes[at[~own]], rim[side[~own]]
    same = np.stack([_lengths(points, np.column_stack([node, end])) <= near[node] for end in ends.T], axis=1)
    doubled = np.maximum(node[:, None], ends)[same]
    at_ends = each_once(np.append(node[same.any(axis=1)], doubled))
    hanging = each_once(node[~same.any(axis=1)])
    return _Contacts(each_once(doubled), hanging[~contained(hanging, at_ends)], each_once(np.append(node, ends)))


def _overlap(points: Floats, triangles: Integers, touching: Integers, rounding: float) -> Floats | None:
    """A place (2,) that several triangles cover, or None, of a mesh whose rim touches itself at some nodes.

    If all triangles turn left, the sides without an opposite one form closed walks, whose winding number around a place
    is the number of triangles that cover it. Where two walks cross, a place beside is covered twice. Elsewhere the
    number on the left of a walk changes only where walks touch.
    """
    measures = Measures(points, triangles)
    ahead = np.where((measures.signed_areas < 0)[:, None], triangles[:, ::-1], triangles)
    sides = directed_sides(ahead)
    rows = one_sided(sides, len(points))
    walks = sides[rows]
    crossing = _crossing(points, walks, rounding)
    if crossing is not None or len(walks) == 0:
        return crossing
    nodes, ends = np.unique(walks, return_inverse=True)
    ends = ends.reshape(walks.shape)
    several = np.bincount(ends[:, 0]) > 1
    several |= contained(nodes, touching)
    _, one_each = np.unique(components(ends, len(nodes))[ends[:, 0]], return_index=True)
    chosen = each_once(np.append(np.flatnonzero(several[ends].any(axis=1)), one_each))
    chosen = chosen[:: -(-len(chosen) // MOST_PROBES)]
    number, triangle = np.divmod(rows[chosen], len(triangles))
    across = points[ahead[triangle, (number + 2) % 3]]
    probes = (1 - INSIDE) * points[walks[chosen]].mean(axis=1) + INSIDE * across
    solid = np.abs(measures.signed_areas) > measures.least_areas
    probes = probes[solid[triangle]]
    covered = probes[winding_numbers(points[walks], probes) > 1]
    return covered[0] if len(covered) else None


def _crossing(points: Floats, sides: Integers, rounding: float) -> Floats | None:
    """A place (2,) where two of the sides (m, 2) cross, by more than rounding; None if there is none."""
    lines = shapely.linestrings(points[sides])
    i, j = shapely.STRtree(lines).query(lines, predicate="crosses")
    apart = (i < j) & (sides[i][:, :, None] != sides[j][:, None, :]).all(axis=(1, 2))
    first, second = points[sides[i[apart]]], points[sides[j[apart]]]
    near = NEAR * np.minimum(_lengths(points, sides[i[apart]]), _lengths(points, sides[j[apart]])) + rounding
    deep = (np.abs(_distances(first, second)) > near[:, None]).all(axis=1)
    deep &= (np.abs(_distances(second, first)) > near[:, None]).all(axis=1)
    if not deep.any():
        return None
    k = int(deep.argmax())
    before, after = _distances(first[[k]], second[[k]])[0]
    return np.asarray(second[k, 0] + before / (before - after) * (second[k, 1] - second[k, 0]))


def _distances(lines: Floats, others: Floats) -> Floats:
    """Signed distances (m, 2) of the ends of others (m, 2, 2) from the lines (m, 2, 2), positive on the left."""
    (x, y), away = (lines[:, 1] - lines[:, 0]).T, others - lines[:, :1]
    return (x[:, None] * away[:, :, 1] - y[:, None] * away[:, :, 0]) / np.hypot(x, y)[:, None]


def _lengths(points: Floats, pairs: Integers) -> Floats:
    return np.hypot(*(points[pairs[:, 1]] - points[pairs[:, 0]]).T)
