"""Meshes at other places: what turns with their triangles, and functions that give no places."""

import dataclasses

import numpy as np
import pytest
from quadrilaterals import mixed
from sandwiches import sandwich

from bubblemesh.errors import CaseError
from bubblemesh.meshes.conformity import require_conforming
from bubblemesh.meshes.mesh import Mesh


def mirror(points):
    return points * [-1, 1]


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("made", [sandwich, mixed])
def test_a_mirrored_mesh_is_turned_round(made, order):
    mesh = made().partitioned(3)
    mesh = mesh if order == 1 else mesh.second_order()[0]
    mirrored = mesh.mapped(mirror)
    require_conforming(mirrored)
    assert (mirrored.sides[:, 0] == mesh.sides[:, 0]).all()  # the same triangles are on the left of all facets
    assert (mirrored.outer == mesh.outer).all()
    assert (mirrored.partition.triangles == mirrored.triangles).all()
    assert mirrored.quality() == pytest.approx(mesh.quality())
    back = mirrored.mapped(mirror)
    for name in ("points", "triangles", "facets", "quads", "facet_middles"):
        np.testing.assert_array_equal(getattr(back, name), getattr(mesh, name))
    if order == 2:  # nodes on edges are between the ends of these
        np.testing.assert_allclose(
            mirrored.points[mirrored.triangles[:, 3:]],
            mirrored.points[mirrored.triangles[:, [[0, 1], [1, 2], [2, 0]]]].mean(axis=2),
            atol=0.1,
        )


def test_a_mirrored_mesh_is_the_same_in_a_file(tmp_path):
    mesh = dataclasses.replace(sandwich(), labelled_nodes=[], node_labels=[])
    mesh.mapped(mirror).write(tmp_path / "a.msh")
    read = Mesh.read(tmp_path / "a.msh")
    np.testing.assert_array_equal(read.facets, mesh.mapped(mirror).facets)


@pytest.mark.parametrize(
    ("function", "text"),
    [
        (lambda points: points[:, 0], r"must give a place \(n, 2\) for each point"),
        (lambda points: None, r"must give a place \(n, 2\)"),
        (lambda points: np.full(points.shape, "a"), r"must give a place \(n, 2\)"),
        (lambda points: np.where(points[:, :1] > 1, np.nan, points), "gives no finite place for the point"),
        (lambda points: np.abs(points - [1.8, -9]), r"turns \d+ of 144 triangles over"),
    ],
)
def test_functions_that_give_no_places_are_refused(function, text):
    with pytest.raises(CaseError, match=f"function: {text}"):
        sandwich().mapped(function)
