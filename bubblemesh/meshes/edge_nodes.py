"""Nodes on the edges of cells of second order: on the true curves, except where a cell would fold over."""

from dataclasses import replace
from math import comb
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.errors import CaseError
from bubblemesh.meshes.edges import edge_keys, find_keys, numbered_edges
from bubblemesh.meshes.metric import at_centroids
from bubblemesh.meshes.quads import quadrilaterals

if TYPE_CHECKING:
    from bubblemesh.meshes.mesh import Mesh

M = TypeVar("M", bound="Mesh")

# Control points of a quadratic curve by its nodes at the start, in the middle and at the end.
CONTROL = np.array([[1, 0, 0], [-0.5, 2, -0.5], [0, 0, 1]])
# Positions of the nodes of a quadrilateral in a grid of three by three.
GRID = np.array([[0, 7, 3], [4, 8, 6], [1, 5, 2]])
# Coefficients k of the product of a linear polynomial, with coefficients i, and a quadratic one, with j, in Bernstein
# form.
PRODUCT = np.array(
    [[[comb(1, i) * comb(2, j) / comb(3, k) * (i + j == k) for j in range(3)] for i in range(2)] for k in range(4)]
)


def in_second_order(mesh: M) -> tuple[M, int]:
    """The mesh with a node on each edge, and the number of curved edges that stay straight; see `Mesh.second_order`."""
    if mesh.order == 2:
        return mesh, 0
    corners, n = mesh.triangles, len(mesh.points)
    edges, of_triangle = numbered_edges(corners)
    keys = edge_keys(edges, n)
    facets, others = (
        find_keys(keys, edge_keys(np.sort(pairs[:, :2], axis=1), n)) for pairs in (mesh.facets, mesh.curved_edges)
    )
    for name, pairs, numbers in (("facets", mesh.facets, facets), ("curved_edges", mesh.curved_edges, others)):
        if (numbers < 0).any():
            raise CaseError(f"{name}: the nodes {pairs[np.argmin(numbers)].tolist()} have no edge")
    straight = mesh.points[edges].mean(axis=1)
    curved = straight.copy()
    curved[others] = mesh.curved_middles
    curved[facets] = mesh.facet_middles
    numbered = np.hstack([corners, of_triangle])
    middles, kept_straight = without_folds(mesh.points, numbered, mesh.quads, straight, curved)
    triangles = np.hstack([corners, n + of_triangle])
    result = replace(
        mesh,
        points=np.vstack([mesh.points, middles]),
        triangles=triangles,
        facets=np.column_stack([mesh.facets[:, :2], n + facets]),
        depth=np.append(mesh.depth, mesh.depth[edges].mean(axis=1)) if len(mesh.depth) else mesh.depth,
        metric=np.vstack([mesh.metric, at_centroids(edges, mesh.metric)]) if len(mesh.metric) else mesh.metric,
        partition=None if mesh.partition is None else mesh.partition.with_nodes(triangles),
    )
    return result, int(kept_straight.sum())


def without_folds(
    points: Floats, triangles: Integers, quads: Integers, straight: Floats, curved: Floats
) -> tuple[Floats, Booleans]:
    """Nodes (e, 2) of edges, ``curved`` ones where no cell folds over; and the mask (e,) of edges that stay straight.

    Parameters
    ----------
    points : (n, 2)
        Corners of the triangles.
    triangles : (t, 6)
        Counter-clockwise corners, and the numbers of edges 0-1, 1-2 and 2-0.
    quads : (q, 2)
        Pairs of triangles that are a quadrilateral. Its middle node, on their diagonal, follows from the others: it is
        where the map of the eight nodes around has its centre.
    straight, curved : (e, 2)
        Middles of the edges, and the places of their nodes on the curves.
    """
    cells = quadrilaterals(triangles, quads)
    middles, bent = curved.copy(), (curved != straight).any(axis=1)
    bent[cells[:, 8]] = False
    sides = triangles[:, [3, 4, 5, 5]]  # of the cell of each triangle
    sides[quads] = cells[:, None, 4:8]
    flat, looked_at = np.zeros(len(middles), bool), np.arange(len(triangles))
    while True:
        middles[cells[:, 8]] = middles[cells[:, 4:8]].sum(axis=1) / 2 - points[cells[:, :4]].sum(axis=1) / 4
        rows = triangles[looked_at]
        folded = looked_at[folded_triangles(points[rows[:, :3]], middles[rows[:, 3:]])]
        quads_folded = folded_quads(points[cells[:, :4]], middles[cells[:, 4:]])
        mine = np.concatenate([sides[folded].ravel(), cells[quads_folded, 4:8].ravel()])
        mine = mine[bent[mine]]
        if len(mine) == 0:
            return middles, flat
        # An edge made straight may lie beyond a neighbour's curved one, so these cells are looked at again.
        middles[mine], bent[mine], flat[mine] = straight[mine], False, True
        moved = np.zeros(len(middles), bool)
        moved[mine] = True
        looked_at = np.flatnonzero(moved[sides].any(axis=1))


def with_diagonals(points: Floats, triangles: Integers, quads: Integers) -> Floats:
    """The nodes (n, 2) of triangles (t, 6) with those of the quadrilaterals' diagonals as triangles want them.

    The middle node of a quadrilateral that is no parallelogram is off its diagonal. Here it is in the middle of that,
    moved by the half of what the four sides bulge, but where a half of the pairs (q, 2) would fold over.
    """
    cells, moved = quadrilaterals(triangles, quads), points.copy()
    corners = points[cells[:, :4]]  # the diagonal is from the second to the fourth one
    moved[cells[:, 8]] += corners[:, [1, 3]].mean(axis=1) - corners.mean(axis=1)
    halves = triangles[quads]
    folded = folded_triangles(moved[halves[..., :3]].reshape(-1, 3, 2), moved[halves[..., 3:]].reshape(-1, 3, 2))
    kept = cells[folded.reshape(-1, 2).any(axis=1), 8]
    moved[kept] = points[kept]
    return moved


def folded_triangles(corners: Floats, middles: Floats) -> Booleans:
    """Mask (t,) of curved triangles, corners (t, 3, 2) and edge nodes (t, 3, 2), whose map is not one to one.

    The Jacobian determinant of the map is a quadratic polynomial: it is positive if its Bernstein coefficients are.
    """
    # Twice the derivatives along edges 0-1 and 0-2 as linear functions, by their values at the three corners.
    a, b, c = np.moveaxis(corners, 1, 0)
    ab, bc, ca = np.moveaxis(middles, 1, 0)
    u = np.stack([4 * ab - 3 * a - b, a + 3 * b - 4 * ab, 4 * bc - 4 * ca - b + a], axis=1)
    v = np.stack([4 * ca - 3 * a - c, 4 * bc - 4 * ab - c + a, a + 3 * c - 4 * ca], axis=1)
    product = u[:, :, None, 0] * v[:, None, :, 1] - u[:, :, None, 1] * v[:, None, :, 0]
    coefficients = (product + product.swapaxes(1, 2)) / 2
    return (coefficients <= 0).any(axis=(1, 2))


def folded_quads(corners: Floats, others: Floats) -> Booleans:
    """Mask (q,) of curved quadrilaterals, corners (q, 4, 2) and other nodes (q, 5, 2), whose map is not one to one.

    The test is that of `folded_triangles`, with polynomials of the third degree in both directions.
    """
    nodes = np.concatenate([corners, others], axis=1)[:, GRID]
    control = np.einsum("ai,bj,qijd->qabd", CONTROL, CONTROL, nodes)
    u, v = np.diff(control, axis=1), np.diff(control, axis=2)
    product = np.einsum("qijx,qmny->qijmnxy", u, v)
    cross = product[..., 0, 1] - product[..., 1, 0]
    coefficients = np.einsum("kim,lnj,qijmn->qkl", PRODUCT, PRODUCT, cross)
    return (coefficients <= 0).any(axis=(1, 2))
