"""The plan of a batch: its options, and all cases by their names before the first of them is meshed."""

import os
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from glob import glob, has_magic
from pathlib import Path
from typing import TypeVar

from bubblemesh import __version__
from bubblemesh.batch.row import Row
from bubblemesh.batch.worker import BatchJob
from bubblemesh.case import Case, Override, Variant, case_variants, load_case
from bubblemesh.errors import DONE, CaseError, FileError, prefixed
from bubblemesh.problem.files import contents_or_errors, files_of_case
from bubblemesh.records import record
from bubblemesh.run.destination import Destination
from bubblemesh.run.output import OutputOptions, destination

T = TypeVar("T")

ENDINGS = (".yaml", ".yml")
STEM = "summary"  # of the names of a summary's files
PRIVATE = (".", "_")  # files in a folder whose names begin so are not cases, but for instance bases of cases


@record
class BatchOptions:
    """Options that hold for all cases of a batch."""

    overrides: Sequence[Override] = ()  # values that replace those of each case's file
    folder: str | None = None  # of all results; without it each case has its own
    page: bool | None = None  # whether each case gets its page; if None, as the case says
    history: bool = False  # whether each case gets the tables of its rounds and steps, and the batch a picture of them
    shard: tuple[int, int] = (1, 1)  # the part of the cases to mesh, from 1, and the number of parts
    untrusted: bool = False  # whether the cases come from strangers
    resume: bool = False  # whether cases that an earlier batch has done stay as they are, and its summary goes on

    def __post_init__(self) -> None:
        if self.folder in ("", "-"):
            raise CaseError(f"-o {self.folder}: a batch writes into a folder: name one")

    @property
    def root(self) -> Path:
        """Folder of the summary."""
        return Path(self.folder or ".")

    @property
    def summary(self) -> Path:
        """File with a line for each case of the batch, or of its shard."""
        return self.root / f"{STEM}{self.suffix}.jsonl"

    @property
    def suffix(self) -> str:
        """Part of the names of the summary's files that names the shard, such as ``-03-of-16``."""
        index, count = self.shard
        return "" if count == 1 else f"-{index:0{len(str(count))}}-of-{count}"

    def part_of(self, entries: Sequence[T]) -> list[T]:
        """Entries of the shard: each so many-th one, as neighbours are often equally large."""
        index, count = self.shard
        return list(entries[index - 1 :: count])


def parse_shard(text: str) -> tuple[int, int]:
    """Index and count in a text such as ``3/16``; CaseError if it is not such a text."""
    found = re.fullmatch(r"(\d{1,9})/(\d{1,9})", text)
    if found is None or not 1 <= int(found[1]) <= int(found[2]):
        raise CaseError(f"--shard {text}: must be I/N, the part I of N parts, from 1/N to N/N")
    return int(found[1]), int(found[2])


@record
class Entry:
    """A case of the batch, as it was when the batch began; if it cannot be read there is only a row with the error."""

    number: int  # its place in the batch, from 1
    row: Row  # what is known of it before it is meshed
    case: Case | None = None
    destination: Destination | None = None

    @property
    def names(self) -> Sequence[str]:
        """Names of all files that may be written, in the destination's folder."""
        return self.destination.names if self.destination else ()

    def job(self) -> BatchJob | Row:
        """Job of the case, with the present contents of the files that it names; a row with the error if that fails.

        The error of a file that cannot be read is raised where the case is meshed, with the key of the file, as in
        `bubblemesh run`.
        """
        if self.case is None or self.destination is None:
            return self.row
        try:
            with prefixed(self.row.source):
                files = contents_or_errors(self.case, self.case.root)
            job = BatchJob(self.number, self.row, self.case, self.destination, files)
            return replace(job, row=replace(self.row, inputs=job.digest()))
        except Exception as error:  # whatever it is, the other cases are meshed
            return self.row.ended_by(error)


def plan_cases(files: Iterable[str], options: BatchOptions) -> list[Entry]:
    """Entries of all cases of the files, in order, also of those that cannot be read.

    CaseError if two cases would write the same file, or an option is wrong for all of them. FileError if the results of
    a case would overwrite a case file, or a file that a case reads.
    """
    sources = list(files)
    entries: list[Entry] = []
    for source in sources:
        try:
            variants = case_variants(source, overrides=options.overrides, untrusted=options.untrusted)
        except Exception as error:
            entries.append(Entry(len(entries) + 1, _row(source).ended_by(error)))
        else:
            entries += planned(source, variants, options, len(entries) + 1)
    _require_usable(entries, options)
    _require_apart(entries, sources)
    return entries


def planned(
    source: str, variants: Sequence[Variant], options: BatchOptions, first: int = 1, text: str | None = None
) -> list[Entry]:
    """Entries of the cases in a file, or in a ``text`` in its place; ``first`` is the number of the first one."""
    return [_entry(number, source, one, options, text) for number, one in enumerate(variants, first)]


def _entry(number: int, source: str, variant: Variant, options: BatchOptions, text: str | None) -> Entry:
    row = _row(source, variant)
    # A name that ends with a slash is a folder, even with the ending of a mesh file.
    output = None if options.folder is None else f"{options.folder}/"
    try:
        case = load_case(source, overrides=options.overrides, text=text, variant=variant, untrusted=options.untrusted)
        place = destination(case, source, OutputOptions(output, history=options.history, page=options.page))
    except Exception as error:
        return Entry(number, row.ended_by(error))
    folder = _seen_from(options.root, place.folder)
    return Entry(number, replace(row, case=str(case.name), folder=folder), case, place)


def _row(source: str, variant: Variant | None = None) -> Row:
    label, values = (variant.label, variant.values) if variant else ("", ())
    return Row(Path(source).stem + label, source, DONE, dict(values), version=__version__)


def _seen_from(root: Path, folder: Path) -> str:
    if folder == root:  # a short way for batches of very many cases
        return "."
    try:
        return Path(os.path.relpath(folder, root)).as_posix()
    except ValueError:  # another drive of Windows
        return str(folder.absolute())


def _require_usable(entries: Sequence[Entry], options: BatchOptions) -> None:
    """Check that some case is right, or that no option is wrong: earlier results must not count as failed then.

    Cases with other errors, such as those that cannot be read, do not make an option right.
    """
    names = tuple(f"{override.source}:" for override in options.overrides)
    wrong = [error for entry in entries if (error := entry.row.error) and error.startswith(names)]
    if wrong and all(entry.row.error for entry in entries):
        raise CaseError(wrong[0])


def _require_apart(entries: Sequence[Entry], sources: Sequence[str]) -> None:
    """Check that no two cases write the same file, and that no case writes a case file or one that a case reads."""
    owners: dict[str, Entry] = {}
    folders: dict[Path, str] = {}
    for entry in entries:
        if entry.destination is None:
            continue
        folder = entry.destination.folder
        real = folders.get(folder) or folders.setdefault(folder, os.path.realpath(folder))
        for name in entry.names:
            place = os.path.join(real, name)  # noqa: PTH118 (ten times faster, and there may be many)
            owner = owners.setdefault(place, entry)
            if owner is not entry:
                advice = f"give one of them another name than {entry.row.case!r}, or another output.directory and no -o"
                raise CaseError(f"{_called(owner)} and {_called(entry)} would both write {folder / name}: {advice}")
    read = {str(path): "file" for entry in entries if entry.case is not None for path in files_of_case(entry.case)}
    for path, kind in (read | dict.fromkeys(sources, "case file")).items():
        writer = owners.get(os.path.realpath(path))
        if writer is not None:
            raise FileError(f"{path}: the results of {_called(writer)} would overwrite this {kind}")


def _called(entry: Entry) -> str:
    return f"{entry.row.source} ({entry.row.case})" if entry.row.sweep else entry.row.source


def case_files(paths: Sequence[str]) -> list[str]:
    """Case files of paths, patterns and folders, each once, in the given order; those of a folder sorted by name.

    CaseError if there is no case file in a folder, or none that fits a pattern; FileError if a folder cannot be read,
    or a name is empty.
    """
    found: dict[str, str] = {}
    for path in paths:
        for file in _files_of(path):
            found.setdefault(os.path.abspath(file), file)  # noqa: PTH100 (two links to one file are two cases)
    return list(found.values())


def _files_of(path: str) -> list[str]:
    """Case files of a path, a pattern or a folder; the errors of `case_files`."""
    if not path:
        raise FileError("the name of a case file or folder is empty")
    if path == "-":
        raise CaseError("-: a batch reads no case from the standard input: use bubblemesh run -")
    is_folder = Path(path).is_dir()
    if not is_folder and (not has_magic(path) or Path(path).exists()):
        return [path]  # a missing file becomes a case that fails
    matches = [path] if is_folder else sorted(glob(path, recursive=True))  # noqa: PTH207 (a whole pattern)
    files = [file for match in matches for file in (_in_folder(match) if Path(match).is_dir() else [match])]
    if files:
        return files
    if not is_folder:
        raise CaseError(f"{path}: no file fits this pattern")
    raise CaseError(
        f"{path}: no case file is in this folder: their names end in {' or '.join(ENDINGS)}, and those that begin "
        f"with {' or '.join(PRIVATE)} are left out"
    )


def _in_folder(path: str) -> Iterator[str]:
    def refuse(error: OSError) -> None:
        raise FileError(f"{error.filename}: the folder cannot be read: {error.strerror}")

    for folder, inner, names in os.walk(path, onerror=refuse):
        inner[:] = sorted(name for name in inner if not name.startswith(PRIVATE))
        for name in sorted(names):
            if name.endswith(ENDINGS) and not name.startswith(PRIVATE):
                yield str(Path(folder, name))
