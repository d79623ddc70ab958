"""Sizes for the next mesh from the solution on the present one."""
