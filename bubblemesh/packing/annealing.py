"""Annealing: random displacements where the order is broken, each followed by a short relaxation."""

import math
from collections.abc import Callable
from dataclasses import field, replace
from typing import Annotated, ClassVar, Literal, NamedTuple, Protocol, Self

import numpy as np
from annotated_types import Ge, Gt, Le
from typing_extensions import Doc

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.kernels.annealing import Acting, Cycles, Links, annealed
from bubblemesh.kernels.library import or_numpy
from bubblemesh.kernels.relaxing import CUTOFF
from bubblemesh.meshes.quality import REGULAR_VALENCE
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.net import Net, connect_within
from bubblemesh.packing.relaxation import Relaxed, Relaxer, kernel_steps
from bubblemesh.records import record

CYCLES = {"fast": 20, "normal": 100, "best": 800}  # before `TIMES`
FEWEST_CYCLES = {"fast": 2, "normal": 20, "best": 40}  # on the largest levels, before `TIMES`
TIMES = {"fast": (1, 2, 4, 4, 8), "normal": (1.6, 2, 4, 4, 8), "best": (5, 5, 4, 4, 5)}  # by the finer levels
MORE_OF_FEW = {"fast": 1, "normal": 1.75, "best": 1}  # times as many on an only level of few bubbles
FEW = 2000  # bubbles, above which these are less in proportion
ANNEALED_NEXT_TO_FINEST = {"fast": 2000, "normal": 2000, "best": math.inf}  # the most bubbles
DISORDERED = 0.02  # share of the bubbles from which on all cycles are worth their time
LAST_SHARE = 0.5  # of the first displacement: by much less than that, defects do not move any more
SPACING_STAYS = 5  # cycles by the same spacings: bubbles do not go far in them
SEEDS = 2**63

Effort = Annotated[
    Literal["fast", "normal", "best"],
    Doc("20, 100 or 800 cycles of annealing, up to 8 times that by the level; with `best` four times the mending"),
]
Calm = Callable[[Bubbles], Booleans]  # which bubbles (n,) are left alone


class Rank(NamedTuple):
    """Where a level stands among those of a packing."""

    coarser: int = 0  # number of levels before it
    finer: int = 0  # number of levels after it


ONLY = Rank()


class Annealing(Protocol):
    """Cycles of displacement and relaxation, of circles or of ellipses."""

    @property
    def shake_steps(self) -> int:
        """Number of steps of relaxation in each cycle."""

    def cycles(self, bubbles: int, rank: Rank = ONLY) -> int:
        """Number of cycles on a level of so many bubbles."""

    def sparing(self, calm: Calm) -> "Annealing":
        """Annealing of all but calm bubbles, which are left alone."""

    def scaled(self, share: float) -> "Annealing":
        """Annealing of a share of a packing, with as many cycles as the whole would have."""

    def fast(self) -> "Annealing":
        """Annealing with the least effort."""


class CircleAnnealing(Annealing, Protocol):
    """Annealing of circles."""

    def __call__(self, net: Net, relaxer: Relaxer, random: np.random.Generator, rank: Rank) -> tuple[Net, Relaxed]:
        """Net and relaxation after all cycles of a level of that rank, whose bubbles the relaxer moves.

        The net has the bubbles where they are then, and triangles from which they have not gone far.
        """


@record
class NoCycles:
    """Zero cycles: no annealing, of circles or of ellipses."""

    shake_steps: ClassVar[int] = 0

    def cycles(self, bubbles: int, rank: Rank = ONLY) -> int:
        """Zero, whatever the number of bubbles."""
        return 0

    def sparing(self, calm: Calm) -> Self:
        """No annealing either: there is none to spare bubbles from."""
        return self

    def scaled(self, share: float) -> Self:
        """No annealing either."""
        return self

    def fast(self) -> Self:
        """No annealing either."""
        return self


@record
class NoAnnealing(NoCycles):
    """No annealing."""

    def __call__(self, net: Net, relaxer: Relaxer, random: np.random.Generator, rank: Rank) -> tuple[Net, Relaxed]:
        """The bubbles as they are."""
        return net, Relaxed.none(net.bubbles)


@record
class AnnealingCycles:
    """Parameters of annealing, of circles or of ellipses, and the number of its cycles."""

    effort: Effort = "normal"
    amplitude: Annotated[float, Gt(0), Le(0.5), Doc("standard deviation of the first displacement, in spacings")] = 0.16
    amplitude_at_boundary: Annotated[float, Ge(0), Le(1), Doc("what of it applies beside the boundary")] = 1.0
    shake_steps: Annotated[int, Gt(0), Le(1000), Doc("steps of relaxation in each cycle")] = 6
    fully_shaken: Annotated[
        int,
        Gt(0),
        Le(1_000_000_000),
        Doc("levels with more bubbles get fewer cycles in proportion, at least 2, 20 or 40"),
    ] = 4000

    def by_size(self, bubbles: int, worth: float = 1.0) -> float:
        """Number of cycles of so many bubbles, before the rank of their level counts.

        ``worth`` is the part of the fewest cycles of large levels that these need.
        """
        share = min(1, self.fully_shaken / bubbles)
        return max(CYCLES[self.effort] * share, FEWEST_CYCLES[self.effort] * worth)

    def scaled(self, share: float) -> Self:
        """Annealing of a share of a packing, with as many cycles as the whole would have."""
        return replace(self, fully_shaken=max(round(share * self.fully_shaken), 1))

    def fast(self) -> Self:
        """Annealing with the least effort."""
        return replace(self, effort="fast")


@record
class CyclicAnnealing(AnnealingCycles):
    """Displacement, again and again and less and less, of bubbles without six neighbours and of those next to them.

    On the coarse levels grain boundaries heal, and what is left of them is in the right places.
    """

    def __call__(self, net: Net, relaxer: Relaxer, random: np.random.Generator, rank: Rank) -> tuple[Net, Relaxed]:
        """Net and relaxation after all cycles of a level, each a displacement and a relaxation.

        The net has the bubbles where they are then, and triangles from which they have not gone far.
        """
        annealer = Annealer(relaxer, self.shake_steps)
        total, seed = self.cycles(len(net.bubbles), rank, net.disorder), int(random.integers(SEEDS))
        shares = 1 - (1 - LAST_SHARE) * np.arange(total) / total
        parts, done = [Relaxed.none(net.bubbles)], 0
        while done < total:
            if done:
                net = net.spaced_by(relaxer.spacing)
            some = slice(done, done + SPACING_STAYS)
            inside, calm = self.amplitude * shares[some], self._calm(net.bubbles)
            cycles = Cycles(seed, done, inside, self.amplitude_at_boundary * inside, calm)
            net, relaxed, count = annealer(net, cycles)
            parts.append(relaxed)
            done += count
        return net, Relaxed.one_of(parts)

    def cycles(self, bubbles: int, rank: Rank = ONLY, disorder: float = 1.0) -> int:
        """Number of cycles on a level of so many bubbles, of which a share is in ``disorder``.

        But with `best`, a coarse level gets more of them than an only one: it is small beside the finest, and all
        others take over its order. On the finest of several levels, and on a large one next to it, annealing breaks
        more of the order that was taken over than it lessens the strain. A large first level that is in order already
        gets fewer, and an only one of few bubbles, which takes little time, more.
        """
        most_next = ANNEALED_NEXT_TO_FINEST[self.effort]
        if rank.coarser and (rank.finer == 0 or (rank.finer == 1 and bubbles > most_next)):
            return 0
        times = TIMES[self.effort]
        worth = 1.0 if rank.coarser else min(disorder / DISORDERED, 1.0)
        most = MORE_OF_FEW[self.effort] if rank == ONLY else 1.0
        more = max(most * min(1.0, FEW / bubbles), 1.0)
        return math.ceil(more * times[min(rank.finer, len(times) - 1)] * self.by_size(bubbles, worth))

    def sparing(self, calm: Calm) -> "CyclicAnnealing":
        """Annealing of all but calm bubbles, which are left alone."""
        return SparingAnnealing(**vars(self), calm=calm)

    def _calm(self, bubbles: Bubbles) -> Booleans:
        """Bubbles (n,) that are not displaced, whatever their order."""
        return np.zeros(len(bubbles), bool)


@record
class SparingAnnealing(CyclicAnnealing):
    """Annealing that leaves ``calm`` bubbles alone."""

    calm: Calm = field(kw_only=True)

    def _calm(self, bubbles: Bubbles) -> Booleans:
        return self.calm(bubbles)


@record
class Annealer:
    """How bubbles of a level go through cycles of annealing."""

    relaxer: Relaxer
    steps: int  # of relaxation in each cycle

    def __call__(self, net: Net, cycles: Cycles) -> tuple[Net, Relaxed, int]:
        """Net and relaxation after so many of the cycles, by the spacings that its bubbles have.

        All cycles, or those until bubbles come or get lost: then others have their numbers.
        """
        parts, done, before, same = [Relaxed.none(net.bubbles)], 0, len(net.bubbles), True
        while done < len(cycles.inside) and same:
            net, relaxed, more = self._some(net, cycles.after(done))
            parts.append(relaxed)
            done, same = done + more, len(net.bubbles) == before and relaxed.added == relaxed.lost == 0
        return net, Relaxed.one_of(parts), done

    def _first(self, net: Net, cycles: Cycles) -> tuple[Net, Relaxed, int]:
        """Net and relaxation after the first of the cycles, and the number 1."""
        return *self._relaxed(_displaced(net, cycles), net), 1

    @or_numpy(_first)
    def _some(self, net: Net, cycles: Cycles) -> tuple[Net, Relaxed, int]:
        """Net and relaxation after the first cycles, and how many these are: those done at once, and one more."""
        bubbles, (force, motion, viscosities, progress) = net.bubbles, self.relaxer.dynamics
        some = range(self.steps)
        steps = kernel_steps(bubbles, motion, viscosities(some, bubbles.touched))
        renewed = self.steps > self.relaxer.relaxation.refresh
        # Bubbles outside have no triangle, and go when they are connected anew.
        if steps is None or renewed or (net.legal is None and (net.valence == 0).any()):
            return self._first(net, cycles)
        twins = None if net.legal is None else net.legal.twins
        links = Links(net.triangles, net.edges, twins, net.facets, net.start)
        acting = Acting(bubbles.d, force.strength(bubbles.d), CUTOFF)
        x, legal, connected_at, speeds = annealed(bubbles.x, links, acting, steps, cycles)
        progress(some, len(x) * len(speeds))
        moved = bubbles.moved(x)
        done = Relaxed(moved, 0, 0, speeds.ravel(), len(x) * speeds.size)
        if legal is not None:
            return net.by(legal, moved, connected_at), done, len(speeds)
        after, last = self._relaxed(moved, net)
        return after, done.followed_by(last), len(speeds) + 1

    def _relaxed(self, bubbles: Bubbles, before: Net) -> tuple[Net, Relaxed]:
        """Net and relaxation of bubbles that have been displaced from a net."""
        net = connect_within(bubbles, self.relaxer.domain, before)
        relaxed = self.relaxer(net, self.steps)
        if relaxed.added or relaxed.lost:
            return connect_within(relaxed.bubbles, self.relaxer.domain), relaxed
        # The edges from before the relaxation still show where the order is broken.
        return net.of(relaxed.bubbles), relaxed


def _displaced(net: Net, cycles: Cycles) -> Bubbles:
    """The bubbles of a net after the displacement of the first of the cycles."""
    amplitude = disorder_marked(net, float(cycles.inside[0]), float(cycles.beside[0]))
    which = np.flatnonzero((amplitude != 0) & ~cycles.calm)
    x, scale = net.bubbles.x.copy(), amplitude[which] * net.bubbles.d[which]
    x[which] = x[which] + scale[:, None] * deviations(cycles.seed, cycles.first, which)
    return net.bubbles.moved(x)


def deviations(seed: int, cycle: int, bubbles: Integers) -> Floats:
    """Random numbers (k, 2) of unit deviation, at most sqrt(6), for bubbles (k,) in a cycle of annealing.

    Each is the sum of two that are uniform, and each bubble has its own in each cycle: 64 bits of SplitMix64.

    References
    ----------
    G. L. Steele, D. Lea, C. H. Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014.
    """
    z = np.uint64(seed) + (np.uint64(cycle << 32) | bubbles.astype(np.uint64)) * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ z >> np.uint64(30)) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ z >> np.uint64(27)) * np.uint64(0x94D049BB133111EB)
    z = z ^ z >> np.uint64(31)
    parts = (z[:, None] >> 16 * np.arange(4, dtype=np.uint64) & np.uint64(0xFFFF)).astype(np.int64)
    return np.asarray((parts[:, ::2] + parts[:, 1::2] - 0xFFFF) * (math.sqrt(6) / 65536), np.float64)


def disorder_marked(net: Net, inside: float, beside: float) -> Floats:
    """Values (n,) of bubbles that do not have six neighbours, or are next to one; zero of all others.

    It is ``beside`` of those next to the boundary, whose bubbles have zero, and else ``inside``.
    """
    on_boundary = np.arange(len(net.bubbles)) < net.bubbles.boundary_count
    values = np.where(net.dilated(on_boundary), beside, inside)
    values[on_boundary | ~net.dilated(net.valence != REGULAR_VALENCE)] = 0
    return values
