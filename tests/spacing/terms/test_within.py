import numpy as np
import pytest
import shapely

from bubblemesh.errors import Key
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.terms.combination import Combination
from bubblemesh.spacing.terms.regions import Located, RegionLimit, RegionLimits

X, Y = (c.ravel() for c in np.meshgrid(np.linspace(0, 4, 17), np.linspace(0, 1, 3)))


class Within:
    """A region as limits see it: its polygon, with the rim and without."""

    def __init__(self, name, polygon, width=1e-9):
        self.name, self.polygon = name, polygon
        self.core, self.reach = polygon.buffer(-width), polygon.buffer(width)


def band(name, low, high):
    return Within(name, shapely.box(low, -1, high, 2))


def constant(value):
    return lambda x, y: np.full(len(x), value)


def limits(regions, **given):
    found = ((name, one if isinstance(one, Spacing) else Spacing(one)) for name, one in given.items())
    return RegionLimits(Located(tuple(regions)), tuple(RegionLimit(name, one, Key([name])) for name, one in found))


OUTER, INNER = band("outer", 1, 3), band("inner", 2, 3)


def test_a_limit_counts_within_its_region_and_on_its_rim():
    values = limits([OUTER], outer=lambda x, y: 0.1 + x)(X, Y)
    np.testing.assert_array_equal(values, np.where((X >= 1) & (X <= 3), 0.1 + X, np.inf))


def test_a_limit_leaves_out_what_is_nested():
    values = limits([OUTER, INNER], outer=constant(0.1))(X, Y)
    np.testing.assert_array_equal(np.isfinite(values), ((X >= 1) & (X <= 2)) | (X == 3))
    np.testing.assert_array_equal(np.isfinite(limits([OUTER, INNER], inner=constant(0.1))(X, Y)), (X >= 2) & (X <= 3))


def test_what_is_nested_belongs_to_a_name_that_it_has_as_well():
    values = limits([OUTER, band("outer", 2, 3)], outer=constant(0.1))(X, Y)
    np.testing.assert_array_equal(np.isfinite(values), (X >= 1) & (X <= 3))


def test_the_rest_is_what_no_region_is():
    values = limits([OUTER], rest=constant(0.1))(X, Y)
    np.testing.assert_array_equal(np.isfinite(values), (X <= 1) | (X >= 3))
    np.testing.assert_array_equal(limits([], rest=constant(0.1))(X, Y), 0.1)


def test_where_limits_meet_the_smaller_one_counts_and_has_the_key():
    both = limits([band("left", 0, 2), band("right", 2, 4)], left=constant(0.3), right=constant(0.1))
    np.testing.assert_array_equal(both(X, Y), np.where(X >= 2, 0.1, 0.3))
    assert both.keys(np.array([[1.0, 0.5], [2, 0.5], [3, 0.5]])) == [Key(["left"]), Key(["right"]), Key(["right"])]


@pytest.mark.parametrize("seed", range(4))
def test_many_regions_are_as_each_by_itself(seed):
    random = np.random.default_rng(seed)
    x, y = random.uniform(-1, 6, (2, 3000))
    discs = [
        Within(f"r{k % 7}", shapely.Point(random.uniform(0, 5, 2)).buffer(r))
        for k, r in enumerate(random.uniform(0.2, 2, 25))
    ]
    named = {f"r{k}": constant(1 + k) for k in range(5)} | {"rest": constant(0.5)}
    expected = np.full(len(x), np.inf)
    for name, value in named.items():
        mine = [disc for disc in discs if disc.name == name]
        widest = max((disc.polygon.area for disc in mine), default=np.inf)
        others = [disc for disc in discs if disc.name != name and (disc.polygon.area < widest or not mine)]
        there = (
            np.any([shapely.contains_xy(disc.reach, x, y) for disc in mine], axis=0) if mine else np.ones(len(x), bool)
        )
        there &= ~np.any([shapely.contains_xy(disc.core, x, y) for disc in others], axis=0)
        expected[there] = np.minimum(expected[there], value(x, y)[there])
    assert len(np.unique(expected)) > 4
    np.testing.assert_array_equal(limits(discs, **named)(x, y), expected)


def test_a_limit_is_evaluated_where_it_counts_only():
    def picky(x, y):
        assert len(x) > 0
        assert (x >= 1).all()
        return x

    limits([OUTER], outer=picky)(X, Y)


def test_what_holds_a_costly_term_is_costly():
    slow = limits([OUTER], outer=Spacing(constant(1), costly=True))
    assert slow.costly
    assert Combination((Spacing(constant(1)), Spacing(slow, costly=True))).costly
    assert not limits([OUTER], outer=constant(1)).costly
