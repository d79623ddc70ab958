"""The rounds of a packing in a metric, told as those of `packing.rounds`, on a single level."""

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.ellipses.annealing import annealed, relaxed
from bubblemesh.packing.ellipses.mending import mended
from bubblemesh.packing.ellipses.net import EllipseNet, connected, flipped_net
from bubblemesh.packing.ellipses.population import controlled
from bubblemesh.packing.ellipses.schemes import Schemes
from bubblemesh.packing.ellipses.smoothing import smoothed
from bubblemesh.packing.ellipses.trials import tried
from bubblemesh.packing.mending import Mending, NoMending
from bubblemesh.packing.methods import Method
from bubblemesh.packing.progress import TimeUp, Watch
from bubblemesh.packing.rounds import Round
from bubblemesh.packing.smoothing import Smoothing
from bubblemesh.records import record
from bubblemesh.spacing.metric.metric import MetricSpacing

LAST_PASSES = 2  # of the smoothing, after trials
# Shares of the packing that are done then.
SETTLED, ANNEALED, SETTLED_AGAIN, SMOOTHED, TRIED = 0.25, 0.45, 0.55, 0.65, 0.95


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
    run = LevelRun(domain, spacing, schemes, random, progress)
    number = 0
    try:
        progress.tell(0.0)
        number += yield from run.settle(1, SETTLED, opening=True)
        run.anneal()
        number += yield from run.settle(number + 1, SETTLED_AGAIN)
        yield run.finish(number + 1)
    except TimeUp as reason:
        # Between two looks at the metric ellipses keep that of where they were.
        net = progress.ellipses.net
        net = flipped_net(net, net.bubbles, net.triangles, spacing).net
        yield Round(number + 1, len(net.bubbles), 0, net, np.zeros(0), 0, str(reason))


@dataclass
class Progress:
    """Share of the work that is done, for a watch; holds the ellipses so far, in case the watch ends the packing."""

    ellipses: EllipseNet
    watch: Watch

    def tell(self, share: float) -> None:
        """Tell what share is done; TimeUp if the watch says so."""
        self.watch(share)

    def tell_between(self, begin: float, end: float, part: float) -> None:
        """Tell what part is done of the work from one share to another."""
        self.tell(begin + part * (end - begin))


@record
class LevelRun:
    """The rounds on one level, and what stays the same through them; the progress holds the ellipses."""

    domain: Domain
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
            progress.tell_between(SETTLED, ANNEALED, share)

    def finish(self, number: int) -> Round:
        """Finish the packing by passes of smoothing, with mending between the first and trials before the last ones.

        Of few passes all come after the trials; without any there are no trials either.
        """
        smoothing, mending = self.schemes.smoothing, self.schemes.mending
        before = len(self.progress.ellipses.tensors)
        if isinstance(smoothing, Smoothing) and smoothing.passes > 0:
            last = min(smoothing.passes, LAST_PASSES)
            self.smooth(smoothing.passes - last, smoothing, mending, (SETTLED_AGAIN, SMOOTHED))
            if isinstance(mending, Mending):
                self.attempt(smoothing, mending, (SMOOTHED, TRIED))
            self.smooth(last, smoothing, NoMending(), (TRIED, 1.0))
        return Round(number, before, 0, self.progress.ellipses.net, np.zeros(0), 0, "the metric is packed")

    def smooth(
        self, passes: int, smoothing: Smoothing, mending: NoMending | Mending, shares: tuple[float, float]
    ) -> None:
        """Passes of smoothing; between them bubbles leave, as often as there are attempts at most."""
        progress = self.progress
        for done in range(passes):
            if isinstance(mending, Mending) and 0 < done <= mending.attempts:
                progress.ellipses = mended(progress.ellipses, self.spacing, smoothing, mending)
            progress.ellipses = smoothed(progress.ellipses, self.domain, self.spacing, smoothing)
            progress.tell_between(*shares, (done + 1) / passes)

    def attempt(self, smoothing: Smoothing, mending: Mending, shares: tuple[float, float]) -> None:
        """Try other neighbours around bad triangles."""
        progress, tell = self.progress, partial(self.progress.tell_between, *shares)
        progress.ellipses = tried(progress.ellipses, self.spacing, smoothing, mending, self.random, tell)
