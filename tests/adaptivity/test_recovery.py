"""Gradients of piecewise linear fields, and recovered ones."""

import numpy as np
import pytest
from lattices import hexagon

import bubblemesh
from bubblemesh.adaptivity.recovery import gradients, recovered_gradients, split_nodes
from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.triangulation import triangulated

PLATE = Domain.of(rings.rectangle(0, 0, 2, 1), [rings.circle((1, 0.5), 0.2)])


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
