"""Pictures of a mesh that programs and notebooks ask it for."""

import base64
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError
from bubblemesh.files import with_home
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.messages import printable
from bubblemesh.pictures.colouring import MeshData, data_of
from bubblemesh.pictures.plots import draw_into, draw_mesh, mesh_figure, small_png
from bubblemesh.pictures.styles import PlotOptionError, PlotOptions, plot_options

MOST_DRAWN = 200_000  # triangles; more take too long for a picture that comes unasked
ARGUMENTS = {"range": "limits"}  # for options of the command line that are called differently there
SMALL = PlotOptions(width=100, dpi=110, axes=False)


def plotted(
    mesh: Mesh, path: Path | str | None, ax: Axes | None, fields: Mapping[str, Floats], options: Mapping[str, Any]
) -> Figure | SubFigure:
    """Figure of a mesh, drawn into axes if there are any, else written to a path if there is one; see `Mesh.plot`."""
    try:
        return _plotted(mesh, path, ax, fields, options)
    except PlotOptionError as error:
        raise PlotOptionError(ARGUMENTS.get(error.option, error.option), error.problem) from None


def _plotted(
    mesh: Mesh, path: Path | str | None, ax: Axes | None, fields: Mapping[str, Floats], options: Mapping[str, Any]
) -> Figure | SubFigure:
    shown, data = plot_options(options), data_of(mesh, fields)
    if not isinstance(ax, Axes | None):
        raise CaseError(f"ax: must be axes of a matplotlib figure (found {type(ax).__name__})")
    if ax is None:
        return mesh_figure(mesh, shown, data) if path is None else draw_mesh(mesh, Path(with_home(path)), shown, data)
    if path is not None:
        raise CaseError("path: ax is drawn into a figure of your own: write that one by its savefig")
    draw_into(ax, mesh, shown, data)
    return ax.figure


def thumbnail(mesh: Mesh) -> str:
    """HTML with the mesh in words, below a picture unless that is too large or has no area."""
    words = f"<div>{escape(printable(repr(mesh)))}</div>"
    if not 0 < len(mesh.triangles) <= MOST_DRAWN or not np.ptp(mesh.points, axis=0).all():
        return words
    picture = base64.b64encode(small_png(mesh, SMALL, MeshData(mesh.fields))).decode()
    return f'<div><img alt="" src="data:image/png;base64,{picture}">{words}</div>'
