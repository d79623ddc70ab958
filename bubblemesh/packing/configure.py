"""A method with what a case sets: other schemes by name, and the parameters of the schemes."""

from collections.abc import Mapping
from dataclasses import fields, replace
from functools import cache
from typing import Any, NamedTuple, get_args, get_type_hints

from pydantic import ConfigDict, TypeAdapter, ValidationError
from typing_extensions import Doc

from bubblemesh.errors import CaseError
from bubblemesh.messages import either, meant
from bubblemesh.packing.method import Method
from bubblemesh.packing.methods import COLUMNS, METHODS, Column

STRICT = ConfigDict(strict=True, allow_inf_nan=False)
CHOICES = {(column.section, column.key): name for name, column in COLUMNS.items() if column.key is not None}


class OptionError(CaseError):
    """A method, or a key of one of its sections, that cannot be used."""

    def __init__(self, section: str, key: str | None, message: str) -> None:
        super().__init__(message if key is None else f"{section}.{key}: {message}")
        self.section = section
        self.key = key
        self.message = message
        self.others: tuple[OptionError, ...] = ()  # faults of further keys

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.section, self.key, self.message), vars(self)


class Option(NamedTuple):
    """A key of a case that some method knows, what it means, and the JSON Schema of its values."""

    section: str
    key: str
    meaning: str
    schema: dict[str, Any]


def configured(method: str, packing: Mapping[str, Any], schedule: Mapping[str, Any]) -> Method:
    """The row ``method`` of the table, with the given schemes and parameters in place of its own.

    OptionError if the method is unknown, does not use a key, or a value is out of range.
    """
    given = {"packing": packing, "schedule": schedule}
    row = _with_schemes(method, given)
    changes: dict[str, dict[str, Any]] = {}
    faults: list[OptionError] = []
    for section, key in _parameters(given):
        names = _columns_of(row, section, key)
        try:
            if not names:
                raise OptionError(section, key, _unused(method, row, section, key))
            value = _checked(type(getattr(row, names[0])), section, key, given[section][key])
        except OptionError as error:
            faults.append(error)
        else:
            for name in names:
                changes.setdefault(name, {})[key] = value
    if faults:
        faults[0].others = tuple(faults[1:])
        raise faults[0]
    return replace(row, **{name: replace(getattr(row, name), **values) for name, values in changes.items()})


def _unused(method: str, row: Method, section: str, key: str) -> str:
    """Why a method does not use a key, and what to do."""
    of_ellipses = [kind for column in COLUMNS.values() for kind in column.ellipses.values()]
    known = any((section, key) == (option.section, option.key) for option in all_options())
    if row.in_metric and known and not any(key in _hints(kind) for kind in of_ellipses):
        return "it has no effect in a metric: leave it out"
    return f"the method {method!r} does not use this key: {_meant(row, section, key)}"


def _meant(row: Method, section: str, key: str) -> str:
    """Advice on a key that a method does not use: methods that have it, or a key that is alike.

    That is the key in the method's other section, else in other methods, else with other schemes.
    """
    elsewhere = [other for other, keys in options(row).items() if key in keys]
    if elsewhere:
        return f"it belongs under {elsewhere[0]}"
    methods = [name for name, other in METHODS.items() if key in options(other)[section]]
    if methods:
        return f"it belongs to the method{'s' * (len(methods) > 1)} {', '.join(methods)}"
    schemes = [
        f"{column.section}.{column.key}: {name}"
        for column in COLUMNS.values()
        if column.section == section and column.key is not None
        for name, kind in column.schemes(row).items()
        if key in _hints(kind)
    ]
    if schemes:
        return f"it belongs to {either(schemes)}"
    sections = [name for name in options(row) if any(key in options(other)[name] for other in METHODS.values())]
    return f"it belongs under {sections[0]}, for other methods" if sections else meant(key, options(row)[section])


def unused_keys(method: str, packing: Mapping[str, Any], schedule: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Sections and keys of the parameters that the method, with the schemes that are given, does not use.

    OptionError if the method or a scheme is unknown.
    """
    given = {"packing": packing, "schedule": schedule}
    row = _with_schemes(method, given)
    return [(section, key) for section, key in _parameters(given) if not _columns_of(row, section, key)]


def options(method: Method) -> dict[str, dict[str, Any]]:
    """All keys of a method with their values, by section."""
    found: dict[str, dict[str, Any]] = {column.section: {} for column in COLUMNS.values()}
    for name, column in _columns(method).items():
        found[column.section] |= vars(getattr(method, name))
    for (section, key), name in CHOICES.items():
        found[section][key] = _scheme_name(method, name)
    return found


def all_options() -> list[Option]:
    """The keys that any method knows: each choice of a scheme, then the parameters of the schemes."""
    found: dict[tuple[str, str], Option] = {}
    for column in COLUMNS.values():
        section, key = column.section, column.key
        if key is not None:
            summaries = ((name, str(kind.__doc__).partition("\n")[0]) for name, kind in column.circles.items())
            meaning = " ".join(f"`{name}`: {summary}" for name, summary in summaries)
            found[section, key] = Option(section, key, meaning, {"enum": list(column.circles)})
        for kind in column.circles.values():
            for key, hint in _hints(kind).items():
                (meaning,) = (note.documentation for note in get_args(hint) if isinstance(note, Doc))
                found[section, key] = Option(section, key, meaning, TypeAdapter(hint).json_schema())
    return list(found.values())


def _with_schemes(method: str, given: Mapping[str, Mapping[str, Any]]) -> Method:
    """The method with the schemes that are given, each with the parameters shared with what it replaces."""
    if method not in METHODS:
        raise OptionError("method", None, f"unknown method {method!r}: {meant(method, METHODS)}")
    row = METHODS[method]
    for (section, key), name in CHOICES.items():
        if key not in given[section]:
            continue
        column, chosen = COLUMNS[name], given[section][key]
        known = column.schemes(row)
        if not isinstance(chosen, str) or chosen not in column.circles:
            problem = f"there is no such scheme: {meant(str(chosen), known)} (found {chosen!r})"
            raise OptionError(section, key, problem)
        if chosen not in known:
            raise OptionError(section, key, f"in a metric only {either(list(known))} is possible: leave it out")
        kind, own = known[chosen], getattr(row, name)
        if kind is not type(own):
            shared = {field.name: value for field in fields(kind) if (value := vars(own).get(field.name)) is not None}
            row = replace(row, **{name: kind(**shared)})
    return row


def _parameters(given: Mapping[str, Mapping[str, Any]]) -> list[tuple[str, str]]:
    """Sections and keys of what is given, but for the choices of schemes."""
    return [(section, key) for section, keys in given.items() for key in keys if (section, key) not in CHOICES]


def _columns_of(row: Method, section: str, key: str) -> list[str]:
    """Names of the columns whose schemes have the parameter."""
    columns = _columns(row).items()
    return [name for name, column in columns if column.section == section and key in vars(getattr(row, name))]


def _columns(method: Method) -> dict[str, Column]:
    """The columns that a method has."""
    return {name: column for name, column in COLUMNS.items() if column.schemes(method)}


def _checked(kind: Any, section: str, key: str, value: Any) -> Any:
    """The value of a scheme's parameter, within its bounds."""
    try:
        return _adapter(kind, key).validate_python(value)
    except ValidationError as error:
        problem = error.errors()[0]["msg"]
        raise OptionError(section, key, f"{problem[0].lower()}{problem[1:]} (found {value!r})") from None


@cache
def _adapter(kind: type[Any], key: str) -> TypeAdapter[Any]:
    """Check of a scheme's parameter, which takes longer to make than to use."""
    return TypeAdapter(_hints(kind)[key], config=STRICT)


def _hints(kind: type[Any]) -> dict[str, Any]:
    """Types of a scheme's parameters, with their bounds and meanings."""
    hints = get_type_hints(kind, include_extras=True)
    return {field.name: hints[field.name] for field in fields(kind)}


def _scheme_name(method: Method, column: str) -> str:
    """Name of the method's scheme in a case."""
    return next(name for name, kind in COLUMNS[column].schemes(method).items() if kind is type(getattr(method, column)))
