"""What of the chosen features of a file bounds areas, and what is left out beside it."""

from collections.abc import Sequence
from functools import reduce
from operator import add
from typing import NamedTuple

import numpy as np

from bubblemesh.errors import BubblemeshError, CaseError, GeometryError
from bubblemesh.geometry.paths import Ring
from bubblemesh.messages import counted, shown
from bubblemesh.readers.features import FILL, HIDDEN, SPARE, Feature, vertices_of
from bubblemesh.readers.rings import rings_of_curves
from bubblemesh.readers.slips import Slips

MOST_LAYERS = 10  # that one message lists


class Bounding(NamedTuple):
    """Areas with their holes, rings that may nest, and notes on what was dropped or left out."""

    areas: list[tuple[Ring, ...]]
    loose: list[Ring]
    notes: list[str]


def bounding(features: Sequence[Feature], join: float | None, *, whole: bool = False) -> Bounding:
    """What bounds areas: polygons alone where there are some, else closed curves and lines that meet.

    Spare features count where there are no others, and fills also where the others do not close. CaseError if there is
    nothing that bounds an area; GeometryError if lines do not close, with the layers that do, or else the features, if
    these are the ``whole`` of the file or its layers, so that they can be chosen by number.
    """
    kinds = {kind: [one for one in features if one.spare == kind and not one.is_empty] for kind in (None, *SPARE)}
    used = next((kind for kind, ones in kinds.items() if any(one.bounds for one in ones)), None)
    try:
        found, notes = _bounding(kinds[used], join), []
    except GeometryError as error:
        if used is not None or not kinds[FILL]:
            closing = _layers_that_close(features, join) or (_features_that_close(features, join) if whole else "")
            raise GeometryError(f"{error}{closing}") from None
        used, found = FILL, _bounding(kinds[FILL], join)
        notes = [f"lines beside fills do not close and are left out ({error})"]
    unused = {f"{kind} element": len(ones) for kind, ones in kinds.items() if kind in (FILL, HIDDEN) and kind != used}
    empty = [one for one in features if one.is_empty]
    left_out = found.left_out | unused | {"empty feature": sum(not one.slips.flat for one in empty)}
    told = ", ".join(counted(number, noun) for noun, number in left_out.items() if number)
    slips = found.slips + reduce(add, (one.slips for one in empty), Slips())
    if not found.areas and not found.rings:
        raise _nothing(features, slips, told)
    notes = [*notes, *dict.fromkeys(note for one in kinds[used] for note in one.notes), *found.notes, *slips.notes]
    return Bounding(found.areas, found.rings, [*notes, f"left out: {told}"] if told else notes)


class _Found(NamedTuple):
    areas: list[tuple[Ring, ...]]
    rings: list[Ring]
    left_out: dict[str, int]  # numbers by what it is
    notes: Sequence[str]
    slips: Slips


def _bounding(features: Sequence[Feature], join: float | None) -> _Found:
    """What bounds areas of features that all count; GeometryError if lines do not close."""
    areas = [area for one in features for area in one.areas]
    rings = [ring for one in features for ring in one.rings]
    curves = [curve for one in features for curve in one.curves]
    slips = reduce(add, (one.slips for one in features), Slips())
    left_out = {"line": len(curves) if areas else 0, "point": sum(len(one.points) for one in features)}
    if areas:
        return _Found(areas, rings, left_out, (), slips)
    joined = rings_of_curves(curves, join)
    return _Found(areas, rings + joined.rings, left_out, joined.notes, slips + joined.slips)


def _nothing(features: Sequence[Feature], slips: Slips, left_out: str) -> BubblemeshError:
    """Error on features that bound no area."""
    if slips.flat:
        names = next((one.name for one in features if one.slips.flat), "a ring")
        return GeometryError(f"{names}: no ring has an area: give at least three different points, not in one line")
    if len(features) == 1 and features[0].is_empty:
        return CaseError(f"{features[0].name}: it is empty, without a geometry: choose another feature")
    but = f" (but {left_out})" if left_out else ""
    return CaseError(f"there is no ring in it{but}: give closed curves, or lines that meet")


def _layers_that_close(features: Sequence[Feature], join: float | None) -> str:
    """Advice that names the layers which bound areas by themselves, where there are several layers."""
    layers: dict[str, list[Feature]] = {}
    for one in features:
        if one.layer is not None:
            layers.setdefault(one.layer, []).append(one)
    closing = [layer for layer, ones in layers.items() if len(layers) > 1 and _closes(ones, join)]
    if not closing:
        return ""
    more = f" and {len(closing) - MOST_LAYERS} more" if len(closing) > MOST_LAYERS else ""
    named = ", ".join(shown(layer, 40) for layer in closing[:MOST_LAYERS])
    return f"; layers that close by themselves: {named}{more}: choose by layer: {shown(closing[0], 40)}"


def _features_that_close(features: Sequence[Feature], join: float | None) -> str:
    """Advice that names the features which bound areas by themselves, the widest of them first."""
    found = [k for k, one in enumerate(features) if len(features) > 1 and one.bounds and _closes([one], join)]
    if not found:
        return ""
    found.sort(key=lambda k: -float(np.ptp(vertices_of([features[k]]), axis=0).max()))
    more = f" and {len(found) - MOST_LAYERS} more" if len(found) > MOST_LAYERS else ""
    named = ", ".join(features[k].name for k in found[:MOST_LAYERS])
    return f"; what closes by itself: {named}{more}: choose by feature: {found[0]}"


def _closes(features: Sequence[Feature], join: float | None) -> bool:
    try:
        found = _bounding(features, join)
    except BubblemeshError:
        return False
    return bool(found.areas or found.rings)
