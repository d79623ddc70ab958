import numpy as np
import pytest
from numpy.testing import assert_allclose

from bubblemesh.errors import LimitError
from bubblemesh.geometry.arrangement.regions import InnerParts, InnerPoint
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.rings import ArcTo, LineTo, circle, ellipse, path, polygon, rectangle
from bubblemesh.meshes.tensors import Axes
from bubblemesh.spacing.metric.metric import MetricSpacing
from bubblemesh.spacing.rules.sources import SHORT, WIDEST_TURN, Sources, coarse_curves, curvature_sources, short_pieces
from bubblemesh.spacing.spacing import Spacing

NOWHERE = Sources(np.zeros((0, 2)), np.zeros(0))
SOURCES = Sources(np.array([[0, 0], [2, 0.0]]), np.array([0.1, 0.4]))
CHAMFERED = Domain.of(polygon([(0, 0), (1, 0), (1, 0.95), (0.95, 1), (0, 1)]))


def uniform(d):
    return Spacing(lambda x, y: np.full(x.shape, float(d)))


def test_sources_are_joined():
    joined = SOURCES.joined(Sources(np.array([[5, 5.0]]), np.array([0.2])))
    assert joined.points.tolist() == [[0, 0], [2, 0], [5, 5]]
    assert joined.sizes.tolist() == [0.1, 0.4, 0.2]
    assert len(SOURCES.joined(NOWHERE)) == 2


def test_short_side_is_a_source_at_both_ends():
    sources = short_pieces(CHAMFERED, uniform(0.2))
    assert sources.points.tolist() == [[1, 0.95], [0.95, 1]]
    assert_allclose(sources.sizes, np.hypot(0.05, 0.05))


@pytest.mark.parametrize(("factor", "count"), [(1.01, 2), (0.99, 0)])
def test_sides_count_as_short_below_a_share_of_the_spacing(factor, count):
    assert len(short_pieces(CHAMFERED, uniform(np.hypot(0.05, 0.05) / SHORT * factor))) == count


def test_short_sides_are_judged_by_the_finer_end():
    graded = Spacing(lambda x, y: np.where(y < 0.97, 0.01, 1.0))
    points = short_pieces(CHAMFERED, graded).points.tolist()
    assert [1, 0.95] not in points


def test_a_loop_is_as_short_as_the_spacing_along_its_own_ends():
    """A hole with one corner, where it goes upwards: there the metric says 0.2, and 0.02 across."""
    at = InnerPoint((0.52, 0.5), "corner")
    domain = Domain.of(rectangle(0, 0, 1, 1), [circle((0.5, 0.5), 0.02)], InnerParts(points=(at,)))
    across = MetricSpacing.of(
        lambda x, y: Axes(np.full(len(x), 0.02), np.full(len(x), 0.2), np.tile([0.0, 1.0], (len(x), 1)))
    )
    along = MetricSpacing.of(
        lambda x, y: Axes(np.full(len(x), 0.02), np.full(len(x), 0.2), np.tile([1.0, 0.0], (len(x), 1)))
    )
    assert_allclose(short_pieces(domain, across).points, [at.at, at.at])
    assert len(short_pieces(domain, along)) == 0


def test_whole_curves_have_no_short_pieces():
    assert len(short_pieces(Domain.of(circle((0, 0), 1)), uniform(9))) == 0


@pytest.mark.parametrize(("factor", "coarse"), [(1.01, True), (0.99, False)])
def test_circle_is_coarse_if_it_has_fewer_than_six_edges(factor, coarse):
    domain = Domain.of(rectangle(-4, -4, 4, 4), [circle((0, 0), 0.5)])
    sources = coarse_curves(domain, uniform(WIDEST_TURN * 0.5 * factor))
    assert (len(sources) > 0) == coarse
    if coarse:
        assert_allclose(sources.sizes, WIDEST_TURN * 0.5)
        assert_allclose(np.hypot(*sources.points.T), 0.5)


def test_ellipse_is_coarse_at_the_ends_of_its_long_axis():
    sources = coarse_curves(Domain.of(ellipse((0, 0), (2, 0.5))), uniform(0.2))
    assert (np.abs(sources.points[:, 0]) > 1.9).all()
    assert sources.sizes.min() == pytest.approx(WIDEST_TURN * 0.5**2 / 2, rel=1e-2)


@pytest.mark.parametrize(("turn", "edges"), [(50, None), (60, 1), (72, 2), (90, 2), (140, 3), (150, 3), (180, 3)])
def test_an_arc_gets_its_share_of_six_edges_rounded_up(turn, edges):
    """A slice of a disc, whose arc by the nearest number of its share gets one edge for 72 degrees, and two for 140."""
    end = (np.cos(np.radians(turn)), np.sin(np.radians(turn)))
    slice_ = path([0, 0], [LineTo((1, 0)), ArcTo(end, center=(0, 0), left=True), LineTo((0, 0))])
    sizes = coarse_curves(Domain.of(slice_), uniform(9)).sizes
    assert_allclose(sizes, WIDEST_TURN if edges is None else np.radians(turn) / edges, rtol=1e-3)


def test_an_arc_that_gets_enough_edges_by_the_nearest_number_is_left_as_it_is():
    quarter = path([0, 0], [LineTo((1, 0)), ArcTo((0, 1), center=(0, 0), left=True), LineTo((0, 0))])
    assert len(coarse_curves(Domain.of(quarter), uniform(0.9))) == 0
    assert_allclose(coarse_curves(Domain.of(quarter), uniform(1)).sizes, np.pi / 4, rtol=1e-3)


def test_straight_sides_are_never_coarse():
    assert len(coarse_curves(CHAMFERED, uniform(100))) == 0


HOLED = Domain.of(rectangle(-4, -4, 4, 4), [circle((0, 0), 1)])


@pytest.mark.parametrize("per_circle", [12, 100])
def test_nodes_on_a_full_turn_give_the_sizes_on_curves(per_circle):
    sources = curvature_sources(HOLED, uniform(9), per_circle, 0.4, 0.0, np.inf, None)
    assert_allclose(sources.sizes, 2 * np.pi / per_circle, rtol=1e-6)
    assert_allclose(np.hypot(*sources.points.T), 1)
    np.testing.assert_array_equal(curvature_sources(HOLED, uniform(9), per_circle, 0.4, 1.0, np.inf, None).sizes, 1.0)


@pytest.mark.parametrize("per_circle", [1e5, 1e7, 1e12])
@pytest.mark.parametrize("domain", [HOLED, Domain.of(circle((0, 0), 1))], ids=["hole", "disc"])
def test_curves_that_need_too_many_nodes_are_refused(domain, per_circle):
    with pytest.raises(LimitError, match=r"limits.max_nodes: spacing.per_circle asks for more than .* 200000 nodes"):
        curvature_sources(domain, uniform(0.5), per_circle, 0.4, 0.0, 200_000, None)
    assert len(curvature_sources(domain, uniform(0.5), per_circle, 0.4, 0.1, 200_000, None)) < 1000


def test_curves_that_need_fewer_nodes_are_not_refused():
    """Beside the curve are at most as many nodes as a spacing that grows from it makes in all of the plane."""
    for domain in (HOLED, Domain.of(circle((0, 0), 1)), Domain.of(circle((0, 0), 1), [circle((0, 0), 0.99)])):
        most = 10_000 * (0.5 + 2 / np.sqrt(3) / 0.4) * len(domain.boundary.kind)
        assert len(curvature_sources(domain, uniform(0.5), 10_000, 0.4, 0.0, most, None)) > 10_000
