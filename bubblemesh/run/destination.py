"""Destination of the products of a run: a folder, one file, or a stream."""

from collections.abc import Iterator, Mapping, Sequence
from datetime import datetime
from functools import cached_property, partial
from typing import Any, BinaryIO

from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.slices import SlicedMesh
from bubblemesh.meshfiles.formats import (
    FORMATS,
    FormatName,
    whole_only,
    without_partition,
)
from bubblemesh.meshfiles.groups import LABELS_FILE, Fields
from bubblemesh.meshfiles.mesh_files import MeshFiles
from bubblemesh.meshfiles.text import HISTORY_FILES, history_tables
from bubblemesh.meshfiles.transaction import require_writable
from bubblemesh.meshfiles.writing import (
    NO_TABLES,
    PAGE_FILE,
    REPORT_FILE,
    Page,
    write_files,
    write_stream,
)
from bubblemesh.messages import counted
from bubblemesh.records import record
from bubblemesh.run.pipeline import Result, SlicedResult

PARTITIONED = ", ".join(name for name, form in FORMATS.items() if form.partition)
SLICED = ", ".join(name for name, form in FORMATS.items() if form.slices)
LARGE = 1_000_000  # nodes
SAMPLE = 20_000  # triangles on the page of a mesh in slices


@record
class Destination(MeshFiles):
    """Folder, names and kinds of the files to write of a run."""

    history: bool = False  # whether tables of all rounds and steps are written too
    page: bool = False  # whether a page to look at is written too
    parts: int = 1  # of the mesh, at most

    @cached_property
    def names(self) -> list[str]:
        """Names of all files that may be written into the folder."""
        tables = [LABELS_FILE, *(HISTORY_FILES if self.history else ()), *([PAGE_FILE] if self.page else ())]
        beside = [form.beside.end for form, _ in self.stems if form.beside is not None]
        return self.file_names(self.parts, [*tables, *beside, REPORT_FILE])

    def require_writable(self) -> None:
        """Check that the files can be written, before the work; else it is a FileError."""
        require_writable(self.folder, self.names)

    def load(self) -> None:
        """Load what writes the formats."""
        for name in self.formats:
            FORMATS[name].load()

    def write_result(self, result: Result | SlicedResult) -> dict[str, Any]:
        """Write the mesh and the report, and return the report as written.

        If that is a FileError, no file is written, and old ones stay.
        """
        tables = history_tables(result.report["rounds"], result.speeds) if self.history else {}
        page = partial(_page, result) if self.page else None
        return self.write(result.mesh, result.fields, result.report, tables, page)

    def write(
        self,
        mesh: Mesh | SlicedMesh,
        fields: Fields,
        report: Mapping[str, Any],
        tables: Mapping[str, str] = NO_TABLES,
        page: Page | None = None,
    ) -> dict[str, Any]:
        """Write a mesh and a report of it, as `write_result` those of a run; see `write_files`."""
        told = _with_formats_told(report, mesh, self.formats)
        return write_files(mesh, fields, told, self, tables, page)


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

    def write_result(self, result: Result | SlicedResult) -> dict[str, Any]:
        """Write the mesh, and return the report, which has no files; a FileError if that cannot be done."""
        assert isinstance(result, Result)  # slices are kept beside files
        return self.write(result.mesh, result.fields, result.report)

    def write(self, mesh: Mesh, fields: Fields, report: Mapping[str, Any]) -> dict[str, Any]:
        """Write a mesh, as `write_result` that of a run."""
        write_stream(mesh, fields, self.format_name, self.stream)
        return {**_with_formats_told(report, mesh, [self.format_name]), "files": []}


def _with_formats_told(
    report: Mapping[str, Any], mesh: Mesh | SlicedMesh, formats: Sequence[FormatName]
) -> Mapping[str, Any]:
    """The report of a mesh, with warnings of formats: of names, no place for its partition, and much memory."""
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
    warned += _taken_names(mesh, formats)
    return {**report, "warnings": [*report["warnings"], *warned]} if warned else report


def _taken_names(mesh: Mesh, formats: Sequence[FormatName]) -> Iterator[str]:
    """Warnings of groups that formats call by other names, while other groups have theirs there, but for capitals."""
    for form in formats:
        words = FORMATS[form].names(mesh) or {}
        owners = {word.casefold(): name for name, word in words.items()}
        taken = [name for name, word in words.items() if word != name and owners.get(name.casefold(), name) != name]
        if taken:
            name = min(taken, key=len)  # rather than that of its rim
            more = f", and {counted(len(taken) - 1, 'more name')}" if len(taken) > 1 else ""
            yield (
                f"{form}: {name!r} is called {words[name]!r} there, since {owners[name.casefold()]!r} has this name in "
                f"the format{more}: give them names that differ by more"
            )


def _page(result: Result | SlicedResult, report: Mapping[str, Any]) -> str:
    """The page of a run whose report is as written; of a mesh in slices it shows a sample, and the whole spacing."""
    from bubblemesh.pages.report import Overview, report_page

    now = datetime.now().astimezone()
    if isinstance(result, Result):
        return report_page(result.mesh, result.fields, report, result.speeds, now)
    from bubblemesh.run.assembly import previewed

    overview = Overview(*previewed(result.problem), result.problem.packing_extremes.both)
    sample, fields = result.mesh.sample(SAMPLE, "quality")
    return report_page(sample, fields, report, result.speeds, now, overview)
