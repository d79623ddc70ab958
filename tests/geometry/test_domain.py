from itertools import islice

import matplotlib as mpl
import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.textpath import TextPath
from numpy.testing import assert_allclose

from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.rings import ArcTo, LineTo, SplineTo, circle, ellipse, path, polygon, rectangle

SQUARE_CORNERS = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1.0)])
STAR = [(0, 0), (3, 0), (1.5, 0.8), (3, 3), (0.7, 1.5), (0, 3)]
TRIANGLE = [(0.4, 0.3), (1.0, 0.4), (0.5, 0.9)]
HALF_DISC = path((1, 0), [ArcTo((-1, 0), (0, 0), True), LineTo((1, 0))])
BLOB = path((1, 0), [SplineTo([(0.3, 1.1), (-1, 0.4), (-0.4, -1), (1, 0)])])


def random_points(seed=0, count=2000, low=-1.5, high=1.5):
    return np.random.default_rng(seed).uniform(low, high, (count, 2))


def dense(domain, per_piece=40001):
    boundary = domain.boundary
    for piece, length in enumerate(boundary.lengths):
        yield boundary.points(np.full(per_piece, piece), np.linspace(0, length, per_piece))


def brute_force_distance(domain, points):
    return np.min(
        [shapely.distance(shapely.linestrings(line), shapely.points(points)) for line in dense(domain)], axis=0
    )


def glyphs():
    """Areas bounded by the outlines of letters: pairs of an outer ring and its holes."""
    text = "".join(chr(k) for k in [*range(33, 127), *range(161, 591), *range(913, 1024), *range(1024, 1104)])
    with mpl.rc_context({"path.simplify": False}):
        for letter in filter(str.isprintable, text):
            loops = [loop for loop in TextPath((0, 0), letter, size=100).to_polygons() if len(loop) > 3]
            faces = [shapely.Polygon(loop) for loop in loops]
            if not faces or not all(face.is_valid and face.area > 0 for face in faces):
                continue
            area = faces[0]
            for face in faces[1:]:
                area = area.symmetric_difference(face)
            yield from (part for part in shapely.get_parts(area) if part.is_valid and part.geom_type == "Polygon")


@st.composite
def star_shaped(draw, centre=(0.0, 0.0), least=0.2, most=1.0):
    count = draw(st.integers(4, 20))
    gaps = np.array(draw(st.lists(st.floats(0.4, 1), min_size=count, max_size=count)))  # none of half a turn
    radii = np.array(draw(st.lists(st.floats(least, most), min_size=count, max_size=count)))
    angles = 2 * np.pi * np.cumsum(gaps) / gaps.sum()
    return np.column_stack([centre[0] + radii * np.cos(angles), centre[1] + radii * np.sin(angles)])


CLOSED_FORMS = {
    "disc": (Domain.of(circle((0.2, 0.1), 1)), lambda p: 1 - np.hypot(p[:, 0] - 0.2, p[:, 1] - 0.1)),
    "ring": (
        Domain.of(circle((0, 0), 1.2), [circle((0, 0), 0.5)]),
        lambda p: np.minimum(1.2 - np.hypot(*p.T), np.hypot(*p.T) - 0.5),
    ),
    "square with a tiny hole": (
        Domain.of(rectangle(-2, -2, 2, 2), [circle((0, 0), 0.01)]),
        lambda p: np.minimum(2 - np.abs(p).max(axis=1), np.hypot(*p.T) - 0.01),
    ),
}
SAMPLED = {
    "polygon with a hole": Domain.of(polygon(STAR), [polygon(TRIANGLE)]),
    "ellipse": Domain.of(ellipse((0, 0), (1.2, 0.4), 30)),
    "elliptic hole": Domain.of(rectangle(-1.5, -1.5, 1.5, 1.5), [ellipse((0, 0), (0.3, 0.05), 30)]),
    "half disc": Domain.of(HALF_DISC),
    "spline": Domain.of(BLOB),
    "spline as a hole": Domain.of(rectangle(-2, -2, 2, 2), [BLOB]),
}


@pytest.mark.parametrize(("domain", "expected"), CLOSED_FORMS.values(), ids=CLOSED_FORMS)
def test_signed_distance_of_circles(domain, expected):
    points = random_points()
    assert_allclose(domain.signed_distance(points), expected(points), atol=1e-7)


@pytest.mark.parametrize(("domain", "expected"), CLOSED_FORMS.values(), ids=CLOSED_FORMS)
def test_feet_are_square_to_the_boundary(domain, expected):
    points = random_points(1)
    points = points[(expected(points) > 0) & (np.hypot(*points.T) > 0.3)]  # a centre has no foot of its own
    piece, s, foot, distance = domain.nearest(points)
    assert_allclose(domain.boundary.points(piece, s), foot, atol=1e-13)
    assert_allclose(np.hypot(*(points - foot).T), distance, rtol=1e-13)
    tangents = domain.boundary.tangents(piece, s)
    assert_allclose(np.einsum("ij,ij->i", points - foot, tangents), 0, atol=1e-7)


@pytest.mark.long
@pytest.mark.parametrize("domain", SAMPLED.values(), ids=SAMPLED)
def test_distance_is_that_to_the_densely_sampled_boundary(domain):
    points = random_points(2, 500)
    assert_allclose(domain.nearest(points).distance, brute_force_distance(domain, points), atol=2e-6)


@pytest.mark.parametrize("domain", SAMPLED.values(), ids=SAMPLED)
def test_sign_is_that_of_the_densely_sampled_polygon(domain):
    points = random_points(3)
    rings = {}
    for line, ring in zip(dense(domain), domain.boundary.ring.tolist(), strict=True):
        rings.setdefault(ring, []).append(line[:-1])
    loops = [np.vstack(lines) for lines in rings.values()]
    inside = shapely.contains_xy(shapely.Polygon(loops[0], loops[1:]), *points.T)
    assert ((domain.signed_distance(points) > 0) == inside).all()


@pytest.mark.parametrize("domain", [*SAMPLED.values(), *(d for d, _ in CLOSED_FORMS.values())])
@pytest.mark.parametrize("height", [1e-3, 1e-6, 1e-9])
def test_sign_is_right_next_to_the_curves(domain, height):
    """Nearer than the chords of the polygonal copy are to their arcs."""
    boundary, size = domain.boundary, domain.size
    piece = np.repeat(np.arange(len(boundary.lengths)), 101)
    s = np.tile(np.linspace(0.01, 0.99, 101), len(boundary.lengths)) * boundary.lengths[piece]
    tx, ty = boundary.tangents(piece, s).T
    lift = height * min(size, boundary.lengths.min()) * np.column_stack([-ty, tx])
    foot = boundary.points(piece, s)
    assert_allclose(domain.signed_distance(foot + lift), np.hypot(*lift.T), rtol=1e-4)
    assert_allclose(domain.signed_distance(foot - lift), -np.hypot(*lift.T), rtol=1e-4)


def test_no_points_have_no_distances():
    none = np.zeros((0, 2))
    domain = SAMPLED["half disc"]
    assert domain.signed_distance(none).shape == domain.contains(none).shape == (0,)
    assert domain.nearest(none).foot.shape == (0, 2)


def test_domain_knows_its_extent_and_holes():
    domain = Domain.of(rectangle(-1, 0, 2, 1), [circle((0, 0.5), 0.2), circle((1, 0.5), 0.2)])
    assert domain.bounds == (-1, 0, 2, 1)
    assert domain.size == 3
    assert domain.hole_count == 2
    assert domain.polygon.area == pytest.approx(3 - 0.08 * np.pi, rel=1e-4)


def test_rings_may_turn_either_way():
    outer, hole = polygon(SQUARE_CORNERS), ellipse((0, 0), (0.5, 0.3), 20)
    expected = Domain.of(outer, [hole]).signed_distance(random_points())
    for way in (Domain.of(outer.reversed(), [hole]), Domain.of(outer.reversed(), [hole.reversed()])):
        assert_allclose(way.signed_distance(random_points()), expected, atol=1e-9)


def test_notes_of_all_rings_are_collected():
    double = polygon([*SQUARE_CORNERS, (-1, 1)])
    small = polygon(np.vstack([SQUARE_CORNERS, [(-1, 1)]]) * 0.1)
    assert Domain.of(double, [small]).notes == (
        "duplicate point (-1, 1) merged",
        "duplicate point (-0.1, 0.1) merged",
    )


@pytest.mark.parametrize("scale", [1e15, 1e-12])
def test_scale_does_not_matter(scale):
    outer, hole = SQUARE_CORNERS, ellipse((0, 0), (0.5, 0.3), 20)
    large = ellipse((0, 0), (0.5 * scale, 0.3 * scale), 20)
    expected = Domain.of(polygon(outer), [hole]).signed_distance(random_points())
    found = Domain.of(polygon(outer * scale), [large]).signed_distance(random_points() * scale)
    assert_allclose(found / scale, expected, atol=1e-9)


def test_distance_from_the_origin_does_not_matter():
    far = np.array([1e6, -1e6])
    expected = Domain.of(polygon(SQUARE_CORNERS), [circle((0.5, 0), 0.5)])
    domain = Domain.of(polygon(SQUARE_CORNERS + far), [circle((1e6 + 0.5, -1e6), 0.5)])
    assert len(domain.boundary.corners) == len(expected.boundary.corners) == 5
    assert_allclose(domain.signed_distance(random_points() + far), expected.signed_distance(random_points()), atol=1e-7)


@pytest.mark.long
@given(star_shaped())
@settings(derandomize=True, deadline=None)
def test_star_shaped_rings_bound_a_domain(points):
    domain = Domain.of(polygon(points))
    assert domain.polygon.area == pytest.approx(shapely.Polygon(points).area, rel=1e-12)
    assert domain.boundary.corners.tolist() == points.tolist()
    probes = random_points(4, 50)
    expected = shapely.distance(shapely.LinearRing(points), shapely.points(probes))
    inside = shapely.contains_xy(shapely.Polygon(points), *probes.T)
    assert_allclose(domain.signed_distance(probes), np.where(inside, expected, -expected), atol=1e-12)


@given(star_shaped(least=1.5, most=3), star_shaped(centre=(0.1, -0.2), least=0.1, most=0.3))
@settings(derandomize=True, deadline=None, max_examples=30)
def test_star_shaped_holes_are_cut_out(outer, hole):
    if not shapely.Polygon(outer).contains_properly(shapely.Polygon(hole)):
        return
    domain = Domain.of(polygon(outer), [polygon(hole[::-1])])
    assert domain.polygon.area == pytest.approx(shapely.Polygon(outer).area - shapely.Polygon(hole).area, rel=1e-12)
    within = shapely.get_coordinates(shapely.Polygon(hole).representative_point())
    assert not domain.contains(within).any()


@pytest.mark.long
def test_outlines_of_letters_bound_domains():
    areas = list(islice(glyphs(), 400))
    assert len(areas) == 400
    assert sum(len(area.interiors) for area in areas) > 40
    for area in areas:
        outer, *inner = [shapely.get_coordinates(ring) for ring in (area.exterior, *area.interiors)]
        domain = Domain.of(polygon(outer), [polygon(ring) for ring in inner])
        assert domain.polygon.area == pytest.approx(area.area, rel=1e-9)


def rough_ring(count, seed=0):
    walk = np.cumsum(np.random.default_rng(seed).normal(size=count))
    walk -= np.linspace(0, walk[-1], count)
    turn = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return (1 + 0.1 * walk / np.abs(walk).max())[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])


TREES = {
    "triangle": [[(0, 0), (1, 0), (0, 1)]],
    "coast": [rough_ring(5000)],
    "circle": [np.column_stack([np.cos(TURN), np.sin(TURN)]) for TURN in [np.linspace(0, 6.28, 2000)]],
    "many holes": [
        2 * SQUARE_CORNERS,
        *(rough_ring(n, n) * 0.09 + [x, y] for n, (x, y) in zip(range(3, 103), np.ndindex(10, 10), strict=True)),
    ],
    "far from the origin": [rough_ring(300) + 1e6],
    "huge": [rough_ring(300) * 1e15],
    "tiny": [rough_ring(300) * 1e-12],
}
TREES["many holes"] = [TREES["many holes"][0], *(ring * 0.3 - [1.4, 1.4] for ring in TREES["many holes"][1:])]


@pytest.mark.long
@pytest.mark.parametrize("rings", TREES.values(), ids=TREES)
def test_nearest_chord_is_that_of_brute_force(rings):
    outer, *holes = map(polygon, rings)
    domain = Domain.of(outer, holes)
    low, high = np.min(rings[0], axis=0), np.max(rings[0], axis=0)
    points = np.random.default_rng(0).uniform(low - 0.1 * (high - low), high + 0.1 * (high - low), (2000, 2))
    points = np.vstack([points, domain.polygonal_copy.points[::7], (low + high) / 2])
    chords = [shapely.linestrings(np.stack([ring, np.roll(ring, -1, axis=0)], axis=1)) for ring in map(np.array, rings)]
    exact = shapely.distance(np.concatenate(chords), shapely.points(points)[:, None]).min(axis=1)
    assert_allclose(domain.nearest(points).distance, exact, atol=1e-13 * np.abs(rings[0]).max())


@pytest.mark.parametrize("domain", [*SAMPLED.values(), Domain.of(polygon(rough_ring(3000)))])
def test_clear_points_are_those_far_enough_inside(domain):
    points = random_points(5, 5000)
    distance = np.random.default_rng(6).uniform(0, 0.2, 5000)
    assert (domain.surely_inside(points, distance) == (domain.signed_distance(points) > distance)).all()
    assert domain.surely_inside(points[:0], distance[:0]).shape == (0,)


def test_deep_outside_is_outside_and_far_enough():
    domain = Domain.of(polygon(SQUARE_CORNERS), [circle((0, 0), 0.5)])
    points, depth = random_points(5), np.random.default_rng(6).uniform(0, 0.6, 2000)
    deep, feet = domain.deep_outside(points, depth)
    distance = domain.signed_distance(points)
    np.testing.assert_array_equal(deep, -distance >= depth)
    assert deep.any()
    assert (distance[~deep] > 0).any()
    assert_allclose(np.hypot(*(feet - points).T), np.abs(distance), atol=1e-12)
