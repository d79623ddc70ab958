"""Packing of circles: what each round does to bubbles whose spacing is the same in all directions."""

from dataclasses import dataclass
from typing import ClassVar

from bubblemesh.arrays import Booleans, Floats
from bubblemesh.packing.annealing import CircleAnnealing
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.forces import VanDerWaals
from bubblemesh.packing.levels import finer
from bubblemesh.packing.mending import Mending, NoMending
from bubblemesh.packing.method import Method
from bubblemesh.packing.motion import Motion
from bubblemesh.packing.net import Net, connect, connect_inside
from bubblemesh.packing.pinch_outs import with_opposite_nodes
from bubblemesh.packing.population import Change, Population
from bubblemesh.packing.progress import CONNECTING, Stage
from bubblemesh.packing.relaxation import CircleRelaxation, Dynamics, Relaxed, Relaxer
from bubblemesh.packing.setting import Setting
from bubblemesh.packing.smoothing import NoSmoothing, Smoothing
from bubblemesh.packing.termination import Counts
from bubblemesh.packing.viscosity import Viscosity
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing

LAST_RELAXATIONS = 4  # without smoothing, at most
IN_ORDER = 0.02  # share of disordered bubbles up to which a start needs no more steps than any other round

# Costs in terms of a step of relaxation, as measured.
SMOOTHING = 60.0  # a pass
MENDING, MENDING_AT_LEAST = 25.0, 4e5


@record
class CircleMethod(Method):
    """A method that packs circles."""

    in_metric: ClassVar[bool] = False

    relaxation: CircleRelaxation
    force: VanDerWaals
    motion: Motion
    population: Population
    annealing: CircleAnnealing
    smoothing: NoSmoothing | Smoothing
    mending: NoMending | Mending
    viscosity: Viscosity

    def packing(self, start: Bubbles, spacing: Spacing, setting: Setting) -> "CirclePacking":
        return CirclePacking(connect(start, setting.domain), spacing, self, setting)

    def finishing_work(self, bubbles: int) -> float:
        mended = self.smoothing.shape_steps > 0 and self.mending.attempts > 0
        mending = MENDING * bubbles + MENDING_AT_LEAST if mended else 0.0
        return self.smoothing.passes * SMOOTHING * bubbles + mending


@dataclass
class CirclePacking:
    """Bubbles on the level at hand; it alone holds the net, which takes most of the memory."""

    net: Net
    spacing: Spacing
    method: CircleMethod
    setting: Setting

    def to_level(self, spacing: Spacing) -> None:
        """Make the bubbles those of the next level, and go on with its spacing."""
        domain = self.setting.domain
        self.spacing, self.net = spacing, finer(self.net, domain, spacing)
        start = self.method.placement.again(self.net.bubbles, domain, spacing)
        if start is not self.net.bubbles:
            self.net = connect(start, domain)

    def move(self, stage: Stage, counts: Counts) -> Relaxed:
        """Relax the bubbles, or anneal them in the round that does, and triangulate them where they are then."""
        number = len(counts)
        if stage.annealing and number == 0:
            net, relaxed = self.method.annealing(
                self.net, self._relaxer(number, counts), self.setting.random, stage.rank
            )
        else:
            net, relaxed = self.net, self._relaxer(number, counts)(self.net, self._steps(stage, number))
        self.net = connect_inside(relaxed.bubbles, self.setting.domain, self.spacing, net)
        return relaxed

    def control(self) -> int:
        """Control the population; the number of new bubbles."""
        change = self._change()
        if change.deleted + change.inserted:
            self.net = connect(change.bubbles, self.setting.domain, self.net, change.triangles)
        else:
            self.net = self.net.of(change.bubbles)
        return change.inserted

    def stop_reason(self, counts: Counts) -> str | None:
        """Why the rounds of a stage end with the last one; None if they go on."""
        return self.method.termination(counts)

    def finish(self, stage: Stage, counts: Counts) -> tuple[int, Relaxed]:
        """Finish the packing; the number of new bubbles, and the last relaxations as one.

        Between the passes of the smoothing the population is controlled, and after them the worst triangles are
        smoothed and mended.
        """
        method, (domain, random, progress) = self.method, self.setting
        inserted, relaxed = 0, Relaxed.none(self.net.bubbles)
        if method.smoothing.relaxing:
            number = len(counts) - 1  # it belongs to the last round
            relaxed = self._relaxed_again(self._relaxer(number, counts), self._steps(stage, number))
        for smoothed in range(method.smoothing.passes):
            if smoothed:
                inserted += self._controlled_again()
            self.net = method.smoothing(self.net, domain, self.spacing)
            progress.add(SMOOTHING * len(self.net.bubbles))
        # Before mending too, so that this is for what is left of them.
        self.net = method.smoothing.of_worst(self.net, domain, self.spacing)
        self.net = method.mending(self.net, domain, self.spacing, method.smoothing, random)
        self.net = method.smoothing.of_worst(self.net, domain, self.spacing)
        self.net = with_opposite_nodes(self.net, domain, self.spacing, method.smoothing)
        return inserted, relaxed

    def _relaxed_again(self, relaxer: Relaxer, steps: int) -> Relaxed:
        """The last relaxations as one: they are repeated while bubbles are lost at the boundary."""
        total = Relaxed.none(self.net.bubbles)
        for _ in range(LAST_RELAXATIONS):
            relaxed = relaxer(self.net, steps)
            total, self.net = total.followed_by(relaxed), connect(relaxed.bubbles, relaxer.domain, self.net)
            if relaxed.lost == 0:
                break
        self.net = connect_inside(self.net.bubbles, relaxer.domain, self.spacing, self.net)
        return total

    def end(self) -> None:
        """Nothing is left to do when the time is up."""

    def _steps(self, stage: Stage, number: int) -> int:
        opening = stage.opening and number == 0 and self.net.disorder > IN_ORDER
        return self.method.termination.steps(opening)

    def _relaxer(self, number: int, counts: Counts) -> Relaxer:
        """Relaxation in a round, counted from 0, whose steps count as progress.

        Where the last round changed the population by little, bubbles that it touched may have their own viscosity.
        """
        method, (domain, _, progress) = self.method, self.setting
        odd = len(counts) > 0 and method.odd.active(*counts[-1])

        def viscosities(some: range, touched: Booleans) -> list[Floats | float]:
            of_normal = [method.viscosity(step, number) for step in some]
            return [method.odd(c, touched) if odd else c for c in of_normal]

        def count(some: range, bubbles: int) -> None:
            connecting = CONNECTING if some.start == 0 else 0.0
            progress.add((connecting + len(some)) * bubbles)

        dynamics = Dynamics(method.force, method.motion, viscosities, count)
        return Relaxer(method.relaxation, domain, self.spacing, dynamics)

    def _controlled_again(self) -> int:
        """Control the population between passes of the smoothing; the number of new bubbles.

        No relaxation comes before the next pass: bubbles outside are left out at once.
        """
        change = self._change()
        if change.deleted + change.inserted:
            domain = self.setting.domain
            self.net = connect_inside(change.bubbles, domain, self.spacing, self.net, change.triangles)
        return change.inserted

    def _change(self) -> Change:
        """The change of the population, as the method controls it."""
        method, (domain, random, _) = self.method, self.setting
        return method.population(self.net, domain, self.spacing, random)
