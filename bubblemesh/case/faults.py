"""Messages on faults in a case's data, with the file, the line and the key."""

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import field
from functools import cached_property
from math import isfinite
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from bubblemesh.case.fields import FOLLOWS, described
from bubblemesh.case.key_homes import Advice, advice_on, homes_below, is_mark, key_of, model_at, strange_keys
from bubblemesh.case.parameters import is_number
from bubblemesh.errors import CaseError
from bubblemesh.messages import counted, either
from bubblemesh.records import record

Model = TypeVar("Model", bound=BaseModel)

MAX_PROBLEMS = 10
MAX_STRANGE = 100  # unknown keys for which to find out which other errors they explain
MAX_ALIKE = 3  # entries of one list with the same problem that are all reported

# Messages for Pydantic's kinds of errors in the words of a case file; other errors have a text of their own.
MESSAGES = {
    "missing": "is missing",
    "float_type": "must be a number",
    "int_type": "must be a whole number",
    "int_from_float": "must be a whole number",
    "string_type": "must be text",
    "string_too_short": "must not be empty",
    "too_short": "must not be empty",
    "string_too_long": "must have at most {max_length} characters",
    "too_long": "must have at most {max_length} characters",
    "tuple_type": "must be a list",
    "dict_type": "must be a mapping of keys to values",
    "model_type": "must be a mapping of keys to values",
    "finite_number": "must be a finite number",
    "greater_than": "must be greater than {gt:g}",
    "greater_than_equal": "must be at least {ge:g}",
    "less_than_equal": "must be at most {le:.10g}",
    "literal_error": "must be {expected}",
}

# Errors that are not about a value.
WITHOUT_VALUE = {
    "missing",
    "excluding",
    "expression",
    "extra_forbidden",
    "labels",
    "parameter",
    "scale",
    "start",
    "traced",
}

Location = tuple[str | int, ...]


def problems(error: ValidationError, model: type[BaseModel], place: Callable[[Location], str]) -> list[str]:
    """Lines on Pydantic's errors with the data of a model, one for each error: the place, the key and the fault.

    Errors that follow from others are left out, and similar ones are reported once. The list is empty if all errors
    follow from problems with parameters, which are reported elsewhere.

    Parameters
    ----------
    error
        The errors.
    model
        The model.
    place
        Returns the place of a key path, such as ``plate.yaml:12``, or an empty text if there is none.
    """
    errors = [dict(one) for one in error.errors(include_url=False)]
    found = [_Problem.of(one, model) for one in errors if not _follows(one)]
    strange = (
        [one for one in found if one.kind == "extra_forbidden"] if "missing" in {one.kind for one in found} else []
    )
    meant = {(*one.path[:-1], key) for one in strange[:MAX_STRANGE] for key in one.advice.explains}
    groups: dict[Hashable, list[_Problem]] = {}
    for one in found:
        if not (one.kind == "missing" and one.path in meant):
            groups.setdefault(one.group, []).append(one)
    described = [line for group in groups.values() for line in _described(group)]
    lines = [
        ": ".join(filter(None, (place(one.path), ".".join(map(str, one.path)), f"{one.message}{more}")))
        for one, more in described[:MAX_PROBLEMS]
    ]
    return [*lines, *([f"... and {len(described) - MAX_PROBLEMS} more"] if len(described) > MAX_PROBLEMS else [])]


def checked(model: type[Model], values: Mapping[str, Any]) -> Model:
    """Model of values that a program gives; CaseError, each line of which names a key, if they are invalid."""
    try:
        return model.model_validate(values)
    except ValidationError as error:
        raise CaseError("\n".join(problems(error, model, lambda path: ""))) from None


def _follows(error: Mapping[str, Any]) -> bool:
    """Whether an error of Pydantic follows from another one."""
    if error["type"] == "too_short":  # entries that have errors are missing in Pydantic's count
        return len(error["input"]) >= int(error["ctx"]["min_length"])
    return bool(error["type"] == FOLLOWS)


@record
class _Problem:
    """An error of Pydantic; its message is made only if it is reported, as there may be very many."""

    path: Location
    error: dict[str, Any]
    model: type[BaseModel]

    @classmethod
    def of(cls, error: dict[str, Any], model: type[BaseModel]) -> "_Problem":
        """Problem of an error of Pydantic."""
        return cls(tuple(part for part in error["loc"] if not is_mark(part)), error, model)

    @property
    def kind(self) -> str:
        """Pydantic's kind of the error."""
        return str(self.error["type"])

    @property
    def unknown(self) -> str | None:
        """Unknown name in an expression, if that is the error."""
        name = self.error.get("ctx", {}).get("unknown")
        return None if name is None else str(name)

    @cached_property
    def advice(self) -> Advice:
        """Advice on an unknown key."""
        *parents, key = self.error["loc"]
        return advice_on(str(key), parents, self.model)

    @property
    def message(self) -> str:
        """Message on the fault."""
        return (
            f"unknown key; {self.advice.text}" if self.kind == "extra_forbidden" else _message(self.error, self.model)
        )

    @property
    def group(self) -> Hashable:
        """Key that is equal for problems reported together: an unknown name, or a list and the fault in it."""
        if self.unknown is not None:
            return self.unknown
        ends = next((k for k in range(len(self.path), 0, -1) if isinstance(self.path[k - 1], str)), 0)
        return self.path[:ends], self.kind


def _described(group: Sequence[_Problem]) -> list[tuple[_Problem, str]]:
    """Problems of a group to report, each with a note on those left out: the first one of a name, some of a list."""
    first, *others = group
    if others and first.unknown is not None:
        keys = list(dict.fromkeys(".".join(map(str, one.path)) for one in others))
        return [(first, f" (also in {either(keys) if len(keys) <= MAX_ALIKE else counted(len(keys), 'more key')})")]
    if len(group) > MAX_ALIKE:
        return [(first, f" (and {len(others):,} more like it)")]
    return [(one, "") for one in group]


def _message(problem: dict[str, Any], model: type[BaseModel]) -> str:
    """Message on the fault, with the value that was found."""
    kind, value, loc = problem["type"], problem["input"], problem["loc"]
    message = MESSAGES[kind].format(**problem.get("ctx", {})) if kind in MESSAGES else problem["msg"]
    if kind in WITHOUT_VALUE:
        return message
    advice = ""
    if kind in ("float_type", "int_type") and is_number(value) and isfinite(float(value)):
        advice = "; remove the quotes"
    elif kind == "tuple_type":
        advice = "; write [a, b], or a line with a dash for each entry"
    elif kind == "model_type" and (form := _form(loc, model)):
        advice = f"; write {form}"
    elif kind == "choice" and isinstance(value, dict) and value:
        advice = _inner_advice(value, loc, model)
    return f"{message} (found {described(value)}{advice})"


def _form(loc: Sequence[str | int], model: type[BaseModel]) -> str:
    """Text on the form of the mapping at a location, with its required keys; empty if it has none."""
    own = model_at(model, loc)
    fields = own.model_fields.items() if own else ()
    needed = [key_of(name, own) for name, field in fields if own and field.is_required()]
    return "{" + ", ".join(f"{key}: ..." for key in needed) + "}" if needed else ""


def _inner_advice(value: Mapping[str, Any], loc: Sequence[str | int], model: type[BaseModel]) -> str:
    """Advice on keys that belong into one of the mappings in a choice."""
    strangers = strange_keys(value, loc, model)
    inner = homes_below(strangers, loc, model)
    return f"; {', '.join(strangers)} belong{'s' if len(strangers) == 1 else ''} under {either(inner)}" if inner else ""


@record
class Origin:
    """Where a case comes from: files and lines of keys, or options that set them. It does not count in comparisons."""

    places: Mapping[tuple[str | int, ...], str] = field(default_factory=dict, compare=False)
    seconds: float = field(default=0.0, compare=False)  # time that loading the case took
    root: Path | None = field(default=None, compare=False)  # folder that contains all files of an untrusted case

    def __call__(self, key: Sequence[str | int]) -> str | None:
        """Place of a key, or of the nearest one above it, if any is known."""
        known = (self.places.get(tuple(key[:depth])) for depth in range(len(key), 0, -1))
        return next((place for place in known if place is not None), None)
