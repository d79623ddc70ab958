"""Reads the triangles of any plane mesh that meshio reads."""

import contextlib
import io
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import FileError
from bubblemesh.files import local_copy, reason
from bubblemesh.messages import shown

# By the ending alone meshio tries the ANSYS format first, and says so on the standard output.
FORMAT_OF_ENDING = {".msh": "gmsh"}
TRIANGLES = ("triangle", "triangle6")  # of the latter the corners
NO_FACES = ("line", "line3", "vertex")
PLANE = 1e-12  # of the extent


class PlaneMesh(NamedTuple):
    """Points (n, 2) in use, triangles (t, 3), and the kinds of cells that were left out."""

    points: Floats
    triangles: Integers
    left_out: tuple[str, ...]


def read_triangles(path: Path) -> PlaneMesh:
    """The triangles of a mesh file.

    Raises
    ------
    FileError
        If the file cannot be read, holds no triangles, is not plane, or has faulty points or cells.
    """
    mesh = read_mesh(path)
    blocks = [block.data[:, :3] for block in mesh.cells if block.type in TRIANGLES and len(block.data)]
    if not blocks:
        raise FileError(f"{path}: holds no triangles")
    cells = np.concatenate(blocks).astype(np.int64)
    used = plane_points(path, mesh, cells)
    left_out = {block.type for block in mesh.cells} - {*TRIANGLES, *NO_FACES}
    return PlaneMesh(mesh.points[used, :2].astype(float), np.searchsorted(used, cells), tuple(sorted(left_out)))


def plane_points(path: Path, mesh: Any, triangles: Integers) -> Integers:
    """The nodes (n,) that triangles (t, 3) of a mesh use, ascending.

    Raises
    ------
    FileError
        If one is not there, has a coordinate that is no number, or they are not plane.
    """
    if triangles.min() < 0 or triangles.max() >= len(mesh.points):
        raise FileError(f"{path}: a triangle has a node that is not there: the file is damaged")
    used = np.unique(triangles)
    points = np.asarray(mesh.points[used], float)
    if not np.isfinite(points).all():
        raise FileError(f"{path}: node {used[~np.isfinite(points).all(axis=1)][0]} has a coordinate that is no number")
    if np.ptp(points[:, 2:], axis=0).max(initial=0) > PLANE * np.ptp(points, axis=0).max():
        raise FileError(f"{path}: is a surface in space: only meshes in the xy plane are read")
    return used


def read_mesh(path: Path) -> Any:
    """The mesh as meshio has it.

    Raises
    ------
    FileError
        If the file cannot be read.
    """
    import meshio

    source = local_copy(path)
    if not source.exists():  # meshio has an error of its own for this
        raise FileError(f"{path}: cannot be read: there is no such file")
    if source.is_file() and source.stat().st_size == 0:
        raise FileError(f"{path}: is empty")
    chatter = io.StringIO()
    try:
        with contextlib.redirect_stdout(chatter), contextlib.redirect_stderr(chatter):
            return meshio.read(source, file_format=FORMAT_OF_ENDING.get(path.suffix))
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {reason(error)}") from error
    except SystemExit as error:  # meshio's answer where no reader of the ending's formats succeeds
        raise FileError(f"{path}: is no mesh of the format that its ending names") from error
    except Exception as error:  # readers of foreign formats fail in any way
        found = shown(error) or type(error).__name__  # some have no text
        raise FileError(f"{path}: is no mesh that can be read ({found})") from error
