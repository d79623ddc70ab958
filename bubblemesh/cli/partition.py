"""The command `partition`: to divide a mesh file for a parallel solver."""

from typing import Annotated

import typer

from bubblemesh.cli.options import AsJson, FormatsNamed, MeshPath, Output, Quiet, SolversNamed
from bubblemesh.cli.stdio import mesh_stream
from bubblemesh.cli.writing import write_again


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
    from bubblemesh.run.mesh_file import divided_mesh_of_file
    from bubblemesh.run.output import OutputOptions

    stream = mesh_stream(output, as_json)
    options = OutputOptions(output, formats or (), solvers or (), stream=stream)
    write_again(mesh, divided_mesh_of_file(mesh, parts), OutputKeys(partition=parts), options, as_json, quiet)
