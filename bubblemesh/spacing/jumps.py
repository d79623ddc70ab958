"""Places where the spacing jumps: it has to be made to grow there, since triangles cannot jump in size."""

import numpy as np

from bubblemesh.geometry.domain import Domain
from bubblemesh.spacing.quadtree import leaves
from bubblemesh.spacing.refinement import Sources
from bubblemesh.spacing.spacing import Spacing

__all__ = ["jumps"]

CELL = 2.0  # spacings: over that length a jump is looked for
STEEP = 0.1  # change of the spacing per length that is worth a closer look
BENT = 0.25  # part of the change that the middle is off the mean: a slope or a kink is less bent than a jump
STEEPEST = 0.7  # change of the spacing per length that a packing can follow
HALVINGS = 8
COMPASS = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])


def jumps(domain: Domain, spacing: Spacing) -> Sources:
    """Sources on the fine side of places where the spacing changes faster than any packing can follow.

    Neighbouring cells whose spacings differ, and whose mean is not that in the middle, are the ends of a bisection
    for the jump between them. Spots finer than the cells stay unseen.
    """
    cells = leaves(domain, spacing, CELL)
    here = np.repeat(cells.centers, len(COMPASS), axis=0)
    there = (cells.centers[:, None] + cells.sides[:, None, None] * COMPASS).reshape(-1, 2)
    d, e = np.repeat(cells.d, len(COMPASS)), spacing.extended(there)
    steep = np.flatnonzero(np.abs(e - d) > STEEP * np.repeat(cells.sides, len(COMPASS)))
    middle = spacing.extended((here + there)[steep] / 2)
    steep = steep[np.abs(middle - (d + e)[steep] / 2) > BENT * np.abs(e - d)[steep]]
    steep = steep[domain.contains(there[steep]) & domain.contains((here + there)[steep] / 2)]
    here, there, d, e = here[steep], there[steep], d[steep], e[steep]
    falling = (e > d)[:, None]
    fine, coarse = np.where(falling, here, there), np.where(falling, there, here)
    low, high = np.minimum(d, e), np.maximum(d, e)
    for _ in range(HALVINGS):
        halfway = (fine + coarse) / 2
        m = spacing.extended(halfway)
        beyond = high - m > m - low  # the larger part of the change is on the coarse half
        fine, low = np.where(beyond[:, None], halfway, fine), np.where(beyond, m, low)
        coarse, high = np.where(beyond[:, None], coarse, halfway), np.where(beyond, high, m)
    jump = (high - low > STEEPEST * np.hypot(*(coarse - fine).T)) & domain.contains(fine) & domain.contains(coarse)
    return Sources(fine[jump], low[jump])
