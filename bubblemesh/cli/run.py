"""Commands that mesh one case, or tell what that would take."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bubblemesh.cli.options import (
    CASE_OPTIONS,
    PACKING_OPTIONS,
    AsJson,
    CaseFile,
    FormatNamed,
    Output,
    Overrides,
    Picture,
    Quiet,
    SolverNamed,
    with_overrides,
)
from bubblemesh.cli.stdio import output_stream, read_input, write_output
from bubblemesh.errors import CaseError, FileError, located

if TYPE_CHECKING:
    from bubblemesh.case import Case
    from bubblemesh.problem.problem import Problem
    from bubblemesh.run.destination import Destination
    from bubblemesh.run.pipeline import OnRound, OnShare, Result


@with_overrides(CASE_OPTIONS, PACKING_OPTIONS)
def run(
    case: CaseFile,
    output: Output = None,
    format_name: FormatNamed = None,
    solver: SolverNamed = None,
    overrides: Overrides = (),
    as_json: AsJson = False,
    history: Annotated[
        bool, typer.Option("--history", help="Write tables of all rounds, and of the mean speed in all steps, as CSV.")
    ] = False,
    page: Annotated[
        bool | None, typer.Option("--report/--no-report", help="Write a page to look at, NAME.html, over the case's.")
    ] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Check the case and estimate the mesh only.")] = False,
    picture: Picture = None,
    quiet: Quiet = False,
) -> None:
    """Mesh a case and write the mesh files and a report."""
    from bubblemesh.run import destination as destinations
    from bubblemesh.run import pipeline

    loaded = read_case(case, overrides)
    require_distinct(as_json, output)
    place = destinations.destination(loaded, case, output, format_name, solver, history=history, page=page)
    if dry_run:
        tell_estimate(loaded, case, picture, as_json, quiet)
        return
    if picture is not None:
        raise CaseError("--plot: draws the spacing of a dry run: add --dry-run, or draw the mesh by bubblemesh plot")
    deliver(partial(pipeline.mesh_case, loaded), loaded, case, place, as_json, quiet)


@with_overrides(CASE_OPTIONS, PACKING_OPTIONS)
def adapt(
    case: CaseFile,
    solution: Annotated[
        Path, typer.Option("--solution", metavar="FILE", help="Mesh of the case with the solution at its nodes.")
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
    exact: Annotated[
        str | None, typer.Option("--exact", metavar="EXPR", help="Exact solution in x and y, to check the estimate.")
    ] = None,
    output: Output = None,
    format_name: FormatNamed = None,
    solver: SolverNamed = None,
    overrides: Overrides = (),
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Mesh a case anew as its solution asks for: finer where the estimated error is large, coarser where small."""
    from bubblemesh.adaptivity import adapt as adapting
    from bubblemesh.adaptivity.solution import Solution
    from bubblemesh.meshfiles.read import read_nodal_field
    from bubblemesh.run import destination as destinations

    loaded = read_case(case, overrides)
    target = adapting.Target(error, nodes)
    place = destinations.destination(loaded, case, output, format_name, solver)
    require_distinct(as_json, output)
    place.require_apart(solution)
    read = read_nodal_field(solution, field)
    with located(str(solution)):
        present = Solution.of(read.points, read.triangles, read.values, read.name)
    deliver(partial(adapting.adapted, loaded, present, target, exact), loaded, case, place, as_json, quiet)


@with_overrides(CASE_OPTIONS)
def check(
    case: CaseFile,
    overrides: Overrides = (),
    as_json: AsJson = False,
    quiet: Quiet = False,
    picture: Picture = None,
) -> None:
    """Check a case: its geometry, its spacing, and how many nodes it needs."""
    tell_estimate(read_case(case, overrides), case, picture, as_json, quiet)


def read_case(case: str, overrides: Overrides) -> "Case":
    """The case of a file or the standard input, with the options over it."""
    from bubblemesh.case import load_case

    text = read_input() if case == "-" else None
    return load_case(case, overrides=overrides, text=text)


def require_distinct(as_json: bool, output: str | None) -> None:
    """Check that report and mesh do not both go to the standard output, nor the mesh to a terminal."""
    if output == "-" and output_stream().isatty():
        raise FileError("-o -: the mesh would go to the terminal: redirect it or pipe it to a program")
    if as_json and output == "-":
        raise CaseError("--json and -o - would both write to the standard output: drop one of them")


def deliver(
    meshed: "Callable[[OnRound, OnShare], Result]",
    case: "Case",
    source: str,
    place: "Destination",
    as_json: bool,
    quiet: bool,
) -> None:
    """Mesh a case from a source, write the result, tell of it, and check it against what the case requires."""
    from bubblemesh import console
    from bubblemesh.console.report import show_files, show_quality
    from bubblemesh.console.run import PackingProgress
    from bubblemesh.meshfiles.text import json_text

    with PackingProgress(f"packing {case.name}", quiet) as progress, located(source, case.origin):
        result = meshed(progress.show, progress.advance)
    report = place.deliver(result, output_stream() if place.folder is None else None)
    if as_json:
        write_output(json_text(report))
    if not quiet:
        show_quality(report)
        if place.folder is not None:
            show_files(str(place.folder), report["files"])
    console.warn(report["warnings"])
    if result.verdict is not None:
        raise result.verdict


def tell_estimate(case: "Case", source: str, picture: Path | None, as_json: bool, quiet: bool) -> None:
    """Tell what meshing the case would take, and draw its spacing if a picture is named."""
    from bubblemesh import console
    from bubblemesh.console import report
    from bubblemesh.meshfiles.text import json_text
    from bubblemesh.problem.prepare import prepare
    from bubblemesh.run.report import estimate

    with located(source, case.origin):
        problem = prepare(case)
    if picture is not None:
        draw_preview(problem, picture)
    figures = estimate(problem)
    if as_json:
        write_output(json_text(figures | ({} if picture is None else {"plot": picture})))
    if not quiet:
        report.show_estimate(figures)
        if picture is not None:
            report.show_files(str(picture.parent), [picture.name])
    console.warn(figures["warnings"])


def draw_preview(problem: "Problem", picture: Path) -> None:
    """Draw the spacing of a problem."""
    from bubblemesh.pictures import spacing_plots
    from bubblemesh.pictures.plots import require_picture
    from bubblemesh.run.preview import previewed

    require_picture(picture)
    shown = previewed(problem)
    least, largest = shown.extremes[:2], shown.extremes[2:]
    spacing_plots.draw_spacing(shown.mesh, shown.spacing, (least, largest), picture, problem.task.name)
