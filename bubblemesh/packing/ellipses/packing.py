"""Packing of ellipses: what each round does to bubbles in a metric."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from bubblemesh.kernels.ellipse_annealing import Relaxing
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.ellipses.annealing import EllipseAnnealing, EllipseRelaxation, NoEllipseAnnealing
from bubblemesh.packing.ellipses.mending import EllipseMending, NoEllipseMending
from bubblemesh.packing.ellipses.net import EllipseNet, connected, flipped_net
from bubblemesh.packing.ellipses.population import EllipseDefects
from bubblemesh.packing.ellipses.smoothing import EllipseSmoothing, NoEllipseSmoothing, costs
from bubblemesh.packing.method import Method
from bubblemesh.packing.motion import SemiImplicitEuler
from bubblemesh.packing.net import Net
from bubblemesh.packing.progress import CONNECTING, Stage
from bubblemesh.packing.relaxation import Relaxed
from bubblemesh.packing.setting import Setting
from bubblemesh.packing.termination import Counts
from bubblemesh.packing.viscosity import Constant
from bubblemesh.records import record
from bubblemesh.spacing.metric.metric import MetricSpacing
from bubblemesh.spacing.spacing import Spacing

LACKING = 0.05  # of all bubbles: if so many are missing the population is not settled
MOST_ROUNDS = 60  # if so many are missing
LAST_PASSES = 2  # of the smoothing, after trials
MOST_COST = 1.0  # of a triangle, where a packing is judged as a whole
# Costs in terms of a step of relaxation, as measured.
SMOOTHING = 200.0  # a pass
TRIAL = 35.0  # an attempt


@record
class EllipseMethod(Method):
    """A method that packs ellipses, in a metric."""

    in_metric: ClassVar[bool] = True

    relaxation: EllipseRelaxation
    motion: SemiImplicitEuler
    population: EllipseDefects
    annealing: NoEllipseAnnealing | EllipseAnnealing
    smoothing: NoEllipseSmoothing | EllipseSmoothing
    mending: NoEllipseMending | EllipseMending
    viscosity: Constant

    def packing(self, start: Bubbles, spacing: Spacing, setting: Setting) -> "EllipsePacking":
        assert isinstance(spacing, MetricSpacing)
        return EllipsePacking(connected(start, setting.domain, spacing), spacing, self, setting)

    def finishing_work(self, bubbles: int) -> float:
        trials = self.mending.attempts * TRIAL if self.smoothing.passes else 0.0
        return (self.smoothing.passes * SMOOTHING + trials) * bubbles


@dataclass
class EllipsePacking:
    """Ellipses on the only level."""

    ellipses: EllipseNet
    spacing: MetricSpacing
    method: EllipseMethod
    setting: Setting
    missing: int = 0  # bubbles that the area lacked after the last population control

    @property
    def net(self) -> Net:
        """The bubbles so far, connected."""
        return self.ellipses.net

    def to_level(self, spacing: Spacing) -> None:
        """Take the metric of another spacing, where the ellipses are."""
        assert isinstance(spacing, MetricSpacing)
        net, self.spacing = self.ellipses.net, spacing
        self.ellipses = flipped_net(net, net.bubbles, net.triangles, spacing)

    def move(self, stage: Stage, counts: Counts) -> Relaxed:
        """Relax the ellipses; in the round that anneals they are displaced before, again and again.

        The motion that is returned is that relaxation, without the annealing.
        """
        first = len(counts) == 0
        if stage.annealing and first:
            self._anneal()
        before, steps = len(self.ellipses.tensors), self.method.termination.steps(stage.opening and first)
        x, speeds = self.method.relaxation(self.ellipses, self._relaxing(steps))
        self.ellipses = self.ellipses.moved(x, self.spacing)
        self._count(CONNECTING + steps)
        return Relaxed(self.net.bubbles, 0, 0, speeds, before * steps)

    def control(self) -> int:
        """Control the population; the number of new bubbles."""
        change = self.method.population(self.ellipses, self.spacing)
        self.ellipses, self.missing = change.net, change.missing
        return change.inserted

    def stop_reason(self, counts: Counts) -> str | None:
        """Why the rounds of a stage end with the last one; None if they go on, also while many bubbles are missing.

        The start misses layers far thinner than its cells, and bubbles come by halving what edges are there.
        """
        lacks_many = self.missing > LACKING * len(self.ellipses.tensors)
        return None if lacks_many and len(counts) < MOST_ROUNDS else self.method.termination(counts)

    def finish(self, stage: Stage, counts: Counts) -> tuple[int, Relaxed]:
        """Finish the packing by passes of smoothing, with mending between the first and trials before the last ones.

        Of few passes all come after the trials; without any there are no trials either.
        """
        passes, inserted = self.method.smoothing.passes, 0
        if passes > 0:
            last = min(passes, LAST_PASSES)
            self._smooth(passes - last, self.method.mending)
            inserted = self._attempt()
            self._smooth(last, NoEllipseMending(), last=True)
        return inserted, Relaxed.none(self.net.bubbles)

    def end(self) -> None:
        """Look at the metric once more: between two looks ellipses keep that of where they were."""
        self.to_level(self.spacing)

    def _anneal(self) -> None:
        """Displace bubbles where the order is broken, again and again, with a short relaxation after each.

        In a metric that jumps from bubble to bubble this may pile them up: then they stay where they were.
        """
        annealing, relaxation, before = self.method.annealing, self.method.relaxation, self.ellipses
        cost, relaxing = CONNECTING + annealing.shake_steps, self._relaxing(annealing.shake_steps)
        try:
            for ellipses, cycles in annealing(before, self.spacing, relaxation, relaxing, self.setting.random):
                self.ellipses = ellipses
                self._count(cycles * cost)
        finally:  # also if the time is up
            if _disorder(self.net, self.spacing) > _disorder(before.net, self.spacing):
                self.ellipses = before

    def _smooth(self, passes: int, mending: NoEllipseMending | EllipseMending, *, last: bool = False) -> None:
        """Passes of smoothing; between them bubbles leave, as often as there are attempts at most.

        The ``last`` ones are for the shapes of the worst triangles.
        """
        for done in range(passes):
            if 0 < done <= mending.attempts:
                self.ellipses = mending.fewer(self.ellipses, self.spacing, self.method.smoothing)
            self.ellipses = self.method.smoothing(self.ellipses, self.setting.domain, self.spacing, last)
            self._count(SMOOTHING)

    def _attempt(self) -> int:
        """Try other neighbours around bad triangles; the number of new bubbles."""
        mending, smoothing, random = self.method.mending, self.method.smoothing, self.setting.random
        left, last = mending.attempts, None
        try:
            for state in mending.tried(self.ellipses, self.spacing, smoothing, random):
                last, left = state, left - 1
                self._count(TRIAL)
            self._count(left * TRIAL)  # no triangles were left for these
        finally:  # also if the time is up
            if last is not None:
                self.ellipses = last.within(self.net, self.spacing)
        return 0 if last is None else last.came

    def _relaxing(self, steps: int) -> Relaxing:
        """So many steps of the motion, as kernels take them."""
        method = self.method
        return Relaxing(self.net.bubbles.boundary_count, steps, float(method.motion.dt), method.viscosity(0, 0))

    def _count(self, cost: float) -> None:
        """Count what has been done with each bubble as progress."""
        self.setting.progress.add(cost * len(self.ellipses.tensors))


def _disorder(net: Net, spacing: MetricSpacing) -> float:
    """Mean cost of the triangles, each of `MOST_COST` at most: single bad ones are mended in the end.

    It goes by the default weights, since a case may smooth by others, or not at all.
    """
    each = costs(net.bubbles.x, net.triangles, spacing, EllipseSmoothing())
    return float(np.minimum(each, MOST_COST).mean())
