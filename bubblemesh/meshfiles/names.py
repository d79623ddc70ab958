"""Names of groups for which a mesh file has only numbers or other words, from the file of labels beside it."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import replace
from os.path import isfile
from pathlib import Path
from typing import Any

from bubblemesh.errors import FileError
from bubblemesh.files import read_bytes
from bubblemesh.meshfiles.formats import FORMATS
from bubblemesh.meshfiles.groups import LABELS_FILE
from bubblemesh.meshfiles.sources.source import Source


def named(source: Source, path: Path) -> Source:
    """The source with names from NAME.labels.json beside the file; unchanged, with a note, if that is damaged.

    Names in the file itself come first, in the spelling of its format.
    """
    beside = _labels_file(path)
    if beside is None:
        return source
    try:
        entries = _entries(json.loads(read_bytes(beside)))
    except (ValueError, RecursionError, FileError) as error:
        reason = str(error) if isinstance(error, FileError) else "is no table of labels as this program writes it"
        return replace(source, notes=(*source.notes, f"{beside.name} beside it {reason}: names are left out"))
    numbers = {name: (entry["id"], entry["dimension"]) for name, entry in entries.items()}
    true = _spelling(source, path, entries)
    return replace(
        source,
        field_data={**numbers, **{true.get(name, name): number for name, number in source.field_data.items()}},
        cell_sets={true.get(name, name): cells for name, cells in source.cell_sets.items()},
        open_sets=tuple(true.get(name, name) for name in source.open_sets),
        cell_tags={tag: [true.get(name, name) for name in names] for tag, names in source.cell_tags.items()},
    )


def kept_spellings(folder: Path, name: str, formats: Iterable[str]) -> dict[str, dict[str, str]]:
    """Spellings by format of each group in NAME.labels.json, for files in other than these formats that are there.

    Empty if there is no such table, or it is damaged: then it is replaced.
    """
    try:
        entries = _entries(json.loads(read_bytes(folder / f"{name}{LABELS_FILE}")))
    except (ValueError, RecursionError, FileError):
        return {}
    others = {form: format.files[0] for form, format in FORMATS.items() if form not in formats}
    there = {
        form
        for form, end in others.items()
        if any(isfile(folder / f"{stem}{end}") for stem in (name, f"{name}.{form}"))  # noqa: PTH113 - as above
    }
    return {
        group: {form: word for form, word in entry["written"].items() if form in there}
        for group, entry in entries.items()
    }


def _spelling(source: Source, path: Path, entries: Mapping[str, Mapping[str, Any]]) -> dict[str, str]:
    """The true name of each word in the file, for the format of its ending in which all of these words occur.

    The same word may stand for different names in different formats.
    """
    used = {*source.field_data, *source.cell_sets, *(name for names in source.cell_tags.values() for name in names)}
    forms = [None, *(name for name, form in FORMATS.items() if form.files[0].endswith(path.suffix.lower()))]
    spellings = [{entry["written"].get(form, name): name for name, entry in entries.items()} for form in forms]
    return max(spellings, key=lambda words: len(used & words.keys()))


def _labels_file(path: Path) -> Path | None:
    """The file of labels of a mesh file NAME.ENDING, or NAME.FORMAT.ENDING, if there is one."""
    stems = dict.fromkeys([path.stem, Path(path.stem).stem])
    files = [path.with_name(stem + LABELS_FILE) for stem in stems]
    return next((file for file in files if isfile(file)), None)  # noqa: PTH113 - the method fails for too long a name


def _entries(table: Any) -> dict[str, dict[str, Any]]:
    """Id, dimension and other spellings of each name; ValueError if the table has another form."""
    if not isinstance(table, Mapping) or not all(isinstance(entry, Mapping) for entry in table.values()):
        raise ValueError("no table")
    found = {}
    for name, entry in table.items():
        number, dimension, written = entry.get("id"), entry.get("dimension"), entry.get("written", {})
        if not isinstance(number, int) or dimension not in (0, 1, 2) or not isinstance(written, Mapping):
            raise ValueError("no entry")
        found[name] = {
            "id": number,
            "dimension": dimension,
            "written": {str(form): str(word) for form, word in written.items()},
        }
    return found
