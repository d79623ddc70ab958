"""Commands on mesh files of any origin: to look at them, and to divide them."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bubblemesh.cli.completion import quantities, styles
from bubblemesh.cli.delivery import show_written
from bubblemesh.cli.options import AsJson, FormatsNamed, Output, Quiet, SolversNamed
from bubblemesh.cli.stdio import mesh_stream, write_json
from bubblemesh.errors import CaseError, located, prefixed

if TYPE_CHECKING:
    from bubblemesh.arrays import Floats, Integers
    from bubblemesh.meshes.quality import SpacingBetween

View = tuple[float, float, float, float]
MeshPath = Annotated[
    Path,
    # As for all paths: a check by Typer whether they can be read would have another message and exit code than ours.
    typer.Argument(metavar="MESH", help="Mesh file of any format that bubblemesh or meshio reads.", readable=False),
]
MetricField = Annotated[
    str | None,
    typer.Option("--field", metavar="NAME", help="Name of the metric at the nodes, if the file has more data."),
]


def quality(
    mesh: MeshPath,
    other: Annotated[
        Path | None,
        typer.Argument(metavar="[OTHER]", help="Another mesh, to compare the first with.", readable=False),
    ] = None,
    spacing: Annotated[
        str | None, typer.Option("--spacing", metavar="EXPR", help="Wanted spacing in x and y, to compare edges with.")
    ] = None,
    metric: Annotated[
        bool, typer.Option("--metric", help="Quality and edges in the metric that the file holds, as runs write it.")
    ] = False,
    field: MetricField = None,
    as_json: AsJson = False,
) -> None:
    """Report the quality of a triangle mesh, or compare two."""
    from bubblemesh import console
    from bubblemesh.console.report import show_quality
    from bubblemesh.meshes.quality import Measures, mesh_figures
    from bubblemesh.meshfiles.read import digits, read_triangles

    spacing_between = None if spacing is None else given_spacing(spacing)
    if metric:
        if other is not None or spacing is not None:
            raise CaseError("--metric: it goes with one mesh, and without --spacing")
        in_metric(mesh, field, as_json)
        return
    if field is not None:
        raise CaseError("--field: it names a metric: use it with --metric")
    if other is not None:
        compare(mesh, other, spacing_between, as_json)
        return
    file = read_triangles(mesh)
    points, triangles = file.points, file.triangles
    notes = chosen(mesh, (*file.source.notes, *file.curved), file.left_out)
    notes += faulty(mesh, points, triangles, digits(file.source))
    console.warn(notes)
    figures = mesh_figures(Measures(points, triangles), spacing_between)
    if as_json:
        write_json(figures | {"warnings": notes})
    else:
        show_quality(figures)


def given_spacing(text: str) -> "SpacingBetween":
    """Spacing by an expression in x and y; its errors, now and when it is evaluated, name the option."""
    from bubblemesh.spacing.expression import Expression
    from bubblemesh.spacing.spacing import Spacing

    of_option = located("--spacing")
    parsed = of_option(Expression.parse)(text, {})
    return of_option(Spacing(parsed).between)


def in_metric(mesh: Path, field: str | None, as_json: bool) -> None:
    """Report the quality of a mesh, without its boundary layers, in a metric that its file holds."""
    import numpy as np

    from bubblemesh import console
    from bubblemesh.console.report import show_quality
    from bubblemesh.meshes.metric import MeasuresInMetric, figures_in_metric, measures_of
    from bubblemesh.meshes.quality import LAYER
    from bubblemesh.meshfiles.metric import with_metric
    from bubblemesh.meshfiles.read import read_mesh

    read = read_mesh(mesh)
    with prefixed(f"--metric: {mesh}"):
        read = with_metric(read, field)
    points, triangles = read.mesh.points, read.mesh.triangles[:, :3]
    notes = [*chosen(mesh, (*read.notes, *read.curved), read.left_out), *faulty(mesh, points, triangles, read.digits)]
    packed = read.cell_data.get(LAYER, np.zeros(len(triangles))) == 0
    if not packed.all():
        notes.append(f"{mesh}: {np.count_nonzero(~packed)} triangles of boundary layers are left out, as in reports")
    console.warn(notes)
    data = {name: values[packed] for name, values in read.cell_data.items()}
    measures = measures_of(points, triangles[packed], data)
    assert isinstance(measures, MeasuresInMetric)
    figures = figures_in_metric(measures)
    if as_json:
        write_json(figures | {"warnings": notes})
    else:
        show_quality(figures)


def partition(
    mesh: MeshPath,
    parts: Annotated[int, typer.Argument(metavar="N", help="Number of parts, one for each process of the solver.")],
    output: Output = None,
    formats: FormatsNamed = None,
    solvers: SolversNamed = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Divide a mesh into parts for a parallel solver, and write it with the part of each triangle and node."""
    from bubblemesh.case import Output as OutputKeys
    from bubblemesh.meshfiles.companions import files_beside
    from bubblemesh.run.division import divided_file
    from bubblemesh.run.output import OutputOptions, destination_beside, stream_destination

    mesh_file = divided_file(mesh, parts)
    stream, keys = mesh_stream(output, as_json), OutputKeys(partition=parts)
    options = OutputOptions(output, formats or (), solvers or (), stream=stream)
    place = (
        stream_destination(keys, stream, options)
        if stream is not None
        else destination_beside([mesh, *files_beside(mesh)], keys, Path(), f"{mesh_file.name}-{parts}", options)
    )
    report = place.write(mesh_file.mesh, mesh_file.fields, mesh_file.report)
    show_written(report, place, as_json, quiet)


def plot(
    mesh: MeshPath,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="PATH", help="Picture: .png, .svg or .pdf.", readable=False),
    ] = None,
    color: Annotated[
        str | None,
        typer.Option(
            "--color",
            help="quality, size, spacing, label, material, none, or a field of the file.",
            autocompletion=quantities,
        ),
    ] = None,
    colormap: Annotated[str | None, typer.Option("--colormap", help="One of matplotlib's colour maps.")] = None,
    limits: Annotated[
        tuple[float, float] | None, typer.Option("--range", help="Values at the ends of the colour map.")
    ] = None,
    edges: Annotated[bool | None, typer.Option("--edges/--no-edges", help="Draw the triangles' edges.")] = None,
    nodes: Annotated[bool, typer.Option("--nodes", help="Draw the nodes.")] = False,
    ellipses: Annotated[
        bool, typer.Option("--ellipses", help="Draw the ellipses of the metric that the file holds.")
    ] = False,
    field: MetricField = None,
    labels: Annotated[bool | None, typer.Option("--labels/--no-labels", help="Colour the boundary by label.")] = None,
    view: Annotated[View | None, typer.Option("--view", help="Part to show: X0 Y0 X1 Y1.")] = None,
    zoom: Annotated[
        str | None, typer.Option("--zoom", metavar="X0,Y0,X1,Y1", help="The same, with commas between the numbers.")
    ] = None,
    axes: Annotated[bool | None, typer.Option("--axes/--no-axes", help="Tell coordinates beside the mesh.")] = None,
    title: Annotated[str | None, typer.Option("--title", help="Text above the picture.")] = None,
    style: Annotated[
        str, typer.Option("--style", help="screen, or paper: a column wide, thin lines.", autocompletion=styles)
    ] = "screen",
    width: Annotated[float | None, typer.Option("--width", metavar="MM", help="Width of the picture.")] = None,
    dpi: Annotated[float | None, typer.Option("--dpi", help="Resolution of bitmaps.")] = None,
) -> None:
    """Draw a triangle mesh as a picture."""
    from bubblemesh import console
    from bubblemesh.console.report import show_files
    from bubblemesh.meshfiles.metric import with_metric
    from bubblemesh.meshfiles.read import read_mesh
    from bubblemesh.meshfiles.transaction import require_writable
    from bubblemesh.pictures.start import load_without_help

    load_without_help()
    from bubblemesh.pictures.colouring import MeshData
    from bubblemesh.pictures.plots import mesh_figure, require_picture, save_figure
    from bubblemesh.pictures.styles import PlotOptionError, PlotOptions

    if field is not None and not ellipses:
        raise CaseError("--field: it names a metric: use it with --ellipses, or --color for other data")
    path = output or Path(f"{mesh.stem}.png")
    require_picture(path)
    require_writable(path.parent, [path.name])
    shown = PlotOptions(
        color=color,
        colormap=colormap,
        limits=limits,
        edges=edges,
        nodes=nodes,
        ellipses=ellipses,
        labels=labels,
        axes=axes,
        view=part_of(view, zoom),
        title=title,
        style=style,
        width=width,
        dpi=dpi,
    )
    read = read_mesh(mesh)
    console.warn(chosen(mesh, (*read.notes, *read.curved), read.left_out))
    try:
        read = with_metric(read, field) if ellipses else read
        figure = mesh_figure(read.mesh, shown, MeshData(read.cell_data, read.point_data))
    except PlotOptionError as error:
        option = "zoom" if error.option == "view" and zoom is not None else error.option
        raise CaseError(f"--{option}: {error.problem}") from None
    except CaseError as error:
        raise CaseError(f"{mesh}: {error}") from None
    save_figure(figure, path, shown)
    show_files(str(path.parent), [path.name])


def part_of(view: View | None, zoom: str | None) -> View | None:
    """Part of the plane that one of two options asks for; CaseError if both are given, or ``zoom`` is wrong."""
    if zoom is None:
        return view
    if view is not None:
        raise CaseError("--zoom and --view show one part each: drop one of them")
    words = zoom.replace(",", " ").split()
    try:
        x0, y0, x1, y1 = map(float, words)
    except ValueError:
        raise CaseError(f"--zoom: give four numbers, as in --zoom 0,0,1.5,1 (found {zoom!r})") from None
    return x0, y0, x1, y1


def compare(first: Path, second: Path, spacing_between: "SpacingBetween | None", as_json: bool) -> None:
    """Print two meshes side by side."""
    from bubblemesh import console
    from bubblemesh.console.report import show_comparison
    from bubblemesh.meshes import comparison
    from bubblemesh.meshfiles.read import read_mesh

    read = {path: read_mesh(path) for path in (first, second)}
    for path, each in read.items():
        console.warn(
            [
                *chosen(path, (*each.notes, *each.curved), each.left_out),
                *faulty(path, each.mesh.points, each.mesh.triangles, each.digits),
            ]
        )
    a, b = (
        comparison.compared(path, read[path].mesh, read[path].cell_data, spacing_between) for path in (first, second)
    )
    if as_json:
        write_json(comparison.report(a, b))
    else:
        rows = comparison.rows(a.figures, b.figures)
        show_comparison((str(first), str(second)), rows, comparison.histograms(a, b))


def chosen(mesh: Path, notes: Sequence[str], left_out: Sequence[str]) -> list[str]:
    """Warnings on what is left out of a mesh file: times before the last one, and cells that are not faces."""
    others = [f"cells that are no triangles or quadrilaterals are left out: {', '.join(left_out)}"] if left_out else []
    return [f"{mesh}: {note}" for note in (*notes, *others)]


def faulty(mesh: Path, points: "Floats", triangles: "Integers", digits: float) -> list[str]:
    """Warnings on a mesh that is not conforming, or whose triangles do not all turn the same way."""
    from bubblemesh.meshfiles.faults import faults

    return [*turned(mesh, points, triangles), *(f"{mesh}: {fault}" for fault in faults(points, triangles, digits))]


def turned(mesh: Path, points: "Floats", triangles: "Integers") -> list[str]:
    """Warnings on a mesh whose triangles do not all turn the same way."""
    from bubblemesh.meshes.quality import inverted
    from bubblemesh.messages import place

    found = inverted(points, triangles)
    if len(found) == 0:
        return []
    count = "1 triangle turns" if len(found) == 1 else f"{len(found)} triangles turn"
    where = place(points[triangles[found[0]]].mean(axis=0), float((points.max(axis=0) - points.min(axis=0)).max()))
    return [f"{mesh}: {count} the other way than the rest, the first at {where}: the mesh may lie upon itself there"]
