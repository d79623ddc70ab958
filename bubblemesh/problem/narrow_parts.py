"""Narrow parts of a domain: the spacing for a packing fits across them, as long as that takes few nodes."""

from typing import NamedTuple

from bubblemesh.errors import LimitError
from bubblemesh.geometry.narrow_parts import FacingWalls
from bubblemesh.spacing.cover import Cover
from bubblemesh.spacing.rules.gap_sources import NarrowPlace
from bubblemesh.spacing.rules.grading import LimitedSpacing
from bubblemesh.spacing.rules.rules import Rules, limited_for_packing_across_sides
from bubblemesh.spacing.rules.sources import Sources
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.survey import ESTIMATE, ideal_nodes

MOST_TIMES, MORE = 4.0, 1000  # the nodes without it, and nodes beside: what narrow parts may lead to
CUTS = (1.0, 0.2, 0.04)  # of these nodes, that narrow parts alone may take; they make the spacing fine beside them too


class Unfilled(NamedTuple):
    """The spacing of a packing that knows nothing of narrow parts yet, and what it was made of."""

    cover: Cover  # of the domain
    requested: Spacing  # whose sizes across narrow parts count
    after_periodic: LimitedSpacing
    for_packing: LimitedSpacing
    expected_nodes: float


class FilledSpacing(NamedTuple):
    """The spacing of a packing that fits across narrow parts."""

    spacing: LimitedSpacing
    expected_nodes: float
    gaps: Sources  # that made it finer
    left_out: NarrowPlace | None  # the narrowest part that would take too many nodes


def with_narrow_parts_filled(walls: FacingWalls, rules: Rules, before: Unfilled, max_nodes: int) -> FilledSpacing:
    """The spacing for a packing, made to fit across narrow parts at least once, unless the rules say how often.

    Parts whose filling takes many times the nodes are left as they are, the narrowest first.
    """
    as_it_is = FilledSpacing(before.for_packing, before.expected_nodes, Sources.none(), None)
    most = min(int(MOST_TIMES * before.expected_nodes) + MORE, max_nodes)
    left_out: NarrowPlace | None = None
    for cut in CUTS:
        gaps, narrowest = rules.affordable_gaps(walls, before.for_packing.spacing, before.requested, cut * most)
        left_out = narrowest or left_out
        if len(gaps) == 0:
            break
        filled = limited_for_packing_across_sides(
            walls.domain, before.after_periodic, gaps, rules.packing_growth, before.for_packing.ground
        )
        try:
            return FilledSpacing(
                filled, ideal_nodes(walls.domain, filled.spacing, most, ESTIMATE, before.cover), gaps, left_out
            )
        except LimitError:
            finest = gaps.sizes.argmin()
            x, y = gaps.points[finest].tolist()
            left_out = left_out or NarrowPlace((x, y), float(gaps.sizes[finest]))
    return as_it_is._replace(left_out=left_out)
