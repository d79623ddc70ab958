import numpy as np
import pytest
import shapely
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial import cKDTree

from bubblemesh.geometry.distance.chord_runs import LENGTH, ChordRuns
from bubblemesh.geometry.distance.nearest_chord import nearest_chord, nearest_in_numpy

UNIFORM = np.linspace(0, 2 * np.pi, 1500, endpoint=False)
RANDOM = np.random.default_rng(0)


pytestmark = pytest.mark.usefixtures("each_engine")


def circle(turn, center=(0, 0), radius=1.0):
    return np.asarray(center) + radius * np.column_stack([np.cos(turn), np.sin(turn)])


def ring(points):
    """Starts and ends (m, 2) of the sides of a polygon."""
    points = np.array(points, float)
    return points, np.roll(points, -1, axis=0)


def joined(*parts):
    return tuple(np.concatenate(column) for column in zip(*parts, strict=True))


def rough(count):
    walk = np.cumsum(np.random.default_rng(1).normal(size=count))
    walk -= np.linspace(0, walk[-1], count)
    turn = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return (1 + 0.2 * walk / np.abs(walk).max())[:, None] * circle(turn)


def comb(teeth):
    x = np.linspace(-1, 1, 2 * teeth)
    return np.vstack([np.column_stack([np.repeat(x, 2)[1:-1], np.tile([-0.9, 0.9, 0.9, -0.9], teeth)[1:-1]]), [0, -1]])


SPOTS = RANDOM.uniform(-1, 1, (40, 2))
CHORDS = {
    "one side": (np.array([[-0.5, 0.2]]), np.array([[0.7, -0.1]])),
    "square": ring([(-1, -1), (1, -1), (1, 1), (-1, 1)]),
    "circle": ring(circle(UNIFORM)),
    "circle of uneven sides": ring(circle(np.unique(2 * np.pi * RANDOM.random(700) ** 6))),
    "coast": ring(rough(1500)),
    "comb": ring(comb(300)),
    "holes of all sizes": joined(
        ring([(-1, -1), (1, -1), (1, 1), (-1, 1)]),
        *(ring(circle(UNIFORM[::30], at, 10.0 ** -(1 + k % 5))) for k, at in enumerate(SPOTS)),
    ),
    "triangles": joined(*(ring(circle(UNIFORM[::500], at, 0.02)) for at in SPOTS)),
    "points": (SPOTS, SPOTS),
    "points and a square": joined((SPOTS, SPOTS), ring([(-1, -1), (1, -1), (1, 1), (-1, 1)])),
}


def clouds(start):
    """Points spread about, next to chords and on their ends, in a cluster, and in the middle of everything."""
    rng = np.random.default_rng(2)
    near = start[rng.integers(0, len(start), 250)] + 10 ** rng.uniform(-9, -1, (250, 1)) * rng.normal(size=(250, 2))
    cluster = near[0] + 1e-5 * rng.normal(size=(150, 2))
    middle = 10 ** rng.uniform(-9, -1, (150, 1)) * rng.normal(size=(150, 2))
    return np.vstack([rng.uniform(-1.3, 1.3, (400, 2)), near, start[::20], cluster, middle, [[0, 0], [50, -80]]])


@pytest.mark.parametrize(("start", "end"), CHORDS.values(), ids=CHORDS)
def test_both_engines_find_the_same_chords(start, end):
    runs, random = ChordRuns.of(start, end), np.random.default_rng(3)
    points = np.vstack(
        [clouds(start), start, np.round(8 * start) / 8, (start + end) / 2, random.uniform(-2, 2, (5000, 2))]
    )
    for order in (np.arange(len(points)), random.permutation(len(points))):
        assert_array_equal(nearest_chord(runs, points[order]), nearest_in_numpy(runs, points[order]))
    assert nearest_chord(runs, points[:0]).tolist() == []


@pytest.mark.long
@pytest.mark.parametrize("scale", [1, 1e-70, 1e60])
@pytest.mark.parametrize(("start", "end"), CHORDS.values(), ids=CHORDS)
def test_no_chord_is_nearer(start, end, scale):
    runs = ChordRuns.of(start * scale, end * scale)
    points = clouds(start)
    found = nearest_chord(runs, points * scale)
    lines = shapely.linestrings(np.stack([start, end], axis=1))
    least = np.array([shapely.distance(lines, point).min() for point in shapely.points(points)])
    assert_allclose(shapely.distance(lines[found], shapely.points(points)), least, rtol=1e-12, atol=3e-15)


def test_whole_numbers_are_coordinates_too():
    start, end = CHORDS["square"]
    points = np.array([[0, -2], [3, 0], [0, 2], [-3, 0]])
    assert nearest_chord(ChordRuns.of(start, end), points).tolist() == [0, 1, 2, 3]


def test_no_site_is_nearer():
    sites, points = RANDOM.uniform(-1, 1, (3000, 2)), RANDOM.uniform(-1, 1, (20_000, 2))
    assert_array_equal(nearest_chord(ChordRuns.of(sites, sites), points), cKDTree(sites).query(points)[1])


@pytest.mark.parametrize("offset", [1e3, 1e9])
def test_no_chord_is_nearer_far_from_the_origin(offset):
    away = np.array([offset, -offset])
    start, end = ring(rough(700) + away)
    points = np.random.default_rng(0).uniform(-1.3, 1.3, (250, 2)) + away
    found = nearest_chord(ChordRuns.of(start, end), points)
    lines = shapely.linestrings(np.stack([start, end], axis=1))
    least = np.array([shapely.distance(lines, point).min() for point in shapely.points(points)])
    assert_allclose(shapely.distance(lines[found], shapely.points(points)), least, atol=4e-16 * offset)


def test_first_of_equally_near_chords_is_found():
    # Squares on a grid of whole numbers, and points on a finer one: all distances are exact, and many are equal.
    corner = np.array([(0, 0), (2, 0), (2, 2), (0, 2)])
    start, end = joined(*(ring(corner + 5 * np.array(at)) for at in np.ndindex(6, 6)))
    points = np.stack(np.meshgrid(np.arange(-2, 30, 0.5), np.arange(-2, 30, 0.5)), axis=-1).reshape(-1, 2)
    low, high = np.minimum(start, end)[:, None], np.maximum(start, end)[:, None]
    squared = ((points - np.clip(points, low, high)) ** 2).sum(axis=2)
    assert ((squared == squared.min(axis=0)).sum(axis=0) > 1).sum() > 1000
    assert_array_equal(nearest_chord(ChordRuns.of(start, end), points), squared.argmin(axis=0))


def test_before_a_corner_the_chord_that_ends_there_is_found():
    start, end = CHORDS["circle"]
    beyond = np.concatenate([start * out for out in 1 + RANDOM.uniform(0, 1, 5)])
    expected = np.maximum(np.arange(len(start)) - 1, 0)
    assert_array_equal(nearest_chord(ChordRuns.of(start, end), beyond), np.tile(expected, 5))


def test_last_chord_of_a_short_run_is_found_beside_its_end():
    start, end = CHORDS["one side"]
    along, away = 1e-9 * RANDOM.random((5000, 1)), RANDOM.random((5000, 1))
    way = (end - start) / np.hypot(*(end - start)[0])
    points = end - along * way + away * way[:, ::-1] * [1, -1]
    assert (nearest_chord(ChordRuns.of(start, end), points) == 0).all()


@pytest.mark.parametrize("name", ["circle", "coast", "holes of all sizes"])
def test_answer_for_a_point_does_not_depend_on_the_others(name):
    start, end = CHORDS[name]
    runs, points = ChordRuns.of(start, end), clouds(start)
    found = nearest_chord(runs, points)
    order = np.random.default_rng(0).permutation(len(points))
    assert_array_equal(nearest_chord(runs, points[order]), found[order])
    some = order[:40]
    assert_array_equal(nearest_chord(runs, points[some]), found[some])
    assert [nearest_chord(runs, points[[k]])[0] for k in some] == found[some].tolist()


def test_runs_hold_every_chord_once_and_do_not_leap():
    start, end = CHORDS["holes of all sizes"]
    runs = ChordRuns.of(start, end)
    assert_array_equal(
        np.concatenate([np.arange(a, a + n) for a, n in zip(runs.first, runs.count, strict=True)]),
        np.arange(len(start)),
    )
    assert runs.count.max() == LENGTH
    for k, (first, count) in enumerate(zip(runs.first, runs.count, strict=True)):
        assert_array_equal(np.column_stack([runs.x[:, k], runs.y[:, k]])[:count], start[first : first + count])
        assert_array_equal(end[first : first + count - 1], start[first + 1 : first + count])
        assert (np.column_stack([runs.x[:, k], runs.y[:, k]])[count:] == end[first + count - 1]).all()


@pytest.mark.parametrize("name", ["circle", "coast", "comb", "triangles"])
def test_rectangles_hold_their_runs(name):
    start, end = CHORDS[name]
    runs = ChordRuns.of(start, end)
    every = np.arange(len(runs.first))
    assert (runs.at_least(runs.x, runs.y, every) == 0).all()
    px, py = clouds(start)[:500].T[:, :, None]
    lines = shapely.linestrings(np.stack([runs.x.T, runs.y.T], axis=2))
    near = shapely.distance(lines, shapely.points(px, py))
    assert (runs.at_least(px, py, every) <= near**2 * (1 + 1e-12)).all()
    far = np.hypot(px[..., None] - runs.x.T, py[..., None] - runs.y.T).max(axis=2)
    assert (runs.at_most(px, py, every) >= far * (1 - 1e-12)).all()


def test_no_points_have_no_chords():
    runs = ChordRuns.of(*CHORDS["square"])
    assert nearest_chord(runs, np.zeros((0, 2))).shape == (0,)
