"""The command `convert`: to write the mesh of a file in another format."""

from typing import Annotated

import typer

from bubblemesh.cli.options import AsJson, FormatsNamed, MeshPath, Quiet, SolversNamed
from bubblemesh.cli.stdio import mesh_stream
from bubblemesh.cli.writing import write_again

TO = "File to write, its format by its ending; a folder, with --format or --for; or - for the standard output."


def convert(
    mesh: MeshPath,
    to: Annotated[str, typer.Argument(metavar="TO", help=TO)],
    formats: FormatsNamed = None,
    solvers: SolversNamed = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Write the mesh of a file in another format, with its labels and regions."""
    from bubblemesh.case import Output
    from bubblemesh.run.mesh_file import mesh_of_file
    from bubblemesh.run.output import OutputOptions

    stream = mesh_stream(to, as_json)
    options = OutputOptions(to, formats or (), solvers or (), stream=stream)
    write_again(mesh, mesh_of_file(mesh), Output(), options, as_json, quiet)
