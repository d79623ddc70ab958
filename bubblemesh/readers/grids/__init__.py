"""Grids of numbers: those with places, arrays and pictures."""

MOST_VALUES = 25_000_000  # of an array or a picture, which are read at once
