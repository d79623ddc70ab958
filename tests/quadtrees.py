"""Quadtrees for the tests."""


def balanced(grid):
    while (large := grid.unbalanced()[0]).any():
        grid, _, _ = grid.split(large)
    return grid
