"""Plateaus: spacings that many of a domain's bubbles have in common."""

import numpy as np

from bubblemesh.arrays import Booleans, Floats
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.placement.diffusion import AREA
from bubblemesh.records import record
from bubblemesh.spacing.grid.cells import Leaves, leaves
from bubblemesh.spacing.grid.quadtree import CORNERS
from bubblemesh.spacing.spacing import Spacing

SAMPLE = 4.0  # spacings: the spacing is looked at in cells of that size
MOST_CELLS = 20_000  # about, if the number of nodes is known
EVEN = 0.005  # relative difference of spacings that counts as none
LEAST_SHARE = 0.1  # of the bubbles


@record
class Plateau:
    """A spacing that does not vary over a part of a domain."""

    d: float
    share: float  # of the domain's bubbles
    bubbles: float  # their number, about

    def holds(self, d: Floats) -> Booleans:
        """Which of the spacings (n,) are that one."""
        return np.abs(d / self.d - 1) <= EVEN


def plateaus(domain: Domain, spacing: Spacing, expected_nodes: float) -> tuple[Plateau, ...]:
    """The spacings that a tenth of the bubbles or more have, the most frequent first.

    If very many nodes are expected, the spacing is looked at in larger cells.
    """
    cells = leaves(domain, spacing, max(SAMPLE, float(np.sqrt(expected_nodes / MOST_CELLS))))
    order = np.argsort(cells.d, kind="stable")
    d, bubbles = cells.d[order], (cells.sides / cells.d)[order] ** 2 / AREA
    count = float(bubbles.sum())
    share = np.where(_even(cells, spacing)[order], bubbles / count, 0.0)
    found = list[Plateau]()
    while len(d):
        before = np.append(0.0, np.cumsum(share))
        together = before[np.searchsorted(d, d * (1 + EVEN), side="right")] - before[:-1]
        most = int(np.argmax(together))
        if together[most] < LEAST_SHARE:
            break
        found.append(Plateau(float(d[most]), float(together[most]), float(together[most]) * count))
        others = (d < d[most] * (1 - 2 * EVEN)) | (d > d[most] * (1 + 2 * EVEN))
        d, share = d[others], share[others]
    return tuple(found)


def _even(cells: Leaves, spacing: Spacing) -> Booleans:
    """Cells (n,) whose corners have the spacing of their centre."""
    corners = cells.centers + (CORNERS - 0.5)[:, None] * cells.sides[:, None]
    at = spacing.extended(corners.reshape(-1, 2)).reshape(len(CORNERS), -1)
    return np.all(np.abs(at / cells.d - 1) <= EVEN, axis=0)
