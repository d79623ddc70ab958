"""A method with the parameters that a case sets: each key belongs to one field of one scheme."""

from collections.abc import Mapping
from dataclasses import fields, replace
from difflib import get_close_matches
from typing import Any, get_type_hints

from pydantic import ConfigDict, TypeAdapter, ValidationError

from bubblemesh.packing.methods import METHODS, Method

__all__ = ["OptionError", "configured", "options"]

STRICT = ConfigDict(strict=True, allow_inf_nan=False)
SECTIONS = {
    "packing": ("placement", "perturbation", "force", "motion", "population"),
    "schedule": ("viscosity", "odd", "termination"),
}


class OptionError(ValueError):
    """A method, or a key of one of its sections, that cannot be used."""

    def __init__(self, section: str, key: str | None, message: str) -> None:
        super().__init__(message)
        self.section = section
        self.key = key
        self.message = message


def configured(method: str, packing: Mapping[str, Any], schedule: Mapping[str, Any]) -> Method:
    """The row ``method`` of the table, with the given keys in place of its own.

    Raises
    ------
    OptionError
        If the method is unknown, does not use a key, or a value is out of range.
    """
    if method not in METHODS:
        raise OptionError("method", None, f"unknown method {method!r}{_suggested(method, list(METHODS))}")
    row = METHODS[method]
    for section, given in (("packing", packing), ("schedule", schedule)):
        for key, value in given.items():
            row = _with_option(row, method, section, key, value)
    return row


def options(method: Method) -> dict[str, dict[str, Any]]:
    """All keys of a method with their values, by section."""
    return {
        section: {name: value for scheme in _schemes(method, section) for name, value in _values(scheme).items()}
        for section in SECTIONS
    }


def _with_option(row: Method, method: str, section: str, key: str, value: Any) -> Method:
    for column in SECTIONS[section]:
        scheme = getattr(row, column)
        if scheme is not None and key in _values(scheme):
            return replace(row, **{column: _replaced(scheme, section, key, value)})
    known = [name for scheme in _schemes(row, section) for name in _values(scheme)]
    raise OptionError(section, key, f"the method {method!r} does not use this key{_suggested(key, known)}")


def _replaced(scheme: Any, section: str, key: str, value: Any) -> Any:
    hint = get_type_hints(type(scheme), include_extras=True)[key]
    try:
        checked = TypeAdapter(hint, config=STRICT).validate_python(value)
    except ValidationError as error:
        problem = error.errors()[0]["msg"]
        raise OptionError(section, key, f"{problem[0].lower()}{problem[1:]} (found {value!r})") from None
    return replace(scheme, **{key: checked})


def _schemes(method: Method, section: str) -> list[Any]:
    return [scheme for column in SECTIONS[section] if (scheme := getattr(method, column)) is not None]


def _values(scheme: Any) -> dict[str, Any]:
    return {field.name: getattr(scheme, field.name) for field in fields(scheme)}


def _suggested(word: str, known: list[str]) -> str:
    close = get_close_matches(word, known, n=1)
    return f": did you mean {close[0]!r}?" if close else f": it is one of {', '.join(known)}"
