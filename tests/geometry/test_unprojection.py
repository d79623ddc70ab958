"""Coordinates, as they were given, of places in a plane: as `Plane.given`, faster."""

import pickle

import numpy as np
import pytest

pytest.importorskip("pyproj")

from bubblemesh.geometry.plane import Plane
from bubblemesh.geometry.unprojection import TOLERANCE, Unprojection


def distances(plane, bounds, x, y):
    """How far the places are, in the plane, from those of the coordinates that are found."""
    return np.hypot(*(plane.near(np.column_stack(Unprojection(plane, bounds)(x, y))) - np.column_stack([x, y])).T)


@pytest.mark.parametrize("source", ["EPSG:4326", "EPSG:32630"])
@pytest.mark.parametrize(
    ("middle", "size"),
    [
        *(((-3.0, 50.0), 10e3), ((-3.0, 50.0), 400e3), ((0.0, 1.0), 10e3), ((0.0, 1.0), 900e3)),
        *(((2.0, 75.0), 10e3), ((2.0, 75.0), 100e3)),
        pytest.param((2.0, 75.0), 900e3, marks=pytest.mark.long),  # for which it takes the finest table
    ],
)
def test_places_are_right_to_a_millionth_of_the_domain(source, middle, size):
    plane = Plane(source, None, middle)
    x, y = np.random.default_rng(0).uniform(-0.55 * size, 0.55 * size, (2, 2_000))
    unprojection = Unprojection(plane, (-size / 2, -size / 4, size / 2, size / 4))
    assert unprojection._table is not None
    assert distances(plane, unprojection.bounds, x, y).max() < TOLERANCE * size


def test_places_beyond_the_table_are_exact():
    plane = Plane("EPSG:4326", None, (-3.0, 50.0))
    unprojection = Unprojection(plane, (-1e4, -1e4, 1e4, 1e4))
    x, y = np.array([0.0, 5e4, -9e5]), np.array([0.0, 5e4, 9e5])
    found, expected = np.column_stack(unprojection(x, y)), plane.given(np.column_stack([x, y]))
    np.testing.assert_array_equal(found[1:], expected[1:])
    np.testing.assert_allclose(found[0], expected[0], atol=1e-6)
    x, y = x[:1], y[:1]
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(unprojection))(x, y), unprojection(x, y))


@pytest.mark.parametrize("middle", [179.0, 181.0, -179.5])
def test_longitudes_go_on_across_the_date_line(middle):
    plane = Plane("EPSG:4326", "EPSG:4326", (middle, -10.0))
    x = np.linspace(-3e5, 3e5, 101)
    for longitudes in (
        plane.given(np.column_stack([x, 0 * x]))[:, 0],
        plane.written(np.column_stack([x, 0 * x]))[:, 0],
        Unprojection(plane, (-3e5, -3e5, 3e5, 3e5))(x, 0 * x)[0],
    ):
        assert abs(longitudes[50] - middle) < 1e-6
        assert (np.diff(longitudes) > 0).all()
