"""All cases of a batch, known by name before the first of them is meshed."""

import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from bubblemesh.batch.jobs import Job
from bubblemesh.case import Case, Override, Variant, case_variants, load_case, named_files
from bubblemesh.errors import BubblemeshError, CaseError, FileError, prefixed
from bubblemesh.files import read_bytes
from bubblemesh.run.destination import Destination, destination


@dataclass(frozen=True)
class Settings:
    """What holds for every case.

    Attributes
    ----------
    overrides : sequence of Override
        Set over each case's file.
    folder : str, optional
        Folder of all results; without it each case has its own.
    page : bool, optional
        Whether each case gets its page; without it the case says so.
    """

    overrides: Sequence[Override] = ()
    folder: str | None = None
    page: bool | None = None

    def __post_init__(self) -> None:
        if self.folder in ("", "-"):
            raise CaseError(f"-o {self.folder}: a batch writes into a folder: name one")


@dataclass(frozen=True)
class Entry:
    """A case of the batch.

    Attributes
    ----------
    number : int
        Its place in the batch, from 1.
    source : str
        Its file.
    variant : Variant
        Which of the file's cases it is.
    name : str
    place : Destination, optional
        Where its results go.
    error : BubblemeshError, optional
        Why it cannot be read; then there is no place.
    """

    number: int
    source: str
    variant: Variant
    name: str
    place: Destination | None
    error: BubblemeshError | None = None


def planned(files: Iterable[str], settings: Settings) -> list[Entry]:
    """The cases of all files, in order; those that cannot be read are among them.

    Raises
    ------
    CaseError
        If two cases would write the same file.
    FileError
        If the results of a case would overwrite a case file.
    """
    sources = list(files)
    found = [one for source in sources for one in _entries(source, settings)]
    entries = [Entry(number, *one) for number, one in enumerate(found, start=1)]
    _require_apart(entries, sources)
    return entries


Found = tuple[str, Variant, str, Destination | None, BubblemeshError | None]


def _entries(source: str, settings: Settings) -> Iterator[Found]:
    try:
        variants = case_variants(source, overrides=settings.overrides)
    except BubblemeshError as error:
        yield source, Variant(), Path(source).stem, None, error
        return
    for variant in variants:
        try:
            case = load_case(source, overrides=settings.overrides, variant=variant)
            yield source, variant, str(case.name), _place(case, source, settings), None
        except BubblemeshError as error:
            yield source, variant, Path(source).stem + variant.label, None, error


def _place(case: Case, source: str, settings: Settings) -> Destination:
    # With a slash at its end it is a folder, whatever its name looks like.
    return destination(
        case, source, None if settings.folder is None else f"{settings.folder}/", None, page=settings.page
    )


def _require_apart(entries: Sequence[Entry], sources: Sequence[str]) -> None:
    """Check that no two cases write the same file, and none a case file."""
    cases = {os.path.realpath(source): source for source in sources}
    owners: dict[str, Entry] = {}
    folders: dict[Path, str] = {}
    for entry in entries:
        for path in entry.place.files if entry.place else ():
            folder = folders.setdefault(path.parent, os.path.realpath(path.parent))
            place = os.path.join(folder, path.name)  # noqa: PTH118 (ten times faster, and there may be many)
            owner = owners.setdefault(place, entry)
            if owner is not entry:
                raise CaseError(f"{_called(owner)} and {_called(entry)} would both write {path}: {_advice(entry)}")
            if place in cases:
                raise FileError(f"{cases[place]}: the results of {_called(entry)} would overwrite this case file")


def _called(entry: Entry) -> str:
    return f"{entry.source} ({entry.name})" if entry.variant.label else entry.source


def _advice(entry: Entry) -> str:
    return f"give one of them another name than {entry.name!r}, or another output.directory and no -o"


def job_of(entry: Entry, settings: Settings) -> Job:
    """The job of a case, with the contents of all files as they are now.

    Raises
    ------
    BubblemeshError
        If the case cannot be read, or writes elsewhere than it did when the batch began.
    """
    if entry.error is not None:
        raise entry.error
    case = load_case(entry.source, overrides=settings.overrides, variant=entry.variant)
    place = _place(case, entry.source, settings)
    if entry.place is None or (place.folder, place.name) != (entry.place.folder, entry.place.name):
        raise CaseError(f"{entry.source}: its name or folder has changed since the batch began: run the batch again")
    with prefixed(entry.source):
        files = {str(path): _content(path) for path in named_files(case)}
    return Job(entry.number, entry.source, case, place, files)


def _content(path: Path) -> bytes:
    with prefixed(path):
        return read_bytes(path)
