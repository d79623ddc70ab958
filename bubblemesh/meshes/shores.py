"""The boundary of a mesh of water, in order: rings of edges, and their stretches: open water, land and islands."""

import re
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Integers, components, ring_area
from bubblemesh.meshes.edges import edge_keys, find_sides, neighbour_pairs
from bubblemesh.meshes.mesh import Mesh

Kind = Literal["open", "land", "island"]
OPEN = re.compile(r"open(?![A-Za-z])", re.IGNORECASE)  # such as open, open_west, open-2, open 3


class Stretch(NamedTuple):
    """A chain of boundary edges of one kind.

    An island is a whole ring, without the first node at its end; any other whole ring ends with its first node.
    """

    kind: Kind
    label: str  # of an island, all of its labels, with commas
    nodes: Integers  # (k,) in order, with the water on the left


def is_open(mesh: Mesh, label: str) -> bool:
    """Whether a label is that of an open boundary: one of the mesh's ``open_labels``; by its name if it has none."""
    return label in mesh.open_labels if mesh.open_labels else OPEN.match(label) is not None


def closed_facets(mesh: Mesh) -> Integers:
    """Boundary facets (k, 2) that are not open, as pairs of nodes."""
    shut = np.array([not is_open(mesh, label) for label in mesh.labels])
    return mesh.facets[mesh.outer & shut[mesh.facet_labels], :2]


def dead_ends(mesh: Mesh) -> Booleans:
    """Mask (t,) of the triangles with at least two closed sides, which are joined to the sea by one side at most."""
    count = np.zeros(len(mesh.triangles), np.int64)
    owner, _ = find_sides(mesh.triangles, len(mesh.points), closed_facets(mesh))
    np.add.at(count, owner[owner >= 0], 1)
    return count > 1


def cut_off(mesh: Mesh) -> Booleans:
    """Mask (t,) of the triangles from which no path through sides of triangles, not only points, leads to an open side.

    If nothing is open, these are the triangles outside of the largest part.
    """
    triangles = mesh.triangles
    part = components(neighbour_pairs(triangles[:, :3]), len(triangles))
    shut = closed_facets(mesh)
    opened = mesh.facets[mesh.outer, :2]
    opened = opened[~np.isin(edge_keys(opened, len(mesh.points)), edge_keys(shut, len(mesh.points)))]
    owner, _ = find_sides(triangles, len(mesh.points), opened)
    reached = part[owner[owner >= 0]] if len(opened) else [np.bincount(part).argmax()]
    return ~np.isin(part, reached)


def stretches(mesh: Mesh) -> list[Stretch]:
    """Stretches of the boundary, ring by ring: outer rings first, the largest of them before the others.

    A ring around a hole without an open label is an island. Any other ring is cut where its labels change.
    """
    opened = [is_open(mesh, label) for label in mesh.labels]
    found = []
    for ring in boundary_rings(mesh):
        nodes, labels = mesh.facets[ring, 0], mesh.facet_labels[ring]
        if ring_area(mesh.points[nodes]) < 0 and not any(opened[k] for k in labels.tolist()):
            names = [mesh.labels[k] for k in dict.fromkeys(labels.tolist())]
            found.append(Stretch("island", ", ".join(names), nodes))
            continue
        first = np.flatnonzero(labels != np.roll(labels, 1))
        start = int(first[0]) if len(first) else 0
        nodes, labels = np.roll(nodes, -start), np.roll(labels, -start)
        ends = [*np.flatnonzero(np.diff(labels)).tolist(), len(labels) - 1]
        begin = 0
        for end in ends:
            label = int(labels[begin])
            along = np.append(nodes[begin : end + 1], nodes[(end + 1) % len(nodes)])
            found.append(Stretch("open" if opened[label] else "land", mesh.labels[label], along))
            begin = end + 1
    return found


def boundary_rings(mesh: Mesh) -> list[Integers]:
    """Numbers (k,) of the boundary facets of each ring in order, the domain on their left; outer rings first.

    No ring has a node twice: rings that meet at a node are separate.
    """
    leaving: dict[int, list[int]] = {}
    for facet in np.flatnonzero(mesh.outer).tolist():
        leaving.setdefault(int(mesh.facets[facet, 0]), []).append(facet)
    rings = []
    for start in list(leaving):
        path, place = list[int](), {start: 0}  # facets since the start, and the number of those before each node
        node = start
        while leaving.get(node):
            path.append(leaving[node].pop())
            node = int(mesh.facets[path[-1], 1])
            if node in place:
                ring = path[place[node] :]
                del path[place[node] :]
                for facet in ring[1:]:
                    del place[int(mesh.facets[facet, 0])]
                rings.append(np.array(ring))
            else:
                place[node] = len(path)
    return sorted(rings, key=lambda ring: -ring_area(mesh.points[mesh.facets[ring, 0]]))


def stretch_of_nodes(found: Sequence[Stretch], count: int) -> Integers:
    """Number (n,) of the stretch of each node, -1 inside; of two, an open one first, else the one that goes on."""
    number = np.full(count, -1)
    opened = [k for k, each in enumerate(found) if each.kind == "open"]
    closed = [k for k, each in enumerate(found) if each.kind != "open"]
    for k in closed:
        number[found[k].nodes if found[k].kind == "island" else found[k].nodes[:-1]] = k
    for k in opened:
        number[found[k].nodes[-1]] = k
    for k in opened:
        number[found[k].nodes[:-1]] = k
    return number
