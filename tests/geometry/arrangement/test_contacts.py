from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import minimize_scalar
from sweeps import sweep

from bubblemesh.errors import GeometryError
from bubblemesh.geometry.arrangement import CONTACT_LENGTH, contacts
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.polygonal_copy import PolygonalCopy
from bubblemesh.geometry.rings import ArcTo, LineTo, SplineTo, circle, ellipse, path, polygon, rectangle
from bubblemesh.meshes.triangulation import triangulated

SQUARE = rectangle(-1, -1, 1, 1)
DISC = circle((0, 0), 1)


def polar(radius, angle):
    return radius * np.cos(angle), radius * np.sin(angle)


def turned(points, angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray(points) @ np.array([[c, s], [-s, c]])


CONTACTS = {
    "hole vertex in the middle of a side": (SQUARE, [polygon([(0.3, -1), (0.5, 0), (0, 0)])], (0.3, -1)),
    "hole vertex in the middle of an oblique side": (
        polygon(turned([(-1, -1), (1, -1), (1, 1), (-1, 1)], 0.3)),
        [polygon(turned([(0.3, -1), (0.5, 0), (0, 0)], 0.3))],
        turned((0.3, -1), 0.3),
    ),
    "hole vertex on a vertex": (SQUARE, [polygon([(-1, -1), (0.5, 0), (0, 0.5)])], (-1, -1)),
    "outer vertex on a hole's side": (
        polygon([(-1, -1), (1, -1), (1, 1), (0, 0.3), (-1, 1)]),
        [rectangle(-0.5, -0.3, 0.5, 0.3)],
        (0, 0.3),
    ),
    "outer vertex on a round hole": (
        polygon([(-1, -1), (1, -1), (1, 1), polar(0.5, 1.3), (-1, 1)]),
        [circle((0, 0), 0.5)],
        polar(0.5, 1.3),
    ),
    "circle tangent to a side": (SQUARE, [circle((0.1, -0.5), 0.5)], (0.1, -1)),
    "circle tangent to an oblique side": (
        polygon(turned([(-1, -1), (1, -1), (1, 1), (-1, 1)], 0.7)),
        [circle(turned((0.1, -0.5), 0.7), 0.5)],
        turned((0.1, -1), 0.7),
    ),
    "ellipse tangent to a side": (SQUARE, [ellipse((0, -0.8), (0.5, 0.2))], (0, -1)),
    "small circle tangent to a long side": (SQUARE, [circle((0.1, -0.999), 0.001)], (0.1, -1)),
    "circle tangent to the circle around it": (DISC, [circle(polar(0.6, 1), 0.4)], polar(1, 1)),
    "large circle tangent to the circle around it": (DISC, [circle(polar(0.1, 2.5), 0.9)], polar(1, 2.5)),
    "two holes tangent to each other": (DISC, [circle(polar(-0.2, 1), 0.2), circle(polar(0.3, 1), 0.3)], (0, 0)),
    "two square holes in a vertex": (
        SQUARE,
        [rectangle(-0.5, -0.5, 0, 0), rectangle(0, 0, 0.5, 0.5)],
        (0, 0),
    ),
    "hole inside an arc": (
        path((1, 0), [ArcTo((-1, 0), (0, 0), True), LineTo((1, 0))]),
        [circle(polar(0.75, 1.2), 0.25)],
        polar(1, 1.2),
    ),
    **{
        f"hole vertex on a circle at {angle}": (
            DISC,
            [polygon([polar(1, angle), polar(0.3, angle + 0.4), polar(0.3, angle - 0.4)])],
            polar(1, angle),
        )
        for angle in (0, 0.3, 0.35, 2.2, -1.234)
    },
}


def edges_of(domain):
    """Boundary edges between the points of the polygonal copy, and the coordinates of these."""
    boundary, line = domain.boundary, domain.polygonal_copy
    node = boundary.closed[line.piece] | (line.s > 0)
    return np.vstack([boundary.corners, line.points[node]]), boundary.edges(line.piece[node], line.s[node])[0]


@cache
def domain_of(name):
    """The domain of a contact: two tests look at it."""
    outer, holes, _ = CONTACTS[name]
    return Domain.of(outer, holes)


@pytest.mark.parametrize("name", CONTACTS)
def test_rings_that_touch_share_one_corner_there(name):
    outer, holes, place = CONTACTS[name]
    domain = domain_of(name)
    boundary = domain.boundary
    distance = np.hypot(*(boundary.corners - place).T)
    near = np.flatnonzero(distance < 1e-3)
    assert len(near) == 1
    assert distance[near[0]] < 2e-5
    assert set(boundary.ring[boundary.start == near[0]]) == set(boundary.ring[boundary.end == near[0]])
    assert len(set(boundary.ring[boundary.start == near[0]])) == 2
    given = sum(len(set(ring.vertices)) for ring in (outer, *holes))
    assert len(boundary.corners) <= given + 1


@pytest.mark.parametrize("name", CONTACTS)
def test_domains_with_a_contact_have_edges_to_triangulate(name):
    points, edges = edges_of(domain_of(name))
    triangles = triangulated(points, edges)
    (ax, ay), (bx, by) = points[edges[:, 0]].T, points[edges[:, 1]].T
    (ux, uy), (vx, vy) = (points[triangles[:, k]].T - points[triangles[:, 0]].T for k in (1, 2))
    assert np.sum(ux * vy - uy * vx) == pytest.approx(np.sum(ax * by - bx * ay), rel=1e-12)
    assert set(triangles.ravel()) == set(range(len(points)))


@pytest.mark.parametrize("scale", [1e15, 1e-12])
@pytest.mark.parametrize("offset", [0, 1e3])
def test_contacts_are_found_at_any_scale(scale, offset):
    low, high = (offset - 1) * scale, (offset + 1) * scale
    hole = circle((offset * scale, (offset - 0.5) * scale), 0.5 * scale)
    domain = Domain.of(rectangle(low, low, high, high), [hole])
    assert len(domain.boundary.corners) == 5
    assert_allclose(domain.boundary.corners[4], [offset * scale, low], atol=2e-5 * scale)


@pytest.mark.parametrize("gap", [1e-2, 1e-4, 1e-6, 1e-8])
def test_rings_with_a_gap_between_them_do_not_touch(gap):
    domain = Domain.of(DISC, [circle((0.5 - gap, 0), 0.5)])
    assert len(domain.boundary.corners) == 0
    assert domain.boundary.closed.all()


def test_three_holes_may_hang_together():
    holes = [circle((-0.4, 0), 0.2), circle((0, 0), 0.2), circle((0.4, 0), 0.2)]
    domain = Domain.of(DISC, holes)
    assert_allclose(np.sort(domain.boundary.corners[:, 0]), [-0.2, 0.2], atol=2e-5)


def test_many_contacts_of_one_ring_are_all_found():
    radius = 0.05
    row = [circle((2 * radius * k - 0.9, 0), radius) for k in range(12)]
    along = [circle(polar(0.98, k), 0.02) for k in range(6)]
    boundary = Domain.of(DISC, [*row, *along]).boundary
    assert len(boundary.corners) == 17
    for expected in [*((2 * radius * k - 0.85, 0) for k in range(11)), *(polar(1, k) for k in range(6))]:
        near = np.flatnonzero(np.hypot(*(boundary.corners - expected).T) < 2e-5)
        assert len(near) == 1
        assert len(set(boundary.ring[boundary.start == near[0]])) == 2


def test_tiny_holes_by_a_large_circle_are_no_contacts():
    tiny = [circle(polar(1 - 3 * 10.0**-k, k), 10.0**-k) for k in range(1, 5)]
    assert len(Domain.of(DISC, tiny).boundary.corners) == 0
    touching = [circle(polar(1 - 10.0**-k, k), 10.0**-k) for k in range(1, 5)]
    assert len(Domain.of(DISC, touching).boundary.corners) == 4


def test_three_holes_may_meet_in_one_point():
    def wedge(angle):
        return polygon([(0, 0), polar(0.5, angle), polar(0.5, angle + 0.5)])

    domain = Domain.of(DISC, [wedge(0), wedge(2), wedge(4)])
    assert len(domain.boundary.corners) == 7


def test_two_holes_may_touch_a_side_in_one_point():
    holes = [polygon([(0.3, -1), (0.5, 0), (0.4, 0)]), polygon([(0.3, -1), (0.2, 0), (0.1, 0)])]
    boundary = Domain.of(SQUARE, holes).boundary
    assert len(boundary.corners) == 9
    assert len(boundary.lengths) == 11
    assert boundary.lengths.min() > 0.05


@pytest.mark.parametrize("angle", range(0, 180, 30))
def test_rings_that_touch_at_two_places_share_one_corner_at_each(angle):
    boundary = contacts.split_at_contacts(Boundary.of([DISC, ellipse((0, 0), (1, 0.5), angle)]))
    assert len(boundary.corners) == 2
    assert_allclose(np.abs(boundary.corners @ polar(1, np.radians(angle))), 1, rtol=0, atol=1e-12)
    assert boundary.ring_corners()[0].tolist() == [0, 0, 1, 1]


def test_labels_survive_the_split_of_a_side():
    outer = rectangle(-1, -1, 1, 1, labels=["bottom", "right", "top", "left"])
    boundary = Domain.of(outer, [circle((0, -0.5), 0.5, label="bore")]).boundary
    names = [boundary.labels[k] for k in boundary.label]
    assert names == ["bottom", "bottom", "right", "top", "left", "bore"]
    assert_allclose(boundary.lengths, [1, 1, 2, 2, 2, np.pi])


@pytest.mark.parametrize("away", [1e-2, 1e-4, 1e-6, 1e-7])
def test_a_ring_that_touches_a_straight_side_beside_its_corner_shares_a_corner_there(away):
    side, touching = polygon([(0, 0), (0.4, 0), (0.4, 0.4)]), polygon([(away, 0), (0, -0.4), (-0.4, -0.4)])
    boundary = Domain.of(SQUARE, [side, touching]).boundary
    assert len(boundary.corners) == 10
    (corner,) = np.flatnonzero((boundary.corners == (away, 0)).all(axis=1))
    assert sorted(boundary.ring[boundary.start == corner]) == [1, 2]
    assert boundary.lengths.min() == pytest.approx(away)


@pytest.mark.parametrize("away", [1e-9, 1e-12, 1e-15])
@pytest.mark.parametrize("way", [(1, 0), (0, -1), (-0.6, -0.8)])
def test_corners_of_two_rings_that_are_nearly_one_are_told_with_their_place(away, way):
    side = polygon([(0.25, 0), (0.4, 0), (0.4, 0.4)])
    beside = polygon([(0.25 + away * way[0], away * way[1]), (0.2, -0.4), (-0.4, -0.4)])
    with pytest.raises(GeometryError, match=r"two rings have corners at \(0.25, -?0\) that are .* apart, next to each"):
        Domain.of(SQUARE, [side, beside])


def test_corners_of_one_ring_that_are_nearly_one_stay():
    ring = polygon([(0, 0), (1, 0), (1, 1), (1, 1 + 5e-10), (0, 1)])
    assert len(Domain.of(ring).boundary.corners) == 5


def touching_spline(random):
    """A closed spline, and a circle that touches it from inside anywhere."""
    knots = [polar(random.uniform(0.9, 1.1), 2 * np.pi * k / 7) for k in range(7)]
    ring = path(knots[0], [SplineTo((*knots[1:], knots[0]))])
    curve, radius = Boundary.of([ring]), random.uniform(0.02, 0.15)
    at = [0], random.uniform(0, curve.lengths)
    (point,), ((x, y),) = curve.points(*at), curve.tangents(*at)
    return [ring, circle(point + radius * np.array([-y, x]), radius)]


def touching_ellipse(random):
    """A box, and a turned ellipse on its lowest side."""
    (long, short), angle = random.uniform(0.1, 0.9, 2), random.uniform(0, 180)
    high = np.hypot(long * np.sin(np.radians(angle)), short * np.cos(np.radians(angle)))
    return [rectangle(-2, 0, 2, 3), ellipse((random.uniform(-0.5, 0.5), high), (long, short), angle)]


def touching_row(random):
    """A circle, with circles along its diameter, each of which touches the next one."""
    radii = random.uniform(0.05, 0.15, 5)
    middles, angle = np.cumsum(2 * radii) - radii - 0.9, random.uniform(0, 7)
    return [DISC, *(circle(polar(x, angle), radius) for x, radius in zip(middles, radii, strict=True))]


TOUCHING_RINGS = {
    "spline": touching_spline,
    "ellipse": touching_ellipse,
    "row": touching_row,
    "arc and side": lambda random: [CONTACTS["hole inside an arc"][0], circle((0, 0.5), 0.5)],
    "vertex": lambda random: [DISC, polygon([polar(r, random.uniform(k, k + 1)) for k, r in enumerate((0.3, 0.4, 1))])],
    "two ends of an ellipse": lambda random: [DISC, ellipse((0, 0), (1, 0.5), random.uniform(0, 180))],
    "four sides": lambda random: [SQUARE, DISC],
    "near, and not touching": lambda random: [DISC, circle(polar(0.6 - random.uniform(2e-9, 1e-7), 3), 0.4)],
}


def contacts_one_by_one(boundary, line, tolerance, splits):
    """What `contacts._contacts` finds, by an optimiser from SciPy for one candidate after the other."""
    found = []
    for probe, chord in zip(*contacts._candidates(boundary, line, tolerance), strict=True):
        piece, s, step, other = line.piece[probe], line.s[probe], line.step[probe], np.array([chord])
        pair = min(line.ring[[probe, chord]]) * len(line.area_of_ring) + max(line.ring[[probe, chord]])

        def point(at, piece=piece):
            return boundary.points(np.array([piece]), np.array([at % boundary.lengths[piece]]))

        def gap(at, point=point, other=other):
            return np.hypot(*(point(at) - contacts._feet(boundary, line, other, point(at))[1])[0])

        corner = boundary.start[piece] >= 0 and s == 0
        bounded = {"bounds": (s - step, s + step), "method": "bounded", "options": {"xatol": 0}}
        nearest = line.points[probe] if corner else point(minimize_scalar(gap, **bounded).x)[0]
        (along,), (foot,) = contacts._feet(boundary, line, other, nearest[None])
        own = line.piece[chord]
        to_end = np.inf if boundary.closed[own] else min(along, boundary.lengths[own] - along)
        straight = not boundary.curved[[piece, own]].any()
        unknown = splits[pair] < contacts.MOST_SPLITS and all(
            pair != one[3] and np.hypot(*(nearest - one[2])) > CONTACT_LENGTH * tolerance for one in found
        )
        inside = to_end > (tolerance if straight else CONTACT_LENGTH * tolerance)
        if unknown and inside and np.hypot(*(nearest - foot)) <= tolerance:
            found.append((own, along, nearest, pair))
    return contacts.Touches(*map(np.array, zip(*found, strict=True) if found else [()] * 4))


@pytest.mark.parametrize("seed", sweep(range(20), quick=1))
@pytest.mark.parametrize("name", TOUCHING_RINGS)
def test_contacts_are_those_that_an_optimiser_finds_one_by_one(name, seed, monkeypatch):
    boundary = Boundary.of(TOUCHING_RINGS[name](np.random.default_rng(seed)))
    found = contacts.split_at_contacts(boundary)
    monkeypatch.setattr(contacts, "_contacts", contacts_one_by_one)
    expected = contacts.split_at_contacts(boundary)
    for column in ("start", "end", "ring", "kind", "index", "closed"):
        np.testing.assert_array_equal(getattr(found, column), getattr(expected, column))
    assert_allclose(found.corners, expected.corners, rtol=0, atol=2e-7)
    assert_allclose(found.lengths, expected.lengths, rtol=0, atol=4e-7)
    assert (len(found.corners) > len(boundary.corners)) == (name not in ("vertex", "near, and not touching"))


def test_many_rings_next_to_each_other_take_no_more_steps_than_few(monkeypatch):
    def steps(count):
        taken = []
        with monkeypatch.context() as patch:
            foot = Boundary.foot
            patch.setattr(Boundary, "foot", lambda *given, **named: taken.append(1) or foot(*given, **named))
            rings = [circle((x, y), 0.499) for x in range(count) for y in range(count)]
            assert contacts.split_at_contacts(Boundary.of(rings)).closed.all()
        return len(taken)

    assert steps(2) == steps(5) > 1


def test_of_contacts_in_one_place_the_first_is_taken():
    points = np.array([(0, 0), (0.9, 0), (1.8, 0), (9, 9), (0, 0)], float)
    np.testing.assert_array_equal(contacts._first_of_places(points, 1.0), [True, False, False, True, False])


def test_distances_to_shared_corners_are_those_to_each_of_them():
    holes = [polygon([(0, 0), polar(0.9, k), polar(0.9, k + 0.5), polar(0.4, k + 0.4)]) for k in range(5)]
    boundary = Boundary.of([SQUARE, *holes, polygon([polar(0.9, 0), polar(0.9, 0.5), (0.95, 0.4)])])
    line = PolygonalCopy.of(boundary)
    probe, chord = np.divmod(np.arange(len(line.points) ** 2), len(line.points))
    corner, ring = boundary.ring_corners()
    found = contacts._to_shared_corner(boundary, line, probe, chord)
    for one, other, distance in zip(probe, chord, found, strict=True):
        shared = np.intersect1d(corner[ring == line.ring[one]], corner[ring == line.ring[other]])
        away = np.hypot(*(boundary.corners[shared] - line.points[one]).T)
        assert distance == away.min(initial=np.inf)
    assert set(np.isinf(found)) == {True, False}
