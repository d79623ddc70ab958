"""Domains of several separate areas."""

import re

import numpy as np
import pytest
import shapely

from bubblemesh.errors import GeometryError
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.nesting import polygons_of
from bubblemesh.geometry.paths import Area
from bubblemesh.geometry.rings import circle, polygon, rectangle

DISC, BORE, ISLAND = circle((0, 0), 1), circle((0, 0), 0.6), circle((0, 0), 0.25)
LAKE = Area(DISC, (BORE,))


def test_an_area_may_lie_in_the_hole_of_another_one():
    domain = Domain.of_areas([LAKE, Area(ISLAND)])
    assert (domain.piece_count, domain.hole_count, domain.euler_characteristic) == (2, 1, 1)
    assert domain.polygon.area == pytest.approx(np.pi * (1 - 0.36 + 0.0625), rel=1e-3)
    np.testing.assert_array_equal(
        domain.contains(np.array([[0, 0], [0.4, 0], [0.8, 0], [1.2, 0]])), [True, False, True, False]
    )
    np.testing.assert_allclose(
        domain.signed_distance(np.array([[0, 0.2], [0, 0.3], [0, 0.75]])), [0.05, -0.05, 0.15], atol=1e-12
    )


def test_rings_are_numbered_from_the_outer_ones_to_the_holes():
    apart = Area(rectangle(2, 0, 3, 1), (rectangle(2.2, 0.2, 2.8, 0.8),))
    domain = Domain.of_areas([LAKE, apart, Area(ISLAND)])
    assert domain.labels[0] == "outer"
    assert {"outer", "outer-3", "hole-1"} <= set(domain.labels)
    boundary = domain.boundary
    by_ring = {int(ring): boundary.labels[label] for ring, label in zip(boundary.ring, boundary.label, strict=True)}
    assert by_ring[3] == "hole-1"
    assert boundary.area_of_ring == (0, 1, 2, 0, 1)
    assert domain.polygon.area == pytest.approx(np.pi * 0.7025 + 0.64, rel=1e-3)


def test_areas_that_touch_in_a_point_share_a_node():
    domain = Domain.of_areas([Area(rectangle(0, 0, 1, 1)), Area(rectangle(1, 1, 2, 2)), Area(circle((2.5, 0.5), 0.5))])
    assert (domain.piece_count, domain.hole_count, domain.euler_characteristic) == (3, 0, 2)
    along = Domain.of_areas([Area(rectangle(0, 0, 1, 2)), Area(circle((1.5, 0.7), 0.5))])
    assert along.euler_characteristic == 1
    assert (np.abs(along.boundary.corners - (1, 0.7)).max(axis=1) < 1e-9).sum() == 1


def test_an_island_may_touch_the_shore():
    domain = Domain.of_areas([LAKE, Area(circle((0.3, 0), 0.3))])
    assert domain.euler_characteristic == 0
    assert (np.abs(domain.boundary.corners - (0.6, 0)).max(axis=1) < 1e-9).sum() == 1


FAULTS = {
    "overlap": ([Area(DISC), Area(rectangle(0.5, -0.1, 2, 0.1))], "outer ring 1 and outer ring 2 overlap at"),
    "equal": ([Area(DISC), Area(DISC)], "outer ring 1 and outer ring 2 overlap"),
    "one within another": ([Area(DISC), Area(ISLAND)], "outer ring 1 and outer ring 2 overlap"),
    "island across the shore": ([LAKE, Area(circle((0.5, 0), 0.3))], "outer ring 1 and outer ring 2 overlap"),
    "island over the whole lake": ([LAKE, Area(BORE)], "outer ring 1 and outer ring 2 (share an edge|overlap)"),
    "common side": (
        [Area(rectangle(0, 0, 1, 1)), Area(rectangle(3, 0, 4, 1)), Area(rectangle(1, 0.2, 2, 0.8))],
        r"outer ring 1 and outer ring 3 share an edge at \(1, 0.[28]\): .*give them as regions",
    ),
    "hole of another area": (
        [Area(DISC), Area(rectangle(3, 0, 4, 1), (ISLAND,))],
        r"hole 1 at \(.*\) lies outside outer ring 2: move",
    ),
    "crossing hole": (
        [Area(rectangle(3, 0, 4, 1)), Area(DISC, (circle((1, 0), 0.2),))],
        "hole 1 crosses outer ring 2 at",
    ),
    "bow tie": ([LAKE, Area(polygon([(3, 0), (4, 1), (4, 0), (3, 1)]))], r"outer ring 2 crosses .* at \(3.5, 0.5\)"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_what_several_areas_cannot_be(fault):
    areas, text = FAULTS[fault]
    with pytest.raises(GeometryError) as caught:
        Domain.of_areas(areas)
    assert re.search(text, str(caught.value)), str(caught.value)


def test_very_many_areas():
    domain = Domain.of_areas(
        [Area(rectangle(2 * i, 2 * j, 2 * i + 1, 2 * j + 1)) for i in range(30) for j in range(30)]
    )
    assert (domain.piece_count, domain.polygon.area) == (900, 900)


def test_polygons_are_found_in_collections_of_collections_and_in_arrays():
    one, other, line = shapely.box(0, 0, 1, 1), shapely.box(2, 0, 3, 1), shapely.LineString([(4, 0), (5, 0)])
    whole = shapely.GeometryCollection([line, shapely.MultiPolygon([one, other]), shapely.Polygon()])
    assert polygons_of(whole) == [one, other]
    assert polygons_of(np.array([one, whole, line])) == [one, one, other]
    assert polygons_of(shapely.GeometryCollection()) == []
