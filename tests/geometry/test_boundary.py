from collections import Counter

import numpy as np
import pytest
from numpy.testing import assert_allclose

from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.polygonal_copy import PolygonalCopy
from bubblemesh.geometry.rings import ArcTo, LineTo, SplineTo, circle, ellipse, path, polygon, rectangle

D_SHAPE = path((0, -1), [ArcTo((0, 1), (0, 0), True, "bow"), LineTo((0, -1), "flat")])
RINGS = [
    rectangle(-4, -4, 4, 4),
    circle((2, 2), 1).reversed(),
    D_SHAPE.reversed(),
    ellipse((-2, 2), (1, 0.5)).reversed(),
]
PLATE = Boundary.of(RINGS)


def nodes_on(boundary, count, rng):
    """Random nodes, two at least on each closed piece."""
    closed = np.flatnonzero(boundary.closed)
    piece = np.concatenate([rng.integers(0, len(boundary.kind), count), closed, closed])
    return piece, rng.random(len(piece)) * boundary.lengths[piece]


def loops(edges):
    successor = dict(edges.tolist())
    while successor:
        loop = [next(iter(successor))]
        while loop[-1] in successor:
            loop.append(successor.pop(loop[-1]))
        yield loop


def signed_area(points):
    x, y = points.T
    return np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) / 2


def test_pieces_keep_ring_label_and_corners():
    assert PLATE.ring.tolist() == [0, 0, 0, 0, 1, 2, 2, 3]
    assert [PLATE.labels[k] for k in PLATE.label] == ["outer"] * 4 + ["hole-1", "flat", "bow", "hole-3"]
    assert PLATE.closed.tolist() == [False] * 4 + [True, False, False, True]
    assert PLATE.curved.tolist() == [False] * 4 + [True, False, True, True]
    assert len(PLATE.corners) == 6
    assert_allclose(PLATE.lengths[:6], [8, 8, 8, 8, 2 * np.pi, 2])


@pytest.mark.parametrize("boundary", [PLATE, Boundary.of([circle((0, 0), 1)]), Boundary.of([D_SHAPE])])
def test_pieces_run_from_corner_to_corner(boundary):
    pieces = np.flatnonzero(~boundary.closed)
    assert_allclose(
        boundary.points(pieces, np.zeros(len(pieces))), boundary.corners[boundary.start[pieces]], atol=1e-14
    )
    assert_allclose(
        boundary.points(pieces, boundary.lengths[pieces]), boundary.corners[boundary.end[pieces]], atol=1e-14
    )


def test_evaluation_of_mixed_families_is_that_of_one_piece_at_a_time():
    piece, s = nodes_on(PLATE, 60, np.random.default_rng(0))
    for method in (PLATE.points, PLATE.tangents):
        together = method(piece, s)
        for k in range(len(piece)):
            assert_allclose(together[k], method(piece[k : k + 1], s[k : k + 1])[0], rtol=1e-13, atol=1e-15)


def test_wrapping_clips_open_pieces_and_runs_on_in_closed_ones():
    piece = np.array([0, 0, 4, 4])
    assert_allclose(PLATE.wrapped(piece, np.array([-1, 9.0, -1, 7])), [0, 8, 2 * np.pi - 1, 7 - 2 * np.pi])


def test_feet_are_where_the_points_lie_square_to_the_curve():
    piece, s = nodes_on(PLATE, 20, np.random.default_rng(5))
    inner = PLATE.closed[piece] | ((s > 0.1) & (s < PLATE.lengths[piece] - 0.1))
    piece, s = piece[inner], s[inner]
    points, tangents = PLATE.points(piece, s), PLATE.tangents(piece, s)
    beside = points + 1e-3 * np.column_stack([-tangents[:, 1], tangents[:, 0]])
    foot = PLATE.foot(beside, piece, PLATE.wrapped(piece, s + 0.01), steps=12, longest=0.02)
    assert_allclose(PLATE.points(piece, foot), points, atol=1e-9)


def test_polyline_lies_on_the_boundary_and_closes_each_ring():
    line = PolygonalCopy.of(PLATE)
    assert_allclose(line.points, PLATE.points(line.piece, line.s), atol=1e-14)
    assert_allclose(PLATE.points(line.piece, line.s + line.step), line.points[line.successor], atol=1e-14)
    assert_allclose(np.bincount(line.piece, line.step), PLATE.lengths)
    assert (line.ring[line.successor] == line.ring).all()
    assert sorted(line.successor.tolist()) == list(range(len(line.points)))
    edges = np.column_stack([np.arange(len(line.points)), line.successor])
    areas = [signed_area(line.points[loop[:-1]]) for loop in loops(edges)]
    assert_allclose(areas, [64, -np.pi, -np.pi / 2, -np.pi / 2], rtol=2e-4)


def test_polyline_keeps_the_coordinates_of_corners_exactly():
    line = PolygonalCopy.of(Boundary.of([polygon([(0.1, 0.2), (1.3, 0.7), (0.4, 1.9)])]))
    assert line.points.tolist() == [[0.1, 0.2], [1.3, 0.7], [0.4, 1.9]]


@pytest.mark.parametrize("seed", range(5))
def test_edges_pass_every_node_once_with_the_domain_on_their_left(seed):
    piece, s = nodes_on(PLATE, 80, np.random.default_rng(seed))
    edges, edge_piece = PLATE.edges(piece, s)
    count = len(PLATE.corners) + len(piece)
    assert sorted(edges[:, 0]) == sorted(edges[:, 1]) == list(range(count))
    assert Counter(edge_piece.tolist()) == Counter([*piece.tolist(), *np.flatnonzero(~PLATE.closed).tolist()])
    points = np.vstack([PLATE.corners, PLATE.points(piece, s)])
    areas = sorted(signed_area(points[loop[:-1]]) for loop in loops(edges))
    assert len(areas) == 4
    assert areas[-1] == pytest.approx(64)
    # Two nodes on a closed curve make a loop there and back, without area.
    assert max(areas[:-1]) <= 1e-14


def test_edges_follow_the_arc_length_of_their_piece():
    piece, s = nodes_on(PLATE, 40, np.random.default_rng(3))
    edges, edge_piece = PLATE.edges(piece, s)
    first = len(PLATE.corners)
    inner = (edges >= first).all(axis=1)
    a, b = edges[inner].T - first
    assert (piece[a] == edge_piece[inner]).all()
    assert (piece[b] == edge_piece[inner]).all()
    backwards = np.flatnonzero(s[b] < s[a])
    assert sorted(piece[a[backwards]]) == np.flatnonzero(PLATE.closed).tolist()


def test_edges_without_further_nodes_join_the_corners():
    boundary = Boundary.of([rectangle(0, 0, 2, 1)])
    edges, edge_piece = boundary.edges(np.zeros(0, int), np.zeros(0))
    assert edges.tolist() == [[0, 1], [1, 2], [2, 3], [3, 0]]
    assert edge_piece.tolist() == [0, 1, 2, 3]


def split_at(boundary, piece, s):
    piece, s = np.array(piece), np.array(s)
    return boundary.split(piece, s, boundary.points(piece, s))


@pytest.mark.parametrize("count", [0, 9])
def test_arcs_of_the_edges_of_a_piece_follow_each_other_and_make_up_its_length(count):
    piece, s = nodes_on(PLATE, count, np.random.default_rng(2))
    edges, edge_piece = PLATE.edges(piece, s)
    begin, end = PLATE.arcs(edges, edge_piece, s)
    assert (end > begin).all()
    assert_allclose(np.bincount(edge_piece, end - begin), PLATE.lengths)
    nodes = np.vstack([PLATE.corners, PLATE.points(piece, s)])
    assert_allclose(PLATE.points(edge_piece, begin), nodes[edges[:, 0]], atol=1e-12)


def test_splitting_an_open_piece_makes_two_that_meet_at_the_corner():
    split = split_at(PLATE, [6], [1.0])
    assert len(split.corners) == len(PLATE.corners) + 1
    assert_allclose(split.lengths[6:8], [1, np.pi - 1])
    assert split.end[6] == split.start[7] == len(PLATE.corners)
    assert split.ring.tolist() == [0, 0, 0, 0, 1, 2, 2, 2, 3]
    assert split.labels[split.label[6]] == split.labels[split.label[7]] == "bow"
    s = np.linspace(0, np.pi, 50)
    piece = np.where(s <= 1, 6, 7)
    there = split.points(piece, np.where(s <= 1, s, s - 1))
    assert_allclose(there, PLATE.points(np.full(50, 6), s), atol=1e-14)


def test_splitting_a_closed_piece_opens_it_at_the_corner_and_runs_past_its_seam():
    split = split_at(PLATE, [4], [2.0])
    assert not split.closed[4]
    assert split.closed[7]
    assert split.start[4] == split.end[4] == len(PLATE.corners)
    assert split.lengths[4] == PLATE.lengths[4]
    s = np.linspace(0, 2 * np.pi, 100)
    four = np.full(100, 4)
    assert_allclose(split.points(four, s), PLATE.points(four, PLATE.wrapped(four, s + 2)), atol=1e-14)
    again = split_at(split, [4], [5.0])
    assert_allclose(again.points(np.array([5]), np.array([0.5])), split.points(np.array([4]), np.array([5.5])))
    edges, _ = again.edges(np.array([8, 8]), np.array([0.1, 1]))
    assert [6, 7] in edges.tolist()
    assert [7, 6] in edges.tolist()


def test_splitting_at_several_places_is_splitting_one_by_one():
    together = split_at(PLATE, [6, 4, 4, 1], [1.0, 5.0, 2.0, 0.5])
    # Pieces move up behind a cut, and the closed one is opened by its first cut.
    one_by_one = split_at(split_at(split_at(split_at(PLATE, [6], [1.0]), [4], [2.0]), [4], [3.0]), [1], [0.5])
    for name in ("lengths", "offset", "index", "label", "ring"):
        assert_allclose(getattr(together, name), getattr(one_by_one, name))
    for ends in ("start", "end"):
        mine, theirs = getattr(together, ends), getattr(one_by_one, ends)
        assert ((mine < 0) == (theirs < 0)).all()
        assert_allclose(together.corners[mine[mine >= 0]], one_by_one.corners[theirs[mine >= 0]], atol=1e-14)


def test_splitting_at_a_known_corner_uses_it_again():
    boundary = Boundary.of([rectangle(0, 0, 2, 2), polygon([(1, 0), (1.2, 1), (0.8, 1)]).reversed()])
    split = split_at(boundary, [0], [1.0])
    assert len(split.corners) == len(boundary.corners)
    assert split.end[0] == split.start[1] == 4


def test_rings_that_share_a_vertex_share_a_corner():
    boundary = Boundary.of([rectangle(0, 0, 2, 2), polygon([(0, 0), (1, 0.5), (0.5, 1)]).reversed()])
    assert len(boundary.corners) == 6
    assert Counter(boundary.start.tolist())[0] == 2


def test_closed_spline_path_has_one_corner_at_its_start():
    boundary = Boundary.of([path((1, 0), [SplineTo([(0, 1), (-1, 0), (0, -1), (1, 0)])])])
    assert boundary.corners.tolist() == [[1, 0]]
    assert boundary.start.tolist() == boundary.end.tolist() == [0]


def test_split_ellipse_runs_past_its_seam():
    boundary = Boundary.of([ellipse((0, 0), (2, 1))])
    zero = np.zeros(50, int)
    s = np.linspace(0, boundary.lengths[0], 50)
    split = split_at(boundary, [0], [3.0])
    assert_allclose(split.points(zero, s), boundary.points(zero, boundary.wrapped(zero, s + 3)), atol=1e-12)
