import numpy as np
import pytest

from bubblemesh.errors import CaseError
from bubblemesh.spacing.spacing import spots
from bubblemesh.spacing.terms import raster
from bubblemesh.spacing.terms.raster import Raster

X, Y = np.array([0.0, 0.5, 2, 3]), np.array([-1.0, 0, 4])


def bilinear(x, y):
    return 9 + 0.5 * x - 0.7 * y + 0.3 * x * y


GRID = bilinear(*np.meshgrid(X, Y))
QUERIES = np.random.default_rng(0).uniform([-1, -3], [5, 6], (500, 2))


def test_bilinear_functions_are_exact_between_the_centres_and_constant_beyond():
    found = Raster.of(X, Y, GRID)(*QUERIES.T)
    np.testing.assert_allclose(found, bilinear(np.clip(QUERIES[:, 0], 0, 3), np.clip(QUERIES[:, 1], -1, 4)), rtol=1e-12)


def test_coordinates_may_descend():
    expected = Raster.of(X, Y, GRID)(*QUERIES.T)
    np.testing.assert_array_equal(Raster.of(X[::-1], Y, GRID[:, ::-1])(*QUERIES.T), expected)
    np.testing.assert_array_equal(Raster.of(X[::-1], Y[::-1], GRID[::-1, ::-1])(*QUERIES.T), expected)


def test_pixels_fill_the_bounds_with_the_first_row_below_or_on_top():
    values = np.array([[1.0, 2, 3], [4, 5, 6]])
    centers = np.stack(np.meshgrid([1 / 6, 0.5, 5 / 6], [12.5, 17.5]), axis=-1).reshape(-1, 2).T
    np.testing.assert_allclose(Raster.within((0, 10, 1, 20), values)(*centers), [1, 2, 3, 4, 5, 6])
    np.testing.assert_allclose(Raster.within((0, 10, 1, 20), values, upper=True)(*centers), [4, 5, 6, 1, 2, 3])
    rim = Raster.within((0, 10, 1, 20), values)
    np.testing.assert_allclose(rim(np.array([0.0, 1, -9]), np.array([10.0, 20, 15])), [1, 6, 2.5])


@pytest.mark.parametrize("shape", [(1, 1), (1, 4), (4, 1)])
def test_one_row_or_column_is_constant_across(shape):
    raster = Raster.within((0, 0, 1, 1), np.arange(1.0, 1 + np.prod(shape)).reshape(shape))
    t = np.linspace(-0.5, 1.5, 40)
    expected = np.clip(0.5 + 4 * t, 1, 4) if max(shape) > 1 else np.ones(40)
    along, across = (t, np.full(40, 0.3)), (np.full(40, 0.3), t)
    np.testing.assert_allclose(raster(*(across if shape[0] > 1 else along)), expected)


def test_scale_multiplies():
    np.testing.assert_allclose(Raster.of(X, Y, GRID).scaled(3)(*QUERIES.T), 3 * Raster.of(X, Y, GRID)(*QUERIES.T))


def test_values_that_are_none_are_named_with_row_column_and_place():
    values = GRID.copy()
    values[1, 2] = np.nan
    with pytest.raises(CaseError, match=r"is nan in row 1, column 2 \(from 0\), \(2, 0\): a spacing has to be"):
        Raster.of(X, Y, values)
    with pytest.raises(CaseError, match=r"is nan in row 1, column 2 \(from 0\), \(2.5, 1.5\)"):
        Raster.within((0, 0, 4, 3), values, upper=True)


@pytest.mark.parametrize(
    ("x", "y", "values", "message"),
    [
        (X, Y, GRID.T, r"x: must be real numbers of shape \(3,\) \(found the shape \(4,\)"),
        (X, X, GRID, r"y: must be real numbers of shape \(3,\) \(found the shape \(4,\)"),
        (*np.meshgrid(X, Y), GRID, r"x: must be real .*found the shape \(3, 4\)"),
        ([0, 1, 1, 2], Y, GRID, "x has to be finite, and ascending or descending from each column"),
        (X, [0, np.nan, 1], GRID, "y has to be finite, and ascending or descending from each row"),
        (X, Y, GRID[0], r"values: must be real numbers of shape \(r, c\) \(found the shape \(4,\)"),
        (X, Y, GRID[:0], r"has the shape \(0, 4\): a raster has at least one row and one column"),
        (X, Y, GRID[..., None], r"found the shape \(3, 4, 1\)"),
    ],
)
def test_shapes_and_coordinates_must_fit(x, y, values, message):
    with pytest.raises(CaseError, match=message):
        Raster.of(np.asarray(x, float), np.asarray(y, float), values)


def test_spots_are_fine_pixels_with_coarse_ones_around():
    values = np.full((5, 7), 0.3)
    values[2, 3] = values[2, 4] = 0.1
    values[4, 0] = 0.29
    spots = Raster.within((0, 0, 7, 5), values).spots
    assert sorted(map(tuple, spots)) == [(3.5, 2.5), (4.5, 2.5)]


@pytest.mark.parametrize("shape", [(9, 13), (1, 13), (9, 1), (1, 1)])
@pytest.mark.parametrize("band", [1, 30, 1000])
def test_spots_are_those_of_the_mesh_of_the_pixels(monkeypatch, shape, band):
    monkeypatch.setattr(raster, "BAND", band)
    rng = np.random.default_rng(1)
    x, y = (np.cumsum(rng.uniform(0.5, 1, count)) for count in shape[::-1])
    values = rng.integers(1, 4, shape).astype(float)
    number = np.arange(values.size).reshape(shape)
    first = np.concatenate([number[:, :-1].ravel(), number[:-1].ravel()])
    last = np.concatenate([number[:, 1:].ravel(), number[1:].ravel()])
    points = np.column_stack([part.ravel() for part in np.meshgrid(x, y)])
    np.testing.assert_array_equal(Raster.of(x, y, values).spots, spots(points, first, last, values.ravel()))
