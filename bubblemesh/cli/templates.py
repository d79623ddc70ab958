"""The commands `init` and `schema`, for those who write case files."""

from pathlib import Path
from typing import Annotated

import typer

from bubblemesh.cli.stdio import write_json, write_new, write_output


def schema() -> None:
    """Print the JSON Schema of the case file."""
    from bubblemesh.case.models import case_schema

    write_json(case_schema())


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
    from bubblemesh import console

    write_new(Path(path), case_template())
    console.tell(f"{path} written: run it with  bubblemesh run {path}")
    console.tell("for editors that complete its keys:  bubblemesh schema > bubblemesh.schema.json")
