"""Where the products of a run go: a folder, one file, or the standard output."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from os.path import isdir, realpath
from pathlib import Path
from typing import Any, BinaryIO, TypeVar

from bubblemesh.case import Case
from bubblemesh.errors import CaseError, FileError
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.formats import FORMATS, FORMATS_FOR, FormatName, formats_by_ending, require_order
from bubblemesh.meshfiles.groups import LABELS_FILE
from bubblemesh.meshfiles.text import HISTORY_FILES, history_tables
from bubblemesh.meshfiles.writing import PAGE_FILE, file_names, write_files, write_stream
from bubblemesh.run.pipeline import Result

T = TypeVar("T")


@dataclass(frozen=True)
class Destination:
    """Folder, names and kinds of the files to write.

    Attributes
    ----------
    folder : Path or None
        Folder of the files; None for the standard output.
    name : str
        Stem of the files' names.
    formats : tuple of str
    history : bool
        Whether tables of all rounds and steps are written too.
    page : bool
        Whether a page to look at is written too.
    """

    folder: Path | None
    name: str
    formats: tuple[str, ...]
    history: bool
    page: bool = False

    @property
    def files(self) -> list[Path]:
        """All files that may be written."""
        if self.folder is None:
            return []
        tables = [LABELS_FILE, *(HISTORY_FILES if self.history else ()), *([PAGE_FILE] if self.page else ())]
        return [self.folder / name for name in file_names(self.name, self.formats, tables)]

    def require_apart(self, source: Path) -> None:
        """Check that no file that may be written is one that has been read; else it is a FileError."""
        if realpath(source) in map(realpath, self.files):
            raise FileError(f"{source}: the results would overwrite this file: give another name by -o")

    def deliver(self, result: Result, stream: BinaryIO | None = None) -> dict[str, Any]:
        """Write the mesh and the report, and return the report as written; without a folder the mesh goes to a stream.

        Raises
        ------
        FileError
            If a file cannot be written; then none is, and old ones stay.
        """
        mesh, report = result.mesh, result.report
        if self.folder is None:
            assert stream is not None
            write_stream(mesh, result.fields, self.formats[0], stream)
            return {**report, "files": []}
        tables = history_tables(report["rounds"], result.speeds) if self.history else {}
        page = partial(_page, mesh, result) if self.page else None
        return write_files(mesh, result.fields, report, self.folder, self.name, self.formats, tables, page)


def destination(
    case: Case,
    source: str,
    output: str | None,
    format_name: str | None,
    solver: str | None = None,
    *,
    history: bool = False,
    page: bool | None = None,
) -> Destination:
    """What the options ``-o``, ``--format``, ``--for`` and ``--report`` and the case say together.

    A path that ends in a slash, is a folder, or has no ending is a folder; any other one is a file, whose format is
    that of its ending.

    Raises
    ------
    CaseError
        If the format or the solver is unknown, or the format is not that of the file's ending or has no form for the
        order of the triangles.
    FileError
        If a file would be written twice, or the case file overwritten.
    """
    asked = _asked(format_name, solver)
    formats = _distinct(asked or case.output.formats)
    folder: Path | None = _own_folder(case, source)
    name = str(case.name)
    if output == "":
        raise CaseError("-o: the name is empty: name a folder, a file, or - for the standard output")
    if output == "-":
        for option, asked_for in (("--history", history), ("--report", page)):
            if asked_for:
                raise CaseError(f"{option}: there is no place for its files with -o -: drop one of them")
        folder, formats = None, formats[:1]
    elif output is not None:
        folder = Path(output)
        if _is_file(output):
            formats = (_format_of(folder, asked, case.output.formats),)
            folder, name = folder.parent, folder.name.removesuffix(FORMATS[formats[0]].files[0])
    require_order(formats, case.output.order)
    wanted = case.output.report if page is None else page
    place = Destination(folder, name, formats, history, wanted and folder is not None)
    if source != "-":
        place.require_apart(Path(source))
    return place


def _page(mesh: Mesh, result: Result, report: Mapping[str, Any]) -> str:
    """The page of a run whose report is as written."""
    from bubblemesh.pages.report import report_page

    return report_page(mesh, result.fields, report, result.speeds, datetime.now().astimezone())


def _asked(format_name: str | None, solver: str | None) -> tuple[FormatName, ...]:
    """The formats that the options ask for, if any."""
    if format_name is not None and solver is not None:
        raise CaseError("--format and --for exclude each other: drop one of them")
    if solver is not None:
        return _looked_up(FORMATS_FOR, solver, "--for: unknown solver")
    if format_name is not None:
        return (_looked_up({name: name for name in FORMATS}, format_name, "--format: unknown format"),)
    return ()


def _looked_up(table: Mapping[Any, T], name: str, problem: str) -> T:
    if name not in table:
        raise CaseError(f"{problem} {name!r}: choose one of {', '.join(table)}")
    return table[name]


def _distinct(formats: tuple[FormatName, ...]) -> tuple[FormatName, ...]:
    """Check that no two formats would be the same file."""
    mains = [FORMATS[name].files[0] for name in formats]
    for name, main in zip(formats, mains, strict=True):
        if formats.count(name) > 1:
            raise FileError(f"output.formats: {name} is named twice, and both would be the same file: name it once")
        if mains.count(main) > 1:
            both = " and ".join(other for other in formats if FORMATS[other].files[0] == main)
            raise FileError(f"output.formats: {both} would be the same file: name one of them")
    return formats


def _own_folder(case: Case, source: str) -> Path:
    """The folder that the case names, relative to the case file; else the present one."""
    if case.output.directory is None:
        return Path()
    return (Path() if source == "-" else Path(source).parent) / case.output.directory


def _is_file(output: str) -> bool:
    path = Path(output)
    is_folder = output.endswith("/") or isdir(path)  # noqa: PTH112 - the method of paths fails for too long a name
    return (path.suffix != "" or path.name.startswith(".")) and not is_folder


def _format_of(path: Path, asked: tuple[FormatName, ...], liked: tuple[FormatName, ...]) -> FormatName:
    """The format of a file by its ending: one of those asked for, else one that the case names, else any."""
    fitting = formats_by_ending(path.name)
    if not fitting:
        ends = ", ".join(dict.fromkeys(form.files[0] for form in FORMATS.values()))
        raise CaseError(
            f"-o {path}: unknown ending for a mesh file: choose one of {ends}; the name of a folder ends with a slash"
        )
    if asked:
        both = [name for name in fitting if name in asked]
        if not both:
            option = f"--format or --for asks for {' or '.join(asked)}"
            raise CaseError(f"-o {path}: its ending asks for {fitting[0]}, {option}: drop one of them")
        return both[0]
    return next((name for name in fitting if name in liked), fitting[0])
