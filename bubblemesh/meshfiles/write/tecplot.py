"""Tecplot's text format, triangles only."""

from pathlib import Path
from typing import Any

import numpy as np

from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.groups import Fields, region_ids


def write_tecplot(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write the triangles as one zone, their region ids as ``material`` and the fields."""
    import meshio

    data: dict[str, Any] = {"material": [region_ids(mesh).astype(float)]}
    data |= {name: [np.asarray(values, float)] for name, values in fields.items()}
    meshio.Mesh(mesh.points, [("triangle", mesh.triangles)], cell_data=data).write(path, file_format="tecplot")
