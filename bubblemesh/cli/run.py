"""The command `run`: to mesh a case."""

from contextlib import ExitStack
from typing import TYPE_CHECKING, Annotated

import typer

from bubblemesh.cli.check import show_preview
from bubblemesh.cli.options import (
    AsJson,
    CaseFile,
    Cluster,
    FormatsNamed,
    Jobs,
    Output,
    Overrides,
    Picture,
    Quiet,
    SolversNamed,
    Untrusted,
    case_at,
    with_overrides,
)
from bubblemesh.cli.stdio import mesh_stream
from bubblemesh.cli.writing import mesh_and_show
from bubblemesh.errors import CaseError
from bubblemesh.workers.choice import crew_for

if TYPE_CHECKING:
    from bubblemesh.run.packing import OnRound, OnShare
    from bubblemesh.run.pipeline import Result, SlicedResult


@with_overrides
def run(
    case: CaseFile,
    output: Output = None,
    formats: FormatsNamed = None,
    solvers: SolversNamed = None,
    overrides: Overrides = (),
    untrusted: Untrusted = False,
    as_json: AsJson = False,
    history: Annotated[
        bool, typer.Option("--history", help="Write tables of all rounds, and of the mean speed in all steps, as CSV.")
    ] = False,
    page: Annotated[
        bool | None, typer.Option("--report/--no-report", help="Write a page to look at, NAME.html, over the case's.")
    ] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Check the case and estimate the mesh only.")] = False,
    picture: Picture = None,
    jobs: Jobs = None,
    cluster: Cluster = None,
    resume: Annotated[
        bool,
        typer.Option("--resume", help="Keep parts as they are done, and go on with those of a run that was ended."),
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Mesh a case and write the mesh files and a report."""
    if picture is not None and not dry_run:
        raise CaseError("--plot: draws the spacing of a dry run: add --dry-run, or draw the mesh by bubblemesh plot")
    loaded = case_at(case, overrides, untrusted)
    # Workers start while the rest is loaded here; the folder of parts, to which they write, is removed after they end.
    memory_mb = loaded.limits.max_memory_mb
    hired = crew_for(loaded.parts, jobs, cluster, warn, at_once=not dry_run, memory_mb=memory_mb)
    with ExitStack() as outlasting, hired as crew:
        from bubblemesh.run import pipeline
        from bubblemesh.run.output import OutputOptions, place_of
        from bubblemesh.run.packing import RunOptions
        from bubblemesh.run.part_store import parts_kept

        stream = mesh_stream(output, as_json)
        options = OutputOptions(output, formats or (), solvers or (), history, page, stream)
        place = place_of(loaded, case, options, in_slices=True)
        shown = options.over(loaded)
        if dry_run:
            show_preview(shown, case, picture, as_json, quiet)
            return
        keeping = outlasting.enter_context(parts_kept(loaded, place, resume, shared=cluster is None))

        def meshing(on_round: "OnRound", on_share: "OnShare") -> "Result | SlicedResult":
            return pipeline.run_case(shown, RunOptions(on_round, on_share, crew, keeping))

        mesh_and_show(meshing, loaded, case, place, as_json, quiet)


def warn(message: str) -> None:
    """Print a warning on workers."""
    from bubblemesh import console

    console.warn([message])
