"""Force between bubbles, and steps of their motion, whose twin is in `packing.relaxation`."""

from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.kernels.library import Argument, call, or_numpy

CUTOFF = 1.5  # distance in units of l0 beyond which bubbles do not act on each other


class Pull(NamedTuple):
    """Forces between pairs of bubbles."""

    pairs: Integers  # (m, 2)
    contact: Floats  # (m,): distance at which a pair is at rest
    strength: Floats  # (n,): factor of the force on each bubble
    cutoff: float  # in units of the contact distance: pairs farther apart have no force


class Steps(NamedTuple):
    """Symplectic Euler steps with implicit damping."""

    fixed: int  # so many of the first bubbles stay where they are
    most: Floats  # (n,): longest move of each bubble in a step
    dt: float
    c: Floats  # (steps,): viscosities


def pair_force(ratio: Floats) -> Floats:
    """Force f(q) = 5/4 q^3 - 19/8 q^2 + 9/8, equation (2.1), between bubbles at distance q = l / l0, for k0 = 1.

    It repels below q = 1 and attracts up to 1.5, beyond which it is zero.
    """
    force = ((1.25 * ratio - 2.375) * ratio) * ratio + 1.125
    return np.where(ratio < CUTOFF, force, 0.0)


def forces_in_numpy(x: Floats, pull: Pull) -> Floats:
    """The same as `forces`, in NumPy."""
    i, j = np.ascontiguousarray(pull.pairs.T)
    # Column by column, which NumPy does several times faster than row by row.
    dx, dy = (column.take(i) - column.take(j) for column in np.ascontiguousarray(x.T))
    distance = np.sqrt(dx * dx + dy * dy)
    # Coinciding bubbles have no direction to part in: they stay until population control removes one.
    size = pair_force(distance / pull.contact) / np.maximum(distance, 1e-12 * pull.contact)
    n = len(pull.strength)
    totals = (np.bincount(i, size * part, n) - np.bincount(j, size * part, n) for part in (dx, dy))
    return np.column_stack([pull.strength * total for total in totals])


@or_numpy(forces_in_numpy)
def forces(x: Floats, pull: Pull) -> Floats:
    """Forces (n, 2) on bubbles at x (n, 2)."""
    result = np.empty_like(x, order="C")
    call("pair_forces", **_pulling(pull), x=np.ascontiguousarray(x), force=result)
    return result


def relaxed(x: Floats, pull: Pull, steps: Steps) -> tuple[Floats, Floats]:
    """Places (n, 2) of bubbles, and their mean speeds (steps,), after steps from rest at x (n, 2)."""
    places, speeds = np.array(x, order="C"), np.empty(len(steps.c))
    call(
        "relax",
        **_pulling(pull),
        x=places,
        fixed=steps.fixed,
        most=steps.most,
        dt=steps.dt,
        steps=len(steps.c),
        c=steps.c,
        speeds=speeds,
    )
    return places, speeds


def _pulling(pull: Pull) -> dict[str, Argument]:
    """Arguments of a kernel that stand for the forces."""
    return {
        "n": len(pull.strength),
        "m": len(pull.pairs),
        "ends": np.ascontiguousarray(pull.pairs),
        "contact": pull.contact,
        "strength": pull.strength,
        "cutoff": pull.cutoff,
    }
