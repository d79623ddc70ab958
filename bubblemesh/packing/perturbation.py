"""A small random displacement of the initial bubbles, so that no run rests on a symmetry of its start."""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from annotated_types import Ge

from bubblemesh.packing.bubbles import Bubbles

__all__ = ["Perturbation"]

CLIPPED_AT = 2.0  # standard deviations


@dataclass(frozen=True)
class Perturbation:
    """Normal displacement of the interior bubbles; another seed gives another mesh of the same quality.

    Attributes
    ----------
    seed : int
    jitter : float
        Standard deviation in units of spacing; small beside the clearance from the boundary.
    """

    seed: Annotated[int, Ge(0)] = 0
    jitter: Annotated[float, Ge(0)] = 0.01

    def __call__(self, bubbles: Bubbles) -> Bubbles:
        """The bubbles displaced."""
        inside = bubbles.interior
        shape = bubbles.x[inside].shape
        shift = np.random.default_rng(self.seed).standard_normal(shape).clip(-CLIPPED_AT, CLIPPED_AT)
        x = bubbles.x.copy()
        x[inside] += self.jitter * bubbles.d[inside, None] * shift
        return replace(bubbles, x=x)
