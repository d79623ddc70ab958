"""What packing methods have in common, those of circles and those of ellipses."""

from dataclasses import replace
from typing import ClassVar, Protocol, Self

from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.annealing import Annealing, Rank
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.levels import Levels, SingleLevel
from bubblemesh.packing.net import Net
from bubblemesh.packing.placement import Perturbation, Placement
from bubblemesh.packing.placement.warm_start import PreviousNodes, WarmStart
from bubblemesh.packing.progress import CONNECTING, Stage
from bubblemesh.packing.relaxation import Relaxation, Relaxed
from bubblemesh.packing.setting import Setting
from bubblemesh.packing.termination import Counts, Termination
from bubblemesh.packing.viscosity import NoOddBubbles, OddBubbles
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing


class Packing(Protocol):
    """Bubbles on the level at hand, circles or ellipses, and what each round does to them."""

    @property
    def net(self) -> Net:
        """The bubbles so far, connected."""

    def to_level(self, spacing: Spacing) -> None:
        """Go on with the spacing of the next level."""

    def move(self, stage: Stage, counts: Counts) -> Relaxed:
        """Move them in the next round of a stage, in its first one by annealing if the stage has it."""

    def control(self) -> int:
        """Control the population; the number of new bubbles."""

    def stop_reason(self, counts: Counts) -> str | None:
        """Why the rounds of a stage end with the last one, by the method's termination; None if they go on."""

    def finish(self, stage: Stage, counts: Counts) -> tuple[int, Relaxed]:
        """Finish the packing in its last round; the number of new bubbles, and the motion."""

    def end(self) -> None:
        """Make a result of what there is, when the time is up."""


@record
class Method:
    """A packing method: one scheme, with its parameters, for each task.

    Those of further tasks depend on what is packed: `CircleMethod` and `EllipseMethod` have them.
    """

    in_metric: ClassVar[bool]  # whether it packs ellipses

    levels: Levels
    placement: Placement
    perturbation: Perturbation
    relaxation: Relaxation
    annealing: Annealing
    odd: NoOddBubbles | OddBubbles
    termination: Termination

    def packing(self, start: Bubbles, spacing: Spacing, setting: Setting) -> Packing:
        """The bubbles of a start, connected."""
        raise NotImplementedError

    def finishing_work(self, bubbles: int) -> float:
        """Expected cost of the end of a packing of so many bubbles, in steps of relaxation of one bubble."""
        raise NotImplementedError

    @property
    def coarsens(self) -> bool:
        """Whether coarser levels may come before the finest one."""
        return self.levels.several and not self.placement.in_order

    def warm_started(self, previous: PreviousNodes) -> Self:
        """The method with a start from the nodes of a previous mesh, on the finest level only."""
        annealing = self.annealing.sparing(previous.calm)
        return replace(self, levels=SingleLevel(), placement=WarmStart(previous), annealing=annealing)

    def started(
        self, domain: Domain, spacing: Spacing, expected_nodes: float, max_nodes: int
    ) -> tuple[tuple[Spacing, ...], Bubbles]:
        """The spacings of the levels, the coarsest first, and the bubbles of that one before any motion.

        LimitError if there would be many more than ``max_nodes`` of them.
        """
        placement = self.placement.fitted(domain, spacing, expected_nodes)
        levels = (spacing,) if placement.in_order else self.levels(domain, spacing, expected_nodes)
        if len(levels) > 1:
            placement = self.placement.fitted(domain, levels[0], halvings=len(levels) - 1)
        return levels, placement(domain, levels[0], max_nodes)

    def stages(self, levels: int, bubbles: int) -> tuple[Stage, ...]:
        """Stages on so many levels; the first has so many ``bubbles``, and each next one four times more.

        Each level settles; those that have cycles of annealing go through these then, and settle again.
        """
        stages = []
        for level in range(levels):
            rank, count = Rank(coarser=level, finer=levels - 1 - level), bubbles * 4**level
            finest = rank.finer == 0
            work = count * (CONNECTING + self.termination.expected_steps(level == 0))
            cycles = self.annealing.cycles(count, rank)
            if cycles:
                stages.append(Stage(rank, annealing=False, finishing=False, work=work))
                work += count * cycles * (CONNECTING + self.annealing.shake_steps)
            if finest:
                work += self.finishing_work(count)
            stages.append(Stage(rank, annealing=cycles > 0, finishing=finest, work=work))
        return tuple(stages)
