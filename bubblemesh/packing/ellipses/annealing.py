"""Relaxation and annealing in a metric."""

import math
from collections.abc import Iterator

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.kernels.annealing import Cycles
from bubblemesh.kernels.ellipse_annealing import Relaxing, Tensors
from bubblemesh.kernels.ellipse_annealing import annealed as annealed_at_once
from bubblemesh.kernels.ellipse_motion import relaxed as relaxed_places
from bubblemesh.kernels.library import library
from bubblemesh.kernels.tensors import roots, unmapped
from bubblemesh.packing.annealing import SEEDS, Annealing, NoAnnealing, deviations, disorder_marked
from bubblemesh.packing.ellipses.net import EllipseNet
from bubblemesh.packing.ellipses.schemes import Schemes
from bubblemesh.spacing.metric.metric import MetricSpacing

SPARED = 0.98  # share of its length below which a shortened ellipse is left alone
TIMES = 2  # as many cycles as of circles: gentle metrics gain by more, steep ones do not
LOOK_AFTER = 10  # cycles: at the metric, and which ellipses are spared; bubbles move little in between


def relaxed(ellipses: EllipseNet, schemes: Schemes, steps: int) -> tuple[Floats, Floats]:
    """Places (n, 2) of the bubbles after steps of motion from rest, and their mean speeds (steps,) in the metric."""
    net = ellipses.net
    return relaxed_places(net.bubbles.x, ellipses.tensors, net.triangles, net.edges, *_motion(ellipses, schemes, steps))


def _motion(ellipses: EllipseNet, schemes: Schemes, steps: int) -> tuple[int, int, float, float]:
    """Motion as kernels take it: number of fixed bubbles, steps, time step and damping."""
    return ellipses.net.bubbles.boundary_count, steps, float(schemes.motion.dt), schemes.viscosity(0, 0)


def cycles_of(annealing: Annealing | NoAnnealing, bubbles: int) -> int:
    """Number of cycles of annealing of so many ellipses, which are on a single level."""
    return math.ceil(TIMES * annealing.by_size(bubbles))


def annealed(
    ellipses: EllipseNet, spacing: MetricSpacing, schemes: Schemes, random: np.random.Generator
) -> Iterator[tuple[EllipseNet, int]]:
    """The ellipses after some cycles of annealing, and how many these were, until all are done.

    Those with other than six neighbours, and those next to them, are displaced by less and less in the metric, and
    relaxed. Where ellipses are shorter than the metric asks for, since it bends, forces know no better order than
    smoothing makes.
    """
    annealing = schemes.annealing
    if isinstance(annealing, NoAnnealing):
        return
    total, seed = cycles_of(annealing, len(ellipses.tensors)), int(random.integers(SEEDS))
    inside = annealing.amplitude * (1 - np.arange(total) / total)
    calm, known = spacing.shares(ellipses.known) <= SPARED, ellipses.known
    for done in range(0, total, LOOK_AFTER):
        some = inside[done : done + LOOK_AFTER]
        ellipses = ellipses.moved(ellipses.net.bubbles.x, spacing)
        fresh = (ellipses.known != known).any(axis=1)
        known = ellipses.known
        calm[fresh] = spacing.shares(known[fresh]) <= SPARED
        cycles = Cycles(seed, done, some, annealing.amplitude_at_boundary * some, calm)
        ellipses = _through(ellipses, schemes, cycles, annealing.shake_steps)
        if done + len(some) == total:
            ellipses = ellipses.moved(ellipses.net.bubbles.x, spacing)
        yield ellipses, len(some)


def _through(ellipses: EllipseNet, schemes: Schemes, cycles: Cycles, steps: int) -> EllipseNet:
    """The ellipses after cycles, all with the tensors that they have now."""
    compiled, net, root = library(), ellipses.net, roots(ellipses.tensors)
    if compiled is None:
        for number in range(len(cycles.inside)):
            ellipses = _once(ellipses, schemes, cycles.after(number), root, steps)
        return ellipses
    tensors, relaxing = Tensors(ellipses.tensors, root), Relaxing(*_motion(ellipses, schemes, steps))
    return ellipses.by(*annealed_at_once(compiled, net.bubbles.x, net.triangles, net.facets, tensors, relaxing, cycles))


def _once(ellipses: EllipseNet, schemes: Schemes, cycles: Cycles, root: Floats, steps: int) -> EllipseNet:
    """The ellipses after the first of the cycles, with roots (n, 3) of their tensors."""
    amplitude = disorder_marked(ellipses.net, float(cycles.inside[0]), float(cycles.beside[0]))
    amplitude[cycles.calm] = 0.0
    chance = deviations(cycles.seed, cycles.first, np.arange(len(amplitude)))
    ellipses = ellipses.displaced(unmapped(root, amplitude[:, None] * chance))
    return ellipses.at(relaxed(ellipses, schemes, steps)[0])
