"""Placement: where the first bubbles are."""

from typing import Protocol

from bubblemesh.errors import LimitError
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.spacing.spacing import Spacing


class Placement(Protocol):
    """Where the first bubbles are."""

    def __call__(self, domain: Domain, spacing: Spacing, max_nodes: int) -> Bubbles:
        """Bubbles of a domain before any motion.

        Raises
        ------
        LimitError
            If there would be many more than ``max_nodes`` of them.
        """


def require_at_most(max_nodes: int, count: int) -> None:
    """Stop a placement that runs away."""
    if count > 4 * max_nodes:
        raise LimitError(
            f"limits.max_nodes: the spacing needs more than {max_nodes} nodes: coarsen it or raise the limit"
        )
