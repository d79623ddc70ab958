"""A domain with boundary layers: columns on its walls, and the rest beside them."""

from collections.abc import Sequence

from bubblemesh.errors import NODE_LIMIT, CaseError, NodeLimitError, at_key
from bubblemesh.geometry.domain import Domain
from bubblemesh.layers.fitting import fitted_strips
from bubblemesh.layers.heights import most_layers
from bubblemesh.layers.ladder import Ladder
from bubblemesh.layers.placement import columns_on
from bubblemesh.layers.rest import Rest
from bubblemesh.layers.walls import Walls
from bubblemesh.packing.placement.diffusion import boundary_bubbles
from bubblemesh.spacing.spacing import Spacing


class HighLayerError(CaseError):
    """A first layer that is higher than the spacing across all of its walls, which is at most ``spacing``."""

    ladder: Ladder
    spacing: float


def layered(domain: Domain, requested: Spacing, spacing: Spacing, ladders: Sequence[Ladder], max_nodes: int) -> Rest:
    """Layers on the walls of a domain, up to the ``requested`` spacing, and what they leave of it.

    The nodes of the walls are placed by a ``spacing`` that may be finer.

    HighLayerError if a first layer is higher than the spacing across all of its walls, LimitError if there would be
    more than ``max_nodes`` nodes.
    """
    walls = Walls.of(domain, boundary_bubbles(domain, spacing), requested, ladders)
    for number, ladder in enumerate(ladders):
        _require_walls(walls, number, ladder)
    columns = columns_on(walls, ladders)
    most = most_layers(columns, requested)
    if (nodes := int(most.count.sum())) > max_nodes:
        raise NodeLimitError(
            f"layers: they may take {nodes} nodes, and the limit is {max_nodes}: coarsen the spacing on "
            f"the walls, ask for fewer layers, or raise {NODE_LIMIT}"
        )
    return Rest.of(fitted_strips(columns, walls, most))


def _require_walls(walls: Walls, number: int, ladder: Ladder) -> None:
    """Check that each label has walls for layers, and a spacing that is not below the first height everywhere."""
    boundary = walls.domain.boundary
    mine = walls.ladder == number
    found = {boundary.labels[k] for k in boundary.label[walls.piece[mine]].tolist()}
    with at_key(*ladder.key):
        for label in ladder.labels:
            if label not in found:
                raise CaseError(f"{label!r} is not a side of the region {ladder.region!r}")
        spacing = float(walls.d[walls.ends[mine]].max())
        if ladder.first > spacing:
            error = HighLayerError(
                f"the first layer, {ladder.first:.4g} high, is higher than the spacing across these walls, which is "
                f"{spacing:.4g} at most: make it lower, by first or by thickness and count, or the spacing larger"
            )
            error.ladder, error.spacing = ladder, spacing
            raise error
