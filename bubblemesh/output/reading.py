"""Reads the triangles of any mesh that meshio reads."""

import contextlib
import io
from pathlib import Path

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import FileError
from bubblemesh.output.atomic import reason

__all__ = ["read_triangles"]

# By the ending alone meshio tries the ANSYS format first, and says so on the standard output.
FORMAT_OF_ENDING = {".msh": "gmsh"}


def read_triangles(path: Path) -> tuple[Floats, Integers]:
    """Points (n, 2) and triangles (t, 3) of a mesh file; a third coordinate is left out.

    Raises
    ------
    FileError
        If the file cannot be read, or holds no triangles.
    """
    import meshio

    try:
        with contextlib.redirect_stdout(io.StringIO()):
            mesh = meshio.read(path, file_format=FORMAT_OF_ENDING.get(path.suffix))
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {reason(error)}") from error
    except (Exception, SystemExit) as error:  # readers of foreign formats fail in any way
        raise FileError(f"{path}: is no mesh that can be read ({error or type(error).__name__})") from error
    blocks = [block.data for block in mesh.cells if block.type == "triangle"]
    if not blocks or not len(np.concatenate(blocks)):
        raise FileError(f"{path}: holds no triangles")
    return np.asarray(mesh.points[:, :2], float), np.concatenate(blocks).astype(np.int64)
