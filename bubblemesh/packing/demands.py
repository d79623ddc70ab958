"""Demands on the triangles of a mesh."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Demands:
    """Demands on triangles: a least angle, largest areas, and a node that is not on the rings of the domain."""

    angle: float = 0.0  # degrees: the least one
    areas: tuple[float, ...] = (np.inf,)  # the largest ones, for each region by its number, or one for all
    inner_node: bool = False  # whether each triangle needs a node that is not on the rings
    max_nodes: int = 2_000_000

    def __bool__(self) -> bool:
        return self.angle > 0 or min(self.areas) < np.inf or self.inner_node
