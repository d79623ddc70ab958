"""What layers lack: columns that are much lower than asked for, and why they are."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.layers.heights import gradual
from bubblemesh.layers.room import spread
from bubblemesh.layers.strips import Strips
from bubblemesh.messages import counted, place
from bubblemesh.records import record

LOW = 0.5  # of the height that is asked for
SHORTEST = 5  # places that are told
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
    "others": f"{LOW_COLUMNS}: columns end before they meet others, or would be farther apart than the spacing asks",
}


@record
class Lack:
    """Columns on the walls of a label that are much lower than asked for, all for the same reason.

    Attributes
    ----------
    reason : str
        Key of ``REASONS``.
    share : float
        Share of the label's columns; of the length of its walls if the reason is ``edges``.
    layers : int
        Number of layers of the lowest one, as of `lowest`.
    at : pair of float
        Place of its foot.
    """

    reason: str
    share: float
    layers: int
    at: tuple[float, float]

    def told(self, compressed: float) -> str:
        """Warning of these columns, beside the least factor of heights that were ``compressed``."""
        at = place(self.at)
        squeezed = f", compressed to {compressed:.2g} of its height at least" if compressed < 1 else ""
        lowest = f"{counted(self.layers, 'layer')} at {at}{squeezed}"
        return REASONS[self.reason].format(share=self.share, at=at, lowest=lowest)


def low_columns(strips: Strips, which: Integers) -> dict[str, Booleans]:
    """Masks (k,) of the columns (k,) that are much lower than asked for, by the key of their reason."""
    columns, heights, every = strips.columns, strips.heights, np.arange(len(strips.columns))
    bare = (heights.most.count == 0) & columns.are_isotropic & ~columns.ends
    asked = np.where(columns.ends | bare, 0, heights.wanted)
    due, by_spacing = (gradual(columns, count) for count in (asked, np.minimum(asked, heights.most.spaced)))
    low = strips.reached < LOW * columns.tops(every, due)
    # Beside a place where the spacing lets few layers be, the height changes gradually along the wall.
    room = spread(columns, columns.tops(every, by_spacing))
    one_more = columns.tops(every, np.minimum(heights.count + 1, columns.wanted))
    as_spaced = (
        low & ~columns.are_isotropic & (heights.factor == 1) & ((heights.count >= by_spacing) | (one_more > room))
    )
    found = {"edges": bare, "spacing": as_spaced, "others": low & ~as_spaced}
    return {reason: mask[which] for reason, mask in found.items()}


def lacks(strips: Strips, which: Integers, low: Mapping[str, Booleans], beside: Floats) -> tuple[Lack, ...]:
    """What the columns (k,) lack, of which some are ``low`` (k,) for each reason.

    Lengths ``beside`` (c,) are those of the wall at all columns.
    """
    found = list[Lack]()
    for reason, mine in low.items():
        if mine.any():
            weight = beside[which] if reason == "edges" else np.ones(len(which))
            found.append(Lack(reason, float(weight[mine].sum() / weight.sum()), **lowest(strips, which[mine])[0]))
    return tuple(found)


def lowest(strips: Strips, which: Integers) -> tuple[dict[str, Any], ...]:
    """Layers and places of the lowest of the columns (k,), those with the fewest layers first, each place once."""
    count = strips.heights.count
    told = dict[tuple[float, ...], int]()
    for column in which[np.lexsort((strips.reached[which], count[which]))].tolist():
        told.setdefault(tuple(strips.columns.at[column].tolist()), int(count[column]))
        if len(told) == SHORTEST:
            break
    return tuple({"layers": layers, "at": at} for at, layers in told.items())
