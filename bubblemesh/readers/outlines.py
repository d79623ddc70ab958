"""Outlines: the curves and rings of chosen features of a file that bound areas, and notes on what is left out."""

from collections.abc import Sequence
from functools import partial, reduce
from operator import add
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.errors import BubblemeshError, CaseError, GeometryError
from bubblemesh.geometry.nesting import shapes_of
from bubblemesh.geometry.paths import Area, Ring
from bubblemesh.messages import counted
from bubblemesh.readers.areas import areas_by_nesting
from bubblemesh.readers.clips import clipped
from bubblemesh.readers.features import FILL, HIDDEN, REGION, SPARE, Feature
from bubblemesh.readers.rings.advice import JoinOutcome, ways_out
from bubblemesh.readers.rings.duplicates import without_same_circles
from bubblemesh.readers.rings.joining import Joining, rings_of_curves
from bubblemesh.readers.rings.linework import rings_of_linework
from bubblemesh.readers.selection import Selection
from bubblemesh.readers.slips import Slips


class Bounding(NamedTuple):
    """Areas with their holes, rings that may be nested, and notes on what was dropped or left out."""

    areas: list[tuple[Ring, ...]]
    loose: list[Ring]
    notes: list[str]


def bounding(features: Sequence[Feature], joining: Joining, *, whole: bool = False, single: bool = False) -> Bounding:
    """Outlines of areas: only polygons if there are any, else closed curves and lines that meet.

    Spare features are used if there are no others, and fills also if the others do not close.

    Parameters
    ----------
    features
        The chosen features.
    joining
        Rules for joining curves.
    whole
        Whether these are all features of the file or of its layers, so that messages can name features by number.
    single
        Whether they have to bound a single area, so that messages advise to choose a part of several.

    Raises
    ------
    CaseError
        If nothing bounds an area.
    GeometryError
        If lines do not close; the message has the keys that help, and the layers or features that do close.
    """
    given = features
    features, clips = clipped(given, joining)
    kinds = {kind: [one for one in features if one.spare == kind and not one.is_empty] for kind in (None, *SPARE)}
    used = next((kind for kind, ones in kinds.items() if any(one.bounds for one in ones)), None)
    try:
        found, notes = _bounding(kinds[used], joining), []
    except GeometryError as error:
        if used is not None or not kinds[FILL]:
            advice = ways_out(kinds[used], given, joining, partial(_tried, single=single), whole)
            raise GeometryError(f"{error}: {advice}") from None
        used, found = FILL, _bounding(kinds[FILL], joining)
        notes = [f"lines beside fills do not close and are left out ({error})"]
    unused = {f"{kind} element": len(ones) for kind, ones in kinds.items() if kind in (FILL, HIDDEN) and kind != used}
    regions = len(kinds[REGION]) if used != REGION else 0
    empty = [one for one in features if one.is_empty and one.spare != REGION]
    left_out = found.left_out | unused | {"empty feature": sum(not one.slips.flat for one in empty)}
    counts = ", ".join(counted(number, noun) for noun, number in left_out.items() if number)
    slips = found.slips + reduce(add, (one.slips for one in empty), Slips())
    if not found.areas and not found.rings:
        raise _nothing(features, slips, counts)
    notes = [
        *notes,
        *clips,
        *dict.fromkeys(note for one in kinds[used] for note in one.notes),
        *found.notes,
        *slips.notes,
    ]
    notes += [f"left out: {counts}"] if counts else []
    if regions:
        notes.append(f"{counted(regions, 'region')} in it: regions: {{file: ..., name: attribute}} takes them")
    return Bounding(found.areas, found.rings, notes)


def joining_of(selection: Selection, size: float | None = None) -> Joining:
    """Rules by which the selected curves become rings; with a ``size`` they may be mended."""
    joining, repair = Joining(selection.join, selection.open == "skip"), selection.repair
    if repair is None or not repair.mend or size is None:
        return joining
    return joining._replace(reach=repair.gap_of(size) if joining.reach is None else joining.reach, mend=True)


class _Outlines(NamedTuple):
    areas: list[tuple[Ring, ...]]
    rings: list[Ring]
    left_out: dict[str, int]  # numbers of things left out, by their kind
    notes: Sequence[str]
    slips: Slips


def _bounding(features: Sequence[Feature], joining: Joining) -> _Outlines:
    """Outlines of areas by all of the features; GeometryError if lines do not close."""
    areas = [area for one in features for area in one.areas]
    rings = [ring for one in features for ring in one.rings]
    curves = [curve for one in features for curve in one.curves]
    slips = reduce(add, (one.slips for one in features), Slips())
    left_out = {"line": len(curves) if areas else 0, "point": sum(len(one.points) for one in features)}
    if areas:
        return _Outlines(areas, rings, left_out, (), slips)
    joined = rings_of_linework(curves, joining) if joining.mend else rings_of_curves(curves, joining)
    loops, copies = without_same_circles(rings + joined.rings)  # joined arcs may be a circle, too
    return _Outlines(areas, loops, left_out, joined.notes, slips + joined.slips + copies)


def _nothing(features: Sequence[Feature], slips: Slips, left_out: str) -> BubblemeshError:
    """Error for features that bound no area."""
    if slips.flat:
        names = next((one.name for one in features if one.slips.flat), "a ring")
        return GeometryError(f"{names}: no ring has an area: give at least three different points, not in one line")
    if len(features) == 1 and features[0].is_empty:
        return CaseError(f"{features[0].name}: it is empty, without a geometry: choose another feature")
    but = f" (but {left_out})" if left_out else ""
    return CaseError(f"there is no ring in it{but}: give closed curves, or lines that meet")


def _tried(features: Sequence[Feature], joining: Joining, single: bool) -> JoinOutcome | None:
    """Outcome of joining features to a ``single`` area or to any; None if a ring does not close or collapses."""
    try:
        seen = clipped(features, joining)[0]
        used = next((kind for kind in (None, *SPARE) if any(one.bounds for one in seen if one.spare == kind)), None)
        found = _bounding([one for one in seen if one.spare == used and not one.is_empty], joining)
        areas = areas_by_nesting([Area(outer, tuple(holes)) for outer, *holes in found.areas], found.rings, None)
    except BubblemeshError:
        return None
    if not areas or found.slips.flat != sum(one.slips.flat for one in seen if one.spare == used):
        return None
    shapes = shapes_of(areas)
    taken = shapes[[np.argmax(shapely.area(shapes))]] if single else shapes
    return JoinOutcome(
        len(found.areas) + len(found.rings), single and len(areas) > 1, bool(shapely.is_valid(taken).all())
    )
