"""Setting of a packing: what its levels have in common."""

from typing import NamedTuple

import numpy as np

from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.progress import Progress


class Setting(NamedTuple):
    """Domain, random numbers and progress of a packing: the same on all of its levels."""

    domain: Domain
    random: np.random.Generator
    progress: Progress
