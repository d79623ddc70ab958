"""What commands that write meshes share: the mesh is made, written and shown."""

from pathlib import Path
from typing import TYPE_CHECKING

from bubblemesh.cli.exits import heed
from bubblemesh.cli.stdio import write_json

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from bubblemesh.case import Case, Output
    from bubblemesh.run.destination import Destination, StreamDestination
    from bubblemesh.run.mesh_file import MeshOfFile
    from bubblemesh.run.output import OutputOptions
    from bubblemesh.run.writing import Meshing


def mesh_and_show(
    meshing: "Meshing",
    case: "Case",
    source: str,
    place: "Destination | StreamDestination",
    as_json: bool,
    quiet: bool,
) -> None:
    """Mesh a case and write the result, with the progress and the report on the terminal.

    If the mesh is not what the case requires, that is raised in the end.
    """
    from bubblemesh.console.run import PackingProgress
    from bubblemesh.run.writing import mesh_and_write

    progress = PackingProgress(f"packing {case.name}", quiet, heed)
    result, report = mesh_and_write(meshing, case, source, place, progress)
    show_written(report, place, as_json, quiet)
    if result.verdict is not None:
        raise result.verdict


def write_again(
    path: Path, read: "MeshOfFile", keys: "Output", options: "OutputOptions", as_json: bool, quiet: bool
) -> None:
    """Write the mesh of a file where and as the options say over the keys, and show what was written."""
    from bubblemesh.meshfiles.sources.table import files_beside
    from bubblemesh.run.output import destination_beside, stream_destination

    place = (
        destination_beside([path, *files_beside(path)], keys, Path(), read.name, options)
        if options.stream is None
        else stream_destination(keys, options.stream, options)
    )
    show_written(place.write(read.mesh, read.fields, read.report), place, as_json, quiet)


def show_written(
    report: "Mapping[str, Any]", place: "Destination | StreamDestination", as_json: bool, quiet: bool
) -> None:
    """Print the warnings on a written mesh, and its report: as JSON, or its quality and files on the terminal."""
    from bubblemesh import console
    from bubblemesh.console.report import show_files, show_quality
    from bubblemesh.run.destination import Destination

    if as_json:
        write_json(report)
    if not quiet:
        show_quality(report, console.terminal)
        if isinstance(place, Destination):
            show_files(str(place.folder), report["files"])
    console.warn(report["warnings"])
