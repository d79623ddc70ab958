"""Cells that resolve a spacing, and walls through which a growing one must not pass."""

import numpy as np
import pytest
from lattices import uniform

from bubblemesh.case import load_case
from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.problem.domain import case_domain
from bubblemesh.spacing.expression import Expression
from bubblemesh.spacing.rules.resolution import (
    FITTING,
    WALL_CELL,
    WIDEST_WALL,
    resolved,
    steepest,
    surely_slow,
    thin_walls,
    unresolved,
)
from bubblemesh.spacing.rules.sources import Sources, short_intervals
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.terms.combination import Combination
from bubblemesh.spacing.terms.proximity import Proximity

RECTANGLE = rings.rectangle(0, 0, 2, 1)


looked = Domain.deep_outside


def found(domain, spacing):
    return thin_walls(domain, spacing, short_intervals(domain, spacing))


def test_a_convex_outline_has_none():
    walls, sides = found(Domain.of(RECTANGLE), uniform(0.1))
    assert walls.shape == (0, 2)
    assert sides.shape == (0,)


def test_wide_holes_are_none():
    walls, _ = found(Domain.of(RECTANGLE, [rings.circle((1, 0.5), 0.4)]), uniform(0.05))
    assert len(walls) == 0


def test_walls_are_no_thicker_than_the_domain_however_large_the_spacing_is(monkeypatch):
    domain = Domain.of(RECTANGLE, [rings.rectangle(0.6, 0.48, 1.4, 0.52)])
    calls = []
    monkeypatch.setattr(
        Domain, "deep_outside", lambda self, points, depth: calls.append(depth) or looked(self, points, depth)
    )
    walls, sides = found(domain, uniform(1e60))
    assert len(calls) < 20
    assert len(walls)
    assert (sides <= 0.02).all()


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


def test_samples_are_the_spacing_at_their_places_to_the_last_bit():
    domain = Domain.of(rings.circle((0.3, -0.2), 0.77))
    varied = Spacing(lambda x, y: 0.02 + 0.1 * np.hypot(x - 0.1, y) + 0.01 * np.sin(7 * x))
    samples = resolved(unresolved(domain, varied), domain, varied, Sources.none())
    grid = samples.grid
    assert len(grid) > 1000
    places = np.concatenate([grid.centers[:, None], grid.corners(np.arange(len(grid)))], axis=1)
    np.testing.assert_array_equal(samples.d, varied.extended(places.reshape(-1, 2)).reshape(-1, 5))
    assert resolved(samples, domain, varied, Sources.none()) is samples


def test_walls_of_a_comb_are_found_as_by_asking_for_each_disc():
    teeth = [(x, y) for k in range(20) for x, y in ((k, 0), (k + 0.7, 0), (k + 0.7, 5 - k % 3), (k + 0.72, 5 - k % 3))]
    domain = Domain.of(rings.polygon([*((x / 5, y / 5) for x, y in teeth), (4, 0), (4, -1), (0, -1)][::-1]))
    spacing = uniform(0.3)
    piece, begin, length = short_intervals(domain, spacing)
    places, _ = found(domain, spacing)
    points, (tx, ty) = domain.boundary.points(piece, begin + length / 2), domain.boundary.tangents(piece, begin).T
    radius, tried = np.full(len(points), WIDEST_WALL * 0.3), np.arange(len(points))
    while len(tried):
        centers = points[tried] + radius[tried, None] * np.column_stack([ty, -tx])[tried]
        tried = tried[-domain.signed_distance(centers) < FITTING * radius[tried]]
        radius[tried] /= 2
        tried = tried[radius[tried] > 1e-9 * domain.size]
    thin = radius < WIDEST_WALL * 0.3
    assert thin.sum() > 50
    assert len(places) == 2 * np.ceil(length[thin] / (WALL_CELL * radius[thin])).sum()


class Counted(Expression):
    """An expression that counts the places it is asked for."""

    def __call__(self, x, y):
        asked.append(np.size(x))
        return super().__call__(x, y)


asked = []
AROUND_A_CIRCLE = "h*(0.2*abs(sqrt(x**2 + y**2) - 0.5) + 0.15)"


@pytest.mark.parametrize("h", [1.0, 0.01, 0.0001])
def test_few_places_tell_that_a_spacing_grows_slowly_however_fine_it_is(h):
    domain = Domain.of(rings.rectangle(-1, -1, 1, 1))
    asked.clear()
    assert surely_slow(domain, Spacing(Counted.parse(AROUND_A_CIRCLE, {"h": h})), 0.4)
    assert sum(asked) < 20_000


def test_few_places_tell_that_distances_grow_slowly():
    domain = Domain.of(rings.rectangle(-1, -1, 1, 1))

    def distance(points):
        asked.append(len(points))
        return domain.distances(points)

    distance.costly = False
    asked.clear()
    by_text = Counted.parse("0.0001 + 0.3*distance()", None, lambda labels: distance)
    near = Combination((Spacing(by_text), Spacing(Proximity(distance, 0.0001, 0.4))), maximum=0.1)
    for function in (by_text, near):
        assert surely_slow(domain, Spacing(function), 0.4)
    assert sum(asked) < 100


@pytest.mark.parametrize(
    "text",
    [
        "0.1 + 0.5*x",
        "0.01 + 0.41*hypot(x - 0.77, y - 0.33)",
        "0.02*(1 - 0.9*exp(-(hypot(x - 1.234, y - 0.4)/0.01)**2))",  # steep around one place
        "0.01 if x < 1 else 0.02",
    ],
)
def test_what_is_steep_somewhere_is_not_surely_slow(text):
    domain = Domain.of(RECTANGLE)
    spacing = Spacing(Expression.parse(text), floor=0.001)
    assert steepest(resolved(unresolved(domain, spacing), domain, spacing, Sources.none()), domain, 0.4) is not None
    assert not surely_slow(domain, spacing, 0.4)


def test_what_is_steep_beyond_the_domain_only_may_be_slow():
    domain = Domain.of(RECTANGLE)
    assert surely_slow(domain, Spacing(Expression.parse("0.1 + max(0.3*(x + 1), 9*(x - 2))")), 0.4)
    assert not surely_slow(domain, Spacing(Expression.parse("0.1 + max(0.3*(x + 1), 9*(x - 1.7))")), 0.4)


def test_only_samples_tell_of_what_has_no_bounds():
    assert not surely_slow(Domain.of(RECTANGLE), uniform(0.1), 0.4)
