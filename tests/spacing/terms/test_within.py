import numpy as np
import shapely

from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.terms.combination import Combination
from bubblemesh.spacing.terms.regions import RegionTerm, ShapeUnion

X, Y = np.meshgrid(np.linspace(0, 4, 9), np.linspace(0, 1, 3))
X, Y = X.ravel(), Y.ravel()


def constant(value):
    return lambda x, y: np.full(len(x), value)


def between(low, high):
    return lambda x, y: (x > low) & (x < high), lambda x, y: (x >= low) & (x <= high)


OUTER, INNER = between(1, 3), between(2, 3)


def test_a_limit_counts_within_its_region_and_on_its_rim():
    core, reach = OUTER
    values = RegionTerm(lambda x, y: 0.1 + x, reach)(X, Y)
    np.testing.assert_array_equal(values, np.where((X >= 1) & (X <= 3), 0.1 + X, np.inf))
    assert core(X, Y).sum() < np.isfinite(values).sum()


def test_a_limit_leaves_out_what_is_nested():
    values = RegionTerm(constant(0.1), OUTER[1], INNER[0])(X, Y)
    np.testing.assert_array_equal(np.isfinite(values), ((X >= 1) & (X <= 2)) | (X == 3))


def test_the_rest_is_what_no_region_is():
    values = RegionTerm(constant(0.1), None, OUTER[0])(X, Y)
    np.testing.assert_array_equal(np.isfinite(values), (X <= 1) | (X >= 3))
    np.testing.assert_array_equal(RegionTerm(constant(0.1), None)(X, Y), 0.1)


def test_a_region_may_have_several_rings():
    x, y = np.random.default_rng(0).uniform(-1, 6, (2, 3000))
    centers = [(i, j) for i in range(5) for j in range(5)]
    discs = ShapeUnion(tuple(shapely.Point(at).buffer(0.7) for at in centers))
    expected = np.any([shapely.contains_xy(disc, x, y) for disc in discs.shapes], axis=0)
    assert 0.1 < expected.mean() < 0.9
    np.testing.assert_array_equal(np.isfinite(RegionTerm(constant(0.1), discs)(x, y)), expected)
    np.testing.assert_array_equal(np.isfinite(RegionTerm(constant(0.1), None, discs)(x, y)), ~expected)
    assert np.isfinite(RegionTerm(constant(0.1), None, ShapeUnion(()))(x, y)).all()


def test_a_limit_is_evaluated_where_it_counts_only():
    def picky(x, y):
        assert len(x) > 0
        assert (x >= 1).all()
        return x

    RegionTerm(picky, OUTER[1])(X, Y)


class Slow:
    costly = True

    def __call__(self, x, y):
        return x


def test_what_holds_a_costly_term_is_costly():
    assert RegionTerm(Slow(), None).costly
    assert Combination((Spacing(constant(1)), Spacing(RegionTerm(Slow(), None), costly=True))).costly
    assert not Combination((Spacing(constant(1)), Spacing(RegionTerm(constant(1), None)))).costly
