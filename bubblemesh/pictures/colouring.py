"""Colours of a picture's triangles, and the quantity that they show."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import matplotlib as mpl
import numpy as np
from matplotlib.colors import Colormap, LinearSegmentedColormap, ListedColormap

from bubblemesh.arrays import Floats
from bubblemesh.meshes.histograms import lowest_shown
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.quality import TARGET_SPACING, radius_ratios, spacing_ratios
from bubblemesh.messages import meant
from bubblemesh.pictures.styles import REGION_COLOURS, PlotOptionError

OWN = ("quality", "spacing", "label", "material", "none")
OUTER = 0.01  # share of the triangles beyond either end of a scale
# Good triangles are pale and calm, so that the bad ones and the boundary are what one sees.
QUALITY = LinearSegmentedColormap.from_list("quality", ["#a50f3c", "#e8683f", "#fbc66a", "#d8ebe4", "#7fb8c4"])
FIELD, RATIO = "viridis", "coolwarm"


@dataclass(frozen=True)
class MeshData:
    """Data (t,) or (t, k) of the triangles and (n,) or (n, k) of the nodes, by name."""

    cells: Mapping[str, Floats] = field(default_factory=dict)
    points: Mapping[str, Floats] = field(default_factory=dict)


@dataclass(frozen=True)
class Colouring:
    """Values (t,) of the triangles and what their colours mean.

    Attributes
    ----------
    values : (t,)
        NaN where there is none; the index of its name for each triangle where there are names.
    title : str
    colormap : Colormap
    limits : tuple of float
        Values at the ends of the colour map.
    names : tuple of str
    """

    values: Floats
    title: str
    colormap: Colormap
    limits: tuple[float, float]
    names: tuple[str, ...] = ()


def colouring_of(
    mesh: Mesh, data: MeshData, color: str, colormap: str | None = None, limits: tuple[float, float] | None = None
) -> Colouring | None:
    """The colouring by a quantity's name; None if the triangles have no colour of their own.

    Parameters
    ----------
    mesh : Mesh
    data : MeshData
    color : str
        One of ``OWN`` or the name of a field.
    colormap : str, optional
        ``quality`` or a name that matplotlib knows.
    limits : tuple of float, optional
        Values at the ends of the colour map; else by the values.

    Raises
    ------
    PlotOptionError
        If the mesh does not have the quantity, or there is no such colour map or range.
    """
    if color in ("none", "label"):
        if color == "label" and not mesh.labels:
            raise PlotOptionError("color", "the mesh has no labelled edges")
        return None
    if color == "material":
        return _by_region(mesh)
    if color == "quality":
        ratios = radius_ratios(mesh.points, mesh.triangles[:, :3])
        return Colouring(ratios, "radius ratio", _map(colormap or QUALITY.name), limits or (lowest_shown(ratios), 1.0))
    if color == "spacing":
        ratios = _spacing_ratios(mesh, data)
        return Colouring(ratios, "edge length / spacing", _map(colormap or RATIO), limits or _around_one(ratios))
    values, title = _field(mesh, data, color)
    return Colouring(values, title, _map(colormap or FIELD), limits or _extremes(values))


def _by_region(mesh: Mesh) -> Colouring:
    if not mesh.regions:
        raise PlotOptionError("color", "the mesh has no regions: its triangles have neither tags nor names")
    count = len(mesh.regions)
    colors = ListedColormap([REGION_COLOURS[k % len(REGION_COLOURS)] for k in range(count)])
    return Colouring(mesh.triangle_regions.astype(float), "material", colors, (-0.5, count - 0.5), mesh.regions)


def _spacing_ratios(mesh: Mesh, data: MeshData) -> Floats:
    wanted = data.cells.get(TARGET_SPACING)
    if wanted is None or wanted.ndim != 1:
        raise PlotOptionError(
            "color", f"the mesh has no {TARGET_SPACING} for its triangles, so that spacing cannot be shown"
        )
    if not (wanted > 0).all():
        raise PlotOptionError("color", f"{TARGET_SPACING} is not positive at some triangle")
    return spacing_ratios(mesh.points, mesh.triangles[:, :3], wanted)


def _field(mesh: Mesh, data: MeshData, name: str) -> tuple[Floats, str]:
    """Values (t,) of a field and what to call them; a vector's is its length, a node's the mean of the corners'."""
    if name in data.cells:
        values = data.cells[name]
    elif name in data.points:
        values = data.points[name]
    else:
        known = dict.fromkeys((*OWN, *data.cells, *data.points))
        close = meant(name, known)
        hint = close if close.startswith("allowed") else f"{close} allowed: {', '.join(known)}"
        raise PlotOptionError("color", f"the mesh has no {name!r}: {hint}")
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
        raise PlotOptionError(
            "colormap", f"{name!r} is unknown: {meant(name, (QUALITY.name, *mpl.colormaps))}"
        ) from None


def _around_one(ratios: Floats) -> tuple[float, float]:
    """Round numbers around nearly all ratios, as far below 1 as above."""
    reach = float(np.quantile(np.abs(ratios - 1), 1 - 2 * OUTER))
    reach = float(np.clip(np.ceil(20 * reach) / 20, 0.05, 1))
    return 1 - reach, 1 + reach


def _extremes(values: Floats) -> tuple[float, float]:
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    return (low, high) if high > low else (low - 0.5, high + 0.5)
