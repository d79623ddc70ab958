"""Names for the array types that the signatures use, and what NumPy lacks."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Booleans = NDArray[np.bool_]

GAUSS = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3)  # places of the two-point Gauss rule on [0, 1], of equal weights


def members(counts: Integers) -> tuple[Integers, Integers]:
    """Groups (m,) and ranks (m,) within them, from 0, of all members of groups with ``counts`` (n,) members."""
    group = np.repeat(np.arange(len(counts)), counts)
    return group, np.arange(len(group)) - (np.cumsum(counts) - counts)[group]
