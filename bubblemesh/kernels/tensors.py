"""Symmetric tensors, as rows (m11, m12, m22): lengths in them, their roots, and the intersections of their ellipses."""

import numpy as np

from bubblemesh.arrays import Floats, Integers, members


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


def seen_from(root: Floats, others: Floats) -> tuple[Floats, Floats, Floats]:
    """Entries (n,) of tensors M in coordinates in which other tensors, with roots R (n, 3), are unit: R^-T M R^-1."""
    r11, r12, r22 = root.T
    i11, i12, i22 = 1 / r11, -r12 / (r11 * r22), 1 / r22
    m11, m12, m22 = others.T
    n12 = i11 * (i12 * m11 + i22 * m12)
    return i11 * i11 * m11, n12, i12 * i12 * m11 + 2 * i12 * i22 * m12 + i22 * i22 * m22


def intersections(some: Floats, others: Floats) -> Floats:
    """Tensors (n, 3) of the largest ellipses within the ellipses of both of two tensors (n, 3).

    In the basis in which both tensors are diagonal, each diagonal entry is the larger one of both.

    References
    ----------
    P. J. Frey, F. Alauzet, "Anisotropic mesh adaptation for CFD computations", Comput. Methods Appl. Mech. Engrg. 194
    (2005), section 2.
    """
    n11, n12, n22 = seen_from(root := roots(some), others)
    half, apart = (n11 + n22) / 2, np.sqrt(((n11 - n22) / 2) ** 2 + n12 * n12)
    large, small = np.maximum(half + apart, 1.0), np.maximum(half - apart, 1.0)
    # With the larger eigenvalues a and b of both: (a + b) / 2 I + (a - b) / 2 (N - half I) / apart.
    mean, part = (large + small) / 2, (large - small) / 2 / np.where(apart > 0, apart, 1.0)
    k11, k12, k22 = mean + part * (n11 - half), part * n12, mean + part * (n22 - half)
    r11, r12, r22 = root.T
    return np.column_stack(
        [
            r11 * r11 * k11,
            r11 * (r12 * k11 + r22 * k12),
            r12 * r12 * k11 + 2 * r12 * r22 * k12 + r22 * r22 * k22,
        ]
    )


def intersected_at(tensors: Floats, at: Integers, others: Floats) -> Floats:
    """Tensors (n, 3), each intersected with those of the others (m, 3) that are ``at`` (m,) its number, in turn."""
    result, order = tensors.copy(), np.argsort(at, kind="stable")
    _, counts = np.unique(at, return_counts=True)
    _, turn = members(counts)
    for turned in range(int(counts.max(initial=0))):  # in which each number comes once at most
        some = order[turn == turned]
        result[at[some]] = intersections(result[at[some]], others[some])
    return result
