"""Complete meshes from files: counter-clockwise triangles, labels on the whole boundary, at least one region."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from bubblemesh.arrays import Floats, Integers, extent
from bubblemesh.meshes.edges import directed_sides, edge_keys, find_keys, one_sided
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.metric import ENTRIES
from bubblemesh.meshes.periodic import misfit, rigid_motion
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.meshfiles.faults import faults
from bubblemesh.meshfiles.groups import ALL_NODES, with_ids_as_read
from bubblemesh.meshfiles.metric import metric_of
from bubblemesh.meshfiles.read import left_out_notes, read_mesh
from bubblemesh.messages import shown

BOUNDARY = "boundary"  # label of boundary edges that have none
MOVED = 1e-6  # of the extent: tolerance for nodes of periodic sides and their counterparts, moved
# Names in formats of coasts of data at nodes that give a depth, with factors: depth, or the height of the bed.
DEPTHS = {"depth": 1.0, "elevation": -1.0, "bottom": -1.0, "z": -1.0}


def whole_mesh(path: Path) -> tuple[Mesh, tuple[str, ...]]:
    """Mesh of a file, and notes on what of the file is missing in it; the same errors as `read_triangles`.

    Of the data only a metric is kept, for triangles and nodes.
    """
    read = read_mesh(path)
    mesh = read.mesh
    triangles = mesh.triangles.copy()
    turned = signed_areas(mesh.points, triangles) < 0
    triangles[turned] = triangles[turned][:, ::-1]
    metric = metric_of(read, path)
    mesh = replace(
        mesh,
        triangles=triangles,
        regions=mesh.regions or ("domain",),
        depth=_depth(read.point_data),
    )
    if metric is not None:
        of_triangles, at_nodes = metric
        mesh = replace(mesh, metric=at_nodes, fields=dict(zip(ENTRIES, of_triangles.T, strict=True)))
    own = {*mesh.labels, *mesh.regions, ALL_NODES}
    unread = shown(", ".join(name for name in read.node_sets if name not in own))
    sets = (f"sets of nodes are left out: {unread}",) if unread else ()
    faulty = faults(mesh.points, read.mesh.triangles, read.digits)
    mesh, unmatched = _with_periodic(with_ids_as_read(with_boundary(mesh), read.ids), read.matching)
    return mesh, (*read.notes, *left_out_notes(read.left_out), *read.curved, *sets, *unmatched, *faulty)


def _with_periodic(mesh: Mesh, matching: Sequence[Integers]) -> tuple[Mesh, tuple[str, ...]]:
    """The mesh with pairs of facets whose nodes (k, 2) match, and a note on sides for which they cannot be found."""
    n, outer = len(mesh.points), np.flatnonzero(mesh.outer)
    keys = edge_keys(mesh.facets[outer], n)
    order = np.argsort(keys)
    pairs, missed, tolerance = [mesh.periodic], 0, MOVED * extent(mesh.points)
    for nodes in matching:
        copy = np.full(n, -1)
        copy[nodes[:, 1]] = nodes[:, 0]
        ends = copy[mesh.facets[outer, ::-1]]
        first = np.flatnonzero((ends >= 0).all(axis=1))
        second = find_keys(keys[order], edge_keys(ends[first], n))
        here, there = mesh.points[nodes.T]
        moved = len(first) > 0 and misfit(rigid_motion(here, there, tolerance), here, there) <= tolerance
        if not moved or (second < 0).any():
            missed += 1
        else:
            pairs.append(np.column_stack([outer[first], outer[order[second]]]))
    left_out = f"{missed} of its {len(matching)} pairs of periodic sides are left out"
    note = (f"{left_out}: they are no boundaries that are shifted or turned",)
    return replace(mesh, periodic=np.vstack(pairs)), note if missed else ()


def _depth(data: Mapping[str, Floats]) -> Floats:
    """Depth (n,) at each node, if it is among the data at nodes."""
    known = [name for name in DEPTHS if name in data and data[name].ndim == 1]
    return DEPTHS[known[0]] * data[known[0]] + 0.0 if known else np.zeros(0)


def with_boundary(mesh: Mesh) -> Mesh:
    """The mesh with all boundary edges as facets, with the domain on the left, and a label for those without."""
    sides, n = directed_sides(mesh.triangles), len(mesh.points)
    rim = sides[one_sided(sides, n)]
    facets = _along(mesh.facets[:, :2], rim, n)
    bare = rim[~np.isin(edge_keys(rim, n), edge_keys(facets, n))]
    if len(bare) == 0:
        return replace(mesh, facets=facets)
    labels = mesh.labels if BOUNDARY in mesh.labels else (*mesh.labels, BOUNDARY)
    label = np.append(mesh.facet_labels, np.full(len(bare), labels.index(BOUNDARY)))
    facets = np.vstack([facets, bare])
    middles = mesh.points[facets].mean(axis=1)
    return replace(mesh, facets=facets, facet_labels=label, labels=labels, facet_middles=middles)


def _along(facets: Integers, rim: Integers, n: int) -> Integers:
    """The facets (f, 2), with those of the boundary in the direction of its sides ``rim`` (b, 2)."""
    against = np.isin(edge_keys(facets[:, ::-1], n), edge_keys(rim, n))
    return np.where(against[:, None], facets[:, ::-1], facets)
