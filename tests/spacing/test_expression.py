import math
import pickle
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bubblemesh.errors import CaseError
from bubblemesh.spacing import expression as module
from bubblemesh.spacing.expression import Expression, checked_parameters, constant, together
from bubblemesh.spacing.functions import FUNCTIONS

X = np.array([-1.5, -0.25, 0.0, 0.5, 2.0])
Y = np.array([0.75, -2.0, 1.0, 0.5, -0.125])

VALUES = [
    ("x + y", X + Y),
    ("x - y*3", X - Y * 3),
    ("x/y", X / Y),
    ("x**2", X**2),
    ("-x**2", -(X**2)),
    ("2**-x", 2**-X),
    ("x % 0.4", X % 0.4),
    ("x // 0.4", X // 0.4),
    ("+x", X),
    ("x < y", X < Y),
    ("-1 < x <= 0.5", (X > -1) & (X <= 0.5)),
    ("x == 0.5", X == 0.5),
    ("x != 0.5", X != 0.5),
    ("x >= 0 and y >= 0", (X >= 0) & (Y >= 0)),
    ("x > 0 or y > 0 or x < -1", (X > 0) | (Y > 0) | (X < -1)),
    ("not x", X == 0),
    ("(x > 0) - (y > 0)", (X > 0) * 1.0 - (Y > 0)),
    ("0.1 if x > 0 else y", np.where(X > 0, 0.1, Y)),
    ("where(x > 0, 0.1, y)", np.where(X > 0, 0.1, Y)),
    ("where(x, 1, 2)", np.where(X != 0, 1, 2)),
    ("min(x, y)", np.minimum(X, Y)),
    ("max(x, y, 0.6)", np.maximum(np.maximum(X, Y), 0.6)),
    ("minimum(x, y) + maximum(x, y)", X + Y),
    ("abs(x)", abs(X)),
    ("sqrt(abs(x))", np.sqrt(abs(X))),
    ("exp(x)", np.exp(X)),
    ("log(x*x + 1)", np.log(X * X + 1)),
    ("log10(x*x + 1)", np.log10(X * X + 1)),
    ("log2(x*x + 1)", np.log2(X * X + 1)),
    ("sin(x) + cos(x) + tan(x)", np.sin(X) + np.cos(X) + np.tan(X)),
    ("asin(x/3) + arccos(x/3)", np.full(5, np.pi / 2)),
    ("acos(x/3) - arcsin(x/3)", np.arccos(X / 3) - np.arcsin(X / 3)),
    ("atan(x) + arctan(y)", np.arctan(X) + np.arctan(Y)),
    ("atan2(y, x) + arctan2(x, y)", np.arctan2(Y, X) + np.arctan2(X, Y)),
    ("sinh(x) + cosh(x) + tanh(x)", np.sinh(X) + np.cosh(X) + np.tanh(X)),
    ("asinh(x) - arcsinh(y)", np.arcsinh(X) - np.arcsinh(Y)),
    ("acosh(3 + x) - arccosh(3 + y)", np.arccosh(3 + X) - np.arccosh(3 + Y)),
    ("atanh(x/3) - arctanh(y/3)", np.arctanh(X / 3) - np.arctanh(Y / 3)),
    ("cbrt(x)", np.cbrt(X)),
    ("erf(x) + 2*erfc(y)", np.array([math.erf(x) + 2 * math.erfc(y) for x, y in zip(X, Y, strict=True)])),
    ("hypot(x, y)", np.hypot(X, Y)),
    ("floor(x) + ceil(y)", np.floor(X) + np.ceil(Y)),
    ("round(x)", np.round(X)),
    ("sign(x)", np.sign(X)),
    ("clip(x, -1, 0.3)", np.clip(X, -1, 0.3)),
    ("pow(x, 2) + mod(x, 0.4)", X**2 + X % 0.4),
    ("pi + e", np.full(5, np.pi + np.e)),
    ("1e-3 + .5 + 0x10", np.full(5, 16.501)),
    ("h*x + gröẞe", 0.1 * X + 7),
    ("\n  x\n  + y\t", X + Y),
    ("hypot(x,\n      y)", np.hypot(X, Y)),
]

REJECTED = [
    ("", "empty"),
    ("   ", "empty"),
    ("x +", "column 3"),
    ("2x", "column 1"),
    ("(x", "column 1"),
    ("x y", "not an expression"),
    ("x = 2", "not an expression"),
    ("import os", "not an expression"),
    ("x.real", "a dot between names"),
    ("().__class__.__bases__", "a dot between names"),
    ("sqrt.__globals__", "a dot between names"),
    ("x[0]", "an index in brackets"),
    ("'x'", "only real numbers"),
    ("b'x'", "only real numbers"),
    ("f'{x}'", "text in quotes"),
    ("True", "only real numbers"),
    ("None", "only real numbers"),
    ("...", "only real numbers"),
    ("1j*x", "column 1: only real numbers are allowed in an expression, at '1j'"),
    ("lambda: x", "a lambda"),
    ("[x, y]", "a list"),
    ("x, y", "a comma outside a call"),
    ("0,5*x", "a comma outside a call is not allowed in an expression: write 0.5 for the number 0,5"),
    ("{x}", "a name in braces, which are for texts"),
    ("[i for i in x]", "this is not allowed"),
    ("(z := x)", "column 2: an assignment"),
    ("await x", "this is not allowed"),
    ("x^2", "use [*][*] for powers"),
    ("x > 0 & y > 0", "use 'and'"),
    ("x > 0 | y > 0", "use 'or'"),
    ("~x", "use 'not'"),
    ("x @ y", "operator is not allowed"),
    ("x << 2", "operator is not allowed"),
    ("x is y", "operator is not allowed"),
    ("x in y", "operator is not allowed"),
    ("1 + radious", "column 5: unknown name 'radious'; did you mean 'radius'[?], at 'radious'"),
    ("z", "unknown name 'z'; allowed: x, y, pi, e, h"),
    ("gröẞe + zzz", "column 9: unknown name 'zzz'"),
    ("1 +\u00a0foo", "column 5: unknown name 'foo'"),
    ("1\u2003+\u00a0foo + 2", "column 5: unknown name 'foo'.*, at 'foo'"),
    ("sin", "'sin' is a function: give it 1 argument in parentheses"),
    ("1 + sqr(x)", "column 5: unknown function 'sqr'; did you mean 'sqrt'[?], at 'sqr.x.'"),
    ("__import__('os')", "unknown function '__import__'"),
    ("eval(x)", "unknown function 'eval'"),
    ("x(2)", "write [*] to multiply"),
    ("h(2)", "write [*] to multiply"),
    ("sin(x)(y)", "only functions can be called: .*sqrt, .*distance"),
    ("np.abs(x)", "functions go by their names alone: write abs, at 'np.abs'"),
    ("r", "unknown name 'r'; did you mean 'radius'[?]; the distance from the origin is hypot\\(x, y\\)"),
    ("min(8 km, 2*x)", "column 5: a unit stands only .*: write parameters: {far: 8 km} and here far.*, at '8 km'"),
    ("x + 2.5in", "column 5: a unit stands only .*: write parameters: {far: 2.5in} and here far"),
    ("2 miles", "not an expression"),
    ("hypot(x, y=2)", "without names"),
    ("min(*x, 1)", "unpacking"),
    ("min(x, **y)", "without names"),
    ("min(x)", "min takes 2 or more arguments, found 1"),
    ("sin()", "sin takes 1 argument, found 0"),
    ("sin(x, y)", "sin takes 1 argument, found 2"),
    ("where(x, y)", "where takes 3 arguments, found 2"),
    ("x # comment\n + 1", "column 3: no comments"),
    ("x\0", "not an expression|not readable"),
    ("\udcff", "not readable"),
    ("9" * 4_301, "not an expression"),
    ("x" * 1_000_000, "1,000,000 characters: at most 10,000"),
    ("(" * 4_999 + ")" * 4_999, "not an expression|too deeply"),
    ("(" * 5_000 + "x" + ")" * 5_000, "10,001 characters"),
    ("-" * 5_000 + "x", "nested"),
    ("x" + "+x" * 4_000, "nested"),
    ("x" + "+x" * 250, "nested more than 200"),
]


@pytest.mark.parametrize(("text", "expected"), VALUES, ids=[text for text, _ in VALUES])
def test_values_are_those_of_numpy(text, expected):
    values = Expression.parse(text, {"h": 0.1, "gröẞe": 7})(X, Y)
    assert values.dtype == np.float64
    assert values.shape == X.shape
    np.testing.assert_allclose(values, expected, rtol=1e-15, atol=1e-15)


@pytest.mark.parametrize(("text", "message"), REJECTED, ids=[text[:30] for text, _ in REJECTED])
def test_rejected_at_parse_time(text, message):
    with pytest.raises(CaseError, match=message):
        Expression.parse(text, {"h": 0.1, "radius": 2.0, "gröẞe": 7})


class Circles:
    """Distances from circles that are called by their radii."""

    def __init__(self, costly=False):
        self.costly = costly

    def __call__(self, labels):
        for label in labels:
            if not label.strip("#").isdigit():
                raise CaseError(f"unknown label {label!r}; known: 1, 2")
        return FromCircles([float(label.strip("#")) for label in labels] or [3.0], self.costly)


@dataclass
class FromCircles:
    radii: list
    costly: bool

    def __call__(self, points):
        return np.min([np.abs(np.hypot(*points.T) - radius) for radius in self.radii], axis=0)


R = np.hypot(X, Y)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("distance('1')", abs(R - 1)),
        ('h + 2*distance("1")**2', 0.1 + 2 * (R - 1) ** 2),
        ("distance('1', '2')", np.minimum(abs(R - 1), abs(R - 2))),
        ("distance()", abs(R - 3)),
        (
            "min(distance('1'), 0.5*distance( '2' ) if x > 0 else y)",
            np.minimum(abs(R - 1), np.where(X > 0, abs(R - 2) / 2, Y)),
        ),
        ("distance('#1') + x", abs(R - 1) + X),
    ],
)
def test_distances_are_measured(text, expected):
    expression = Expression.parse(text, {"h": 0.1}, Circles())
    assert not expression.costly
    assert Expression.parse(text, {"h": 0.1}, Circles(costly=True)).costly
    np.testing.assert_allclose(expression(X, Y), expected, rtol=1e-14)
    Expression.parse(text, {"h": 0.1})  # without a domain the syntax is checked all the same


def test_distances_have_the_common_shape():
    values = Expression.parse("distance('1')", {}, Circles())(np.zeros((3, 1)), np.arange(4.0)[None])
    np.testing.assert_array_equal(values, np.broadcast_to([1.0, 0.0, 1.0, 2.0], (3, 4)))
    assert Expression.parse("distance('1')", {}, Circles())(0.5, 0.0) == 0.5


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0.1 + distance(bore)", "column 16: distance takes labels in quotes.*, at 'bore'"),
        ("distance(3)", "column 10: distance takes labels in quotes"),
        ("distance('1', x)", "column 15: distance takes labels in quotes.*, at 'x'"),
        ("distance(b'1')", "column 10: distance takes labels in quotes"),
        ("distance(f'{x}')", "column 10: distance takes labels in quotes"),
        ("distance(*x)", "column 10: distance takes labels in quotes"),
        ("distance(label='1')", "column 1: the arguments of distance go without names"),
        ("distance('1'", "not an expression"),
        ("distance('1)", "not an expression"),
        ("distance", "'distance' is a function: give it labels in parentheses and quotes"),
        ("distence('1')", "unknown function 'distence'; did you mean 'distance'"),
        ("min('1', 2)", "column 5: only real numbers are allowed in an expression, at \"'1'\""),
        ("distance('1') + '1'", "column 17: only real numbers"),
        ("distance('1').real", "a dot between names"),
        ("distance('1')('2')", "only functions can be called"),
        ("distance('1') # '", "column 15: no comments"),
        ("distance('1\\x31')", "column 12: no backslashes"),
    ],
)
def test_text_is_allowed_as_a_label_only(text, message):
    for distance_to in (None, Circles()):
        with pytest.raises(CaseError, match=message):
            Expression.parse(text, {}, distance_to)


def test_an_unknown_label_is_told_with_its_column():
    with pytest.raises(CaseError, match=r"column 9: unknown label 'boer'; known: 1, 2, at .distance\('1', 'boer'\)"):
        Expression.parse("0.1 + 2*distance('1', 'boer')", {}, Circles())


def test_without_a_domain_a_distance_has_no_value():
    expression = Expression.parse("x + distance('1')")
    with pytest.raises(CaseError, match="measured from the boundary of a domain"):
        expression(X, Y)


def test_distances_travel_to_worker_processes():
    expression = Expression.parse("x + distance('1')", {}, Circles())
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(expression))(X, Y), expression(X, Y))


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("distance", "hide the distance"),
        ("x", "hide the x"),
        ("y", "hide the y"),
        ("pi", "hide the pi"),
        ("sqrt", "hide the sqrt"),
        ("2h", "not a name"),
        ("a-b", "not a name"),
        ("if", "is a word that expressions cannot use as a name: rename it"),
        ("", "not a name"),
    ],
)
def test_parameter_names_are_checked(name, message):
    with pytest.raises(CaseError, match=f"'{name}'.*{message}"):
        Expression.parse("x", {name: 1.0})


@pytest.mark.parametrize("text", ["9**9**9**9", "9**9**9**9 + x", "0x" + "f" * 5_000, "9" * 400, "exp(1e6)", "1/0"])
def test_huge_numbers_are_infinite(text):
    assert np.isposinf(Expression.parse(text)(X, Y)).all()


def test_nan_is_passed_on_without_a_warning():
    assert np.isnan(Expression.parse("sqrt(x) + log(y)")(np.array([-1.0]), np.array([-1.0]))).all()


def test_result_is_a_new_array_of_the_common_shape():
    values = Expression.parse("x")(X, Y)
    values[0] = 99.0
    assert X[0] == -1.5
    assert Expression.parse("1")(np.zeros((3, 1)), np.zeros((1, 4))).shape == (3, 4)


def test_micro_sign_typed_on_a_keyboard_is_the_greek_letter():
    np.testing.assert_array_equal(Expression.parse("µ*x", {"µ": 2.0})(X, Y), 2 * X)


def test_expression_keeps_its_text_and_travels_to_worker_processes():
    expression = Expression.parse(" h*x ", {"h": 3.0})
    assert expression.text == "h*x"
    copy = pickle.loads(pickle.dumps(expression))
    assert copy == expression
    np.testing.assert_array_equal(copy(X, Y), 3 * X)


BINARY = {"+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide, "%": np.mod, "**": np.power}
CALLS = {"sin": np.sin, "abs": np.abs, "floor": np.floor, "exp": np.exp, "min": np.minimum, "hypot": np.hypot}
LEAVES = st.one_of(st.sampled_from(["x", "y"]), st.floats(0, 1e6), st.integers(0, 10**30))


def grown(trees):
    """Trees (kind, part, ...) one level higher."""
    return st.one_of(
        st.tuples(st.sampled_from(sorted(BINARY)), trees, trees),
        st.tuples(st.sampled_from(["sin", "abs", "floor", "exp", "-"]), trees),
        st.tuples(st.sampled_from(["min", "hypot", "<"]), trees, trees),
        st.tuples(st.just("if"), trees, trees, trees),
    )


def written(tree):
    if not isinstance(tree, tuple):
        return str(tree)
    kind, *parts = tree[0], *map(written, tree[1:])
    if kind == "if":
        return f"({parts[0]} if {parts[1]} else {parts[2]})"
    if kind in CALLS:
        return f"{kind}({', '.join(parts)})"
    return f"({kind}{parts[0]})" if len(parts) == 1 else f"({parts[0]} {kind} {parts[1]})"


def computed(tree):
    if not isinstance(tree, tuple):
        return {"x": X, "y": Y}[tree] if isinstance(tree, str) else np.float64(tree)
    kind, *parts = tree[0], *map(computed, tree[1:])
    if kind == "if":
        return np.where(parts[1] != 0, parts[0], parts[2])
    if kind == "<":
        return (parts[0] < parts[1]).astype(float)
    if len(parts) == 1 and kind == "-":
        return -parts[0]
    return (CALLS | BINARY)[kind](*parts)


@given(st.recursive(LEAVES, grown, max_leaves=12))
def test_random_arithmetic_agrees_with_numpy(tree):
    with np.errstate(all="ignore"):
        expected = np.broadcast_to(computed(tree), X.shape)
    np.testing.assert_array_equal(Expression.parse(written(tree))(X, Y), expected)


def test_distances_are_bound_to_an_expression_that_is_parsed_already():
    expression = Expression.parse(" x + distance('1')\n", {"h": 2.0})
    assert (expression.text, expression.given, str(expression)) == (
        "x + distance('1')",
        " x + distance('1')\n",
        expression.text,
    )
    bound = expression.measuring(Circles(), None)
    np.testing.assert_array_equal(bound(X, Y), Expression.parse(expression.text, {}, Circles())(X, Y))
    assert bound.parameters == {"h": 2.0}


def test_parameters_are_checked_once_for_all_expressions(monkeypatch):
    checked = []
    monkeypatch.setattr(module, "check_parameter_name", checked.append)
    parameters = checked_parameters({"a": 1, "b": 2.0})
    values = [Expression.parse(f"a*x + b*{k}", parameters)(np.ones(1), np.ones(1)).item() for k in range(3)]
    assert values == [1.0, 3.0, 5.0]
    assert constant("a + b", parameters) == 3.0
    assert checked == ["a", "b"]


def test_equal_parts_are_evaluated_once_and_constant_ones_are_known():
    measured = []

    class Measured:
        costly = True

        def __call__(self, points):
            measured.append(len(points))
            return points[:, 0]

    text = 'distance("a")**2 + 0.5*distance("a") + sin(2*pi*x)*sin(2*pi*x)'
    x = np.linspace(0, 1, 7)
    one = Expression.parse(text, distance_to=lambda labels: Measured())
    np.testing.assert_array_equal(one(x, x), x**2 + 0.5 * x + np.sin(2 * np.pi * x) * np.sin(2 * np.pi * x))
    assert measured == [7]
    assert Expression.parse("2*a + hypot(3, 4)", {"a": 0.5}).is_uniform
    assert not Expression.parse("2*a + 0*x", {"a": 0.5}).is_uniform
    assert not one.is_uniform


def test_what_is_evaluated_together_is_the_same_as_alone():
    texts = "atan2(y, x) + 1", "x if atan2(y, x) > 0.5 else y", "3", "x", "min(hypot(x, y), atan2(y, x), 0.7)"
    expressions = [Expression.parse(text) for text in texts]
    x, y = np.random.default_rng(0).random((2, 9))
    for found, one in zip(together(expressions)(x, y), expressions, strict=True):
        np.testing.assert_array_equal(found, one(x, y))
        assert found is not x


def test_docs_list_every_function():
    text = Path(__file__).parents[2].joinpath("docs", "case.md").read_text(encoding="utf-8")
    listed = set(re.findall(r"`(\w+)`", text.split("and these functions: ")[1].split(". They are checked")[0]))
    calls = [FUNCTIONS[name].call for name in listed]
    assert {name for name, function in FUNCTIONS.items() if function.call not in calls} == set()


def test_functions_of_scipy_are_loaded_by_cases_that_use_them():
    code = (
        "import sys\n"
        "import numpy as np\n"
        "from bubblemesh.spacing.expression import Expression\n"
        "loaded = []\n"
        "for text in 'tanh(x)', 'erf(x)':\n"
        "    Expression.parse(text)(np.ones(1), np.ones(1))\n"
        "    loaded.append('scipy' in sys.modules)\n"
        "assert loaded == [False, True], loaded\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
