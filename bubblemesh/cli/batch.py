"""The command that meshes many cases."""

from typing import Annotated

import typer

from bubblemesh.cli.options import CASE_OPTIONS, PACKING_OPTIONS, Overrides, Quiet, with_overrides
from bubblemesh.cli.stdio import write_output


@with_overrides(CASE_OPTIONS, PACKING_OPTIONS)
def batch(
    paths: Annotated[list[str], typer.Argument(metavar="PATH...", help="Case files, folders or patterns of them.")],
    output: Annotated[
        str | None, typer.Option("--output", "-o", metavar="DIR", help="Folder of all results and the summary.")
    ] = None,
    jobs: Annotated[
        int | None, typer.Option("--jobs", "-j", metavar="N", min=1, help="Worker processes; else one for each core.")
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Keep results whose inputs have not changed.")] = False,
    shard: Annotated[str, typer.Option("--shard", metavar="I/N", help="Mesh part I of N, for job arrays.")] = "1/1",
    cluster: Annotated[
        str | None, typer.Option("--cluster", metavar="ADDRESS", help="Dask scheduler whose workers mesh the cases.")
    ] = None,
    overrides: Overrides = (),
    page: Annotated[
        bool | None,
        typer.Option("--report/--no-report", help="Write a page for each case, and index.html to compare them."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the summary as JSON on the standard output.")] = False,
    quiet: Quiet = False,
) -> None:
    """Mesh many cases; one that fails is a row of the summary."""
    from bubblemesh import batch as many
    from bubblemesh.console.batch import BatchProgress
    from bubblemesh.meshfiles.text import json_text

    options = many.BatchOptions(overrides, output, page, many.parse_shard(shard), resume)
    workers = many.workers_at(jobs, cluster)
    entries = many.plan_cases(many.case_files(paths), options)
    with BatchProgress(quiet) as progress:
        totals = many.run_batch(entries, options, workers, progress)
    if as_json:
        write_output(json_text(totals))
    raise typer.Exit(totals["exit_code"])
