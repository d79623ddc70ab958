import numpy as np
import pytest

from bubblemesh.case import load_case
from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.problem.prepare import prepare
from bubblemesh.run.pipeline import mesh_problem
from bubblemesh.spacing.grid.table import ROUGH, SMALLEST_IN_SPACINGS, TOLERANCE, tabulated
from bubblemesh.spacing.spacing import Spacing

PLATE = Domain.of(rings.rectangle(-1, -1, 1, 1), [rings.circle((0, 0), 0.4)])
POINTS = np.random.default_rng(3).uniform(-1, 1, (20_000, 2))
INSIDE = POINTS[PLATE.contains(POINTS)]


def cone(x, y):
    return 0.02 + 0.2 * np.abs(np.hypot(x, y) - 0.4)


def bent(x, y):
    return 0.02 + 0.3 * np.abs(x - 0.3 * y)


def jumping(x, y):
    return np.where(x > 0.1 * y, 0.05, 0.1)


def spotted(x, y):
    return np.minimum(0.1, 0.01 + 0.4 * np.hypot(x - 0.617, y + 0.593))


class Counted:
    """A function that counts where it is asked."""

    def __init__(self, function):
        self.function, self.asked = function, []

    def __call__(self, x, y):
        self.asked.append(np.column_stack([x, y]))
        return self.function(x, y)

    def asked_since(self):
        asked, self.asked = self.asked, []
        return np.concatenate([np.zeros((0, 2)), *asked])


def tables(function):
    counted = Counted(function)
    spacing = tabulated(PLATE, Spacing(counted, 0.003, costly=True))
    counted.asked_since()
    return counted, spacing


@pytest.mark.parametrize("function", [cone, bent, jumping, spotted])
def test_values_are_right_within_the_tolerance(function):
    _, spacing = tables(function)
    error = np.abs(spacing(INSIDE) / function(*INSIDE.T) - 1)
    assert np.quantile(error, 0.97) < TOLERANCE
    assert error.max() < ROUGH


def test_what_is_bilinear_is_exact():
    _, spacing = tables(lambda x, y: 0.1 + 0.02 * x - 0.01 * y + 0.03 * x * y)
    np.testing.assert_allclose(
        spacing(INSIDE), 0.1 + 0.02 * INSIDE[:, 0] - 0.01 * INSIDE[:, 1] + 0.03 * INSIDE.prod(1), rtol=1e-12
    )


@pytest.mark.parametrize("function", [cone, spotted])
def test_the_function_is_hardly_asked_any_more(function):
    counted, spacing = tables(function)
    spacing(INSIDE)
    assert len(counted.asked_since()) < 0.02 * len(INSIDE)


def test_the_function_is_not_asked_for_no_points():
    counted, spacing = tables(lambda x, y: 0.1 + 0.02 * x)
    spacing(INSIDE)
    assert counted.asked == []


def test_beside_a_jump_the_function_is_asked_and_nowhere_else():
    counted, spacing = tables(jumping)
    np.testing.assert_allclose(spacing(INSIDE), jumping(*INSIDE.T), rtol=1e-14)
    x, y = counted.asked_since().T
    assert len(x) > 0
    assert np.abs(x - 0.1 * y).max() < 2 * SMALLEST_IN_SPACINGS * 0.05


def test_outside_the_domain_the_function_is_asked():
    _, spacing = tables(cone)
    outside = np.array([[0.0, 0.0], [0.05, 0.1], [1.5, 0.0], [-0.3, -7.0]])
    np.testing.assert_array_equal(spacing.extended(outside), np.maximum(cone(*outside.T), 0.003))


def test_the_function_may_be_undefined_in_a_hole():
    with np.errstate(invalid="ignore"):
        _, spacing = tables(lambda x, y: 0.05 + 0.1 * np.sqrt(np.hypot(x, y) - 0.3999))
        assert np.isfinite(spacing(INSIDE)).all()
        assert spacing.extended(np.zeros((1, 2))) == 0.003


def test_a_bad_value_between_is_told_of_all_the_same():
    _, spacing = tables(lambda x, y: np.where(np.hypot(x - 0.7, y - 0.7) < 0.05, -1.0, 0.1))
    np.testing.assert_array_equal(spacing.extended(np.array([[0.7, 0.7]])), 0.003)


def test_what_is_quick_to_compute_is_left_alone():
    spacing = Spacing(cone)
    assert tabulated(PLATE, spacing) is spacing


def test_a_needle_is_resolved():
    spacing = tabulated(PLATE, Spacing(lambda x, y: 1e-9 + np.abs(np.hypot(x - 0.7, y)), costly=True))
    assert spacing(np.array([[0.7, 0.0]])) == pytest.approx(1e-9, rel=ROUGH)


@pytest.mark.long
def test_spots_as_small_as_the_spacing_around_are_not_passed_over():
    for at in np.random.default_rng(5).uniform([0.5, -0.9], [0.9, 0.9], (4, 2)):

        def spotted(x, y, at=at):
            return np.minimum(0.004, 0.002 + 0.4 * np.hypot(x - at[0], y - at[1]))

        spacing = tabulated(PLATE, Spacing(spotted, costly=True))
        assert spacing(at[None]) == pytest.approx(0.002, rel=0.1)


@pytest.mark.long
def test_packing_asks_for_costly_distances_a_few_times_for_each_node_only(monkeypatch):
    text = """
domain:
  outer: {rectangle: [-1, -1, 1, 1]}
  holes: [{ellipse: {center: [0, 0], radii: [0.4, 0.2]}, label: bore}]
spacing: "0.02 + 0.05*distance('bore')"
"""
    asked = []
    measured = Domain.distance_to

    def counted(self, points, *labels):
        asked.append(len(points))
        return measured(self, points, *labels)

    monkeypatch.setattr(Domain, "distance_to", counted)
    problem = prepare(load_case("plate.yaml", text=text))
    asked.clear()
    nodes = mesh_problem(problem).report["nodes"]
    assert sum(asked) < 25 * nodes
