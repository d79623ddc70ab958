"""Writes the files of a run together."""

import shutil
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any, BinaryIO

from bubblemesh.errors import CaseError, FileError
from bubblemesh.files import LONGEST_FILE_NAME, bytes_of_name, temporary_folder, unwritten
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.metric import measures_of
from bubblemesh.meshes.slices import SlicedMesh
from bubblemesh.meshfiles.formats import (
    format_named,
    formats_by_ending,
    require_order,
    stem_of,
    stems,
    unknown_ending,
)
from bubblemesh.meshfiles.groups import LABELS_FILE, Fields, labels_text
from bubblemesh.meshfiles.text import json_text, write_text
from bubblemesh.meshfiles.transaction import transaction
from bubblemesh.messages import shown
from bubblemesh.process.limits import enter

_REPORT = ".report.json"
MEDIT, METRIC_FILE = "mesh", ".sol"
PAGE_FILE = ".html"
Page = Callable[[Mapping[str, Any]], str]
NO_TABLES: Mapping[str, str] = {}


def write_files(
    mesh: Mesh | SlicedMesh,
    fields: Fields,
    report: Mapping[str, Any],
    folder: Path,
    name: str,
    formats: Sequence[str],
    tables: Mapping[str, str] = NO_TABLES,
    page: Page | None = None,
    *,
    ending: str | None = None,
    lasting: bool = True,
) -> dict[str, Any]:
    """Write a mesh in several formats, and the report, all of them or none.

    NAME.labels.json has the ids of all names, if a format has no names or spells them differently, and the labelled
    points and periodic sides, if a format cannot hold them. NAME.sol has the metric of a mesh, beside NAME.mesh.

    Parameters
    ----------
    mesh, fields
        The fields are ``quality`` and ``target_spacing`` of each triangle. A mesh in slices, which only some formats
        accept, has its own fields.
    report : mapping
        Written to NAME.report.json, and returned, with the names of all files, relative to the folder, under ``files``,
        and the time of writing the meshes under ``seconds``.
    folder, name, formats
        The folder is made if it is missing. Formats are keys of ``FORMATS``; if two have the same ending, the second
        one is written to NAME.FORMAT.ENDING.
    tables : mapping of str to str
        Texts of further files, by the ends of their names.
    page : callable, optional
        Makes the text of NAME.html from the report, which does not have the time for this yet.
    ending : str, optional
        Ending of the first file, if it is spelled differently from its format's, as in NAME.MSH.
    lasting : bool
        Whether the files must survive a power cut; files that are read at once need not.

    Raises
    ------
    CaseError
        If a format is unknown or cannot hold triangles of this order, or the name cannot be that of a file.
    FileError
        If a file cannot be written, or two of them would have the same name.
    """
    frame = mesh.frame if isinstance(mesh, SlicedMesh) else mesh
    require_order(formats, frame.order)
    labels = _labels(frame, formats)
    tables = {**tables, **({} if labels is None else {LABELS_FILE: labels}), **_metric(frame, formats)}
    files = file_names(name, formats, (*tables, *([PAGE_FILE] if page else [])), _parts(mesh), ending)
    _check_distinct(files, folder)
    begun = perf_counter()
    enter("writing")
    with transaction(folder, lasting=lasting) as staging:
        for form, stem in stems(name, formats):
            path = staging / f"{stem}{format_named(form).files[0]}"
            if isinstance(mesh, SlicedMesh):
                format_named(form).write_slices(mesh, path)
            else:
                format_named(form).write(mesh, fields, path)
        _spell(staging, name, formats[0], ending)
        _write_tables(tables, staging, name)
        written = _completed(report, files, "writing", perf_counter() - begun)
        if page is not None:
            begun = perf_counter()
            write_text(staging / f"{name}{PAGE_FILE}", [page(written)])
            written = _completed(written, files, "page", perf_counter() - begun)
        write_text(staging / files[-1], [json_text(written)])
    return written


def file_names(name: str, formats: Sequence[str], tables: Iterable[str], parts: int, ending: str | None) -> list[str]:
    """Names of all files of a mesh with a number of parts, the report last; CaseError for an impossible name or format.

    The first file may have its own ``ending``.
    """
    meshes = [stem + end for form, stem in stems(name, formats) for end in format_named(form).ends(parts)]
    meshes[:1] = meshes[:1] if ending is None else [name + ending]
    return _checked(name, [*meshes, *(name + end for end in (*tables, _REPORT))])


def write_mesh(mesh: Mesh, path: Path, *, sidecars: bool) -> list[str]:
    """Write a mesh with its fields and its quality, and return the names of the files; see `Mesh.write`."""
    measures = measures_of(mesh.points, mesh.triangles[:, :3], mesh.fields)
    fields = {**mesh.fields, "quality": measures.radius_ratios}
    if not sidecars:
        return write_alone(mesh, fields, path)
    figures = {"nodes": len(mesh.points), "triangles": len(mesh.triangles), "quality": mesh.quality()}
    return list(write_file(mesh, fields, figures, path)["files"])


def write_file(mesh: Mesh, fields: Fields, report: Mapping[str, Any], path: Path) -> dict[str, Any]:
    """Write a mesh in the format of the path's ending, and STEM.report.json beside it, as `write_files` does."""
    form, stem = _form_at(path)
    return write_files(mesh, fields, report, path.parent, stem, [form], ending=path.name.removeprefix(stem))


def write_alone(mesh: Mesh, fields: Fields, path: Path) -> list[str]:
    """Write a mesh in the format of the path's ending without a report or labels, and return the names of its files.

    The same errors as `write_files`.
    """
    form, stem = _form_at(path)
    require_order([form], mesh.order)
    metric = _metric(mesh, [form])
    files = _checked(stem, [stem + end for end in (*format_named(form).ends(_parts(mesh)), *metric)])
    enter("writing")
    with transaction(path.parent) as staging:
        format_named(form).write(mesh, fields, staging / files[0])
        ending = path.name.removeprefix(stem)
        _spell(staging, stem, form, ending)
        _write_tables(metric, staging, stem)
    return [stem + ending, *files[1:]]


def _spell(folder: Path, name: str, form: str, ending: str | None) -> None:
    """Give the first file of a format the requested ending; other files keep theirs, as the first may refer to them."""
    usual = format_named(form).files[0]
    if ending not in (None, usual):
        (folder / f"{name}{usual}").rename(folder / f"{name}{ending}")


def _write_tables(tables: Mapping[str, str], folder: Path, name: str) -> None:
    for end, text in tables.items():
        write_text(folder / f"{name}{end}", [text])


def _parts(mesh: Mesh | SlicedMesh) -> int:
    if isinstance(mesh, SlicedMesh):
        return len(mesh.sizes)
    return 1 if mesh.partition is None else mesh.partition.count


def _form_at(path: Path) -> tuple[str, str]:
    """Format by the ending of a path, and the name before that; CaseError for an unknown ending."""
    formats = formats_by_ending(path.name)
    if not formats:
        raise unknown_ending(str(path))
    return formats[0], stem_of(path.name, formats[0])


def write_stream(mesh: Mesh, fields: Fields, format: str, stream: BinaryIO) -> None:
    """Write a mesh to a binary stream; of a format with several files, only the triangles are written.

    The same errors as `write_files`, but BrokenPipeError if the reader of the stream has gone.
    """
    enter("writing")
    form = format_named(format)
    require_order([format], mesh.order)
    try:
        with temporary_folder() as folder:
            path = Path(folder, f"mesh{form.files[0]}")
            form.write(mesh, fields, path, alone=True)
            with path.open("rb") as source:
                shutil.copyfileobj(source, stream)
        stream.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        raise unwritten("the mesh to the output stream", error) from error


def _metric(mesh: Mesh, formats: Sequence[str]) -> dict[str, str]:
    """Text of the file beside Medit's with the metric of a mesh, by the end of its name, if there is one."""
    if MEDIT not in formats or len(mesh.metric) == 0:
        return {}
    from bubblemesh.meshfiles.write.fem import medit_metric

    return {METRIC_FILE: medit_metric(mesh)}


def _labels(mesh: Mesh, formats: Sequence[str]) -> str | None:
    """Text of the sidecar with the ids of all names, if a format needs it."""
    table = {form: format_named(form) for form in formats}
    spellings = {name: form.names(mesh) for name, form in table.items()}
    return labels_text(mesh, spellings, complete=all(form.holds_all_of(mesh) for form in table.values()))


def _completed(report: Mapping[str, Any], files: Sequence[str], stage: str, time: float) -> dict[str, Any]:
    """The report with the time of a stage and the names of all files."""
    seconds = dict(report.get("seconds", {}))
    total = seconds.pop("total", 0.0) + time
    return {**report, "seconds": {**seconds, stage: time, "total": total}, "files": list(files)}


def _checked(name: str, files: list[str]) -> list[str]:
    """The files of a name; CaseError if it cannot be that of a file, or is too long for one of them."""
    if not name.isprintable() or name in {"", ".", ".."} or "/" in name or "\\" in name:
        raise CaseError(f"{name!r} cannot be the name of a file; use a name without slashes")
    longest = max(files, key=bytes_of_name)
    if bytes_of_name(longest) > LONGEST_FILE_NAME:
        size = f"with {longest.removeprefix(name)} it has {bytes_of_name(longest)} bytes"
        raise CaseError(f"{shown(repr(name))} is too long a name: {size}, files up to {LONGEST_FILE_NAME}: shorten it")
    return files


def _check_distinct(files: Sequence[str], folder: Path) -> None:
    repeated = [file for file, count in Counter(files).items() if count > 1]
    if repeated:
        raise FileError(f"{folder / repeated[0]}: more than one output would have this name; name each format once")
