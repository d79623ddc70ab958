"""What layers lack: columns that are much lower than asked for, and why they are."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from bubblemesh.arrays import TINY, Booleans, Floats, Integers
from bubblemesh.layers.heights import gradual, layers_within
from bubblemesh.layers.pinches import SHORT
from bubblemesh.layers.room import limited_slopes
from bubblemesh.layers.strips import Strips
from bubblemesh.messages import counted, place
from bubblemesh.records import record

LOW = 0.5  # of the height that is asked for
SHORTEST = 5  # places that the report lists
LOW_COLUMNS = "{share:.2%} of the columns are less than half as high as asked for, the lowest of these with {lowest}"
REASONS = {
    "edges": (
        "{share:.2%} of the wall has no layer, as at {at}, since its edges or the spacing there are below the first "
        "height: make first smaller, or the spacing coarser"
    ),
    "spacing": (
        f"{LOW_COLUMNS}, since no layer becomes higher than the spacing: ask for fewer layers or less growth, or make "
        "the spacing coarser"
    ),
    "neighbours": (
        f"{LOW_COLUMNS}, since columns near them have few layers and neighbours differ by one at most: give these "
        "fewer by a larger first or growth, or walls of another entry beside them more"
    ),
    "first": (
        "{share:.2%} of the wall has a lower first layer than asked for, as at {at}, since it meets walls with lower "
        "ones, beside which first heights rise only gradually from column to column: make the first heights of both "
        "more alike, or the spacing along this wall finer"
    ),
    "short": (
        f"{LOW_COLUMNS}{{squeezed}}, beside an edge that is shorter than {SHORT:g} first heights: simplify, beside "
        "what is drawn, leaves such edges out"
    ),
    "others": (
        f"{LOW_COLUMNS}{{squeezed}}: columns end before they meet others, or would be farther apart than the spacing "
        "asks"
    ),
}
# Share of the wall from which on a reason is reported: beside a wall with few layers some columns are always short.
# Likewise first heights rise beside a wall with lower ones, of which the wall should have most as they are asked for.
LEAST_SHARES = {"neighbours": 0.25, "first": 0.5}
OF_WALL = "edges", "first"  # reasons whose share is that of the wall's length


@record
class LowColumns:
    """Columns on the walls of a label that are much lower than asked for, all for the same reason.

    Attributes
    ----------
    reason : str
        Key of ``REASONS``.
    share : float
        Share of the label's columns; of the length of its walls if the reason is one of ``OF_WALL``.
    layers : int
        Number of layers of the lowest one, as in `lowest`.
    at : pair of float
        Place of its foot.
    """

    reason: str
    share: float
    layers: int
    at: tuple[float, float]

    def warning(self, compressed: float) -> str:
        """Warning of these columns, beside the least factor of heights that were ``compressed``."""
        at = place(self.at)
        squeezed = f", compressed to {compressed:.2g} of its height at least" if compressed < 1 else ""
        lowest = f"{counted(self.layers, 'layer')} at {at}"
        return REASONS[self.reason].format(share=self.share, at=at, lowest=lowest, squeezed=squeezed)


def low_columns(strips: Strips, which: Integers) -> dict[str, Booleans]:
    """Masks (k,) of the columns (k,) that are much lower than asked for, by the key of their reason.

    Where layers end one by one along the wall, as they have to, columns are not low. Nor are they where layers that go
    on until they are isotropic end at about the spacing, as around a nose: there they could go on far beyond those
    beside, as columns part.
    """
    columns = strips.columns
    heights = strips.heights
    every = np.arange(len(columns))
    bare = (heights.most.count == 0) & columns.are_isotropic & ~columns.ends
    requested = np.where(columns.ends | bare, 0, heights.requested)
    beside_ends = gradual(columns, np.where(columns.ends, 0, heights.requested.max(initial=0)))
    due, by_spacing = (gradual(columns, count) for count in (requested, np.minimum(requested, heights.most.spaced)))
    all_along = _have_all(strips, due)
    passing = all_along & columns.are_isotropic & (heights.count >= heights.most.passing)
    low = ~passing & (strips.reached < LOW * columns.tops(every, due))
    due_beside_few = np.minimum(requested, beside_ends)
    excused = ~(low | bare | passing) & (strips.reached < LOW * columns.tops(every, due_beside_few))
    as_neighbours = excused | (low & all_along)
    as_spaced = low & ~as_neighbours & _have_all(strips, by_spacing)
    others = low & ~as_neighbours & ~as_spaced
    found = {"edges": bare, "spacing": as_spaced, "neighbours": as_neighbours, "others": others}
    own = {reason: mask[which] for reason, mask in found.items()}
    if own["others"].any() and _is_beside_short_edge(strips, lowest(strips, which[own["others"]])[0]["at"]):
        own["short"] = own.pop("others")
    return own


def _is_beside_short_edge(strips: Strips, at: tuple[float, float]) -> bool:
    """Whether there is a side of a drawing beside a place that is as short as features below the first layers are."""
    walls, boundary = strips.walls, strips.walls.domain.boundary
    first = np.array([ladder.first for ladder in strips.columns.ladders])[walls.ladder]
    reach = SHORT * first
    short = walls.layered & (boundary.lengths[walls.piece] < reach) & ~boundary.approximated[walls.piece]
    begin = walls.x[walls.ends[short, 0]]
    return bool((np.hypot(*(begin - at).T) < 2 * reach[short]).any())


def _have_all(strips: Strips, most: Integers) -> Booleans:
    """Mask (c,) of the columns with ``most`` (c,) layers, or all for which heights along the wall leave room.

    These change gradually, so that columns beside few layers are lower than one layer more for each would make them.
    """
    columns = strips.columns
    heights = strips.heights
    every = np.arange(len(columns))
    fitting = layers_within(columns, limited_slopes(columns, columns.tops(every, most)))
    return (heights.factor == 1) & (heights.count >= gradual(columns, np.minimum(most, fitting)))


def lacks(strips: Strips, which: Integers, low: Mapping[str, Booleans], beside: Floats) -> tuple[LowColumns, ...]:
    """The lacks of columns (k,), of which some are ``low`` (k,) for each reason.

    Their first height may be lower than asked for, too. Lengths ``beside`` (c,) are those of the wall at all columns.
    """
    found, length = list[LowColumns](), beside[which]
    for reason, mine in {**low, "first": ~strips.columns.have_own_first[which]}.items():
        of_wall = float(length[mine].sum() / max(length.sum(), TINY))
        if mine.any() and of_wall >= LEAST_SHARES.get(reason, 0.0):
            share = of_wall if reason in OF_WALL else float(mine.mean())
            found.append(LowColumns(reason, share, **lowest(strips, which[mine])[0]))
    return tuple(found)


def lowest(strips: Strips, which: Integers) -> tuple[dict[str, Any], ...]:
    """Layers and places of the lowest of the columns (k,), those with the fewest layers first, each place once."""
    count = strips.heights.count
    lowest = dict[tuple[float, ...], int]()
    for column in which[np.lexsort((strips.reached[which], count[which]))].tolist():
        lowest.setdefault(tuple(strips.columns.start[column].tolist()), int(count[column]))
        if len(lowest) == SHORTEST:
            break
    return tuple({"layers": layers, "at": at} for at, layers in lowest.items())
