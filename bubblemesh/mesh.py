"""The product: a triangle mesh with labelled boundary edges."""

from dataclasses import dataclass

from bubblemesh.arrays import Floats, Integers

__all__ = ["Mesh"]


@dataclass(frozen=True)
class Mesh:
    """A conforming triangle mesh of a plane domain.

    Attributes
    ----------
    points : (n, 2)
        Node coordinates, boundary nodes first; every node belongs to a triangle.
    triangles : (t, 3)
        Counter-clockwise node indices.
    facets : (f, 2)
        Node indices of the boundary edges, with the domain on their left.
    facet_labels : (f,)
        Index into ``labels`` for each boundary edge.
    labels : tuple of str
        Names of the boundary labels; each is used by at least one facet.
    region : str
        Name of the region that the triangles fill.
    """

    points: Floats
    triangles: Integers
    facets: Integers
    facet_labels: Integers
    labels: tuple[str, ...]
    region: str = "domain"
