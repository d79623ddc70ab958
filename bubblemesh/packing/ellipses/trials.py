"""Trials: at bad triangles bubbles leave, come or are displaced, and stay so where triangles get better by it.

Forces and smoothing find the best places of bubbles for the neighbours that they have, trials find other neighbours.
"""

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.kernels.ellipse_motion import moved
from bubblemesh.kernels.tensors import roots, unmapped
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.quality import doubled_areas
from bubblemesh.meshes.tensors import area_sizes, determinants, edge_lengths
from bubblemesh.packing.ellipses.net import EllipseNet
from bubblemesh.packing.ellipses.patches import PatchNet, patches_around
from bubblemesh.packing.ellipses.population import AREA_OF_TRIANGLE
from bubblemesh.packing.ellipses.smoothing import (
    AnyEllipseSmoothing,
    better_shapes,
    costs_by,
    roots_by,
    smoothed_places,
)
from bubblemesh.packing.mending import MendingAttempts
from bubblemesh.packing.net import Net
from bubblemesh.packing.newton import metrics_around
from bubblemesh.packing.placement import CLIPPED_AT
from bubblemesh.records import record
from bubblemesh.spacing.metric.metric import MetricSpacing

RINGS = 1, 2  # of bubbles around a bad triangle: small patches, of which there are many at once, and larger ones
PRICE = 2.0  # what triangles have to cost less for one bubble more, and may cost more for one less
SURELY_LESS = 1e-3  # costs that are less by more than rounding
AGAIN = 0.8  # of the chance to be tried, of a triangle for each trial in vain at its nodes
SMALL, LARGE = 0.8, 1.2  # triangles, by their areas in the metric and in terms of perfect ones
VALENCE_NOISE, LENGTH_NOISE = 0.6, 0.2  # in the choice of the bubble that leaves, of the edge to which one comes
CHANCES = np.array([[0.8, 0.05], [0.25, 0.25], [0.05, 0.9]])  # at small, other and large ones: a bubble leaves, comes


@record
class Tried:
    """Bubbles and triangles as trials have left them so far."""

    x: Floats  # (n, 2)
    tensors: Floats  # (n, 3): of the metric that is asked for
    triangles: Integers  # (t, 3)
    costs: Floats  # (t,)
    failures: Integers  # (n,): trials in vain of triangles there
    came: int = 0  # bubbles that have come, those that have left again too
    in_vain: int = 0  # last attempts, in a row, after which nothing stayed so

    def within(self, net: Net, spacing: MetricSpacing) -> EllipseNet:
        """The bubbles as tried so far, within the boundary of a net, with the tensors of a spacing."""
        fixed, tensors = net.bubbles.boundary_count, spacing.at(self.x)
        shell, d = net.bubbles.select(np.arange(fixed)), area_sizes(tensors)
        bubbles, (edges, _) = shell.append(self.x[fixed:], d[fixed:]), unique_edges(self.triangles)
        tried_net = Net(bubbles, net.facets, net.facet_piece, net.two_sided, self.triangles, edges)
        return EllipseNet(tried_net, tensors, self.x)


@record
class Trials:
    """Trials within the boundary of a net."""

    net: Net
    spacing: MetricSpacing
    smoothing: AnyEllipseSmoothing
    mending: MendingAttempts
    random: np.random.Generator

    def candidates(self, state: Tried) -> Integers:
        """Rows (c,) of bad triangles, by chance: sooner those that are worse, later where trials were in vain."""
        bad = np.flatnonzero(state.costs > self.mending.mend_worse**4 - 1)
        chance = np.sqrt(state.costs[bad]) * AGAIN ** state.failures[state.triangles[bad]].sum(axis=1)
        return bad[np.argsort(-chance * self.random.random(len(bad)), kind="stable")]

    def attempt(self, state: Tried, candidates: Integers) -> Tried:
        """The state after trials at some of the candidates (c,), whose patches are apart."""
        edges, _ = unique_edges(state.triangles)
        rings, given = int(self.random.choice(RINGS)), (state.x, state.tensors, state.triangles, edges)
        chosen, within, patches = patches_around(candidates, rings, self.net, *given)
        corners, count = state.triangles[chosen], len(chosen)
        before, owner = _sums(state.costs[within], patches.owner, count), np.full(len(within), -1)
        owner[within] = patches.owner
        # 1. Bubbles leave, come and are displaced; what is around them is smoothed.
        patches = self.smoothed(self.changed(patches, corners, state, edges))
        # 2. Patches stay so whose triangles cost less.
        patches, inside = self.measured(patches)
        cost = costs_by(patches.x, patches.triangles, inside, roots(patches.tensors), self.smoothing)
        better = _sums(cost, patches.owner, count) < before - SURELY_LESS
        cost, patches = cost[better[patches.owner]], patches.select(better)
        # 3. The others are as they were.
        n, came, stays = len(state.x), int((patches.nodes < 0).sum()), ~np.append(better, False)[owner]
        nodes = np.where(patches.nodes < 0, n - 1 + np.cumsum(patches.nodes < 0), patches.nodes)
        x, tensors = (np.append(part, np.zeros((came, part.shape[1])), axis=0) for part in (state.x, state.tensors))
        x[nodes], tensors[nodes] = patches.x, patches.tensors
        failures = np.append(state.failures, np.zeros(came, np.int64))
        failures[corners] += 1
        failures[corners[better]] = 0
        triangles = np.concatenate([state.triangles[stays], nodes[patches.triangles]])
        used = np.arange(len(x)) < self.net.bubbles.boundary_count
        used[triangles] = True
        numbered = (np.cumsum(used) - 1)[triangles]
        now = x[used], tensors[used], numbered, np.append(state.costs[stays], cost), failures[used]
        return Tried(*now, state.came + came, 0 if better.any() else state.in_vain + 1)

    def changed(self, patches: PatchNet, corners: Integers, state: Tried, edges: Integers) -> PatchNet:
        """Patches in which a bubble has left, one has come, or the free ones are displaced.

        One leaves sooner where the triangle in the middle, with these corners (k, 3), is small in the metric, and it is
        a corner with few neighbours; one comes sooner where that is large, to the longest side.
        """
        x, number, rows = state.x[corners], np.full(len(state.x), -1), np.arange(len(corners))
        number[patches.nodes] = np.arange(len(patches.nodes))
        corners_there = number[corners]
        area = np.sqrt(determinants(state.tensors[corners].mean(axis=1))) * doubled_areas(x) / 2
        leaves, comes = CHANCES[np.digitize(area / AREA_OF_TRIANGLE, [SMALL, LARGE])].T
        chance, noise = self.random.random(len(corners)), self.random.standard_normal((len(corners), 3))
        leaving, coming = chance < leaves, chance > 1 - comes
        # 1. A corner leaves.
        valence = np.bincount(edges.ravel(), minlength=len(state.x))[corners]
        few = np.where(patches.free[corners_there], valence + VALENCE_NOISE * noise, np.inf).argmin(axis=1)
        gone = np.zeros(len(patches.x), bool)
        gone[corners_there[rows, few][leaving]] = True
        # 2. A side is halved.
        sides = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2)
        lengths = edge_lengths(state.x, state.tensors, sides.reshape(-1, 2)).reshape(-1, 3)
        long = (lengths + LENGTH_NOISE * noise).argmax(axis=1)
        halved = number[sides[rows, long][coming]]
        inner = patches.free[halved].any(axis=1)
        changed = patches.changed(gone & patches.free, halved[inner])
        # 3. Elsewhere bubbles are displaced.
        displaced = np.flatnonzero(changed.free & ~(leaving | coming)[changed.patch])
        random = self.random.standard_normal((len(displaced), 2)).clip(-CLIPPED_AT, CLIPPED_AT)
        moves = np.zeros_like(changed.x)
        moves[displaced] = unmapped(roots(changed.tensors[displaced]), self.mending.mend_amplitude * random)
        return changed._replace(x=moved(changed.x, moves, changed.triangles)[0])

    def smoothed(self, patches: PatchNet) -> PatchNet:
        """Patches after flips and smoothing."""
        patches, around = self.measured(patches)
        x, free, own_roots = patches.x, patches.free, roots(patches.tensors)
        triangles, around = better_shapes(x, patches.triangles, patches.facets, self.spacing, around)
        inside, own = metrics_around(x, triangles, around, own_roots, free, roots_by(self.spacing))
        places = smoothed_places(x, triangles, free, inside, own, own.axes, self.smoothing)
        return patches._replace(x=places, triangles=triangles)

    def measured(self, patches: PatchNet) -> tuple[PatchNet, Floats]:
        """Patches with the tensors where bubbles are now, and roots (t, 3) of the metric at the centroids."""
        free, tensors, count = np.flatnonzero(patches.free), patches.tensors.copy(), len(patches.triangles)
        centroids = patches.x[patches.triangles].mean(axis=1)
        found = self.spacing.at(np.concatenate([centroids, patches.x[free]]))
        tensors[free] = found[count:]
        return patches._replace(tensors=tensors), roots(found[:count])


def _sums(costs: Floats, owner: Integers, count: int) -> Floats:
    """Costs (count,) of the triangles (t,) of each owner with the price of its bubbles; infinite without triangles."""
    triangles = np.bincount(owner, minlength=count)  # two of each bubble
    return np.where(triangles > 0, np.bincount(owner, costs, count) + PRICE / 2 * triangles, np.inf)
