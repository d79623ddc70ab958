"""Faults of a case's data, in words that name the file, the line and the key."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from bubblemesh.case.fields import described
from bubblemesh.case.parameters import is_number
from bubblemesh.messages import meant

MAX_PROBLEMS = 10

# Pydantic's kinds of errors in the words of a case file; other ones bring their own text.
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
    "less_than_equal": "must be at most {le:g}",
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

Path = tuple[str | int, ...]


def problems(error: ValidationError, model: type[BaseModel], place: Callable[[Path], str]) -> list[str]:
    """One line for each problem that Pydantic found with the data of a model: its place, its key and what is wrong.

    ``place`` gives that of a key path, such as ``plate.yaml:12``; empty where there is none to tell.
    """
    found = error.errors(include_url=False)
    lines = []
    for one in found[:MAX_PROBLEMS]:
        path = tuple(part for part in one["loc"] if not _is_mark(part))
        parts = (place(path), ".".join(map(str, path)), _message(dict(one), model))
        lines.append(": ".join(part for part in parts if part))
    if len(found) > MAX_PROBLEMS:
        lines.append(f"... and {len(found) - MAX_PROBLEMS} more")
    return lines


def _is_mark(part: str | int) -> bool:
    """Whether a part of a location is a choice's tag or Pydantic's mark of a key, rather than a key of the file."""
    return isinstance(part, str) and (part == "[key]" or (part.startswith("<") and part.endswith(">")))


def _message(problem: dict[str, Any], model: type[BaseModel]) -> str:
    kind, value = problem["type"], problem["input"]
    if kind == "extra_forbidden":
        *parents, key = problem["loc"]
        return f"unknown key; {meant(str(key), _fields(model, parents))}"
    message = MESSAGES[kind].format(**problem.get("ctx", {})) if kind in MESSAGES else problem["msg"]
    if kind in WITHOUT_VALUE:
        return message
    advice = "; remove the quotes" if kind in ("float_type", "int_type") and is_number(value) else ""
    return f"{message} (found {described(value)}{advice})"


def _fields(model: type[BaseModel], loc: list[str | int]) -> list[str]:
    """Keys that the mapping at ``loc`` may have."""
    models = [model]
    for part in loc:
        if _is_mark(part):
            # A tag is the key that tells its model apart, where there are several.
            models = [one for one in models if str(part)[1:-1] in one.model_fields] or models
        elif isinstance(part, str):
            models = _models(models[0].model_fields[part].annotation)
    fields = models[0].model_fields
    own_first = dict.fromkeys(name for base in models[0].__mro__ for name in vars(base).get("__annotations__", ()))
    return [fields[name].alias or name for name in own_first if name in fields]


def _models(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for part in get_args(annotation) for model in _models(part)]


@dataclass(frozen=True)
class Origin:
    """Where a case comes from: files and lines of keys, or options that set them; cases are equal wherever that is."""

    places: Mapping[tuple[str | int, ...], str] = field(default_factory=dict, compare=False)
    seconds: float = field(default=0.0, compare=False)  # that loading the case took
    root: FilePath | None = field(default=None, compare=False)  # folder that an untrusted case may not leave

    def __call__(self, key: Sequence[str | int]) -> str | None:
        """Place of a key, or of the nearest one above it, if any is known."""
        known = (self.places.get(tuple(key[:depth])) for depth in range(len(key), 0, -1))
        return next((place for place in known if place is not None), None)
