"""Rings and lines where similarities take them."""

import numpy as np
import pytest

from bubblemesh.geometry import rings
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.paths import Arc, Ellipse, Polyline, Ring, Side, Spline
from bubblemesh.geometry.rings import ArcTo, LineTo, SplineTo
from bubblemesh.geometry.similarity import UNMOVED, Similarity

MOVES = [
    Similarity.of(move=(3, -2)),
    Similarity.of(rotate=37, about=(1, 2)),
    Similarity.of(mirror="x"),
    Similarity.of(mirror="y", rotate=200),
    Similarity.of(mirror="x", scale=2.5, rotate=-77, about=(0.3, 0), move=(1, 1)),
]
ALL_KINDS = rings.path(
    (0, 0),
    [
        LineTo((2, 0), "floor"),
        ArcTo((2, 2), (2, 1), True, "nose"),
        SplineTo([(1, 2.3), (0.4, 1.9), (0, 1)], "roof"),
        ArcTo((0, 0), (-1, 0.5), False, "bay"),
    ],
)
WAVE = np.column_stack([np.linspace(0, 1, 9), np.sin(np.linspace(0, 3, 9))])
CLAMPED = Ring(
    (Side(Spline(WAVE, np.array([[0.6, 0.8], [1.0, 0.0]]))), Side(Polyline(WAVE[::-1].copy()))),
    ((0.0, 0.0), (1.0, 0.1)),
)
SHAPES = [ALL_KINDS, rings.circle((1, 2), 0.5), rings.ellipse((1, 2), (0.5, 0.2), 30), CLAMPED]


@pytest.mark.parametrize("move", MOVES)
@pytest.mark.parametrize("ring", SHAPES)
def test_every_place_of_a_ring_is_where_the_similarity_takes_it(ring, move):
    before, after = Boundary.of([ring]), Boundary.of([ring.moved(move)])
    assert after.lengths == pytest.approx(move.scale * before.lengths)
    piece = np.repeat(np.arange(len(before.kind)), 7)
    share = np.tile(np.linspace(0, 0.99, 7), len(before.kind))
    expected = move.points(before.points(piece, share * before.lengths[piece]))
    found = after.points(piece, share * after.lengths[piece])
    np.testing.assert_allclose(found, expected, atol=1e-12)
    np.testing.assert_allclose(after.corners, move.points(before.corners), atol=1e-12)
    assert [type(side.curve) for side in ring.moved(move).sides] == [type(side.curve) for side in ring.sides]
    assert [side.label for side in ring.moved(move).sides] == [side.label for side in ring.sides]


def test_the_order_is_mirror_scale_rotate_move():
    move = Similarity.of(mirror="x", scale=2, rotate=90, about=(1, 0), move=(10, 0))
    # (1, 3) mirrored (-1, 3), scaled (-2, 6), from the centre (-3, 6) turned (-6, -3), so (-5, -3), moved (5, -3)
    assert move.point((1, 3)) == (5, -3)


def test_quarter_turns_are_exact():
    square = rings.rectangle(0.1, 0.2, 0.3, 0.7)
    for degrees in (90, 180, 270, -90, 450):
        turned = {tuple(map(abs, vertex)) for vertex in square.moved(Similarity.of(rotate=degrees)).vertices}
        flipped = {vertex[::-1] for vertex in turned}
        assert {*square.vertices} in (turned, flipped)


def test_what_is_not_moved_stays_to_the_last_bit():
    (side,) = rings.circle((0.1, 1 / 3), 0.7).moved(UNMOVED).sides
    assert side.curve == Arc((0.1, 1 / 3), 0.7, 0.0, 2 * np.pi)
    (side,) = rings.ellipse((0.1, 1 / 3), (0.7, 0.2), 20).moved(UNMOVED).sides
    assert side.curve == Ellipse((0.1, 1 / 3), (0.7, 0.2), np.radians(20), 1.0)


def test_one_after_the_other():
    one, other = MOVES[4], MOVES[3]
    assert one.then(other).point((0.3, 0.8)) == pytest.approx(other.point(one.point((0.3, 0.8))))
    assert one.then(UNMOVED) == one
