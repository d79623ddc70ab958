import numpy as np
import pytest

from bubblemesh.errors import Key
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.terms.combination import Combination

X, Y = np.array([0.0, 1.0, 2.0, 3.0]), np.zeros(4)


def term(*values, key="spacing"):
    """A term with values at the points x = 0, 1, 2 ..."""
    return Spacing(lambda x, y: np.array(values, float)[x.astype(int)], key=lambda point: Key([key]))


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


@pytest.mark.parametrize(("at", "key"), [(0, "a"), (1, "b"), (2, "b"), (3, "a")])
def test_the_term_that_has_the_value_is_named(at, key):
    made = Combination((term(1, 2, 3, np.inf, key="a"), term(1, -1, np.nan, np.inf, key="b")))
    assert str(made.key(np.array([at, 0.0]))) == key
