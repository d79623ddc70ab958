"""A spacing given by values at scattered points."""

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError
from bubblemesh.messages import place
from bubblemesh.spacing.terms.field import Field
from bubblemesh.spacing.terms.values import require_positive

THINNEST = 1e-9  # width of the points' hull in terms of its length


def scattered(points: Floats, values: Floats) -> Field:
    """Linear interpolation of values (n,) on the Delaunay triangulation of points (n, 2).

    Outside the points' hull, the value at its nearest place.

    Raises
    ------
    CaseError
        If a coordinate is no number, a value is not positive and finite, points at one place have different values, or
        all lie on a line; the text names the point, from 0, and its place.
    """
    # Imported here since it takes as long as meshing a small case, and other spacings do without.
    from scipy.spatial import Delaunay, QhullError

    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise CaseError(f"point {bad[0]} (from 0), {place(points[bad[0]])}, has a coordinate that is no number")
    require_positive(values, lambda k: f"at point {k} (from 0), {place(points[k])}")
    places, first, number = np.unique(points, axis=0, return_index=True, return_inverse=True)
    twice = np.flatnonzero(values != values[first][number])
    if len(twice):
        k, other = twice[0], first[number[twice[0]]]
        raise CaseError(
            f"points {other} and {k} (from 0) are both at {place(points[k])}, with the values {values[other]:g} and "
            f"{values[k]:g}: keep one of them"
        )
    centered = places - places.mean(axis=0)
    extent = np.linalg.svd(centered, compute_uv=False) if len(places) > 2 else np.zeros(2)
    if extent[1] <= THINNEST * extent[0]:
        raise CaseError("the points lie on a line, or are fewer than three: triangles between them are needed")
    try:
        triangles = Delaunay(centered / extent[0]).simplices
    except QhullError as error:  # of these its first line tells enough
        raise CaseError(f"the points cannot be triangulated: {str(error).splitlines()[0]}") from error
    return Field.of(places, triangles.astype(np.int64), values[first])
