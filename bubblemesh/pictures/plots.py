"""Pictures of meshes. The module imports matplotlib: import it only where a picture is drawn."""

import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import EllipseCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.ticker import FuncFormatter, MaxNLocator
from matplotlib.transforms import Bbox
from PIL import Image

from bubblemesh.arrays import Booleans, Floats
from bubblemesh.errors import CaseError
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.metric import ENTRIES, node_tensors, tensors_in
from bubblemesh.meshes.tensors import axes as axes_of
from bubblemesh.meshfiles.transaction import transaction
from bubblemesh.messages import coordinate
from bubblemesh.pictures.colouring import MANY, Colouring, MeshData, add_colour_bar, colouring_of, standard_color
from bubblemesh.pictures.outlines import add_legend, add_outlines
from bubblemesh.pictures.styles import BARE, INK, SOFT, PlotOptionError, PlotOptions, View
from bubblemesh.process.shared import warnings_are

# Without a date and with fixed ids the same mesh gives the same bytes.
METADATA: dict[str, dict[str, Any]] = {".png": {}, ".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
FIXED: Any = {"svg.hashsalt": "bubblemesh"}
NO_DATA = MeshData()
POINTS_PER_INCH, MM_PER_INCH = 72, 25.4
MARGIN, NARROW_MARGIN = 0.12, 0.03  # inches
MOST_PIXELS = 30_000
TALL, TALL_IN_COLUMN = 1 / 1.6, 1.6  # height over width
COLOURS = 256
TICKS = 5  # numbers along the longer side, at most
FEWEST_PIXELS = 2.0  # length of edges, in pixels, below which they would only darken the picture
EDGE_SHARE, BOUNDARY_SHARE, NODE_SHARE = 0.025, 0.15, 0.22  # of the edges' length
LARGEST_ELLIPSE = 10.0  # axes that are drawn, in terms of the size of the mesh
ELLIPSE = "#d1495b"
STANDARD = PlotOptions()


def draw_mesh(mesh: Mesh, path: Path, options: PlotOptions = STANDARD, data: MeshData = NO_DATA) -> Figure:
    """Draw a mesh into a file, and return the figure; the same errors as `mesh_figure` and `save_figure`."""
    require_picture(path)
    figure = mesh_figure(mesh, options, data)
    save_figure(figure, path, options)
    return figure


def require_picture(path: Path) -> None:
    """Check that a path has the ending of a picture; CaseError if not."""
    if path.suffix.lower() not in METADATA:
        raise CaseError(f"{path}: unknown ending {path.suffix!r} for a picture: choose one of {', '.join(METADATA)}")


def save_figure(figure: Figure, path: Path, options: PlotOptions = STANDARD) -> None:
    """Write a picture of a mesh, as `mesh_figure` makes it with the same options, as ``.png``, ``.svg`` or ``.pdf``.

    The triangles of a large mesh become a bitmap inside the latter two. CaseError if the path has another ending,
    FileError if the file cannot be written.
    """
    require_picture(path)
    with _drawing(options), transaction(path.parent) as staging:
        kept = _cropped(figure, options)
        figure.savefig(staging / path.name, dpi=figure.dpi, metadata=METADATA[path.suffix.lower()], bbox_inches=kept)


def mesh_figure(
    mesh: Mesh, options: PlotOptions = STANDARD, data: MeshData = NO_DATA, also: Sequence[PlotOptions] = ()
) -> Figure:
    """Picture of a mesh, with data for ``options.color``; CaseError if an option asks for something that is missing.

    For each of the options ``also``, a further picture is beside the first one if that is tall, else below it.
    """
    options.check()
    with _drawing(options):
        aside = is_tall(box_of(mesh, options.view), options)
        panels = (1, 1 + len(also)) if aside else (1 + len(also), 1)
        figure, inches_per_unit = _sheet(box_of(mesh, options.view), options, *panels)
        for number, each in enumerate([options, *also]):
            _draw(figure.add_subplot(*panels, number + 1), mesh, each, data, inches_per_unit, aside=aside)
    return figure


def draw_into(axes: Axes, mesh: Mesh, options: PlotOptions = STANDARD, data: MeshData = NO_DATA) -> None:
    """Draw a mesh into axes of a figure; the same errors as `mesh_figure`."""
    options.check()
    x0, y0, x1, y1 = box_of(mesh, options.view)
    place = axes.get_window_extent()
    inches = min(place.width / (x1 - x0), place.height / (y1 - y0)) / axes.figure.dpi
    with _drawing(options):
        _draw(axes, mesh, options, data, float(inches), aside=True)  # as there may be other axes below


def _draw(axes: Axes, mesh: Mesh, options: PlotOptions, data: MeshData, inches_per_unit: float, *, aside: bool) -> None:
    """Draw all parts of a picture with so many inches per unit of length; the scale is ``aside`` or below."""
    style, box = options.look, box_of(mesh, options.view)
    shown = _in_view(mesh, options.view)
    color = options.color or standard_color(int(shown.sum()))
    limits = None if options.limits is None else (options.limits[0], options.limits[1])  # it may be an array
    colouring = colouring_of(mesh, data, color, options.colormap, limits)
    edge = inches_per_unit * _typical_edge(mesh, shown)
    triangles = _add_triangles(axes, mesh, shown, colouring, options, edge)
    if options.ellipses:
        _add_ellipses(axes, mesh, shown, data, edge)
    labels = style.labels if options.labels is None else options.labels
    outlines = add_outlines(
        axes,
        mesh,
        np.reshape(box, (2, 2)),
        told_apart=labels or color == "label",
        all_labels=color == "label" or options.labels is True,
        width=float(np.clip(BOUNDARY_SHARE * POINTS_PER_INCH * edge, *style.boundary)),
    )
    _arrange(axes, box, options)
    add_legend(axes, outlines, colouring)
    if colouring is not None and not colouring.names:
        add_colour_bar(axes, triangles, colouring, style, aside=aside)


def small_png(mesh: Mesh, options: PlotOptions, data: MeshData = NO_DATA) -> bytes:
    """Picture of a mesh as a small PNG (`png_of`); the same errors as `mesh_figure`."""
    return png_of(mesh_figure(mesh, options, data), options)


def png_of(figure: Figure, options: PlotOptions) -> bytes:
    """A figure as PNG of few colours, which takes a quarter of the bytes.

    It is compressed once, and not as far as possible: the last 5 % of the bytes would take twice as long as all else.
    """
    full, small = io.BytesIO(), io.BytesIO()
    with _drawing(options):
        kept, plain = _cropped(figure, options), {"compress_level": 0}
        figure.savefig(full, format="png", dpi=figure.dpi, bbox_inches=kept, pil_kwargs=plain)
    bitmap = Image.open(full).convert("RGB")
    bitmap = bitmap.quantize(COLOURS, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    bitmap.save(small, format="png")
    return small.getvalue()


@contextmanager
def _drawing(options: PlotOptions) -> Iterator[None]:
    """Within the block, draw in the fonts of the style; a letter that they lack becomes a box, without a warning."""
    with warnings_are("ignore", "Glyph .* missing"), mpl.rc_context(FIXED | options.look.settings):
        yield


def _in_view(mesh: Mesh, view: View | None) -> Booleans:
    """Mask (t,) of the triangles that reach into the view."""
    if view is None:
        return np.ones(len(mesh.triangles), bool)
    x0, y0, x1, y1 = view
    low, high = (bound(mesh.points[mesh.triangles[:, :3]], axis=1) for bound in (np.min, np.max))
    shown = np.asarray((high > [x0, y0]).all(axis=1) & (low < [x1, y1]).all(axis=1))
    if not shown.any():
        (left, bottom), (right, top) = mesh.points.min(axis=0), mesh.points.max(axis=0)
        raise PlotOptionError(
            "view", f"no triangle is there: the mesh covers [{left:.6g}, {right:.6g}] x [{bottom:.6g}, {top:.6g}]"
        )
    return shown


def box_of(mesh: Mesh, view: View | None = None) -> View:
    """The view, or the box of the whole mesh; CaseError if that has no area."""
    if view is not None:
        return view
    (x0, y0), (x1, y1) = mesh.points.min(axis=0), mesh.points.max(axis=0)
    if not (x0 < x1 and y0 < y1):
        raise CaseError("the mesh has no area: there is nothing to draw")
    return float(x0), float(y0), float(x1), float(y1)


def is_tall(box: View, options: PlotOptions) -> bool:
    """Whether the colour bar stands beside the mesh."""
    aspect = (box[3] - box[1]) / (box[2] - box[0])
    return aspect > (TALL if options.whole_width is None else TALL_IN_COLUMN)


def _sheet(box: View, options: PlotOptions, down: int = 1, across: int = 1) -> tuple[Figure, float]:
    """A figure with room for some panels, and the inches that a unit of length takes; empty room is cut off later."""
    width, height = box[2] - box[0], box[3] - box[1]
    whole_width, dpi = options.whole_width, options.dpi or options.look.dpi
    long_side = options.look.long_side / MM_PER_INCH
    if whole_width is None:
        inches = long_side / max(width, height)
        size = (across * (max(width * inches, 2.5) + 1.2), down * (max(height * inches, 2.0) + 1.0))
    else:
        inches = min(whole_width / MM_PER_INCH / width, long_side / height)
        size = (whole_width / MM_PER_INCH, down * (height * inches + 1.5))
    if max(size) * dpi > MOST_PIXELS:
        raise PlotOptionError(
            "dpi", f"the picture would be {max(size) * dpi:.0f} pixels long: at most {MOST_PIXELS} are drawn"
        )
    pads: Any = {} if whole_width is None else {"w_pad": 0.01, "h_pad": 0.02}
    figure = Figure(figsize=size, dpi=dpi, layout=ConstrainedLayoutEngine(**pads))
    FigureCanvasAgg(figure)
    return figure, inches


def _cropped(figure: Figure, options: PlotOptions) -> Bbox:
    """Part of the figure to keep: all that is drawn, or the whole width if the options give one."""
    if (layout := figure.get_layout_engine()) is not None:
        layout.execute(figure)
        figure.set_layout_engine("none")  # all places are known: a second layout would take longer than the drawing
    drawn = figure.get_tightbbox()
    if options.whole_width is not None:
        return Bbox([[0, drawn.y0 - NARROW_MARGIN], [figure.get_figwidth(), drawn.y1 + NARROW_MARGIN]])
    return drawn.padded(MARGIN)


def _typical_edge(mesh: Mesh, shown: Booleans) -> float:
    corners = mesh.triangles[shown]
    sides = mesh.points[corners[:, 1]] - mesh.points[corners[:, 0]]
    return float(np.median(np.hypot(sides[:, 0], sides[:, 1])))


def _add_triangles(
    axes: Axes, mesh: Mesh, shown: Booleans, colouring: Colouring | None, options: PlotOptions, edge: float
) -> PolyCollection:
    """Draw the triangles, and the nodes where asked for; ``edge`` is the edges' typical length in inches."""
    style, points = options.look, edge * POINTS_PER_INCH
    # An array is drawn much faster than a list of arrays, but is missing in matplotlib's type annotations.
    corners: Any = mesh.points[mesh.triangles[shown, :3]]
    few = len(corners) < MANY or options.view is not None
    seen = few and edge * axes.figure.dpi >= FEWEST_PIXELS
    visible = seen if options.edges is None else options.edges
    width = float(np.clip(EDGE_SHARE * points, *style.edges))
    if visible:
        triangles = PolyCollection(corners, edgecolors="face" if len(mesh.quads) else INK, linewidths=width)
    elif len(corners) >= MANY:  # without antialiasing there are no hairlines between faces
        triangles = PolyCollection(corners, edgecolors="none", antialiaseds=False)
    else:  # edges in the colours of the faces close the hairlines
        triangles = PolyCollection(corners, edgecolors="face", linewidths=0.1)
    triangles.set_rasterized(len(corners) > style.most_vectors)
    axes.add_collection(triangles)
    if visible and len(mesh.quads):  # drawn apart, since the diagonals of quadrilaterals are not edges
        _add_cell_edges(axes, mesh, shown, width, rasterized=len(corners) > style.most_vectors)
    if colouring is None:
        triangles.set_facecolor(BARE)
        if not visible and len(corners) < MANY:
            triangles.set_edgecolor(BARE)
    else:
        colormap = colouring.colormap.with_extremes(bad=BARE)
        triangles.set(array=np.ma.masked_invalid(colouring.values[shown]), cmap=colormap, norm=colouring.norm)
    if options.nodes:
        x, y = mesh.points[np.unique(mesh.triangles[shown])].T
        size = float(np.clip(NODE_SHARE * points, 0.4, 4))
        axes.plot(x, y, "o", color=INK, markersize=size, markeredgewidth=0, rasterized=len(x) > style.most_vectors)
    return triangles


def _add_ellipses(axes: Axes, mesh: Mesh, shown: Booleans, data: MeshData, edge: float) -> None:
    """Draw an ellipse at each node, with the requested distances to neighbours; PlotOptionError without a metric."""
    nodes = np.unique(mesh.triangles[shown, :3])
    across, along, direction = axes_of(_node_metric(mesh, data)[nodes])
    angle = np.degrees(np.arctan2(direction[:, 1], direction[:, 0]))
    # Ellipses far larger than the picture take long to draw, and nothing more would be seen of them.
    along, across = (np.minimum(size, LARGEST_ELLIPSE * np.ptp(mesh.points, axis=0).max()) for size in (along, across))
    width = float(np.clip(EDGE_SHARE * edge * POINTS_PER_INCH, 0.2, 0.8))
    ellipses = EllipseCollection(
        along, across, angle, units="xy", offsets=mesh.points[nodes], offset_transform=axes.transData
    )
    ellipses.set(facecolor="none", edgecolor=ELLIPSE, linewidth=width)
    axes.add_collection(ellipses)


def _node_metric(mesh: Mesh, data: MeshData) -> Floats:
    """Tensors (n, 3) of the nodes, by those of the triangles if the mesh has no other; PlotOptionError without any."""
    if len(mesh.metric):
        return mesh.metric
    tensors = tensors_in(data.cells)
    if tensors is None:
        raise PlotOptionError("ellipses", f"the mesh has no metric: its triangles need the data {', '.join(ENTRIES)}")
    return node_tensors(mesh.triangles, tensors, len(mesh.points))


def _add_cell_edges(axes: Axes, mesh: Mesh, shown: Booleans, width: float, *, rasterized: bool) -> None:
    """Draw the outlines of the cells of which a triangle is shown."""
    for nodes, triangles in mesh.cells:
        sides = 2 + triangles.shape[1]
        outlines: Any = mesh.points[nodes[shown[triangles].any(axis=1), :sides]]
        edges = PolyCollection(outlines, facecolors="none", edgecolors=INK, linewidths=width)
        edges.set_rasterized(rasterized)
        axes.add_collection(edges)


def _arrange(axes: Axes, box: View, options: PlotOptions) -> None:
    x0, y0, x1, y1 = box
    margin = 0.01 * max(x1 - x0, y1 - y0) if options.view is None else 0.0
    axes.set_aspect("equal")
    axes.set(xlim=(x0 - margin, x1 + margin), ylim=(y0 - margin, y1 + margin))
    if options.axes if options.axes is not None else options.look.axes:
        _tell_coordinates(axes, max(x1 - x0, y1 - y0))
    else:
        axes.set_axis_off()
    if options.title is not None:
        size = 1.3 * float(mpl.rcParams["font.size"])
        axes.set_title(options.title, color=INK, fontsize=size, pad=6, parse_math=False)


def _tell_coordinates(axes: Axes, size: float) -> None:
    """Write coordinates along two sides, with as many digits as messages have in a domain of this size."""
    (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
    for axis, extent in ((axes.xaxis, x1 - x0), (axes.yaxis, y1 - y0)):
        axis.set_major_locator(MaxNLocator(max(round(TICKS * extent / size), 1), steps=[1, 2, 5, 10]))
        axis.set_major_formatter(FuncFormatter(lambda value, position: coordinate(value, size)))
    letters = 0.8 * float(mpl.rcParams["font.size"])
    axes.tick_params(color=SOFT, labelcolor=SOFT, labelsize=letters, width=0.5, length=3, pad=2)
    for spine in axes.spines.values():
        spine.set(color=SOFT, linewidth=0.3)
