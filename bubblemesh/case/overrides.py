"""Values that replace those of a case: ``--set domain.holes.0.circle.radius=0.3``, and options such as ``--seed 3``."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from bubblemesh.case.yaml import read_value
from bubblemesh.errors import CaseError
from bubblemesh.records import record

# Options that set a key of the case, by their names in Python; the command line's row of each is in cli/options.py.
OPTIONS: dict[str, tuple[str, ...]] = {
    "method": ("method",),
    "seed": ("packing", "seed"),
    "repair": ("domain", "repair"),
    "angle_min": ("angle_min",),
    "parts": ("parts",),
    "time_limit": ("limits", "seconds"),
    "partition": ("output", "partition"),
}
# Keys whose plain value is an abbreviation of a mapping with one key.
SHORT_FORMS: dict[tuple[str | int, ...], str] = {("spacing",): "value"}


@record
class Override:
    """A value for one place of the data, and the source that messages name.

    ``key`` is the key as it was written, if the source alone does not show it.
    """

    path: tuple[str | int, ...]
    value: Any
    source: str
    key: str | None = None

    def covers(self, path: Sequence[str | int]) -> bool:
        """Whether this override has set the value at ``path``."""
        return [*map(str, path[: len(self.path)])] == [*map(str, self.path)]

    def leads_through(self, path: Sequence[str | int]) -> bool:
        """Whether this override sets a value within that at ``path``, which it makes if it is missing."""
        return [*map(str, self.path[: len(path)])] == [*map(str, path)]


def overrides_of(
    settings: Iterable[str | Override] = (), /, *, of_command: bool = False, **options: Any
) -> list[Override]:
    """Overrides of settings such as ``a.b=value``, followed by those of options; an option that is None is left out.

    Messages name those ``of_command`` as the command line does, and else as arguments of `load_case`.

    Raises
    ------
    CaseError
        If the settings are not a list of texts, but for instance a single text, or one cannot be `parsed_override`.
    TypeError
        If an option is unknown.
    """
    if isinstance(settings, str):  # else its letters would be taken for settings
        raise CaseError(f"overrides: must be a list of texts, as in [{settings!r}] (found the text {settings!r})")
    if isinstance(settings, Mapping) or not isinstance(settings, Iterable):
        found = type(settings).__name__
        raise CaseError(f"overrides: must be a list of texts, as in ['spacing=0.1'] (found {found})")
    settings = list(settings)
    for one in settings:
        if not isinstance(one, str | Override):
            raise CaseError(f"overrides: must be texts, as 'spacing=0.1' (found {one!r})")
    unknown = options.keys() - OPTIONS.keys()
    if unknown:
        raise TypeError(f"no option of a case: {', '.join(sorted(unknown))} (there are: {', '.join(OPTIONS)})")
    source = flag if of_command else _argument
    named = [Override(OPTIONS[name], value, source(name)) for name, value in options.items() if value is not None]
    return [*(parsed_override(one, of_command) if isinstance(one, str) else one for one in settings), *named]


def flag(option: str) -> str:
    """Name of an option on the command line."""
    return f"--{option.replace('_', '-')}"


def _argument(option: str) -> str:
    """Name of an option among the arguments of `load_case`: only of the call if the key, which follows, is the same."""
    return "load_case()" if OPTIONS[option] == (option,) else option


def parsed_override(setting: str, of_command: bool = False) -> Override:
    """Override of a text ``a.b=value`` with a value in YAML; numbers are indices of lists; else CaseError.

    Messages name the option ``--set`` of a command, or the argument ``overrides``.
    """
    keys, equals, text = setting.partition("=")
    before, example = ("--set ", "--set key.key=value") if of_command else ("overrides: ", "'key.key=value'")
    if not equals:
        raise CaseError(f"{before}{setting}: no '=' found: write {example}")
    path = tuple(key.strip() for key in keys.split("."))
    if not all(path):
        raise CaseError(f"{before}{setting}: an empty key found: write {example}")
    place = f"{before}{'.'.join(path)}"
    return Override(path, read_value(text, place), place if of_command else "overrides")


def applied(data: Any, override: Override, depth: int = 0) -> Any:
    """A copy of ``data`` with the override's value; missing mappings on the way are made.

    A plain spacing that gets a key becomes the ``value`` of a mapping. ``depth`` parts of the path have led to
    ``data``. CaseError if the path leads into another plain value, or to an entry of a list that does not exist.
    """
    if depth == len(override.path):
        return override.value
    if isinstance(data, list):
        index = _index(data, override, depth)
        return [*data[:index], applied(data[index], override, depth + 1), *data[index + 1 :]]
    if data is None:
        data = {}
    elif not isinstance(data, dict) and override.path[:depth] in SHORT_FORMS:
        data = {SHORT_FORMS[override.path[:depth]]: data}
    if not isinstance(data, dict):
        reached = ".".join(map(str, override.path[:depth]))
        raise CaseError(f"{override.source}: {reached} is the plain value {data!r}, without keys: set it as a whole")
    key = str(override.path[depth])
    return data | {key: applied(data.get(key), override, depth + 1)}


def _index(entries: list[Any], override: Override, depth: int) -> int:
    part = str(override.path[depth])
    reached = ".".join(map(str, override.path[:depth]))
    if not (part.isascii() and part.isdigit()):
        raise CaseError(f"{override.source}: {reached} is a list: give the number of an entry in place of {part!r}")
    if len(part) > 9 or int(part) >= len(entries):
        allowed = f"0 to {len(entries) - 1}" if entries else "none, the list is empty"
        raise CaseError(f"{override.source}: {reached} has no entry {part} (entries: {allowed})")
    return int(part)
