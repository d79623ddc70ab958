import numpy as np
import pytest
from numpy.testing import assert_allclose

from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.rings import circle, ellipse, polygon, rectangle
from bubblemesh.spacing.refinement import SHORT, WIDEST_TURN, Sources, coarse_curves, short_pieces
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


def test_straight_sides_are_never_coarse():
    assert len(coarse_curves(CHAMFERED, uniform(100))) == 0
