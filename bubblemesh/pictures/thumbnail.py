"""A small picture of a mesh as HTML, for notebooks."""

import base64
from html import escape

from bubblemesh.meshes.mesh import Mesh
from bubblemesh.messages import printable
from bubblemesh.pictures.colouring import MeshData
from bubblemesh.pictures.plots import small_png
from bubblemesh.pictures.styles import PlotOptions

MOST_DRAWN = 200_000  # triangles; more take too long for a picture that comes unasked
SMALL = PlotOptions(width=100, dpi=110, axes=False)


def thumbnail(mesh: Mesh) -> str:
    """HTML with the mesh in words, below a picture unless it is too large or has no area."""
    words = f"<div>{escape(printable(repr(mesh)))}</div>"
    (x0, y0), (x1, y1) = mesh.points.min(axis=0), mesh.points.max(axis=0)
    if len(mesh.triangles) > MOST_DRAWN or not (x0 < x1 and y0 < y1):
        return words
    picture = base64.b64encode(small_png(mesh, SMALL, MeshData(mesh.fields))).decode()
    return f'<div><img alt="" src="data:image/png;base64,{picture}">{words}</div>'
