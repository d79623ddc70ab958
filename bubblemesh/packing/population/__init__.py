"""Population control: which bubbles go, and where new ones come."""

from typing import NamedTuple, Protocol

import numpy as np

from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.net import Net
from bubblemesh.spacing.spacing import Spacing


class Change(NamedTuple):
    """Bubbles after population control, which marks those it touched."""

    bubbles: Bubbles
    deleted: int
    inserted: int


class Population(Protocol):
    """Which bubbles go, and where new ones come."""

    def __call__(self, net: Net, domain: Domain, spacing: Spacing, random: np.random.Generator) -> Change:
        """Control the whole population once."""
