"""The rounds of a packing: relax, control the population, until the method's termination says stop."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.adjacency import Neighbours
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.chords import enclosed, parted
from bubblemesh.packing.connection import connected
from bubblemesh.packing.methods import Method
from bubblemesh.packing.rails import Clearance, Rails
from bubblemesh.spacing.spacing import Spacing

__all__ = ["Round", "rounds"]

REACH = 1.9  # neighbours are listed up to this many l0, so that the list stays complete for a while
CLOSING_REPEATS = 3
REFRESH_STEPS = 10
MOST_MOVE = 0.5  # spacings in a step; where d jumps, a large bubble has so many small neighbours that it would fly
REFRESH_DRIFT = 0.2  # half of what the list reaches beyond the force's cutoff


@dataclass(frozen=True)
class Round:
    """What a round did.

    Attributes
    ----------
    number : int
        Counted from 1.
    iterations : int
        Steps of the motion.
    deleted, inserted : int
    before : int
        Number of bubbles before the population control.
    bubbles, triangles : Bubbles, (t, 3)
        After the round.
    speeds : (iterations,)
        Mean speed of the bubbles after each step.
    evaluations : int
        Evaluations of the force on a bubble.
    stop_reason : str or None
        Why no round follows.
    """

    number: int
    iterations: int
    before: int
    deleted: int
    inserted: int
    bubbles: Bubbles
    triangles: Integers
    speeds: Floats
    evaluations: int
    stop_reason: str | None = None


class Relaxed(NamedTuple):
    """Bubbles after some steps, how many the boundary needed more, their mean speed (steps,) and force evaluations."""

    bubbles: Bubbles
    added: int
    speeds: Floats
    evaluations: int


def rounds(start: Bubbles, domain: Domain, spacing: Spacing, method: Method) -> Iterator[Round]:
    """Rounds of the method from the bubbles ``start``; after the last change of population a relaxation closes."""
    random = method.perturbation.generator()
    bubbles = method.perturbation(start, spacing, random)
    counts: list[tuple[int, int]] = []
    odd, reason = False, None
    while reason is None:
        number = len(counts)
        relaxed = _relaxed(bubbles, domain, spacing, method, number, odd)
        change = method.population(enclosed(relaxed.bubbles, domain), domain, spacing, random)
        counts.append((len(bubbles), len(change.bubbles)))
        odd = method.odd is not None and method.odd.active(*counts[-1])
        reason = method.termination(counts)
        after, speeds, evaluations = change.bubbles, relaxed.speeds, relaxed.evaluations
        inserted = relaxed.added + change.inserted
        if reason is not None:
            closing = _closed(after, domain, spacing, method, number, odd)
            after = closing.bubbles
            inserted += closing.added
            speeds, evaluations = np.append(speeds, closing.speeds), evaluations + closing.evaluations
        yield Round(
            number=number + 1,
            iterations=len(speeds),
            before=len(bubbles),
            deleted=len(bubbles) + inserted - len(after),
            inserted=inserted,
            bubbles=after,
            triangles=connected(after, domain)[2],
            speeds=speeds,
            evaluations=evaluations,
            stop_reason=reason,
        )
        bubbles = after


def _closed(start: Bubbles, domain: Domain, spacing: Spacing, method: Method, number: int, odd: bool) -> Relaxed:
    """The relaxation after the last change of population, again if bubbles came too near to the boundary."""
    relaxed = _relaxed(start, domain, spacing, method, number, odd)
    for _ in range(CLOSING_REPEATS):
        kept = enclosed(relaxed.bubbles, domain)
        if len(kept) == len(relaxed.bubbles):
            break
        again = _relaxed(kept, domain, spacing, method, number, odd)
        speeds = np.append(relaxed.speeds, again.speeds)
        relaxed = Relaxed(again.bubbles, relaxed.added + again.added, speeds, relaxed.evaluations + again.evaluations)
    return relaxed._replace(bubbles=enclosed(relaxed.bubbles, domain))


def _relaxed(start: Bubbles, domain: Domain, spacing: Spacing, method: Method, number: int, odd: bool) -> Relaxed:
    """The steps of a round; if ``odd``, the bubbles that were touched have a viscosity of their own."""
    rails, clearance = Rails(domain.boundary, start), Clearance(domain, start.x[start.interior])
    x, v, d, inside = start.x.copy(), np.zeros_like(start.x), start.d, start.interior
    neighbours, listed = Neighbours.of(x, d, REACH), 0
    force = method.force.among(neighbours)
    speeds = np.empty(method.termination.iterations)
    for step in range(len(speeds)):
        if step - listed >= REFRESH_STEPS or neighbours.drift(x) > REFRESH_DRIFT:
            clearance.kept_inside(x[inside], v[inside], d[inside])
            d = spacing(x)
            neighbours, listed = Neighbours.of(x, d, REACH), step
            force = method.force.among(neighbours)
        c = method.viscosity(step, number)
        damping = method.odd(c, start.touched) if odd and method.odd is not None else c
        moved, v = method.motion(x, v, damping, rails.holding(force))
        x, v = rails.settled(*_bounded(x, moved, v, d))
        speeds[step] = np.hypot(*v.T).mean()
    clearance.kept_inside(x[inside], v[inside], d[inside])
    ended = parted(rails.ended(x, spacing(x)), domain, spacing)
    return Relaxed(ended, len(ended) - len(x), speeds, len(x) * len(speeds) * method.motion.evaluations)


def _bounded(x: Floats, moved: Floats, v: Floats, d: Floats) -> tuple[Floats, Floats]:
    """Positions and velocities after a step in which no bubble goes too far."""
    move = moved - x
    length = np.sqrt(np.einsum("ij,ij->i", move, move))
    if (length <= MOST_MOVE * d).all():
        return moved, v
    share = np.minimum(1, MOST_MOVE * d / np.maximum(length, MOST_MOVE * d))[:, None]
    return x + share * move, share * v
