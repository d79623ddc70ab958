"""The command `partition`: to divide a mesh file for a parallel solver."""

from pathlib import Path
from typing import Annotated

import typer

from bubblemesh.cli.delivery import show_written
from bubblemesh.cli.options import AsJson, FormatsNamed, MeshPath, Output, Quiet, SolversNamed
from bubblemesh.cli.stdio import mesh_stream


def partition(
    mesh: MeshPath,
    parts: Annotated[int, typer.Argument(metavar="N", help="Number of parts, one for each process of the solver.")],
    output: Output = None,
    formats: FormatsNamed = None,
    solvers: SolversNamed = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Divide a mesh into parts for a parallel solver, and write it with the part of each triangle and node."""
    from bubblemesh.case import Output as OutputKeys
    from bubblemesh.meshfiles.companions import files_beside
    from bubblemesh.run.division import divided_file
    from bubblemesh.run.output import OutputOptions, destination_beside, stream_destination

    mesh_file = divided_file(mesh, parts)
    stream, keys = mesh_stream(output, as_json), OutputKeys(partition=parts)
    options = OutputOptions(output, formats or (), solvers or (), stream=stream)
    place = (
        stream_destination(keys, stream, options)
        if stream is not None
        else destination_beside([mesh, *files_beside(mesh)], keys, Path(), f"{mesh_file.name}-{parts}", options)
    )
    report = place.write(mesh_file.mesh, mesh_file.fields, mesh_file.report)
    show_written(report, place, as_json, quiet)
