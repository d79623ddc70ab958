"""From a case file and the command line's options to a checked `Case`."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from os.path import realpath
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any, TypeVar

from pydantic import ValidationError

from bubblemesh.case.bases import SourceFile, merged, place_of, source_files
from bubblemesh.case.domain import RegionFile, RegionSeed
from bubblemesh.case.faults import Origin, problems
from bubblemesh.case.key_homes import home_of_no_option
from bubblemesh.case.models import UNTRUSTED, Case
from bubblemesh.case.overrides import Override, applied, overrides_of
from bubblemesh.case.parameters import literal, no_use, resolved
from bubblemesh.case.sweep import ALONE, SweepError, Variant, key_parts, variants_of
from bubblemesh.case.yaml import read_case_text, value_ahead
from bubblemesh.errors import CaseError, FileError
from bubblemesh.files import confined_to, with_home
from bubblemesh.process.limits import within
from bubblemesh.process.watchdog import allow
from bubblemesh.records import record

if TYPE_CHECKING:
    from bubblemesh.packing.configure import OptionError

T = TypeVar("T")

FOREVER = 1e9  # seconds
DEEPEST = 4  # parts of keys whose lines are kept for errors of the geometry and the spacing
ABOUT_LIMITS = (("limits", "max_nodes"),)  # likewise, of limits: the time is that of the whole case


def load_case(
    path: Path | str,
    *,
    overrides: Sequence[str | Override] = (),
    text: str | None = None,
    variant: Variant | None = None,
    untrusted: bool = False,
    **options: Any,
) -> Case:
    """Read and check a case.

    Parameters
    ----------
    path : path
        The case file; also the name in messages if ``text`` is given, where ``-`` is the standard input.
    overrides : sequence of str or Override
        Settings such as ``domain.holes.0.circle.radius=0.3``; later ones replace earlier ones.
    text : str, optional
        The case as YAML, in place of the file's content.
    variant : Variant, optional
        Which of the cases of a sweep; without it, a file with a sweep is an error. For a variant from `case_variants`
        the files are not read again: the case is that of the files as they were then.
    untrusted : bool
        Whether the case comes from a stranger: its files have to be below its folder, wherever links lead, and its
        limits are at most those of `UNTRUSTED`, unless ``overrides`` or ``options`` set them.
    **options
        ``method``, ``seed`` and ``time_limit`` set ``method``, ``packing.seed`` and ``limits.seconds``, and replace
        values in ``overrides``.

    Raises
    ------
    FileError
        If the file cannot be read.
    CaseError
        If the text is not valid YAML or not a valid case; each line of the message names a place and a key.
    """
    path, changes = _named(path, text), overrides_of(overrides, **options)
    root = _root_of(path, untrusted)
    return _in_time(path, changes, root, lambda begun: _loaded(path, text, changes, variant, root, begun))


def _loaded(
    path: Path,
    text: str | None,
    changes: Sequence[Override],
    variant: Variant | None,
    root: Path | None,
    begun: float,
) -> Case:
    """The case, with the arguments of `load_case`; ``begun`` is the reading of the clock when that was called."""
    data, places = _read(path, text, changes, root, variant.files if variant else ())
    allow(_seconds(data.get("limits")))
    sweep = data.pop("sweep", None)
    if variant is None and sweep is not None:
        raise SweepError(
            places.message(["sweep"], "makes several cases of this file: mesh them with bubblemesh batch, or remove it")
        )
    for key, value in (variant or ALONE).values:
        change = Override(key_parts(key), value, places(["sweep", key]), f"sweep.{key}")
        data = applied(data, change)
        places = replace(places, changes=[*places.changes, change])
    if data.get("name") is None:
        data["name"] = "mesh" if str(path) == "-" else literal(path.stem)
    if variant is not None and isinstance(data["name"], str):
        data["name"] += variant.label
    options = [change for change in changes if change.key is None]
    useless = [(change, problem) for change in options if (problem := _no_use(change.path, data))]
    return _checked(data, places, root, begun, [f"{change.source}: {problem}" for change, problem in useless])


def _no_use(path: Sequence[str | int], data: dict[str, Any]) -> str | None:
    """Message about a value for a key of a case that nothing depends on; None if something may."""
    return no_use(str(path[1]), data) if path[0] == "parameters" and len(path) > 1 else None


def case_variants(
    path: Path | str,
    *,
    overrides: Sequence[str | Override] = (),
    text: str | None = None,
    untrusted: bool = False,
    **options: Any,
) -> list[Variant]:
    """The variants in a file, or in a ``text`` in its place: one, or those of its sweep.

    The same errors as `load_case`, but the cases are not checked yet; CaseError if an option sets a swept key.
    """
    path, changes = _named(path, text), overrides_of(overrides, **options)
    root = _root_of(path, untrusted)
    data, places = _in_time(path, changes, root, lambda begun: _read(path, text, changes, root))
    variants = variants_of(data.get("sweep"), places)
    every = _with_all_values(data)
    for key, _ in variants[0].values:
        if problem := _no_use(key_parts(key), every):
            raise CaseError(f"{places(['sweep', key])}: sweep.{key}: {problem}")
    for key, _ in variants[0].values:
        for change in places.changes:
            if change.covers(key_parts(key)) or change.leads_through(key_parts(key)):
                raise CaseError(f"{change.source}: {places(['sweep', key])} sweeps {key}: drop the one or the other")
    return [replace(variant, files=tuple(places.files)) for variant in variants]


def _with_all_values(data: dict[str, Any]) -> dict[str, Any]:
    """The data of a case with the list of its values at each swept key, in place of what stands there."""
    sweep = data.get("sweep") or {}
    data = data | {"sweep": None}
    for key, values in sweep.items():
        with suppress(CaseError):  # there is no such place: each of the cases tells it
            data = applied(data, Override(key_parts(key), values, f"sweep.{key}"))
    return data


def _named(path: Path | str, text: str | None) -> Path:
    """Path of a case file.

    FileError if the name is empty, which would mean the working directory; CaseError if the text is not a string.
    """
    if text is not None and not isinstance(text, str):
        raise CaseError(f"text: must be a text (found {type(text).__name__}): decode bytes by their decode()")
    if path == "" and text is None:
        raise FileError("the case file cannot be read: its name is empty")
    return Path(with_home(path))


def _root_of(path: Path, untrusted: bool) -> Path | None:
    """Folder that contains all files of an untrusted case; None for a trusted one."""
    return Path(realpath(path.parent)) if untrusted else None


def _in_time(path: Path, changes: Sequence[Override], root: Path | None, call: Callable[[float], T]) -> T:
    """Value of a call, with the time when it began as argument, within limits that overrides may set."""
    begun = perf_counter()
    seconds, memory = _allowed("seconds", changes, None), _allowed("max_memory_mb", changes, root)
    return within(lambda: call(begun), seconds, memory, begun, f"{_source(path)}: ")


def _allowed(key: str, changes: Sequence[Override], root: Path | None) -> float | None:
    """Limit that holds while a case is read, when its own limits are not known yet."""
    given = [change.value for change in changes if change.path == ("limits", key)]
    if given:
        return _usable(given[-1])
    return None if root is None else UNTRUSTED[key]


def _seconds_ahead(text: str, changes: Sequence[Override], root: Path | None) -> float | None:
    """Time limit of a case by a first look at its text, if no override sets it: the key may be anywhere in there."""
    if any(change.covers(("limits", "seconds")) for change in changes):
        return None
    given = (_seconds(value_ahead(text, "limits")), None if root is None else UNTRUSTED["seconds"])
    return min((limit for limit in given if limit is not None), default=None)


def _usable(seconds: Any) -> float | None:
    """A time limit if it is a valid one, else None: invalid ones are reported later, with their place."""
    return seconds if type(seconds) in (int, float) and 0 < seconds < FOREVER else None


def _seconds(limits: Any) -> float | None:
    """Time limit among the limits in a file, if there is one."""
    return _usable(limits.get("seconds")) if isinstance(limits, dict) else None


def _source(path: Path) -> str:
    return "<stdin>" if str(path) == "-" else str(path)


def _read(
    path: Path, text: str | None, changes: Sequence[Override], root: Path | None, files: Sequence[SourceFile] = ()
) -> "tuple[dict[str, Any], _Places]":
    """The data of a case's files with the overrides, and the places of the values.

    ``files`` that are known already are not read again, unless they have to be below a root.
    """
    source = _source(path)
    for change in changes:
        if change.path[0] == "base":
            raise CaseError(f"{change.source}: the base is what the case file names: write it there")
    if root is not None or not files:
        with confined_to(root):
            text = read_case_text(path) if text is None else text
            allow(_seconds_ahead(text, changes, root))
            files = source_files(path, source, text)
    data: Any = merged(files)
    for change in changes:
        data = applied(data, change)
    return data, _Places(files, changes)


@record
class _Places:
    """Places from which the values of a case come."""

    files: Sequence[SourceFile]
    changes: Sequence[Override]

    def __call__(self, path: Sequence[str | int]) -> str:
        """Option that has set or made the value at the key path, else the file and line of its nearest known key."""
        # Options for other keys, which cases of a sweep may have in great number, are not looked through.
        changes = [change for change in reversed(self.changes) if not path or str(change.path[0]) == str(path[0])]
        for change in changes:
            if change.covers(path):
                return change.source
        in_file = changes and any(file.document.depth(path) == len(path) for file in self.files)
        for change in () if in_file else changes:
            if change.leads_through(path):
                return f"{change.source}: {change.key}" if change.key else change.source
        return place_of(self.files, path)

    def is_option(self, path: Sequence[str | int]) -> bool:
        """Whether an option, not a file, has set the value at the key path."""
        return any(change.covers(path) for change in self.changes if change.key is None)

    def message(self, path: Sequence[str | int], problem: object) -> str:
        """A problem with its place and key."""
        return f"{self(path)}: {'.'.join(map(str, path))}: {problem}"


def _checked(data: dict[str, Any], places: _Places, root: Path | None, begun: float, noted: Sequence[str] = ()) -> Case:
    """The case of ``data``, with everything checked that needs no geometry.

    ``begun`` is the reading of the clock when loading began. The warnings in ``noted`` are among those of the case.
    """
    parameters = data.get("parameters")
    found = resolved(parameters if isinstance(parameters, dict) else {}, units=data.get("crs") is not None)
    if isinstance(parameters, dict):
        data = data | {"parameters": found.given}
    faults = [places.message(["parameters", name], problem) for name, problem in found.problems.items()]
    try:
        case = Case.model_validate(data, context=found.known)
    except ValidationError as error:
        raise CaseError("\n".join([*faults, *problems(error, Case, places)])) from None
    if faults:
        raise CaseError("\n".join(faults))
    _check_names(case, places)
    if root is not None:
        case = _limited(case, places)
    case, warnings = _with_method(case, places)
    late = [path for key in ("spacing", "metric", "layers", "domain", "output") for path in _paths(data.get(key), key)]
    late += [path for path in _paths(data.get("limits"), "limits") if path in ABOUT_LIMITS]
    places_of = {path: places(path) for path in late if len(path) <= DEEPEST}
    return case.loaded(Origin(places_of, perf_counter() - begun, root), (*noted, *warnings))


def _paths(value: Any, *path: str | int) -> Iterator[tuple[str | int, ...]]:
    """Paths of a key and of all keys below it."""
    yield path
    for key, entry in value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ():
        if isinstance(value, dict) or isinstance(entry, dict):
            yield from _paths(entry, *path, key)


def _check_names(case: Case, places: _Places) -> None:
    """Check that each region has a name of its own."""
    seen = {case.domain.region: "domain.region"}
    for number, region in enumerate(case.domain.regions):
        if isinstance(region, RegionFile):  # the names of its regions are known when it is read
            continue
        path = ("domain", "regions", number, "name")
        if region.name in seen:
            problem = f"{region.name!r} is the name at {seen[region.name]} too: give every region a name of its own"
            if not isinstance(region, RegionSeed) and region.name != case.domain.region:
                problem += ", or make several rings one region by ring: {union: [...]} or repeat"
            raise CaseError(places.message(path, problem))
        seen[region.name] = ".".join(map(str, path))


def _limited(case: Case, places: _Places) -> Case:
    """The case with the limits of untrusted cases where it has none; CaseError if it asks for more itself."""
    limits: dict[str, float] = {}
    for key, most in UNTRUSTED.items():
        path, given = ("limits", key), getattr(case.limits, key)
        if places.is_option(path):
            continue
        if key not in case.limits.model_fields_set or given is None:
            limits[key] = most
        elif given > most:
            advice = f"lower it, or allow it by --set limits.{key}={given:g}, in Python by overrides"
            raise CaseError(places.message(path, f"an untrusted case may ask for {most:g} (found {given:g}): {advice}"))
    return case.model_copy(update={"limits": case.limits.model_copy(update=limits)})


def _on_option(error: "OptionError", places: _Places) -> str:
    """Line on a fault of a method's option; for a key of another part of the case it says where that belongs."""
    path = [error.section] if error.key is None else [error.section, error.key]
    belongs = None if error.key is None else home_of_no_option(error.key, path[:1], Case)
    return places.message(path, f"unknown key; {belongs}" if belongs else error.message)


def _with_method(case: Case, places: _Places) -> tuple[Case, tuple[str, ...]]:
    """The case, whose options its method can use, and warnings on options that are left out.

    If an option of the command line sets the method, options in files that this method does not use, but others do, are
    left out.
    """
    if case.method == Case.model_fields["method"].default and not case.packing and not case.schedule:
        return case, ()
    # Imported here since the methods take time to load, and errors in a case should come at once.
    from bubblemesh.packing.configure import OptionError, all_options, configured, unused_keys

    warnings = []
    try:
        if places.is_option(["method"]):
            given = {"packing": dict(case.packing), "schedule": dict(case.schedule)}
            unused = unused_keys(case.method, **given)
            known = {(option.section, option.key) for option in all_options()} if unused else set()
            for section, key in unused:
                if (section, key) in known and not places.is_option([section, key]):
                    del given[section][key]
                    warnings.append(
                        f"{section}.{key}: the method {case.method!r} does not use this key: it is left out"
                    )
            case = case.model_copy(update=given) if warnings else case
        configured(case.method, case.packing, case.schedule)
    except OptionError as error:
        raise CaseError("\n".join(_on_option(one, places) for one in (error, *error.others))) from None
    return case, tuple(warnings)
