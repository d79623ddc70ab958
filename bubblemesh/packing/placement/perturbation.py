"""Chance: a small displacement of the initial bubbles, so that no run rests on a symmetry of its start."""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from annotated_types import Ge, Le
from typing_extensions import Doc

from bubblemesh.arrays import Floats
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.spacing.spacing import Spacing

CLIPPED_AT = 2.0  # standard deviations


@dataclass(frozen=True)
class Perturbation:
    """Normal displacement of the interior bubbles, small beside their distance from the boundary."""

    seed: Annotated[
        int, Ge(0), Doc("seed of the random numbers; another one gives another mesh of the same quality")
    ] = 0
    jitter: Annotated[
        float, Ge(0), Le(0.1), Doc("displacement of the initial bubbles, standard deviation in units of spacing")
    ] = 0.01

    def generator(self) -> np.random.Generator:
        """The random numbers of a run."""
        return np.random.default_rng(self.seed)

    def __call__(self, bubbles: Bubbles, spacing: Spacing, random: np.random.Generator) -> Bubbles:
        """The bubbles after the displacement."""
        inside = bubbles.interior
        x = bubbles.x.copy()
        shift = displacements(random, len(x[inside]))
        x[inside] += self.jitter * bubbles.d[inside, None] * shift
        return replace(bubbles, x=x, d=spacing(x))


def displacements(random: np.random.Generator, count: int) -> Floats:
    """Normal displacements (count, 2) of standard deviation 1, of which none is so long that a bubble would be lost."""
    return random.standard_normal((count, 2)).clip(-CLIPPED_AT, CLIPPED_AT)
