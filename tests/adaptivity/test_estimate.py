"""The error estimate beside true errors."""

import numpy as np
import pytest

import bubblemesh
from bubblemesh.adaptivity.estimate import estimated, true_error
from bubblemesh.adaptivity.recovery import gradients, recovered_gradients
from bubblemesh.errors import CaseError
from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain

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
