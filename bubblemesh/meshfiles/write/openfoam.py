"""For OpenFOAM, whose meshes have volume: one layer of prisms over the triangles, as Gmsh's format 2.2 in ASCII."""

from pathlib import Path

import numpy as np

from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.meshfiles.groups import Fields, Group, facet_ids, group_names, region_ids
from bubblemesh.meshfiles.names import plain_words
from bubblemesh.meshfiles.text import write_text
from bubblemesh.meshfiles.write.gmsh import Block, msh_text

FRONT, BACK = "front", "back"


def patch_names(mesh: Mesh) -> dict[str, str]:
    """Return the name of each label's patch and of each region's zone."""
    return plain_words(mesh, reserved=(FRONT.upper(), BACK.upper()), dimensions=(1, 2))


def write_openfoam(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write a layer of prisms from z = 0, whose height is the side of a square as large as the mean triangle.

    Labels become patches of quadrilaterals, regions cell zones; the triangles at z = 0 are the patch ``back``, those
    above ``front``. Labelled points and the fields have no place.
    """
    n, names, words = len(mesh.points), group_names(mesh), patch_names(mesh)
    groups = [(word, Group(names[name].id, names[name].dimension + 1)) for name, word in words.items()]
    front, back = len(names) + 1, len(names) + 2
    height = float(np.sqrt(signed_areas(mesh.points, mesh.triangles).mean()))
    points = np.vstack([np.pad(mesh.points, ((0, 0), (0, 1)), constant_values=z) for z in (0.0, height)])
    below, above = mesh.triangles, mesh.triangles + n
    all_of = np.ones(len(below), np.int64)
    blocks = [
        Block("quad", np.hstack([mesh.facets, mesh.facets[:, ::-1] + n]), facet_ids(mesh)),
        Block("triangle", above, front * all_of),
        Block("triangle", below[:, ::-1], back * all_of),
        Block("wedge", np.hstack([below, above]), region_ids(mesh)),
    ]
    write_text(path, msh_text(points, blocks, [*groups, (FRONT, Group(front, 2)), (BACK, Group(back, 2))]))
