"""The rounds of a packing in a metric, told as those of `packing.rounds`: on levels of doubled aspect."""

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.ellipses.annealing import annealed, relaxed
from bubblemesh.packing.ellipses.net import EllipseNet, connected
from bubblemesh.packing.ellipses.population import controlled
from bubblemesh.packing.ellipses.schemes import Schemes
from bubblemesh.packing.ellipses.smoothing import shaped, smoothed
from bubblemesh.packing.methods import Method
from bubblemesh.packing.placement.diffusion import boundary_bubbles, near_facets
from bubblemesh.packing.progress import TimeUp, Watch
from bubblemesh.packing.rounds import Round
from bubblemesh.packing.smoothing import Smoothing
from bubblemesh.spacing.metric.metric import MetricSpacing

CLEAR = 0.05  # of the size of circles of their area: ellipses nearer to a new boundary edge are left out
CUT_SHORT = 3  # controls of the population on each level that there is no time for
SETTLED, ANNEALED = 0.2, 0.7  # shares of a level that are done then


def rounds_in_metric(
    start: Bubbles, domain: Domain, levels: Sequence[MetricSpacing], method: Method, watch: Watch = lambda share: None
) -> Iterator[Round]:
    """Rounds of the method on each level; after the last change of population the packing is finished.

    The bubbles of the ``start`` are placed by the first of the levels, which go from the mildest metric to the one
    asked for. If the watch raises `TimeUp`, the population is brought to the last metric without more ado, and a last
    round tells so.
    """
    schemes = Schemes.of(method)
    random = schemes.perturbation.generator()
    number, finest = 0, len(levels) - 1
    ellipses = connected(schemes.perturbation(start, levels[0], random), domain, levels[0])
    progress = Progress(ellipses, watch, len(levels))
    try:
        for level, spacing in enumerate(levels):
            progress.begin(level)
            run = LevelRun(domain, spacing, schemes, random, progress)
            if level:
                run.refine()
            number += yield from run.settle(number + 1, SETTLED, opening=level == 0)
            run.anneal(finest=level == finest)
            number += yield from run.settle(number + 1, ANNEALED)
        yield run.finish(number + 1)
    except TimeUp as reason:
        yield _cut_short(progress, domain, levels, schemes, number + 1, str(reason))


def _cut_short(
    progress: "Progress", domain: Domain, levels: Sequence[MetricSpacing], schemes: Schemes, number: int, reason: str
) -> Round:
    """A round that does no more than to bring the population to the last metric, level by level."""
    progress.watch, before, inserted = _unwatched, len(progress.ellipses.tensors), 0
    random = schemes.perturbation.generator()
    for spacing in levels[progress.level + 1 :]:
        run = LevelRun(domain, spacing, schemes, random, progress)
        run.refine()
        inserted += sum(run.control() for _ in range(CUT_SHORT))
    return Round(number, before, inserted, progress.ellipses.net, np.zeros(0), 0, reason)


def _unwatched(share: float) -> None:
    """Let the time pass."""


@dataclass
class Progress:
    """Count of the work done, for a watch; holds the ellipses so far, in case the watch ends the packing."""

    ellipses: EllipseNet
    watch: Watch
    levels: int
    level: int = 0

    def begin(self, level: int) -> None:
        """Begin a level."""
        self.level = level
        self.tell(0.0)

    def tell(self, share: float) -> None:
        """Tell what share of the level is done; TimeUp if the watch says so. Each level takes as long as all before."""
        done = 2.0 ** (self.level + 1 - self.levels)
        before = done / 2 if self.level else 0.0
        self.watch(before + share * (done - before))


@dataclass(frozen=True)
class LevelRun:
    """The rounds on one level, and what stays the same through them; the progress holds the ellipses."""

    domain: Domain
    spacing: MetricSpacing
    schemes: Schemes
    random: np.random.Generator
    progress: Progress

    def refine(self) -> None:
        """Go on from the ellipses of a milder level: the boundary is spaced anew, and too near to it there are none."""
        bubbles = self.progress.ellipses.net.bubbles
        x, shell = bubbles.x[bubbles.interior], boundary_bubbles(self.domain, self.spacing)
        d = self.spacing(x)
        x = x[near_facets(shell, self.domain)(x, d) > CLEAR * d]
        self.progress.ellipses = connected(shell.append(x, self.spacing(x)), self.domain, self.spacing)

    def settle(self, first: int, share: float, opening: bool = False) -> Generator[Round, None, int]:
        """Rounds, numbered from ``first``, of motion and population control until the termination says stop.

        By then the ``share`` of the level is done.
        """
        schemes, progress = self.schemes, self.progress
        counts: list[tuple[int, int]] = []
        reason = None
        while reason is None:
            before = len(progress.ellipses.tensors)
            steps = schemes.termination.steps(opening and not counts)
            speeds = self.relax(steps)
            inserted = self.control()
            counts.append((before, len(progress.ellipses.tensors)))
            reason = schemes.termination(counts)
            progress.tell(share)
            yield Round(first + len(counts) - 1, before, inserted, progress.ellipses.net, speeds, before * steps)
        return len(counts)

    def relax(self, steps: int) -> Floats:
        """Steps of motion; the mean speeds (steps,)."""
        x, speeds = relaxed(self.progress.ellipses, self.schemes, steps)
        self.progress.ellipses = self.progress.ellipses.moved(x, self.spacing)
        return speeds

    def control(self) -> int:
        """Control the population; the number of new bubbles."""
        change = controlled(self.progress.ellipses, self.spacing, self.schemes.population)
        self.progress.ellipses = change.net
        return change.inserted

    def anneal(self, finest: bool) -> None:
        """Displace bubbles where the order is broken, again and again, with a short relaxation after each."""
        progress = self.progress
        for share, ellipses in annealed(progress.ellipses, self.spacing, self.schemes, self.random, finest):
            progress.ellipses = ellipses
            progress.tell(SETTLED + share * (ANNEALED - SETTLED))

    def finish(self, number: int) -> Round:
        """Finish the packing by passes of smoothing: with population control in between, then with flips by shape."""
        progress, smoothing = self.progress, self.schemes.smoothing
        before, inserted = len(progress.ellipses.tensors), 0
        if isinstance(smoothing, Smoothing):
            for done in range(smoothing.passes):
                if done:
                    inserted += self.control()
                progress.ellipses = smoothed(progress.ellipses, self.spacing, smoothing)
            progress.tell((1 + ANNEALED) / 2)
            for _ in range(smoothing.passes):
                progress.ellipses = shaped(progress.ellipses, self.spacing, smoothing)
        return Round(number, before, inserted, progress.ellipses.net, np.zeros(0), 0, "the last metric is packed")
