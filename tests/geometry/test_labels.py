import numpy as np
import pytest
import shapely
from numpy.testing import assert_allclose, assert_array_equal

from bubblemesh.errors import GeometryError
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.rings import ArcTo, LineTo, circle, ellipse, path, polygon, rectangle
from tests.partitions import domain_of

POINTS = np.random.default_rng(0).uniform(-0.5, 4.5, (3000, 2))
PLATE = Domain.of(
    rectangle(0, 0, 4, 4, labels=["bottom", "right", "top", "left"]),
    [circle((1, 1), 0.5, label="bore"), circle((3, 1), 0.1, label="bore"), ellipse((2, 3), (0.8, 0.2), 30)],
)
PARTED = domain_of("""
domain:
  outer: {rectangle: [0, 0, 4, 4], label: wall}
  regions:
    - {name: core, ring: {circle: {center: [2, 2], radius: 1}}}
  lines:
    - {path: [[0.5, 0.5], [1, 3], [3.5, 3.5]], label: crack}
    - {path: [[3.2, 0.5], {arc: {to: [3.2, 1.5], center: [3.2, 1], turn: left}}], label: wire}
  points:
    - {at: [0.5, 3.5], label: well}
    - {at: [3.5, 0.2], label: well}
    - {at: [1, 0.25], label: crack}
""")


def from_circle(center, radius):
    return np.abs(np.hypot(*(POINTS - center).T) - radius)


def from_line(*vertices):
    return shapely.distance(shapely.LineString(vertices), shapely.points(POINTS))


def from_points(*places):
    return np.min([np.hypot(*(POINTS - at).T) for at in places], axis=0)


def from_half_circle():
    ends = from_points((3.2, 0.5), (3.2, 1.5))
    return np.where(POINTS[:, 0] > 3.2, from_circle((3.2, 1), 0.5), ends)


EXPECTED = {
    "a side": (PLATE, ["top"], from_line((0, 4), (4, 4))),
    "two sides": (PLATE, ["top", "left"], from_line((0, 0), (0, 4), (4, 4))),
    "all circles of a name": (PLATE, ["bore"], np.minimum(from_circle((1, 1), 0.5), from_circle((3, 1), 0.1))),
    "circles and a side": (
        PLATE,
        ["bore", "right"],
        np.min([from_circle((1, 1), 0.5), from_circle((3, 1), 0.1), from_line((4, 0), (4, 4))], axis=0),
    ),
    "interface": (PARTED, ["core-rim"], from_circle((2, 2), 1)),
    "curved line": (PARTED, ["wire"], from_half_circle()),
    "points": (PARTED, ["well"], from_points((0.5, 3.5), (3.5, 0.2))),
    "line and a point of one name": (
        PARTED,
        ["crack"],
        np.minimum(from_line((0.5, 0.5), (1, 3), (3.5, 3.5)), from_points((1, 0.25))),
    ),
    "curve, line and points": (
        PARTED,
        ["well", "wire", "crack"],
        np.min(
            [
                from_half_circle(),
                from_line((0.5, 0.5), (1, 3), (3.5, 3.5)),
                from_points((0.5, 3.5), (3.5, 0.2), (1, 0.25)),
            ],
            axis=0,
        ),
    ),
}


@pytest.mark.parametrize(("domain", "labels", "expected"), EXPECTED.values(), ids=EXPECTED)
def test_distance_is_that_to_everything_of_the_name(domain, labels, expected):
    assert_allclose(domain.distance_to(POINTS, *labels), expected, atol=1e-7)
    assert_array_equal(domain.distance_to(POINTS, *labels[::-1]), domain.distance_to(POINTS, *labels))


@pytest.mark.parametrize("name", ["plate", "half disc"])
def test_distance_to_all_sides_is_that_to_the_boundary(name):
    half = path((1, 0), [ArcTo((-1, 0), (0, 0), True, "arc"), LineTo((1, 0), "base")])
    domain = {"plate": PLATE, "half disc": Domain.of(half)}[name]
    assert_allclose(domain.distance_to(POINTS, *domain.labels), domain.nearest(POINTS).distance, atol=1e-7)


def test_distances_vanish_on_what_is_named_only():
    boundary = PARTED.boundary
    for number, label in enumerate(boundary.labels):
        pieces = np.repeat(np.flatnonzero(boundary.label == number), 50)
        s = np.tile(np.linspace(0, 1, 50), len(pieces) // 50) * boundary.lengths[pieces]
        assert PARTED.distance_to(boundary.points(pieces, s), label).max() < 1e-8
    assert PARTED.distance_to(PARTED.boundary.corners, "well").tolist().count(0) == 2


def test_labels_are_those_of_sides_lines_and_points():
    assert set(PLATE.labels) == {"bottom", "right", "top", "left", "bore", "hole-3"}
    assert sorted(PARTED.labels) == ["core-rim", "crack", "wall", "well", "wire"]


def test_no_points_have_no_distances():
    assert PARTED.distance_to(np.zeros((0, 2)), "well").shape == (0,)


@pytest.mark.parametrize(
    ("labels", "message"),
    [
        (["botom"], "no side, line or point 'botom': did you mean 'bottom'"),
        (["bore", "xyz"], "no side, line or point 'xyz': allowed: bottom, right, top, left, bore, hole-3"),
        ([], "no side, line or point is named: give at least one of bottom, right"),
    ],
)
def test_names_that_are_none_are_refused(labels, message):
    with pytest.raises(GeometryError, match=message):
        PLATE.distance_to(POINTS, *labels)


def test_label_whose_sides_are_all_gone_is_none():
    inside = domain_of("""
domain:
  outer: {polygon: [[0, 0], [1, 0], [1, 1]], label: wall}
  regions:
    - {name: half, ring: {polygon: [[0, 0], [1, 0], [1, 1]], label: never}}
""")
    assert inside.labels == ("wall",)


def test_polygon_rings_are_cornered():
    domain = Domain.of(polygon([(0, 0), (1, 0), (0, 1)], labels=["a", "b", "c"]))
    assert_allclose(domain.distance_to(np.array([[2.0, 0.0], [0.5, 0.5], [0, 0]]), "a"), [1, 0.5, 0], atol=1e-15)
