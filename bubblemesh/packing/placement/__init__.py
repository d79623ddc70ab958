"""Placement: where the first bubbles are, and how chance moves them."""

from typing import Annotated, Protocol

import numpy as np
from annotated_types import Ge, Le
from typing_extensions import Doc

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.errors import COARSEN, NODE_LIMIT, NodeLimitError
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing

CLIPPED_AT = 2.0  # standard deviations: no displacement is so long that a bubble would be lost


class Placement(Protocol):
    """Placement of the first bubbles."""

    in_order: bool = False  # whether most bubbles are in order where they are placed, and need no coarser levels for it

    def fitted(self, domain: Domain, spacing: Spacing, expected_nodes: float = 0.0, halvings: int = 0) -> "Placement":
        """The placement for a domain, with what it has to know of all of it.

        If very many nodes are expected, it takes a less close look. The edges of a coarse level are halved so many
        times until they have the spacing asked for.
        """
        return self

    def shared(self, domain: Domain, spacing: Spacing, expected_nodes: float) -> "Placement":
        """The placement for the parts of a domain, with what all of them have to know of the whole."""
        return self

    def __call__(self, domain: Domain, spacing: Spacing, max_nodes: int) -> Bubbles:
        """Bubbles of a domain before any motion; LimitError if there would be many more than ``max_nodes`` of them."""

    def one_by_one(self) -> "Placement":
        """The placement, or one by which numbers of bubbles change by one and not by whole rows as the spacing does."""
        return self

    def again(self, start: Bubbles, domain: Domain, spacing: Spacing) -> Bubbles:
        """The bubbles from which a domain is packed after a coarser level or once more.

        Those of a ``start``, which such a packing leaves, or others that fit better.
        """
        return start


def require_at_most(max_nodes: int, count: int, spacing: Spacing) -> None:
    """Stop a placement by a spacing that runs away."""
    if count > 4 * max_nodes:
        raise NodeLimitError(
            f"{NODE_LIMIT}: {spacing.noun} needs more than {max_nodes} nodes: {COARSEN} or raise the limit",
            spacing.noun,
        )


@record
class Perturbation:
    """Small displacement of the interior bubbles, so that no run rests on a symmetry of its start."""

    seed: Annotated[int, Ge(0), Doc("seed of the random numbers")] = 0
    jitter: Annotated[float, Ge(0), Le(0.1), Doc("standard deviation of the initial displacement, in spacings")] = 0.01

    def generator(self) -> np.random.Generator:
        """Generator of the random numbers of a run."""
        return np.random.default_rng(self.seed)

    def __call__(self, bubbles: Bubbles, spacing: Spacing, random: np.random.Generator) -> Bubbles:
        """The bubbles after the displacement."""
        moved = displaced(bubbles, bubbles.interior, self.jitter, random)
        return moved.moved(moved.x, spacing(moved.x))


def displaced(
    bubbles: Bubbles, which: slice | Booleans | Integers, amplitude: Floats | float, random: np.random.Generator
) -> Bubbles:
    """The bubbles with k of them moved at random: standard deviations ``amplitude`` (k,) in units of their spacing."""
    x, scale = bubbles.x.copy(), amplitude * bubbles.d[which]
    moves = random.standard_normal((len(scale), 2)).clip(-CLIPPED_AT, CLIPPED_AT)
    x[which] = x[which] + scale[:, None] * moves
    return bubbles.moved(x)
