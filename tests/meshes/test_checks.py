"""What meshes are given: arrays and lists that fit, and what is told of those that do not."""

import dataclasses
import re

import numpy as np
import pytest
from squares import holed_square

from bubblemesh import Mesh, MeshWarning
from bubblemesh.errors import CaseError

LISTS = {
    "points": [[0, 0], [2, 0], [2, 2], [0, 2]],
    "triangles": [[0, 1, 2], [0, 2, 3]],
    "facets": [[0, 1], [1, 2], [2, 3], [3, 0]],
    "facet_labels": [0, 0, 1, 1],
    "labels": ["a", "b"],
}
SQUARE = Mesh(**LISTS)
MASKED = np.ma.array(LISTS["points"], mask=[[0, 0], [0, 1], [0, 0], [0, 0]])


def test_lists_are_as_good_as_arrays(tmp_path):
    rest = {"labelled_nodes": [2], "node_labels": [0], "point_labels": ["p"], "quads": [[0, 1]], "periodic": []}
    mesh = Mesh(**LISTS, **rest, fields={"u": [1, 2]}, depth=[1, 2, 3, 4])
    assert (mesh.points.dtype, mesh.triangles.dtype, mesh.depth.dtype) == (float, np.int64, float)
    assert (mesh.labels, mesh.periodic.shape, mesh.triangle_regions.tolist()) == (("a", "b"), (0, 2), [0, 0])
    mesh.write(tmp_path / "a.msh")
    assert Mesh.read(tmp_path / "a.msh").labels == ("a", "b")


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (
            {"points": np.zeros((4, 3))},
            "points: must be real numbers of shape (n, 2) (found the shape (4, 3), type float",
        ),
        ({"points": None}, "points: must be real numbers of shape (n, 2) (found None)"),
        ({"points": [[0, 0], [1]]}, "points: must be an array of real numbers (found rows of unequal length"),
        (
            {"points": [[0, 0], [1, 0], [1, np.nan], [0, 1]]},
            "points: must be finite and at most 1e+70 (found nan in row 2",
        ),
        ({"points": MASKED}, "points: must be finite and at most 1e+70 (found nan in row 1)"),
        (
            {"triangles": [[0, 1, 2], [0, 2, -3]]},
            "triangles: must be indices of 4 nodes, from 0 on (found -3 in row 1)",
        ),
        ({"triangles": [[0, 1, 2], [0, 4, 3]]}, "triangles: must be indices of 4 nodes, from 0 on (found 4 in row 1)"),
        (
            {"triangles": [[0.0, 1, 2]]},
            "triangles: must be whole numbers of shape (t, 3) or (t, 6) (found the shape (1, 3)",
        ),
        ({"facets": [[0, 1, 2]]}, "facets: must be whole numbers of shape (f, 2) (found the shape (1, 3), type int64)"),
        ({"facet_labels": [0, 0, 1, 2]}, "facet_labels: must be indices of 2 labels, from 0 on (found 2 in row 3)"),
        (
            {"facet_labels": [0, 0]},
            "facet_labels: must be whole numbers of shape (4,) (found the shape (2,), type int64)",
        ),
        ({"facet_middles": [[0, 0]]}, "facet_middles: must be real numbers of shape (4, 2) or (0, 2)"),
        ({"labels": "ab"}, "labels: must be a list of texts (found 'ab')"),
        ({"regions": [1]}, "regions: must be a list of texts (found [1])"),
        ({"triangle_regions": [0, 4]}, "triangle_regions: must be indices of 1 region, from 0 on (found 4 in row 1)"),
        ({"labelled_nodes": [9], "node_labels": [0]}, "labelled_nodes: must be indices of 4 nodes"),
        ({"labelled_nodes": [1], "node_labels": [0]}, "node_labels: must be indices of no point labels"),
        ({"periodic": [[0, 4]]}, "periodic: must be indices of 4 facets, from 0 on (found 4 in row 0)"),
        ({"quads": [0, 1]}, "quads: must be whole numbers of shape (q, 2) (found the shape (2,), type int64)"),
        ({"quads": [[0, 2]]}, "quads: must be indices of 2 triangles, from 0 on (found 2 in row 0)"),
        ({"curved_edges": [[0, 1]]}, "curved_middles: must be real numbers of shape (1, 2)"),
        ({"depth": [1, 2]}, "depth: must be real numbers of shape (4,) or (0,) (found the shape (2,), type int64)"),
        ({"metric": np.eye(3)}, "metric: must be real numbers of shape (4, 3) or (0, 3) (found the shape (3, 3)"),
        ({"metric": np.full((4, 3), np.inf)}, "metric: must be finite"),
        (
            {"fields": {"u": [1, 2, 3]}},
            "fields: u: must be real numbers of shape (2,) (found the shape (3,), type int64)",
        ),
        ({"fields": [1]}, "fields: must be a mapping of names to arrays (found [1])"),
        ({"partition": 3}, "partition: must be a Partition or None (found 3)"),
        (
            {"partition": holed_square().partitioned(2).partition},
            "partition: must be one of 2 triangles (found one of 144",
        ),
        ({"geographic": "no"}, "geographic: must be True or False (found 'no')"),
    ],
)
def test_what_does_not_fit_is_told(given, told):
    with pytest.raises(CaseError, match=f"^{re.escape(told)}"):
        dataclasses.replace(SQUARE, **given)


@pytest.mark.parametrize(
    ("facets", "told"),
    [
        ([[0, 1], [1, 2], [2, 3], [3, 1]], "the nodes [3, 1] in row 3 have no edge"),
        ([[0, 1], [1, 2], [2, 3], [0, 0]], "the nodes [0, 0] in row 3 have no edge"),
        ([[0, 1], [2, 1], [2, 3], [3, 0]], "the nodes [2, 1] in row 1 have their triangle on the right"),
        ([[0, 1], [0, 1], [2, 3], [3, 0]], "the nodes [0, 1] in row 1 are there twice with the same label"),
        ([[0, 2], [2, 0], [2, 3], [3, 0]], "the nodes [2, 0] in row 1 are there twice with the same label"),
    ],
)
def test_facets_that_others_would_take_for_other_edges_are_told(facets, told, tmp_path):
    mesh = dataclasses.replace(SQUARE, facets=facets)
    for take in (lambda: mesh.write(tmp_path / "a.inp"), mesh.to_skfem, mesh.to_meshio):
        with pytest.raises(CaseError, match=f"^{re.escape(f'facets: {told}')}"):
            take()
    assert not list(tmp_path.iterdir())


def test_an_inner_edge_may_run_either_way_and_have_two_labels():
    mesh = dataclasses.replace(SQUARE, facets=[[0, 1], [0, 2], [2, 0], [3, 0]])
    mesh = dataclasses.replace(mesh, facet_labels=[0, 0, 1, 1])
    assert {name: len(edges) for name, edges in mesh.to_skfem().boundaries.items()} == {"a": 2, "b": 2}


def test_ids_of_what_is_not_in_the_mesh_are_told(tmp_path):
    mesh = dataclasses.replace(SQUARE, ids={"a": 5, "bb": 7})
    with pytest.warns(MeshWarning, match=r"^ids: unknown label, region or point 'bb'; did you mean 'b'\?") as told:
        mesh.write(tmp_path / "a.msh")
    assert told[0].filename == __file__


def test_a_facet_that_is_no_edge_has_no_node_of_second_order():
    mesh = dataclasses.replace(SQUARE, facets=[[0, 1], [1, 2], [2, 3], [3, 1]])
    with pytest.raises(CaseError, match=r"^facets: the nodes \[3, 1\] have no edge"):
        mesh.second_order()
