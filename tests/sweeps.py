"""Sweeps: parametrizations with more rows than quick tests need."""

import pytest


def sweep(rows, quick):
    """Rows of a parametrization: so many of them, evenly spread, are quick tests, and the others are long ones."""
    rows = list(rows)
    chosen = {number * len(rows) // quick for number in range(quick)}
    return [row if number in chosen else _long(row) for number, row in enumerate(rows)]


def _long(row):
    return pytest.param(*(row if isinstance(row, tuple) else (row,)), marks=pytest.mark.long)
