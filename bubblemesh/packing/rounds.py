"""The rounds of a packing: bubbles move, and their number is controlled, until the method's termination says stop."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from time import perf_counter
from typing import Any, NamedTuple, Self

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.method import Method, Packing
from bubblemesh.packing.net import Net, connect
from bubblemesh.packing.progress import Progress, Stage, TimeUp, Watch
from bubblemesh.packing.setting import Setting
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing


class Figures(NamedTuple):
    """Figures of bubbles and their triangles."""

    nodes: int
    boundary_nodes: int
    triangles: int
    quality_mean: float
    quality_min: float

    @classmethod
    def of(cls, net: Net, spacing: Spacing) -> Self:
        """Figures of connected bubbles, with qualities in the metric of a spacing if it has one."""
        q = spacing.measures(net.bubbles.x, net.triangles).radius_ratios
        return cls(len(net.bubbles), net.bubbles.boundary_count, len(q), float(q.mean()), float(q.min()))

    @classmethod
    def together(cls, parts: "Sequence[Figures]") -> Self:
        """Figures of several as one; bubbles that two have in common count for both."""
        nodes, boundary_nodes, triangles, mean, least = zip(*parts, strict=True)
        average = float(np.average(mean, weights=triangles))
        return cls(sum(nodes), sum(boundary_nodes), sum(triangles), average, min(least))


class Record(NamedTuple):
    """Record of a round; of all rounds of a packing, or of several packings, as one."""

    before: int  # number of bubbles
    after: Figures
    deleted: int
    inserted: int
    speeds: Floats  # (iterations,): mean speed after each step of the motion
    evaluations: int  # of the force on a bubble
    seconds: float
    late: bool  # whether it was ended since the time was up

    @classmethod
    def in_turn(cls, rounds: "Iterable[Record]") -> Self:
        """The record of all rounds of a packing."""
        before, after, *work = zip(*rounds, strict=True)
        return cls(before[0], after[-1], *_all_of(*work))

    @classmethod
    def together(cls, packings: "Iterable[Record]") -> Self:
        """The record of several packings; bubbles that two have in common count for both."""
        before, after, *work = zip(*packings, strict=True)
        return cls(sum(before), Figures.together(after), *_all_of(*work))


def _all_of(deleted: Any, inserted: Any, speeds: Any, evaluations: Any, seconds: Any, late: Any) -> tuple[Any, ...]:
    """The work of several records, one after the other."""
    return sum(deleted), sum(inserted), np.concatenate(speeds), sum(evaluations), sum(seconds), any(late)


class Packed(NamedTuple):
    """The result of a packing."""

    net: Net
    start: Figures  # before the first round
    rounds: tuple[Record, ...]
    stop_reason: str | None


@record
class Round:
    """A round as it ends, with the bubbles."""

    number: int  # counted from 1
    before: int  # number of bubbles
    inserted: int
    net: Net  # after the round
    speeds: Floats  # (iterations,): mean speed after each step of the motion
    evaluations: int  # of the force on a bubble
    stop_reason: str | None = None  # why no round follows
    late: bool = False  # whether that is since the time was up

    @property
    def deleted(self) -> int:
        """Number of bubbles that were deleted or lost."""
        return self.before + self.inserted - len(self.bubbles)

    @property
    def bubbles(self) -> Bubbles:
        """The bubbles after the round."""
        return self.net.bubbles

    def record(self, spacing: Spacing, seconds: float) -> Record:
        """The record of the round, with qualities in the metric of a spacing if it has one."""
        work = self.deleted, self.inserted, self.speeds, self.evaluations
        return Record(self.before, Figures.of(self.net, spacing), *work, seconds, self.late)


def all_rounds(
    start: Bubbles,
    domain: Domain,
    levels: Sequence[Spacing],
    method: Method,
    measured_by: Spacing,
    watch: Watch,
    on_round: Callable[[Record], None] = lambda done: None,
) -> Packed:
    """Run all `rounds` from a start; ``on_round`` is called with the record of each as it ends.

    Qualities after rounds are in the metric of the spacing that they are ``measured_by``, if it has one.
    """
    first = Figures.of(connect(start, domain), levels[0])
    records, last, begun = list[Record](), None, perf_counter()
    for done in rounds(start, domain, levels, method, watch):
        records.append(done.record(measured_by, perf_counter() - begun))
        on_round(records[-1])
        last, begun = done if done.stop_reason is not None else None, perf_counter()
        del done  # or its net, which takes most of the memory, stays while the next round makes its own
    assert last is not None  # the last round tells why it is
    return Packed(last.net, first, tuple(records), last.stop_reason)


def rounds(
    start: Bubbles, domain: Domain, levels: Sequence[Spacing], method: Method, watch: Watch = lambda share: None
) -> Iterator[Round]:
    """Rounds of the method on each level; after the last change of population the packing is finished.

    The bubbles of the ``start`` are placed by the first of the levels' spacings, which go from the coarsest to the one
    asked for. If the watch raises `TimeUp`, the bubbles go to the last level without further rounds, but for a last one
    that is marked as late.
    """
    random = method.perturbation.generator()
    stages = method.stages(len(levels), len(start))
    progress = Progress(stages, watch)
    setting = Setting(domain, random, progress)
    packing = method.packing(method.perturbation(start, levels[0], random), levels[0], setting)
    number, before, level = 0, len(packing.net.bubbles), 0
    try:
        for stage in stages:
            if stage.rank.coarser > level:
                level = stage.rank.coarser
                packing.to_level(levels[level])
            progress.begin(stage)
            for done in _rounds(packing, stage, number + 1):
                number, before = done.number, len(done.bubbles)
                yield done
                del done  # or its net, which takes most of the memory, stays while the next round makes its own
    except TimeUp as reason:
        # What the round has done until then counts as this one's.
        for spacing in levels[level + 1 :]:
            packing.to_level(spacing)
        packing.end()
        inserted = max(len(packing.net.bubbles) - before, 0)
        yield Round(number + 1, before, inserted, packing.net, np.zeros(0), 0, str(reason), late=True)
    else:
        progress.finish()


def _rounds(packing: Packing, stage: Stage, first: int) -> Iterator[Round]:
    """Rounds of a stage, numbered from ``first`` on."""
    counts: list[tuple[int, int]] = []
    reason = None
    while reason is None:
        before = len(packing.net.bubbles)
        # 1. The bubbles move; in the round that anneals they are displaced before, again and again.
        moved = packing.move(stage, counts)
        # 2. Where they are too many some are deleted, and gaps are filled.
        inserted = packing.control()
        # 3. The change of their number decides whether to stop.
        counts.append((before, len(packing.net.bubbles)))
        reason = packing.stop_reason(counts)
        # 4. At the end of the packing they relax once more, or are smoothed.
        if reason is not None and stage.finishing:
            more, last = packing.finish(stage, counts)
            moved, inserted = moved.followed_by(last), inserted + more
        stop_reason = reason if stage.finishing else None
        inserted += moved.added
        yield Round(
            first + len(counts) - 1, before, inserted, packing.net, moved.speeds, moved.evaluations, stop_reason
        )
