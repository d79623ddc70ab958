"""Meshes of the Triangle program."""

import numpy as np
import pytest

from bubblemesh.errors import FileError
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.meshfiles.fields import read_field
from bubblemesh.meshfiles.read import read_mesh

NODES = """# made by hand
5 2 1 1
1  0 0   7    1
2  1 0   7.5  1

3  1 1   8    1  # a corner
4  0 1   9    0
5  .5 .5 1    0
"""
TRIANGLES = "4 3 1\n1 1 2 5 10\n2 2 3 5 10\n3 3 4 5 20\n4 4 1 5 20\n# end\n"
# Of Triangle's six nodes the fourth is across from the first.
CURVED_NODES = "6 2 1 0\n0 0 0 1\n1 1 0 1\n2 0 1 1\n3 .5 .5 1\n4 0 .5 1\n5 .5 0 1\n"
CURVED = "1 6 0\n0 0 1 2 3 4 5\n"


@pytest.fixture
def pair(tmp_path):
    def write(nodes, triangles):
        (tmp_path / "a.node").write_text(nodes)
        (tmp_path / "a.ele").write_text(triangles)
        return tmp_path / "a.ele"

    return write


@pytest.mark.parametrize("ending", [".node", ".ele"])
def test_either_of_the_two_files_gives_the_mesh_and_its_data(pair, ending):
    found = read_mesh(pair(NODES, TRIANGLES).with_suffix(ending))
    assert found.mesh.points.tolist() == [[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.5]]
    assert found.mesh.triangles.tolist() == [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]
    assert found.point_data["attribute"].tolist() == [7, 7.5, 8, 9, 1]
    assert found.point_data["marker"].tolist() == [1, 1, 1, 0, 0]
    assert found.cell_data["attribute"].tolist() == [10, 10, 20, 20]


def test_numbers_may_begin_at_zero_and_heads_may_be_short(pair):
    found = read_mesh(pair("3\n0 0 0\n1 1 0\n2 0 1\n", "1\n0 0 1 2\n"))
    assert found.mesh.triangles.tolist() == [[0, 1, 2]]


def test_nodes_halfway_are_where_they_are(pair):
    field = read_field(pair(CURVED_NODES, CURVED), "attribute")
    areas = signed_areas(field.points, field.triangles)
    np.testing.assert_allclose(areas, 1 / 8)


@pytest.mark.parametrize(
    ("nodes", "triangles", "message"),
    [
        ("# nothing\n", TRIANGLES, "a.node: has no line with the number of nodes"),
        ("0 2 0 0\n", TRIANGLES, "a.node: has no nodes"),
        ("9999999999 2 0 0\n1 0 0\n", TRIANGLES, "it ends too early: it has 1 of 9999999999 nodes"),
        ("3 2 0 0\n1 0 0\n2 1\n3 1 1\n", TRIANGLES, "a.node: has rows of unequal length"),
        ("3 2 5000000 1\n1 0 0\n2 1 1\n3 1 1\n", TRIANGLES, "3 of 5000004 numbers in each row of nodes"),
        ("3 2 -1 0\n1 0 0\n2 1 1\n3 1 1\n", TRIANGLES, "a negative number of attributes"),
        ("3 3 0 0\n1 0 0 0\n2 1 1 0\n3 1 1 1\n", TRIANGLES, "nodes of 3 dimensions: only meshes of the plane"),
        ("3 2 0 0\n1 0 0\n2 1 x\n3 1 1\n", TRIANGLES, "a.node: its nodes are no numbers"),
        ("3 2 0 0\n1 0 0\n4 1 0\n3 1 1\n", "1 3 0\n1 1 2 3\n", "does not number its nodes one after the other"),
        ("1.5 2 0 0\n1 0 0\n", TRIANGLES, "a.node: its numbers of nodes are no whole numbers"),
        (NODES, "", "a.ele"),
        (NODES, "# c\n", "a.ele: has no line with the number of triangles"),
        (NODES, "1 4 0\n1 1 2 3 4\n", "cells of 4 nodes"),
        (NODES, "1 3 0\n1 1 2 9\n", "a node that is not there"),
        (NODES, "1 3 0\n1 1 2 1.5\n", "by whole numbers"),
        (NODES, "1 3 0\n1 1 2 nan\n", "by whole numbers"),
        (NODES, "1 6 0\n1 1 2 3\n", "4 of 7 numbers in each row of triangles"),
    ],
)
def test_what_is_damaged_is_told(pair, nodes, triangles, message):
    with pytest.raises(FileError, match=message):
        read_mesh(pair(nodes, triangles))
