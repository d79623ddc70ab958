import numpy as np
import pytest
from scipy.integrate import quad

from bubblemesh.errors import CaseError, LimitError
from bubblemesh.geometry.arrangement.regions import InnerParts, Region
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.paths import Area
from bubblemesh.geometry.rings import LineTo, circle, open_path, rectangle
from bubblemesh.meshes.quality import doubled_areas
from bubblemesh.spacing.cover import Cover
from bubblemesh.spacing.expression import Expression
from bubblemesh.spacing.integrals import Intervals, Triangles, mean_inverse, mean_inverse_square
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.survey import rough_nodes, surveyed
from bubblemesh.spacing.terms.proximity import Proximity

ENOUGH = 10**6
SQUARE = Domain.of(rectangle(-1, -1, 1, 1))
LARGE_SQUARE = Domain.of(rectangle(-3, -3, 3, 3))
PERFORATED = Domain.of(rectangle(-1, -1, 1, 1), [circle((0, 0), 0.4)])
CONSTANT = Spacing(Expression.parse("0.1", {}))


def uniform(d):
    return Spacing(lambda x, y: np.full(x.shape, float(d)))


def around_circle(slope, least):
    return Spacing(lambda x, y: slope * np.abs(np.hypot(x, y) - 2) + least)


def ideal(area, boundary, holes=0):
    return 2 / np.sqrt(3) * area + boundary / 2 + 1 - holes


@pytest.mark.parametrize("d", [0.5, 0.1, 0.02])
def test_ideal_nodes_of_a_uniform_square(d):
    found = surveyed(SQUARE, uniform(d), ENOUGH).ideal_nodes
    assert found == pytest.approx(ideal(4 / d**2, 8 / d), rel=1e-9)


@pytest.mark.parametrize("domain", [SQUARE, PERFORATED])
def test_a_constant_is_surveyed_without_a_look_at_the_domain(domain):
    found, other = (surveyed(domain, spacing, ENOUGH) for spacing in (CONSTANT, uniform(0.1)))
    assert found.ideal_nodes == pytest.approx(other.ideal_nodes, rel=1e-12)
    assert found.extremes == other.extremes
    assert "_in_area" not in vars(found.cover)


@pytest.mark.parametrize("tiny", ["1e-3", "1e-200", "1e-320"])
def test_a_constant_that_is_too_small_needs_too_many_nodes(tiny):
    with pytest.raises(LimitError, match=r"needs .* more than the limit"):
        surveyed(SQUARE, Spacing(Expression.parse(tiny, {})), 1000)


def test_what_a_spacing_grows_from_is_its_minimum_without_a_search():
    calls = []

    def distance(points):
        calls.append(len(points))
        return np.abs(np.hypot(*points.T) - 0.4) + 1e-12  # with the rounding error of a curve's distance

    found = surveyed(PERFORATED, Spacing(Proximity(distance, 0.05)), ENOUGH)
    assert found.extremes.minimum == pytest.approx(0.05)
    assert len(calls) < 20


@pytest.mark.parametrize("domain", [SQUARE, PERFORATED])
def test_divided_parts_have_the_spacing_at_their_ends_to_the_last_bit(domain):
    spacing = Spacing(lambda x, y: 0.02 + 0.1 * np.hypot(x - 0.1, y))
    cover = Cover(domain)
    triangles, intervals = Triangles.of(cover, spacing), Intervals.of(cover, spacing, domain.boundary)
    area = np.abs(doubled_areas(cover.corners)).sum()
    length = np.diff(cover.intervals[:, 1:]).sum()
    for _ in range(3):
        triangles, intervals = triangles.divided(), intervals.divided()
        np.testing.assert_array_equal(triangles.d, spacing(triangles.points))
        assert np.abs(doubled_areas(triangles.points[triangles.corners])).sum() == pytest.approx(area, rel=1e-12)
        for d, s in ((intervals.first, intervals.begin), (intervals.last, intervals.end)):
            np.testing.assert_array_equal(d, spacing.along(domain.boundary, intervals.piece, s))
        assert (intervals.end - intervals.begin).sum() == pytest.approx(length, rel=1e-12)


@pytest.mark.parametrize("large", [1e6, 1e20, 1e36, 1e300])
def test_means_beside_sizes_that_stand_for_no_limit(large):
    few, many = np.array([0.05]), np.array([large])
    expected = np.log(large / 0.05) / large
    for a, b in ((few, many), (many, few)):
        assert mean_inverse(a, b)[0] == pytest.approx(expected)


@pytest.mark.parametrize("values", [(0.3, 1, 2), (2, 0.1, 1), (1, 1, 1), (1, 1, 5), (3, 1, 1), (1, 1 + 1e-5, 1 + 1e-3)])
def test_means_over_triangles_are_those_of_a_linear_spacing(values):
    (a, b, c), (nodes, weights) = values, np.polynomial.legendre.leggauss(100)
    u, weights = (nodes + 1) / 2, weights / 2
    inverse = 1 / (a + (b - a) * u)[:, None]
    square = 1 / (a + (b - a) * u[:, None] * (1 - u) + (c - a) * u) ** 2  # (1 - u) is the width at a height
    assert mean_inverse(np.array([a]), np.array([b]))[0] == pytest.approx(weights @ inverse[:, 0], rel=1e-6)
    expected = 2 * weights @ square @ (weights * (1 - u))
    assert mean_inverse_square(np.array([values], float))[0] == pytest.approx(expected, rel=1e-6)
    for swapped in ((b, a, c), (c, a, b), (c, b, a)):
        assert mean_inverse_square(np.array([swapped], float))[0] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("change", [1e-12, 1e-9, 2e-6, 1e-5])
def test_means_over_triangles_of_nearly_one_spacing_keep_their_digits(change):
    d = np.array([[0.1, 0.1 * (1 + change / 2), 0.1 * (1 + change)]])
    assert mean_inverse_square(d)[0] == pytest.approx(100 * (1 - change), rel=1e-9)


def test_each_hole_takes_one_node_off():
    domain = Domain.of(rectangle(-1, -1, 1, 1), [rectangle(-0.5, -0.5, 0, 0), rectangle(0.5, 0.5, 0.7, 0.7)])
    found = surveyed(domain, uniform(0.1), ENOUGH).ideal_nodes
    assert found == pytest.approx(ideal((4 - 0.25 - 0.04) / 0.01, (8 + 2 + 0.8) / 0.1, holes=2), rel=1e-9)


@pytest.mark.parametrize("radius", [1e-3, 0.05])
def test_holes_smaller_than_the_spacing_have_three_nodes_each(radius):
    places = [(x, y) for x in np.linspace(-0.9, 0.9, 8) for y in np.linspace(-0.9, 0.9, 8)]
    domain = Domain.of(rectangle(-1, -1, 1, 1), [circle(place, radius) for place in places])
    found = surveyed(domain, uniform(0.5), ENOUGH).ideal_nodes
    assert found == pytest.approx(ideal((4 - 64 * np.pi * radius**2) / 0.25, 8 / 0.5 + 64 * 3, holes=64), rel=1e-3)
    assert rough_nodes(domain)(uniform(0.5)) == pytest.approx(found, rel=1e-3)


def test_inner_lines_take_no_nodes_of_their_own():
    crack = open_path((-0.5, 0), [LineTo((0.5, 0))], "crack")
    region = Region(Area(rectangle(-1, -1, 0, 1)), "west", label="rim")
    domain = Domain.of(rectangle(-1, -1, 1, 1), parts=InnerParts(regions=(region,), lines=(crack,)))
    assert domain.boundary.inner.any()
    found = surveyed(domain, uniform(0.1), ENOUGH).ideal_nodes
    assert found == pytest.approx(ideal(4 / 0.1**2, 8 / 0.1), rel=1e-9)


@pytest.mark.parametrize("d", [0.2, 0.02])
def test_ideal_nodes_of_a_uniform_disc(d):
    found = surveyed(Domain.of(circle((3, 4), 1)), uniform(d), ENOUGH).ideal_nodes
    assert found == pytest.approx(ideal(np.pi / d**2, 2 * np.pi / d), rel=5e-3)


@pytest.mark.parametrize("growth", [0.1, 0.3])
def test_ideal_nodes_of_a_far_field_are_right_to_a_thousandth(growth):
    far, least = 40.0, 0.01
    domain = Domain.of(circle((0, 0), far), [circle((0, 0), 0.5)])
    spacing = Spacing(lambda x, y: least + growth * (np.hypot(x, y) - 0.5))
    area, _ = quad(lambda r: 2 * np.pi * r / (least + growth * (r - 0.5)) ** 2, 0.5, far, points=[0.6, 1, 4], limit=200)
    boundary = 2 * np.pi * (0.5 / least + far / (least + growth * (far - 0.5)))
    assert surveyed(domain, spacing, ENOUGH).ideal_nodes == pytest.approx(ideal(area, boundary, holes=1), rel=2e-3)


def test_ideal_nodes_of_a_graded_annulus():
    domain = Domain.of(circle((0, 0), 2), [circle((0, 0), 0.25)])
    found = surveyed(domain, Spacing(lambda x, y: np.hypot(x, y) / 8), ENOUGH).ideal_nodes
    expected = ideal(64 * 2 * np.pi * np.log(8), 2 * 8 * 2 * np.pi, holes=1)
    assert found == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize(
    ("domain", "spacing", "nodes"),
    [
        (Domain.of(rectangle(-1, -2, 1, 2)), uniform(0.1), 985),
        (PERFORATED, Spacing(lambda x, y: np.hypot(x, y) / 8), 530),
        (LARGE_SQUARE, around_circle(0.2, 0.15), 655),
        (LARGE_SQUARE, around_circle(0.35, 0.05), 1524),
    ],
)
def test_ideal_nodes_of_the_examples(domain, spacing, nodes):
    assert round(surveyed(domain, spacing, ENOUGH).ideal_nodes) == pytest.approx(nodes, abs=1)


@pytest.mark.parametrize(("slope", "least"), [(0.2, 0.15), (0.35, 0.05), (1, 1e-2)])
def test_narrow_valleys_of_the_spacing_are_integrated(slope, least):
    domain = Domain.of(circle((0, 0), 3))

    def density(r):
        return 2 * np.pi * r / (slope * abs(r - 2) + least) ** 2

    area = sum(quad(density, *part, epsrel=1e-10, limit=500)[0] for part in ((0, 1.9), (1.9, 2), (2, 2.1), (2.1, 3)))
    found = surveyed(domain, around_circle(slope, least), 10**8).ideal_nodes
    assert found == pytest.approx(ideal(area, 6 * np.pi / (slope + least)), rel=5e-3)


@pytest.mark.parametrize("scale", [1e15, 1e-12])
def test_ideal_nodes_do_not_depend_on_the_unit_of_length(scale):
    domain = Domain.of(rectangle(-scale, -scale, scale, scale), [circle((0, 0), 0.4 * scale)])
    found = surveyed(domain, Spacing(lambda x, y: np.hypot(x, y) / 8), ENOUGH).ideal_nodes
    expected = surveyed(PERFORATED, Spacing(lambda x, y: np.hypot(x, y) / 8), ENOUGH).ideal_nodes
    assert found == pytest.approx(expected, rel=1e-3)


def test_extremes_are_found_with_their_places():
    survey = surveyed(SQUARE, Spacing(lambda x, y: 0.1 + (x - 0.317) ** 2 + (y + 0.123) ** 2), ENOUGH)
    assert survey.extremes.minimum == pytest.approx(0.1, rel=1e-12)
    assert survey.extremes.minimum_at == pytest.approx((0.317, -0.123), abs=1e-6)
    assert survey.extremes.maximum_at == (-1, 1)
    assert survey.extremes.maximum == pytest.approx(0.1 + 1.317**2 + 1.123**2)


def test_spacing_larger_than_the_domain_is_allowed():
    assert surveyed(SQUARE, uniform(100), ENOUGH).ideal_nodes == 3  # the formula gives one


@pytest.mark.parametrize("value", [0, -1, np.nan, np.inf])
def test_unusable_spacing_is_refused_with_the_point(value):
    spacing = Spacing(lambda x, y: np.where((x > 0.5) & (y > 0.5), value, 0.1))
    with pytest.raises(CaseError, match=rf"spacing: is {value:g} at \((0\.[5-9]\d*|1), (0\.[5-9]\d*|1)\)"):
        surveyed(SQUARE, spacing, ENOUGH)


@pytest.mark.parametrize(
    ("function", "place"),
    [
        (lambda x, y: np.hypot(x - 0.317, y - 0.123), r"\(0.317, 0.123\)"),
        (lambda x, y: np.abs(x - y / 3), r"\("),
        (lambda x, y: np.hypot(x - 0.317, y - 0.123) - 1e-4, r"\(0.31\d*, 0.12\d*\)"),
    ],
)
def test_spacing_that_vanishes_between_the_samples_is_refused(function, place):
    with pytest.raises(CaseError, match=rf"spacing: .* at {place}.*positive"):
        surveyed(SQUARE, Spacing(function), ENOUGH)


def test_spacing_may_be_undefined_in_a_hole():
    with np.errstate(invalid="ignore"):
        spacing = Spacing(lambda x, y: 0.1 + np.sqrt(np.hypot(x, y) - 0.3999))
        assert surveyed(PERFORATED, spacing, ENOUGH).extremes.minimum > 0.1


@pytest.mark.parametrize(
    ("d", "count"),
    [(0.01, r"about 4\.62e\+04 nodes"), (1e-6, r"about 4\.62e\+12 nodes"), (1e-300, "more nodes than can be counted")],
)
def test_too_many_nodes_are_refused_with_the_estimate(d, count):
    with pytest.raises(LimitError, match=rf"needs {count}, more than the limit of 20000"):
        surveyed(SQUARE, uniform(d), 20_000)


def test_nodes_of_a_long_boundary_count_against_the_limit():
    strip = Domain.of(rectangle(0, 0, 100, 1e-3))
    with pytest.raises(LimitError, match=r"needs about 1e\+04 nodes, more than the limit of 2000:"):
        surveyed(strip, uniform(0.01), 2000)


def test_limit_itself_may_be_reached():
    nodes = surveyed(SQUARE, uniform(0.1), ENOUGH).ideal_nodes
    surveyed(SQUARE, uniform(0.1), int(np.ceil(nodes)))
    with pytest.raises(LimitError):
        surveyed(SQUARE, uniform(0.1), int(nodes))


def test_the_spacing_is_asked_at_few_places_also_beside_curves():
    domain = Domain.of(rectangle(-1, -1, 1, 1), [circle((0.3, 0.1), 0.4), circle((-0.5, 0.5), 0.05)])
    asked = []

    def function(x, y):
        asked.append(len(x))
        return np.full(len(x), 0.1)

    surveyed(domain, Spacing(function), ENOUGH)
    assert sum(asked) < 30_000
