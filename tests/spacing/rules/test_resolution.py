"""Walls through which a growing spacing must not pass."""

import numpy as np
import pytest
from lattices import uniform

from bubblemesh.case import load_case
from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.problem.domain import case_domain
from bubblemesh.spacing.rules.resolution import thin_walls
from bubblemesh.spacing.rules.sources import short_intervals

RECTANGLE = rings.rectangle(0, 0, 2, 1)


def found(domain, spacing):
    return thin_walls(domain, spacing, short_intervals(domain, spacing))


def test_a_convex_outline_has_none():
    walls, sides = found(Domain.of(RECTANGLE), uniform(0.1))
    assert walls.shape == (0, 2)
    assert sides.shape == (0,)


def test_wide_holes_are_none():
    walls, _ = found(Domain.of(RECTANGLE, [rings.circle((1, 0.5), 0.4)]), uniform(0.05))
    assert len(walls) == 0


@pytest.mark.parametrize("width", [0.05, 0.01])
@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_thin_holes_are_covered_by_places_with_small_cells(width, angle):
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    corners = np.array([[-0.4, -width / 2], [0.4, -width / 2], [0.4, width / 2], [-0.4, width / 2]])
    domain = Domain.of(RECTANGLE, [rings.polygon(corners @ turn.T + [1, 0.5])])
    walls, sides = found(domain, uniform(0.1))
    assert (sides <= width / 2).all()
    assert (sides[: len(sides) // 2] >= width / 40).all()  # beside corners the discs are smaller
    along = np.linspace(-0.35, 0.35, 500)
    for across in (-width / 2, 0, width / 2):
        middle = np.column_stack([along, np.full(500, across)]) @ turn.T + [1, 0.5]
        assert np.hypot(*(middle[:, None] - walls).transpose(2, 0, 1)).min(axis=1).max() < 0.5 * width


def test_walls_finer_than_can_be_told_cost_no_more_than_others():
    slit = rings.polygon([(0.5, 0.5), (1.5, 0.5), (1.5, 0.5 + 1e-7), (0.5, 0.5 + 1e-7)])
    walls, sides = found(Domain.of(RECTANGLE, [slit]), uniform(0.1))
    assert 0 < len(walls) < 12_000
    assert sides.min() > 1e-5


def test_embedded_lines_are_none():
    text = "domain: {outer: {rectangle: [0, 0, 1, 1]}, lines: [{path: [[0.2, 0.2], [0.8, 0.2]]}]}\nspacing: 0.1"
    assert len(found(case_domain(load_case("-", text=text)), uniform(0.05))[0]) == 0
