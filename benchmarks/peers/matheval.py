"""A spacing as text for Gmsh's field MathEval."""

import ast
from collections.abc import Mapping

import numpy as np

OPERATORS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "^"}
FUNCTIONS = {
    **{name: name for name in ("abs", "sqrt", "exp", "log", "log10", "sin", "cos", "tan", "sinh", "cosh", "tanh")},
    **{name: name for name in ("asin", "acos", "atan", "min", "max")},
    **{"arcsin": "asin", "arccos": "acos", "arctan": "atan", "minimum": "min", "maximum": "max"},
}


def matheval(text: str, parameters: Mapping[str, float]) -> str:
    """The expression with its parameters' values, in Gmsh's notation.

    Raises
    ------
    ValueError
        If it uses what Gmsh does not have.
    """
    constants = {"pi": np.pi, "e": np.e} | dict(parameters)
    return _translated(ast.parse(text.strip().replace("\n", " "), mode="eval").body, constants)


def _translated(node: ast.expr, constants: Mapping[str, float]) -> str:
    def part(inner: ast.expr) -> str:
        return _translated(inner, constants)

    match node:
        case ast.Constant(value=int() | float() as value):
            return _decimal(value)
        case ast.Name(id="x" | "y" as name):
            return name
        case ast.Name(id=name) if name in constants:
            return _decimal(constants[name])
        case ast.BinOp(left=left, op=op, right=right) if type(op) in OPERATORS:
            return f"({part(left)}{OPERATORS[type(op)]}{part(right)})"
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return f"(0-{part(operand)})"
        case ast.Call(func=ast.Name(id="hypot"), args=[first, second]):
            return f"sqrt({part(first)}^2+{part(second)}^2)"
        case ast.Call(func=ast.Name(id=name), args=arguments) if name in FUNCTIONS:
            return f"{FUNCTIONS[name]}({','.join(map(part, arguments))})"
    raise ValueError(f"Gmsh's MathEval has no {ast.unparse(node)!r}")


def _decimal(value: float) -> str:
    """The number without exponent; a negative one in parentheses."""
    digits = np.format_float_positional(abs(value), trim="-")
    return f"(0-{digits})" if value < 0 else digits
