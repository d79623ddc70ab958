"""The work on one part or strip, in whatever process it is done, and what is told of it."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from time import perf_counter, time
from typing import Any, NamedTuple, Protocol, Self, TypeVar

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import prefixed
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.methods import Method
from bubblemesh.packing.net import connect
from bubblemesh.packing.progress import TimeUp
from bubblemesh.packing.rounds import Round, rounds
from bubblemesh.spacing.grid.table import tabulated
from bubblemesh.spacing.metric.measures import measures_in
from bubblemesh.spacing.spacing import Spacing

T = TypeVar("T")

LATE = "the time limit"


class Job(NamedTuple):
    """Arguments of a function, and what errors are about."""

    what: str
    arguments: tuple[Any, ...]


class Crew(Protocol):
    """Who calls functions: this process, others, or those of a cluster."""

    def __call__(self, function: Callable[..., T], jobs: Iterable[Job]) -> Iterator[tuple[int, T]]:
        """Number and result of each job, in any order; errors of the package tell which job they are about."""


def alone(function: Callable[..., T], jobs: Iterable[Job]) -> Iterator[tuple[int, T]]:
    """Call a function for one job after the other, in this process."""
    for number, (what, arguments) in enumerate(jobs):
        with prefixed(what):
            result = function(*arguments)
        yield number, result


class Figures(NamedTuple):
    """Figures of bubbles and their triangles."""

    nodes: int
    boundary_nodes: int
    triangles: int
    quality_mean: float
    quality_min: float

    @classmethod
    def of(cls, bubbles: Bubbles, triangles: Integers, spacing: Spacing) -> Self:
        """Figures of bubbles that triangles (t, 3) connect, with qualities in the metric of a spacing if it has one."""
        q = measures_in(spacing, bubbles.x, triangles).radius_ratios
        return cls(len(bubbles), bubbles.boundary_count, len(q), float(q.mean()), float(q.min()))

    @classmethod
    def together(cls, parts: "Sequence[Figures]") -> Self:
        """Figures of several as one; bubbles that two have in common count for both."""
        nodes, boundary_nodes, triangles, mean, least = zip(*parts, strict=True)
        average = float(np.average(mean, weights=triangles))
        return cls(sum(nodes), sum(boundary_nodes), sum(triangles), average, min(least))


class Record(NamedTuple):
    """Record of a part's packing."""

    start: Figures  # before the first round
    end: Figures
    deleted: int
    inserted: int
    speeds: Floats  # (iterations,): mean speed after each step
    evaluations: int  # of the force on a bubble
    late: bool  # whether the deadline ended it
    seconds: float

    @classmethod
    def together(cls, parts: "Sequence[Record]") -> Self:
        """The record of several, one after the other."""
        start, end, deleted, inserted, speeds, evaluations, late, seconds = zip(*parts, strict=True)
        figures, counts = (Figures.together(start), Figures.together(end)), (sum(deleted), sum(inserted))
        return cls(*figures, *counts, np.concatenate(speeds), sum(evaluations), any(late), sum(seconds))


class Packed(NamedTuple):
    """Bubbles of a domain, with their triangles."""

    bubbles: Bubbles
    triangles: Integers  # (t, 3)
    record: Record


class Deadline(NamedTuple):
    """A time at which work has to end with what there is; infinite if there is none."""

    at: float  # seconds since 1970, on which clocks of several machines agree

    @classmethod
    def within(cls, seconds: float) -> "Deadline":
        """The time after so many seconds."""
        return cls(time() + seconds)

    @property
    def over(self) -> bool:
        """Whether it is past."""
        return time() >= self.at

    def watch(self, share: float) -> None:
        """TimeUp if the time is over."""
        if self.over:
            raise TimeUp(LATE)


def packed(
    domain: Domain, spacing: Spacing, method: Method, expected_nodes: float, max_nodes: int, deadline: Deadline
) -> Packed:
    """Pack a domain by itself."""
    levels, start = method.started(domain, tabulated(domain, spacing), expected_nodes, max_nodes)
    return _ended(domain, levels, method, start, deadline)


def packed_from(domain: Domain, spacing: Spacing, method: Method, x: Floats, deadline: Deadline) -> Packed:
    """Pack a domain whose bubbles are all corners, but for those at x (k, 2), from there."""
    table = tabulated(domain, spacing)
    places, count = np.vstack([domain.boundary.corners, x]), len(domain.boundary.corners)
    none = np.zeros(0, np.int64), np.zeros(0)
    start = Bubbles(places, table.extended(places), *none, count, np.zeros(len(places), bool))
    return _ended(domain, (table,), method, method.placement.again(start, domain, table), deadline)


def _ended(domain: Domain, levels: tuple[Spacing, ...], method: Method, start: Bubbles, deadline: Deadline) -> Packed:
    """All rounds of a packing."""
    begun, speeds = perf_counter(), list[Floats]()
    before = Figures.of(start, connect(start, domain).triangles, levels[0])
    deleted = inserted = evaluations = 0
    last: Round | None = None
    for last in rounds(start, domain, levels, method, deadline.watch):
        speeds.append(last.speeds)
        deleted, inserted = deleted + last.deleted, inserted + last.inserted
        evaluations += last.evaluations
    assert last is not None  # a packing has a round
    bubbles, triangles = last.bubbles, last.net.triangles
    figures, along = Figures.of(bubbles, triangles, levels[-1]), np.concatenate(speeds)
    seconds = perf_counter() - begun
    record = Record(before, figures, deleted, inserted, along, evaluations, last.stop_reason == LATE, seconds)
    return Packed(bubbles, triangles, record)
