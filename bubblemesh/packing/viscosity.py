"""Viscosity c of the medium: it grows within a round and starts each round anew (section 2.2 of the paper)."""

from typing import Annotated, Protocol

import numpy as np
from annotated_types import Ge, Gt
from typing_extensions import Doc

from bubblemesh.arrays import Booleans, Floats
from bubblemesh.records import record


class Viscosity(Protocol):
    """The viscosity of a normal bubble as a function of time."""

    def __call__(self, step: int, round_number: int) -> float:
        """Viscosity in a step of a round, both counted from 0."""


@record
class Constant:
    """Viscosity that stays the same from the first step to the last."""

    c: Annotated[float, Gt(0), Doc("viscosity; 1.4 is a damping ratio of 0.7 for unit mass and strength")] = 1.4

    def __call__(self, step: int, round_number: int) -> float:
        return self.c


@record
class SawTooth:
    """Saw-tooth in time: c0 + c_in * step + c_out * round.

    The paper's figure 2 and section 4.2 name the two slopes the other way round; its results need this one.
    """

    c0: Annotated[float, Gt(0), Doc("saw-tooth: viscosity at the start")] = 1.0
    c_in: Annotated[float, Ge(0), Doc("saw-tooth: rise with each step of a round")] = 0.01
    c_out: Annotated[float, Ge(0), Doc("saw-tooth: rise with each round")] = 0.2

    def __call__(self, step: int, round_number: int) -> float:
        return self.c0 + self.c_in * step + self.c_out * round_number


@record
class NoOddBubbles:
    """Viscosity that is the same for normal and odd bubbles."""

    def active(self, before: int, after: int) -> bool:
        """False: no bubble ever stands out."""
        return False

    def __call__(self, c: float, odd: Booleans) -> float:
        """Viscosity ``c`` of all bubbles."""
        return c


@record
class OddBubbles:
    """A constant, small viscosity for the bubbles that the last population control touched."""

    c_odd: Annotated[float, Gt(0), Doc("viscosity of the odd bubbles")] = 1.0
    odd_start: Annotated[float, Ge(0), Doc("largest relative change of the population at which the scheme begins")] = (
        0.05
    )

    def active(self, before: int, after: int) -> bool:
        """Whether the change of population in a round is small enough."""
        return abs(before - after) <= self.odd_start * before

    def __call__(self, c: float, odd: Booleans) -> Floats | float:
        """Viscosity (n, 1) where odd bubbles (n,) stand out from normal ones; ``c`` for all if there are none."""
        return np.where(odd, self.c_odd, c)[:, None] if odd.any() else c
