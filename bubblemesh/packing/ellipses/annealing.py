"""Relaxation and annealing in a metric."""

import math
from collections.abc import Iterator
from typing import ClassVar, Self

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.kernels.annealing import Cycles
from bubblemesh.kernels.ellipse_annealing import Relaxing, Tensors, annealed
from bubblemesh.kernels.ellipse_motion import relaxed
from bubblemesh.kernels.library import or_numpy
from bubblemesh.kernels.tensors import roots, unmapped
from bubblemesh.packing.annealing import (
    ONLY,
    SEEDS,
    AnnealingCycles,
    Calm,
    NoCycles,
    Rank,
    deviations,
    disorder_marked,
)
from bubblemesh.packing.ellipses.net import EllipseNet
from bubblemesh.records import record
from bubblemesh.spacing.metric.metric import MetricSpacing

SPARED = 0.98  # share of its length below which a shortened ellipse is left alone
TIMES = 2  # as many cycles as of circles: gentle metrics gain by more, steep ones do not
LOOK_AFTER = 10  # cycles: at the metric, and which ellipses are spared; bubbles move little in between

Annealed = Iterator[tuple[EllipseNet, int]]  # the ellipses after some cycles, and how many these were


@record
class EllipseRelaxation:
    """Ellipses joined by an edge of the triangulation act on each other; those on the boundary stay.

    The force, of strength 1, goes by the lengths of edges in the metric. It is part of the kernels, as the motion is.
    """

    boundary_stays: ClassVar[bool] = True

    def __call__(self, ellipses: EllipseNet, relaxing: Relaxing) -> tuple[Floats, Floats]:
        """Places (n, 2) of the bubbles after steps from rest, and their mean speeds (steps,) in the metric."""
        net = ellipses.net
        return relaxed(net.bubbles.x, ellipses.tensors, net.triangles, net.edges, *relaxing)


@record
class NoEllipseAnnealing(NoCycles):
    """No annealing."""

    def __call__(
        self,
        ellipses: EllipseNet,
        spacing: MetricSpacing,
        relaxation: EllipseRelaxation,
        relaxing: Relaxing,
        random: np.random.Generator,
    ) -> Annealed:
        """Nothing: there are no cycles."""
        return iter(())


@record
class EllipseAnnealing(AnnealingCycles):
    """Displacement in the metric, less and less, of ellipses without six neighbours and of those next to them.

    Where ellipses are shorter than the metric asks for, since it bends, they stay: forces know no better order than
    smoothing makes.
    """

    def __call__(
        self,
        ellipses: EllipseNet,
        spacing: MetricSpacing,
        relaxation: EllipseRelaxation,
        relaxing: Relaxing,
        random: np.random.Generator,
    ) -> Annealed:
        """The ellipses after some cycles, each a displacement and a relaxation, until all are done."""
        total, seed = self.cycles(len(ellipses.tensors)), int(random.integers(SEEDS))
        inside = self.amplitude * (1 - np.arange(total) / total)
        calm, known = spacing.shares(ellipses.known, ellipses.tensors) <= SPARED, ellipses.known
        for done in range(0, total, LOOK_AFTER):
            some = inside[done : done + LOOK_AFTER]
            ellipses = ellipses.moved(ellipses.net.bubbles.x, spacing)
            fresh = (ellipses.known != known).any(axis=1)
            known = ellipses.known
            calm[fresh] = spacing.shares(known[fresh], ellipses.tensors[fresh]) <= SPARED
            cycles = Cycles(seed, done, some, self.amplitude_at_boundary * some, calm)
            ellipses = _through(ellipses, relaxation, relaxing, cycles)
            if done + len(some) == total:
                ellipses = ellipses.moved(ellipses.net.bubbles.x, spacing)
            yield ellipses, len(some)

    def cycles(self, bubbles: int, rank: Rank = ONLY) -> int:
        """Number of cycles of so many ellipses, which are on a single level."""
        return math.ceil(TIMES * self.by_size(bubbles))

    def sparing(self, calm: Calm) -> Self:
        """The same annealing: the sizes of a metric do not show where ellipses are in order."""
        return self


def _through_in_numpy(
    ellipses: EllipseNet, relaxation: EllipseRelaxation, relaxing: Relaxing, cycles: Cycles
) -> EllipseNet:
    """The same as `_through`, in NumPy."""
    root = roots(ellipses.tensors)
    for number in range(len(cycles.inside)):
        ellipses = _once(ellipses, relaxation, relaxing, cycles.after(number), root)
    return ellipses


@or_numpy(_through_in_numpy)
def _through(ellipses: EllipseNet, relaxation: EllipseRelaxation, relaxing: Relaxing, cycles: Cycles) -> EllipseNet:
    """The ellipses after cycles, all with the tensors that they have now."""
    net, tensors = ellipses.net, Tensors(ellipses.tensors, roots(ellipses.tensors))
    return ellipses.by(*annealed(net.bubbles.x, net.triangles, net.facets, tensors, relaxing, cycles))


def _once(
    ellipses: EllipseNet, relaxation: EllipseRelaxation, relaxing: Relaxing, cycles: Cycles, root: Floats
) -> EllipseNet:
    """The ellipses after the first of the cycles, with roots (n, 3) of their tensors."""
    amplitude = disorder_marked(ellipses.net, float(cycles.inside[0]), float(cycles.beside[0]))
    amplitude[cycles.calm] = 0.0
    chance = deviations(cycles.seed, cycles.first, np.arange(len(amplitude)))
    ellipses = ellipses.displaced(unmapped(root, amplitude[:, None] * chance))
    return ellipses.at(relaxation(ellipses, relaxing)[0])
