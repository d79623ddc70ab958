"""Faces: rings traced from pieces in any order."""

import numpy as np
import pytest
import shapely

from bubblemesh.geometry import rings
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.faces import compact, face
from bubblemesh.geometry.paths import Area, Line, OpenPath, Side
from bubblemesh.geometry.polygonal_copy import PolygonalCopy

SQUARE = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)]


def polygon(*points):
    return rings.polygon(np.array(points, float), ["side"] * len(points))


def shuffled(boundary, seed):
    """The boundary with its pieces in any order and without ring numbers, and which of them bound it."""
    order = np.random.default_rng(seed).permutation(len(boundary.kind))
    mixed = boundary.select(order)
    return mixed, ~mixed.inner


DOMAINS = {
    "square": Domain.of(polygon(*SQUARE)),
    "hole": Domain.of(polygon(*SQUARE), [polygon((1, 1), (2, 1), (2, 2)), rings.circle((3, 3), 0.5, "bore")]),
    "touching hole": Domain.of(polygon(*SQUARE), [polygon((4, 4), (3, 1), (1, 3))]),
    "areas": Domain.of_areas(
        [
            Area(polygon(*SQUARE), (polygon((1, 1), (3, 1), (3, 3), (1, 3)),)),
            Area(polygon((1.5, 1.5), (2.5, 1.5), (2.5, 2.5), (1.5, 2.5)), (rings.circle((2, 2), 0.2, "hole"),)),
        ]
    ),
    "touching areas": Domain.of_areas([Area(polygon(*SQUARE)), Area(polygon((4, 4), (6, 4), (6, 6)))]),
}


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("name", DOMAINS)
def test_rings_are_found_again_in_any_order_of_their_pieces(name, seed):
    domain = DOMAINS[name]
    mixed, rim = shuffled(domain.boundary, seed)
    traced, pieces = face(mixed, rim)
    found = PolygonalCopy.of(traced).polygon()
    assert found.is_valid
    assert found.equals(domain.polygon) or shapely.hausdorff_distance(found, domain.polygon) < 1e-12
    assert found.area == pytest.approx(domain.polygon.area, rel=1e-12)
    assert sorted(traced.area_of_ring) == sorted(domain.boundary.area_of_ring)
    np.testing.assert_array_equal(traced.lengths, mixed.lengths[pieces])


def test_lobes_that_meet_in_a_corner_are_areas_of_their_own():
    points = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [2, 1], [2, 2], [1, 2]], float)
    around = [[(0, 1), (1, 2), (2, 3), (3, 0)], [(2, 4), (4, 5), (5, 6), (6, 2)]]
    sides = [Line(tuple(points[a].tolist()), tuple(points[b].tolist())) for loop in around for a, b in loop]
    paths = [OpenPath((Side(side),), (side.start, side.end), "rim") for side in sides]
    boundary = Boundary.empty().with_inner(paths)
    traced, _ = face(boundary, np.ones(8, bool))
    assert traced.area_of_ring == (0, 1)
    assert PolygonalCopy.of(traced).polygon().area == pytest.approx(2)


def test_inner_pieces_come_after_the_rings():
    boundary = DOMAINS["hole"].boundary.with_inner(
        [OpenPath((Side(Line((0.5, 3.0), (1.5, 3.5))),), ((0.5, 3.0), (1.5, 3.5)), "crack")]
    )
    mixed, rim = shuffled(boundary, 3)
    traced, _ = face(mixed, rim)
    assert traced.inner.tolist() == [False] * (len(traced.kind) - 1) + [True]
    assert traced.labels[traced.label[-1]] == "crack"


def test_a_compact_boundary_has_what_its_pieces_need():
    boundary = DOMAINS["hole"].boundary
    triangle = np.flatnonzero(boundary.ring == 1)
    small, corners = compact(boundary.select(triangle), np.array([0]))
    assert len(small.families) == 1
    assert len(small.families[0].lengths) == 3
    assert small.labels == ("side",)
    np.testing.assert_array_equal(small.corners, boundary.corners[corners])
    assert (small.corners[0] == boundary.corners[0]).all()  # it was to stay
    middle = small.lengths / 2
    np.testing.assert_allclose(small.points(np.arange(3), middle), boundary.points(triangle, middle), rtol=1e-15)
