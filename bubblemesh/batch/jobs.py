"""What a worker is given, and what it gives back."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Any

from bubblemesh import __version__
from bubblemesh.case import Case
from bubblemesh.run.destination import Destination


@dataclass(frozen=True)
class Job:
    """A case with everything that meshing it takes, wherever that happens.

    Attributes
    ----------
    number : int
        The case's place in the batch.
    source : str
        What messages call the case file.
    case : Case
    place : Destination
        Where the results are to go, and in which formats.
    files : mapping of str to bytes
        Contents of the files that the case names.
    version : str
        Version of bubblemesh that has to mesh it.
    """

    number: int
    source: str
    case: Case
    place: Destination
    files: Mapping[str, bytes]
    version: str = __version__

    def digest(self) -> str:
        """Hash of all that a finished mesh and its files depend on.

        Where files lie does not count, what is in them does. Nor does it count which files are written beside the mesh,
        and how much time there was.
        """
        contents = {name: sha256(content).hexdigest() for name, content in self.files.items()}
        case = self.case.model_dump(mode="json", exclude={"output": True, "limits": {"seconds"}})
        inputs = {
            "version": self.version,
            "case": _with_contents(case, contents),
            "files": sorted((Path(name).name, digest) for name, digest in contents.items()),
            "formats": self.place.formats,
            "order": self.place.order,
        }
        return sha256(json.dumps(inputs, sort_keys=True).encode()).hexdigest()


def _with_contents(value: Any, contents: Mapping[str, str]) -> Any:
    """The same data, with the hash of its content in place of each file's name."""
    if isinstance(value, dict):
        named = {"file": contents[value["file"]]} if value.get("file") in contents else {}
        return {key: _with_contents(entry, contents) for key, entry in value.items()} | named
    if isinstance(value, list | tuple):
        return [_with_contents(entry, contents) for entry in value]
    return value


@dataclass(frozen=True)
class Outcome:
    """What became of a job.

    Attributes
    ----------
    exit_code : int
        What ``bubblemesh run`` would have ended with.
    error : str, optional
    report : dict
        As written; empty if there is no mesh.
    warnings : tuple of str
    files : mapping of str to bytes
        Contents of the files to write, by their names; either all or none.
    digests : mapping of str to str
        Their SHA-256 hashes.
    traceback : str, optional
        Where an error of the program happened.
    full : bool
        Whether there was no space for temporary files.
    """

    exit_code: int = 0
    error: str | None = None
    report: Mapping[str, Any] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    files: Mapping[str, bytes] = field(default_factory=dict)
    digests: Mapping[str, str] = field(default_factory=dict)
    traceback: str | None = None
    full: bool = False


@dataclass(frozen=True)
class Note:
    """How far a running job is: its finished rounds, and the nodes then (0 before the first)."""

    number: int
    round: int = 0
    nodes: int = 0


Tell = Callable[[Note], None]
