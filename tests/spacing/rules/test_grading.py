from dataclasses import replace

import numpy as np
import pytest
from examples import BARE
from lattices import uniform

from bubblemesh.case import load_case
from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.problem.prepare import prepare
from bubblemesh.spacing.expression import Expression
from bubblemesh.spacing.rules import sources as source_rules
from bubblemesh.spacing.rules.grading import STEEPEST_GROWTH, LimitedSpacing, gradient_limited, limited_for_packing
from bubblemesh.spacing.rules.sources import Sources, coarse_curves
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.terms.raster import Raster

SQUARE = Domain.of(rings.rectangle(-1, -1, 1, 1))
NONE = Sources(np.zeros((0, 2)), np.zeros(0))
INSIDE = np.random.default_rng(0).uniform(-1, 1, (20_000, 2))
JUMPS = {
    "line": lambda x, y: x - 0.123,
    "oblique": lambda x, y: 0.6 * x + 0.8 * y - 0.1,
    "circle": lambda x, y: np.hypot(x, y) - 0.6,
    "spot": lambda x, y: np.hypot(x - 0.31, y + 0.2) - 0.04,
}


def stepped(edge, low=0.02, high=0.2):
    """Small where ``edge`` is negative."""
    return Spacing(lambda x, y: np.where(edge(x, y) < 0, low, high), floor=low / 2)


@pytest.mark.parametrize("growth", [0.1, 0.3, 0.6])
@pytest.mark.parametrize("name", JUMPS)
def test_spacing_grows_from_the_fine_side_of_a_jump(name, growth):
    edge = JUMPS[name]
    found = gradient_limited(SQUARE, stepped(edge), growth, NONE).spacing(INSIDE)
    largest = np.minimum(0.2, 0.02 + growth * np.maximum(edge(*INSIDE.T), 0))
    assert np.quantile(np.abs(found / largest - 1), 0.99) < 0.05
    assert np.abs(found / largest - 1).max() < 0.3  # in the cells that the jump crosses


@pytest.mark.parametrize("growth", [0.15, 0.4])
def test_graded_spacing_grows_nowhere_faster(growth):
    def function(x, y):
        return 0.02 + 0.3 * np.abs(np.sin(4 * x)) * np.abs(np.cos(3 * y)) + 0.7 * np.maximum(x, 0)

    found = gradient_limited(SQUARE, Spacing(function, floor=0.01), growth, NONE).spacing
    random = np.random.default_rng(1)
    angle = random.uniform(0, 2 * np.pi, len(INSIDE))
    d = found(INSIDE)
    there = INSIDE + 0.2 * d[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    real = (np.abs(there) < 1).all(axis=1)
    slope = np.abs(found(there) - d)[real] / (0.2 * d[real])
    assert np.quantile(slope, 0.99) < 1.03 * growth
    assert slope.max() < 1.3 * growth
    assert (d <= function(*INSIDE.T) * (1 + 1e-12)).all()


@pytest.mark.parametrize(
    "function",
    [
        lambda x, y: np.full(x.shape, 0.1),
        lambda x, y: 0.05 + 0.1 * (x + 1),
        lambda x, y: 0.03 + 0.99 * STEEPEST_GROWTH * (y + 1),
        lambda x, y: 0.05 + 0.39 * np.abs(x - 0.2),
        lambda x, y: 0.02 + 0.35 * np.hypot(x, y),
        lambda x, y: 0.1 + 0.03 * np.sin(9 * x) * np.cos(4 * y),
    ],
)
def test_slow_growth_is_left_alone(function):
    requested = Spacing(function, floor=0.01)
    found = gradient_limited(SQUARE, requested, STEEPEST_GROWTH, NONE)
    assert found.spacing is requested
    assert (found.steepest, found.share, found.ratio) == (None, 0.0, 1.0)


@pytest.mark.parametrize("example", BARE)
def test_examples_are_left_alone(example):
    problem = prepare(load_case("example.yaml", text=BARE[example]))
    assert not problem.packed_finer
    assert not any("per length" in warning for warning in problem.warnings)


@pytest.mark.parametrize("at", [-0.5, 0.0, 0.25])
@pytest.mark.parametrize("side", [np.less, np.less_equal])
def test_jumps_between_cells_are_seen(at, side):
    requested = Spacing(lambda x, y: np.where(side(x, at), 0.01, 0.2), floor=0.005)
    found = gradient_limited(SQUARE, requested, 0.4, NONE)
    assert found.steepest is not None
    assert found.spacing(np.array([[at + 0.1, 0.3]]))[0] == pytest.approx(0.05, rel=0.03)


def test_change_is_told():
    found = gradient_limited(SQUARE, stepped(JUMPS["line"]), 0.3, NONE)
    assert found.steepest.size == 0.02
    assert found.steepest.growth > 10
    assert abs(found.steepest.at[0] - 0.123) < 0.03
    assert found.share == pytest.approx(0.6 / 2, abs=0.03)  # 0.18 / 0.3 of length
    assert 8 < found.ratio < 10


def test_steep_slope_is_told_with_its_growth():
    found = gradient_limited(SQUARE, Spacing(lambda x, y: 0.05 + 0.8 * (x + 1), floor=0.02), 0.3, NONE)
    assert found.steepest.growth == pytest.approx(0.8, rel=1e-6)
    at = np.array([[0.5, 0.1]])
    assert found.spacing(at)[0] == pytest.approx(0.05 + 0.3 * 1.5, rel=0.01)


def test_sources_hold_the_spacing_where_they_are():
    sources = Sources(np.array([[0.1, 0.2], [0.7, -0.5], [-1.0, -1.0]]), np.array([0.01, 0.002, 0.05]))
    found = gradient_limited(SQUARE, uniform(0.3), 0.25, sources)
    away = np.hypot(*(INSIDE[:, None] - sources.points).transpose(2, 0, 1))
    largest = np.minimum(0.3, (sources.sizes + 0.25 * away).min(axis=1))
    d = found.spacing(INSIDE)
    assert np.quantile(np.abs(d / largest - 1), 0.99) < 0.06
    assert (d / largest).max() < 1.5
    np.testing.assert_allclose(found.spacing(sources.points), sources.sizes, rtol=0.05)
    assert found.steepest is None
    assert found.spacing.floor <= 0.0015


def test_sources_finer_than_any_cell_are_no_endless_task():
    sources = Sources(np.array([[0.1, 0.2], [0.3, 0.2]]), np.array([1e-13, 1e-300]))
    d = gradient_limited(SQUARE, uniform(0.3), 0.4, sources).spacing(np.array([[0.1, 0.2], [0.1, 0.4], [0.3, 0.3]]))
    assert d[0] < 1e-8
    np.testing.assert_allclose(d[1:], [0.08, 0.04], rtol=0.1)


def test_growth_goes_around_walls():
    slit = [(-1, -1), (1, -1), (1, 1), (0.05, 1), (0.05, -0.6), (-0.05, -0.6), (-0.05, 1), (-1, 1)]
    domain = Domain.of(rings.polygon(slit))
    requested = stepped(lambda x, y: x + 0.2, high=0.5)
    d = gradient_limited(domain, requested, 0.3, NONE).spacing(np.array([[0.3, 0.9], [-0.06, 0.9]]))
    assert d[0] == pytest.approx(0.5)
    assert d[1] == pytest.approx(0.02 + 0.3 * 0.14, rel=0.1)


@pytest.mark.long
@pytest.mark.parametrize("width", [0.1, 0.02, 0.004])
def test_growth_goes_around_walls_however_thin(width):
    outline = [(0, 0), (2, 0), (2, 1), (1 + width, 1), (1 + width, 0.5), (1, 0.5), (1, 1), (0, 1)]
    domain = Domain.of(rings.polygon(outline))
    requested = Spacing(lambda x, y: np.where(np.hypot(x - 0.9, y - 0.9) < 0.05, 0.01, 0.5), floor=0.005)
    there = np.array([[1 + width + 0.05, 0.95], [1 + width + 0.05, 0.5], [0.95, 0.5]])
    over_tip = np.hypot(0.1, 0.4) - 0.05 + width
    ways = np.array([over_tip + np.hypot(0.05, 0.45), over_tip + 0.05, np.hypot(0.05, 0.4) - 0.05])
    found = gradient_limited(domain, requested, 0.2, NONE).spacing(there)
    np.testing.assert_allclose(found, 0.01 + 0.2 * ways, rtol=0.06)


@pytest.mark.parametrize("growth", [0.1, 0.2, 0.4])
def test_curves_get_the_nodes_that_their_sources_ask_for(growth, monkeypatch):
    monkeypatch.setattr(source_rules, "WIDEST_TURN", 2 * np.pi / 36)
    plate = Domain.of(rings.rectangle(-1, -1, 1, 1), [rings.circle((0, 0), 0.2), rings.circle((0.6, 0.5), 0.03)])
    fine = gradient_limited(plate, uniform(0.3), growth, coarse_curves(plate, uniform(0.3))).spacing
    for piece in np.flatnonzero(plate.boundary.curved):
        length = plate.boundary.lengths[piece]
        s = (np.arange(5000) + 0.5) / 5000 * length
        nodes = length * (1 / fine(plate.boundary.points(np.full(5000, piece), s))).mean()
        assert 35.7 < nodes < 37.5


@pytest.mark.parametrize(("size", "slope"), [(0.001, 20), (0.001, 1000), (0.01, 5), (0.01, 2)])
def test_spots_that_no_sample_sees_are_known_by_their_places(size, slope):
    place = np.array([[0.31, -0.123]])

    def function(x, y):
        return np.minimum(0.2, size + slope * np.hypot(x - place[0, 0], y - place[0, 1]))

    found = gradient_limited(SQUARE, Spacing(function, spots=np.vstack([place, [[5, 5]]])), 0.2, NONE)
    largest = np.minimum(0.2, size + 0.2 * np.hypot(*(INSIDE - place).T))
    np.testing.assert_allclose(found.spacing(INSIDE), largest, rtol=0.05)
    assert found.steepest.growth > 0.9 * min(slope, 0.19 / size)


@pytest.mark.long
def test_what_grows_slowly_by_its_rules_is_graded_no_more(monkeypatch):
    monkeypatch.setattr(source_rules, "WIDEST_TURN", 2 * np.pi / 36)
    holes = [rings.circle((0.3 * i, 0.5 * j), 0.05) for i in (-2, 0, 1) for j in (-1, 0, 1)]
    plate = Domain.of(rings.rectangle(-1, -1, 1, 1), holes)
    ruled = gradient_limited(plate, uniform(0.3), STEEPEST_GROWTH, coarse_curves(plate, uniform(0.3)))
    assert limited_for_packing(plate, ruled, NONE, STEEPEST_GROWTH, None) is ruled
    near = Sources(np.array([[0.9, 0.9]]), np.array([0.01]))
    finer = limited_for_packing(plate, ruled, near, STEEPEST_GROWTH, None)
    assert finer.steepest is None
    assert finer.spacing(np.array([[0.9, 0.9]]))[0] == pytest.approx(0.01, rel=0.05)
    steep = replace(ruled, growth=0.6)
    assert limited_for_packing(plate, steep, NONE, STEEPEST_GROWTH, None).growth == STEEPEST_GROWTH


@pytest.mark.parametrize("spacing", [uniform(0.3), Spacing(lambda x, y: 0.05 + 0.2 * np.hypot(x, y), floor=0.02)])
def test_more_sources_on_the_ground_of_the_first_ones_give_the_same_spacing(spacing):
    slit = rings.polygon([(-0.4, 0.0), (0.4, 0.1), (0.4, 0.11), (-0.4, 0.01)])
    domain = Domain.of(rings.rectangle(-1, -1, 1, 1), [slit, rings.circle((0.3, 0.6), 0.1)])
    random = np.random.default_rng(2)
    many = Sources(random.uniform(-1, 1, (60, 2)), random.uniform(0.002, 0.1, 60))
    some, more = many.select(np.arange(20)), many.select(np.arange(20, 60))
    before = LimitedSpacing(spacing)
    first = limited_for_packing(domain, before, some, STEEPEST_GROWTH, None)
    assert len(first.ground.with_sources(domain, spacing, more).given) > len(first.ground.given) + 100
    for growth in (0.2, STEEPEST_GROWTH):
        held = replace(before, growth=growth)
        anew = limited_for_packing(domain, held, many, growth, None)
        on_ground = limited_for_packing(domain, held, more, growth, first.ground)
        assert on_ground.spacing(INSIDE).tobytes() == anew.spacing(INSIDE).tobytes()
        assert (on_ground.share, on_ground.ratio_at) == (anew.share, anew.ratio_at)


def test_spacing_that_exists_in_the_domain_only():
    def function(x, y):
        with np.errstate(invalid="ignore"):
            return 0.05 + 0.1 * np.sqrt(np.hypot(x, y) - 0.39)

    domain = Domain.of(rings.rectangle(-1, -1, 1, 1), [rings.circle((0, 0), 0.4)])
    assert gradient_limited(domain, Spacing(function, floor=0.025), 0.6, NONE).steepest is None
    limited = gradient_limited(domain, Spacing(function, floor=0.025), 0.1, NONE)
    points = INSIDE[domain.contains(INSIDE)]
    assert (limited.spacing(points) <= function(*points.T)).all()
    assert limited.steepest is not None


@pytest.mark.parametrize("scale", [2.0**-40, 2.0**40])
def test_grading_does_not_depend_on_the_unit_of_length(scale):
    function = stepped(JUMPS["oblique"]).function
    unit = gradient_limited(SQUARE, stepped(JUMPS["oblique"]), 0.3, NONE)
    large = Domain.of(rings.rectangle(-scale, -scale, scale, scale))
    found = gradient_limited(
        large, Spacing(lambda x, y: scale * function(x / scale, y / scale), floor=0.01 * scale), 0.3, NONE
    )
    np.testing.assert_allclose(found.spacing(INSIDE * scale) / scale, unit.spacing(INSIDE), rtol=1e-9)
    assert found.share == pytest.approx(unit.share)


def test_spacing_larger_than_the_domain_is_left_alone():
    assert gradient_limited(SQUARE, uniform(100.0), 0.3, NONE).steepest is None


def test_fast_growth_is_warned_of_with_its_place():
    text = 'domain: {outer: {rectangle: [-1, -1, 1, 1]}}\nspacing: "where(x < 0.123, 0.05, 0.2)"\n'
    problem = prepare(load_case("case.yaml", text=text))
    (warning,) = [warning for warning in problem.warnings if "per length" in warning]
    assert "from 0.05" in warning
    assert "(0.12" in warning
    assert problem.packed_finer


def test_raster_that_grows_slowly_is_left_as_it_is():
    columns = np.linspace(0.1, 0.3, 40)
    raster = Raster.within((-2, -2, 2, 2), np.tile(columns, (30, 1)))
    spacing = Spacing(raster, floor=0.1)
    assert gradient_limited(SQUARE, spacing, 0.2, NONE).spacing is spacing


@pytest.mark.parametrize(
    "text", ["max(0.02 + 0.1*sqrt(x + 1), 0.01)", "max(0.01, 0.02 + 0.1*hypot(x - 0.2, y - 0.1)**0.5)"]
)
def test_roots_of_zero_within_bounds_are_limited(text):
    spacing = Spacing(Expression.parse(text), floor=0.01)
    limited = gradient_limited(SQUARE, spacing, 0.2, NONE).spacing
    ends = np.random.default_rng(1).uniform(-0.9, 0.9, (20_000, 2))
    others = ends + np.random.default_rng(2).uniform(-0.05, 0.05, ends.shape)
    rise = np.abs(limited(ends) - limited(others)) / np.hypot(*(ends - others).T)
    assert limited is not spacing
    assert np.quantile(rise, 0.999) < 0.3
