"""Arithmetic expressions in x and y, checked against an allow-list and evaluated by NumPy ufuncs."""

import ast
import keyword
import unicodedata
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from textwrap import shorten
from typing import Any

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError
from bubblemesh.spacing.functions import FUNCTIONS, OPERATORS, Function, chained, folded, select
from bubblemesh.wording import meant

__all__ = ["Expression", "check_parameter_name"]

MAX_CHARACTERS = 10_000
# Each level costs a Python frame or two, and the interpreter allows about a thousand.
MAX_DEPTH = 200

Evaluate = Callable[[Floats, Floats], Any]


# What people write who come from other languages, and what is meant here.
HINTS: dict[type[ast.AST], str] = {
    ast.BitXor: "'^' is not a power here: use ** for powers",
    ast.BitAnd: "'&' is not an operator here: use 'and'",
    ast.BitOr: "'|' is not an operator here: use 'or'",
    ast.Invert: "'~' is not an operator here: use 'not'",
}

FORBIDDEN: dict[type[ast.AST], str] = {
    ast.Attribute: "a dot between names",
    ast.Subscript: "an index in brackets",
    ast.Starred: "unpacking with *",
    ast.Lambda: "a lambda",
    ast.NamedExpr: "an assignment",
    ast.JoinedStr: "text in quotes",
    ast.List: "a list",
    ast.Tuple: "a comma outside a call",
}

CONSTANTS = {"pi": float(np.pi), "e": float(np.e)}
COORDINATES: dict[str, Evaluate] = {"x": lambda x, y: x, "y": lambda x, y: y}


def check_parameter_name(name: str) -> None:
    """Refuse a parameter that no expression could use.

    Raises
    ------
    CaseError
        If ``name`` is not an identifier, or already means something in every expression.
    """
    if not name.isidentifier() or keyword.iskeyword(name):
        raise CaseError(f"the parameter {name!r} is not a name: use letters, digits and underscores")
    if name in FUNCTIONS or name in CONSTANTS or name in COORDINATES:
        raise CaseError(f"the parameter {name!r} would hide the {name} that expressions already have: rename it")


@dataclass(frozen=True)
class Expression:
    """A real function of x and y given as text; made by `Expression.parse`.

    Attributes
    ----------
    text : str
        The expression as given, without the space around it.
    parameters : mapping of str to float
        The constants it may name.
    """

    text: str
    parameters: Mapping[str, float] = field(hash=False)
    _evaluate: Evaluate = field(repr=False, compare=False)

    @classmethod
    def parse(cls, text: str, parameters: Mapping[str, float] | None = None) -> "Expression":
        """Check ``text`` and bind its parameters.

        Comparisons, ``and``, ``or`` and ``not`` give 1 and 0; as a condition, everything but 0 is true.
        All numbers are float64 from the start, so that ``9**9**9**9`` is infinite rather than endless.

        Raises
        ------
        CaseError
            If the text is not such an expression; the message names the column and the part of the text.
        """
        text, parameters = text.strip(), dict(parameters or {})
        for name in parameters:
            check_parameter_name(name)
        # Python compares identifiers in this normal form, in which the micro sign is a Greek mu.
        constants = {unicodedata.normalize("NFKC", name): float(value) for name, value in parameters.items()}
        return cls(text, parameters, _Builder(text, CONSTANTS | constants).built(_tree(text), 0))

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Values at the points (x, y), in the arrays' common shape; nan and infinite ones are passed on."""
        x, y = np.asarray(x, np.float64), np.asarray(y, np.float64)
        with np.errstate(all="ignore"):
            values = self._evaluate(x, y)
        return np.array(np.broadcast_to(values, np.broadcast_shapes(x.shape, y.shape)), np.float64)

    def __reduce__(self) -> tuple[Any, ...]:
        # Closures do not travel to worker processes; the text does.
        return Expression.parse, (self.text, self.parameters)


def _tree(text: str) -> ast.expr:
    """Syntax tree of ``text``; columns count in characters of the text as one line."""
    if not text:
        raise CaseError("the expression is empty: give a number or a formula in x and y")
    if len(text) > MAX_CHARACTERS:
        raise CaseError(f"the expression has {len(text):,} characters: at most {MAX_CHARACTERS:,} are allowed")
    if "#" in text:
        raise _error("no comments in an expression", text, text.index("#"))
    line = "".join(" " if character.isspace() else character for character in text)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            return ast.parse(line, mode="eval").body
    except (RecursionError, MemoryError):
        raise CaseError(f"the expression is nested too deeply: {_shown(text)}") from None
    except SyntaxError as error:
        # The parser gives column 0 where the text ends too early.
        column = min(error.offset or len(text), len(text)) - 1
        raise _error(f"not an expression ({shorten(error.msg, 100)})", text, column) from None
    except ValueError as error:
        raise CaseError(f"the expression is not readable text ({error}): {_shown(text)}") from None


def _shown(part: str) -> str:
    return repr(part if len(part) <= 60 else part[:57] + "...")


def _error(problem: str, text: str, start: int, end: int | None = None) -> CaseError:
    return CaseError(f"column {start + 1}: {problem}, at {_shown(text[start:end])}")


class _Builder:
    """Turns checked syntax nodes into nested closures ``(x, y) -> array``."""

    def __init__(self, text: str, constants: Mapping[str, float]) -> None:
        self.text = text
        self.constants = constants

    def built(self, node: ast.expr, depth: int) -> Evaluate:
        if depth > MAX_DEPTH:
            raise CaseError(f"the expression is nested more than {MAX_DEPTH} deep: {_shown(self.text)}")
        parts: Sequence[ast.expr]
        match node:
            case ast.Constant(value=value):
                return self._number(node, value)
            case ast.Name(id=name):
                return self._named(node, name)
            case ast.Call():
                call, parts = self._function(node).call, node.args
            case ast.BinOp(left=left, op=op, right=right):
                call, parts = self._operator(node, op), [left, right]
            case ast.UnaryOp(op=op, operand=operand):
                call, parts = self._operator(node, op), [operand]
            case ast.BoolOp(op=op, values=parts):
                call = folded(self._operator(node, op))
            case ast.IfExp(test=test, body=body, orelse=orelse):
                call, parts = select, [test, body, orelse]
            case ast.Compare(left=left, ops=ops, comparators=comparators):
                call, parts = chained([self._operator(node, op) for op in ops]), [left, *comparators]
            case _:
                raise self._error(node, f"{FORBIDDEN.get(type(node), 'this')} is not allowed in an expression")
        return _applied(call, [self.built(part, depth + 1) for part in parts])

    def _number(self, node: ast.expr, value: object) -> Evaluate:
        if not isinstance(value, int | float) or isinstance(value, bool):
            raise self._error(node, "only real numbers are allowed in an expression")
        return _constant(value)

    def _named(self, node: ast.expr, name: str) -> Evaluate:
        if name in COORDINATES:
            return COORDINATES[name]
        if name in self.constants:
            return _constant(self.constants[name])
        if name in FUNCTIONS:
            raise self._error(node, f"{name!r} is a function: give it {FUNCTIONS[name].arity()} in parentheses")
        known = [*COORDINATES, *self.constants]
        raise self._error(node, f"unknown name {name!r}; {meant(name, known)}")

    def _function(self, node: ast.Call) -> Function:
        if not isinstance(node.func, ast.Name):
            raise self._error(node.func, "only functions of the table can be called")
        name = node.func.id
        if name in COORDINATES or name in self.constants:
            raise self._error(node, f"{name!r} is not a function: write * to multiply")
        if name not in FUNCTIONS:
            raise self._error(node, f"unknown function {name!r}; {meant(name, FUNCTIONS)}")
        if node.keywords:
            raise self._error(node, f"the arguments of {name} go without names")
        function = FUNCTIONS[name]
        if not function.accepts(len(node.args)):
            raise self._error(node, f"{name} takes {function.arity()}, found {len(node.args)}")
        return function

    def _operator(self, node: ast.expr, op: ast.AST) -> Callable[..., Any]:
        if type(op) not in OPERATORS:
            raise self._error(node, HINTS.get(type(op), "this operator is not allowed in an expression"))
        return OPERATORS[type(op)]

    def _error(self, node: ast.expr, problem: str) -> CaseError:
        # The tree counts bytes of UTF-8.
        encoded = self.text.encode()
        start, end = (len(encoded[:offset].decode()) for offset in (node.col_offset, node.end_col_offset))
        return _error(problem, self.text, start, end)


def _constant(number: float) -> Evaluate:
    try:
        value = np.float64(number)
    except OverflowError:
        value = np.float64(np.inf)
    return lambda x, y: value


def _applied(call: Callable[..., Any], parts: Sequence[Evaluate]) -> Evaluate:
    if len(parts) == 1:
        (only,) = parts
        return lambda x, y: call(only(x, y))
    if len(parts) == 2:
        first, second = parts
        return lambda x, y: call(first(x, y), second(x, y))
    return lambda x, y: call(*[part(x, y) for part in parts])
