"""Smoothing: the finished packing is moved to triangles of the best shape and edges as long as the spacing."""

from collections.abc import Callable
from typing import Annotated, ClassVar

import numpy as np
from annotated_types import Ge, Gt, Le
from typing_extensions import Doc

from bubblemesh.arrays import Booleans, Floats, Integers, any_of_rows
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.newton import Metrics, Newton, SmoothingTerms
from bubblemesh.kernels.shapes import WORST, Descent, eta
from bubblemesh.meshes.quality import REGULAR_VALENCE
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.confinement import Sliding
from bubblemesh.packing.net import Net, connect_inside
from bubblemesh.packing.newton import axes_with, independent_groups, metrics_around, side_weight
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing

MOMENTUM = 0.8
MOST_SMOOTHING_MOVE = 0.1  # spacings in a step
WORSE = 1.04  # shape measure of a triangle from which on the last pass is for it
LAST_WEIGHT, LAST_SWEEPS = 2.0, 5  # times the weight of lengths in the last pass, and times that it moves a node


@record
class NoSmoothing:
    """No smoothing: the bubbles relax once more, and again while some are lost at the boundary."""

    relaxing: ClassVar[bool] = True  # whether a packing ends with relaxations
    passes: ClassVar[int] = 0
    shape_steps: ClassVar[int] = 0

    def __call__(self, net: Net, domain: Domain, spacing: Spacing) -> Net:
        """The net as it is."""
        return net

    def of_worst(self, net: Net, domain: Domain, spacing: Spacing) -> Net:
        """The net as it is."""
        return net

    def moved(self, net: Net, domain: Domain, free: Booleans) -> Bubbles:
        """The bubbles of a net as they are."""
        return net.bubbles


@record
class SmoothingPasses:
    """Parameters of smoothing, of circles or of ellipses."""

    passes: Annotated[int, Ge(0), Le(1000), Doc("passes of the smoothing, with population control in between")] = 3
    shape_steps: Annotated[int, Gt(0), Le(1000), Doc("steps of a pass")] = 10
    spacing_weight: Annotated[float, Ge(0), Le(20), Doc("weight of edges' lengths beside triangles' shapes")] = 7.0


@record
class Smoothing(SmoothingPasses):
    """Gradient descent, with momentum, on the shapes of the triangles and the lengths of the edges.

    It lessens the sum over triangles of eta^8 / 2 + spacing_weight * the sum over edges of (l/d - 1)^2. The shape
    measure eta = (a^2 + b^2 + c^2) / (4 sqrt(3) A) is 1 for an equilateral triangle; its eighth power makes
    the worst triangles count most. Nearly all of these are at defects, bubbles without six neighbours, or on the
    boundary: triangles there count ``defect_weight`` times. Bubbles on the boundary slide along it, corners stay.

    The last pass, around bad triangles alone, is Newton's method on eta^32 / 8 in place of eta^8 / 2.

    References
    ----------
    L. Freitag, P. Knupp, "Tetrahedral mesh improvement via optimization of the element condition number",
    Int. J. Numer. Meth. Eng. 53 (2002), for the measure.
    """

    relaxing: ClassVar[bool] = False

    shape_step: Annotated[float, Gt(0), Le(0.1), Doc("length of a step, in units where the spacing is 1")] = 0.015
    defect_weight: Annotated[
        float, Ge(1), Le(10), Doc("weight of triangles at bubbles without six neighbours, as those on the boundary")
    ] = 2.0

    def __call__(self, net: Net, domain: Domain, spacing: Spacing) -> Net:
        """Net after one pass, connected anew."""
        return _accepted(net, domain, spacing, lambda free: self.moved(net, domain, free))

    def of_worst(self, net: Net, domain: Domain, spacing: Spacing) -> Net:
        """Net after the last pass, for the worst triangles, connected anew; as it is if there are no passes."""
        if self.passes == 0:
            return net
        return _accepted(net, domain, spacing, lambda free: self._worst_moved(net, domain, spacing, free))

    def moved(self, net: Net, domain: Domain, free: Booleans) -> Bubbles:
        """The bubbles of a net after one pass in which only those that are ``free`` (n,) move.

        Those on the boundary go along its tangents where they were, and are put back on it in the end.
        """
        bubbles, d = net.bubbles, net.bubbles.d
        sliding = Sliding(domain.boundary, bubbles)
        free = free.copy()
        free[bubbles.sliding] &= ~domain.tied[bubbles.piece]
        defects = net.valence != REGULAR_VALENCE
        counts = np.where(any_of_rows(defects[net.triangles]), self.defect_weight, 1.0)
        # What is pulled by triangles that count more goes shorter ways, or it would overshoot.
        scale = np.where(free, d * d, 0.0) / np.where(net.dilated(defects), self.defect_weight, 1.0)
        weights = self.spacing_weight, MOMENTUM, self.shape_step
        groups = bubbles.corners, len(bubbles.piece)
        descent = Descent(net.triangles, counts, net.edges, d, scale, MOST_SMOOTHING_MOVE * d, *groups, *weights)
        x = descent.moved(bubbles.x, sliding.tangents, self.shape_steps)
        sliding.follow(x)
        return sliding.bubbles_at(x, d)

    def _worst_moved(self, net: Net, domain: Domain, spacing: Spacing, free: Booleans) -> Bubbles:
        """The bubbles of a net after Newton's method, in which those of bad triangles that are ``free`` (n,) move."""
        bubbles, sliding, moving = net.bubbles, Sliding(domain.boundary, net.bubbles), np.zeros(len(net.bubbles), bool)
        moving[net.triangles[eta(bubbles.x, net.triangles) > WORSE]] = True
        moving &= free
        moving[bubbles.sliding] &= ~domain.tied[bubbles.piece]
        if not moving.any():
            return bubbles
        near, rows = np.unique(net.triangles[any_of_rows(moving[net.triangles])], return_inverse=True)
        x, triangles, moving = bubbles.x[near], rows.reshape(-1, 3), moving[near]
        inside, own = _metrics(x, triangles, bubbles.d[near], moving, spacing)
        slides = slice(*np.searchsorted(near, [bubbles.corners, bubbles.boundary_count]))
        axes = axes_with(own, slides, sliding.tangents[near[slides] - bubbles.corners])
        terms = SmoothingTerms(LAST_WEIGHT * side_weight(self.spacing_weight), worst=True, bend=np.inf)
        newton = Newton(triangles, inside, own, axes, independent_groups(moving, triangles), terms)
        places = bubbles.x.copy()
        places[near] = newton.moved(x, LAST_SWEEPS)
        sliding.follow(places)
        return sliding.bubbles_at(places, bubbles.d)


def _accepted(net: Net, domain: Domain, spacing: Spacing, move: Callable[[Booleans], Bubbles]) -> Net:
    """Net of the bubbles as a function moves those that are free (n,); as it was if its worst triangle gets worse.

    Where two walls are near, bubbles that slide may make boundary edges that cross, or next to each other: then
    the boundary stays as it is.
    """
    allowed = max(float(eta(net.bubbles.x, net.triangles).max()), WORST)
    for held in (net.bubbles.corners, net.bubbles.boundary_count):
        try:
            smoothed = connect_inside(move(np.arange(len(net.bubbles)) >= held), domain, spacing, net)
        except GeometryError:
            continue
        if eta(smoothed.bubbles.x, smoothed.triangles).max() <= allowed:
            return smoothed
    return net


def _metrics(x: Floats, triangles: Integers, d: Floats, moving: Booleans, spacing: Spacing) -> tuple[Metrics, Metrics]:
    """The metrics, as of `metrics_around`, in which an edge as long as the spacing has the length 1."""

    def roots_at(places: Floats) -> Floats:
        return _roots(spacing.extended(places))

    inside = roots_at(x[triangles].mean(axis=1))
    return metrics_around(x, triangles, inside, _roots(d), moving, roots_at)


def _roots(d: Floats) -> Floats:
    """Roots (k, 3), as of `kernels.tensors.roots`, of metrics by spacings d (k,)."""
    return np.column_stack([1 / d, np.zeros(len(d)), 1 / d])
