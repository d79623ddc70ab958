"""A mesh with regions, lines and points for the tests."""

import dataclasses

import numpy as np
from squares import fields_of, holed_square

from bubblemesh.meshfiles.groups import group_names
from bubblemesh.meshfiles.mesh_files import MeshFiles
from bubblemesh.meshfiles.writing import write_files

ODD = ("on", "no", "äußere Wand", "1, 2", "a'b & <c>")


def sandwich(labels=("bottom", "right", "top", "left", "hole"), regions=("steel", "glass fibre")):
    """The square with a hole, its left third another region, and two labelled points."""
    mesh = holed_square(labels=labels)
    region = (mesh.points[mesh.triangles, 0].mean(axis=1) < mesh.points[:, 0].min() + 1).astype(int)
    owner = {side: k for k, t in enumerate(mesh.triangles.tolist()) for side in zip(t, t[1:] + t[:1], strict=True)}
    between = [side for side, k in owner.items() if region[k] == 0 and region[owner.get(side[::-1], k)] == 1]
    return dataclasses.replace(
        mesh,
        facets=np.vstack([mesh.facets, between]),
        facet_labels=np.append(mesh.facet_labels, np.full(len(between), 5)),
        labels=(*labels, "interface"),
        regions=regions,
        triangle_regions=region,
        labelled_nodes=np.array([0, len(mesh.points) - 1]),
        node_labels=np.array([0, 1]),
        point_labels=("corner", "probe"),
        facet_middles=np.zeros((0, 2)),
    )


def written(mesh, folder, form):
    """Write a mesh in one format, and return the path of its main file."""
    corners = dataclasses.replace(mesh, triangles=mesh.triangles[:, :3], facets=mesh.facets[:, :2])
    files = write_files(mesh, fields_of(corners), {}, MeshFiles(folder, "plate", [form]))["files"]
    return folder / files[0]


def names_of(mesh):
    """Names of labels, regions and points as the groups have them."""
    names = list(group_names(mesh))
    ends = np.cumsum([len(mesh.labels), len(mesh.regions)])
    return names[: ends[0]], names[ends[0] : ends[1]], names[ends[1] :]
