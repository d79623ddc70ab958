"""The time that a packing may take."""

from collections.abc import Callable
from time import perf_counter

from bubblemesh.packing.progress import TimeUp


class Clock:
    """A watch that ends a packing after a time, and hands on what share of it is done.

    Parameters
    ----------
    limit : float or None
        Seconds that all may take.
    begun : float
        Reading of ``perf_counter`` when all began.
    on_share : callable
    """

    def __init__(self, limit: float | None, begun: float, on_share: Callable[[float], None]) -> None:
        self._limit, self._on_share = limit, on_share
        self._begun, self._share = begun, 0.0
        self.over = False

    def __call__(self, share: float) -> None:
        """Note the share that is done.

        Raises
        ------
        TimeUp
            If the time is over.
        """
        self._share = share
        self._on_share(share)
        if self._limit is not None and perf_counter() - self._begun > self._limit:
            self.over = True
            raise TimeUp(f"the time limit of {self._limit:g} s")

    @property
    def warnings(self) -> list[str]:
        """Warning on what the limit did to the mesh, if it was met."""
        if not self.over:
            return []
        return [
            f"the time limit of {self._limit:g} s ended the packing at about {self._share:.0%}: the mesh is valid, but "
            "less good than it could be"
        ]
