"""Functions and operators of expressions: one table each, of ufuncs of NumPy and SciPy."""

import ast
from collections.abc import Callable, Sequence
from functools import reduce
from typing import Any, NamedTuple

import numpy as np


class Function(NamedTuple):
    """Function of expressions: what it calls, and with how many arguments."""

    call: Callable[..., Any]
    least: int
    most: int | None

    def accepts(self, count: int) -> bool:
        """Whether the function can be called with ``count`` arguments."""
        return self.least <= count and (self.most is None or count <= self.most)

    def arity(self) -> str:
        """Number of arguments that the function takes, in words."""
        if self.most is None:
            return f"{self.least} or more arguments"
        return f"{self.least} argument{'s' * (self.least > 1)}"


def _taking(call: Callable[..., Any], count: int = 1) -> Function:
    return Function(call, count, count)


def _taking_several(call: Callable[..., Any]) -> Function:
    return Function(folded(call), 2, None)


def folded(call: Callable[..., Any]) -> Callable[..., Any]:
    """The binary ``call`` taken from left to right over all its arguments."""
    return lambda *values: reduce(call, values)


def _of_scipy(name: str) -> Function:
    """The function of one argument with a name in SciPy, which is loaded when it is called."""

    def call(value: Any) -> Any:
        from scipy import special  # takes longer to load than most cases take to mesh

        return getattr(special, name)(value)

    return _taking(call)


def _as_number(call: Callable[..., Any]) -> Callable[..., Any]:
    """Give the answers of ``call`` as 1.0 and 0.0, since booleans do not subtract."""
    return lambda *values: np.multiply(call(*values), 1.0)


def select(condition: Any, chosen: Any, other: Any) -> Any:
    """``chosen`` where ``condition`` is not 0, else ``other``."""
    return np.where(np.not_equal(condition, 0.0), chosen, other)


def chained(calls: Sequence[Callable[..., Any]]) -> Callable[..., Any]:
    """The comparison ``a < b < c`` as ``a < b and b < c``."""

    def compare(*values: Any) -> Any:
        answers = (call(*pair) for call, *pair in zip(calls, values[:-1], values[1:], strict=True))
        return reduce(np.multiply, answers)

    return compare


FUNCTIONS = {
    **dict.fromkeys(["min", "minimum"], _taking_several(np.minimum)),
    **dict.fromkeys(["max", "maximum"], _taking_several(np.maximum)),
    **dict.fromkeys(["asin", "arcsin"], _taking(np.arcsin)),
    **dict.fromkeys(["acos", "arccos"], _taking(np.arccos)),
    **dict.fromkeys(["atan", "arctan"], _taking(np.arctan)),
    **dict.fromkeys(["asinh", "arcsinh"], _taking(np.arcsinh)),
    **dict.fromkeys(["acosh", "arccosh"], _taking(np.arccosh)),
    **dict.fromkeys(["atanh", "arctanh"], _taking(np.arctanh)),
    **dict.fromkeys(["atan2", "arctan2"], _taking(np.arctan2, 2)),
    "abs": _taking(np.abs),
    "sqrt": _taking(np.sqrt),
    "cbrt": _taking(np.cbrt),
    "exp": _taking(np.exp),
    "log": _taking(np.log),
    "log10": _taking(np.log10),
    "log2": _taking(np.log2),
    "sin": _taking(np.sin),
    "cos": _taking(np.cos),
    "tan": _taking(np.tan),
    "sinh": _taking(np.sinh),
    "cosh": _taking(np.cosh),
    "tanh": _taking(np.tanh),
    "erf": _of_scipy("erf"),
    "erfc": _of_scipy("erfc"),
    "hypot": _taking(np.hypot, 2),
    "floor": _taking(np.floor),
    "ceil": _taking(np.ceil),
    "round": _taking(np.rint),
    "sign": _taking(np.sign),
    "where": _taking(select, 3),
    "clip": _taking(lambda value, low, high: np.minimum(np.maximum(value, low), high), 3),
    "pow": _taking(np.power, 2),
    "mod": _taking(np.mod, 2),
}

OPERATORS: dict[type[ast.AST], Callable[..., Any]] = {
    ast.Add: np.add,
    ast.Sub: np.subtract,
    ast.Mult: np.multiply,
    ast.Div: np.divide,
    ast.Pow: np.power,
    ast.Mod: np.mod,
    ast.FloorDiv: np.floor_divide,
    ast.UAdd: np.positive,
    ast.USub: np.negative,
    ast.Not: _as_number(np.logical_not),
    ast.And: _as_number(np.logical_and),
    ast.Or: _as_number(np.logical_or),
    ast.Lt: _as_number(np.less),
    ast.LtE: _as_number(np.less_equal),
    ast.Gt: _as_number(np.greater),
    ast.GtE: _as_number(np.greater_equal),
    ast.Eq: _as_number(np.equal),
    ast.NotEq: _as_number(np.not_equal),
}
