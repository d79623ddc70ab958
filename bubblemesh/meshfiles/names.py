"""Names of groups that a mesh file knows by numbers or other words, from the file of labels beside it."""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from bubblemesh.errors import FileError
from bubblemesh.files import read_bytes
from bubblemesh.meshfiles.groups import LABELS_FILE
from bubblemesh.meshfiles.sources.source import Source


def named(source: Source, path: Path) -> Source:
    """The source with the names that NAME.labels.json beside the file tells; as it is, with a note if that is damaged.

    Names that the file itself has go first.
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
    words = {word: name for name, entry in entries.items() for word in entry["written"]}
    sets = {words.get(name, name): cells for name, cells in source.cell_sets.items()}
    return replace(source, field_data={**numbers, **source.field_data}, cell_sets=sets)


def _labels_file(path: Path) -> Path | None:
    """The file of labels of a mesh file NAME.ENDING, or NAME.FORMAT.ENDING, if there is one."""
    stems = dict.fromkeys([path.stem, Path(path.stem).stem])
    return next((beside for stem in stems if (beside := path.with_name(stem + LABELS_FILE)).is_file()), None)


def _entries(table: Any) -> dict[str, dict[str, Any]]:
    """Id, dimension and other spellings of each name; ValueError if the table is none of this kind."""
    if not isinstance(table, Mapping) or not all(isinstance(entry, Mapping) for entry in table.values()):
        raise ValueError("no table")
    found = {}
    for name, entry in table.items():
        number, dimension, written = entry.get("id"), entry.get("dimension"), entry.get("written", {})
        if not isinstance(number, int) or dimension not in (0, 1, 2) or not isinstance(written, Mapping):
            raise ValueError("no entry")
        found[name] = {"id": number, "dimension": dimension, "written": [str(word) for word in written.values()]}
    return found
