"""Quadtrees for the tests."""


def balanced(grid):
    needed = grid.unbalanced()
    while (large := grid.among(needed)).any():
        grid, _, _ = grid.split(large)
    return grid
