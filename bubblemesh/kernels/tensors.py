"""Roots of symmetric tensors, as rows (m11, m12, m22), and lengths in them."""

import numpy as np

from bubblemesh.arrays import Floats


def lengths(tensors: Floats, vectors: Floats) -> Floats:
    """Lengths (n,) of vectors (n, 2) in tensors (n, 3)."""
    (m11, m12, m22), (vx, vy) = tensors.T, vectors.T
    return np.asarray(np.sqrt(np.maximum(m11 * vx * vx + 2 * (m12 * vx * vy) + m22 * vy * vy, 0.0)))


def mean_lengths(first: Floats, last: Floats) -> Floats:
    """Lengths (n,) of edges that are ``first`` (n,) and ``last`` (n,) long in the metrics of their two ends.

    They are two thirds of the geometric mean and a third of the plain one. That is close to the logarithmic mean, the
    length if the metric changes geometrically from end to end: larger by less than 2 % up to a ratio of 15.
    """
    return np.asarray((2 * np.sqrt(first * last) + (first + last) / 2) / 3)


def roots(tensors: Floats) -> Floats:
    """Upper triangular matrices R (n, 3), as rows (r11, r12, r22), with R' R equal to tensors (n, 3).

    The length of a vector in a tensor is the usual one of R times the vector.
    """
    m11, m12, m22 = tensors.T
    r11 = np.sqrt(m11)
    r12 = m12 / r11
    return np.column_stack([r11, r12, np.sqrt(np.maximum(m22 - r12 * r12, np.finfo(float).tiny))])


def mapped(root: Floats, vectors: Floats) -> Floats:
    """Products (n, 2) of matrices (n, 3), as in `roots`, and vectors (n, 2)."""
    (r11, r12, r22), (vx, vy) = root.T, vectors.T
    return np.column_stack([r11 * vx + r12 * vy, r22 * vy])


def unmapped(root: Floats, vectors: Floats) -> Floats:
    """Vectors (n, 2) whose products with the matrices (n, 3), as in `roots`, are the given ones: `mapped` undone."""
    (r11, r12, r22), (vx, vy) = root.T, vectors.T
    y = vy / r22
    return np.column_stack([(vx - r12 * y) / r11, y])
