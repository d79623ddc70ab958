"""The rounds of a packing: relax, control the population, until the method's termination says stop."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.levels import refined
from bubblemesh.packing.methods import Method
from bubblemesh.packing.net import Net, connect, connect_inside
from bubblemesh.packing.population.thresholds import Change
from bubblemesh.packing.progress import CONNECTING, POLISHING, Progress, Stage, TimeUp, Watch, stages_of
from bubblemesh.packing.relaxation import Dynamics, Relaxed
from bubblemesh.spacing.spacing import Spacing

CLOSING_REPEATS = 3


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
    net : Net
        The bubbles and their triangulation after the round.
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
    net: Net
    speeds: Floats
    evaluations: int
    stop_reason: str | None = None

    @property
    def bubbles(self) -> Bubbles:
        """The bubbles after the round."""
        return self.net.bubbles

    @property
    def triangles(self) -> Integers:
        """The triangles (t, 3) after the round."""
        return self.net.triangles


@dataclass(frozen=True)
class LevelRun:
    """What stays the same through the rounds of a level."""

    domain: Domain
    spacing: Spacing
    method: Method
    random: np.random.Generator
    workload: Progress

    def relaxed(self, net: Net, steps: int, number: int = 0, odd: bool = False) -> Relaxed:
        """The steps of a round; if ``odd``, the bubbles that were touched have a viscosity of their own."""
        method, workload = self.method, self.workload
        workload.grows(CONNECTING * len(net.bubbles))

        def damping(step: int, touched: Booleans) -> Floats | float:
            workload.grows(len(touched))
            c = method.viscosity(step, number)
            return method.odd(c, touched) if odd and method.odd is not None else c

        dynamics = Dynamics(method.force, method.motion, damping)
        return method.relaxation(net, self.domain, self.spacing, dynamics, steps)

    def controlled(self, net: Net) -> Change:
        """The bubbles after the method's population control."""
        return self.method.population(net, self.domain, self.spacing, self.random)

    def shaken(self, net: Net) -> Relaxed:
        """The method's shaking, or no step at all."""
        shaking = self.method.shaking
        if shaking is None:
            return Relaxed.none(net.bubbles)
        return shaking(net, self.domain, self.spacing, self.random, self.relaxed)

    def closed(self, net: Net, steps: int, number: int, odd: bool) -> tuple[Net, int, Relaxed]:
        """The net after the polish, or without one a last relaxation, and the number of bubbles that this inserts.

        The relaxation is repeated while bubbles are lost at the boundary.
        """
        if self.method.polish is not None:
            return *self.polished(net), Relaxed.none(net.bubbles)
        relaxed = total = self.relaxed(net, steps, number, odd)
        for _ in range(CLOSING_REPEATS):
            if relaxed.lost == 0:
                break
            relaxed = self.relaxed(connect(relaxed.bubbles, self.domain), steps, number, odd)
            total = total.followed_by(relaxed)
        return connect_inside(total.bubbles, self.domain, self.spacing), 0, total

    def polished(self, net: Net) -> tuple[Net, int]:
        """The net after the method's polish, with population control in between, and the number of new bubbles."""
        polish, mending, inserted = self.method.polish, self.method.mending, 0
        if polish is None:
            return net, inserted
        for number in range(polish.passes):
            change = self.controlled(net) if number else Change(net.bubbles, 0, 0)
            if change.deleted + change.inserted:
                net, inserted = connect_inside(change.bubbles, self.domain, self.spacing), inserted + change.inserted
            net = polish(net, self.domain, self.spacing)
            self.workload.net = net
            self.workload.grows(POLISHING * len(net.bubbles))
        if mending is not None:
            net = mending(net, self.domain, self.spacing, polish, self.random)
        return net, inserted


def rounds(
    start: Bubbles, domain: Domain, levels: Sequence[Spacing], method: Method, watch: Watch = lambda share: None
) -> Iterator[Round]:
    """Rounds of the method on each level; after the last change of population a relaxation closes.

    Parameters
    ----------
    start : Bubbles
        Placed by the first spacing of the levels.
    domain : Domain
    levels : sequence of Spacing
        From the coarsest to the wanted one.
    method : Method
    watch : callable
        Is told what share of the packing is done. If it raises `TimeUp`, the bubbles are refined to the wanted spacing
        without more ado, and a last round tells so.
    """
    random = method.perturbation.generator()
    stages = stages_of(method, len(levels), len(start))
    net, number, level = connect(method.perturbation(start, levels[0], random), domain), 0, 0
    workload = Progress(stages, watch, net)
    try:
        for place, stage in enumerate(stages):
            if stage.level > level:
                level = stage.level
                workload.net = net = connect(refined(net, domain, levels[level]), domain)
            workload.begins(place)
            course = LevelRun(domain, levels[level], method, random, workload)
            for done in _settling(course, net, number == 0, stage):
                number, net = number + 1, done.net
                yield replace(done, number=number)
    except TimeUp as reason:
        yield _cut_short(workload.net, domain, levels[level + 1 :], number + 1, str(reason))


def _cut_short(net: Net, domain: Domain, levels: Sequence[Spacing], number: int, reason: str) -> Round:
    """A round that does no more than to refine the bubbles to the wanted spacing, level by level."""
    before = len(net.bubbles)
    for spacing in levels:
        net = connect(refined(net, domain, spacing), domain)
    inserted = len(net.bubbles) - before
    return Round(number, 0, before, max(-inserted, 0), max(inserted, 0), net, np.zeros(0), 0, reason)


def _settling(course: LevelRun, net: Net, opening: bool, stage: Stage) -> Iterator[Round]:
    """Rounds of a stage until the termination says stop."""
    method, closing = course.method, stage.closing
    counts: list[tuple[int, int]] = []
    odd, reason = False, None
    while reason is None:
        number, before = len(counts), len(net.bubbles)
        steps = method.termination.steps(opening and number == 0)
        relaxed = course.shaken(net) if stage.shaking and number == 0 else course.relaxed(net, steps, number, odd)
        change = course.controlled(connect_inside(relaxed.bubbles, course.domain, course.spacing))
        counts.append((before, len(change.bubbles)))
        odd = method.odd is not None and method.odd.active(*counts[-1])
        reason = method.termination(counts)
        net, inserted = connect(change.bubbles, course.domain), change.inserted
        course.workload.net = net
        if reason is not None and closing:
            net, more, last = course.closed(net, steps, number, odd)
            relaxed, inserted = relaxed.followed_by(last), inserted + more
        inserted += relaxed.added
        yield Round(
            number=number + 1,
            iterations=len(relaxed.speeds),
            before=before,
            deleted=before + inserted - len(net.bubbles),
            inserted=inserted,
            net=net,
            speeds=relaxed.speeds,
            evaluations=relaxed.evaluations,
            stop_reason=reason if closing else None,
        )
