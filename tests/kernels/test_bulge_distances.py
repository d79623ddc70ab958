"""Distances from cubics above chords: the same bytes in C as in NumPy."""

import numpy as np
import pytest
from twins import needs_compiler

from bubblemesh.geometry.distance.bulges import LEAST_SLOPE, STEPS, Bulges
from bubblemesh.kernels.bulges import bulge_distances


def turned(vectors, angle):
    (x, y), c, s = vectors.T, np.cos(angle), np.sin(angle)
    return np.column_stack([c * x - s * y, s * x + c * y])


@needs_compiler
@pytest.mark.parametrize("seed", range(5))
def test_distances_are_those_in_numpy_to_the_last_bit(seed):
    random, count = np.random.default_rng(seed), 3000
    start = random.normal(size=(200, 2))
    end = start + random.normal(size=(200, 2)) * 10 ** random.uniform(-6, 2, (200, 1))
    before, after = (turned(end - start, random.normal(size=200, scale=0.5)) for _ in range(2))
    bulges = Bulges.of(start, end, before, after, random.random(200) < 0.2, random.random(200) < 0.2)
    of = random.integers(200, size=count)
    away = random.normal(size=(count, 2)) * 10 ** random.uniform(-8, 3, (count, 1))
    points = bulges.start[of] + np.where(random.random((count, 1)) < 0.1, 0, away * bulges.length[of, None])
    found = bulge_distances(bulges.rows, points, of, STEPS, LEAST_SLOPE)
    np.testing.assert_array_equal(found, bulges.distances(points, of))
