"""The command line. A command loads only the parts of the package that it needs, when it runs."""

from typing import Annotated

import typer

from bubblemesh import __version__
from bubblemesh.cli import adapt, batch, check, convert, partition, plot, quality, run, templates
from bubblemesh.cli.exits import Commands, reported, reporting, signals_obeyed
from bubblemesh.cli.stdio import expendable_messages, write_output

__all__ = ["app", "main"]

app = typer.Typer(
    cls=Commands,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)
for command in (
    *(run.run, adapt.adapt, batch.batch, check.check),
    *(quality.quality, plot.plot, convert.convert, partition.partition),
    *(templates.schema, templates.init),
):
    app.command()(reporting(command))


@app.callback(invoke_without_command=True)
def bubblemesh(
    version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
) -> None:
    """Triangle meshes by bubble packing, from a YAML case file to solver-ready files."""
    if version:
        from bubblemesh.kernels.library import engine

        with reported():
            write_output(f"{__version__} (kernels: {engine()})\n")
        raise typer.Exit


def main() -> None:
    """Run the command."""
    expendable_messages()
    with signals_obeyed():
        app(prog_name="bubblemesh")  # the name that shells complete, also with python -m
