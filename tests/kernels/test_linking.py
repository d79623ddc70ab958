import numpy as np
import pytest
from scattered_points import SIDES, SQUARE, scattered
from twins import needs_compiler

from bubblemesh.kernels.linking import in_order, in_order_in_numpy, legalised, without_ties, without_ties_in_numpy
from bubblemesh.meshes.triangulation import _within, linked

pytestmark = needs_compiler


def moved(x, share, seed):
    """Points at other places, by a share of their distance from each other, but for those near the rim."""
    step = share / np.sqrt(len(x)) * np.random.default_rng(seed).uniform(-1, 1, x.shape)
    step[(np.abs(x - 0.5) > 0.35).any(axis=1)] = 0  # triangles there are flat
    return x + step


@pytest.mark.parametrize("seed", range(5))
def test_both_engines_order_triangles_and_edges_alike(seed):
    random = np.random.default_rng(seed)
    triangles, _ = linked(scattered(seed), SIDES)
    mixed = random.permutation(triangles)
    turned = np.take_along_axis(mixed, (np.arange(3) + random.integers(0, 3, (len(mixed), 1))) % 3, axis=1)
    compiled, plain = in_order(turned, 293), in_order_in_numpy(turned, 293)
    for found, expected in zip(compiled, plain, strict=True):
        assert found.dtype == np.int64
        np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(compiled[0], triangles)
    assert len(compiled[1]) == 3 * 293 - 3 - 4
    assert (np.diff(compiled[1][:, 0] * 293 + compiled[1][:, 1]) > 0).all()


@pytest.mark.parametrize(("origin", "spared"), [(0.0, 15), (1e6, 10)])
def test_flips_lead_to_the_triangulation_made_anew(origin, spared):
    found = flipped = 0
    for seed in range(20):
        before, after = scattered(seed) + origin, moved(scattered(seed), 0.1, seed + 50) + origin
        triangles, _ = linked(before, SIDES)
        expected = linked(after, SIDES)
        legal = legalised(triangles, before, after, SIDES)
        if legal is not None:
            found += 1
            flipped += not np.array_equal(legal[0], triangles)
            for mine, theirs in zip(legal[:2], expected, strict=True):
                np.testing.assert_array_equal(mine, theirs)
    assert found >= spared
    assert flipped > spared // 2


def test_facets_inside_stay():
    x = np.vstack([SQUARE, [[0.5, 0.3], [0.5, 0.7]], scattered(4, 8)[4:]])
    x = x[np.append(True, np.hypot(*(x[1:] - [0.5, 0.5]).T) > 0.1)]  # none near the middle of the wall
    wall = np.array([[4, 5]])
    facets, two_sided = np.vstack([SIDES, wall]), np.arange(5) == 4
    triangles, edges = linked(x, facets, two_sided)
    after = moved(x, 0.05, 1)
    after[4:6] = x[4:6]
    found = legalised(triangles, x, after, facets)
    assert found is not None
    np.testing.assert_array_equal(found[1], linked(after, facets, two_sided)[1])
    assert [4, 5] in found[1].tolist()
    assert [4, 5] in edges.tolist()


@pytest.mark.parametrize(
    "x",
    [
        pytest.param([*SQUARE, [2.0, 0.5]], id="inverted"),
        pytest.param([*SQUARE, [0.5, 0.0]], id="flat"),
        pytest.param([*SQUARE, [np.nan, 0.5]], id="no number"),
    ],
)
def test_what_a_node_inverts_is_left_to_the_triangulation(x):
    start = np.array([*SQUARE, [0.5, 0.5]])
    triangles, _ = linked(start, SIDES)
    assert legalised(triangles, start, np.array(x), SIDES) is None


def across(triangles, side):
    """The ends of a side, and the other node of its triangle."""
    corners = triangles.ravel()
    first = side - side % 3
    return corners[side], corners[first + (side + 1) % 3], corners[first + (side + 2) % 3]


@pytest.mark.parametrize("seed", range(5))
def test_twins_are_sides_of_the_same_edge_with_a_triangle_each(seed):
    before, after = scattered(seed), moved(scattered(seed), 0.1, seed + 50)
    found = legalised(linked(before, SIDES)[0], before, after, SIDES)
    assert found is not None
    inner = np.flatnonzero(found.twins.ravel() >= 0)
    assert len(inner) == found.triangles.size - len(SIDES)
    for side in inner.tolist():
        twin = int(found.twins.ravel()[side])
        assert found.twins.ravel()[twin] == side
        assert across(found.triangles, side)[:2] == across(found.triangles, twin)[1::-1]


def test_what_is_known_of_a_triangulation_comes_back_until_a_node_crosses_a_circle_or_a_side():
    wall = np.array([[4, 5]])
    x = np.vstack([SQUARE, [[0.4, 0.2], [0.43, 0.75]]])
    facets = np.vstack([SIDES, wall])
    triangles, edges = linked(x, facets, np.arange(5) == 4)
    known = legalised(triangles, x, x, facets)
    assert legalised(triangles, x, x, facets, known) is known
    np.testing.assert_array_equal(known.triangles, triangles)
    np.testing.assert_array_equal(known.edges, edges)
    # All edges but the sides and the wall may be turned.
    turned = {tuple(sorted(across(triangles, side)[:2])) for side in np.flatnonzero(known.twins.ravel() >= 0)}
    assert turned == {tuple(edge) for edge in edges.tolist()} - {(4, 5), (0, 1), (1, 2), (2, 3), (0, 3)}
    for place, legal in [([0.405, 0.2], True), ([0.4, 0.0], False), ([1.2, 0.5], False), ([np.nan, 0.5], False)]:
        moved_one = x.copy()
        moved_one[4] = place
        assert (legalised(known.triangles, x, moved_one, facets, known) is known) == legal
    for seed in range(20):
        before, after = scattered(seed), moved(scattered(seed), 0.02, seed + 50)
        known, anew = (legalised(linked(y, SIDES)[0], y, y, SIDES) for y in (before, after))
        if known is not None and anew is not None:
            again = legalised(known.triangles, before, after, SIDES, known)
            assert (again is known) == np.array_equal(known.triangles, anew.triangles)
            for mine, theirs in zip(again, anew, strict=True):
                np.testing.assert_array_equal(mine, theirs)


@pytest.mark.parametrize("seed", range(5))
def test_flips_go_on_from_what_is_known_as_from_triangles_alone(seed):
    x = scattered(seed)
    known = legalised(linked(x, SIDES)[0], x, x, SIDES)
    for step in range(10):
        after = moved(x, 0.1, 100 * seed + step)
        alone, known = legalised(known.triangles, x, after, SIDES), legalised(known.triangles, x, after, SIDES, known)
        if known is None:  # where rounding decides
            break
        for mine, theirs in zip(known, alone, strict=True):
            np.testing.assert_array_equal(mine, theirs)
        x = after
    assert step > 1


def test_of_four_nodes_on_a_circle_the_lowest_has_the_edge():
    for triangles in ([[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]]):
        found = legalised(np.array(triangles), SQUARE, SQUARE, SIDES)
        np.testing.assert_array_equal(found.triangles, [[0, 1, 2], [0, 2, 3]])
        plain, _ = without_ties_in_numpy(np.array(triangles), SQUARE, SIDES)
        np.testing.assert_array_equal(plain, [[0, 1, 2], [0, 2, 3]])
    kite = np.array([[0.0, 0], [1, 0], [1.1, 1.1], [0, 1]])  # whose other edge is the right one
    found = legalised(np.array([[0, 1, 2], [0, 2, 3]]), SQUARE, kite, SIDES)
    np.testing.assert_array_equal(found.triangles, [[0, 1, 3], [1, 2, 3]])


def ring_of(nodes):
    return np.column_stack([nodes, np.roll(nodes, -1)])


def grid_of_cells(rows, columns, across, turned):
    """Nodes of a grid and the ring around it: the four nodes of each cell lie on a circle."""
    x = np.stack(np.meshgrid(np.arange(columns), across * np.arange(rows)), axis=-1).reshape(-1, 2)
    number = np.arange(rows * columns).reshape(rows, columns)
    ring = np.concatenate([number[0, :-1], number[:-1, -1], number[-1, :0:-1], number[:0:-1, 0]])
    c, s = np.cos(turned), np.sin(turned)
    return x @ np.array([[c, s], [-s, c]]), ring_of(ring)


def nodes_on_a_circle(count, inside, seed):
    angle = 2 * np.pi * np.arange(count) / count
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    more = np.random.default_rng(seed).uniform(-0.5, 0.5, (inside, 2))
    return np.vstack([circle, more]), ring_of(np.arange(count))


TIES = {
    **{f"grid {r} x {c}": grid_of_cells(r, c, 1.0, 0.0) for r, c in ((2, 2), (2, 9), (5, 4), (8, 8))},
    "flat cells": grid_of_cells(6, 5, 0.5, 0.0),
    "turned": grid_of_cells(6, 7, 1.0, 0.3),
    **{f"circle of {n}": nodes_on_a_circle(n, 0, 0) for n in (4, 6, 12, 24)},
    "circle with nodes inside": nodes_on_a_circle(16, 2, 3),
}


@pytest.mark.parametrize("name", TIES)
@pytest.mark.parametrize("seed", range(6))
def test_both_engines_take_the_same_edges_between_nodes_on_circles(name, seed):
    x, ring = TIES[name]
    number = np.random.default_rng(seed).permutation(len(x))
    mixed = np.empty_like(x)
    mixed[number] = x
    facets = number[ring]
    triangles = _within(mixed, facets, None)
    compiled = without_ties(triangles, mixed, facets)
    plain = without_ties_in_numpy(triangles, mixed, facets)
    for mine, other in zip(compiled, plain, strict=True):
        np.testing.assert_array_equal(mine, other)
    assert len(compiled[0]) == len(triangles)
    if name.startswith("circle of"):  # a fan around the lowest one
        assert (compiled[0][:, 0] == 0).all()


def test_flips_go_on_where_nodes_that_stay_lie_on_a_circle():
    """As the corners of a square region that is one spacing wide: no triangulation of all is needed in each cycle."""
    square, (scattered_ones, (x0, y0)) = SQUARE * 0.05 + 0.5, (scattered(1), (0.5, 0.5))
    far = np.hypot(*(scattered_ones - [x0 + 0.025, y0 + 0.025]).T) > 0.06
    before = np.vstack([SQUARE, square, scattered_ones[4:][far[4:]]])
    facets = np.vstack([SIDES, SIDES + 4])
    two_sided = np.arange(8) >= 4
    after = before.copy()
    after[8:] += np.random.default_rng(2).uniform(-0.002, 0.002, (len(before) - 8, 2))
    triangles, _ = linked(before, facets, two_sided)
    found = legalised(triangles, before, after, facets)
    for mine, anew in zip(found[:2], linked(after, facets, two_sided), strict=True):
        np.testing.assert_array_equal(mine, anew)


def test_nodes_that_invert_triangles_flip_edges_on_their_way():
    found = inverted = 0
    for seed in range(20):
        before, after = scattered(seed), moved(scattered(seed), 0.45, seed + 50)
        triangles, _ = linked(before, SIDES)
        (ax, ay), (bx, by), (cx, cy) = (after[triangles[:, k]].T for k in range(3))
        some = ((bx - ax) * (cy - ay) - (cx - ax) * (by - ay) < 0).any()
        legal = legalised(triangles, before, after, SIDES)
        if legal is not None:
            found += 1
            inverted += some
            for mine, theirs in zip(legal[:2], linked(after, SIDES), strict=True):
                np.testing.assert_array_equal(mine, theirs)
    assert found >= 10
    assert inverted >= 8
