"""The command line; each command is one call into the package, which is loaded only then."""

import os
import signal
import sys
import traceback
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager, nullcontext
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated

import typer

from bubblemesh import __version__
from bubblemesh.errors import OUT_OF_MEMORY, BubblemeshError, CaseError, FileError, LimitError, located
from bubblemesh.streams import read_input, write_new, write_output

if TYPE_CHECKING:
    from bubblemesh.case import Case
    from bubblemesh.delivery import Destination
    from bubblemesh.meshes import Mesh
    from bubblemesh.pipeline import Result
    from bubblemesh.problem import Problem
    from bubblemesh.spacing.spacing import Spacing

__all__ = ["app", "main"]

INTERRUPTED = 130

app = typer.Typer(
    help="Triangle meshes by bubble packing, from a YAML case file to solver-ready files.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

CaseFile = Annotated[str, typer.Argument(metavar="CASE", help="Case file, or - for the standard input.")]
Settings = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Change the case, e.g. packing.w2=0.7.")
]
MethodName = Annotated[str | None, typer.Option("--method", help="Packing method, over the case's.")]
Seed = Annotated[int | None, typer.Option("--seed", help="Seed of the random numbers, over the case's.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print the report as JSON on the standard output.")]
Output = Annotated[
    str | None,
    typer.Option("--output", "-o", metavar="PATH", help="A folder, a mesh file, or - for the standard output."),
]
FormatNamed = Annotated[
    str | None, typer.Option("--format", help="Write this format only: msh, vtu, xdmf, mesh, inp, su2 ...")
]
SolverNamed = Annotated[
    str | None, typer.Option("--for", metavar="SOLVER", help="Write what a solver reads: fenicsx, calculix ...")
]
Picture = Annotated[Path | None, typer.Option("--plot", metavar="FILE", help="Draw the spacing: .png, .svg or .pdf.")]
TimeLimit = Annotated[
    float | None,
    typer.Option("--time-limit", metavar="SECONDS", help="End the packing then, with the mesh as it is."),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Show warnings and errors only.")]


received: list[int] = []  # signals that ask to end


class Interrupted(BaseException):
    """A signal asks to end.

    Python itself ends a process by its signal, whatever the exit code, once a KeyboardInterrupt has met compiled code.
    """


def main() -> None:
    """Run the command."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, interrupt)
    try:
        app()
    except Interrupted:  # before a command has begun
        sys.stderr.write("error: interrupted\n")
        sys.exit(INTERRUPTED)
    finally:
        # What was asked for is done or given up: the exit code is not to change while Python shuts down.
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)


def interrupt(number: int, frame: FrameType | None) -> None:
    """Ctrl-C, or a request to terminate: ends the command with exit code 130 and no half files."""
    received.append(number)
    raise Interrupted


@app.callback(invoke_without_command=True)
def bubblemesh(version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False) -> None:
    """Triangle meshes by bubble packing, from a YAML case file to solver-ready files."""
    if version:
        with reported():
            write_output(f"{__version__}\n")
        raise typer.Exit


@app.command()
def run(
    case: CaseFile,
    output: Output = None,
    format_name: FormatNamed = None,
    solver: SolverNamed = None,
    settings: Settings = None,
    method: MethodName = None,
    seed: Seed = None,
    as_json: AsJson = False,
    history: Annotated[
        bool, typer.Option("--history", help="Write tables of all rounds, and of the mean speed in all steps, as CSV.")
    ] = False,
    time_limit: TimeLimit = None,
    page: Annotated[
        bool | None, typer.Option("--report/--no-report", help="Write a page to look at, NAME.html, over the case's.")
    ] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Check the case and estimate the mesh only.")] = False,
    picture: Picture = None,
    quiet: Quiet = False,
) -> None:
    """Mesh a case and write the mesh files and a report."""
    with reported():
        from bubblemesh import console, delivery, pipeline

        loaded = read_case(case, settings, method, seed, time_limit)
        require_distinct(as_json, output)
        place = delivery.destination(loaded, case, output, format_name, solver, history=history, page=page)
        if dry_run:
            show_estimate(loaded, case, picture, as_json, quiet)
            return
        if picture is not None:
            raise CaseError(
                "--plot: draws the spacing of a dry run: add --dry-run, or draw the mesh by bubblemesh plot"
            )
        with console.Progress(f"packing {loaded.name}", quiet) as progress, located(case):
            result = pipeline.mesh_case(loaded, progress.show, progress.advance)
        hand_over(result, loaded, place, as_json, quiet)


@app.command()
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
    settings: Settings = None,
    method: MethodName = None,
    seed: Seed = None,
    as_json: AsJson = False,
    time_limit: TimeLimit = None,
    quiet: Quiet = False,
) -> None:
    """Mesh a case anew as its solution asks for: finer where the estimated error is large, coarser where small."""
    with reported():
        from bubblemesh import adapting, console, delivery
        from bubblemesh.adaptivity.solution import Solution
        from bubblemesh.output.solutions import read_nodal_field

        loaded = read_case(case, settings, method, seed, time_limit)
        target = adapting.Target(error, nodes)
        place = delivery.destination(loaded, case, output, format_name, solver)
        require_distinct(as_json, output)
        place.require_apart(solution)
        read = read_nodal_field(solution, field)
        with located(str(solution)):
            present = Solution.of(read.points, read.triangles, read.values, read.name)
        with console.Progress(f"packing {loaded.name}", quiet) as progress, located(case):
            result = adapting.adapted(loaded, present, target, exact, progress.show, progress.advance)
        hand_over(result, loaded, place, as_json, quiet)


@app.command()
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
    settings: Settings = None,
    method: MethodName = None,
    seed: Seed = None,
    page: Annotated[
        bool | None, typer.Option("--report", help="Write a page for each case, and index.html to compare them.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the summary as JSON on the standard output.")] = False,
    quiet: Quiet = False,
) -> None:
    """Mesh many cases; one that fails is a row of the summary."""
    with reported():
        from bubblemesh import batch as many
        from bubblemesh.console.batch import BatchProgress
        from bubblemesh.output import dump

        part = many.Shard.parsed(shard)
        workers = many.workers_at(jobs, cluster)
        common, folder = many.Settings(tuple(settings or ()), method, seed, output, page), Path(output or ".")
        entries = many.planned(many.case_files(paths), common)
        if page:
            many.require_no_index(entries, folder)
        events = many.course(entries, common, workers, shard=part, resume=resume)
        with closing(events), BatchProgress(quiet) as progress:
            results = many.Results.of(progress.shown(events))
        if page:
            many.write_index(results.rows, folder, part.suffix)
        if as_json:
            write_output(dump(results.data()))
    raise typer.Exit(results.exit_code)


@app.command()
def check(
    case: CaseFile,
    settings: Settings = None,
    method: MethodName = None,
    seed: Seed = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    picture: Picture = None,
) -> None:
    """Check a case: its geometry, its spacing, and how many nodes it needs."""
    with reported():
        loaded = read_case(case, settings, method, seed)
        show_estimate(loaded, case, picture, as_json, quiet)


@app.command()
def quality(
    mesh: Annotated[Path, typer.Argument(metavar="MESH", help="Mesh file of any format that meshio reads.")],
    other: Annotated[
        Path | None, typer.Argument(metavar="[OTHER]", help="Another mesh, to compare the first with.")
    ] = None,
    spacing: Annotated[
        str | None, typer.Option("--spacing", metavar="EXPR", help="Wanted spacing in x and y, to compare edges with.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Report the quality of a triangle mesh, or compare two."""
    with reported():
        from bubblemesh import console
        from bubblemesh.output import dump
        from bubblemesh.output.reading import read_triangles
        from bubblemesh.spacing.expression import Expression
        from bubblemesh.spacing.spacing import Spacing
        from bubblemesh.summary import mesh_figures

        with located("--spacing"):
            wanted = None if spacing is None else Spacing(Expression.parse(spacing, {}))
        if other is not None:
            compare(mesh, other, wanted, as_json)
            return
        points, triangles, others = read_triangles(mesh)
        console.warn(left_out(mesh, others))
        with located("--spacing"):
            figures = mesh_figures(points, triangles, wanted)
        if as_json:
            write_output(dump(figures))
        else:
            console.show_quality(figures)


@app.command()
def plot(
    mesh: Annotated[Path, typer.Argument(metavar="MESH", help="Mesh file of any format that meshio reads.")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="PATH", help="Picture: .png, .svg or .pdf.")
    ] = None,
    color: Annotated[
        str, typer.Option("--color", help="quality, spacing, label, material, none, or a field of the file.")
    ] = "quality",
    colormap: Annotated[str | None, typer.Option("--colormap", help="One of matplotlib's colour maps.")] = None,
    limits: Annotated[
        tuple[float, float] | None, typer.Option("--range", help="Values at the ends of the colour map.")
    ] = None,
    edges: Annotated[bool | None, typer.Option("--edges/--no-edges", help="Draw the triangles' edges.")] = None,
    nodes: Annotated[bool, typer.Option("--nodes", help="Draw the nodes.")] = False,
    labels: Annotated[bool | None, typer.Option("--labels/--no-labels", help="Colour the boundary by label.")] = None,
    view: Annotated[
        tuple[float, float, float, float] | None, typer.Option("--view", help="Part to show: X0 Y0 X1 Y1.")
    ] = None,
    title: Annotated[str | None, typer.Option("--title", help="Text above the picture.")] = None,
    style: Annotated[str, typer.Option("--style", help="screen, or paper: a column wide, thin lines.")] = "screen",
    width: Annotated[float | None, typer.Option("--width", metavar="MM", help="Width of the picture.")] = None,
    dpi: Annotated[float | None, typer.Option("--dpi", help="Resolution of bitmaps.")] = None,
) -> None:
    """Draw a triangle mesh as a picture."""
    with reported():
        from bubblemesh import console
        from bubblemesh.output.foreign import read_foreign
        from bubblemesh.output.plots import MeshData, PlotOptions, mesh_figure, require_picture, save_figure

        path = output or Path(f"{mesh.stem}.png")
        require_picture(path)
        shown = PlotOptions(
            color=color,
            colormap=colormap,
            limits=limits,
            edges=edges,
            nodes=nodes,
            labels=labels,
            view=view,
            title=title,
            style=style,
            width=width,
            dpi=dpi,
        )
        read = read_foreign(mesh)
        console.warn(left_out(mesh, read.left_out))
        with located(str(mesh)):
            figure = mesh_figure(read.mesh, shown, MeshData(read.cell_data, read.point_data))
        save_figure(figure, path, shown)
        console.show_files(str(path.parent), [path.name])


@app.command()
def schema() -> None:
    """Print the JSON Schema of the case file."""
    with reported():
        from bubblemesh.case.schema import case_schema
        from bubblemesh.output import dump

        write_output(dump(case_schema()))


@app.command()
def init(
    path: Annotated[str, typer.Argument(metavar="[CASE]", help="File to write, or - for the standard output.")] = (
        "case.yaml"
    ),
) -> None:
    """Write a commented case file to start from."""
    with reported():
        from bubblemesh.case.template import TEMPLATE

        if path == "-":
            write_output(TEMPLATE)
            return
        write_new(Path(path), TEMPLATE)
        typer.echo(f"{path} written: run it with  bubblemesh run {path}", err=True)


def read_case(
    case: str,
    settings: list[str] | None,
    method: str | None,
    seed: int | None,
    time_limit: float | None = None,
) -> "Case":
    """The case of a file or the standard input, with the options over it."""
    from bubblemesh.case import load_case

    text = read_input() if case == "-" else None
    return load_case(case, overrides=settings or (), method=method, seed=seed, time_limit=time_limit, text=text)


def require_distinct(as_json: bool, output: str | None) -> None:
    """Check that report and mesh do not both go to the standard output."""
    if as_json and output == "-":
        raise CaseError("--json and -o - would both write to the standard output: drop one of them")


def hand_over(result: "Result[Mesh]", case: "Case", place: "Destination", as_json: bool, quiet: bool) -> None:
    """Write what a run has made, tell of it, and check it against what the case requires."""
    from bubblemesh import console, delivery
    from bubblemesh.output import dump

    report = place.deliver(result)
    if as_json:
        write_output(dump(report))
    if not quiet:
        console.show_quality(report)
        if place.folder is not None:
            console.show_files(str(place.folder), report["files"])
    console.warn(report["warnings"])
    delivery.require_finished(report)
    delivery.require_quality(case, report)


def compare(first: Path, second: Path, wanted: "Spacing | None", as_json: bool) -> None:
    """Two meshes side by side."""
    from bubblemesh import comparison, console
    from bubblemesh.console.comparison import show_comparison
    from bubblemesh.output import dump
    from bubblemesh.output.foreign import read_foreign

    read = {path: read_foreign(path) for path in (first, second)}
    for path, mesh in read.items():
        console.warn(left_out(path, mesh.left_out))
    with nullcontext() if wanted is None else located("--spacing"):
        a, b = (comparison.measured(path, read[path], wanted) for path in (first, second))
    if as_json:
        write_output(dump(comparison.report(a, b)))
    else:
        rows = comparison.rows(a.figures, b.figures)
        show_comparison((str(first), str(second)), rows, comparison.histograms(a, b))


def left_out(mesh: Path, kinds: Sequence[str]) -> list[str]:
    """What to say of a mesh's cells that are no triangles."""
    return [f"{mesh}: cells that are no triangles are left out: {', '.join(kinds)}"] if kinds else []


def show_estimate(case: "Case", source: str, picture: Path | None, as_json: bool, quiet: bool) -> None:
    """What meshing the case would take, and a picture of its spacing if one is named."""
    from bubblemesh import console
    from bubblemesh.output import dump
    from bubblemesh.problem import prepared
    from bubblemesh.summary import estimate

    with located(source):
        problem = prepared(case)
    if picture is not None:
        draw_spacing(problem, picture)
    if as_json:
        write_output(dump(estimate(problem) | ({} if picture is None else {"plot": picture})))
    if not quiet:
        console.show_problem(problem)
        if picture is not None:
            console.show_files(str(picture.parent), [picture.name])
    console.warn(problem.warnings)


def draw_spacing(problem: "Problem", picture: Path) -> None:
    """Draw the spacing of a problem."""
    from bubblemesh.output import spacing_plots
    from bubblemesh.preview import previewed

    spacing_plots.require_picture(picture)
    shown = previewed(problem)
    least, largest = shown.extremes[:2], shown.extremes[2:]
    spacing_plots.draw_spacing(shown.mesh, shown.spacing, (least, largest), picture, problem.task.name)


@contextmanager
def reported() -> Iterator[None]:
    """Turn errors into a message and the exit code of their class; only an error of the program has a traceback."""
    try:
        yield
    except typer.Exit:
        raise
    except BubblemeshError as error:
        raise failed(str(error), error.exit_code) from None
    except (Interrupted, KeyboardInterrupt):
        raise failed("interrupted", INTERRUPTED) from None
    except MemoryError:
        raise failed(OUT_OF_MEMORY, LimitError.exit_code) from None
    except BrokenPipeError:
        # Whatever is still buffered cannot be delivered; closing the real stream would complain again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise failed("the reader of the standard output has gone", FileError.exit_code) from None
    except Exception:
        if received:  # a library that was being loaded may turn the interrupt into any other error
            raise failed("interrupted", INTERRUPTED) from None
        traceback.print_exc()
        raise failed("this is an error of bubblemesh, not of the case: please report it", 1) from None


def failed(message: str, exit_code: int) -> typer.Exit:
    """Say why the command ends, and give the exception that ends it."""
    from bubblemesh import console

    console.fail(message)
    return typer.Exit(exit_code)
