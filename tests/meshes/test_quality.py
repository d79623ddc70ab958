import math
from collections import Counter
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.quality import (
    Measures,
    Shape,
    angles,
    radius_ratios,
    shape_quality,
    signed_areas,
    spacing_fit,
    worst_triangles,
)

EQUILATERAL = np.array([[0, 0], [1, 0], [0.5, math.sqrt(3) / 2]])
ONE = np.array([[0, 1, 2]])


def random_mesh(seed, nodes=60):
    points = np.random.default_rng(seed).random((nodes, 2))
    return points, Delaunay(points).simplices.astype(np.int64)


def side_lengths(points, triangle):
    i, j, k = triangle
    return math.dist(points[j], points[k]), math.dist(points[k], points[i]), math.dist(points[i], points[j])


def reference_ratio(points, triangle):
    a, b, c = side_lengths(points, triangle)
    if abs(reference_area(points, triangle)) <= 1e-14 * (a + b + c) ** 2:
        return 0.0
    return (b + c - a) * (c + a - b) * (a + b - c) / (a * b * c)


def reference_area(points, triangle):
    (ax, ay), (bx, by), (cx, cy) = (points[i] for i in triangle)
    return ((bx - ax) * (cy - ay) - (by - ay) * (cx - ax)) / 2


def reference_angles(points, triangle):
    a, b, c = side_lengths(points, triangle)
    return [
        math.degrees(math.acos((v * v + w * w - u * u) / (2 * v * w))) for u, v, w in ((a, b, c), (b, c, a), (c, a, b))
    ]


def reference_edges(triangles):
    return Counter(tuple(sorted(pair)) for i, j, k in triangles.tolist() for pair in pairwise((i, j, k, i)))


def reference_quantile(values, share):
    ordered = sorted(values)
    place = share * (len(ordered) - 1)
    low = math.floor(place)
    high = min(low + 1, len(ordered) - 1)
    return ordered[low] + (place - low) * (ordered[high] - ordered[low])


def reference_irregular(nodes, triangles):
    counted = reference_edges(triangles)
    boundary = {node for edge, count in counted.items() if count == 1 for node in edge}
    valence = Counter(node for edge in counted for node in edge)
    inner = [node for node in range(nodes) if valence[node] and node not in boundary]
    return sum(valence[node] != 6 for node in inner) / len(inner) if inner else None


@pytest.mark.parametrize("seed", range(5))
def test_each_triangle_agrees_with_a_plain_loop(seed):
    points, triangles = random_mesh(seed)
    np.testing.assert_allclose(
        radius_ratios(points, triangles), [reference_ratio(points, t) for t in triangles], rtol=0, atol=1e-12
    )
    np.testing.assert_allclose(
        signed_areas(points, triangles), [reference_area(points, t) for t in triangles], rtol=0, atol=1e-15
    )
    np.testing.assert_allclose(
        angles(points, triangles), [reference_angles(points, t) for t in triangles], rtol=0, atol=1e-9
    )


@pytest.mark.parametrize("seed", range(5))
def test_the_summary_agrees_with_a_plain_loop(seed):
    points, triangles = random_mesh(seed, nodes=200)
    ratios = [reference_ratio(points, t) for t in triangles]
    corners = [angle for t in triangles for angle in reference_angles(points, t)]
    shape = shape_quality(Measures(points, triangles))
    assert shape.mean == pytest.approx(sum(ratios) / len(ratios), abs=1e-12)
    assert shape.min == pytest.approx(min(ratios), abs=1e-12)
    assert shape.p01 == pytest.approx(reference_quantile(ratios, 0.01), abs=1e-12)
    assert shape.irregular_fraction == pytest.approx(reference_irregular(len(points), triangles), abs=1e-15)
    assert shape.angle_min == pytest.approx(min(corners), abs=1e-9)
    assert shape.angle_max == pytest.approx(max(corners), abs=1e-9)
    counted = Counter(min(int(10 * q), 9) for q in ratios)
    assert shape.histogram == tuple(counted[i] for i in range(10))


@pytest.mark.parametrize("seed", range(3))
def test_the_spacing_fit_agrees_with_a_plain_loop(seed):
    points, triangles = random_mesh(seed)
    pairs, _ = unique_edges(triangles)
    target = 0.05 + points[pairs].mean(axis=1)[:, 0]
    ratios = [math.dist(points[i], points[j]) / d for (i, j), d in zip(pairs.tolist(), target, strict=True)]
    mean = sum(ratios) / len(ratios)
    fit = spacing_fit(points, pairs, target)
    assert fit.mean == pytest.approx(mean, abs=1e-12)
    assert fit.std == pytest.approx(math.sqrt(sum((r - mean) ** 2 for r in ratios) / len(ratios)), abs=1e-12)
    assert fit.p01 == pytest.approx(reference_quantile(ratios, 0.01), abs=1e-12)
    assert fit.p99 == pytest.approx(reference_quantile(ratios, 0.99), abs=1e-12)


def test_known_triangles():
    right = np.array([[0.0, 0], [3, 0], [0, 4]])
    assert radius_ratios(EQUILATERAL, ONE)[0] == pytest.approx(1)
    assert radius_ratios(right, ONE)[0] == pytest.approx(2 * 1 / 2.5)
    assert angles(right, ONE)[0] == pytest.approx([90, math.degrees(math.atan2(4, 3)), math.degrees(math.atan2(3, 4))])
    assert signed_areas(right, ONE)[0] == 6
    assert signed_areas(right, ONE[:, ::-1])[0] == -6


@given(
    st.floats(1e-12, 1e12),
    st.floats(0, 7),
    st.tuples(st.floats(-10, 10), st.floats(-10, 10)),
    st.permutations([0, 1, 2]),
)
def test_the_ratio_knows_neither_size_nor_place_nor_order(size, turn, shift, order):
    points = np.array([[0.0, 0], [1, 0.1], [0.3, 0.8]])
    rotation = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    moved = size * (points @ rotation + np.array(shift))
    expected = radius_ratios(points, ONE)
    np.testing.assert_allclose(radius_ratios(moved, np.array([order])), expected, rtol=1e-11)


@pytest.mark.parametrize(
    "points",
    [
        [[0, 0], [1, 1], [2, 2]],
        [[0, 0], [0, 0], [1, 0]],
        [[0, 0], [0, 0], [0, 0]],
        [[0, 0], [1, 0], [0.5, 1e-15]],
    ],
)
def test_a_degenerate_triangle_has_ratio_zero(points):
    assert radius_ratios(np.array(points, float), ONE)[0] == 0


def test_the_limit_of_degeneracy_is_the_area_beside_the_perimeter():
    for base, degenerate in ((7e-14, True), (9e-14, False)):
        needle = np.array([[0, 0], [base, 0], [0, 1]])
        assert (radius_ratios(needle, ONE)[0] == 0) == degenerate


def test_angles_of_flat_and_of_pointlike_triangles():
    assert angles(np.array([[0.0, 0], [1, 0], [3, 0]]), ONE)[0].tolist() == [0, 180, 0]
    assert np.isnan(angles(np.zeros((3, 2)), ONE)).all()
    beside = np.vstack([EQUILATERAL, EQUILATERAL[:1]])
    assert Measures(beside, np.array([[0, 1, 2], [0, 1, 3]])).angle_range == (0, 180)


def test_an_equilateral_triangle_is_in_the_last_bin_whatever_rounding_does():
    turns = np.linspace(0, 2, 200)
    points = np.concatenate([EQUILATERAL @ [[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]] for a in turns])
    triangles = np.arange(600).reshape(-1, 3)
    assert (radius_ratios(points, triangles) > 1).any()
    assert shape_quality(Measures(points, triangles)).histogram == (*[0] * 9, 200)


def test_one_triangle_has_no_inner_node():
    shape = shape_quality(Measures(EQUILATERAL, ONE))
    assert isinstance(shape, Shape)
    assert shape.irregular_fraction is None


@pytest.mark.parametrize(("valence", "irregular"), [(5, 1.0), (6, 0.0), (7, 1.0)])
def test_a_wheel_is_regular_with_six_spokes(valence, irregular):
    turn = 2 * np.pi * np.arange(valence) / valence
    points = np.concatenate([np.stack([np.cos(turn), np.sin(turn)], axis=1), [[0, 0], [9, 9]]])
    spokes = np.arange(valence)
    triangles = np.stack([spokes, np.roll(spokes, -1), np.full(valence, valence)], axis=1)
    assert shape_quality(Measures(points, triangles)).irregular_fraction == irregular  # the unused node does not count


def test_worst_triangles_come_in_order():
    points, triangles = random_mesh(3)
    worst = worst_triangles(Measures(points, triangles), 5)
    ranked = sorted((reference_ratio(points, t), tuple(points[t].mean(axis=0))) for t in triangles)[:5]
    np.testing.assert_allclose([q for q, _ in worst], [q for q, _ in ranked], atol=1e-12)
    np.testing.assert_allclose([place for _, place in worst], [place for _, place in ranked])
    assert len(worst_triangles(Measures(points, triangles), 10_000)) == len(triangles)


@pytest.mark.parametrize("equal", [1, 3, 20])
def test_of_equally_bad_triangles_the_first_ones_are_told(equal):
    """A row of right triangles: the worst are alike in shape, but for their places."""
    heights = np.array([1.0] * 20 + [0.1] * equal + [2.0])
    points = np.concatenate([[[4 * k, 0], [4 * k + 1, 0], [4 * k, h]] for k, h in enumerate(heights)])
    triangles = np.arange(len(points)).reshape(-1, 3)
    worst = worst_triangles(Measures(points, triangles), 5)
    order = sorted(range(len(heights)), key=lambda k: (reference_ratio(points, triangles[k]), k))
    assert [x for _, (x, _) in worst] == pytest.approx([4 * k + 1 / 3 for k in order[:5]])


def test_measures_are_those_of_the_single_functions_and_made_once():
    points, triangles = random_mesh(4)
    measures = Measures(points, triangles)
    for found, alone in (
        (measures.radius_ratios, radius_ratios),
        (measures.angles, angles),
        (measures.signed_areas, signed_areas),
    ):
        assert found.tobytes() == alone(points, triangles).tobytes()
    assert measures.radius_ratios is measures.radius_ratios
    assert measures.edges[0].tolist() == [list(pair) for pair in sorted(reference_edges(triangles))]
