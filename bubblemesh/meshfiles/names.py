"""Names of groups in formats that know plain words only, and the sidecar that tells the names of all groups."""

import json
import re
import unicodedata
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.groups import group_names, node_ids

LABELS_FILE = ".labels.json"
LONGEST = 60  # characters; CalculiX and Abaqus allow 80


def as_they_are(mesh: Mesh) -> dict[str, str]:
    """Return the names of all groups, each as its own spelling."""
    return {name: name for name in group_names(mesh)}


def plain_words(mesh: Mesh, reserved: Iterable[str] = (), dimensions: Iterable[int] = (0, 1, 2)) -> dict[str, str]:
    """Return for the name of each group of these dimensions a word of letters, digits, ``_`` and ``-``.

    It begins with a letter. The words differ in more than upper and lower case, as some readers know one of them only;
    none is a reserved one, which are given in upper case.
    """
    words: dict[str, str] = {}
    taken = set(reserved)
    for name, group in group_names(mesh).items():
        if group.dimension not in dimensions:
            continue
        bare = re.sub(r"[\u0300-\u036f]", "", unicodedata.normalize("NFKD", name))  # letters without their accents
        word = re.sub(r"[^A-Za-z0-9_-]", "_", bare)[:LONGEST]
        if not re.match(r"[A-Za-z]", word):
            word = f"group_{word}"
        while word.upper() in taken:
            word = f"{word}_{group.id}"
        words[name] = word
        taken.add(word.upper())
    return words


def labels_text(mesh: Mesh, spellings: Mapping[str, Mapping[str, str] | None], *, complete: bool) -> str | None:
    """Text of the sidecar: id and dimension of each group by name, and its name in a format that spells it otherwise.

    Labelled points have the numbers of their nodes, from 0, and periodic sides the label of their counterpart with
    the shift to it.

    Parameters
    ----------
    mesh : Mesh
    spellings : mapping of str to mapping or None
        For each format that is written, the spelling of each name, or None if it holds ids only.
    complete : bool
        Whether the formats hold labelled points and periodic pairs, as far as the mesh has any.

    Returns
    -------
    str or None
        JSON text; None if every format holds the names as they are, and all else.
    """
    more = _places(mesh) | _counterparts(mesh)
    entries = {}
    for name, group in group_names(mesh).items():
        other = {form: words[name] for form, words in spellings.items() if words and words.get(name, name) != name}
        entries[name] = group._asdict() | more.get(group.id, {}) | ({"written": other} if other else {})
    if complete and None not in spellings.values() and not any("written" in entry for entry in entries.values()):
        return None
    return json.dumps(entries, indent=2, ensure_ascii=False) + "\n"


def _places(mesh: Mesh) -> dict[int, dict[str, Any]]:
    """Nodes of the labelled points, by the ids of their groups."""
    ids = node_ids(mesh)
    return {int(number): {"nodes": mesh.labelled_nodes[ids == number].tolist()} for number in np.unique(ids)}


def _counterparts(mesh: Mesh) -> dict[int, dict[str, Any]]:
    """Counterparts of the periodic sides, by the ids of their labels."""
    found: dict[int, dict[str, Any]] = {}
    for first, second, shift, _ in mesh.periodic_sides:
        found[first + 1] = {"periodic": {"with": mesh.labels[second], "shift": shift.tolist()}}
        found[second + 1] = {"periodic": {"with": mesh.labels[first], "shift": (0 - shift).tolist()}}
    return found
