"""A method with what a case sets: other schemes by name, and the parameters of the schemes."""

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any, get_type_hints

from pydantic import ConfigDict, TypeAdapter, ValidationError

from bubblemesh.errors import CaseError
from bubblemesh.messages import meant
from bubblemesh.packing.methods import METHODS, SCHEMES, Method

STRICT = ConfigDict(strict=True, allow_inf_nan=False)
SECTIONS = {
    "packing": (
        *(
            "levels",
            "placement",
            "perturbation",
            "relaxation",
            "force",
            "motion",
            "population",
            "shaking",
            "polish",
            "mending",
        ),
    ),
    "schedule": ("viscosity", "odd", "termination"),
}


class OptionError(CaseError):
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
        raise OptionError("method", None, f"unknown method {method!r}: {meant(method, METHODS)}")
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


def option_schemas() -> dict[str, dict[str, Any]]:
    """JSON Schemas of the keys that any method knows, by section."""
    schemas: dict[str, dict[str, Any]] = {section: {} for section in SECTIONS}
    for section, columns in SECTIONS.items():
        for column in columns:
            kinds = {type(getattr(row, column)) for row in METHODS.values()} - {type(None)}
            for kind in sorted(kinds, key=lambda kind: kind.__name__):
                for name, hint in _hints(kind).items():
                    schemas[section][name] = TypeAdapter(hint).json_schema()
            if column in SCHEMES:
                schemas[section][column] = {"enum": list(SCHEMES[column])}
    return schemas


def _with_scheme(row: Method, section: str, column: str, name: Any) -> Method:
    """The row with the scheme ``name``, which keeps the parameters that both schemes have."""
    known = SCHEMES[column]
    if not isinstance(name, str) or name not in known:
        raise OptionError(section, column, f"there is no such scheme: {meant(str(name), known)} (found {name!r})")
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
    raise OptionError(section, key, f"the method {method!r} does not use this key: {meant(key, known)}")


def _replaced(scheme: Any, section: str, key: str, value: Any) -> Any:
    try:
        checked = TypeAdapter(_hints(type(scheme))[key], config=STRICT).validate_python(value)
    except ValidationError as error:
        problem = error.errors()[0]["msg"]
        raise OptionError(section, key, f"{problem[0].lower()}{problem[1:]} (found {value!r})") from None
    return replace(scheme, **{key: checked})


def _hints(kind: type[Any]) -> dict[str, Any]:
    """Types of a scheme's parameters, with their bounds."""
    hints = get_type_hints(kind, include_extras=True)
    return {field.name: hints[field.name] for field in fields(kind)}


def _name(method: Method, column: str) -> str:
    """What a case calls the method's scheme for a task."""
    scheme = getattr(method, column)
    return next(name for name, kind in SCHEMES[column].items() if kind is (scheme and type(scheme)))


def _values(scheme: Any) -> dict[str, Any]:
    """The parameters of a scheme; none of one that is left out."""
    return {} if scheme is None else {field.name: getattr(scheme, field.name) for field in fields(scheme)}
