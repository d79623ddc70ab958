"""The work on one part or strip, in whatever process it is done, and what is reported of it."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from time import monotonic, time
from typing import Any, NamedTuple, Protocol, TypeVar

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import prefixed
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.levels import SingleLevel
from bubblemesh.packing.method import Method
from bubblemesh.packing.progress import TimeUp
from bubblemesh.packing.rounds import Packed, all_rounds
from bubblemesh.records import record
from bubblemesh.spacing.grid.table import tabulated
from bubblemesh.spacing.spacing import Spacing

T = TypeVar("T")


class Job(NamedTuple):
    """Arguments of a function, and what errors are about."""

    what: str
    arguments: tuple[Any, ...]


class Crew(Protocol):
    """Who calls functions: this process, others, or those of a cluster."""

    def __call__(self, function: Callable[..., T], jobs: Iterable[Job]) -> Iterator[tuple[int, T]]:
        """Number and result of each job, in any order; errors of the package say which job they are about."""


def alone(function: Callable[..., T], jobs: Iterable[Job]) -> Iterator[tuple[int, T]]:
    """Call a function for one job after the other, in this process."""
    for number, (what, arguments) in enumerate(jobs):
        with prefixed(what):
            result = function(*arguments)
        yield number, result


@record
class Deadline:
    """A time at which work has to end with what there is; infinite if there is none.

    In another process it is over after as many seconds as are left when it is sent there, less those on the way.
    """

    at: float  # on the clock of this process, which nobody sets

    @classmethod
    def within(cls, seconds: float) -> "Deadline":
        """The time after so many seconds."""
        return cls(monotonic() + seconds)

    @property
    def left(self) -> float:
        """Seconds until then; negative if it is past."""
        return self.at - monotonic()

    def watch(self, share: float) -> None:
        """TimeUp if the time is over."""
        if self.left <= 0:
            raise TimeUp("the time limit")

    def __reduce__(self) -> tuple[Callable[[float, float], "Deadline"], tuple[float, float]]:
        return _arrived, (self.left, time())


def _arrived(left: float, sent: float) -> Deadline:
    """A deadline that had so many seconds left when it was sent, in seconds since 1970."""
    # Jobs may wait for a worker of a cluster; if a clock was set back meanwhile, they have not waited.
    return Deadline.within(left - max(time() - sent, 0.0))


@record
class Terms:
    """Terms on which all parts and strips of a mesh are packed: spacing, method, limits."""

    spacing: Spacing
    target: Spacing | None  # that figures and fields of the triangles compare with, if they are made by parts
    method: Method
    max_nodes: int
    deadline: Deadline = Deadline(np.inf)

    def for_part(self, share: float) -> "Terms":
        """The terms for a part with a share of the work: it takes as long for each bubble as in one piece."""
        return replace(self, method=replace(self.method, annealing=self.method.annealing.scaled(share)))

    def for_seams(self) -> "Terms":
        """The terms for strips, whose order is that of the parts beside them."""
        annealing = self.method.annealing.fast()
        return replace(self, method=replace(self.method, levels=SingleLevel(), annealing=annealing))


def packed(domain: Domain, expected_nodes: float, terms: Terms) -> Packed:
    """Pack a domain by itself."""
    levels, start = terms.method.started(domain, tabulated(domain, terms.spacing), expected_nodes, terms.max_nodes)
    return all_rounds(start, domain, levels, terms.method, levels[-1], terms.deadline.watch)


def packed_from(domain: Domain, x: Floats, terms: Terms) -> Packed:
    """Pack a domain whose bubbles are all corners, but for those at x (k, 2), from there."""
    table = tabulated(domain, terms.spacing)
    places, count = np.vstack([domain.boundary.corners, x]), len(domain.boundary.corners)
    none = np.zeros(0, np.int64), np.zeros(0)
    start = Bubbles(places, table.extended(places), *none, count, np.zeros(len(places), bool))
    start = terms.method.placement.again(start, domain, table)
    return all_rounds(start, domain, (table,), terms.method, table, terms.deadline.watch)
