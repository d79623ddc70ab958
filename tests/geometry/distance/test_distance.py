"""Distances from labelled parts of a domain, against brute force over very many points of the true curves."""

import pickle
from functools import partial

import numpy as np
import pytest
import shapely
from partitions import domain_of

from bubblemesh.errors import CaseError
from bubblemesh.geometry.distance.distances import MOST_FORMULAS, distance_to_line
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.label_distances import distance_to_labels
from bubblemesh.geometry.rings import polygon

TEXT = """
domain:
  outer:
    path:
      - [0, 0]
      - {to: [4, 0], label: base}
      - {arc: {to: [4, 2], center: [4, 1], turn: left}, label: cap}
      - {spline: {through: [[3, 2.4], [2, 1.8], [1, 2.2], [0, 2]]}, label: roof}
  holes:
    - {circle: {center: [1, 1], radius: 0.3}, label: bore}
    - {ellipse: {center: [3.2, 1], radii: [0.5, 0.2], angle: 20}, label: slot}
    - {circle: {center: [2, 0.5], radius: 0.2}, label: bore}
  regions:
    - {name: core, ring: {circle: {center: [2, 1.2], radius: 0.3}}}
  lines:
    - {path: [[0.2, 0.3], [0.6, 0.2], [0.6, 0.6]], label: crack}
  points:
    - {at: [0.3, 1.7], label: well}
    - {at: [4.6, 1], label: well}
    - {at: [2, 1.7], label: crack}
"""
DOMAIN = domain_of(TEXT)
RANDOM = np.random.default_rng(5)
POINTS = RANDOM.uniform([-1, -1], [6, 4], (400, 2))


def brute_force(labels, points, domain=DOMAIN):
    """Distances from very many points of the curves, with an error below 1e-7."""
    boundary = domain.boundary
    shapes = [shapely.Point(point.at) for point in domain.parts.points if point.label in labels]
    for k in range(len(boundary.kind)):
        if boundary.labels[boundary.label[k]] in labels:
            s = np.linspace(0, boundary.lengths[k], 20_001)
            shapes.append(shapely.LineString(boundary.points(np.full(len(s), k), s)))
    return shapely.distance(shapely.points(points), shapely.GeometryCollection(shapes))


@pytest.mark.parametrize(
    "labels",
    [["base"], ["cap"], ["roof"], ["bore"], ["slot"], ["core-rim"], ["crack"], ["well"], ["bore", "roof", "well"]],
    ids=" ".join,
)
def test_distances_are_those_of_brute_force(labels):
    np.testing.assert_allclose(distance_to_labels(DOMAIN, labels)(POINTS), brute_force(labels, POINTS), atol=1e-7)


def test_a_label_of_several_rings_is_all_of_them():
    circles = [((1, 1), 0.3), ((2, 0.5), 0.2)]
    each = [np.abs(np.hypot(*(POINTS - center).T) - radius) for center, radius in circles]
    np.testing.assert_allclose(distance_to_labels(DOMAIN, ["bore"])(POINTS), np.minimum(*each), atol=1e-12)


def test_without_a_label_it_is_the_rings():
    labels = ["base", "cap", "roof", "bore", "slot", "outer"]
    np.testing.assert_allclose(distance_to_labels(DOMAIN, [])(POINTS), brute_force(labels, POINTS), atol=1e-7)
    np.testing.assert_allclose(distance_to_labels(DOMAIN, [])(POINTS), DOMAIN.nearest(POINTS).distance, atol=1e-7)


def test_on_a_label_the_distance_vanishes():
    boundary = DOMAIN.boundary
    for k in range(len(boundary.kind)):
        s = np.linspace(0, boundary.lengths[k], 57)
        there = distance_to_labels(DOMAIN, [boundary.labels[boundary.label[k]]])(boundary.points(np.full(57, k), s))
        assert np.abs(there).max() < 1e-7


def test_the_order_of_the_points_does_not_matter():
    order = RANDOM.permutation(len(POINTS))
    distance = distance_to_labels(DOMAIN, ["roof", "bore"])
    np.testing.assert_array_equal(distance(POINTS[order]), distance(POINTS)[order])
    np.testing.assert_allclose([distance(point[None])[0] for point in POINTS[:40]], distance(POINTS)[:40], rtol=1e-12)


def test_no_points_have_no_distances():
    assert distance_to_labels(DOMAIN, ["bore"])(np.zeros((0, 2))).shape == (0,)
    assert distance_to_labels(DOMAIN, ["well"])(np.zeros((0, 2))).shape == (0,)


@pytest.mark.parametrize(
    ("label", "message"),
    [
        ("boer", "unknown label 'boer'; did you mean 'bore'[?] known: base, cap, "),
        ("core", "unknown label 'core'; .*known: .*core-rim"),
        ("domain", "unknown label 'domain'; known: base"),
    ],
)
def test_an_unknown_label_names_the_known_ones(label, message):
    with pytest.raises(CaseError, match=message):
        distance_to_labels(DOMAIN, ["bore", label])


def test_a_label_of_nothing_but_a_side_without_length_is_told_as_such():
    domain = Domain.of(polygon([(0, 0), (1, 0), (1, 0), (1, 1)], labels=["a", "gone", "b", "c"]))
    with pytest.raises(CaseError, match="the side 'gone' has no length, since both of its ends are one point"):
        distance_to_labels(domain, ["gone"])


def test_a_polyline_is_open_and_may_cross_itself():
    line = [(0, 0), (2, 0), (2, 0), (1, 1), (1, -1)]
    found = distance_to_line(line)(POINTS)
    np.testing.assert_allclose(found, shapely.distance(shapely.points(POINTS), shapely.LineString(line)), atol=1e-12)


def test_a_line_may_be_a_point():
    np.testing.assert_allclose(distance_to_line([(3, 1)])(POINTS), np.hypot(*(POINTS - (3, 1)).T), rtol=1e-14)


def test_distances_travel_to_worker_processes():
    copy = pickle.loads(pickle.dumps(partial(distance_to_labels, DOMAIN)))
    np.testing.assert_array_equal(copy(["slot", "well"])(POINTS), distance_to_labels(DOMAIN, ["slot", "well"])(POINTS))


@pytest.mark.parametrize("label", ["bore", "slot", "core-rim", "cap", "roof"])
def test_points_beyond_the_ends_of_chords_are_no_exception(label):
    boundary, number = DOMAIN.boundary, DOMAIN.boundary.labels.index(label)
    piece, s, _ = boundary.stations()
    mine = boundary.label[piece] == number
    piece, s = piece[mine], s[mine]
    tx, ty = boundary.tangents(piece, s).T
    for away in (-0.03, 0.03, 0.4):
        for aside in (-0.01, -1e-3, 0, 1e-4, 5e-3):
            normal = np.column_stack([ty, -tx]) + aside * np.column_stack([tx, ty])
            points = boundary.points(piece, s) + away * normal
            found = distance_to_labels(DOMAIN, [label])(points)
            assert (found <= abs(away) * np.hypot(1, aside) * (1 + 1e-9)).all()
            np.testing.assert_allclose(found[:3], brute_force([label], points[:3]), atol=1e-7)


CUT = domain_of("""
domain:
  outer:
    path:
      - [0, 0]
      - {to: [2, 0], label: base}
      - {arc: {to: [2, 1], center: [2, 0.5], turn: right}, label: bay}
      - {arc: {to: [0, 0], center: [1, 0.5], turn: left}, label: dome}
  regions:
    - {name: core, ring: {circle: {center: [1, 0], radius: 0.4}}}
    - {name: ball, ring: {circle: {center: [1, 0.9], radius: 0.2}}}
  lines:
    - {path: [[0.9, 0.1], {arc: {to: [0.9, 0.3], center: [0.9, 0.2], turn: left}}], label: wire}
    - {path: [[1, 1.1], [1, 1.3]], label: wire}
""")


@pytest.mark.long
@pytest.mark.parametrize("label", ["base", "bay", "dome", "core-rim", "ball-rim", "wire"])
def test_formulas_of_arcs_and_lines_agree_with_looking_for_the_nearest_piece(label):
    points = np.vstack([RANDOM.uniform([-1, -1], [3, 2.5], (3000, 2)), CUT.polygonal_copy.points, [[1, 0], [2, 0.5]]])
    distance = distance_to_labels(CUT, [label])
    assert not distance.costly
    np.testing.assert_allclose(distance(points[-300:]), brute_force([label], points[-300:], CUT), atol=1e-7)
    # Beside the end of an arc the chord before may be nearer than the one that follows the nearest arc.
    np.testing.assert_allclose(distance(points), CUT.distance_to(points, label), atol=1e-5)


def test_few_lines_and_arcs_only_are_asked_one_by_one():
    assert not distance_to_labels(CUT, []).costly
    assert distance_to_labels(DOMAIN, ["slot"]).costly
    assert distance_to_labels(DOMAIN, ["bore", "roof"]).costly
    turn = np.linspace(0, 5, MOST_FORMULAS + 1)
    line = list(zip(turn, np.sin(3 * turn), strict=True))
    assert distance_to_line(line).costly
    assert not distance_to_line(line[:-1]).costly
    expected = shapely.distance(shapely.points(POINTS), shapely.LineString(line))
    np.testing.assert_allclose(distance_to_line(line)(POINTS), expected, atol=1e-12)
