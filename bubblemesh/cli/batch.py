"""The command `batch`: to mesh many cases."""

from typing import Annotated

import typer

from bubblemesh.cli.check import show_previews
from bubblemesh.cli.exits import heed
from bubblemesh.cli.options import (
    Cluster,
    FormatsNamed,
    Jobs,
    Overrides,
    Quiet,
    SolversNamed,
    Untrusted,
    with_overrides,
)
from bubblemesh.cli.stdio import write_json


@with_overrides
def batch(
    paths: Annotated[list[str], typer.Argument(metavar="PATH...", help="Case files, folders or patterns of them.")],
    output: Annotated[
        str | None, typer.Option("--output", "-o", metavar="DIR", help="Folder of all results and the summary.")
    ] = None,
    jobs: Jobs = None,
    resume: Annotated[bool, typer.Option("--resume", help="Keep results whose inputs have not changed.")] = False,
    shard: Annotated[str, typer.Option("--shard", metavar="I/N", help="Mesh part I of N, for job arrays.")] = "1/1",
    cluster: Cluster = None,
    formats: FormatsNamed = None,
    solvers: SolversNamed = None,
    overrides: Overrides = (),
    untrusted: Untrusted = False,
    page: Annotated[
        bool | None,
        typer.Option("--report/--no-report", help="Write a page for each case, and index.html to compare them."),
    ] = None,
    history: Annotated[
        bool,
        typer.Option(
            "--history", help="Write tables of the rounds and steps of each case, and one picture of them all."
        ),
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the summary as JSON on the standard output.")] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Check the cases and tell what would be meshed only.")
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Mesh many cases; one that fails is a row of the summary."""
    from bubblemesh import batch as many
    from bubblemesh.console.batch import BatchProgress
    from bubblemesh.run.output import OutputOptions
    from bubblemesh.workers.hire import workers_at

    overrides = [*overrides, *OutputOptions(None, formats or (), solvers or ()).over_cases()]
    options = many.BatchOptions(overrides, output, page, history, many.parse_shard(shard), untrusted, resume)
    workers = workers_at(jobs, cluster)
    entries = many.plan_cases(many.case_files(paths), options)
    if dry_run:
        show_previews(options.part_of(entries), as_json, quiet)
        return
    with BatchProgress(quiet, heed) as progress:
        totals = many.run_batch(entries, options, workers, progress)
    if as_json:
        write_json(totals)
    raise typer.Exit(totals["exit_code"])
