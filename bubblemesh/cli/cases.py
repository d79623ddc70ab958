"""Commands on cases: to mesh one or many, to estimate what that would take, and to write one."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, ExitStack, nullcontext
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bubblemesh.cli.exits import heed
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
    with_overrides,
)
from bubblemesh.cli.stdio import mesh_stream, read_input, tell_written, write_json, write_new, write_output
from bubblemesh.errors import CaseError, located

if TYPE_CHECKING:
    from bubblemesh.batch import Entry
    from bubblemesh.case import Case
    from bubblemesh.parts.work import Crew
    from bubblemesh.problem.problem import Problem
    from bubblemesh.run.destination import Destination, OutputOptions, StreamDestination
    from bubblemesh.run.packing import OnRound, OnShare
    from bubblemesh.run.pipeline import Result, SlicedResult

PACKING = "bubblemesh.parts.packing"  # what workers call


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
    with ExitStack() as outlasting, crew_for(loaded, jobs, cluster, at_once=not dry_run) as crew:
        from bubblemesh.run import pipeline
        from bubblemesh.run.destination import OutputOptions
        from bubblemesh.run.part_store import parts_kept

        options = OutputOptions(output, formats or (), solvers or (), history, page)
        place = destination_of(loaded, case, options, as_json, in_slices=True)
        told = with_formats(loaded, options)
        if dry_run:
            tell_estimate(told, case, picture, as_json, quiet)
            return
        keeping = outlasting.enter_context(parts_kept(loaded, place, resume, shared=cluster is None))
        meshed = partial(pipeline.mesh_case_in_slices, told, keeping, crew=crew)
        deliver(meshed, loaded, case, place, as_json, quiet)


@with_overrides
def adapt(
    case: CaseFile,
    solution: Annotated[
        Path,
        typer.Option(
            "--solution", metavar="FILE", help="Mesh of the case with the solution at its nodes.", readable=False
        ),
    ],
    field: Annotated[
        str | None, typer.Option("--field", metavar="NAME", help="Name of the solution, if the file has more data.")
    ] = None,
    error: Annotated[
        float | None, typer.Option("--error", metavar="E", help="Wanted error of the gradient, relative: 0.05 is 5 %.")
    ] = None,
    nodes: Annotated[
        int | None, typer.Option("--nodes", metavar="N", help="Wanted number of nodes; by default as many as now.")
    ] = None,
    anisotropic: Annotated[
        bool,
        typer.Option("--anisotropic", help="Sizes that depend on the direction, by the solution's second derivatives."),
    ] = False,
    exact: Annotated[
        str | None, typer.Option("--exact", metavar="EXPR", help="Exact solution in x and y, to check the estimate.")
    ] = None,
    output: Output = None,
    formats: FormatsNamed = None,
    solvers: SolversNamed = None,
    overrides: Overrides = (),
    untrusted: Untrusted = False,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Mesh a case anew as its solution asks for: finer where the estimated error is large, coarser where small."""
    from bubblemesh import console
    from bubblemesh.adaptivity import adapt as adapting
    from bubblemesh.adaptivity.solution import read_solution
    from bubblemesh.run.destination import OutputOptions

    loaded = case_at(case, overrides, untrusted)
    target = adapting.Target(error, nodes, anisotropic, mark="--")
    options = OutputOptions(output, formats or (), solvers or ())
    place = destination_of(loaded, case, options, as_json, solution)

    def adapted() -> None:
        present, notes = read_solution(solution, field, target.called("field"))
        console.warn(notes)
        told = with_formats(loaded, options)
        deliver(partial(adapting.adapted, told, present, target, exact), loaded, case, place, as_json, quiet)

    loaded.within_limits(adapted, f"{case}: ")


@with_overrides
def check(
    case: CaseFile,
    overrides: Overrides = (),
    untrusted: Untrusted = False,
    as_json: AsJson = False,
    quiet: Quiet = False,
    picture: Picture = None,
) -> None:
    """Check a case, or all cases of its sweep: geometry, spacing, and how many nodes it needs."""
    from bubblemesh.case import SweepError, case_variants

    text = read_input() if case == "-" else None
    try:
        loaded = case_at(case, overrides, untrusted, text)
    except SweepError:
        if picture is not None:
            raise CaseError("--plot: draws one case, and this file has a sweep: add --set sweep=null") from None
        from bubblemesh import batch as many

        variants = case_variants(case, overrides=overrides, text=text, untrusted=untrusted)
        entries = many.planned(case, variants, many.BatchOptions(overrides, untrusted=untrusted), text=text)
        tell_previews(entries, as_json, quiet)
    else:
        tell_estimate(loaded, case, picture, as_json, quiet)


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
    from bubblemesh.run.destination import OutputOptions
    from bubblemesh.workers.hire import workers_at

    overrides = [*overrides, *OutputOptions(None, formats or (), solvers or ()).over_cases()]
    options = many.BatchOptions(overrides, output, page, history, many.parse_shard(shard), untrusted, resume)
    workers = workers_at(jobs, cluster)
    entries = many.plan_cases(many.case_files(paths), options)
    if dry_run:
        tell_previews(options.part_of(entries), as_json, quiet)
        return
    with BatchProgress(quiet, heed) as progress:
        totals = many.run_batch(entries, options, workers, progress)
    if as_json:
        write_json(totals)
    raise typer.Exit(totals["exit_code"])


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


def case_at(case: str, overrides: Overrides, untrusted: bool, text: str | None = None) -> "Case":
    """Case of a file, or of the standard input for ``-`` unless its text is given, with the options over it."""
    from bubblemesh.case import load_case

    text = read_input() if case == "-" and text is None else text
    return load_case(case, overrides=overrides, untrusted=untrusted, text=text)


def with_formats(case: "Case", options: "OutputOptions") -> "Case":
    """The case with the formats that the options ask for, if any, as its report shows them."""
    if not options.formats:
        return case
    output = case.output.model_copy(update={"formats": options.formats, "solver": None})
    return case.model_copy(update={"output": output})


def crew_for(case: "Case", jobs: int | None, cluster: str | None, *, at_once: bool) -> "AbstractContextManager[Crew]":
    """Crew that packs the parts of a case: worker processes, here or on a cluster, or this process for one part.

    Worker processes are started ``at_once``, or for the first part.
    """
    if case.parts is None:
        from bubblemesh.parts.work import alone

        given = [option for option, value in (("--jobs", jobs), ("--cluster", cluster)) if value is not None]
        if given:
            raise CaseError(f"{' and '.join(given)}: a mesh in one piece takes one process: add --parts auto")
        return nullcontext(alone)
    from bubblemesh.workers.crew import MANY, crew_of
    from bubblemesh.workers.hire import workers_at

    def warn(message: str) -> None:
        from bubblemesh import console

        console.warn([message])

    # With `parts: auto` one part may be enough, and they start in vain; but who asks for parts mostly has a large mesh.
    ahead = PACKING if at_once and case.parts != 1 else None
    return crew_of(workers_at(jobs, cluster), warn, ahead, MANY if case.parts == "auto" else case.parts)


def destination_of(
    case: "Case",
    source: str,
    options: "OutputOptions",
    as_json: bool,
    solution: Path | None = None,
    *,
    in_slices: bool = False,
) -> "Destination | StreamDestination":
    """Destination of the results, by `destination` and, for the standard output, `mesh_stream`, with their errors."""
    from bubblemesh.run.destination import destination, require_fitting_coordinates, stream_destination

    if options.output != "-":
        return destination(case, source, options, solution, in_slices=in_slices)
    place = stream_destination(case.output, mesh_stream(as_json), options)
    require_fitting_coordinates(case, [place.format_name])
    return place


def deliver(
    meshed: "Callable[[OnRound, OnShare], Result | SlicedResult]",
    case: "Case",
    source: str,
    place: "Destination | StreamDestination",
    as_json: bool,
    quiet: bool,
) -> None:
    """Mesh a case from a source, write and print the result, and check it against what the case requires.

    FileError before the work if the result cannot be written.
    """
    from bubblemesh.console.run import PackingProgress

    def delivered() -> "tuple[Result | SlicedResult, dict[str, Any]]":
        with PackingProgress(f"packing {case.name}", quiet, heed) as progress, located(source, case.origin):

            def on_share(share: float) -> None:
                progress.advance(share)
                place.load()  # while workers pack other parts, if there are any

            result = meshed(progress.show, on_share)
        return result, place.deliver(result)

    place.require_writable()
    result, report = case.within_limits(delivered, f"{source}: ")
    tell_written(report, place, as_json, quiet)
    if result.verdict is not None:
        raise result.verdict


def tell_estimate(case: "Case", source: str, picture: Path | None, as_json: bool, quiet: bool) -> None:
    """Print what meshing the case would take, and draw its spacing if a picture is named."""
    from bubblemesh import console
    from bubblemesh.console import report
    from bubblemesh.problem.prepare import prepare
    from bubblemesh.run.estimate import estimate

    def estimated() -> dict[str, Any]:
        with located(source, case.origin):
            problem = prepare(case)
        estimates = estimate(problem, complete=as_json)
        if picture is not None:
            draw_preview(problem, picture)  # last: while files get their names no time limit holds
        return estimates

    figures = case.within_limits(estimated, f"{source}: ")
    if as_json:
        write_json(figures | ({} if picture is None else {"plot": picture}))
    if not quiet:
        report.show_estimate(figures)
        if picture is not None:
            report.show_files(str(picture.parent), [picture.name])
    console.warn(figures["warnings"])


def tell_previews(entries: "Sequence[Entry]", as_json: bool, quiet: bool) -> None:
    """Print what meshing each of many cases would take; nothing is written. The exit code is the largest of theirs."""
    from bubblemesh import batch as many
    from bubblemesh.console.batch import PreviewLines

    lines = PreviewLines(len(entries), quiet)
    previews = []
    for entry in entries:
        previews.append(many.preview_of(entry))
        lines.show(previews[-1])
    totals = many.totals_of(previews)
    lines.end(totals)
    if as_json:
        write_json(totals)
    raise typer.Exit(totals["exit_code"])


def draw_preview(problem: "Problem", picture: Path) -> None:
    """Draw the spacing of a problem, or its rings before and after a repair that changed them."""
    from bubblemesh.pictures.plots import require_picture
    from bubblemesh.pictures.repairs import draw_repairs
    from bubblemesh.pictures.spacing_plots import draw_spacing
    from bubblemesh.problem.ruling import ruling
    from bubblemesh.run.assembly import previewed

    require_picture(picture)  # before the work
    if changes := problem.domain.changes:
        before = [points for change in changes for points in change.before]
        draw_repairs(problem.domain.polygon, before, [change.at for change in changes], picture)
        return
    extremes = problem.packing_extremes
    mesh, spacing = previewed(problem)
    setters = ruling(problem, mesh.points[mesh.triangles[:, :3]].mean(axis=1))
    draw_spacing(mesh, spacing, (extremes[:2], extremes[2:]), picture, problem.task.name, setters)
