"""Parameters of a case that depend on others, and texts that hold parameters."""

import math
import re
from collections.abc import Callable, Mapping
from graphlib import CycleError, TopologicalSorter
from typing import Any

from bubblemesh.errors import CaseError
from bubblemesh.messages import unknown
from bubblemesh.spacing.expression import Parameters, check_parameter_name, constant, names_in, normal

BRACES = re.compile(r"\{\{|\}\}|\{([^{}]*)\}|[{}]")


def is_number(value: object) -> bool:
    """Whether ``value`` is the text of a number."""
    try:
        return isinstance(value, str) and isinstance(float(value), float)
    except ValueError:
        return False


def resolved(given: Mapping[str, Any], message: Callable[[str, object], str]) -> dict[str, Any]:
    """Parameters with numbers in place of expressions of other parameters, which may stand in any order.

    What is neither a number nor such a text stays as it is. CaseError with a line for each text that is no expression,
    or if parameters depend on each other in a circle; ``message`` makes the line of a parameter and its problem.
    """
    texts = {normal(name): name for name, value in given.items() if isinstance(value, str) and not is_number(value)}
    values, needed, problems = known_parameters(given), dict[str, set[str]](), dict[str, str]()
    known = Parameters(dict.fromkeys(map(normal, given), math.nan) | values)  # names that an expression may have
    for name, key in texts.items():
        try:
            constant(given[key], known)
            needed[name] = names_in(given[key])
        except CaseError as error:
            problems[key] = message(key, f"must be a number, or an expression of other parameters: {error}")
    for name in _in_order({name: names & texts.keys() for name, names in needed.items()}, message):
        if name in needed and needed[name] & known.keys() <= values.keys():  # else what it needs has a fault
            values[name] = constant(given[texts[name]], values)
    if problems:
        raise CaseError("\n".join(problems.values()))
    return {key: values.get(normal(key), value) if isinstance(value, str) else value for key, value in given.items()}


def known_parameters(given: Mapping[str, Any]) -> Parameters:
    """Parameters that are numbers, by names that expressions can have; others are reported where they stand."""
    numbers = {name: float(value) for name, value in given.items() if type(value) in (int, float)}
    return Parameters({normal(name): value for name, value in numbers.items() if _is_usable(name)})


def _is_usable(name: str) -> bool:
    try:
        check_parameter_name(name)
    except CaseError:
        return False
    return True


def filled_in(text: str, parameters: Mapping[str, float]) -> str:
    """The text with the values of the parameters that it names in braces, such as ``part-{r}.dxf``.

    Two braces stand for one. CaseError if there is no such parameter.
    """

    def value(match: re.Match[str]) -> str:
        name = match[1]
        if match[0] in ("{{", "}}"):
            return match[0][0]
        if name is None:
            raise CaseError("has a single brace: write {{ or }} for a brace, {name} for a parameter")
        key = normal(name.strip())
        if key not in parameters:
            hint = (
                unknown("parameter", name, parameters) if parameters else f"unknown parameter {name!r}; there is none"
            )
            raise CaseError(f"{hint}; write {{{{ for a brace")
        return f"{parameters[key]:.12g}"

    return BRACES.sub(value, text)


def literal(text: str) -> str:
    """The text as `filled_in` gives it again, whatever braces it has."""
    return text.replace("{", "{{").replace("}", "}}")


def _in_order(needed: Mapping[str, set[str]], message: Callable[[str, object], str]) -> list[str]:
    """Names, each after those that it needs."""
    try:
        return list(TopologicalSorter(needed).static_order())
    except CycleError as error:
        cycle = error.args[1][::-1]
        problem = f"depends on itself: {' -> '.join(cycle)}: give one of them a number"
        raise CaseError(message(cycle[0], problem)) from None
