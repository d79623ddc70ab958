"""Advice on curves that do not close: keys that make rings of them, tried before they are named."""

from collections.abc import Callable, Sequence

import numpy as np

from bubblemesh.messages import counted, just_above, shown
from bubblemesh.readers.features import CompoundCurve, Feature, vertices_of
from bubblemesh.readers.rings import Joining, extent, meeting, to_next

SMALL = 0.05  # of the drawing's size: wider gaps are no slips
MOST_LAYERS = 10  # that one message lists

RingsBy = Callable[[Sequence[Feature], Joining], int]  # number of rings that features give, 0 if they do not close


def ways_out(
    used: Sequence[Feature], features: Sequence[Feature], joining: Joining, rings_by: RingsBy, whole: bool
) -> str:
    """Advice on the ``used`` features, whose curves do not close by a ``joining``: keys that help.

    Of all features, the layers that close by themselves are named, or else the features, if the ``whole`` of the file
    or its layers is there, so that they can be chosen by number.
    """
    ways = _other_joinings(used, joining, rings_by)
    closing = _layers_that_close(features, joining, rings_by)
    if not closing and whole:
        closing = _features_that_close(features, joining, rings_by)
    advice = "; or ".join(ways) or "draw what is missing and remove double lines, or choose a layer or feature"
    return f"{advice}{closing}"


def _other_joinings(used: Sequence[Feature], joining: Joining, rings_by: RingsBy) -> list[str]:
    """Keys by which the features close."""
    width = _gap_to_close([curve for one in used for curve in one.curves], joining)
    ways = list[str]()
    join = None if width is None else joining._replace(reach=float(width))
    if join and rings_by(used, join):
        ways.append(f"set join: {width}, which closes all gaps")
    if joining.skip:
        return ways
    skipped = rings_by(used, joining._replace(skip=True))
    if join and not ways and (more := rings_by(used, join._replace(skip=True))) > skipped:
        ways.append(f"set join: {width} and open: skip, which close gaps and leave out other curves ({_left(more)})")
    if skipped:
        ways.append(f"set open: skip, which leaves out what forms no ring ({_left(skipped)})")
    return ways


def _left(rings: int) -> str:
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
    gaps, widest = np.sort(to_next(loose)), SMALL * extent(open_)
    narrow = gaps[gaps <= widest]
    if len(narrow) == 0:
        return None
    steps = np.append(narrow[1:], widest) / narrow
    last = len(narrow) - 1 if len(narrow) == len(gaps) else int(steps.argmax())
    return just_above(float(narrow[last]))


def _layers_that_close(features: Sequence[Feature], joining: Joining, rings_by: RingsBy) -> str:
    """Advice that names the layers which bound areas by themselves, where there are several layers."""
    layers: dict[str, list[Feature]] = {}
    for one in features:
        if one.layer is not None:
            layers.setdefault(one.layer, []).append(one)
    closing = [layer for layer, ones in layers.items() if len(layers) > 1 and rings_by(ones, joining)]
    if not closing:
        return ""
    more = f" and {len(closing) - MOST_LAYERS} more" if len(closing) > MOST_LAYERS else ""
    named = ", ".join(shown(layer, 40) for layer in closing[:MOST_LAYERS])
    return f"; layers that close by themselves: {named}{more}: choose by layer: {shown(closing[0], 40)}"


def _features_that_close(features: Sequence[Feature], joining: Joining, rings_by: RingsBy) -> str:
    """Advice that names the features which bound areas by themselves, the widest of them first."""
    found = [k for k, one in enumerate(features) if len(features) > 1 and one.bounds and rings_by([one], joining)]
    if not found:
        return ""
    found.sort(key=lambda k: -float(np.ptp(vertices_of([features[k]]), axis=0).max()))
    more = f" and {len(found) - MOST_LAYERS} more" if len(found) > MOST_LAYERS else ""
    named = ", ".join(features[k].name for k in found[:MOST_LAYERS])
    return f"; what closes by itself: {named}{more}: choose by feature: {found[0]}"
