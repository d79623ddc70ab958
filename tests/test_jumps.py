import numpy as np
import pytest
from examples import BARE
from lattices import uniform

from bubblemesh.case import load_case
from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.problem import prepared
from bubblemesh.spacing.jumps import STEEPEST, jumps
from bubblemesh.spacing.refinement import GROWTH
from bubblemesh.spacing.spacing import Spacing

SQUARE = Domain.of(rings.rectangle(-1, -1, 1, 1))


def stepped(edge, low=0.05, high=0.2):
    """Small where ``edge`` is negative."""
    return Spacing(lambda x, y: np.where(edge(x, y) < 0, low, high), floor=0.02)


STEPS = {
    "line": (lambda x, y: x - 0.123, lambda x, y: np.abs(x - 0.123)),
    "oblique": (lambda x, y: 0.6 * x + 0.8 * y - 0.1, lambda x, y: np.abs(0.6 * x + 0.8 * y - 0.1)),
    "circle": (lambda x, y: np.hypot(x, y) - 0.6, lambda x, y: np.abs(np.hypot(x, y) - 0.6)),
}


@pytest.mark.parametrize("name", STEPS)
def test_sources_are_on_the_fine_side_of_a_jump(name):
    edge, distance = STEPS[name]
    sources = jumps(SQUARE, stepped(edge))
    x, y = sources.points.T
    assert len(sources) > 5
    np.testing.assert_array_equal(sources.sizes, 0.05)
    assert (edge(x, y) < 0).all()
    assert distance(x, y).max() < 0.01


@pytest.mark.parametrize("name", STEPS)
def test_sources_follow_the_whole_jump(name):
    edge, distance = STEPS[name]
    sources = jumps(SQUARE, stepped(edge))
    points = np.random.default_rng(0).uniform(-0.95, 0.95, (20_000, 2))
    beside = points[(distance(*points.T) < 0.01) & (edge(*points.T) > 0)]
    assert len(beside) > 50
    nearest = np.hypot(*(beside[:, None] - sources.points).transpose(2, 0, 1)).min(axis=1)
    assert nearest.max() < 0.35  # coarse cells are 0.25 wide
    limited = sources.limited(stepped(edge))
    assert (limited(beside) <= 0.05 + GROWTH * 0.35).all()


def test_limited_spacing_grows_from_the_jump_and_is_the_wanted_one_far_off():
    edge, _ = STEPS["line"]
    wanted = stepped(edge)
    limited = jumps(SQUARE, wanted).limited(wanted)
    at = np.column_stack([np.linspace(0.13, 1, 100), np.zeros(100)])
    d = limited(at)
    assert d[0] < 0.1
    assert (np.diff(d) > -0.01).all()
    assert (d <= np.minimum(0.2, 0.05 + GROWTH * (at[:, 0] - 0.123) + GROWTH * 0.13)).all()
    far = np.array([[0.9, 0.0], [-0.5, 0.2]])
    np.testing.assert_array_equal(limited(far), wanted(far))


@pytest.mark.parametrize(
    "function",
    [
        lambda x, y: np.full(x.shape, 0.1),
        lambda x, y: 0.05 + 0.1 * (x + 1),
        lambda x, y: 0.03 + 0.6 * (y + 1),
        lambda x, y: 0.03 + (y + 1) + 0.1 * (y + 1) ** 2,  # too steep for any packing, but no jump
        lambda x, y: 0.05 + 0.5 * np.abs(x - 0.2),
        lambda x, y: 0.02 + 0.6 * np.hypot(x, y),
        lambda x, y: 0.1 + 0.03 * np.sin(9 * x) * np.cos(7 * y),
        lambda x, y: np.where(x < 0, 0.1, 0.101),
    ],
)
def test_slopes_kinks_and_waves_are_no_jumps(function):
    assert len(jumps(SQUARE, Spacing(function, floor=0.01))) == 0


@pytest.mark.parametrize("example", BARE)
def test_examples_have_no_jumps(example):
    problem = prepared(load_case("example.yaml", text=BARE[example]))
    assert len(jumps(problem.domain, problem.wanted)) == 0
    assert not any("jumps" in warning for warning in problem.warnings)


@pytest.mark.parametrize(("slope", "found"), [(0.4, False), (3 * STEEPEST, True)])
def test_short_ramp_counts_as_a_jump_if_it_is_too_steep(slope, found):
    ramp = Spacing(lambda x, y: np.clip(0.125 + slope * (x - 0.123), 0.05, 0.2), floor=0.02)
    assert (len(jumps(SQUARE, ramp)) > 0) is found


def test_spacing_that_exists_in_the_domain_only():
    def function(x, y):
        with np.errstate(invalid="ignore"):
            return 0.05 + 0.1 * np.sqrt(np.hypot(x, y) - 0.39)

    domain = Domain.of(rings.rectangle(-1, -1, 1, 1), [rings.circle((0, 0), 0.4)])
    assert len(jumps(domain, Spacing(function, floor=0.025))) == 0


@pytest.mark.parametrize("scale", [2.0**-40, 2.0**40])
def test_jumps_do_not_depend_on_the_unit_of_length(scale):
    edge, _ = STEPS["oblique"]
    unit = jumps(SQUARE, stepped(edge))
    function = stepped(edge).function
    large = Domain.of(rings.rectangle(-scale, -scale, scale, scale))
    found = jumps(large, Spacing(lambda x, y: scale * function(x / scale, y / scale), floor=0.02 * scale))
    np.testing.assert_allclose(found.points / scale, unit.points, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(found.sizes / scale, unit.sizes)


def test_small_domain_has_no_jumps():
    assert len(jumps(SQUARE, uniform(100.0))) == 0


def test_jump_is_warned_of_with_its_place():
    text = 'domain: {outer: {rectangle: [-1, -1, 1, 1]}}\nspacing: "where(x < 0.123, 0.05, 0.2)"\n'
    problem = prepared(load_case("case.yaml", text=text))
    (warning,) = [warning for warning in problem.warnings if "jumps" in warning]
    assert "0.05" in warning
    assert "0.12" in warning
    assert problem.refined
