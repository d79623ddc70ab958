from dataclasses import replace

import numpy as np
import pytest
from lattices import uniform

from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.spacing.rules.rules import Rules
from bubblemesh.spacing.rules.sources import short_pieces
from bubblemesh.spacing.spacing import Spacing

PLATE = Domain.of(rings.rectangle(0, 0, 4, 2), [rings.circle((1, 1), 0.3), rings.circle((1.7, 1), 0.3)])
ANGLE = np.linspace(0, 2 * np.pi, 60, endpoint=False)
UNIT = np.column_stack([np.cos(ANGLE), np.sin(ANGLE)])


def test_no_rule_changes_nothing():
    requested = Spacing(lambda x, y: np.where(x < 0.3, 0.01, 1.0))
    found = Rules()(PLATE, requested)
    assert found.spacing is requested
    assert (found.share, found.ratio) == (0.0, 1.0)


@pytest.mark.parametrize("per_circle", [12, 48, 200])
def test_curves_get_their_nodes_on_a_full_turn(per_circle):
    spacing = Rules(per_circle=per_circle)(PLATE, replace(uniform(0.3), floor=0.1)).spacing
    for center in ((1, 1), (1.7, 1)):
        rim = spacing(np.array(center) + 0.3 * UNIT)
        np.testing.assert_allclose(rim, min(2 * np.pi * 0.3 / per_circle, 0.3), rtol=0.12)
    assert spacing(np.array([[3.9, 0.1]]))[0] == pytest.approx(0.3)


def test_straight_walls_are_no_curves():
    square = Domain.of(rings.rectangle(0, 0, 1, 1))
    assert Rules(per_circle=100)(square, uniform(0.3)).ratio == 1.0


@pytest.mark.parametrize("across", [1.0, 3.0, 6.5])
def test_narrow_parts_get_their_spacings_across(across):
    spacing = Rules(across=across)(PLATE, uniform(0.15)).spacing
    d = spacing(np.array([[1.3, 1.0], [1.4, 1.0]]))
    assert d[0] == pytest.approx(min(0.1 / across, 0.15), rel=0.12)
    assert spacing(np.array([[3.5, 1.0]]))[0] == pytest.approx(0.15)


def test_thin_walls_resolve_by_themselves():
    comb = [(0, 0), (3, 0), (3, 1), (1.04, 1), (1.04, 0.2), (1.0, 0.2), (1.0, 1), (0, 1)]
    slot = Domain.of(rings.polygon([(0, 0), (3, 0), (3, 0.05), (1, 0.05), (1, 1), (0, 1)]))
    d = Rules(across=2)(slot, uniform(0.2)).spacing(np.array([[1.5, 0.025], [2.5, 0.025]]))
    np.testing.assert_allclose(d, 0.025, rtol=0.15)
    outside = Rules(across=2)(Domain.of(rings.polygon(comb)), uniform(0.05))
    assert outside.ratio == 1.0  # the slit is narrow, but it is not in the domain


def test_rules_make_the_spacing_nowhere_finer_than_the_minimum():
    spacing = Rules(per_circle=500, across=50, minimum=0.02)(PLATE, uniform(0.2)).spacing
    points = np.vstack([PLATE.polygonal_copy.points, np.random.default_rng(0).uniform([0, 0], [4, 2], (2000, 2))])
    d = spacing(points[PLATE.contains(points)])
    assert d.min() == pytest.approx(0.02, rel=0.05)


def test_growth_holds_away_from_what_the_rules_made_fine():
    spacing = Rules(growth=0.1, per_circle=60)(PLATE, uniform(0.3)).spacing
    away = np.linspace(0, 0.6, 20)
    d = spacing(np.column_stack([np.full(20, 1.0), 1.3 + away]))
    np.testing.assert_allclose(d, 2 * np.pi * 0.3 / 60 + 0.1 * away, rtol=0.06)


def test_rules_combine_to_the_finest():
    both = Rules(growth=0.2, per_circle=48, across=4)(PLATE, uniform(0.2)).spacing
    points = np.random.default_rng(1).uniform([0, 0], [4, 2], (3000, 2))
    points = points[PLATE.contains(points)]
    alone = [Rules(growth=0.2, per_circle=48)(PLATE, uniform(0.2)), Rules(growth=0.2, across=4)(PLATE, uniform(0.2))]
    finest = np.minimum(*(one.spacing(points) for one in alone))
    assert np.quantile(np.abs(both(points) / finest - 1), 0.95) < 0.1


NOTCHED = Domain.of(rings.polygon([(0, 0), (2, 0), (2, 1), (1.01, 1), (1.01, 1.01), (0.99, 1.01), (0.99, 1), (0, 1)]))


@pytest.mark.parametrize("growth", [0.1, 0.2])
def test_growth_holds_away_from_short_edges_too(growth):
    away = np.linspace(0.02, 0.7, 20)
    d = Rules(growth=growth)(NOTCHED, uniform(0.2)).spacing(np.column_stack([np.full(20, 1.0), 1 - away]))
    expected = np.minimum(0.01 + growth * np.hypot(0.01, away), 0.2)
    np.testing.assert_allclose(d, expected, rtol=0.06)
    assert not len(short_pieces(NOTCHED, Rules(growth=growth)(NOTCHED, uniform(0.2)).spacing))


def test_growth_holds_away_from_tight_curves_too():
    drilled = Domain.of(rings.rectangle(0, 0, 2, 2), [rings.circle((1, 1), 0.02)])
    d = Rules(growth=0.1)(drilled, uniform(0.2)).spacing(np.column_stack([1.02 + np.linspace(0, 0.9, 9), np.ones(9)]))
    np.testing.assert_allclose(d, 0.02 * np.pi / 3 + 0.1 * np.linspace(0, 0.9, 9), rtol=0.08)


def test_growth_is_kept_above_a_minimum():
    d = Rules(growth=0.1, minimum=0.05)(NOTCHED, uniform(0.2)).spacing(np.array([[1.0, 0.99], [1.0, 0.5]]))
    np.testing.assert_allclose(d, [0.051, 0.1], rtol=0.05)
