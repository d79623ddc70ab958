"""Quadrilaterals of a mesh: pairs of triangles as cells, their curves in second order, and their parts."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from quadrilaterals import mixed
from squares import holed_square

from bubblemesh.errors import CaseError
from bubblemesh.meshes import division
from bubblemesh.meshes.edge_nodes import folded_triangles
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.quads import halved, quadrilaterals
from bubblemesh.meshes.quality import signed_areas


def paired(mesh):
    """A mesh of squares in which all are quadrilaterals."""
    return dataclasses.replace(mesh, quads=np.arange(len(mesh.triangles)).reshape(-1, 2))


def ring(cells=8, heights=(0.0, 0.1, 0.25), radius=1.0):
    """Layers of quadrilaterals around a circle, the edges along it on true circles."""
    angle = 2 * np.pi * np.arange(cells) / cells
    middle = angle + np.pi / cells
    radii = radius + np.array(heights)
    points = np.concatenate([r * np.column_stack([np.cos(angle), np.sin(angle)]) for r in radii])
    middles = [r * np.column_stack([np.cos(middle), np.sin(middle)]) for r in radii]
    here, there = np.arange(cells), (np.arange(cells) + 1) % cells
    triangles, quads = [], []
    for layer in range(len(heights) - 1):
        a, b, c, d = (
            here + layer * cells,
            there + layer * cells,
            there + (layer + 1) * cells,
            here + (layer + 1) * cells,
        )
        for i in range(cells):  # the inner circle runs clockwise as seen from the layers
            cut = [(a[i], c[i], b[i]), (a[i], d[i], c[i])] if i % 2 else [(d[i], c[i], b[i]), (b[i], a[i], d[i])]
            quads.append((len(triangles), len(triangles) + 1))
            triangles += cut
    outer = (len(heights) - 1) * cells
    inside = [np.column_stack([here, there]) + layer * cells for layer in range(1, len(heights) - 1)]
    return Mesh(
        points,
        np.array(triangles),
        np.concatenate([np.column_stack([there, here]), np.column_stack([here, there]) + outer]),
        np.repeat([0, 1], cells),
        ("bore", "rim"),
        facet_middles=np.concatenate([middles[0], middles[-1]]),
        quads=np.array(quads),
        curved_edges=np.concatenate([*inside, np.zeros((0, 2), int)]),
        curved_middles=np.concatenate([*middles[1:-1], np.zeros((0, 2))]),
    )


def shape(nodes):
    """Places on a quadrilateral of nine nodes (9, 2) at local coordinates, and the Jacobian determinants there."""
    order = np.array([[0, 7, 3], [4, 8, 6], [1, 5, 2]])

    def along(s):
        return np.array([(1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1)])

    def slope(s):
        return np.array([4 * s - 3, 4 - 8 * s, 4 * s - 1])

    s = np.linspace(0, 1, 9)
    x = nodes[order]
    du = np.einsum("ia,jb,ijk->abk", slope(s), along(s), x)
    dv = np.einsum("ia,jb,ijk->abk", along(s), slope(s), x)
    return np.einsum("ia,jb,ijk->abk", along(s), along(s), x), du[..., 0] * dv[..., 1] - du[..., 1] * dv[..., 0]


def test_cells_are_the_other_triangles_and_quadrilaterals():
    mesh = mixed()
    triangles, quads = mesh.cells
    assert len(triangles.nodes) + 2 * len(quads.nodes) == len(mesh.triangles)
    np.testing.assert_array_equal(triangles.nodes, mesh.triangles[triangles.triangles[:, 0]])
    np.testing.assert_array_equal(quads.triangles, mesh.quads)
    for nodes, halves in zip(quads.nodes.tolist(), mesh.triangles[quads.triangles].tolist(), strict=True):
        sides = set(pairwise([*nodes, nodes[0]]))
        of_halves = [side for half in halves for side in pairwise([*half, half[0]])]
        assert sides == {side for side in of_halves if side[::-1] not in of_halves}
    assert sorted(set(mesh.cell_numbers.tolist())) == list(range(len(triangles.nodes) + len(quads.nodes)))
    assert (mesh.cell_numbers[mesh.quads] == len(triangles.nodes) + np.arange(len(quads.nodes))[:, None]).all()


def test_a_mesh_without_quadrilaterals_has_its_triangles():
    mesh = holed_square()
    ((nodes, triangles),) = mesh.cells
    assert nodes is mesh.triangles
    assert triangles.ravel().tolist() == mesh.cell_numbers.tolist() == list(range(len(nodes)))
    np.testing.assert_array_equal(mesh.cell_sides, mesh.sides)
    assert mesh.in_triangles() is mesh
    assert len(mixed().in_triangles().quads) == 0


def test_each_facet_is_a_side_of_a_cell():
    mesh = mixed()
    nodes = [row for cells in mesh.cells for row in cells.nodes.tolist()]
    for facet, (cell, side) in zip(mesh.facets.tolist(), mesh.cell_sides.tolist(), strict=True):
        row = nodes[cell]
        assert [row[side], row[(side + 1) % len(row)]] == facet


@pytest.mark.parametrize("first", range(3))
@pytest.mark.parametrize("second", range(3))
def test_the_halves_may_begin_anywhere(first, second):
    points = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    triangles = np.array([np.roll([0, 1, 2], first), np.roll([0, 2, 3], second)])
    flat = Mesh(points, triangles, np.array([[0, 1], [1, 2], [2, 3], [3, 0]]), np.zeros(4, int), ("rim",))
    mesh, straight = dataclasses.replace(flat, quads=np.array([[0, 1]])).second_order()
    ((nodes, _),) = mesh.cells
    np.testing.assert_array_equal(np.roll(nodes[0, :4], nodes[0, :4].tolist().index(0) * -1), [0, 1, 2, 3])
    corners = mesh.points[nodes[0, :4]]
    np.testing.assert_array_equal(mesh.points[nodes[0, 4:8]], (corners + np.roll(corners, -1, axis=0)) / 2)
    np.testing.assert_array_equal(mesh.points[nodes[0, 8]], [0.5, 0.5])
    assert straight == 0


@pytest.mark.parametrize(
    "quads",
    [[[0, 2]], [[0, 1], [1, 2]], [[0, 0]], [[-1, 0]], [[0, 144]]],
    ids=["apart", "twice", "with itself", "below", "beyond"],
)
def test_pairs_that_are_no_quadrilaterals_are_refused(quads):
    with pytest.raises(CaseError, match="quads: "):
        dataclasses.replace(holed_square(), quads=np.array(quads))


def test_pairs_that_turn_differently_are_refused():
    mesh = holed_square()
    triangles = mesh.triangles.copy()
    triangles[0] = triangles[0, ::-1]
    with pytest.raises(CaseError, match="quads: the triangles 0 and 1 share no edge, or turn different ways"):
        dataclasses.replace(mesh, triangles=triangles, quads=np.array([[0, 1]]))


def test_curved_edges_are_followed_and_middles_are_between():
    flat = ring()
    mesh, straight = flat.second_order()
    assert straight == 0
    along = {
        tuple(sorted(edge)): place for edge, place in zip(flat.curved_edges.tolist(), flat.curved_middles, strict=True)
    }
    found = 0
    for triangle in mesh.triangles.tolist():
        for k in range(3):
            edge = tuple(sorted((triangle[k], triangle[(k + 1) % 3])))
            if edge in along:
                np.testing.assert_array_equal(mesh.points[triangle[3 + k]], along[edge])
                found += 1
    assert found == 2 * len(along)
    ((nodes, _),) = mesh.cells
    for row in nodes:
        places, determinant = shape(mesh.points[row])
        assert (determinant > 0).all()
        radius = np.hypot(*np.moveaxis(places, -1, 0))
        assert radius.min() > 1 - 0.003
        assert radius.max() < 1.25 + 0.003


def test_halves_of_quadrilaterals_have_straight_diagonals_between_straight_sides():
    points = np.array([[0, 0], [2, 0], [1, 1], [0, 1.5]])
    rim = np.array([[0, 1], [1, 2], [2, 3], [3, 0]])
    flat = Mesh(points, np.array([[0, 1, 2], [0, 2, 3]]), rim, np.zeros(4, int), ("rim",), quads=np.array([[0, 1]]))
    mesh, _ = flat.second_order()
    (middle,) = set(mesh.triangles[0, 3:].tolist()) & set(mesh.triangles[1, 3:].tolist())
    np.testing.assert_array_equal(mesh.points[middle], points.mean(axis=0))
    halves = mesh.in_triangles()
    np.testing.assert_allclose(halves.points[middle], [0.5, 0.5], rtol=0, atol=1e-15)
    others = np.arange(len(mesh.points)) != middle
    np.testing.assert_array_equal(halves.points[others], mesh.points[others])


@pytest.mark.parametrize("thickness", [0.002, 0.01, 0.1])
def test_diagonals_of_layers_on_a_curve_bulge_as_these_do_and_halves_do_not_fold(thickness):
    mesh, _ = ring(8, (0, thickness, 2 * thickness)).second_order()
    halves = mesh.in_triangles()
    assert not folded_triangles(halves.points[halves.triangles[:, :3]], halves.points[halves.triangles[:, 3:]]).any()
    radius = np.hypot(*halves.points.T)
    assert radius.min() > 1 - 0.01
    assert radius.max() < 1 + 2 * thickness + 0.01


def test_layers_thinner_than_the_bulge_of_their_wall_stay_curved():
    flat = ring(8, (0, 0.01, 0.02, 0.2))
    assert 1 - np.cos(np.pi / 8) > 0.07  # the wall bulges through both layers
    mesh, straight = flat.second_order()
    assert straight == 0
    ((nodes, _),) = mesh.cells
    assert all((shape(mesh.points[row])[1] > 0).all() for row in nodes)


def test_without_the_curves_of_layers_the_wall_stays_straight_and_is_counted():
    flat = dataclasses.replace(
        ring(8, (0, 0.01, 0.02, 0.2)), curved_edges=np.zeros((0, 2), int), curved_middles=np.zeros((0, 2))
    )
    mesh, straight = flat.second_order()
    assert straight == 8
    corners = flat.points[mesh.facets[:8, :2]].mean(axis=1)
    np.testing.assert_array_equal(mesh.points[mesh.facets[:8, 2]], corners)
    ((nodes, _),) = mesh.cells
    assert all((shape(mesh.points[row])[1] > 0).all() for row in nodes)


def test_what_stays_straight_may_make_its_neighbours_straight():
    flat = ring(8, (0, 0.01, 0.02, 0.2))
    middles = flat.curved_middles.copy()
    middles[1] *= 1.5  # one edge of the first layer cannot bulge so far
    mesh, straight = dataclasses.replace(flat, curved_middles=middles).second_order()
    assert straight >= 3  # it, the wall below it and the edge above it
    assert straight < 8
    ((nodes, _),) = mesh.cells
    assert all((shape(mesh.points[row])[1] > 0).all() for row in nodes)


def test_a_folded_quadrilateral_is_seen_where_its_halves_are_not_folded():
    points = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    facets = np.array([[0, 1], [1, 2], [2, 3], [3, 0]])
    for bulge in np.linspace(0, 0.9, 19):
        middles = points[facets].mean(axis=1)
        middles[0] += [0.3 * bulge, bulge]
        mesh, straight = Mesh(
            points,
            np.array([[0, 1, 2], [0, 2, 3]]),
            facets,
            np.zeros(4, int),
            ("rim",),
            facet_middles=middles,
            quads=np.array([[0, 1]]),
        ).second_order()
        ((nodes, _),) = mesh.cells
        assert (shape(mesh.points[nodes[0]])[1] > 0).all()
        assert straight == 0 if bulge < 0.15 else True
    assert straight == 1


@pytest.mark.parametrize("seed", range(20))
def test_no_cell_folds_over_however_wild_its_curves_are(seed):
    """By the determinants of maps at many places, of which a fold has one that is not positive."""
    rng = np.random.default_rng(seed)
    flat = ring(12, (0, 0.15, 0.3, 0.5))
    flat = dataclasses.replace(
        flat, curved_middles=flat.curved_middles + rng.normal(0, 0.09, flat.curved_middles.shape)
    )
    mesh, straight = flat.second_order()
    assert straight > 0
    ((nodes, _),) = mesh.cells
    assert all((shape(mesh.points[row])[1] > 0).all() for row in nodes)
    a, b = np.array([(i / 8, j / 8) for i in range(9) for j in range(9 - i)]).T
    c = 1 - a - b
    # Derivatives of the six functions in the directions of edges 0-1 and 0-2, by those in the three coordinates.
    zero = 0 * a
    by_corner = [
        np.stack([4 * c - 1, zero, zero, 4 * a, zero, 4 * b], axis=-1),
        np.stack([zero, 4 * a - 1, zero, 4 * c, 4 * b, zero], axis=-1),
        np.stack([zero, zero, 4 * b - 1, zero, 4 * a, 4 * c], axis=-1),
    ]
    places = mesh.points[mesh.triangles]
    u, v = ((by_corner[k] - by_corner[0]) @ places for k in (1, 2))
    assert (u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0] > 0).all()


def test_curves_of_edges_that_are_not_there_are_refused():
    mesh = dataclasses.replace(
        holed_square(), curved_edges=np.array([[0, 1], [0, 40]]), curved_middles=np.zeros((2, 2))
    )
    with pytest.raises(CaseError, match=r"curved_edges: the nodes \[0, 40\] have no edge"):
        mesh.second_order()


@pytest.mark.parametrize("straight", [True, False])
def test_halves_of_second_order_cover_their_quadrilateral(straight):
    """Twice the area of each half and of the quadrilateral, by Green's theorem along quadratic edges."""
    flat = mixed() if straight else ring()
    mesh, _ = flat.second_order()

    def area(corners, middles):
        total = 0.0
        for k, start in enumerate(corners):
            end, middle = corners[(k + 1) % len(corners)], middles[k]
            cross = [a[0] * b[1] - a[1] * b[0] for a, b in ((start, middle), (middle, end), (start, end))]
            total += (4 * cross[0] + 4 * cross[1] - cross[2]) / 6
        return total

    *_, quads = mesh.cells
    p = mesh.points
    for row, halves in zip(quads.nodes, quads.triangles, strict=True):
        whole = area(p[row[:4]], p[row[4:8]])
        parts = [area(p[mesh.triangles[k, :3]], p[mesh.triangles[k, 3:]]) for k in halves]
        assert sum(parts) == pytest.approx(whole, rel=1e-12)
        assert min(parts) > 0


def test_random_quadrilaterals_are_cut_into_triangles_that_turn_as_they_do():
    rng = np.random.default_rng(5)
    points = rng.random((4000, 2))
    cells = np.arange(4000).reshape(-1, 4)
    found = halved(points, cells)
    x, y = np.moveaxis(points[cells], -1, 0)
    whole = (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1) / 2
    areas = signed_areas(points, found.triangles)
    sums = np.bincount(found.cells, areas)
    np.testing.assert_allclose(sums, whole, atol=1e-15)
    fine = ~np.isin(found.cells, found.crossed)
    assert (areas[fine] * whole[found.cells[fine]] > 0).all()
    assert (np.bincount(found.cells) == 2).all()
    ahead = np.roll(points[cells], -1, axis=1) - points[cells]
    back = np.roll(ahead, 1, axis=1)
    turns = back[..., 0] * ahead[..., 1] - back[..., 1] * ahead[..., 0]
    convex = (np.abs(np.sign(turns).sum(axis=1)) == 4) & ~np.isin(np.arange(1000), found.crossed)
    np.testing.assert_array_equal(np.flatnonzero(convex), found.cells[found.quads[:, 0]])
    again = quadrilaterals(found.triangles, found.quads)
    turned = [np.roll(row, -row.index(min(row))).tolist() for row in again.tolist()]
    assert turned == cells[convex].tolist()
    kinds = [*found.dented, *found.crossed, *np.flatnonzero(convex)]
    assert sorted(kinds) == list(range(1000))
    assert min(len(found.dented), len(found.crossed), convex.sum()) > 100


@pytest.mark.parametrize("made", [mixed, lambda: paired(holed_square(12)), lambda: ring(40, (0, 0.1, 0.2, 0.4))])
@pytest.mark.parametrize("count", [1, 2, 7, 16])
@pytest.mark.parametrize("way", ["METIS", "geometry"])
def test_both_halves_come_into_one_part_and_parts_have_like_numbers_of_triangles(way, count, made, monkeypatch):
    if way == "geometry":
        monkeypatch.setattr(division, "find_spec", lambda name: None)
    else:
        pytest.importorskip("pymetis")
    mesh = made()
    partition = mesh.partitioned(count).partition
    owner = partition.owner
    assert (owner[mesh.quads[:, 0]] == owner[mesh.quads[:, 1]]).all()
    assert partition.sizes.min() >= 1
    if partition.by == "METIS":
        assert partition.sizes.max() <= np.ceil(1.03 * len(mesh.triangles) / count) + 1
    else:
        assert np.ptp(partition.sizes) <= 4


def test_each_cell_may_be_a_part_but_no_half_one(monkeypatch):
    mesh = mixed()
    cells = sum(len(cells.nodes) for cells in mesh.cells)
    for _ in range(2):
        assert len(np.unique(mesh.partitioned(cells).partition.owner)) == cells
        monkeypatch.setattr(division, "find_spec", lambda name: None)
    with pytest.raises(CaseError, match=f"a mesh of {cells} cells has from 1 to {cells} parts"):
        mesh.partitioned(cells + 1)
