"""The interbubble force, equation (2.1) of the paper."""

from functools import cached_property
from typing import Annotated, Literal

import numpy as np
from annotated_types import Gt, Le
from typing_extensions import Doc

from bubblemesh.arrays import Floats, Integers
from bubblemesh.kernels.library import library
from bubblemesh.kernels.relaxing import CUTOFF, Pull, forces, pair_force
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
    def ends(self) -> Integers:
        """First and second members (2, m) of the pairs."""
        return np.ascontiguousarray(self.neighbours.pairs.T)

    @cached_property
    def pull(self) -> Pull:
        """Forces between the pairs, as compiled kernels take them."""
        return Pull(self.neighbours.pairs, self.neighbours.contact, self.strength, CUTOFF)

    def __call__(self, x: Floats) -> Floats:
        """Forces (n, 2) on bubbles at x (n, 2)."""
        compiled = library()
        return self._in_numpy(x) if compiled is None else forces(compiled, x, self.pull)

    def _in_numpy(self, x: Floats) -> Floats:
        i, j = self.ends
        # Column by column, which NumPy does several times faster than row by row.
        dx, dy = (column.take(i) - column.take(j) for column in np.ascontiguousarray(x.T))
        distance = np.sqrt(dx * dx + dy * dy)
        contact = self.neighbours.contact
        # Coinciding bubbles have no direction to part in: they stay until population control removes one.
        size = pair_force(distance / contact) / np.maximum(distance, 1e-12 * contact)
        columns = [self.strength * self._summed(size * part) for part in (dx, dy)]
        return np.column_stack(columns)

    def _summed(self, along: Floats) -> Floats:
        """Sums (n,), bubble by bubble, of the pairs' forces (m,) along an axis."""
        i, j = self.ends
        n = len(self.strength)
        return np.asarray(np.bincount(i, along, minlength=n) - np.bincount(j, along, minlength=n), float)
