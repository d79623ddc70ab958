"""Periodic sides count as one: what is fine at one of them is fine at the other, and grows from there."""

import numpy as np
import pytest
from lattices import uniform
from partitions import MOONS

from bubblemesh.case import load_case
from bubblemesh.problem.prepare import prepare
from bubblemesh.run.estimate import estimate
from bubblemesh.run.pipeline import mesh_case
from bubblemesh.spacing.rules import grading
from bubblemesh.spacing.rules import rules as sides
from bubblemesh.spacing.rules.grading import LimitedSpacing, gradient_limited
from bubblemesh.spacing.rules.rules import (
    finer_of_both_sides,
    limited_across_sides,
    limited_for_packing_across_sides,
)
from bubblemesh.spacing.rules.sources import Sources
from bubblemesh.spacing.spacing import Spacing

SQUARE = "outer: {rectangle: [0, 0, 2, 1], labels: [bottom, right, top, left]}"
ONE, BOTH = "[[left, right]]", "[[left, right], [bottom, top]]"
POINTS = np.random.default_rng(3).uniform([0, 0], [2, 1], (2000, 2))


def problem_of(spacing, pairs=ONE, outline=SQUARE):
    return prepare(load_case("cell.yaml", text=f"domain:\n  {outline}\n  periodic: {pairs}\nspacing: {spacing}\n"))


def from_copies(at, shifts):
    """Distance (n,) of the points from a place or one of its copies."""
    return np.min([np.hypot(*(POINTS - at - shift).T) for shift in np.array(shifts)], axis=0)


@pytest.mark.long
@pytest.mark.parametrize(
    ("spacing", "ratio"),
    [
        ("{near: {label: left, size: 0.01}, maximum: 0.2, growth: 0.2}", 1.1),
        ("0.01 + 0.1*x", 1.1),
        ("{value: 0.2, near: {point: [0.02, 0.5], size: 0.004, growth: 0.3}, growth: 0.2}", 1.1),
    ],
)
def test_meshes_are_good_beside_the_side_that_is_coarse_alone(spacing, ratio):
    result = mesh_case(load_case("cell.yaml", text=f"domain: {{{SQUARE}, periodic: {ONE}}}\nspacing: {spacing}\n"))
    report = result.report
    assert report["quality"]["min"] > 0.6
    assert report["spacing"]["p01"] > 0.75
    assert 1 / ratio < report["nodes"] / report["ideal_nodes"] < ratio
    assert report["warnings"] == []


@pytest.mark.parametrize("at", [(0.02, 0.5), (0.02, 0.03), (1.7, 0.98)])
def test_a_fine_spot_reaches_across_all_sides(at):
    spacing = f"{{value: 0.15, near: {{point: [{at[0]}, {at[1]}], size: 0.01}}, growth: 0.2}}"
    shifts = [(dx, dy) for dx in (-2, 0, 2) for dy in (-1, 0, 1)]
    expected = np.minimum(0.01 + 0.2 * from_copies(at, shifts), 0.15)
    np.testing.assert_allclose(problem_of(spacing, BOTH).spacing(POINTS), expected, rtol=0.12)


def test_curved_sides_are_followed():
    spacing = problem_of("{value: 0.15, near: {label: left, size: 0.01}, growth: 0.2}", outline=MOONS).spacing
    beside = np.linspace(-1.3, 1.3, 9)
    rim = np.column_stack([2 + 0.49 * np.cos(beside), 0.5 + 0.49 * np.sin(beside)])
    np.testing.assert_allclose(spacing(rim), 0.012, rtol=0.12)
    np.testing.assert_allclose(spacing(np.array([[2.0, 0.5], [2.25, 0.5]])), [0.11, 0.06], rtol=0.05)


@pytest.mark.parametrize("spacing", ["0.1", "{value: 0.1, growth: 0.2}", "0.1 + 0.02*sin(pi*x)*y"])
def test_nothing_changes_where_both_sides_agree(spacing):
    problem = problem_of(spacing)
    assert problem.after_periodic is problem.after_rules
    assert "periodic" not in estimate(problem)


def test_sides_that_are_not_periodic_are_left_alone():
    domain = problem_of("0.1", "[]").domain
    steep = LimitedSpacing(Spacing(lambda x, y: 0.01 + 0.1 * x))
    assert limited_across_sides(domain, steep.spacing, steep, None) is steep
    assert limited_for_packing_across_sides(domain, steep, Sources.none()).spacing is steep.spacing


def test_how_much_changed_is_told():
    found = estimate(problem_of("0.01 + 0.1*x"))
    assert found["periodic"]["ratio"] == pytest.approx(20, rel=0.1)
    assert found["periodic"]["ratio_at"][0] == pytest.approx(2, abs=0.01)
    assert 0.1 < found["periodic"]["share"] < 0.3
    assert "rules" not in found


def test_short_edges_beside_one_side_make_the_other_one_fine():
    outline = "outer: {polygon: [[0, 0], [2, 0], [2, 1], [0.03, 1], [0.02, 0.99], [0.01, 1], [0, 1]], " + (
        "labels: [bottom, right, top, tooth, tooth, top, left]}"
    )
    problem = problem_of("0.2", outline=outline)
    assert problem.packing_spacing(np.array([[1.99, 0.99]]))[0] < 0.04
    assert problem.spacing(np.array([[1.99, 0.99]]))[0] == 0.2


def test_the_finer_spacing_of_both_sides_is_that_of_either():
    domain = problem_of("0.1").domain
    left, right = domain.periodic[0]
    s = np.array([0.25, 0.5])
    spacing = Spacing(lambda x, y: 0.1 + 0.1 * x * y)
    for piece in (left, right):
        np.testing.assert_array_equal(finer_of_both_sides(domain, spacing, np.full(2, piece), s), 0.1)
    others = np.setdiff1d(np.arange(4), domain.periodic)
    np.testing.assert_array_equal(finer_of_both_sides(domain, uniform(0.3), others, np.zeros(2)), 0.3)


def test_a_limit_of_growth_is_no_compromise():
    case = "{value: 0.2, near: {point: [0.5, 0.5], size: 0.004, growth: 1}, growth: 0.4}"
    assert problem_of(case).warnings == ()
    assert "it is held to 0.4" in problem_of(case.replace(", growth: 0.4", "")).warnings[0]


def test_grading_across_the_sides_ends(monkeypatch):
    graded_times = []

    def counted(*arguments):
        graded_times.append(arguments)
        return gradient_limited(*arguments)

    monkeypatch.setattr(sides, "gradient_limited", counted)
    problem = problem_of("{value: 0.2, near: {point: [0.02, 0.03], size: 0.004}}", BOTH)
    assert len(graded_times) <= 4
    assert problem.packing_spacing is problem.after_periodic.spacing


def test_cells_of_a_spacing_that_follows_rules_are_not_split_once_more_for_periodic_sides(monkeypatch):
    rounds, limited = [], grading.limited_values
    monkeypatch.setattr(grading, "limited_values", lambda *given: rounds.append(given) or limited(*given))
    holes = "holes: [{circle: {center: [0.2, 0.5], radius: 0.1}}, {circle: {center: [0.4, 0.3], radius: 0.05}}]"
    problem = problem_of("{value: 0.2, per_circle: 60, growth: 0.3}", outline=f"{SQUARE}\n  {holes}")
    assert len(rounds) <= 4
    left, right = np.array([[0.0, 0.5], [2.0, 0.5]])
    at_hole = 2 * np.pi * 0.1 / 60
    np.testing.assert_allclose(problem.spacing(np.array([left, right])), at_hole + 0.3 * 0.1, rtol=0.12)
    assert problem.spacing(np.array([[1.8, 0.5]]))[0] == pytest.approx(at_hole + 0.3 * 0.3, rel=0.12)
    assert problem.after_periodic.share < 0.5
