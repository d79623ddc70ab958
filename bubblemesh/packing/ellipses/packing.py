"""Packing of ellipses: what each round does to bubbles in a metric."""

from dataclasses import dataclass
from typing import TypeGuard

import numpy as np

from bubblemesh.packing.annealing import Rank
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.ellipses.annealing import annealed, cycles_of, relaxed
from bubblemesh.packing.ellipses.mending import mended
from bubblemesh.packing.ellipses.net import EllipseNet, connected, flipped_net
from bubblemesh.packing.ellipses.population import controlled
from bubblemesh.packing.ellipses.schemes import Schemes
from bubblemesh.packing.ellipses.smoothing import costs, smoothed
from bubblemesh.packing.ellipses.trials import Tried, tried
from bubblemesh.packing.mending import Mending, NoMending
from bubblemesh.packing.methods import Method
from bubblemesh.packing.net import Net
from bubblemesh.packing.progress import CONNECTING, Stage
from bubblemesh.packing.relaxation import Relaxed
from bubblemesh.packing.setting import Setting
from bubblemesh.packing.smoothing import NoSmoothing, Smoothing
from bubblemesh.spacing.metric.metric import MetricSpacing
from bubblemesh.spacing.spacing import Spacing

LACKING = 0.05  # of all bubbles: if so many are missing the population is not settled
LAST_PASSES = 2  # of the smoothing, after trials
MOST_COST = 1.0  # of a triangle, where a packing is judged as a whole
# Costs in terms of a step of relaxation, as measured.
SMOOTHING = 200.0  # a pass
TRIAL = 75.0  # an attempt


@dataclass
class EllipsePacking:
    """Ellipses on the only level."""

    ellipses: EllipseNet
    spacing: MetricSpacing
    schemes: Schemes
    setting: Setting
    missing: int = 0  # bubbles that the area lacked after the last population control

    @classmethod
    def of(cls, start: Bubbles, spacing: Spacing, setting: Setting) -> "EllipsePacking":
        """The bubbles of a start, connected in the metric of the spacing."""
        assert isinstance(spacing, MetricSpacing)
        return cls(connected(start, setting.domain, spacing), spacing, Schemes.of(setting.method), setting)

    @staticmethod
    def cycles(method: Method, bubbles: int, rank: Rank) -> int:
        """Expected number of cycles of annealing."""
        return cycles_of(Schemes.of(method).annealing, bubbles)

    @staticmethod
    def finishing_work(method: Method, bubbles: int) -> float:
        """Expected cost of the end of a packing, in steps of relaxation of one bubble."""
        if not _smooths(method.smoothing):
            return 0.0
        return (method.smoothing.passes * SMOOTHING + method.mending.attempts * TRIAL) * bubbles

    @property
    def net(self) -> Net:
        """The bubbles so far, connected."""
        return self.ellipses.net

    def refine(self, spacing: Spacing) -> None:
        """Take the metric of another spacing, where the ellipses are."""
        assert isinstance(spacing, MetricSpacing)
        net, self.spacing = self.ellipses.net, spacing
        self.ellipses = flipped_net(net, net.bubbles, net.triangles, spacing)

    def move(self, stage: Stage, number: int, odd: bool) -> Relaxed:
        """Relax the ellipses; in the round that anneals they are displaced before, again and again.

        What is told of the motion is the relaxation.
        """
        if stage.annealing and number == 0:
            self._anneal()
        before, steps = len(self.ellipses.tensors), self.schemes.termination.steps(stage.opening and number == 0)
        x, speeds = relaxed(self.ellipses, self.schemes, steps)
        self.ellipses = self.ellipses.moved(x, self.spacing)
        self._count(CONNECTING + steps)
        return Relaxed(self.net.bubbles, 0, 0, speeds, before * steps)

    def control(self) -> int:
        """Control the population; the number of new bubbles."""
        change = controlled(self.ellipses, self.spacing, self.schemes.population)
        self.ellipses, self.missing = change.net, change.missing
        return change.inserted

    @property
    def lacks_many(self) -> bool:
        """Whether so many bubbles are missing yet that rounds go on even if few come in each.

        The start misses layers far thinner than its cells, and bubbles come by halving what edges are there.
        """
        return self.missing > LACKING * len(self.ellipses.tensors)

    def finish(self, stage: Stage, number: int, odd: bool) -> tuple[int, Relaxed]:
        """Finish the packing by passes of smoothing, with mending between the first and trials before the last ones.

        Of few passes all come after the trials; without any there are no trials either.
        """
        smoothing, mending, inserted = self.schemes.smoothing, self.schemes.mending, 0
        if _smooths(smoothing):
            last = min(smoothing.passes, LAST_PASSES)
            self._smooth(smoothing.passes - last, smoothing, mending)
            if isinstance(mending, Mending):
                inserted = self._attempt(smoothing, mending)
            self._smooth(last, smoothing, NoMending())
        return inserted, Relaxed.none(self.net.bubbles)

    def end(self) -> None:
        """Look at the metric once more: between two looks ellipses keep that of where they were."""
        self.refine(self.spacing)

    def _anneal(self) -> None:
        """Displace bubbles where the order is broken, again and again, with a short relaxation after each.

        In a metric that jumps from bubble to bubble this may pile them up: then they stay where they were.
        """
        cost, before = CONNECTING + self.schemes.annealing.shake_steps, self.ellipses
        try:
            for ellipses, cycles in annealed(self.ellipses, self.spacing, self.schemes, self.setting.random):
                self.ellipses = ellipses
                self._count(cycles * cost)
        finally:  # also if the time is up
            if _disorder(self.net, self.spacing) > _disorder(before.net, self.spacing):
                self.ellipses = before

    def _smooth(self, passes: int, smoothing: Smoothing, mending: NoMending | Mending) -> None:
        """Passes of smoothing; between them bubbles leave, as often as there are attempts at most."""
        for done in range(passes):
            if isinstance(mending, Mending) and 0 < done <= mending.attempts:
                self.ellipses = mended(self.ellipses, self.spacing, smoothing, mending)
            self.ellipses = smoothed(self.ellipses, self.setting.domain, self.spacing, smoothing)
            self._count(SMOOTHING)

    def _attempt(self, smoothing: Smoothing, mending: Mending) -> int:
        """Try other neighbours around bad triangles; the number of new bubbles."""
        given, left = (self.ellipses, self.spacing, smoothing, mending, self.setting.random), mending.attempts
        last: Tried | None = None
        try:
            for state in tried(*given):
                last, left = state, left - 1
                self._count(TRIAL)
            self._count(left * TRIAL)  # no triangles were left for these
        finally:  # also if the time is up
            if last is not None:
                self.ellipses = last.within(self.net, self.spacing)
        return 0 if last is None else last.came

    def _count(self, cost: float) -> None:
        """Count what has been done with each bubble as progress."""
        self.setting.progress.add(cost * len(self.ellipses.tensors))


def _smooths(smoothing: NoSmoothing | Smoothing) -> TypeGuard[Smoothing]:
    """Whether a packing ends with passes of smoothing: without any there are no trials either."""
    return isinstance(smoothing, Smoothing) and smoothing.passes > 0


def _disorder(net: Net, spacing: MetricSpacing) -> float:
    """Mean cost of the triangles, each of `MOST_COST` at most: single bad ones are mended in the end.

    It goes by the default weights, since a case may smooth by others, or not at all.
    """
    each = costs(net.bubbles.x, net.triangles, spacing, Smoothing())
    return float(np.minimum(each, MOST_COST).mean())
