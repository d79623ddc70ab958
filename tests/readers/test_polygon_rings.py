"""Rings of straight sides that come from files."""

import numpy as np
import pytest

from bubblemesh.errors import CaseError
from bubblemesh.geometry.rings import LineTo, path
from bubblemesh.readers.features import finite_points, polygon_ring
from bubblemesh.readers.slips import clean_loop

SQUARE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]


@pytest.mark.parametrize("points", [[[0, 1, 5], [2, 3, 5]], [[0, 1], [2, 3, 5]], [(0, 1, None), (2, 3, "high")]])
def test_heights_are_left_out(points):
    assert finite_points(points, "ring") == [(0.0, 1.0), (2.0, 3.0)]


@pytest.mark.parametrize("points", [[[0], [1]], [0, 1], [["a", "b"]], [{}], [[10**400, 1]], [[None, 1]], [[np.inf, 1]]])
def test_what_is_no_pair_of_numbers_is_refused(points):
    with pytest.raises(CaseError, match=r"^ring: "):
        finite_points(points, "ring")


@pytest.mark.parametrize("points", [SQUARE, [*SQUARE, SQUARE[0]]])
def test_a_clean_ring_is_the_path_along_its_points(points):
    ring, slips = polygon_ring(points, "ring", "wall")
    assert ring == path(SQUARE[0], list(map(LineTo, SQUARE[1:])), "wall")
    assert ring.origin == "ring"
    assert slips.notes == ()


def test_slips_are_dropped_and_told():
    ring, slips = polygon_ring([*SQUARE[:2], SQUARE[1], *SQUARE[2:], (0.0, 2.0), SQUARE[3]], "ring")
    assert set(ring.vertices) == set(SQUARE)
    assert (slips.doubles, slips.spikes) == (1, 1)
    start, pieces, same = clean_loop(SQUARE[0], list(map(LineTo, [*SQUARE[1:], SQUARE[0]])))
    assert (start, len(pieces), same.notes) == (SQUARE[0], 4, ())


@pytest.mark.parametrize("points", [[], SQUARE[:1], SQUARE[:2], [SQUARE[0]] * 3, [*SQUARE[:3], SQUARE[1]]])
def test_rings_without_area_are_none(points):
    assert polygon_ring(points, "ring")[0] is None
