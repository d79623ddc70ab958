"""Mending in a metric: where triangles are bad, bubbles leave, or trials are made, if triangles cost less after it."""

from collections.abc import Iterator
from typing import ClassVar, NamedTuple, Self

import numpy as np

from bubblemesh.arrays import Floats, Integers, all_of_rows
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.packing.ellipses.net import EllipseNet
from bubblemesh.packing.ellipses.smoothing import AnyEllipseSmoothing, costs
from bubblemesh.packing.ellipses.trials import Trials, Tried
from bubblemesh.packing.mending import MendingAttempts
from bubblemesh.packing.net import Net
from bubblemesh.packing.splicing import Holes
from bubblemesh.records import record
from bubblemesh.spacing.metric.metric import MetricSpacing

LEAST_GAIN = 0.1  # of what triangles cost, for which a bubble leaves
IN_VAIN = 0.15  # of the attempts: after so many in a row without a gain there is no hope for more


class Removals(NamedTuple):
    """Bubbles that could move onto a neighbour and vanish."""

    nodes: Integers  # (k,)
    onto: Integers  # (k,): the neighbours
    gains: Floats  # (k,): how much less the triangles would cost
    around: list[Integers]  # (k,) of all their neighbours

    @classmethod
    def of(cls, ellipses: EllipseNet, bad: float, spacing: MetricSpacing, smoothing: AnyEllipseSmoothing) -> Self:
        """Inner bubbles of triangles that cost more than ``bad``, and the best neighbour of each."""
        x, triangles = ellipses.net.bubbles.x, ellipses.net.triangles
        cost = costs(x, triangles, spacing, smoothing)
        chosen = np.zeros(len(x), bool)
        chosen[triangles[cost > bad]] = True
        chosen &= ellipses.interior
        holes = Holes.of(triangles, chosen)
        row, node, a, b, nodes, start, _ = holes
        # From each corner of a hole, triangles to the sides that it is no end of, and what they cost.
        corner, side, apart = holes.fans()
        fans = np.column_stack([a[corner], a[side], b[side]])[apart]
        after = np.bincount(corner[apart], costs(x, fans, spacing, smoothing), len(node))
        # The node moves onto the corner where that is least.
        best = np.lexsort([after, node])[start]
        before = np.add.reduceat(cost[row], start)
        return cls(nodes, a[best], np.asarray(before - after[best]), np.split(a, start[1:]))

    @property
    def best(self) -> Integers:
        """Numbers (r,) of those that gain most, no two of which have a neighbour in common."""
        taken, found = set[int](), list[int]()
        order = np.argsort(-self.gains, kind="stable")
        for number in order[self.gains[order] > LEAST_GAIN].tolist():
            patch = {int(self.nodes[number]), *self.around[number].tolist()}
            if not patch & taken:
                taken |= patch
                found.append(number)
        return np.array(found, np.int64)


@record
class NoEllipseMending:
    """No mending."""

    attempts: ClassVar[int] = 0

    def fewer(self, ellipses: EllipseNet, spacing: MetricSpacing, smoothing: AnyEllipseSmoothing) -> EllipseNet:
        """The ellipses as they are."""
        return ellipses

    def tried(
        self, ellipses: EllipseNet, spacing: MetricSpacing, smoothing: AnyEllipseSmoothing, random: np.random.Generator
    ) -> Iterator[Tried]:
        """Nothing: there are no attempts."""
        return iter(())


@record
class EllipseMending(MendingAttempts):
    """Bubbles that leave, and trials of other neighbours, where triangles are bad and cost less for it."""

    def fewer(self, ellipses: EllipseNet, spacing: MetricSpacing, smoothing: AnyEllipseSmoothing) -> EllipseNet:
        """The net without those bubbles, at triangles with a measure above ``mend_worse``, that gain most by leaving.

        What lacks bubbles gets them from population control: triangles of a halved one are worse until they are
        smoothed.
        """
        net, tensors, known = ellipses
        removals = Removals.of(ellipses, self.mend_worse**4 - 1, spacing, smoothing)
        best = removals.best
        if len(best) == 0:
            return ellipses
        onto, stay = np.arange(len(tensors)), np.ones(len(tensors), bool)
        onto[removals.nodes[best]], stay[removals.nodes[best]] = removals.onto[best], False
        triangles = onto[net.triangles]
        triangles = (np.cumsum(stay) - 1)[triangles[all_of_rows(triangles != np.roll(triangles, 1, axis=1))]]
        bubbles, (edges, _) = net.bubbles.select(np.flatnonzero(stay)), unique_edges(triangles)
        rest = Net(bubbles, net.facets, net.facet_piece, net.two_sided, triangles, edges)
        return EllipseNet(rest, tensors[stay], known[stay])

    def tried(
        self, ellipses: EllipseNet, spacing: MetricSpacing, smoothing: AnyEllipseSmoothing, random: np.random.Generator
    ) -> Iterator[Tried]:
        """Bubbles and triangles after each attempt at those above ``mend_worse``, until none are left or gain by it."""
        net, requested = ellipses.net, spacing.unstraightened
        x, triangles = net.bubbles.x, net.triangles
        trials = Trials(net, requested, smoothing, self, random)
        cost, failures = costs(x, triangles, requested, smoothing), np.zeros(len(x), np.int64)
        state = Tried(x, requested.at(x), triangles, cost, failures)
        for _ in range(self.attempts):
            candidates = trials.candidates(state)
            if len(candidates) == 0 or state.in_vain >= IN_VAIN * self.attempts:
                break
            state = trials.attempt(state, candidates)
            yield state
