"""The time limit of a packing, and what it has cut short."""

from collections.abc import Callable
from dataclasses import dataclass

from bubblemesh.packing.progress import TimeUp
from bubblemesh.process.watchdog import time_left
from bubblemesh.records import record


@record
class CutShort:
    """A packing, or its refinement, that was ended by the time limit."""

    seconds: float | None
    share: float  # of the packing that was done
    refining: bool = False  # whether the packing was at its end, and was refined

    @property
    def reason(self) -> str:
        """Why it ended."""
        return _reason(self.seconds)

    @property
    def warning(self) -> str:
        """Warning on what the limit did to the mesh."""
        if self.refining:
            return f"{self.reason} ended the refinement for angle_min, largest or overconstrained: the mesh is valid"
        return (
            f"{self.reason} ended the packing at about {self.share:.0%}: the mesh is valid, but less good than it "
            "could be"
        )


@dataclass
class TimeLimit:
    """Watch that ends a packing, or its refinement, while there is time to finish it, and hands on the share done."""

    seconds: float | None
    reserve: float  # seconds that what follows takes where no other program works
    on_share: Callable[[float], None]
    slowness: float = 1.0  # how many times as long it takes beside other programs
    share: float = 0.0
    over: bool = False  # whether it has ended anything

    @property
    def left(self) -> float:
        """Seconds until the packing has to end, negative if its time is up; infinite without a limit."""
        return time_left() - self.reserve * self.slowness

    def __call__(self, share: float) -> None:
        """Note the share that is done; TimeUp if the time is over."""
        self.tell(share)
        if self.left < 0:
            self.over = True
            raise TimeUp(_reason(self.seconds))

    def tell(self, share: float) -> None:
        """Hand on the share that is done, and note it while there is time: it is what a limit will have left."""
        if self.left >= 0 or self.share == 0:
            self.share = share
        self.on_share(share)

    def cut_short(self, *, refining: bool = False) -> CutShort:
        """What the limit has ended."""
        return CutShort(self.seconds, self.share, refining)


def _reason(seconds: float | None) -> str:
    return f"the time limit of {seconds:g} s"
