"""Progress of a packing, as the share that is done: for those who show progress, and for limits of time."""

from collections.abc import Callable, Sequence
from contextlib import suppress

from bubblemesh.packing.annealing import Rank
from bubblemesh.records import record

CONNECTING = 8.0  # cost in terms of a step of relaxation, as measured
TOLD_AFTER = 2e3  # steps of a bubble, about a tenth of a millisecond: a watch takes time, too

Watch = Callable[[float], None]  # called again and again with the share of the packing that is done; may raise TimeUp


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


class Progress:
    """Count of the work done, for a watch."""

    def __init__(self, stages: Sequence[Stage], watch: Watch) -> None:
        self._total = sum(stage.work for stage in stages)
        self._done, self._end, self._untold, self._watch = 0.0, 0.0, TOLD_AFTER, watch

    def begin(self, stage: Stage) -> None:
        """Begin the next stage: what was expected before it is done."""
        self._done, self._end = self._end, self._end + stage.work
        self.add(0.0)

    def finish(self) -> None:
        """Report that all is done, whatever was expected; a TimeUp of the watch comes too late and is ignored."""
        with suppress(TimeUp):
            self._watch(1.0)

    def add(self, work: float) -> None:
        """Count so many steps of a bubble; TimeUp if the watch raises it."""
        self._done = min(self._done + work, self._end)
        self._untold += work
        if self._untold >= TOLD_AFTER:
            self._untold = 0.0
            self._watch(self._done / self._total)
