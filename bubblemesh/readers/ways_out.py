"""Advice on curves that do not close: keys that make rings of them, tried before they are named."""

from collections.abc import Callable, Sequence

import numpy as np

from bubblemesh.messages import counted, just_above
from bubblemesh.readers.features import CompoundCurve
from bubblemesh.readers.rings import Joining, extent, meeting, to_next

SMALL = 0.01  # of the drawing's size: wider gaps are no slips


def ways_out(curves: Sequence[CompoundCurve], joining: Joining, rings_by: Callable[[Joining], int]) -> str:
    """What to do about curves that do not close by a ``joining``, with the keys that help.

    ``rings_by`` tells how many rings there are by another joining, 0 if it does not help either.
    """
    width = _gap_to_close(curves, joining)
    ways = list[str]()
    join = None if width is None else joining._replace(reach=float(width))
    if join and rings_by(join):
        ways.append(f"set join: {width} to close the gaps")
    skipped = 0 if joining.skip else rings_by(joining._replace(skip=True))
    if join and not ways and not joining.skip and (more := rings_by(join._replace(skip=True))) > skipped:
        ways.append(f"set join: {width} and open: skip to close what gaps of that width part ({_stay(more)})")
    if skipped:
        ways.append(f"set open: skip to leave out what forms no ring ({_stay(skipped)})")
    return "; or ".join(ways) or "draw what is missing and remove double lines, or choose by layer or feature"


def _stay(rings: int) -> str:
    return f"{counted(rings, 'ring')} stay{'s' if rings == 1 else ''}"


def _gap_to_close(curves: Sequence[CompoundCurve], joining: Joining) -> str | None:
    """A length above the gaps between loose ends that are narrow beside the drawing and beside other gaps."""
    open_ = [curve for curve in curves if curve.start != curve.end]
    if not open_:
        return None
    ends, node = meeting(open_, joining.reach)
    loose = ends[np.bincount(node)[node] == 1]
    if len(loose) < 2:
        return None
    gaps, widest = np.sort(to_next(loose)), SMALL * extent(curves)
    narrow = gaps[gaps <= widest]
    if len(narrow) == 0:
        return None
    steps = np.append(narrow[1:], max(widest, narrow[-1])) / narrow
    last = len(narrow) - 1 if len(narrow) == len(gaps) else int(steps.argmax())
    return just_above(float(narrow[last]))
