"""Writes the files of a run together."""

import shutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import Any, BinaryIO

from bubblemesh.files import temporary_folder, unwritten
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.metric import measures_of
from bubblemesh.meshes.slices import SlicedMesh
from bubblemesh.meshfiles.formats import format_named, require_order
from bubblemesh.meshfiles.groups import LABELS_FILE, Fields, labels_text
from bubblemesh.meshfiles.mesh_files import MeshFiles
from bubblemesh.meshfiles.names import kept_spellings
from bubblemesh.meshfiles.text import json_text, write_text
from bubblemesh.meshfiles.transaction import transaction
from bubblemesh.process.watchdog import enter

REPORT_FILE, PAGE_FILE = ".report.json", ".html"
Page = Callable[[Mapping[str, Any]], str]
NO_TABLES: Mapping[str, str] = {}


def write_files(
    mesh: Mesh | SlicedMesh,
    fields: Fields,
    report: Mapping[str, Any],
    into: MeshFiles,
    tables: Mapping[str, str] = NO_TABLES,
    page: Page | None = None,
) -> dict[str, Any]:
    """Write a mesh in several formats, and the report, all of them or none.

    NAME.labels.json has the ids of all names, if a format has no names or spells them differently, and the labelled
    points and periodic sides, if a format cannot hold them. Files of the name in other formats keep their spellings.

    Parameters
    ----------
    mesh, fields
        The fields are ``quality`` and ``target_spacing`` of each triangle. A mesh in slices, which only some formats
        accept, has its own fields.
    report : mapping
        Written to NAME.report.json, and returned, with the names of all files, relative to the folder, under ``files``,
        and the time of writing the meshes under ``seconds``.
    into
        The folder, the name and the formats.
    tables : mapping of str to str
        Texts of further files, by the ends of their names.
    page : callable, optional
        Makes the text of NAME.html from the report, which does not have the time for this yet.

    Raises
    ------
    CaseError
        If a format is unknown or cannot hold triangles of this order, or the name cannot be that of a file.
    FileError
        If a file cannot be written, or two of them would have the same name.
    """
    frame = mesh.frame if isinstance(mesh, SlicedMesh) else mesh
    require_order(into.formats, frame.order)
    texts = {**tables, **_labels(frame, into), **_beside(frame, into.formats)}
    names = into.file_names(_parts(mesh), [*texts, *([PAGE_FILE] if page else []), REPORT_FILE])
    into.require_distinct(names)
    begun = perf_counter()
    enter("writing")
    with transaction(into.folder, lasting=into.lasting) as staging:
        _write(mesh, fields, replace(into, folder=staging), texts)
        written = _completed(report, names, "writing", perf_counter() - begun)
        if page is not None:
            begun = perf_counter()
            write_text(staging / f"{into.name}{PAGE_FILE}", [page(written)])
            written = _completed(written, names, "page", perf_counter() - begun)
        write_text(staging / names[-1], [json_text(written)])
    return written


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
    return write_files(mesh, fields, report, MeshFiles.at(path))


def write_alone(mesh: Mesh, fields: Fields, path: Path) -> list[str]:
    """Write a mesh in the format of the path's ending without a report or labels, and return the names of its files.

    The same errors as `write_files`.
    """
    into = MeshFiles.at(path)
    require_order(into.formats, mesh.order)
    texts = _beside(mesh, into.formats)
    names = into.file_names(_parts(mesh), texts)
    enter("writing")
    with transaction(into.folder) as staging:
        _write(mesh, fields, replace(into, folder=staging), texts)
    return names


def _write(mesh: Mesh | SlicedMesh, fields: Fields, into: MeshFiles, texts: Mapping[str, str]) -> None:
    """Write a mesh in all formats, and texts by the ends of their names, to a folder that is there."""
    for form, stem in into.stems:
        path = into.folder / f"{stem}{form.files[0]}"
        if isinstance(mesh, SlicedMesh):
            form.write_slices(mesh, path)
        else:
            form.write(mesh, fields, path)
    if into.ending is not None:  # of a single mesh file; files beside it keep theirs, as it may refer to them
        path.rename(into.folder / f"{into.name}{into.ending}")
    for end, text in texts.items():
        write_text(into.folder / f"{into.name}{end}", [text])


def _parts(mesh: Mesh | SlicedMesh) -> int:
    if isinstance(mesh, SlicedMesh):
        return len(mesh.sizes)
    return 1 if mesh.partition is None else mesh.partition.count


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


def _beside(mesh: Mesh, formats: Iterable[str]) -> dict[str, str]:
    """Texts of the files that a mesh needs beside those of the formats, by the ends of their names."""
    return {end: text for form in formats for end, text in format_named(form).text_beside(mesh).items()}


def _labels(mesh: Mesh, into: MeshFiles) -> dict[str, str]:
    """Text of the sidecar with the ids of all names, by the end of its name, if a format needs it.

    It also has the spellings of files in other formats that were written before, with the same name.
    """
    table = {form: format_named(form) for form in into.formats}
    spellings = {name: form.names(mesh) for name, form in table.items()}
    complete = all(form.holds_all_of(mesh) for form in table.values())
    kept = kept_spellings(into.folder, into.name, into.formats)
    text = labels_text(mesh, spellings, complete=complete, kept=kept)
    return {} if text is None else {LABELS_FILE: text}


def _completed(report: Mapping[str, Any], files: Sequence[str], stage: str, time: float) -> dict[str, Any]:
    """The report with the time of a stage and the names of all files."""
    seconds = dict(report.get("seconds", {}))
    total = seconds.pop("total", 0.0) + time
    return {**report, "seconds": {**seconds, stage: time, "total": total}, "files": list(files)}
