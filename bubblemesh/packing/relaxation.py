"""Relaxation: some steps of the motion, among neighbours near by or among neighbours in the triangulation."""

from collections.abc import Callable, Sequence
from typing import Annotated, ClassVar, NamedTuple, Protocol

import numpy as np
from annotated_types import Gt, Le
from typing_extensions import Doc

from bubblemesh.arrays import Booleans, Floats
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.library import or_numpy
from bubblemesh.kernels.relaxing import Steps, relaxed
from bubblemesh.packing.boundary_edges import drop_strays, split_cutting_edges
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.confinement import Confinement, Sliding
from bubblemesh.packing.forces import BoundForce, VanDerWaals
from bubblemesh.packing.motion import Motion, SemiImplicitEuler
from bubblemesh.packing.neighbours import Neighbours
from bubblemesh.packing.net import Net, connect_inside
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing

REACH = 1.9  # neighbours are listed up to this many l0, so that the list stays complete for a while
REFRESH_STEPS = 10
REFRESH_DRIFT = 0.2  # half of what the list reaches beyond the force's cutoff
MOST_MOVE = 0.5  # spacings in a step; where d jumps, a large bubble has so many small neighbours that it would fly

# Viscosities in some steps, of bubbles touched (n,) or not.
Viscosities = Callable[[range, Booleans], list[Floats | float]]
# Called with steps as they are made, and the number of bubbles.
OnSteps = Callable[[range, int], None]


class Dynamics(NamedTuple):
    """Motion of bubbles: the force between two of them, the step of their motion, what damps it, and its progress."""

    force: VanDerWaals
    motion: Motion
    viscosities: Viscosities
    progress: OnSteps = lambda steps, bubbles: None


class Relaxed(NamedTuple):
    """Bubbles after some steps, how many were added and lost on the way, their mean speed (steps,), evaluations."""

    bubbles: Bubbles
    added: int
    lost: int
    speeds: Floats
    evaluations: int

    @classmethod
    def none(cls, bubbles: Bubbles) -> "Relaxed":
        """The result of no step at all."""
        return cls(bubbles, 0, 0, np.zeros(0), 0)

    @classmethod
    def one_of(cls, parts: "Sequence[Relaxed]") -> "Relaxed":
        """One relaxation of some, one after the other."""
        bubbles, added, lost, speeds, evaluations = zip(*parts, strict=True)
        return cls(bubbles[-1], sum(added), sum(lost), np.concatenate(speeds), sum(evaluations))

    def followed_by(self, other: "Relaxed") -> "Relaxed":
        """One relaxation of both, the other after this one."""
        return Relaxed.one_of([self, other])


class Relaxation(Protocol):
    """A choice of the bubbles that act on each other, circles or ellipses, and of the boundary's part in the motion."""

    boundary_stays: ClassVar[bool]


class CircleRelaxation(Relaxation, Protocol):
    """Relaxation of circles."""

    def __call__(self, net: Net, domain: Domain, spacing: Spacing, dynamics: Dynamics, steps: int) -> Relaxed:
        """The bubbles of a net after ``steps`` steps."""

    @property
    def refresh(self) -> int:
        """Steps after which the edges along which bubbles act are renewed; 0 if they act on all that are near."""


@record
class Relaxer:
    """Relaxation of the bubbles of a level, by its spacing."""

    relaxation: CircleRelaxation
    domain: Domain
    spacing: Spacing
    dynamics: Dynamics

    def __call__(self, net: Net, steps: int) -> Relaxed:
        """The bubbles of a net after ``steps`` steps."""
        return self.relaxation(net, self.domain, self.spacing, self.dynamics, steps)


@record
class Nearby:
    """Bubbles near by act on each other; those on the boundary slide along it, the others are kept inside."""

    boundary_stays: ClassVar[bool] = False
    refresh: ClassVar[int] = 0

    def __call__(self, net: Net, domain: Domain, spacing: Spacing, dynamics: Dynamics, steps: int) -> Relaxed:
        start, (force, motion, viscosities, progress) = net.bubbles, dynamics
        sliding, confinement = Sliding(domain.boundary, start), Confinement(domain, start.x[start.interior])
        x, v, d, inside = start.x.copy(), np.zeros_like(start.x), start.d, start.interior
        neighbours, listed = Neighbours.of(x, d, REACH), 0
        acting = force.among(neighbours)
        speeds = np.empty(steps)
        for step in range(steps):
            if step - listed >= REFRESH_STEPS or neighbours.drift(x) > REFRESH_DRIFT:
                confinement.put_back(x[inside], v[inside], d[inside])
                d = spacing(x)
                neighbours, listed = Neighbours.of(x, d, REACH), step
                acting = force.among(neighbours)
            now = range(step, step + 1)
            progress(now, len(x))
            (c,) = viscosities(now, start.touched)
            moved, v = motion(x, v, c, sliding.projecting(acting))
            x, v = sliding.advance(*_bounded(x, moved, v, d))
            speeds[step] = _mean(_lengths(v))
        confinement.put_back(x[inside], v[inside], d[inside])
        ended = split_cutting_edges(sliding.bubbles_at(x, spacing(x)), domain, spacing)
        kept = drop_strays(ended, domain)
        added, lost = len(ended) - len(x), len(ended) - len(kept)
        return Relaxed(kept, added, lost, speeds, len(x) * steps * motion.evaluations)


@record
class Connected:
    """Bubbles joined by an edge of the triangulation act on each other; those on the boundary stay.

    Within the reach of the force these are the pairs that matter, and they do not act through thin walls. Bubbles that
    are outside when the triangulation is renewed are lost.
    """

    refresh: Annotated[int, Gt(0), Le(100_000), Doc("steps after which the triangulation is renewed")] = 20

    boundary_stays: ClassVar[bool] = True

    def __call__(self, net: Net, domain: Domain, spacing: Spacing, dynamics: Dynamics, steps: int) -> Relaxed:
        before, speeds, evaluations = len(net.bubbles), np.empty(steps), 0
        force, motion, viscosities, progress = dynamics
        for begin in range(0, steps, self.refresh):
            if begin:
                net = connect_inside(net.bubbles, domain, spacing, net)
            bubbles = net.bubbles
            x, d = bubbles.x, bubbles.d
            acting = force.among(Neighbours.along(net.edges, x, d))
            some = range(begin, min(begin + self.refresh, steps))
            progress(some, len(x))
            damping = viscosities(some, bubbles.touched)
            x, speeds[begin : begin + self.refresh] = _moved(bubbles, acting, motion, damping)
            evaluations += len(x) * motion.evaluations * len(some)
            net = net.of(bubbles.moved(x))
        return Relaxed(net.bubbles, 0, before - len(net.bubbles), speeds, evaluations)


def _moved_in_numpy(
    bubbles: Bubbles, acting: BoundForce, motion: Motion, viscosities: list[Floats | float]
) -> tuple[Floats, Floats]:
    """The same as `_moved`, in NumPy."""
    x, d, fixed = bubbles.x, bubbles.d, bubbles.boundary_count
    v, speeds = np.zeros_like(x), np.empty(len(viscosities))
    for step, c in enumerate(viscosities):
        moved, v = motion(x, v, c, acting)
        moved[:fixed], v[:fixed] = x[:fixed], 0
        x, v = _bounded(x, moved, v, d)
        speeds[step] = _mean(_lengths(v))
    return x, speeds


@or_numpy(_moved_in_numpy)
def _moved(
    bubbles: Bubbles, acting: BoundForce, motion: Motion, viscosities: list[Floats | float]
) -> tuple[Floats, Floats]:
    """Places (n, 2) and mean speeds (k,) of bubbles after a step for each viscosity; those on the boundary stay."""
    steps = kernel_steps(bubbles, motion, viscosities)
    if steps is None:
        return _moved_in_numpy(bubbles, acting, motion, viscosities)
    return relaxed(bubbles.x, acting.pull, steps)


def kernel_steps(bubbles: Bubbles, motion: Motion, viscosities: list[Floats | float]) -> Steps | None:
    """Steps of bubbles, one for each viscosity, that kernels know, or None; bubbles on the boundary stay."""
    if isinstance(motion, SemiImplicitEuler) and all(map(np.isscalar, viscosities)):
        return Steps(bubbles.boundary_count, MOST_MOVE * bubbles.d, float(motion.dt), np.array(viscosities, float))
    return None


def _bounded(x: Floats, moved: Floats, v: Floats, d: Floats) -> tuple[Floats, Floats]:
    """Positions and velocities (n, 2) after a step from x to ``moved`` in which no bubble goes too far."""
    move = moved - x
    length = _lengths(move)
    if (length <= MOST_MOVE * d).all():
        return moved, v
    share = (MOST_MOVE * d / np.maximum(length, MOST_MOVE * d))[:, None]
    return x + share * move, share * v


def _lengths(vectors: Floats) -> Floats:
    """Lengths (n,) of vectors (n, 2)."""
    x, y = vectors.T
    return np.sqrt(x * x + y * y)


def _mean(values: Floats) -> float:
    """Mean of values (n,), added one after the other as the compiled kernels do."""
    return float(np.cumsum(values)[-1]) / len(values)
