"""Grids that hold a spacing."""
