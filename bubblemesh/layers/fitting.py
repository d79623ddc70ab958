"""Fitting: columns as high as they may be so that all cells are valid and none meets another."""

import numpy as np

from bubblemesh.layers.columns import Columns
from bubblemesh.layers.heights import Most, heights
from bubblemesh.layers.obstacles import Obstacles
from bubblemesh.layers.room import limited_slopes, room
from bubblemesh.layers.strips import Strips
from bubblemesh.layers.walls import Walls

LOWERED = 0.8  # of their height: columns that are in the way
PATIENCE = 16  # times that a column is lowered before it has no layers


def fitted_strips(columns: Columns, walls: Walls, most: Most) -> Strips:
    """Strips between columns of the layers that they can have at most, as high as there is room for.

    Where cells are not valid or meet others the columns are made lower, again and again: without layers a column is in
    nobody's way, so that this ends.
    """
    obstacles = Obstacles.of(walls)
    height = room(columns, walls, obstacles, most.count)
    lowered = np.zeros(len(columns), np.int64)
    strips = Strips.of(columns, walls, heights(columns, height, most))
    while (wrong := obstacles.in_the_way(strips)).any():
        lowered[wrong] += 1
        height = np.where(wrong, LOWERED * np.minimum(height, strips.reached), height)
        height[lowered > PATIENCE] = 0.0
        height = limited_slopes(columns, height)
        strips = Strips.of(columns, walls, heights(columns, height, most))
    return strips
