"""How much of a packing is done: for those who show progress, and for limits of time."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import accumulate

from bubblemesh.packing.methods import Method
from bubblemesh.packing.net import Net

# Costs in terms of a step of relaxation, as measured.
CONNECTING = 8.0
POLISHING = 60.0  # a pass
MENDING, MENDING_AT_LEAST = 25.0, 4e5

Watch = Callable[[float], None]  # is told, again and again, what share of the packing is done; may raise TimeUp


class TimeUp(Exception):  # noqa: N818 - it ends the packing, but is no error
    """The packing has to end with the bubbles as they are."""


@dataclass(frozen=True)
class Stage:
    """A part of a packing.

    Attributes
    ----------
    level : int
    shaking : bool
        Whether it begins by shaking.
    closing : bool
        Whether the packing is closed at its end.
    work : float
        Expected cost, in terms of a step of relaxation of one bubble.
    """

    level: int
    shaking: bool
    closing: bool
    work: float


def stages_of(method: Method, levels: int, bubbles: int) -> tuple[Stage, ...]:
    """What a method does on its levels; the first has so many ``bubbles``, and each next one four times more."""
    stages = []
    for level in range(levels):
        finest, count = level == levels - 1, bubbles * 4**level
        settling = count * (CONNECTING + method.termination.expected_steps(level == 0))
        closing = _closing(method, count) if finest else 0.0
        if method.shaking is None or (finest and level > 0):
            stages.append(Stage(level, False, finest, settling + closing))
            continue
        shaking = count * method.shaking.cycles(count) * (CONNECTING + method.shaking.shake_steps)
        stages.append(Stage(level, False, False, settling))
        stages.append(Stage(level, True, finest, shaking + settling + closing))
    return tuple(stages)


def _closing(method: Method, bubbles: int) -> float:
    if method.polish is None:
        return 0.0
    mending = 0.0 if method.mending is None else MENDING * bubbles + MENDING_AT_LEAST
    return method.polish.passes * POLISHING * bubbles + mending


class Progress:
    """Keeps count of the work done, for a watch.

    Parameters
    ----------
    stages : sequence of Stage
    watch : callable
    net : Net
        The bubbles so far, for the case that the watch ends the packing.
    """

    def __init__(self, stages: Sequence[Stage], watch: Watch, net: Net) -> None:
        self._ends = list(accumulate(stage.work for stage in stages))
        self._done, self._end, self._watch = 0.0, 0.0, watch
        self.net = net

    def begins(self, number: int) -> None:
        """Stage ``number`` begins: what was expected before it is done."""
        self._done, self._end = (self._ends[number - 1] if number else 0.0), self._ends[number]
        self.grows(0.0)

    def grows(self, work: float) -> None:
        """So many steps of a bubble are done.

        Raises
        ------
        TimeUp
            If the watch does.
        """
        self._done = min(self._done + work, self._end)
        self._watch(self._done / self._ends[-1])
