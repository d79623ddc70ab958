"""Quadtrees for the tests."""


def balanced(grid):
    wanted = grid.unbalanced()
    while (large := grid.among(wanted)).any():
        grid, _, _ = grid.split(large)
    return grid
