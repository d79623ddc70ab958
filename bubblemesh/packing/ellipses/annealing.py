"""Relaxation and annealing in a metric."""

import math
from collections.abc import Iterator

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.kernels import ellipses as kernels
from bubblemesh.meshes.tensors import roots, unmapped
from bubblemesh.packing.annealing import Annealing, NoAnnealing, disorder_marked
from bubblemesh.packing.ellipses.net import EllipseNet
from bubblemesh.packing.ellipses.schemes import Schemes
from bubblemesh.packing.placement import CLIPPED_AT
from bubblemesh.spacing.metric.metric import MetricSpacing

SPARED = 0.98  # share of its length below which a shortened ellipse is left alone
LOOK_AFTER = 10  # cycles: at the metric, and which ellipses are spared; bubbles move little in between


def relaxed(ellipses: EllipseNet, schemes: Schemes, steps: int) -> tuple[Floats, Floats]:
    """Places (n, 2) of the bubbles after steps of motion from rest, and their mean speeds (steps,) in the metric."""
    net, c = ellipses.net, schemes.viscosity(0, 0)
    fixed, dt = net.bubbles.boundary_count, float(schemes.motion.dt)
    return kernels.relaxed(net.bubbles.x, ellipses.tensors, net.triangles, net.edges, fixed, steps, dt, c)


def cycles_of(annealing: Annealing | NoAnnealing, bubbles: int) -> int:
    """Number of cycles of annealing of so many ellipses, which are on a single level."""
    return math.ceil(annealing.by_size(bubbles))


def annealed(
    ellipses: EllipseNet, spacing: MetricSpacing, schemes: Schemes, random: np.random.Generator
) -> Iterator[EllipseNet]:
    """The ellipses after each cycle of annealing: less and less displaced, relaxed.

    Those with other than six neighbours, and those next to them, are displaced by about the same in the metric. Where
    ellipses are shorter than the metric asks for, since it bends, forces know no better order than smoothing makes.
    """
    annealing = schemes.annealing
    if isinstance(annealing, NoAnnealing):
        return
    cycles = cycles_of(annealing, len(ellipses.tensors))
    for cycle in range(cycles):
        if cycle % LOOK_AFTER == 0:
            ellipses = ellipses.moved(ellipses.net.bubbles.x, spacing)
            free = spacing.shares(ellipses.net.bubbles.x) > SPARED
        amplitude = np.where(free, _amplitude(annealing, ellipses, 1 - cycle / cycles), 0.0)
        chance = random.standard_normal((len(amplitude), 2)).clip(-CLIPPED_AT, CLIPPED_AT)
        moves = unmapped(roots(ellipses.tensors), amplitude[:, None] * chance)
        ellipses = ellipses.displaced(moves)
        # Displacements and relaxations go by the tensors of the last look.
        ellipses = ellipses.at(relaxed(ellipses, schemes, annealing.shake_steps)[0])
        if cycle + 1 == cycles:
            ellipses = ellipses.moved(ellipses.net.bubbles.x, spacing)
        yield ellipses


def _amplitude(annealing: Annealing, ellipses: EllipseNet, share: float) -> Floats:
    """Standard deviations (n,) of displacements, in the metric: of the first cycle's the ``share``."""
    inside = share * annealing.amplitude
    return disorder_marked(ellipses.net, inside, annealing.amplitude_at_boundary * inside)
