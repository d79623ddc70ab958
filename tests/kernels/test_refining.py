from itertools import product

import numpy as np
import pytest
from twins import needs_compiler

from bubblemesh.kernels.linking import in_order
from bubblemesh.kernels.refining import LEFT_OUT, WHOLE, refined_triangles
from bubblemesh.meshes.edges import directed_sides
from bubblemesh.meshes.quality import signed_areas

pytestmark = needs_compiler

POINTS = np.array([[0, 0], [4, 0], [1, 3], [5, 4.0]])
TRIANGLES, EDGES = in_order(np.array([[0, 1, 2], [2, 1, 3]]), 4)
MIDDLES = POINTS[EDGES].mean(axis=1)


def refined(number, middle):
    return refined_triangles(TRIANGLES, EDGES, np.array(number), np.array(middle))


@pytest.mark.parametrize("halved", list(product([False, True], repeat=5)))
def test_any_edges_are_halved(halved):
    halved = np.array(halved)
    middle = np.where(halved, 3 + np.cumsum(halved), WHOLE)
    triangles, sides = refined(range(4), middle)
    points = np.vstack([POINTS, MIDDLES[halved]])
    areas = signed_areas(points, triangles)
    assert (areas > 0).all()
    assert areas.sum() == signed_areas(POINTS, TRIANGLES).sum()
    assert len(triangles) == 2 + halved.sum() + halved[(EDGES == [1, 2]).all(axis=1)].sum()
    assert len(sides) == 0
    rows = directed_sides(triangles).tolist()
    alone = [side for side in rows if side[::-1] not in rows]
    assert len(alone) == 4 + halved[~(EDGES == [1, 2]).all(axis=1)].sum()  # no node in the middle of a side


def test_parts_with_a_node_that_is_left_out_are_missing_and_their_other_sides_are_told():
    everything, _ = refined(range(4), range(4, 9))
    for gone in range(9):
        numbers = np.where(np.arange(9) == gone, LEFT_OUT, np.arange(9))
        triangles, sides = refined(numbers[:4], numbers[4:])
        missing = [row for row in everything.tolist() if gone in row]
        expected = [row for row in everything.tolist() if gone not in row]
        assert triangles.tolist() == expected
        others = {(row[(row.index(gone) + 1) % 3], row[(row.index(gone) + 2) % 3]) for row in missing}
        assert set(map(tuple, sides.tolist())) == others


def test_sides_between_two_missing_parts_are_not_told():
    triangles, sides = refined([0, LEFT_OUT, 2, LEFT_OUT], [WHOLE] * 5)
    assert len(triangles) == 0
    assert sides.tolist() == [[2, 0]]
    triangles, sides = refined([LEFT_OUT, 1, 2, LEFT_OUT], [WHOLE] * 5)
    assert (len(triangles), len(sides)) == (0, 0)
