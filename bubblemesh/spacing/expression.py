"""Arithmetic expressions in x and y, checked against an allow-list and evaluated by NumPy ufuncs."""

import ast
import keyword
import math
import re
import unicodedata
from collections import ChainMap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError
from bubblemesh.messages import meant
from bubblemesh.records import record
from bubblemesh.spacing.bounds import Bounds, NoBoundsError
from bubblemesh.spacing.functions import FUNCTIONS, OPERATORS, Function, chained, folded, select
from bubblemesh.spacing.program import Program, ProgramBuilder, X, Y
from bubblemesh.spacing.quantities import Dimension, is_quantity, value_of
from bubblemesh.spacing.syntax import FORBIDDEN, HINTS, error_at, parsed, shown

if TYPE_CHECKING:
    from bubblemesh.geometry.distance.distances import Distance  # with which a case that is wrong should not wait


# Each level costs a Python frame or two, and the interpreter allows about a thousand.
MAX_DEPTH = 200

Evaluate = Callable[[Any, Any], Any]
Rasters = Mapping[str, Evaluate]
DistanceTo = Callable[[Sequence[str]], "Distance"]  # distance from what has some labels

CONSTANTS = {"pi": math.pi, "e": math.e}
COORDINATES = {"x": X, "y": Y}
RADII = "r", "R", "radius"  # names that people expect to be known
DISTANCE = "distance"  # the only function that takes text: labels of what the distance is measured from


def check_parameter_name(name: str) -> None:
    """Refuse a parameter that no expression could use.

    CaseError if ``name`` is not an identifier, or already means something in every expression.
    """
    if keyword.iskeyword(name):
        raise CaseError(f"the parameter {name!r} is a word that expressions cannot use as a name: rename it")
    if not name.isidentifier():
        raise CaseError(f"the parameter {name!r} is not a name: use letters, digits and underscores")
    if name in FUNCTIONS or name in CONSTANTS or name in COORDINATES or name == DISTANCE:
        raise CaseError(f"the parameter {name!r} would hide the {name} that expressions already have: rename it")


@record
class Expression:
    """A real function of two numbers, x and y unless they have other names, given as text.

    Made by `Expression.parse`.
    """

    text: str  # without the space around it
    parameters: "Parameters" = field(hash=False)  # constants that it may name
    costly: bool  # whether it measures distances that take long
    given: str = field(repr=False, compare=False)  # with the space around it
    _tree: ast.expr = field(repr=False, compare=False)
    _program: Program = field(repr=False, compare=False)
    _distance_to: DistanceTo | None = field(repr=False, compare=False)
    names: tuple[str, str] = ("x", "y")  # of the two numbers
    rasters: frozenset[str] = field(default=frozenset(), repr=False, compare=False)  # names of those in it
    _rasters: Rasters | None = field(default=None, repr=False, compare=False)

    @classmethod
    def parse(
        cls,
        text: str,
        parameters: Mapping[str, float] | None = None,
        distance_to: DistanceTo | None = None,
        names: tuple[str, str] = ("x", "y"),
    ) -> "Expression":
        """Check ``text`` and bind its parameters.

        Comparisons, ``and``, ``or`` and ``not`` give 1 and 0; as a condition, everything but 0 is true. All numbers are
        float64 from the start, so that ``9**9**9**9`` is infinite rather than endless. CaseError if the text is not
        such an expression; the message names the column and the part of the text.

        ``distance_to`` gives the distance from some labels for calls such as ``distance("bore")``, or raises a
        CaseError if a label is unknown. Without it, such calls are checked, but have no values.
        """
        return cls._of(
            text, checked_parameters({} if parameters is None else parameters), parsed(text.strip()), distance_to, names
        )

    @classmethod
    def _of(
        cls,
        given: str,
        parameters: "Parameters",
        tree: ast.expr,
        distance_to: DistanceTo | None,
        names: tuple[str, str],
        rasters: Rasters | None = None,
    ) -> "Expression":
        coordinates = dict(zip(names, COORDINATES.values(), strict=True))
        builder = _Builder(given.strip(), coordinates, parameters, distance_to, rasters=rasters)
        program = builder.steps.program(builder.built(tree, 0))
        named = frozenset(builder.named)
        return cls(given.strip(), parameters, builder.costly, given, tree, program, distance_to, names, named, rasters)

    def measuring(self, distance_to: DistanceTo, rasters: Rasters | None) -> "Expression":
        """Expression with values for its calls of the distance, and for rasters by names; same errors as `parse`."""
        return self._of(self.given, self.parameters, self._tree, distance_to, self.names, rasters)

    def __str__(self) -> str:
        return self.text

    @property
    def is_uniform(self) -> bool:
        """Whether it is the same everywhere."""
        return self._program.is_constant

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Values at the points (x, y), in the arrays' common shape; nan and infinite ones are passed on."""
        return _values(self._program, x, y)[0]

    def bounds_within(self, low: Floats, high: Floats) -> Bounds | None:
        """Bounds within boxes between corners low (n, 2) and high (n, 2); None if it is of what has none."""
        if self._rasters:
            return None
        try:
            with np.errstate(all="ignore"):
                return Bounds.of(*self._program(*Bounds.of_coordinates(low, high)))
        except NoBoundsError:
            return None

    def __reduce__(self) -> tuple[Any, ...]:
        # Closures do not travel to worker processes; the text does.
        return _again, (self.given, self.parameters, self._distance_to, self.names, self._rasters)


def together(expressions: Sequence[Expression]) -> Callable[[Floats, Floats], list[Floats]]:
    """The values of several expressions at the points (x, y): what they have in common is evaluated once."""
    builder = ProgramBuilder()
    results = [number for each in expressions for number in builder.added(each._program)]
    return partial(_values, builder.program(*results))


def _values(program: Program, x: Floats, y: Floats) -> list[Floats]:
    """What a program gives at the points (x, y), in the arrays' common shape."""
    x, y = np.asarray(x, np.float64), np.asarray(y, np.float64)
    with np.errstate(all="ignore"):
        found = program(x, y)
    shape = np.broadcast(x, y).shape
    results = [np.empty(shape) for _ in found]
    for result, values in zip(results, found, strict=True):
        result[...] = values
    return results


def _again(
    given: str,
    parameters: "Parameters",
    distance_to: DistanceTo | None,
    names: tuple[str, str],
    rasters: Rasters | None,
) -> Expression:
    """An expression in another process."""
    parsed_again = Expression.parse(given, parameters, distance_to, names)
    return parsed_again if distance_to is None else parsed_again.measuring(distance_to, rasters)


def is_raster_name(text: str, parameters: Mapping[str, float]) -> bool:
    """Whether a text is a name that can only be that of a raster."""
    return text.isidentifier() and text not in parameters and text not in CONSTANTS and text not in COORDINATES


def constant(text: str, parameters: Mapping[str, float], dimension: Dimension | None = "length") -> float:
    """Value of an expression of the parameters alone, with the same functions; infinities and nan are passed on.

    A quantity with a unit has to be of the ``dimension``, if one is given. CaseError as `Expression.parse`; x, y and
    distances have no value here.
    """
    text = text.strip()
    builder = _Builder(text, {}, checked_parameters(parameters), None, dimension)
    program, nowhere = builder.steps.program(builder.built(parsed(text), 0)), np.zeros(0)
    with np.errstate(all="ignore"):
        (value,) = program(nowhere, nowhere)
    return float(value)


def names_in(text: str) -> set[str]:
    """Names that stand in an expression, also those of functions; same errors as `Expression.parse`."""
    return {node.id for node in ast.walk(parsed(text.strip())) if isinstance(node, ast.Name)}


class Parameters(dict[str, float]):
    """Parameters whose names have been checked, once for all expressions that may name them.

    Python compares identifiers in the normal form of their keys, in which the micro sign is a Greek mu.
    """

    without_value: frozenset[str] = frozenset()  # names of those that have a fault
    units: bool = False  # whether quantities may have units


class UnknownNameError(CaseError):
    """An expression has a name that stands for nothing; or for a parameter with a fault, from which this follows."""

    def __init__(self, problem: str, name: str, *, follows: bool = False) -> None:
        super().__init__(problem)
        self.name = name
        self.follows = follows

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.text, self.name), vars(self)


def checked_parameters(parameters: Mapping[str, float]) -> Parameters:
    """Parameters that expressions may name; same errors as `check_parameter_name`."""
    if isinstance(parameters, Parameters):
        return parameters
    for name in parameters:
        check_parameter_name(name)
    return Parameters({normal(name): float(value) for name, value in parameters.items()})


def normal(name: str) -> str:
    """The form of a name in which Python compares identifiers."""
    return unicodedata.normalize("NFKC", name)


class _Builder:
    """Turns checked syntax nodes into steps, by the numbers of their values."""

    def __init__(
        self,
        text: str,
        coordinates: Mapping[str, int],
        parameters: Parameters,
        distance_to: DistanceTo | None,
        dimension: Dimension | None = "length",
        rasters: Rasters | None = None,
    ) -> None:
        self.text = text
        self.coordinates = coordinates
        self.constants = ChainMap(parameters, CONSTANTS)
        self.without_value = parameters.without_value
        self.units, self.dimension = parameters.units, dimension
        self.rasters = rasters
        self.distance_to = distance_to
        self.costly, self.named = False, set[str]()
        self.steps = ProgramBuilder()
        self.distances: dict[tuple[str, ...], Evaluate] = {}

    def built(self, node: ast.expr, depth: int) -> int:
        """The number of the value of a node."""
        if depth > MAX_DEPTH:
            raise CaseError(f"the expression is nested more than {MAX_DEPTH} deep: {shown(self.text)}")
        parts: Sequence[ast.expr]
        match node:
            case ast.Constant() | ast.Name() | ast.Attribute(value=ast.Name(id="raster")):
                return self._leaf(node)
            case ast.Call(func=ast.Name(id=name)) if name == DISTANCE:
                return self._measured(node)
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
                raise self._error(node, self._forbidden(node))
        return self.steps.step(call, [self.built(part, depth + 1) for part in parts])

    def _forbidden(self, node: ast.expr) -> str:
        """Message on what has no place in an expression."""
        told = f"{FORBIDDEN.get(type(node), 'this')} is not allowed in an expression"
        if isinstance(node, ast.Tuple) and (number := re.search(r"(?<!\w)\d+,\d+", self.text)):
            told += f": write {number[0].replace(',', '.')} for the number {number[0]}"
        return told

    def _leaf(self, node: ast.Constant | ast.Name | ast.Attribute) -> int:
        if isinstance(node, ast.Attribute):
            return self._of_raster(node)
        return self._named(node, node.id) if isinstance(node, ast.Name) else self._number(node, node.value)

    def _number(self, node: ast.expr, value: object) -> int:
        if not isinstance(value, int | float) or isinstance(value, bool):
            raise self._error(node, "only real numbers are allowed in an expression")
        return self._constant(value)

    def _named(self, node: ast.expr, name: str) -> int:
        if name in self.coordinates:
            return self.coordinates[name]
        if name in self.constants:
            return self._constant(self.constants[name])
        if name in FUNCTIONS:
            raise self._error(node, f"{name!r} is a function: give it {FUNCTIONS[name].arity()} in parentheses")
        if name == DISTANCE:
            raise self._error(node, f"{name!r} is a function: give it labels in parentheses and quotes, or none")
        if is_quantity(name):
            return self._constant(value_of(name, self.dimension, allowed=self.units))
        if name in self.without_value:
            raise UnknownNameError(f"the parameter {name!r} has no value", name, follows=True)
        told = meant(name, [*self.coordinates, *self.constants])
        if name in RADII and "x" in self.coordinates:
            told += "; the distance from the origin is hypot(x, y)"
        raise UnknownNameError(str(self._error(node, f"unknown name {name!r}; {told}")), name)

    def _function(self, node: ast.Call) -> Function:
        if not isinstance(node.func, ast.Name):
            if isinstance(node.func, ast.Attribute) and node.func.attr in FUNCTIONS:
                raise self._error(node.func, f"functions go by their names alone: write {node.func.attr}")
            raise self._error(node.func, f"only functions can be called: {', '.join([*FUNCTIONS, DISTANCE])}")
        name = node.func.id
        if name in COORDINATES or name in self.constants:
            raise self._error(node, f"{name!r} is not a function: write * to multiply")
        if name not in FUNCTIONS:
            raise self._error(node, f"unknown function {name!r}; {meant(name, [*FUNCTIONS, DISTANCE])}")
        if node.keywords:
            raise self._error(node, f"the arguments of {name} go without names")
        function = FUNCTIONS[name]
        if not function.accepts(len(node.args)):
            raise self._error(node, f"{name} takes {function.arity()}, found {len(node.args)}")
        return function

    def _of_raster(self, node: ast.Attribute) -> int:
        """Values of a raster of the spacing, by its name."""
        self.named.add(node.attr)
        if self.rasters is None:
            return self.steps.step(_unknown_raster, (X, Y))
        if node.attr not in self.rasters:
            advice = meant(node.attr, list(self.rasters)) if self.rasters else "give one under spacing.raster"
            raise self._error(node, f"there is no raster {node.attr!r}: {advice}")
        return self.steps.step(self.rasters[node.attr], (X, Y))

    def _measured(self, node: ast.Call) -> int:
        """A call of the distance, whose arguments are labels."""
        if node.keywords:
            raise self._error(node, f"the arguments of {DISTANCE} go without names")
        labels: list[str] = []
        for part in node.args:
            if not (isinstance(part, ast.Constant) and isinstance(part.value, str)):
                raise self._error(part, f"{DISTANCE} takes labels in quotes, or nothing for the whole boundary")
            labels.append(part.value)
        if self.distance_to is None:
            return self.steps.step(_unmeasured, (X, Y))
        if tuple(labels) not in self.distances:
            try:
                distance = self.distance_to(labels)
            except CaseError as error:
                raise self._error(node, str(error)) from None
            self.costly |= distance.costly
            self.distances[tuple(labels)] = _of_points(distance)
        return self.steps.step(self.distances[tuple(labels)], (X, Y))

    def _constant(self, number: float) -> int:
        try:
            return self.steps.constant(np.float64(number))
        except OverflowError:
            return self.steps.constant(np.float64(np.inf))

    def _operator(self, node: ast.expr, op: ast.AST) -> Callable[..., Any]:
        if type(op) not in OPERATORS:
            raise self._error(node, HINTS.get(type(op), "this operator is not allowed in an expression"))
        return OPERATORS[type(op)]

    def _error(self, node: ast.expr, problem: str) -> CaseError:
        return error_at(node, self.text, problem)


def _unmeasured(x: Floats, y: Floats) -> Floats:
    raise CaseError(f"{DISTANCE}(...) is measured from the boundary of a domain, and there is none here")


def _unknown_raster(x: Floats, y: Floats) -> Floats:
    raise CaseError("a raster is known by its name only in a spacing that has it: give it under raster: beside value:")


def _of_points(distance: "Distance") -> Evaluate:
    def evaluate(x: Floats, y: Floats) -> Any:
        if isinstance(x, Bounds) and isinstance(y, Bounds):
            return Bounds.of_distance(distance, x, y)
        x, y = np.broadcast_arrays(x, y)
        return distance(np.column_stack([x.ravel(), y.ravel()])).reshape(x.shape)

    return evaluate
