"""The rounds of a packing: relax, control the population, until the method's termination says stop."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.adjacency import Neighbours
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.connection import connected, enclosed
from bubblemesh.packing.methods import Method
from bubblemesh.packing.rails import Clearance, Rails
from bubblemesh.spacing.spacing import Spacing

__all__ = ["Round", "rounds"]

REACH = 1.9  # neighbours are listed up to this many l0, so that the list stays complete for a while
REFRESH_STEPS = 10
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


def rounds(start: Bubbles, domain: Domain, spacing: Spacing, method: Method) -> Iterator[Round]:
    """Rounds of the method from the bubbles ``start``; after the last change of population a relaxation closes."""
    bubbles, odd = start, np.zeros(len(start), bool)
    counts: list[tuple[int, int]] = []
    while True:
        relaxed, speeds = _relaxed(bubbles, domain, spacing, method, len(counts), odd)
        relaxed = enclosed(relaxed, domain)
        change = method.population(relaxed, domain, spacing)
        counts.append((len(bubbles), len(change.bubbles)))
        odd = change.touched & (method.odd is not None and method.odd.active(*counts[-1]))
        reason = method.termination(counts)
        evaluations = len(bubbles) * len(speeds) * method.motion.evaluations
        after = change.bubbles
        if reason is not None:
            after, closing = _relaxed(after, domain, spacing, method, len(counts) - 1, odd)
            after = enclosed(after, domain)
            speeds = np.concatenate([speeds, closing])
            evaluations += len(after) * len(closing) * method.motion.evaluations
        yield Round(
            number=len(counts),
            iterations=len(speeds),
            before=len(bubbles),
            deleted=len(bubbles) + change.inserted - len(after),
            inserted=change.inserted,
            bubbles=after,
            triangles=connected(after, domain)[2],
            speeds=speeds,
            evaluations=evaluations,
            stop_reason=reason,
        )
        if reason is not None:
            return
        bubbles = after


def _relaxed(
    start: Bubbles, domain: Domain, spacing: Spacing, method: Method, round_number: int, odd: Booleans
) -> tuple[Bubbles, Floats]:
    """The bubbles after the steps of a round, and their mean speed (iterations,) after each."""
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
        c = method.viscosity(step, round_number)
        damping = c if method.odd is None else method.odd(c, odd)
        x, v = method.motion(x, v, damping, rails.holding(force))
        x, v = rails.settled(x, v)
        speeds[step] = np.hypot(*v.T).mean()
    clearance.kept_inside(x[inside], v[inside], d[inside])
    return rails.ended(x, spacing(x)), speeds
