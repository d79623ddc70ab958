"""Commands that help to write case files."""

from pathlib import Path
from typing import Annotated

import typer

from bubblemesh.cli.stdio import write_new, write_output


def schema() -> None:
    """Print the JSON Schema of the case file."""
    from bubblemesh.case.models import case_schema
    from bubblemesh.meshfiles.text import json_text

    write_output(json_text(case_schema()))


def init(
    path: Annotated[str, typer.Argument(metavar="[CASE]", help="File to write, or - for the standard output.")] = (
        "case.yaml"
    ),
) -> None:
    """Write a commented case file to start from."""
    from bubblemesh.case.models import case_template

    if path == "-":
        write_output(case_template())
        return
    write_new(Path(path), case_template())
    typer.echo(f"{path} written: run it with  bubblemesh run {path}", err=True)
