"""A method with what a case sets: other schemes by name, and the parameters of the schemes."""

from collections.abc import Mapping
from dataclasses import fields, replace
from difflib import get_close_matches
from typing import Any, get_type_hints

from pydantic import ConfigDict, TypeAdapter, ValidationError

from bubblemesh.packing.methods import METHODS, SCHEMES, Method

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
    """The row ``method`` of the table, with the given schemes and parameters in place of its own.

    Raises
    ------
    OptionError
        If the method is unknown, does not use a key, or a value is out of range.
    """
    if method not in METHODS:
        raise OptionError("method", None, f"unknown method {method!r}{_suggested(method, list(METHODS))}")
    row = METHODS[method]
    for section, given in (("packing", packing), ("schedule", schedule)):
        named = [key for key in given if key in SCHEMES and key in SECTIONS[section]]
        for key in named:
            row = _with_scheme(row, section, key, given[key])
        for key, value in given.items():
            if key not in named:
                row = _with_parameter(row, method, section, key, value)
    return row


def options(method: Method) -> dict[str, dict[str, Any]]:
    """All keys of a method with their values, by section."""
    return {
        section: {
            **{name: value for column in columns for name, value in _values(getattr(method, column)).items()},
            **{column: _name(method, column) for column in columns if column in SCHEMES},
        }
        for section, columns in SECTIONS.items()
    }


def _with_scheme(row: Method, section: str, column: str, name: Any) -> Method:
    """The row with the scheme ``name``, which keeps the parameters that both schemes have."""
    known = SCHEMES[column]
    if not isinstance(name, str) or name not in known:
        hint = _suggested(str(name), list(known))
        raise OptionError(section, column, f"there is no such scheme{hint} (found {name!r})")
    if name == _name(row, column):
        return row
    kind, present = known[name], _values(getattr(row, column))
    shared = (
        {} if kind is None else {field.name: present[field.name] for field in fields(kind) if field.name in present}
    )
    scheme: Any = kind and kind(**shared)
    return replace(row, **{column: scheme})


def _with_parameter(row: Method, method: str, section: str, key: str, value: Any) -> Method:
    for column in SECTIONS[section]:
        scheme = getattr(row, column)
        if key in _values(scheme):
            return replace(row, **{column: _replaced(scheme, section, key, value)})
    known = list(options(row)[section])
    raise OptionError(section, key, f"the method {method!r} does not use this key{_suggested(key, known)}")


def _replaced(scheme: Any, section: str, key: str, value: Any) -> Any:
    hint = get_type_hints(type(scheme), include_extras=True)[key]
    try:
        checked = TypeAdapter(hint, config=STRICT).validate_python(value)
    except ValidationError as error:
        problem = error.errors()[0]["msg"]
        raise OptionError(section, key, f"{problem[0].lower()}{problem[1:]} (found {value!r})") from None
    return replace(scheme, **{key: checked})


def _name(method: Method, column: str) -> str:
    """What a case calls the method's scheme for a task."""
    scheme = getattr(method, column)
    return next(name for name, kind in SCHEMES[column].items() if kind is (scheme and type(scheme)))


def _values(scheme: Any) -> dict[str, Any]:
    """The parameters of a scheme; none of one that is left out."""
    return {} if scheme is None else {field.name: getattr(scheme, field.name) for field in fields(scheme)}


def _suggested(word: str, known: list[str]) -> str:
    close = get_close_matches(word, known, n=1)
    return f": did you mean {close[0]!r}?" if close else f": it is one of {', '.join(known)}"
