"""The command `plot`: to draw a mesh file."""

from pathlib import Path
from typing import Annotated

import typer

from bubblemesh.cli.completion import quantities, styles
from bubblemesh.cli.options import MeshPath, MetricField
from bubblemesh.errors import CaseError

View = tuple[float, float, float, float]


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
    from bubblemesh.meshfiles.read import read_mesh, reading_notes
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
    console.warn([f"{mesh}: {note}" for note in reading_notes(read)])
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
