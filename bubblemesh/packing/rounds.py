"""The rounds of a packing: bubbles move, and their number is controlled, until the method's termination says stop."""

from collections.abc import Generator, Iterator, Sequence
from typing import TypeGuard

import numpy as np

from bubblemesh.arrays import Booleans, Floats
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.annealing import Rank
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.levels import refined
from bubblemesh.packing.methods import Method
from bubblemesh.packing.net import Net, connect, connect_inside
from bubblemesh.packing.progress import CONNECTING, SMOOTHING, Progress, Stage, TimeUp, Watch, stages_of
from bubblemesh.packing.relaxation import Dynamics, Relaxed
from bubblemesh.records import record
from bubblemesh.spacing.metric.metric import MetricSpacing
from bubblemesh.spacing.spacing import Spacing


@record
class Round:
    """Record of a round."""

    number: int  # counted from 1
    before: int  # number of bubbles
    inserted: int
    net: Net  # after the round
    speeds: Floats  # (iterations,): mean speed after each step of the motion
    evaluations: int  # of the force on a bubble
    stop_reason: str | None = None  # why no round follows

    @property
    def iterations(self) -> int:
        """Number of steps of the motion."""
        return len(self.speeds)

    @property
    def deleted(self) -> int:
        """Number of bubbles that were deleted or lost."""
        return self.before + self.inserted - len(self.bubbles)

    @property
    def bubbles(self) -> Bubbles:
        """The bubbles after the round."""
        return self.net.bubbles


def all_rounds(
    start: Bubbles, domain: Domain, levels: Sequence[Spacing], method: Method, watch: Watch = lambda share: None
) -> Iterator[Round]:
    """Rounds of the method on each level, in the metric of the levels if they have one."""
    if not is_in_metric(levels):
        return rounds(start, domain, levels, method, watch)
    # Imported here since few cases have a metric.
    from bubblemesh.packing.ellipses.rounds import rounds_in_metric

    return rounds_in_metric(start, domain, levels, method, watch)


def is_in_metric(levels: Sequence[Spacing]) -> TypeGuard[Sequence[MetricSpacing]]:
    """Whether levels have spacings in a metric: all of them have, or none."""
    return isinstance(levels[-1], MetricSpacing)


def rounds(
    start: Bubbles, domain: Domain, levels: Sequence[Spacing], method: Method, watch: Watch = lambda share: None
) -> Iterator[Round]:
    """Rounds of the method on each level; after the last change of population the packing is finished.

    The bubbles of the ``start`` are placed by the first of the levels' spacings, which go from the coarsest to the one
    asked for. If the watch raises `TimeUp`, the bubbles are refined to the last spacing without more ado, and a last
    round tells so.
    """
    random = method.perturbation.generator()
    number = level = 0
    stages = stages_of(method, len(levels), len(start))
    progress = Progress(stages, watch, connect(method.perturbation(start, levels[0], random), domain))
    try:
        for stage in stages:
            if stage.rank.coarser > level:
                level = stage.rank.coarser
                progress.net = refined(progress.net, domain, levels[level])
            progress.begin(stage)
            number += yield from LevelRun(domain, levels[level], method, random, progress).rounds(stage, number + 1)
    except TimeUp as reason:
        yield _cut_short(progress.net, domain, levels[level + 1 :], number + 1, str(reason))


def _cut_short(net: Net, domain: Domain, levels: Sequence[Spacing], number: int, reason: str) -> Round:
    """A round that does no more than to refine the bubbles to the last spacing, level by level."""
    before = len(net.bubbles)
    for spacing in levels:
        net = refined(net, domain, spacing)
    return Round(number, before, max(len(net.bubbles) - before, 0), net, np.zeros(0), 0, reason)


@record
class LevelRun:
    """The rounds on one level, and what stays the same through them.

    The progress alone holds the net, which takes most of the memory: no copy of what it was stays behind.
    """

    domain: Domain
    spacing: Spacing
    method: Method
    random: np.random.Generator
    progress: Progress

    def rounds(self, stage: Stage, first: int) -> Generator[Round, None, int]:
        """Rounds of a stage, numbered from ``first``; in the end, how many."""
        method, progress = self.method, self.progress
        counts: list[tuple[int, int]] = []
        odd, reason = False, None
        while reason is None:
            number, before = len(counts), len(progress.net.bubbles)
            # 1. The bubbles move; in the round that anneals they are displaced before, again and again.
            steps = method.termination.steps(stage.opening and number == 0)
            if stage.annealing and number == 0:
                relaxed = self.anneal(stage.rank)
            else:
                relaxed = self.relax(progress.net, steps, number, odd)
            # 2. They are triangulated where they are now, with the spacing there.
            progress.net = connect_inside(relaxed.bubbles, self.domain, self.spacing, progress.net)
            # 3. Where they are too many some are deleted, and gaps are filled.
            inserted = self.control()
            # 4. The change of their number tells whether to stop, and whether the odd ones get their own viscosity.
            counts.append((before, len(progress.net.bubbles)))
            reason = method.termination(counts)
            odd = method.odd.active(*counts[-1])
            # 5. At the end of the packing they relax once more, or are smoothed.
            more = 0
            if reason is not None and stage.finishing:
                more, last = self.finish(steps, number, odd)
                relaxed = relaxed.followed_by(last)
            inserted += relaxed.added + more
            told = reason if stage.finishing else None
            yield Round(first + number, before, inserted, progress.net, relaxed.speeds, relaxed.evaluations, told)
        return len(counts)

    def relax(self, net: Net, steps: int, number: int = 0, odd: bool = False) -> Relaxed:
        """Steps of a round; if ``odd``, the bubbles that were touched have a viscosity of their own."""
        return self.method.relaxation(net, self.domain, self.spacing, self.dynamics(number, odd), steps)

    def dynamics(self, number: int = 0, odd: bool = False) -> Dynamics:
        """The motion in a round; whatever asks for its damping counts as progress."""
        method, progress = self.method, self.progress

        def damping(some: range, touched: Booleans) -> list[Floats | float]:
            connecting = CONNECTING if some.start == 0 else 0.0
            progress.add((connecting + len(some)) * len(touched))
            viscosities = [method.viscosity(step, number) for step in some]
            return [method.odd(c, touched) if odd else c for c in viscosities]

        return Dynamics(method.force, method.motion, damping)

    def anneal(self, rank: Rank) -> Relaxed:
        """Annealing on a level of that rank; kernels go through its cycles where they can."""
        method, net = self.method, self.progress.net
        steps = method.annealing.shake_steps
        dynamics = self.dynamics() if method.relaxation.is_compiled(method.motion, steps) else None
        return method.annealing(net, self.domain, self.spacing, self.random, self.relax, rank, dynamics)

    def control(self) -> int:
        """Control the population; the number of new bubbles."""
        progress = self.progress
        change = self.method.population(progress.net, self.domain, self.spacing, self.random)
        progress.net = connect(change.bubbles, self.domain, progress.net, change.triangles)
        return change.inserted

    def control_again(self) -> int:
        """Control the population between passes of the smoothing; the number of new bubbles."""
        progress = self.progress
        change = self.method.population(progress.net, self.domain, self.spacing, self.random)
        if change.deleted + change.inserted:
            progress.net = connect_inside(change.bubbles, self.domain, self.spacing, progress.net, change.triangles)
        return change.inserted

    def finish(self, steps: int, number: int, odd: bool) -> tuple[int, Relaxed]:
        """Finish the packing; the number of new bubbles, and the last relaxations as one.

        A relaxation is repeated while bubbles are lost at the boundary. Between the passes of the smoothing the
        population is controlled, and after them the worst triangles are mended.
        """
        method, domain, spacing, progress = self.method, self.domain, self.spacing, self.progress
        total, inserted = Relaxed.none(progress.net.bubbles), 0
        for _ in range(method.smoothing.last_relaxations):
            relaxed = self.relax(progress.net, steps, number, odd)
            total, progress.net = total.followed_by(relaxed), connect(relaxed.bubbles, domain, progress.net)
            if relaxed.lost == 0:
                break
        for smoothed in range(method.smoothing.passes):
            if smoothed:
                inserted += self.control_again()
            progress.net = method.smoothing(progress.net, domain, spacing)
            progress.add(SMOOTHING * len(progress.net.bubbles))
        progress.net = method.mending(progress.net, domain, spacing, method.smoothing, self.random)
        return inserted, total
