"""Where the products of a run go: a folder, one file, or the standard output."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bubblemesh.case import Case
from bubblemesh.errors import CaseError, FileError, RequirementError
from bubblemesh.output import FORMATS, HISTORY_FILES, file_names, history_tables, write_file, write_files, write_stream
from bubblemesh.pipeline import Result
from bubblemesh.streams import output_stream

__all__ = ["Destination", "destination", "require_quality"]


@dataclass(frozen=True)
class Destination:
    """Where to write.

    Attributes
    ----------
    path : Path or None
        A mesh file, or a folder for the whole set of files; None for the standard output.
    is_file : bool
        Whether the path is that of one mesh file.
    name : str
        Stem of the files in a folder.
    formats : tuple of str
    history : bool
        Whether tables of all rounds and steps are written too.
    """

    path: Path | None
    is_file: bool
    name: str
    formats: tuple[str, ...]
    history: bool

    @property
    def files(self) -> list[Path]:
        """All files to write."""
        if self.path is None:
            return []
        folder, stem = (self.path.parent, self.path.stem) if self.is_file else (self.path, self.name)
        formats = (self.path.suffix.removeprefix("."),) if self.is_file else self.formats
        return [folder / name for name in file_names(stem, formats, HISTORY_FILES if self.history else ())]

    def deliver(self, result: Result) -> dict[str, Any]:
        """Write the mesh and the report, and return the report as written.

        Raises
        ------
        FileError
            If a file cannot be written; then none is, and old ones stay.
        """
        if self.path is None:
            write_stream(result.mesh, result.fields, self.formats[0], output_stream())
            return {**result.report, "files": []}
        tables = history_tables(result.report["rounds"], result.speeds) if self.history else {}
        if self.is_file:
            return write_file(result.mesh, result.fields, result.report, self.path, tables)
        return write_files(result.mesh, result.fields, result.report, self.path, self.name, self.formats, tables)


def destination(
    case: Case, source: str, output: str | None, format_name: str | None, *, history: bool = False
) -> Destination:
    """What the options ``-o`` and ``--format`` and the case say together.

    A path that ends in a slash, is a folder, or has no ending is a folder; any other one is a file, whose format is
    that of its ending.

    Raises
    ------
    CaseError
        If the format is unknown, or is not that of the file's ending.
    FileError
        If a file would be written twice, the case file overwritten, or a mesh go to a terminal.
    """
    formats = _formats(case, format_name)
    name = str(case.name)
    if output == "":
        raise CaseError("-o: the name is empty: name a folder, a file, or - for the standard output")
    if output == "-":
        if output_stream().isatty():
            raise FileError("-o -: the mesh would go to the terminal: redirect it or pipe it to a program")
        if history:
            raise CaseError("--history: there is no place for its files with -o -: drop one of them")
        return Destination(None, False, name, formats, history)
    if output is None:
        place = Destination(_own_folder(case, source), False, name, formats, history)
    else:
        path = Path(output)
        is_file = (path.suffix != "" or path.name.startswith(".")) and not output.endswith("/") and not path.is_dir()
        if is_file:
            _check_ending(path, format_name)
        place = Destination(path, is_file, name, formats, history)
    if source != "-" and Path(source).resolve() in [path.resolve() for path in place.files]:
        raise FileError(f"{source}: the results would overwrite the case file: give another name")
    return place


def require_quality(case: Case, report: Mapping[str, Any]) -> None:
    """Check what the case demands under ``require``.

    Raises
    ------
    RequirementError
        With each figure that is missed.
    """
    reached = {
        "quality_min": report["quality"]["min"],
        "quality_mean": report["quality"]["mean"],
        "angle_min": report["quality"]["angle_min"],
    }
    wanted = case.require.model_dump(exclude_none=True)
    missed = [
        f"{key} is {reached[key]:.4g}, below {bound:.4g}" for key, bound in wanted.items() if reached[key] < bound
    ]
    if missed:
        raise RequirementError(f"the mesh is written, but misses what the case requires: {'; '.join(missed)}")


def _formats(case: Case, format_name: str | None) -> tuple[str, ...]:
    """The formats of the case, or the one of the option."""
    if format_name is not None and format_name not in FORMATS:
        raise CaseError(f"--format: unknown format {format_name!r}: choose one of {', '.join(FORMATS)}")
    formats = case.output.formats if format_name is None else (format_name,)
    for name in formats:
        if formats.count(name) > 1:
            raise FileError(f"output.formats: {name} is named twice, and both would be the same file: name it once")
    return formats


def _own_folder(case: Case, source: str) -> Path:
    """The folder that the case names, relative to the case file; else the present one."""
    if case.output.directory is None:
        return Path()
    return (Path() if source == "-" else Path(source).parent) / case.output.directory


def _check_ending(path: Path, format_name: str | None) -> None:
    ending = path.suffix.removeprefix(".")
    if ending not in FORMATS:
        known = ", ".join(f".{name}" for name in FORMATS)
        raise CaseError(
            f"-o {path}: unknown ending for a mesh file: choose one of {known}; the name of a folder ends with a slash"
        )
    if format_name not in (None, ending):
        raise CaseError(f"-o {path}: its ending asks for {ending}, --format for {format_name}: drop one of them")
