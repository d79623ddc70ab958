"""Colours of a picture's triangles, the quantity that they show, and the bar with its values."""

from collections.abc import Mapping
from dataclasses import field
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, ListedColormap, LogNorm, Normalize
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from bubblemesh.arrays import Floats, unmasked
from bubblemesh.errors import CaseError
from bubblemesh.meshes.histograms import lowest_shown
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.metric import MeasuresInMetric, measures_of
from bubblemesh.meshes.quality import TARGET_SPACING, signed_areas, spacing_ratios
from bubblemesh.messages import shown, unknown
from bubblemesh.pictures.styles import INK, QUANTITIES, REGION_COLOURS, PlotOptionError, Style, region_colour
from bubblemesh.records import record

MANY = 10_000  # triangles, from which on each is too small to be seen
OUTER = 0.01  # share of the triangles beyond either end of a scale
# The one scale of quality, in pictures and pages. Good triangles are pale, so that bad ones stand out; the colours are
# ordered by lightness, for colour-blind readers.
QUALITY = mpl.colormaps["YlGnBu_r"].copy()
QUALITY.name = "quality"
FIELD, RATIO = "viridis", "coolwarm"
WIDE = 4.0  # largest over least size, from which on the scale is logarithmic
NARROWEST = 3.0  # least ratio of the ends of the scale, so that small differences do not fill it


@record
class MeshData:
    """Data (t,) or (t, k) of the triangles and (n,) or (n, k) of the nodes, by name."""

    cells: Mapping[str, Floats] = field(default_factory=dict)
    points: Mapping[str, Floats] = field(default_factory=dict)


def data_of(mesh: Mesh, fields: Mapping[str, Any]) -> MeshData:
    """Data of a mesh and further fields, each of triangles or nodes by its length; CaseError if it fits neither."""
    if not isinstance(fields, Mapping):
        raise CaseError(f"fields: must be a mapping of names to arrays (found {type(fields).__name__})")
    cells, points = dict(mesh.fields), dict[str, Floats]()
    for name, given in fields.items():
        values = np.asarray(unmasked(given))
        if values.dtype.kind not in "iufb" or values.ndim not in (1, 2) or values.size == 0:
            raise CaseError(f"fields: {name}: must be an array of numbers (found {shown(repr(given))})")
        if len(values) not in (len(mesh.triangles), len(mesh.points)):
            expected = f"the {len(mesh.triangles)} triangles or of the {len(mesh.points)} nodes"
            raise CaseError(f"fields: {name}: must have values of {expected} (found {len(values)})")
        cells.pop(name, None)
        (cells if len(values) == len(mesh.triangles) else points)[name] = values.astype(float)
    return MeshData(cells, points)


@record
class Colouring:
    """Values of the triangles and what their colours mean."""

    values: Floats  # (t,): NaN where there is no value; indices of names if the quantity has names
    title: str
    colormap: Colormap
    limits: tuple[float, float]  # values at the ends of the colour map
    names: tuple[str, ...] = ()
    logarithmic: bool = False

    @property
    def norm(self) -> Normalize:
        """The map from values to shares of the colour map."""
        return (LogNorm if self.logarithmic else Normalize)(*self.limits)


def standard_color(count: int) -> str:
    """Default quantity of the colours for so many triangles: their size if they are too many to be seen."""
    return "quality" if count < MANY else "size"


def colouring_of(
    mesh: Mesh, data: MeshData, color: str, colormap: str | None = None, limits: tuple[float, float] | None = None
) -> Colouring | None:
    """The colouring by a quantity of ``QUANTITIES`` or a field; None if the triangles have no colour of their own.

    The colour map is ``quality`` or one of matplotlib's. By default the limits follow from the values. PlotOptionError
    if the mesh does not have the quantity, or there is no such colour map.
    """
    if color in ("none", "label"):
        if color == "label" and not mesh.labels:
            raise PlotOptionError("color", "the mesh has no labelled edges")
        return None
    if color == "material":
        return _by_region(mesh)
    if color == "quality":
        measures = measures_of(mesh.points, mesh.triangles[:, :3], data.cells)
        ratios, title = measures.radius_ratios, "radius ratio"
        if isinstance(measures, MeasuresInMetric):
            title = "radius ratio in the metric"
        return Colouring(ratios, title, _map(colormap or QUALITY.name), limits or (lowest_shown(ratios), 1.0))
    if color == "size":
        return _by_size(mesh, _map(colormap or FIELD), limits)
    if color == "spacing":
        ratios = _spacing_ratios(mesh, data)
        return Colouring(ratios, "edge length / spacing", _map(colormap or RATIO), limits or _around_one(ratios))
    values, title = _field(mesh, data, color)
    return Colouring(values, title, _map(colormap or FIELD), limits or _extremes(values))


def _by_region(mesh: Mesh) -> Colouring:
    if not mesh.regions:
        raise PlotOptionError("color", "the mesh has no regions: its triangles have neither tags nor names")
    count = len(mesh.regions)
    colors = ListedColormap([REGION_COLOURS[region_colour(k)] for k in range(count)])
    return Colouring(mesh.triangle_regions.astype(float), "material", colors, (-0.5, count - 0.5), mesh.regions)


def _by_size(mesh: Mesh, colormap: Colormap, limits: tuple[float, float] | None) -> Colouring:
    """Colouring by size: the side of an equilateral triangle with the mean area of the triangles around."""
    corners = mesh.triangles[:, :3]
    sizes = np.sqrt(4 / np.sqrt(3) * np.abs(signed_areas(mesh.points, corners)))
    # Means at the nodes, then means over the triangles: this shows the field without the scatter of single triangles.
    total = np.bincount(corners.ravel(), np.repeat(sizes, 3), len(mesh.points))
    count = np.bincount(corners.ravel(), minlength=len(mesh.points))
    sizes = (total / np.maximum(count, 1))[corners].mean(axis=1)
    low, high = limits or _spread(sizes)
    return Colouring(sizes, "edge length", colormap, (low, high), logarithmic=high > WIDE * low > 0)


def _spread(sizes: Floats) -> tuple[float, float]:
    """Limits of a scale that leaves out few sizes, and is not too narrow if all are nearly equal."""
    low, high = np.quantile(sizes, [OUTER / 10, 1 - OUTER / 10]).tolist()
    if high >= NARROWEST * low:
        return low, high
    middle, half = np.sqrt(low * high), np.sqrt(NARROWEST)
    return float(middle / half), float(middle * half)


def _spacing_ratios(mesh: Mesh, data: MeshData) -> Floats:
    target = data.cells.get(TARGET_SPACING)
    if target is None or target.ndim != 1:
        raise PlotOptionError(
            "color", f"the mesh has no {TARGET_SPACING} for its triangles, so that spacing cannot be shown"
        )
    if not (target > 0).all():
        raise PlotOptionError("color", f"{TARGET_SPACING} is not positive at some triangle")
    measures = measures_of(mesh.points, mesh.triangles[:, :3], data.cells)
    if isinstance(measures, MeasuresInMetric):
        return measures.mean_sides
    return spacing_ratios(mesh.points, mesh.triangles[:, :3], target)


def _field(mesh: Mesh, data: MeshData, name: str) -> tuple[Floats, str]:
    """Values (t,) of a field, and their name: lengths of vectors; means of the corners if the field is one of nodes."""
    values = data.cells.get(name, data.points.get(name))
    if values is None:
        known = dict.fromkeys((*QUANTITIES, *data.cells, *data.points))
        raise PlotOptionError("color", unknown("quantity", name, known))
    flat = values.reshape(len(values), -1)
    lengths = flat[:, 0] if flat.shape[1] == 1 else np.sqrt((flat**2).sum(axis=1))
    title = name if flat.shape[1] == 1 else f"|{name}|"
    if name not in data.cells:
        lengths = lengths[mesh.triangles[:, :3]].mean(axis=1)
    if not np.isfinite(lengths).any():
        raise PlotOptionError("color", f"{name} has no finite value")
    return np.where(np.isfinite(lengths), lengths, np.nan), title


def _map(name: str) -> Colormap:
    if name == QUALITY.name:
        return QUALITY
    try:
        return mpl.colormaps[name]
    except KeyError:
        raise PlotOptionError("colormap", unknown("colour map", name, (QUALITY.name, *mpl.colormaps))) from None


def _around_one(ratios: Floats) -> tuple[float, float]:
    """Round numbers around nearly all ratios, as far below 1 as above."""
    reach = float(np.quantile(np.abs(ratios - 1), 1 - 2 * OUTER))
    reach = float(np.clip(np.ceil(20 * reach) / 20, 0.05, 1))
    return 1 - reach, 1 + reach


def _extremes(values: Floats) -> tuple[float, float]:
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    return (low, high) if high > low else (low - 0.5, high + 0.5)


def add_colour_bar(axes: Axes, triangles: ScalarMappable, colouring: Colouring, style: Style, *, aside: bool) -> None:
    """Add the scale of the colours, beside the mesh or below it."""
    values, (low, high) = colouring.values, colouring.limits
    below, above = bool(np.nanmin(values) < low), bool(np.nanmax(values) > high)
    bar = axes.figure.colorbar(
        triangles,
        ax=axes,
        location="right" if aside else "bottom",
        shrink=0.7,
        aspect=style.bar,
        pad=0.02,
        extend={(True, True): "both", (True, False): "min", (False, True): "max"}.get((below, above), "neither"),
    )
    if colouring.logarithmic:
        _tell_decades(bar, high / low)
    told = f"   (mean {np.nanmean(values):.3f}, min {np.nanmin(values):.3f})" if style.figures else ""
    bar.set_label(colouring.title + told, color=INK, parse_math=False)
    # By default matplotlib makes a bitmap of the scale; edges in the colours of the faces close the hairlines in it.
    bar.solids.set(rasterized=False, edgecolor="face")  # type: ignore[union-attr]
    bar.outline.set_visible(False)
    size = 0.9 * float(mpl.rcParams["font.size"])
    bar.ax.tick_params(color=INK, labelcolor=INK, labelsize=size, width=0.5)


# First digits of the numbers along a logarithmic scale, by the largest ratio of its ends up to which they have room.
DIGITS = {10: (1, 2, 3, 4, 5, 6, 8), 1000: (1, 2, 5), float("inf"): (1,)}


def _tell_decades(bar: Any, ratio: float) -> None:
    """Write plain numbers along a logarithmic scale, as many as have room; ``ratio`` is that of its ends."""
    bar.locator = LogLocator(subs=next(digits for most, digits in DIGITS.items() if ratio <= most))
    bar.minorlocator = NullLocator()
    bar.formatter = FuncFormatter(lambda value, position: f"{value:g}")
