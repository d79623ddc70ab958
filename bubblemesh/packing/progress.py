"""Progress of a packing, as the share that is done: for those who show progress, and for limits of time."""

from collections.abc import Callable, Sequence

from bubblemesh.packing.annealing import Rank
from bubblemesh.packing.methods import Method
from bubblemesh.records import record

CONNECTING = 8.0  # cost in terms of a step of relaxation, as measured
TOLD_AFTER = 2e3  # steps of a bubble, about a tenth of a millisecond: a watch takes time, too

Watch = Callable[[float], None]  # is told, again and again, what share of the packing is done; may raise TimeUp


class TimeUp(Exception):  # noqa: N818 - it ends the packing, but is no error
    """The packing has to end with the bubbles as they are."""


@record
class Stage:
    """A part of a packing: the rounds on a level until its termination says stop."""

    rank: Rank  # of its level
    annealing: bool  # the stage begins by annealing
    finishing: bool  # the packing is finished at its end
    work: float  # expected cost, in steps of relaxation of one bubble

    @property
    def opening(self) -> bool:
        """Whether the stage is the first of all."""
        return self.rank.coarser == 0 and not self.annealing


def stages_of(
    method: Method, levels: int, bubbles: int, finishing_work: Callable[[Method, int], float]
) -> tuple[Stage, ...]:
    """Stages of a method on its levels; the first has so many ``bubbles``, and each next one four times more.

    Each level settles; those that have cycles of annealing go through these then, and settle again. What it costs to
    finish so many bubbles is given by a function, in steps of relaxation of one bubble.
    """
    stages = []
    for level in range(levels):
        rank, count = Rank(coarser=level, finer=levels - 1 - level), bubbles * 4**level
        finest = rank.finer == 0
        work = count * (CONNECTING + method.termination.expected_steps(level == 0))
        cycles = method.annealing.cycles(count, rank)
        if cycles:
            stages.append(Stage(rank, annealing=False, finishing=False, work=work))
            work += count * cycles * (CONNECTING + method.annealing.shake_steps)
        if finest:
            work += finishing_work(method, count)
        stages.append(Stage(rank, annealing=cycles > 0, finishing=finest, work=work))
    return tuple(stages)


class Progress:
    """Count of the work done, for a watch."""

    def __init__(self, stages: Sequence[Stage], watch: Watch) -> None:
        self._total = sum(stage.work for stage in stages)
        self._done, self._end, self._untold, self._watch = 0.0, 0.0, TOLD_AFTER, watch

    def begin(self, stage: Stage) -> None:
        """Begin the next stage: what was expected before it is done."""
        self._done, self._end = self._end, self._end + stage.work
        self.add(0.0)

    def add(self, work: float) -> None:
        """Count so many steps of a bubble; TimeUp if the watch does, when it is told."""
        self._done = min(self._done + work, self._end)
        self._untold += work
        if self._untold >= TOLD_AFTER:
            self._untold = 0.0
            self._watch(self._done / self._total)
