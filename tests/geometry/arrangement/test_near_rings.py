"""Rings that are near to others: only their chords are compared with each other."""

import numpy as np
import shapely

from bubblemesh.geometry.arrangement.contacts import _near, _of_near_rings
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.polygonal_copy import PolygonalCopy
from bubblemesh.geometry.rings import circle, rectangle

REACH = 1e-3


def copy_of(*circles):
    holes = [circle(centre, radius).reversed() for centre, radius in circles]
    return PolygonalCopy.of(Boundary.of([rectangle(0, 0, 9, 9), *holes]))


def test_points_and_chords_are_those_found_without_looking_at_rings():
    line = copy_of(((2, 2), 1), ((4, 2), 1), ((7.9995, 7), 1), ((2, 7), 0.5), ((2, 5.9), 0.5995))
    reach = np.full(len(line.points), REACH)
    points, chords = shapely.points(line.points), shapely.linestrings(np.stack(line.chords[3:], axis=1))
    within = shapely.dwithin(points[:, None], chords, REACH) & (line.ring[:, None] != line.ring)
    probe, chord = np.nonzero(within)
    found = _near(line, reach)
    np.testing.assert_array_equal(found, [probe, chord])
    assert {tuple(pair) for pair in np.sort(line.ring[np.array(found)].T)} == {(0, 3), (1, 2), (4, 5)}


def test_rings_that_are_far_from_all_others_are_left_out():
    line = copy_of(*(((x, y), 0.3) for x in range(1, 9) for y in range(1, 9)), ((4.5, 1), 0.2))
    some = _of_near_rings(line, np.full(len(line.points), REACH))
    assert len(some) > 0
    assert set(line.ring[some]) == {25, 33, 65}
