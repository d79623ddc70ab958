"""Bounds of functions and of their slopes, which no sample may leave."""

import numpy as np
import pytest

from bubblemesh.spacing.bounds import RULES
from bubblemesh.spacing.expression import Expression
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.terms.combination import Combination, nothing
from bubblemesh.spacing.terms.proximity import Proximities, Proximity

# For each rule an expression that is made of it, where it has bounds and where it has none.
EXPRESSIONS = {
    np.add: "x + 2*y + 3",
    np.subtract: "x - y*y - 1",
    np.multiply: "(x - 0.3)*(y + 0.2)*x",
    np.divide: "(1 + x)/(y - 2.2) + 1/x",
    np.positive: "+x*y",
    np.negative: "-x**2",
    np.absolute: "abs(x*y - 0.1)",
    np.minimum: "min(x, 0.5*y, 0.3)",
    np.maximum: "max(x, 0.5*y, 0.3) + clip(x + y, -1, 1)",
    np.power: "x**2 + (x - y)**3 + (x + 2.5)**1.5 + (3 + y)**-2 + abs(x)**0.5",
    np.hypot: "hypot(x - 0.3, 2*y)",
    np.sqrt: "sqrt(x**2 + y**2)",
    np.exp: "exp(x - y)",
    np.log: "log(2.5 + x) + log(x)",
    np.sin: "sin(3*x + y)",
    np.cos: "cos(3*x*y)",
    np.tanh: "tanh((x - y)/0.1)",
    np.cbrt: "cbrt(x - y)",
    np.arcsinh: "asinh((x + y)/0.1)",
    np.arccosh: "acosh(2.5 + x*y) + acosh(x)",
    np.arctanh: "atanh(x/4 - y/8) + atanh(x)",
    "erf": "erf((x - y)/0.1)",
    "erfc": "erfc(x - y/0.3)",
    np.arctan: "atan(4*x) + y",
}
BLUNT = [EXPRESSIONS[function] for function in (np.power, np.sin, np.cos)]  # whose slopes cancel, or are at most those
WITHOUT = [
    "where(x > 0, 0.1, y)",
    "0.1 if x > 0 else 0.2",
    "floor(x)",
    "x % 0.4",
    "sign(x)",
    "2**x",
    "x > y",
    "atan2(x, y)",
]


def boxes(count):
    """Random boxes, small and large ones."""
    random = np.random.default_rng(3)
    low = random.uniform(-2, 2, (count, 2))
    return low, np.minimum(low + 10.0 ** random.uniform(-3, 0.6, (count, 1)), 2)


def test_each_rule_has_an_expression_here():
    assert EXPRESSIONS.keys() == RULES.keys()


@pytest.mark.parametrize("text", EXPRESSIONS.values())
def test_no_sample_is_beyond_bounds(text):
    function, (low, high) = Expression.parse(text), boxes(400)
    found = function.bounds_within(low, high)
    places = low[:, None] + np.random.default_rng(5).uniform(0, 1, (400, 200, 2)) * (high - low)[:, None]
    values = function(places[..., 0], places[..., 1])
    known = ~np.isnan(values).any(axis=1)
    values, slopes = values[known], found.steepest[known]
    away = np.hypot(*np.diff(places[known], axis=1).transpose(2, 0, 1))
    rounding = 1e-12 * (1 + np.abs(values).max(axis=1))
    assert (values.min(axis=1) >= found.low[known] - rounding).all()
    assert (values.max(axis=1) <= found.high[known] + rounding).all()
    risen = np.abs(np.diff(values, axis=1)) / away
    assert not (risen.max(axis=1) > slopes * (1 + 1e-9) + rounding / away.min(axis=1)).any()
    if text not in BLUNT:  # bounds in small boxes are worth something
        small = np.isfinite(slopes) & ((high - low)[known].max(axis=1) < 0.01)
        assert small.any()
        assert (slopes[small] < 2 * risen.max(axis=1)[small] + 0.5).all()


@pytest.mark.parametrize(
    "text",
    ["sqrt(x)", "x**0.5", "log(x)", "acosh(x + 0.6)", "atanh(x/2 - 0.8)", "1/x", "sqrt(x)*0", "1/x - 1/x"],
)
@pytest.mark.parametrize(
    "around", ["{}", "min({}, 0.5)", "max({}, 5*y)", "clip({}, 0.1, 0.2)", "abs({})", "tanh({})", "atan({})", "erf({})"]
)
def test_unknown_arguments_leave_slopes_unknown(text, around):
    low = np.array([[-1.0, 0.3], [0.5, 0.3]])  # x of either sign, and none near to zero
    found = Expression.parse(around.format(text)).bounds_within(low, low + np.array([1.5, 0.1]))
    assert not (np.isnan(found.low) | np.isnan(found.high) | np.isnan(found.steepest)).any()
    assert np.isinf(found.steepest[0])
    assert np.isfinite(found.steepest[1])


@pytest.mark.parametrize("text", WITHOUT)
def test_what_jumps_or_has_no_rule_has_no_bounds(text):
    assert Expression.parse(text).bounds_within(*boxes(3)) is None


def test_a_constant_has_no_slope():
    found = Expression.parse("2*h", {"h": 0.1}).bounds_within(*boxes(3))
    assert (found.low, found.high, found.steepest) == (0.2, 0.2, 0.0)


def test_rasters_have_no_bounds():
    expression = Expression.parse("0.1 + raster.depth").measuring(
        lambda labels: around_origin, {"depth": lambda x, y: x + y}
    )
    assert expression.bounds_within(*boxes(3)) is None


def around_origin(points):
    """Distances from a circle of radius 0.5."""
    return np.abs(np.hypot(*points.T) - 0.5)


around_origin.costly = False
FINE, COARSE = Proximity(around_origin, 0.02, 0.3, until=0.1), Proximity(around_origin, 0.01, 0.9)
ON_ITS_OWN = Expression.parse("0.3 + 0.1*x")
OF_DISTANCES = {
    "in an expression": Expression.parse("min(0.1 + 0.3*distance(), 0.4)", None, lambda labels: around_origin),
    "one term": FINE,
    "terms": Proximities((FINE, COARSE)),
    "limits": Combination((Spacing(FINE), Spacing(ON_ITS_OWN)), 1.3, minimum=0.05, maximum=0.3),
    "negative": Combination((Spacing(Expression.parse("0.2 + x")), Spacing(COARSE)), minimum=0.1),
}


@pytest.mark.parametrize("function", OF_DISTANCES.values(), ids=OF_DISTANCES)
def test_no_sample_is_beyond_bounds_of_distances(function):
    low, high = boxes(400)
    found = function.bounds_within(low, high)
    places = low[:, None] + np.random.default_rng(5).uniform(0, 1, (400, 200, 2)) * (high - low)[:, None]
    values = function(*places.reshape(-1, 2).T).reshape(400, 200)
    rounding = 1e-12
    assert (values.min(axis=1) >= found.low - rounding).all()
    assert (values.max(axis=1) <= found.high + rounding).all()
    away = np.hypot(*np.diff(places, axis=1).transpose(2, 0, 1))
    risen = np.abs(np.diff(values, axis=1)) / away
    assert (risen.max(axis=1) <= found.steepest * (1 + 1e-9) + rounding / away.min(axis=1)).all()


def test_a_distance_grows_by_the_way_and_no_more():
    assert Expression.parse("0.1 + 0.3*distance()", None, lambda labels: around_origin).bounds_within(
        *boxes(50)
    ).steepest == pytest.approx(0.3)
    assert COARSE.bounds_within(*boxes(50)).steepest == pytest.approx(0.9)


def test_limits_say_nothing_where_there_may_be_no_spacing():
    low = np.array([[-1.0, 0.0], [0.1, 0.0]])
    found = OF_DISTANCES["negative"].bounds_within(low, low + 0.5)
    assert np.isinf(found.steepest).tolist() == [True, False]
    assert found.low[0] == -np.inf


def test_a_combination_with_a_term_of_no_bounds_has_none():
    assert Combination((Spacing(FINE), Spacing(lambda x, y: x))).bounds_within(*boxes(3)) is None
    assert Combination((Spacing(nothing),)).bounds_within(*boxes(3)) is None


def test_a_term_that_asks_for_nothing_does_not_count_among_bounds():
    fine = Spacing(FINE)
    both = (Combination(terms).bounds_within(*boxes(3)) for terms in ((Spacing(nothing), fine), (fine,)))
    found, other = ((bounds.low, bounds.high, bounds.steepest) for bounds in both)
    np.testing.assert_array_equal(found, other)
