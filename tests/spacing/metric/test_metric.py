import numpy as np
import pytest
from metrics import tensor_metric, uniform_metric

from bubblemesh.errors import CaseError
from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.tensors import lengths
from bubblemesh.meshes.tensors import axes, of_axes
from bubblemesh.spacing.metric.metric import STRAIGHT
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.survey import surveyed


def around_a_circle(across, along, radius):
    """Ellipses along circles around the origin, narrow at one radius."""

    def tensors(x, y):
        r = np.hypot(x, y)
        direction = np.column_stack([-y, x]) / r[:, None]
        return of_axes(np.minimum(across + 0.2 * np.abs(r - radius), along), np.full(len(x), along), direction)

    return tensor_metric(tensors, along / across)


def test_the_spacing_along_a_boundary_is_that_in_its_direction():
    domain = Domain.of(rings.polygon([[0, 0], [1, 0], [1, 1], [0, 1]]))
    metric = uniform_metric(0.01, 0.1, 0.0)
    d = metric.along(domain.boundary, np.arange(4), np.full(4, 0.5))
    np.testing.assert_allclose(d, [0.1, 0.01, 0.1, 0.01])


def test_between_the_ends_of_an_edge_the_spacing_is_that_in_its_direction():
    points, edges = np.array([[0.0, 0.0], [0.3, 0.0], [0.0, 0.3]]), np.array([[0, 1], [0, 2]])
    np.testing.assert_allclose(uniform_metric(0.01, 0.1, 0.0).between(points, edges), [0.1, 0.01])


def test_the_ideal_number_is_that_of_the_stretched_domain():
    domain = Domain.of(rings.polygon([[0, 0], [1, 0], [1, 1], [0, 1]]))
    stretched = Domain.of(rings.polygon([[0, 0], [1, 0], [1, 8], [0, 8]]))
    circles = surveyed(stretched, Spacing(lambda x, y: np.full(x.shape, 0.2)), 10**6)
    ellipses = surveyed(domain, uniform_metric(0.025, 0.2, 0.0), 10**6)
    assert ellipses.ideal_nodes == pytest.approx(circles.ideal_nodes, rel=1e-3)


def test_a_metric_that_is_not_positive_is_refused_with_its_place():
    metric = tensor_metric(lambda x, y: np.column_stack([1 - x, np.zeros(len(x)), np.ones(len(x))]))
    assert metric(np.array([[0.5, 0.0]]))[0] > 0
    with pytest.raises(CaseError, match=r"not positive definite and finite at \(2, 0\)"):
        metric(np.array([[0.5, 0.0], [2.0, 0.0]]))


def test_a_metric_in_one_direction_needs_no_shorter_ellipses():
    points = np.random.default_rng(0).uniform(-1, 1, (50, 2))
    metric = uniform_metric(0.001, 0.1, 0.3)
    np.testing.assert_allclose(metric.straightened().at(points), metric.at(points), rtol=1e-6)


@pytest.mark.parametrize("across", [0.02, 0.003, 0.001])
def test_straight_edges_can_follow_the_ellipses_of_a_straightened_metric(across):
    metric = around_a_circle(across, 0.1, 0.5)
    straight = metric.straightened()
    angle = np.linspace(0, 6, 50)
    points = 0.5 * np.column_stack([np.cos(angle), np.sin(angle)])
    narrow, along, direction = axes(straight.at(points))
    assert (along < 0.1 - 1e-3).all() == (across < 0.02)
    np.testing.assert_allclose(narrow, across, rtol=1e-6)
    edge = along[:, None] * direction
    there = [lengths(straight.at(points + side * edge / 2), edge) for side in (-1, 1)]
    assert np.max(there) < 1.15 * STRAIGHT


def test_triangles_that_the_metric_stretches_to_equilateral_ones_have_quality_1():
    points = np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 0.05 * np.sqrt(3)]])
    triangles = np.array([[0, 1, 2]])
    assert uniform_metric(0.01, 0.1, 0.0).measures(points, triangles).radius_ratios[0] == pytest.approx(1)
    plain = Spacing(lambda x, y: np.ones(x.shape)).measures(points, triangles)
    assert plain.radius_ratios[0] < 0.1
