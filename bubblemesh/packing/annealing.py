"""Annealing: random displacements where the order is broken, each followed by a short relaxation."""

import math
from collections.abc import Callable
from dataclasses import field
from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np
from annotated_types import Ge, Gt, Le
from typing_extensions import Doc

from bubblemesh.arrays import Booleans, Floats
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.disorder import disorder_marked
from bubblemesh.kernels.library import library
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.net import Net, connect_inside
from bubblemesh.packing.placement import displaced
from bubblemesh.packing.relaxation import Relaxed
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing

CYCLES = {"fast": 20, "normal": 100, "best": 800}
FEWEST_CYCLES = {"fast": 2, "normal": 10, "best": 40}  # on the largest levels
TIMES = {"fast": (1, 2, 4, 4, 8), "normal": (1, 2, 4, 4, 8), "best": (1, 2, 2, 2, 4)}  # by the number of finer levels
ANNEALED_NEXT_TO_FINEST = {"fast": 2000, "normal": 2000, "best": math.inf}  # the most bubbles
REGULAR_VALENCE = 6

Effort = Annotated[
    Literal["fast", "normal", "best"],
    Doc("20, 100 or 800 cycles of shaking, 2 to 8 times that on coarse levels; with `best` four times the mending"),
]
Relax = Callable[[Net, int], Relaxed]  # so many steps from a net
Calm = Callable[[Bubbles], Booleans]  # which bubbles (n,) are left alone


class Rank(NamedTuple):
    """Where a level stands among those of a packing."""

    coarser: int = 0  # number of levels before it
    finer: int = 0  # number of levels after it


ONLY = Rank()


@record
class NoAnnealing:
    """No annealing."""

    shake_steps: ClassVar[int] = 0

    def __call__(
        self,
        net: Net,
        domain: Domain,
        spacing: Spacing,
        random: np.random.Generator,
        relax: Relax,
        rank: Rank = ONLY,
    ) -> Relaxed:
        """The bubbles as they are."""
        return Relaxed.none(net.bubbles)

    def cycles(self, bubbles: int, rank: Rank = ONLY) -> int:
        """Zero, whatever the number of bubbles."""
        return 0

    def sparing(self, calm: Calm) -> "NoAnnealing":
        """No annealing either: there is none to spare bubbles from."""
        return self


@record
class Annealing:
    """Displacement, again and again and less and less, of bubbles without six neighbours and of those next to them.

    On the coarse levels grain boundaries heal, and what is left of them is in the right places.
    """

    effort: Effort = "normal"
    amplitude: Annotated[float, Gt(0), Le(0.5), Doc("standard deviation of the first displacement, in spacings")] = 0.18
    amplitude_at_boundary: Annotated[float, Ge(0), Le(1), Doc("what of it applies beside the boundary")] = 0.5
    shake_steps: Annotated[int, Gt(0), Doc("steps of relaxation in each cycle")] = 8
    fully_shaken: Annotated[
        int, Gt(0), Doc("levels with more bubbles get fewer cycles in proportion, at least 2, 10 or 40")
    ] = 4000

    def __call__(
        self,
        net: Net,
        domain: Domain,
        spacing: Spacing,
        random: np.random.Generator,
        relax: Relax,
        rank: Rank = ONLY,
    ) -> Relaxed:
        """The bubbles after all cycles of a level, each a displacement and a relaxation."""
        parts = [Relaxed.none(net.bubbles)]
        cycles = self.cycles(len(net.bubbles), rank)
        for cycle in range(cycles):
            displaced = self._displaced(net, 1 - cycle / cycles, random)
            net = connect_inside(displaced, domain, spacing, net)
            relaxed = relax(net, self.shake_steps)
            parts.append(relaxed)
            # The edges from before the relaxation still tell where the order is broken.
            net = connect_inside(relaxed.bubbles, domain, spacing) if relaxed.lost else net.of(relaxed.bubbles)
        return Relaxed.one_of(parts)

    def cycles(self, bubbles: int, rank: Rank = ONLY) -> int:
        """Number of cycles on a level of so many bubbles.

        A coarse level gets more of them than an only one: it is small beside the finest, and all others take over its
        order. But on the finest of several levels, and on a large one next to it, annealing breaks more of the order
        that was taken over than it lessens the strain.
        """
        most_next = ANNEALED_NEXT_TO_FINEST[self.effort]
        if rank.coarser and (rank.finer == 0 or (rank.finer == 1 and bubbles > most_next)):
            return 0
        most, fewest, times = CYCLES[self.effort], FEWEST_CYCLES[self.effort], TIMES[self.effort]
        share = min(1, self.fully_shaken / bubbles)
        return math.ceil(times[min(rank.finer, len(times) - 1)] * max(most * share, fewest))

    def sparing(self, calm: Calm) -> "Annealing":
        """Annealing of all but calm bubbles, which are left alone."""
        return SparingAnnealing(**vars(self), calm=calm)

    def _displaced(self, net: Net, share: float, random: np.random.Generator) -> Bubbles:
        """The bubbles after a displacement, whose amplitude is ``share`` times that of the first one."""
        amplitudes = share * self.amplitude, share * (self.amplitude_at_boundary * self.amplitude)
        compiled, count = library(), net.bubbles.boundary_count
        if compiled is None:
            amplitude = disorder_marked_in_numpy(net, *amplitudes)
        else:
            amplitude = disorder_marked(compiled, len(net.bubbles), net.edges, count, *amplitudes)
        which = np.flatnonzero(amplitude)
        return displaced(net.bubbles, which, amplitude[which], random)


@record
class SparingAnnealing(Annealing):
    """Annealing that leaves ``calm`` bubbles alone."""

    calm: Calm = field(kw_only=True)

    def _displaced(self, net: Net, share: float, random: np.random.Generator) -> Bubbles:
        displaced = super()._displaced(net, share, random)
        return displaced.moved(np.where(self.calm(net.bubbles)[:, None], net.bubbles.x, displaced.x))


def disorder_marked_in_numpy(net: Net, inside: float, beside: float) -> Floats:
    """Values (n,) of a net's bubbles as of `disorder_marked`, made in NumPy."""
    on_boundary = np.arange(len(net.bubbles)) < net.bubbles.boundary_count
    values = np.where(net.dilated(on_boundary), beside, inside)
    values[on_boundary | ~net.dilated(net.valence != REGULAR_VALENCE)] = 0
    return values
