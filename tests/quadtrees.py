"""Quadtrees for the tests."""


def balanced(grid):
    while (large := grid.unbalanced()).any():
        grid, _, _ = grid.split(large)
    return grid
