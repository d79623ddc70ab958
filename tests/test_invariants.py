"""The checks of every mesh notice what is wrong with one."""

from dataclasses import replace

import numpy as np
import pytest
from invariants import check_mesh

from bubblemesh.meshes.mesh import Mesh

FAN = Mesh(
    [[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.5]],
    [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
    [[0, 1], [1, 2], [2, 3], [3, 0]],
    [0, 0, 1, 1],
    ("a", "b"),
)
LAST_FIRST = np.array([1, 2, 3, 4, 0])  # new numbers: the node inside comes first


def with_facets(facets):
    """The mesh with other facets."""
    return replace(FAN, facets=facets, facet_labels=[0, 1, *[0] * (len(facets) - 2)], facet_middles=np.zeros((0, 2)))


def without(triangle):
    """The mesh without one of its triangles."""
    return replace(FAN, triangles=np.delete(FAN.triangles, triangle, axis=0), triangle_regions=[0, 0, 0])


def test_a_sound_mesh_passes():
    check_mesh(FAN)
    check_mesh(with_facets([*FAN.facets, [0, 4], [4, 2]]))


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        (replace(FAN, points=[*FAN.points, [2, 2]]), "a node is unused"),
        (replace(FAN, points=[*FAN.points[:4], FAN.points[0]]), "two nodes coincide"),
        (
            replace(
                FAN,
                points=FAN.points[np.argsort(LAST_FIRST)],
                triangles=LAST_FIRST[FAN.triangles],
                facets=LAST_FIRST[FAN.facets],
            ),
            "boundary nodes do not come first",
        ),
        (replace(FAN, triangles=[*FAN.triangles[:3], [0, 3, 4]]), "an edge has two triangles on one side"),
        (with_facets([*FAN.facets, [0, 4], [4, 0]]), "a facet is listed twice"),
        (with_facets([*FAN.facets[:3], [0, 3]]), "a facet is no edge of a triangle on its left"),
        (with_facets(FAN.facets[:3]), "outer facets are not the triangles' free edges"),
        (without(3), "a facet is no edge of a triangle on its left"),
        (replace(FAN, points=[*FAN.points[:4], [0.5, 1.5]]), "a triangle is not counter-clockwise"),
        (replace(FAN, labels=("a", "b", "c")), "a label is unused or out of range"),
    ],
)
def test_what_is_wrong_with_a_mesh_is_noticed(mesh, message):
    with pytest.raises(AssertionError, match=message):
        check_mesh(mesh)
