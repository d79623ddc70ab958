"""A mesh as a tool made it."""

from dataclasses import dataclass

from bubblemesh.arrays import Floats, Integers


@dataclass(frozen=True)
class Made:
    """A mesh: points (n, 2), triangles (t, 3), boundary edges (b, 2), and edges (w, 2) of the walls with layers."""

    points: Floats
    triangles: Integers
    facets: Integers
    walls: Integers
