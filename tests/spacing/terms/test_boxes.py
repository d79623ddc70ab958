import numpy as np
import pytest

from bubblemesh.spacing.terms.regions import Boxes


def random_boxes(count, rng):
    corners = rng.random((count, 2, 2))
    widths = np.where(rng.random((count, 1)) < 0.2, 1.0, 0.1)  # some that span the grid
    low = corners[:, 0]
    return np.column_stack([low, low + widths * corners[:, 1]])


@pytest.mark.long
@pytest.mark.parametrize("count", [1, 2, 7, 300, 20_000])
def test_the_boxes_that_hold_a_point_are_found(count):
    rng = np.random.default_rng(count)
    bounds = random_boxes(count, rng)
    corners = bounds[: min(count, 50)].reshape(-1, 2)
    x, y = np.vstack([2.5 * rng.random((200, 2)) - 0.5, corners]).T  # also outside the grid, and on its edges
    point, box = Boxes.of(bounds).holding(x, y)
    x0, y0, x1, y1 = bounds.T
    held = (x[:, None] >= x0) & (x[:, None] <= x1) & (y[:, None] >= y0) & (y[:, None] <= y1)
    assert list(zip(point.tolist(), box.tolist(), strict=True)) == [(int(p), int(b)) for p, b in np.argwhere(held)]


@pytest.mark.parametrize("scale", [1e-60, 1e60])
def test_the_unit_of_length_does_not_matter(scale):
    bounds = random_boxes(30, np.random.default_rng(0))
    x, y = np.random.default_rng(1).random((2, 100))
    found = Boxes.of(scale * bounds).holding(scale * x, scale * y)
    np.testing.assert_array_equal(found, Boxes.of(bounds).holding(x, y))


def test_boxes_without_extent():
    point, box = Boxes.of(np.array([[1.0, 2, 1, 2], [1, 2, 3, 2]])).holding(
        np.array([1.0, 2, 2]), np.array([2.0, 2, 3])
    )
    assert (point.tolist(), box.tolist()) == ([0, 0, 1], [0, 1, 1])
