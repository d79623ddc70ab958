"""Demands on the triangles of a mesh."""

import numpy as np

from bubblemesh.records import record


@record
class Demands:
    """Demands on triangles: a least angle, largest areas, and a node that is not on the rings of the domain."""

    angle: float = 0.0  # degrees: the least one
    areas: tuple[float, ...] = (np.inf,)  # the largest ones, for each region by its number, or one for all
    inner_node: bool = False  # whether each triangle needs a node that is not on the rings
    max_nodes: int = 2_000_000

    @property
    def corner_angle(self) -> float:
        """Angle in degrees below which a corner of the domain excuses triangles.

        Where each triangle needs a node inside, an edge leaves each corner into the domain, which halves its angle.
        """
        return self.angle * (2 if self.inner_node else 1)
