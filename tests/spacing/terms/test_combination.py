import numpy as np
import pytest

from bubblemesh.errors import Key
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.terms.combination import Combination

X, Y = np.array([0.0, 1.0, 2.0, 3.0]), np.zeros(4)


def term(*values, key="spacing"):
    """A term with values at the points x = 0, 1, 2 ..."""
    return Spacing(lambda x, y: np.array(values, float)[x.astype(int)], keys=lambda points: [Key([key])] * len(points))


def test_smallest_term_counts():
    found = Combination((term(1, 2, 3, 4), term(4, 3, 2, 1), term(np.inf, np.inf, 1, np.inf)))(X, Y)
    np.testing.assert_array_equal(found, [1, 2, 1, 1])


def test_limits_hold_after_the_scale():
    found = Combination((term(1, 2, 3, np.inf),), scale=0.5, minimum=0.8, maximum=1.2)(X, Y)
    np.testing.assert_array_equal(found, [0.8, 1, 1.2, 1.2])


@pytest.mark.parametrize("bad", [np.nan, 0.0, -1.0, -np.inf])
def test_limits_hide_no_value_that_is_none(bad):
    found = Combination((term(1, 2, 3, bad), term(1, 1, 1, 1)), minimum=0.5, maximum=9)(X, Y)
    np.testing.assert_array_equal(found[3], bad)


def test_no_term_asks_for_nothing():
    assert np.isinf(Combination(())(X, Y)).all()


def named(made):
    return list(map(str, made.keys(np.column_stack([X, Y]))))


def test_the_term_that_has_the_value_is_named():
    made = Combination((term(1, 2, 3, np.inf, key="a"), term(1, -1, np.nan, np.inf, key="b")))
    assert named(made) == ["a", "b", "b", "a"]


def test_limits_are_named_where_they_count():
    made = Combination((term(1, 2, 3, np.inf, key="a"), term(9, 1.5, 9, 9, key="b")), 0.5, minimum=0.6, maximum=1.2)
    assert named(made) == ["spacing.minimum", "b", "spacing.maximum", "spacing.maximum"]
    assert named(Combination((term(-1, 0, np.nan, 1, key="a"),), minimum=0.5)) == ["a"] * 4
