"""The rounds of a packing: bubbles move, and their number is controlled, until the method's termination says stop."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from bubblemesh.arrays import Booleans, Floats
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.levels import refined
from bubblemesh.packing.methods import Method
from bubblemesh.packing.net import Net, connect, connect_inside
from bubblemesh.packing.progress import CONNECTING, SMOOTHING, Progress, Stage, TimeUp, Watch, stages_of
from bubblemesh.packing.relaxation import Dynamics, Relaxed
from bubblemesh.spacing.spacing import Spacing


@dataclass(frozen=True)
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


def rounds(
    start: Bubbles, domain: Domain, levels: Sequence[Spacing], method: Method, watch: Watch = lambda share: None
) -> Iterator[Round]:
    """Rounds of the method on each level; after the last change of population the packing is finished.

    The bubbles of the ``start`` are placed by the first of the levels' spacings, which go from the coarsest to the one
    asked for. If the watch raises `TimeUp`, the bubbles are refined to the last spacing without more ado, and a last
    round tells so.
    """
    random = method.perturbation.generator()
    net, number, level = connect(method.perturbation(start, levels[0], random), domain), 0, 0
    stages = stages_of(method, len(levels), len(start))
    progress = Progress(stages, watch, net)
    try:
        for stage in stages:
            if stage.level > level:
                level = stage.level
                progress.net = net = connect(refined(net, domain, levels[level]), domain)
            progress.begin(stage)
            for done in LevelRun(domain, levels[level], method, random, progress).rounds(net, stage, number + 1):
                number, net = done.number, done.net
                yield done
    except TimeUp as reason:
        yield _cut_short(progress.net, domain, levels[level + 1 :], number + 1, str(reason))


def _cut_short(net: Net, domain: Domain, levels: Sequence[Spacing], number: int, reason: str) -> Round:
    """A round that does no more than to refine the bubbles to the last spacing, level by level."""
    before = len(net.bubbles)
    for spacing in levels:
        net = connect(refined(net, domain, spacing), domain)
    return Round(number, before, max(len(net.bubbles) - before, 0), net, np.zeros(0), 0, reason)


@dataclass(frozen=True)
class LevelRun:
    """The rounds on one level, and what stays the same through them."""

    domain: Domain
    spacing: Spacing
    method: Method
    random: np.random.Generator
    progress: Progress

    def rounds(self, net: Net, stage: Stage, first: int) -> Iterator[Round]:
        """Rounds of a stage, numbered from ``first``."""
        method, domain, spacing = self.method, self.domain, self.spacing
        counts: list[tuple[int, int]] = []
        odd, reason = False, None
        while reason is None:
            number, before = len(counts), len(net.bubbles)
            # 1. The bubbles move; in the round that anneals they are displaced before, again and again.
            steps = method.termination.steps(stage.opening and number == 0)
            if stage.annealing and number == 0:
                coarse = not stage.finishing
                relaxed = method.annealing(net, domain, spacing, self.random, self.relax, coarse)
            else:
                relaxed = self.relax(net, steps, number, odd)
            # 2. They are triangulated where they are now, with the spacing there.
            net = connect_inside(relaxed.bubbles, domain, spacing, net)
            # 3. Where they are too many some are deleted, and gaps are filled.
            change = method.population(net, domain, spacing, self.random)
            self.progress.net = net = connect(change.bubbles, domain, net, change.triangles)
            # 4. The change of their number tells whether to stop, and whether the odd ones get their own viscosity.
            counts.append((before, len(change.bubbles)))
            reason = method.termination(counts)
            odd = method.odd.active(*counts[-1])
            # 5. At the end of the packing they relax once more, or are smoothed.
            more = 0
            if reason is not None and stage.finishing:
                net, more, last = self.finish(net, steps, number, odd)
                relaxed = relaxed.followed_by(last)
            inserted = relaxed.added + change.inserted + more
            told = reason if stage.finishing else None
            yield Round(first + number, before, inserted, net, relaxed.speeds, relaxed.evaluations, told)

    def relax(self, net: Net, steps: int, number: int = 0, odd: bool = False) -> Relaxed:
        """Steps of a round; if ``odd``, the bubbles that were touched have a viscosity of their own."""
        method, progress = self.method, self.progress
        progress.add(CONNECTING * len(net.bubbles))

        def damping(step: int, touched: Booleans) -> Floats | float:
            progress.add(len(touched))
            c = method.viscosity(step, number)
            return method.odd(c, touched) if odd else c

        dynamics = Dynamics(method.force, method.motion, damping)
        return method.relaxation(net, self.domain, self.spacing, dynamics, steps)

    def finish(self, net: Net, steps: int, number: int, odd: bool) -> tuple[Net, int, Relaxed]:
        """Finish the packing; the net, the number of new bubbles, and the last relaxations as one.

        A relaxation is repeated while bubbles are lost at the boundary. Between the passes of the smoothing the
        population is controlled, and after them the worst triangles are mended.
        """
        method, domain, spacing = self.method, self.domain, self.spacing
        total, inserted = Relaxed.none(net.bubbles), 0
        for _ in range(method.smoothing.last_relaxations):
            relaxed = self.relax(net, steps, number, odd)
            total, net = total.followed_by(relaxed), connect(relaxed.bubbles, domain, net)
            if relaxed.lost == 0:
                break
        for smoothed in range(method.smoothing.passes):
            if smoothed:
                change = method.population(net, domain, spacing, self.random)
                if change.deleted + change.inserted:
                    net = connect_inside(change.bubbles, domain, spacing, net, change.triangles)
                    inserted += change.inserted
            self.progress.net = net = method.smoothing(net, domain, spacing)
            self.progress.add(SMOOTHING * len(net.bubbles))
        return method.mending(net, domain, spacing, method.smoothing, self.random), inserted, total
