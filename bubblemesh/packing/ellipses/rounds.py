"""The rounds of a packing in a metric, told as those of `packing.rounds`, on a single level."""

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.ellipses.annealing import annealed, relaxed
from bubblemesh.packing.ellipses.mending import mended
from bubblemesh.packing.ellipses.net import EllipseNet, connected
from bubblemesh.packing.ellipses.population import controlled
from bubblemesh.packing.ellipses.schemes import Schemes
from bubblemesh.packing.ellipses.smoothing import smoothed
from bubblemesh.packing.ellipses.trials import tried
from bubblemesh.packing.mending import Mending
from bubblemesh.packing.methods import Method
from bubblemesh.packing.progress import TimeUp, Watch
from bubblemesh.packing.rounds import Round
from bubblemesh.packing.smoothing import Smoothing
from bubblemesh.records import record
from bubblemesh.spacing.metric.metric import MetricSpacing

LAST_PASSES = 2  # of the smoothing, after trials
SETTLED, ANNEALED, SETTLED_AGAIN, TRIED = 0.25, 0.45, 0.55, 0.95  # shares of the packing that are done then


def rounds_in_metric(
    start: Bubbles, domain: Domain, levels: Sequence[MetricSpacing], method: Method, watch: Watch = lambda share: None
) -> Iterator[Round]:
    """Rounds of the method on the only level; after the last change of population the packing is finished.

    If the watch raises `TimeUp`, a last round tells so, with the bubbles as they are.
    """
    schemes = Schemes.of(method)
    random = schemes.perturbation.generator()
    (spacing,) = levels
    progress = Progress(connected(schemes.perturbation(start, spacing, random), domain, spacing), watch)
    run = LevelRun(spacing, schemes, random, progress)
    number = 0
    try:
        progress.tell(0.0)
        number += yield from run.settle(1, SETTLED, opening=True)
        run.anneal()
        number += yield from run.settle(number + 1, SETTLED_AGAIN)
        yield run.finish(number + 1)
    except TimeUp as reason:
        net = progress.ellipses.net
        yield Round(number + 1, len(net.bubbles), 0, net, np.zeros(0), 0, str(reason))


@dataclass
class Progress:
    """Share of the work that is done, for a watch; holds the ellipses so far, in case the watch ends the packing."""

    ellipses: EllipseNet
    watch: Watch

    def tell(self, share: float) -> None:
        """Tell what share is done; TimeUp if the watch says so."""
        self.watch(share)


@record
class LevelRun:
    """The rounds on one level, and what stays the same through them; the progress holds the ellipses."""

    spacing: MetricSpacing
    schemes: Schemes
    random: np.random.Generator
    progress: Progress

    def settle(self, first: int, share: float, opening: bool = False) -> Generator[Round, None, int]:
        """Rounds, numbered from ``first``, of motion and population control until the termination says stop.

        By then the ``share`` of the packing is done.
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

    def anneal(self) -> None:
        """Displace bubbles where the order is broken, again and again, with a short relaxation after each."""
        progress = self.progress
        for share, ellipses in annealed(progress.ellipses, self.spacing, self.schemes, self.random):
            progress.ellipses = ellipses
            progress.tell(SETTLED + share * (ANNEALED - SETTLED))

    def finish(self, number: int) -> Round:
        """Finish the packing by passes of smoothing, with mending between them."""
        progress, smoothing, mending = self.progress, self.schemes.smoothing, self.schemes.mending
        before = len(progress.ellipses.tensors)
        if isinstance(smoothing, Smoothing):
            for done in range(smoothing.passes):
                if isinstance(mending, Mending) and mending.mend_attempts > 0:
                    self.mend(done, smoothing, mending)
                progress.ellipses = smoothed(progress.ellipses, self.spacing, smoothing)
        return Round(number, before, 0, progress.ellipses.net, np.zeros(0), 0, "the metric is packed")

    def mend(self, done: int, smoothing: Smoothing, mending: Mending) -> None:
        """Take bubbles away between the first passes of smoothing, of which so many are done; try before the last."""

        def tell(share: float) -> None:
            self.progress.tell(SETTLED_AGAIN + share * (TRIED - SETTLED_AGAIN))

        ellipses, given = self.progress.ellipses, (self.spacing, smoothing, mending)
        if 0 < done < smoothing.passes - LAST_PASSES:
            self.progress.ellipses = mended(ellipses, *given)
        elif done == smoothing.passes - LAST_PASSES:
            self.progress.ellipses = tried(ellipses, *given, self.random, tell)
