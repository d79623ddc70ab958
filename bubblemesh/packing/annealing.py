"""Annealing: random displacements where the order is broken, each followed by a short relaxation."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Gt, Le

from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.net import Net, connect_inside
from bubblemesh.packing.placement.perturbation import displacements
from bubblemesh.packing.relaxation import Relaxed
from bubblemesh.spacing.spacing import Spacing

CYCLES = {"fast": 20, "normal": 100, "best": 400}
REGULAR_VALENCE = 6


@dataclass(frozen=True)
class Annealing:
    """Annealing of the coarse levels: grain boundaries heal, and what is left of them is in the right places.

    Bubbles with another number of neighbours than six, and their neighbours, are displaced, less from cycle to cycle.

    Attributes
    ----------
    effort : {"fast", "normal", "best"}
        Number of cycles: 20, 100 or 400.
    amplitude : float
        Standard deviation of the first displacement, in units of spacing.
    amplitude_at_boundary : float
        What of it applies to bubbles next to the boundary.
    shake_steps : int
        Steps of relaxation after each displacement.
    fully_shaken : int
        Levels with more bubbles than this get fewer cycles in proportion, so that each level costs about the same.
    """

    effort: Literal["fast", "normal", "best"] = "normal"
    amplitude: Annotated[float, Gt(0), Le(0.5)] = 0.18
    amplitude_at_boundary: Annotated[float, Ge(0), Le(1)] = 0.5
    shake_steps: Annotated[int, Gt(0)] = 8
    fully_shaken: Annotated[int, Gt(0)] = 1500

    def __call__(
        self,
        net: Net,
        domain: Domain,
        spacing: Spacing,
        random: np.random.Generator,
        relax: Callable[[Net, int], Relaxed],
    ) -> Relaxed:
        """The bubbles after all cycles; ``relax`` takes a net and a number of steps."""
        total = Relaxed.none(net.bubbles)
        cycles = self.cycles(len(net.bubbles))
        for cycle in range(cycles):
            net = connect_inside(self._displaced(net, 1 - cycle / cycles, random), domain, spacing)
            relaxed = relax(net, self.shake_steps)
            total = total.followed_by(relaxed)
            # The edges from before the relaxation still tell where the order is broken.
            net = (
                connect_inside(relaxed.bubbles, domain, spacing)
                if relaxed.lost
                else replace(net, bubbles=relaxed.bubbles)
            )
        return total

    def cycles(self, bubbles: int) -> int:
        """Number of cycles on a level of so many bubbles."""
        return math.ceil(CYCLES[self.effort] * min(1, self.fully_shaken / bubbles))

    def _displaced(self, net: Net, share: float, random: np.random.Generator) -> Bubbles:
        """The bubbles after a displacement by this share of the first one."""
        bubbles, inside = net.bubbles, net.bubbles.interior
        shift = displacements(random, len(bubbles))
        at_boundary = net.dilated(np.arange(len(bubbles)) < bubbles.boundary_count)
        amplitude = share * np.where(at_boundary, self.amplitude_at_boundary * self.amplitude, self.amplitude)
        amplitude[~net.dilated(net.valence != REGULAR_VALENCE)] = 0
        x = bubbles.x.copy()
        x[inside] += (amplitude * bubbles.d)[inside, None] * shift[inside]
        return replace(bubbles, x=x)
