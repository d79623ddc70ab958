"""The rounds of a packing: bubbles move, and their number is controlled, until the method's termination says stop."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple, Self

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.method import Method, Packing
from bubblemesh.packing.net import Net
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


@record
class Round:
    """Record of a round."""

    number: int  # counted from 1
    before: int  # number of bubbles
    inserted: int
    net: Net  # after the round
    speeds: Floats  # (iterations,): mean speed after each step of the motion
    evaluations: int  # of the force on a bubble
    stop_reason: str | None = None  # why no round follows
    late: bool = False  # whether that is since the time was up

    @property
    def iterations(self) -> int:
        """Number of steps of the motion."""
        return len(self.speeds)

    @property
    def deleted(self) -> int:
        """Number of bubbles that were deleted or lost."""
        return self.before + self.inserted - len(self.bubbles)

    @property
    def bubbles(self) -> Bubbles:
        """The bubbles after the round."""
        return self.net.bubbles


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
