"""The time that each stage of a run takes."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from time import perf_counter

from bubblemesh.process.watchdog import Stage, enter


class Stopwatch:
    """A watch that measures the stages of a run, and goes on from the ``seconds`` of stages before."""

    def __init__(self, seconds: Mapping[str, float] | None = None) -> None:
        self._seconds = dict(seconds or {})
        self._within = list[Stage]()  # the stages of the blocks that have begun, the innermost last

    @property
    def seconds(self) -> dict[str, float]:
        """Seconds of each stage so far."""
        return dict(self._seconds)

    @contextmanager
    def stage(self, name: Stage) -> Iterator[None]:
        """Enter a stage, and add the time of the block to it, without the times of stages within the block.

        After a stage within another one that is entered again, unless an exception ends both.
        """
        begun, others = perf_counter(), -sum(self._seconds.values())
        enter(name)
        self._within.append(name)
        try:
            yield
        finally:
            self._within.pop()
            others += sum(self._seconds.values())
            self._seconds[name] = self._seconds.get(name, 0.0) + perf_counter() - begun - others
        if self._within:
            enter(self._within[-1])
