from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose

from bubblemesh.errors import GeometryError
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.rings import ArcTo, LineTo, circle, ellipse, path, polygon, rectangle
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
