"""The interbubble force, equation (2.1) of the paper."""

from functools import cached_property
from typing import Annotated, Literal

import numpy as np
from annotated_types import Gt, Le
from typing_extensions import Doc

from bubblemesh.arrays import Floats
from bubblemesh.kernels.relaxing import CUTOFF, Pull, forces
from bubblemesh.packing.neighbours import Neighbours
from bubblemesh.records import record


@record
class VanDerWaals:
    """Sum of the pair forces, in the directions away from the neighbours."""

    k0: Annotated[float, Gt(0), Le(100), Doc("strength of the force")] = 1.0
    force: Annotated[
        Literal["scaled", "plain"],
        Doc(
            "`scaled`: the force is multiplied by the bubble's spacing, so that one time step serves every case; "
            "`plain`: as printed in the paper, for a case whose spacing is about 0.1 in its unit (with `dt: 0.05`)"
        ),
    ] = "scaled"

    def among(self, neighbours: Neighbours) -> "BoundForce":
        """The force as a function of the positions, for these neighbours."""
        return BoundForce(neighbours, self.strength(neighbours.d))

    def strength(self, d: Floats) -> Floats:
        """Factors (n,) of the force on bubbles with spacings d (n,)."""
        return self.k0 * (d if self.force == "scaled" else np.ones(len(d)))


@record
class BoundForce:
    """Force as a function of the positions, for fixed neighbours."""

    neighbours: Neighbours
    strength: Floats

    @cached_property
    def pull(self) -> Pull:
        """Forces between the pairs, as kernels take them."""
        return Pull(self.neighbours.pairs, self.neighbours.contact, self.strength, CUTOFF)

    def __call__(self, x: Floats) -> Floats:
        """Forces (n, 2) on bubbles at x (n, 2)."""
        return forces(x, self.pull)
