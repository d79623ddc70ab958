"""The error estimate beside true errors; gradients of piecewise linear fields, and recovered ones."""

import numpy as np
import pytest
from lattices import hexagon

import bubblemesh
from bubblemesh.adaptivity.estimate import estimated, gradients, recovered_gradients, split_nodes, true_error
from bubblemesh.errors import CaseError
from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.triangulation import triangulated

PLATE = Domain.of(rings.rectangle(0, 0, 2, 1), [rings.circle((1, 0.5), 0.2)])
SMOOTH = {
    "x^2": lambda x, y: x * x,
    "saddle": lambda x, y: x * y - 3 * y,
    "wave": lambda x, y: np.sin(3 * x) * np.exp(y),
}


@pytest.fixture(scope="module")
def meshes():
    return [bubblemesh.mesh(PLATE, f"{h} + {h}*x") for h in (0.1, 0.05, 0.025)]


def test_a_linear_field_has_no_error(meshes):
    points, triangles = meshes[0].points, meshes[0].triangles
    found = estimated(points, triangles, points @ np.array([[1.0, 2], [3, -1]]) + 5)
    assert found.error < 1e-12
    assert found.relative < 1e-12
    assert found.norm == pytest.approx(np.sqrt((1 + 9 + 4 + 1) * (2 - np.pi * 0.04)), rel=1e-2)


def test_a_constant_field_has_no_error(meshes):
    found = estimated(meshes[0].points, meshes[0].triangles, np.full((len(meshes[0].points), 1), 0.1))
    assert (found.error, found.norm, found.relative) == (0, 0, 0)


@pytest.mark.parametrize("name", SMOOTH)
def test_estimates_of_smooth_fields_come_to_the_true_errors(meshes, name):
    off = []
    for mesh in meshes:
        values = SMOOTH[name](*mesh.points.T)
        true = true_error(mesh.points, mesh.triangles, values, SMOOTH[name])
        off.append(abs(estimated(mesh.points, mesh.triangles, values[:, None]).error / true - 1))
    assert off[0] < 0.05
    assert off[-1] < 0.01
    assert off[-1] < off[0]


@pytest.mark.parametrize("name", SMOOTH)
def test_estimates_fall_with_the_size(meshes, name):
    errors = [estimated(m.points, m.triangles, SMOOTH[name](*m.points.T)[:, None]).error for m in meshes]
    order = np.polyfit(np.log([0.1, 0.05, 0.025]), np.log(errors), 1)[0]
    assert order == pytest.approx(1, abs=0.1)


def test_integrals_are_those_of_a_quadrature(meshes):
    mesh = meshes[0]
    values = np.random.default_rng(1).normal(size=(len(mesh.points), 2))
    own = gradients(mesh.points, mesh.triangles, values)
    corners = recovered_gradients(mesh.points, mesh.triangles, own)[mesh.triangles]
    (ux, uy), (vx, vy) = (mesh.points[mesh.triangles[:, k]].T - mesh.points[mesh.triangles[:, 0]].T for k in (1, 2))
    total = 0.0
    for i, j in ((0, 1), (1, 2), (2, 0)):  # midpoints of the edges are exact for quadratic functions
        total = total + (((corners[:, i] + corners[:, j]) / 2 - own) ** 2).sum(axis=(1, 2)) / 3
    expected = np.sqrt(total * (ux * vy - uy * vx) / 2)
    np.testing.assert_allclose(estimated(mesh.points, mesh.triangles, values).indicators, expected, rtol=1e-10)


def test_errors_of_components_add_up_in_squares(meshes):
    mesh = meshes[0]
    values = np.column_stack([SMOOTH["x^2"](*mesh.points.T), SMOOTH["wave"](*mesh.points.T)])
    both = estimated(mesh.points, mesh.triangles, values)
    one, other = (estimated(mesh.points, mesh.triangles, values[:, [k]]) for k in (0, 1))
    np.testing.assert_allclose(both.indicators, np.hypot(one.indicators, other.indicators))
    assert both.norm == pytest.approx(np.hypot(one.norm, other.norm))
    assert both.relative == pytest.approx(both.error / np.hypot(both.norm, both.error))


def test_a_material_s_jump_is_no_error():
    text = "domain: {outer: {rectangle: [0, 0, 2, 1]}, regions: [{name: a, ring: {rectangle: [0, 0, 0.7, 1]}}]}\n"
    mesh = bubblemesh.mesh_case(bubblemesh.load_case("-", text=text + "spacing: 0.1")).mesh
    kink = np.where(mesh.points[:, 0] < 0.7, mesh.points[:, 0], 0.7 + 5 * (mesh.points[:, 0] - 0.7))[:, None]
    assert estimated(mesh.points, mesh.triangles, kink, mesh.triangle_regions).relative < 1e-12
    assert estimated(mesh.points, mesh.triangles, kink).relative > 0.02


def test_the_true_error_of_a_quadratic_field():
    points = np.array([[0.0, 0], [1, 0], [0, 1]])
    # Of x^2 on this triangle the interpolant is x, and the integral of (2 x - 1)^2 is 1/6.
    found = true_error(points, np.array([[0, 1, 2]]), points[:, 0] ** 2, lambda x, y: x * x)
    assert found == pytest.approx(np.sqrt(1 / 6), rel=1e-8)


def test_an_exact_solution_without_gradient_names_the_place():
    points = np.array([[0.0, 0], [3, 0], [0, 3]])
    with pytest.raises(CaseError, match=r"no gradient at \(1, 1\)"):
        true_error(points, np.array([[0, 1, 2]]), points[:, 0], lambda x, y: np.where(x < 1, np.nan, x))


@pytest.fixture(scope="module")
def plate():
    return bubblemesh.mesh(PLATE, "0.08 + 0.05*x")


def hexagonal_mesh(side):
    """The lattice in a hexagon: points, triangles, and which are inside."""
    points = hexagon(side)
    rim = np.hypot(*points.T) > side * np.sqrt(3) / 2 - 1e-9
    radius = np.abs(points @ np.array([[np.sqrt(3) / 2, 0, -np.sqrt(3) / 2], [0.5, 1, 0.5]])).max(axis=1)
    on_rim = np.flatnonzero(rim & (radius > side * np.sqrt(3) / 2 - 1e-9))
    order = on_rim[np.argsort(np.arctan2(*points[on_rim].T[::-1]))]
    triangles = triangulated(points, np.column_stack([order, np.roll(order, -1)]))
    inside = np.ones(len(points), bool)
    inside[on_rim] = False
    return points, triangles, inside


def test_gradients_by_differences(plate):
    values = np.random.default_rng(0).normal(size=(len(plate.points), 2))
    found = gradients(plate.points, plate.triangles, values)
    for t in (0, 17, len(plate.triangles) - 1):
        a, b, c = plate.triangles[t]
        for k in range(2):
            for other in (b, c):
                rise = found[t, k] @ (plate.points[other] - plate.points[a])
                assert rise == pytest.approx(values[other, k] - values[a, k])


def test_a_linear_field_is_recovered_everywhere(plate):
    values = plate.points @ np.array([[3.0, 0.5], [-1.0, 2.0]]) + [7, -100]
    found = recovered_gradients(plate.points, plate.triangles, gradients(plate.points, plate.triangles, values))
    np.testing.assert_allclose(found, np.broadcast_to([[3, -1], [0.5, 2]], found.shape), atol=1e-11)


@pytest.mark.parametrize("hessian", [[[2, 0], [0, 0]], [[1, 3], [3, -2]]])
def test_quadratic_fields_are_recovered_exactly_inside_a_lattice(hessian):
    points, triangles, inside = hexagonal_mesh(4)
    values = np.einsum("ni,ij,nj->n", points, np.array(hessian), points)[:, None] / 2
    found = recovered_gradients(points, triangles, gradients(points, triangles, values))[:, 0]
    np.testing.assert_allclose(found[inside], (points @ np.array(hessian))[inside], atol=1e-12)


def test_recovered_gradients_are_nearer_to_the_truth_also_on_the_boundary(plate):
    def slope(points):
        x, y = points.T
        return np.column_stack([3 * np.cos(3 * x + y), np.cos(3 * x + y)])

    values = np.sin(3 * plate.points[:, 0] + plate.points[:, 1])[:, None]
    own = gradients(plate.points, plate.triangles, values)
    found = recovered_gradients(plate.points, plate.triangles, own)[:, 0]
    rim = np.unique(plate.facets)
    error = np.hypot(*(found - slope(plate.points)).T)
    raw = np.hypot(*(own[:, None, 0] - slope(plate.points)[plate.triangles]).reshape(-1, 2).T)
    assert error.mean() < 0.2 * raw.mean()
    assert error[rim].mean() < 0.5 * raw.mean()


def test_moving_scaling_and_turning_change_nothing(plate):
    values = np.exp(plate.points[:, :1])
    angle, offset, size = 0.7, [1e4, -3e3], 1e-3
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    moved = size * plate.points @ turn.T + offset
    one, other = (
        recovered_gradients(points, plate.triangles, gradients(points, plate.triangles, values))[:, 0]
        for points in (plate.points, moved)
    )
    np.testing.assert_allclose(other * size @ turn, one, atol=1e-4)


@pytest.mark.parametrize("triangles", [[[0, 1, 2]], [[0, 1, 2], [1, 3, 2]], [[0, 1, 2], [1, 3, 2], [3, 4, 2]]])
def test_meshes_without_inner_nodes_have_the_mean_of_their_triangles(triangles):
    points = np.array([[0.0, 0], [1, 0], [0, 1], [1, 1], [0.5, 2]])[: np.max(triangles) + 1]
    triangles = np.array(triangles)
    own = np.arange(2.0 * len(triangles)).reshape(-1, 1, 2)
    found = recovered_gradients(points, triangles, own)
    assert np.isfinite(found).all()
    for node in range(len(points)):
        mine = (triangles == node).any(axis=1)
        area = np.array([0.5, 0.5, 0.25])[: len(triangles)]
        if len(triangles) < 3:
            np.testing.assert_allclose(found[node, 0], (area[mine] @ own[mine, 0]) / area[mine].sum())


def test_gradients_jump_between_parts_only():
    points, triangles, _ = hexagonal_mesh(3)
    upper = (points[triangles].mean(axis=1)[:, 1] > 0).astype(int)
    own = gradients(points, triangles, np.abs(points[:, 1:]))  # a kink along a row of the lattice
    split, corners = split_nodes(points, triangles, upper)
    np.testing.assert_array_equal(split[corners], points[triangles])
    assert not set(corners[upper == 0].ravel()) & set(corners[upper == 1].ravel())
    found = recovered_gradients(split, corners, own)[corners]
    np.testing.assert_allclose(found[:, :, 0], np.stack([0 * upper, 2 * upper - 1], axis=1)[:, None] + np.zeros((3, 2)))
    smeared = recovered_gradients(points, triangles, own)
    assert np.abs(smeared[np.abs(points[:, 1]) < 0.1, 0, 1]).max() < 0.5
