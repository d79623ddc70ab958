"""Parameters of a case that depend on others, and texts that contain parameters."""

import math
import re
from collections.abc import Iterator, Mapping
from graphlib import CycleError, TopologicalSorter
from typing import Any, NamedTuple

from bubblemesh.errors import CaseError
from bubblemesh.messages import MOST_NAMES, closest, unknown
from bubblemesh.spacing.expression import (
    Parameters,
    UnknownNameError,
    check_parameter_name,
    constant,
    names_in,
    normal,
)

WORD = re.compile(r"\w+")
BRACES = re.compile(r"\{\{|\}\}|\{([^{}]*)\}|[{}]")


def is_number(value: object) -> bool:
    """Whether ``value`` is the text of a number."""
    try:
        return isinstance(value, str) and isinstance(float(value), float)
    except ValueError:
        return False


class Resolved(NamedTuple):
    """Parameters with numbers in place of expressions, and the problems of expressions without a value.

    In ``given``, parameters with a problem, and those that depend on them, are missing. Values that are neither a
    number nor the text of an expression are unchanged.
    """

    given: dict[str, Any]
    problems: dict[str, str]  # of expressions, by the names of their parameters as they were given
    known: Parameters  # the parameters that expressions may use


def resolved(given: Mapping[str, Any], *, units: bool = False) -> Resolved:
    """Parameters with numbers in place of expressions of other parameters, in any order.

    With ``units``, quantities may have units. Problems are texts that are not expressions, and parameters that depend
    on each other in a circle.
    """
    texts = {normal(name): name for name, value in given.items() if isinstance(value, str) and not is_number(value)}
    values = _numbers(given)
    needed = dict[str, set[str]]()
    problems = dict[str, str]()
    known = Parameters(dict.fromkeys(map(normal, given), math.nan) | values)  # names that an expression may use
    known.units = values.units = units
    for name, key in texts.items():
        try:
            constant(given[key], known, None)
            needed[name] = names_in(given[key])
        except CaseError as error:
            problems[key] = f"must be a number, or an expression of other parameters: {error}"
    try:
        order = list(TopologicalSorter({name: names & texts.keys() for name, names in needed.items()}).static_order())
    except CycleError as error:
        order, cycle = [], error.args[1][::-1]
        problems[texts[cycle[0]]] = f"depends on itself: {' -> '.join(cycle)}: give one of them a number"
    for name in order:
        if name in needed and needed[name] & known.keys() <= values.keys():  # else one that it needs has a fault
            values[name] = constant(given[texts[name]], values, None)
    rest = {
        key: values[normal(key)] if normal(key) in texts else value
        for key, value in given.items()
        if normal(key) not in texts or normal(key) in values
    }
    names = [normal(name) for name in given if _is_usable(normal(name))]
    usable = Parameters({name: values[name] for name in names if name in values and math.isfinite(values[name])})
    usable.units = units
    usable.without_value = frozenset(names) - usable.keys()
    return Resolved(rest, problems, usable)


def _numbers(given: Mapping[str, Any]) -> Parameters:
    """Parameters that are numbers, if expressions can use their names."""
    numbers = {name: float(value) for name, value in given.items() if type(value) in (int, float)}
    return Parameters({normal(name): value for name, value in numbers.items() if _is_usable(name)})


def used_names(data: Mapping[str, Any]) -> set[str]:
    """All words in the texts of a case's data, and in those of parameters whose names are among these words.

    A parameter whose name is not among them has no effect; but a word may also be something else, such as a label.
    """
    parameters = data.get("parameters")
    own = {normal(name): value for name, value in parameters.items()} if isinstance(parameters, dict) else {}
    words = set[str]()
    ahead = _words({key: value for key, value in data.items() if key != "parameters"})
    while ahead:
        words |= ahead
        ahead = _words([own[word] for word in ahead & own.keys()]) - words
    return words


def _words(data: Any) -> set[str]:
    """Words in all texts that are values of mappings and lists."""
    words, stack = set[str](), [data]
    while stack:
        match stack.pop():
            case str() as text:
                words.update(WORD.findall(normal(text)))
            case dict() as entries:
                stack.extend(entries.values())
            case list() as entries:
                stack.extend(entries)
    return words


def no_use(name: str, data: Mapping[str, Any]) -> str | None:
    """Message on a value for a parameter that no key of a case's ``data`` uses; None if one does."""
    used = used_names(data)
    if normal(name) in used:
        return None
    given = data.get("parameters")
    known = [str(one) for one in given if normal(str(one)) in used] if isinstance(given, dict) else []
    close = closest(name, known)
    hint = f"did you mean {close!r}?" if close else "name it in an expression, or in braces in a text"
    others = "" if close or not known else f" (those that are used: {', '.join(known[:MOST_NAMES])})"
    return f"no key uses a parameter {name!r}{others}: {hint}"


def _is_usable(name: str) -> bool:
    try:
        check_parameter_name(name)
    except CaseError:
        return False
    return True


def filled_in(text: str, parameters: Parameters) -> str:
    """The text with values in place of parameters in braces, as in ``part-{r}.dxf``.

    A doubled brace stands for a plain one. CaseError if there is no such parameter.
    """

    def value(name: str) -> str:
        """Text in place of a parameter in braces."""
        key = normal(name.strip())
        if key in parameters.without_value:
            raise UnknownNameError(f"the parameter {key!r} has no value", key, follows=True)
        if key not in parameters:
            hint = (
                unknown("parameter", name, parameters) if parameters else f"unknown parameter {name!r}; there is none"
            )
            raise CaseError(f"{hint}; write {{{{ for a brace")
        return f"{parameters[key]:.12g}"

    return "".join(part if inner is None else value(inner) for part, inner in parts_by_braces(text))


def parts_by_braces(text: str) -> Iterator[tuple[str, str | None]]:
    """Parts of a text: plain ones with None, and those in braces with what is within; a doubled brace is a plain one.

    CaseError for a single brace.
    """
    end = 0
    for found in BRACES.finditer(text):
        yield text[end : found.start()], None
        end = found.end()
        if found[0] in ("{{", "}}"):
            yield found[0][0], None
        elif found[1] is None:
            raise CaseError("has a single brace: write {{ or }} for a brace, {name} for a parameter")
        else:
            yield found[0], found[1]
    yield text[end:], None


def literal(text: str) -> str:
    """The text with doubled braces, of which `filled_in` makes the text again."""
    return text.replace("{", "{{").replace("}", "}}")
