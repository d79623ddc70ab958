"""Destination of the products of a run: a folder, one file, or a stream."""

from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime
from functools import cached_property, partial
from os.path import isdir, realpath, split
from pathlib import Path
from typing import Any, BinaryIO

from bubblemesh.case import Case, Output, Override
from bubblemesh.errors import CaseError, FileError, prefixed
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.slices import SlicedMesh
from bubblemesh.meshfiles.companions import files_beside
from bubblemesh.meshfiles.formats import (
    FORMATS,
    FORMATS_FOR,
    MOST_PIECES,
    FormatName,
    format_named,
    formats_by_ending,
    formats_for,
    require_no_sizes,
    require_order,
    stem_of,
    unknown_ending,
    whole_only,
    without_partition,
)
from bubblemesh.meshfiles.groups import LABELS_FILE, Fields
from bubblemesh.meshfiles.text import HISTORY_FILES, history_tables
from bubblemesh.meshfiles.transaction import require_room, require_writable
from bubblemesh.meshfiles.writing import (
    MEDIT,
    METRIC_FILE,
    NO_TABLES,
    PAGE_FILE,
    Page,
    file_names,
    write_files,
    write_stream,
)
from bubblemesh.messages import unknown
from bubblemesh.problem.files import files_of_case
from bubblemesh.records import record
from bubblemesh.run.pipeline import Result, SlicedResult

PARTITIONED = ", ".join(name for name, form in FORMATS.items() if form.partition)
SLICED = ", ".join(name for name, form in FORMATS.items() if form.slices)
LARGE = 1_000_000  # nodes
SAMPLE = 20_000  # triangles on the page of a mesh in slices
NO_FIELDS: Fields = {}


@record
class OutputOptions:
    """Options of a command that say over the case what is written, and where."""

    output: str | None = None  # a folder, or a file
    named: Sequence[str] = ()  # formats
    solvers: Sequence[str] = ()  # whose formats are meant
    history: bool = False
    page: bool | None = None

    @property
    def formats(self) -> tuple[FormatName, ...]:
        """Formats that the options ask for, if any; an unknown format or solver is a CaseError."""
        if self.named and self.solvers:
            raise CaseError("--format and --for exclude each other: drop one of them")
        for solver in self.solvers:
            if solver not in FORMATS_FOR:
                raise CaseError(f"--for: {unknown('solver', solver, FORMATS_FOR)}")
        with prefixed("--format"):
            for name in self.named:
                format_named(name)
        return formats_for(self.solvers) or tuple(dict.fromkeys(self.named))

    def over_cases(self) -> list[Override]:
        """Overrides that set the formats of many cases; none if the options ask for none. Errors as `formats`."""
        if not self.formats:
            return []
        source = "--for" if self.solvers else "--format"
        return [Override(("output", "for"), None, source), Override(("output", "formats"), [*self.formats], source)]

    def require_only(self, chosen: FormatName) -> None:
        """Check that a single file in the chosen format is for each solver and format named; else it is a CaseError."""
        others = [f"--for {solver}" for solver in self.solvers if chosen not in FORMATS_FOR[solver]]
        others += [f"--format {name}" for name in self.named if name != chosen]
        if others:
            problem = f"is one file, in the format {chosen}, and {others[0]} asks for another"
            raise CaseError(f"-o {self.output}: {problem}: name a folder")


@record
class Destination:
    """Folder, names and kinds of the files to write."""

    folder: Path
    name: str  # stem of the files' names
    formats: tuple[FormatName, ...]
    history: bool  # whether tables of all rounds and steps are written too
    page: bool = False  # whether a page to look at is written too
    lasting: bool = True  # whether the files outlast a power cut
    parts: int = 1  # of the mesh, at most
    ending: str | None = None  # of a single mesh file, as the user spells it

    @cached_property
    def names(self) -> list[str]:
        """Names of all files that may be written into the folder."""
        tables = [LABELS_FILE, *(HISTORY_FILES if self.history else ()), *([PAGE_FILE] if self.page else ())]
        tables += [METRIC_FILE] if MEDIT in self.formats else []
        return file_names(self.name, self.formats, tables, self.parts, self.ending)

    def require_writable(self) -> None:
        """Check that the files can be written, before the work; else it is a FileError."""
        require_writable(self.folder, self.names)

    def load(self) -> None:
        """Load what writes the formats."""
        for name in self.formats:
            FORMATS[name].load()

    def deliver(self, result: Result | SlicedResult) -> dict[str, Any]:
        """Write the mesh and the report, and return the report as written.

        If that is a FileError, no file is written, and old ones stay.
        """
        tables = history_tables(result.report["rounds"], result.speeds) if self.history else {}
        page = partial(_page, result) if self.page else None
        fields = result.fields if isinstance(result, Result) else NO_FIELDS
        return self.write(result.mesh, fields, result.report, tables, page)

    def write(
        self,
        mesh: Mesh | SlicedMesh,
        fields: Fields,
        report: Mapping[str, Any],
        tables: Mapping[str, str] = NO_TABLES,
        page: Page | None = None,
    ) -> dict[str, Any]:
        """Write a mesh and a report of it, as `deliver` those of a run; see `write_files`."""
        told = _with_formats_told(report, mesh, self.formats)
        where = self.folder, self.name, self.formats
        return write_files(mesh, fields, told, *where, tables, page, ending=self.ending, lasting=self.lasting)


@record
class StreamDestination:
    """A stream for the mesh alone."""

    stream: BinaryIO
    format_name: FormatName

    def require_writable(self) -> None:
        """Check nothing: what becomes of a stream shows as it is written."""

    def load(self) -> None:
        """Load what writes the format."""
        FORMATS[self.format_name].load()

    def deliver(self, result: Result | SlicedResult) -> dict[str, Any]:
        """Write the mesh, and return the report, which has no files; a FileError if that cannot be done."""
        assert isinstance(result, Result)  # slices are kept beside files
        return self.write(result.mesh, result.fields, result.report)

    def write(self, mesh: Mesh, fields: Fields, report: Mapping[str, Any]) -> dict[str, Any]:
        """Write a mesh, as `deliver` that of a run."""
        write_stream(mesh, fields, self.format_name, self.stream)
        return {**_with_formats_told(report, mesh, [self.format_name]), "files": []}


def destination(
    case: Case, source: str, options: OutputOptions, solution: Path | None = None, *, in_slices: bool = False
) -> Destination:
    """Destination that the options and the case name together, as of `destination_beside`.

    Its inputs are the case file, the solution if there is one, and all files that the case names. ``in_slices`` tells
    that what is packed in parts may be written part by part. An untrusted case that names a folder outside of its own
    is a CaseError, and a format that the case's coordinates do not go with.
    """
    # Relative to the case file; with a case of the standard input, or without a name, the present folder.
    directory = case.output.directory
    folder = Path() if directory is None else Path(source).parent / directory
    if case.root is not None and directory is not None and options.output is None:
        _require_below(folder, case.root)
    inputs: list[str | Path] = [*([] if source == "-" else [source]), *files_of_case(case)]
    if solution is not None:
        inputs += [solution, *files_beside(solution)]
    slices = _most_parts(case) if in_slices else 1
    place = destination_beside(inputs, case.output, folder, str(case.name), options, slices)
    require_fitting_coordinates(case, place.formats)
    return place


def require_fitting_coordinates(case: Case, formats: Iterable[FormatName]) -> None:
    """Check that sizes are written in the plane of the packing only; else it is a CaseError."""
    if case.crs is not None and case.crs.to != "auto":
        require_no_sizes(formats)


def _most_parts(case: Case) -> int:
    """Most parts that a case's mesh may be packed in."""
    if case.parts != "auto":
        return case.parts or 1
    # Imported here since few meshes have parts.
    from bubblemesh.parts.pipeline import enough_parts

    return min(enough_parts(case.limits.max_nodes), MOST_PIECES)


def destination_beside(
    inputs: Iterable[str | Path], keys: Output, folder: Path, name: str, options: OutputOptions, slices: int = 1
) -> Destination:
    """Destination that the options name over the keys of a case, with a folder and a name for what they leave open.

    A path that ends in a slash, is a folder, or has no ending is a folder; any other one is a file, whose format is
    that of its ending. A mesh may be written in so many ``slices`` at the most, if all formats can. CaseError if the
    format or the solver is unknown, or the format is not that of the file's ending, has no form for the order of the
    triangles, or would be too many files; FileError if a file would be written twice, one of the inputs be
    overwritten, or something that is not a file has a name to write.
    """
    requested, output = options.formats, options.output
    formats = _distinct(requested or keys.formats)
    if output == "":
        raise CaseError("-o: the name is empty: name a folder, a file, or - for the standard output")
    ending = None
    if output is not None:
        folder = Path(output)
        if _is_file(output):
            formats = (_format_of(folder, requested, keys.formats),)
            options.require_only(formats[0])
            file, folder = folder.name, folder.parent
            name = stem_of(file, formats[0])
            ending = file.removeprefix(name)
    require_order(formats, keys.order)
    page = keys.report if options.page is None else options.page
    parts = keys.partition or (1 if whole_only(formats) else slices)
    place = Destination(folder, name, formats, options.history, page, parts=parts, ending=ending)
    names = place.names
    for path in inputs:
        own, file = split(realpath(path))  # a link that has the name of a file to write is replaced by it
        if file in names and own == realpath(folder):
            raise FileError(f"{path}: the results would overwrite this file: give another name by -o")
    require_room(folder, names)
    return place


def _require_below(folder: Path, root: Path) -> None:
    """Check that the folder of an untrusted case's results lies below the folder of the case."""
    if not Path(realpath(folder)).is_relative_to(root):
        raise CaseError(
            f"output.directory: {folder} leads out of {root}: an untrusted case writes below it, or where -o says"
        )


def stream_destination(keys: Output, stream: BinaryIO, options: OutputOptions) -> StreamDestination:
    """Destination of the option ``-o -``; CaseError as of `destination`, and if there are other files to write."""
    first = _distinct(options.formats or keys.formats)[0]
    options.require_only(first)
    for option, asked_for in (("--history", options.history), ("--report", options.page)):
        if asked_for:
            raise CaseError(f"{option}: there is no place for its files with -o -: drop one of them")
    require_order([first], keys.order)
    if FORMATS[first].piece is not None:
        raise CaseError(f"--format {first}: has a file for each part, and -o - is one file: take another format")
    return StreamDestination(stream, first)


def _with_formats_told(
    report: Mapping[str, Any], mesh: Mesh | SlicedMesh, formats: Sequence[FormatName]
) -> Mapping[str, Any]:
    """The report of a mesh, with warnings of formats that have no place for its partition, or take much memory."""
    if not isinstance(mesh, Mesh):
        return report
    warned, lacking, whole = list[str](), without_partition(formats), whole_only(formats)
    pieces = [name for name in formats if FORMATS[name].piece is not None]
    if mesh.partition is not None and lacking:
        warned.append(f"there is no place for the partition in {', '.join(lacking)}: {PARTITIONED} have one")
    if "parts" in report and len(mesh.points) > LARGE and whole:
        warned.append(f"{', '.join(whole)}: written from the whole mesh in memory: {SLICED} are written part by part")
    if "parts" in report and mesh.partition is None and pieces:
        reasons = [*report["parts"]["joined_for"], *whole]
        warned.append(
            f"{', '.join(pieces)}: in one piece, since the whole mesh is needed for {', '.join(reasons)}: leave that "
            "to another run, or set output.partition"
        )
    return {**report, "warnings": [*report["warnings"], *warned]} if warned else report


def _page(result: Result | SlicedResult, report: Mapping[str, Any]) -> str:
    """The page of a run whose report is as written; of a mesh in slices it shows a sample, and the whole spacing."""
    from bubblemesh.pages.report import Overview, report_page

    now = datetime.now().astimezone()
    if isinstance(result, Result):
        return report_page(result.mesh, result.fields, report, result.speeds, now)
    from bubblemesh.run.assembly import previewed

    extremes = result.problem.packing_extremes
    overview = Overview(*previewed(result.problem), (extremes[:2], extremes[2:]))
    sample, fields = result.mesh.sample(SAMPLE, "quality")
    return report_page(sample, fields, report, result.speeds, now, overview)


def _distinct(formats: tuple[FormatName, ...]) -> tuple[FormatName, ...]:
    """Check that no two formats would be the same file."""
    for name in formats:
        if formats.count(name) > 1:
            raise FileError(f"output.formats: {name} is named twice, and both would be the same file: name it once")
    return formats


def _is_file(output: str) -> bool:
    path = Path(output)
    is_folder = output.endswith("/") or isdir(path)  # noqa: PTH112 - the method of paths fails for too long a name
    return (path.suffix != "" or path.name.startswith(".")) and not is_folder


def _format_of(path: Path, requested: tuple[FormatName, ...], liked: tuple[FormatName, ...]) -> FormatName:
    """The format of a file by its ending: one of those asked for, else one that the case names, else any."""
    fitting = formats_by_ending(path.name)
    if not fitting:
        raise unknown_ending(f"-o {path}", "; the name of a folder ends with a slash")
    if requested:
        both = [name for name in fitting if name in requested]
        if not both:
            option = f"--format or --for asks for {' or '.join(requested)}"
            raise CaseError(f"-o {path}: its ending asks for {fitting[0]}, {option}: drop one of them")
        return both[0]
    return next((name for name in fitting if name in liked), fitting[0])
