"""Advice on curves that do not close: keys that make rings of them, each tried before it is advised."""

import json
import re
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from bubblemesh.messages import counted, just_above, shown
from bubblemesh.readers.features import HIDDEN, CompoundCurve, Feature, vertices_of
from bubblemesh.readers.rings.joining import Joining, longer_side, meeting, to_next

SMALL = 0.05  # of the drawing's size: wider gaps are not slips of the pen
MOST_LAYERS_LISTED = 10  # that one message lists
# A name that needs no quotes in YAML.
PLAIN = re.compile(r"(?!(true|false|yes|no|on|off|null|nan|inf|[yn])$)[^\W\d_][\w-]*( [\w-]+)*", re.IGNORECASE)


class JoinOutcome(NamedTuple):
    """Outcome of joining some features."""

    rings: int
    choice: bool  # whether one of several areas has to be chosen, the largest
    sound: bool  # whether the rings of the areas that are taken do not cross

    @property
    def more(self) -> str:
        """The further keys that are needed."""
        part, repair = " and part: largest" * self.choice, " and repair: true" * (not self.sound)
        return f"{part}{repair}"

    @property
    def rank(self) -> int:
        """Number of these further keys."""
        return self.choice + (not self.sound)


JoinTrial = Callable[[Sequence[Feature], Joining], JoinOutcome | None]  # outcome of features, None if they do not close


class _Way(NamedTuple):
    """Advice on a key, and the number of further keys that it needs."""

    text: str
    rank: int


def ways_out(
    used: Sequence[Feature], features: Sequence[Feature], joining: Joining, trial: JoinTrial, whole: bool
) -> str:
    """Advice on features whose curves do not close, with the advice that needs the fewest keys first.

    Parameters
    ----------
    used
        The features whose curves do not close.
    features
        All features, of which layers, or else single features, that close by themselves are named.
    joining
        The rules by which they were joined.
    trial
        Function that shows whether features close by other rules.
    whole
        Whether these are all features of the file or of its layers, so that features can be chosen by number.
    """
    ways = _other_joinings(used, joining, trial)
    closing = _layers_that_close(features, joining, trial)
    if closing is None and whole:
        closing = _features_that_close(features, joining, trial)
    advice = "; or ".join(way.text for way in sorted(ways, key=lambda way: way.rank))
    if not ways:
        advice = "draw what is missing and remove double lines, or choose a layer or feature"
    if closing is None:
        return advice
    simpler = ways and closing.rank < min(way.rank for way in ways)
    return f"{closing.text}; or {advice}" if simpler else f"{advice}; {closing.text}"


def _other_joinings(used: Sequence[Feature], joining: Joining, trial: JoinTrial) -> list[_Way]:
    """Advice on keys of joining with which the features close."""
    width = _gap_to_close([curve for one in used for curve in one.curves], joining)
    ways = list[_Way]()
    join = None if width is None else joining._replace(reach=float(width))
    if join and (found := trial(used, join)):
        ways.append(_Way(f"set join: {width}{found.more}, which closes all gaps", found.rank))
    if joining.skip:
        return ways
    skipped = trial(used, joining._replace(skip=True))
    more = trial(used, join._replace(skip=True)) if join and not ways else None
    if more and (skipped is None or more.rings > skipped.rings):
        keys = f"set join: {width} and open: skip{more.more}"
        ways.append(_Way(f"{keys}, which close gaps and leave out other curves ({_left(more)})", more.rank))
    if skipped:
        keys = f"set open: skip{skipped.more}"
        ways.append(_Way(f"{keys}, which leaves out what forms no ring ({_left(skipped)})", skipped.rank))
    return ways


def _left(found: JoinOutcome) -> str:
    return f"{counted(found.rings, 'ring')} stay{'s' if found.rings == 1 else ''}"


def _gap_to_close(curves: Sequence[CompoundCurve], joining: Joining) -> str | None:
    """A length just above the narrow gaps between loose ends, compared with the drawing and other gaps; else None."""
    open_ = [curve for curve in curves if curve.start != curve.end]
    if not open_:
        return None
    ends, node = meeting(open_, joining.reach)
    loose = ends[np.bincount(node)[node] == 1]
    if len(loose) < 2:
        return None
    gaps, widest = np.sort(to_next(loose)), SMALL * longer_side(open_)
    narrow = gaps[gaps <= widest]
    if len(narrow) == 0:
        return None
    steps = np.append(narrow[1:], widest) / narrow
    last = len(narrow) - 1 if len(narrow) == len(gaps) else int(steps.argmax())
    return just_above(float(narrow[last]))


def _layers_that_close(features: Sequence[Feature], joining: Joining, trial: JoinTrial) -> _Way | None:
    """Advice that names the layers which bound areas by themselves, if there are several layers.

    It names layers that bound one area together, if necessary without the outermost ones.
    """
    layers: dict[str, list[Feature]] = {}
    for one in features:
        if one.layer is not None and one.spare != HIDDEN:
            layers.setdefault(one.layer, []).append(one)
    found = {layer: trial(ones, joining) for layer, ones in layers.items() if len(layers) > 1}
    closing = {layer: outcome for layer, outcome in found.items() if outcome is not None}
    if not closing:
        return None
    more = f" and {len(closing) - MOST_LAYERS_LISTED} more" if len(closing) > MOST_LAYERS_LISTED else ""
    named = ", ".join(shown(layer, 40) for layer in [*closing][:MOST_LAYERS_LISTED])
    widest = sorted(closing, key=lambda layer: -_extent(layers[layer]))
    together = (widest[k:] for k in range(min(len(widest) - 1, MOST_LAYERS_LISTED)))
    for some in together:
        outcome = trial([one for one in features if one.layer in some], joining)
        if outcome is not None and outcome.rank == 0:
            key = f"layer: [{', '.join(map(_value, sorted(some, key=[*closing].index)))}]"
            break
    else:
        best = min(closing, key=lambda layer: closing[layer].rank)
        key, outcome = f"layer: {_value(best)}", closing[best]
    advice = f"layers that close by themselves: {named}{more}: choose by {key}{outcome.more}"
    return _Way(advice, outcome.rank)


def _features_that_close(features: Sequence[Feature], joining: Joining, trial: JoinTrial) -> _Way | None:
    """Advice that names the features which bound areas by themselves, the widest of them first."""
    several = len(features) > 1
    tried = {k: trial([one], joining) for k, one in enumerate(features) if several and one.bounds}
    found = {k: outcome for k, outcome in tried.items() if outcome is not None}
    if not found:
        return None
    order = sorted(found, key=lambda k: -_extent([features[k]]))
    more = f" and {len(found) - MOST_LAYERS_LISTED} more" if len(found) > MOST_LAYERS_LISTED else ""
    named = ", ".join(features[k].name for k in order[:MOST_LAYERS_LISTED])
    best = min(order, key=lambda k: found[k].rank)
    advice = f"what closes by itself: {named}{more}: choose by feature: {best}{found[best].more}"
    return _Way(advice, found[best].rank)


def _extent(features: Sequence[Feature]) -> float:
    return float(np.ptp(vertices_of(features), axis=0).max())


def _value(name: str) -> str:
    """A name as the value of a key."""
    return shown(name, 40) if PLAIN.fullmatch(name) else json.dumps(shown(name, 40), ensure_ascii=False)
