"""Spacings of arrays that do not fit together."""

import numpy as np
import pytest

from bubblemesh.errors import CaseError
from bubblemesh.spacing.terms.field import MeshField, scattered
from bubblemesh.spacing.terms.raster import Raster

POINTS, TRIANGLES = [[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]]
HIDDEN = np.ma.array([0.1, 0.2, 0.1, 0.2], mask=[0, 1, 0, 0])


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (
            lambda: MeshField.of(POINTS, TRIANGLES, [0.1, 0.2, 0.1]),
            r"values: must be real numbers of shape \(4,\) \(found the shape \(3,\)",
        ),
        (lambda: MeshField.of(POINTS, TRIANGLES, ["a"] * 4), "values: must be real numbers"),
        (lambda: MeshField.of(POINTS, TRIANGLES, HIDDEN), r"is nan at node 1 \(from 0\)"),
        (lambda: MeshField.of([0, 1], TRIANGLES, [0.1] * 4), r"points: must be real numbers of shape \(n, 2\)"),
        (lambda: MeshField.of([[0, 0], [1]], TRIANGLES, [0.1] * 4), "points: must be an array of .* rows of unequal"),
        (
            lambda: MeshField.of([[0, np.nan], *POINTS[1:]], TRIANGLES, [0.1] * 4),
            "points: must be finite .*found nan in row 0",
        ),
        (
            lambda: MeshField.of(POINTS, [[0, 1, 4]], [0.1] * 4),
            r"triangles: must be indices of 4 nodes, from 0 on \(found 4 in row 0",
        ),
        (lambda: MeshField.of(POINTS, [[0.0, 1, 2]], [0.1] * 4), "triangles: must be whole numbers"),
        (lambda: MeshField.of(POINTS, np.zeros((0, 3), int), [0.1] * 4), "none of the triangles has an area"),
        (lambda: MeshField.of_triangles(POINTS, TRIANGLES, [0.1]), r"values: must be real numbers of shape \(2,\)"),
        (
            lambda: MeshField.of_triangles(POINTS, TRIANGLES, [0.1], [0]),
            r"cells: must be whole numbers of shape \(2,\)",
        ),
        (
            lambda: MeshField.of_triangles(POINTS, TRIANGLES, [0.1], [0, 1]),
            "cells: must be indices of 1 value, from 0 on",
        ),
        (lambda: scattered(POINTS, [0.1] * 3), r"values: must be real numbers of shape \(4,\)"),
        (lambda: scattered(POINTS, HIDDEN), r"is nan at point 1 \(from 0\)"),
        (lambda: Raster.within((0, 0, 1), [[0.1]]), r"bounds: must be real numbers of shape \(4,\)"),
        (lambda: Raster.within((0, 0, 1, 0), [[0.1]]), "bounds: must be x0, y0, x1, y1 with"),
        (lambda: Raster.within((0, 0, 1, 1), [[0.1], [0.1, 0.2]]), "values: must be an array of .* rows of unequal"),
        (lambda: Raster.within((0, 0, 1, 1), HIDDEN.reshape(2, 2)), "is nan in row 0, column 1"),
    ],
)
def test_what_does_not_fit_is_told(made, message):
    with pytest.raises(CaseError, match=message):
        made()


def test_lists_are_as_good_as_arrays():
    field = MeshField.of(POINTS, TRIANGLES, [0.1, 0.2, 0.2, 0.1])
    raster = Raster.of([0, 1], [0, 1], [[0.1, 0.2], [0.1, 0.2]])
    at = np.array([0.25, 0.5]), np.array([0.5, 0.25])
    np.testing.assert_allclose(field(*at), [0.125, 0.15])
    np.testing.assert_allclose(raster(*at), [0.125, 0.15])
    np.testing.assert_allclose(scattered(POINTS, [0.1, 0.2, 0.2, 0.1])(*at), [0.125, 0.15])
