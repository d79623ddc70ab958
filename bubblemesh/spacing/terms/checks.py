"""Arrays that spacings are given by, checked for what they are to be."""

from typing import Any

import numpy as np

from bubblemesh.arrays import LARGEST_NUMBER, Floats, Integers, unmasked
from bubblemesh.errors import CaseError
from bubblemesh.messages import place


def numbers(given: Any, name: str, shape: tuple[int | None, ...] | None = None) -> Floats:
    """The numbers of an array, with NaN where a masked one hides them; in its ``shape`` any length may stand for None.

    CaseError, which begins with the ``name``, if these are no real numbers, or of another shape.
    """
    try:
        values = np.asarray(unmasked(given))
    except ValueError:  # rows of unequal length
        raise CaseError(f"{name}: has rows of unequal length") from None
    if values.dtype.kind not in "iuf":
        raise CaseError(f"{name}: must be real numbers (found {values.dtype})")
    if shape is not None and not (
        values.ndim == len(shape) and all(n in (None, m) for n, m in zip(shape, values.shape, strict=True))
    ):
        expected = ", ".join("n" if n is None else str(n) for n in shape) + ("," if len(shape) == 1 else "")
        raise CaseError(f"{name}: must have the shape ({expected}) (found {values.shape})")
    return values.astype(float, copy=False)


def places(given: Any) -> Floats:
    """The points (n, 2); CaseError if they have another shape, or a coordinate is no number or a huge one."""
    points = numbers(given, "points", (None, 2))
    bad = np.flatnonzero(~(np.abs(points) <= LARGEST_NUMBER).all(axis=1))
    if len(bad):
        what = f"no number, or above {LARGEST_NUMBER:g}"
        raise CaseError(f"point {bad[0]} (from 0), {place(points[bad[0]])}, has a coordinate that is {what}")
    return points


def cells_of(given: Any, triangles: int, cells: int) -> Integers:
    """The number (t,) of the cell of each triangle; CaseError if one is missing, or no number of a cell."""
    numbered = np.asarray(given)
    if numbered.shape != (triangles,) or numbered.dtype.kind not in "iu":
        raise CaseError(f"cells: must be a whole number for each of {triangles} triangles (found {numbered.shape})")
    if numbered.min() < 0 or numbered.max() >= cells:
        raise CaseError(f"cells: must be from 0 to {cells - 1}, as there are values")
    return numbered.astype(np.int64, copy=False)


def triangles_of(given: Any, nodes: int) -> Integers:
    """The triangles (t, 3) of nodes from 0; CaseError for another shape or type, or for nodes that are not there."""
    triangles = np.asarray(given)
    if triangles.ndim != 2 or triangles.shape[1] != 3 or len(triangles) == 0 or triangles.dtype.kind not in "iu":
        raise CaseError(
            f"triangles: must be node numbers of shape (t, 3) (found the shape {triangles.shape}, type "
            f"{triangles.dtype})"
        )
    if triangles.min() < 0 or triangles.max() >= nodes:
        raise CaseError(
            f"triangles: must be of the nodes 0 to {nodes - 1} (found {triangles.min()} to {triangles.max()})"
        )
    return triangles.astype(np.int64, copy=False)
