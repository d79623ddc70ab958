"""Grids of numbers: those with places, arrays and pictures."""
