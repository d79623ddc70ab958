"""Triangles of second order."""

import dataclasses

import meshio
import numpy as np
import pytest
from sandwiches import sandwich, written

from bubblemesh.errors import CaseError
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.formats import FORMATS
from bubblemesh.meshfiles.mesh_files import MeshFiles
from bubblemesh.meshfiles.writing import write_files


def test_second_order_adds_one_node_for_each_edge():
    mesh = sandwich()
    curved, straight = mesh.second_order()
    assert (curved.order, straight) == (2, 0)
    pairs, _ = unique_edges(mesh.triangles)
    assert len(curved.points) == len(mesh.points) + len(pairs)
    corners = curved.points[curved.triangles[:, :3]]
    for k in range(3):
        middle = (corners[:, k] + corners[:, (k + 1) % 3]) / 2
        np.testing.assert_allclose(curved.points[curved.triangles[:, 3 + k]], middle, atol=1e-15)
    np.testing.assert_allclose(
        curved.points[curved.facets[:, 2]], curved.points[curved.facets[:, :2]].mean(axis=1), atol=1e-15
    )
    np.testing.assert_array_equal(np.unique(curved.triangles), np.arange(len(curved.points)))


@pytest.mark.parametrize("form", [name for name, form in FORMATS.items() if 2 in form.orders])
def test_second_order_survives(tmp_path, form):
    mesh, _ = sandwich(regions=("a", "b")).second_order()
    path = written(mesh, tmp_path, form)
    if form in {"inp", "inp-strain"}:
        return  # read by a parser of its own above; meshio knows one of the two kinds only
    if form in {"pvtu", "msh4"}:
        return  # read in test_partition_files.py; meshio knows no lists, and numbers nodes by their entities
    read = meshio.read(path, file_format="gmsh" if path.suffix == ".msh" else None)
    np.testing.assert_array_equal(read.points[:, :2], mesh.points)
    np.testing.assert_array_equal(read.cells_dict["triangle6"], mesh.triangles)
    if form == "xdmf":
        read = meshio.read(tmp_path / "plate_facets.xdmf")
    if form in {"msh", "msh-ascii", "xdmf", "med"}:
        np.testing.assert_array_equal(read.cells_dict["line3"], mesh.facets)


@pytest.mark.parametrize("form", [name for name, form in FORMATS.items() if 2 not in form.orders])
def test_formats_without_second_order_say_so(tmp_path, form):
    mesh, _ = sandwich().second_order()
    with pytest.raises(CaseError, match=rf"{form} has no form for triangles of order 2: choose among msh, vtu"):
        write_files(mesh, {}, {}, MeshFiles(tmp_path / "new", "plate", ["msh", form]))
    assert list(tmp_path.iterdir()) == []


def test_a_triangle_that_would_fold_over_stays_straight():
    triangle = Mesh(
        points=np.array([[0.0, 0], [1, 0], [0.5, 0.1]]),
        triangles=np.array([[0, 1, 2]]),
        facets=np.array([[0, 1], [1, 2], [2, 0]]),
        facet_labels=np.zeros(3, int),
        labels=("a",),
        facet_middles=np.array([[0.5, 0.2], [0.75, 0.05], [0.25, 0.05]]),
    )
    curved, straight = triangle.second_order()
    assert straight == 1
    np.testing.assert_array_equal(curved.points[curved.facets[0, 2]], [0.5, 0])
    outward, straight = dataclasses.replace(
        triangle, facet_middles=np.array([[0.5, -0.05], [0.75, 0.05], [0.25, 0.05]])
    ).second_order()
    assert straight == 0
    np.testing.assert_array_equal(outward.points[outward.facets[0, 2]], [0.5, -0.05])
