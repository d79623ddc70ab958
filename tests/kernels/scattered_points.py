"""Points near those of a grid in the unit square, for triangulations."""

import numpy as np

SQUARE = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
SIDES = np.array([[0, 1], [1, 2], [2, 3], [3, 0]])


def scattered(seed, rows=17):
    """Points near those of a grid in a square, with its corners first."""
    steps = (np.arange(rows) + 0.5) / rows
    grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    return np.vstack([SQUARE, grid + np.random.default_rng(seed).uniform(-0.2, 0.2, grid.shape) / rows])
