"""SVG drawings: shapes and paths with their transforms, styles and fill rules; y is reversed to point up."""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np

from bubblemesh.errors import CaseError
from bubblemesh.files import read_bytes
from bubblemesh.geometry.paths import Point
from bubblemesh.geometry.rings import LineTo
from bubblemesh.messages import counted, place, shown
from bubblemesh.readers.features import HIDDEN, CompoundCurve, Feature, FeatureCollection, foreign, writable_label
from bubblemesh.readers.svg.curves import curves_of
from bubblemesh.readers.svg.fill import FLAT_SUBPATH, area_of, filled
from bubblemesh.readers.svg.size import physical_length, stretch
from bubblemesh.readers.svg.source import checked_drawing
from bubblemesh.readers.svg.tree import Around, Drawing, Drawn, shapes

NO_PAINT = ("none", "transparent")


def read_svg(path: Path) -> FeatureCollection:
    """The shapes of a drawing in its own units, with transforms applied and y pointing up.

    Each subpath is a curve. Open subpaths of filled shapes are closed, and the fill rule decides which curves bound
    areas. FileError or CaseError with the element.
    """
    root = checked_drawing(read_bytes(path))
    with foreign("not a valid drawing", "correct it"):
        return _features(Drawing.of(root))


def _features(drawing: Drawing) -> FeatureCollection:
    """Content of a drawing: a feature for each shape, size on paper, and notes on what is not used."""
    features: list[Feature] = []
    stretched = stretch(drawing.root)
    for drawn in shapes(drawing, drawing.root, Around(transform=f"scale(1,{stretched!r})" if stretched != 1 else "")):
        features.append(_feature(drawing, drawn, len(features)))
    notes = [f"{counted(number, tag)} not used" for tag, number in drawing.unused.items()]
    notes += [f"{counted(number, 'element')} not clipped: {why}" for why, number in drawing.unclipped.items()]
    if drawing.masked:
        notes.append(f"{counted(drawing.masked, 'shape')} under a mask used whole: masks are not applied")
    if stretched != 1:
        notes.append(f"its y are stretched by {stretched:.6g}, since preserveAspectRatio is none")
    features, more = _closed(features, {one.name for one in features if one.properties["rule"]})
    features = [_by_fill_rule(one) for one in features]
    if not any(one.bounds for one in features):
        raise CaseError(f"there are no closed paths or shapes in it{''.join(f'; {note}' for note in (*notes, *more))}")
    return FeatureCollection(tuple(features), (*notes, *more), physical=physical_length(drawing.root))


def _feature(drawing: Drawing, drawn: Drawn, number: int) -> Feature:
    """The element with a curve for each subpath, and its fill rule among the properties if it is filled."""
    element, around = drawn
    own = element.attributes.get("id")
    name = f"feature {number} ({element.tag}{f' {shown(own, 40)!r}' if own else ''})"
    label, notes = writable_label(around.label, name)
    curves = curves_of(element, around.transform, drawing.size, name, label)
    style = around.style
    is_filled = style.get("fill", "black") not in NO_PAINT and element.tag != "line"
    unpainted = not is_filled and style.get("stroke", "none") in NO_PAINT
    hidden = around.hidden or unpainted or style.get("visibility", "visible") != "visible"
    drawing.masked += around.masked and not hidden
    rule = ("evenodd" if style.get("fill-rule") == "evenodd" else "nonzero") if is_filled else None
    properties = {"id": own, "label": label, "class": element.attributes.get("class"), "rule": rule}
    spare = HIDDEN if hidden else None
    return Feature(
        name, around.layer, properties, curves=tuple(curves), notes=notes, spare=spare, clips=around.clips or ()
    )


def _closed(features: list[Feature], painted: set[str]) -> tuple[list[Feature], list[str]]:
    """The features, with open subpaths of filled shapes closed by straight lines, except those that join others."""
    points = [point for one in features for curve in one.curves for point in (curve.start, curve.end)]
    if not points:
        return features, []
    grid = 1e-7 * float(np.ptp(np.array(points), axis=0).max()) or 1.0

    def spot(point: Point) -> tuple[int, int]:
        return round(point[0] / grid), round(point[1] / grid)

    open_ = [curve for one in features for curve in one.curves if curve.start != curve.end]
    ends = Counter(spot(point) for curve in open_ for point in (curve.start, curve.end))
    gaps: list[tuple[float, Point]] = []

    def closed(curve: CompoundCurve) -> CompoundCurve:
        joins = ends[spot(curve.start)] > 1 and ends[spot(curve.end)] > 1
        loop = replace(curve, pieces=(*curve.pieces, LineTo(curve.start, curve.pieces[0].label)))
        if curve.start == curve.end or joins or area_of(loop) <= FLAT_SUBPATH:
            return curve
        gaps.append((float(np.hypot(*np.subtract(curve.start, curve.end))), curve.end))
        return loop

    found = [replace(one, curves=tuple(map(closed, one.curves))) if one.name in painted else one for one in features]
    if not gaps:
        return found, []
    widest, where = max(gaps)
    many = counted(len(gaps), "open subpath")
    return found, [f"{many} closed straight, as what is filled is, the widest gap ({widest:.3g}) at {place(where)}"]


def _by_fill_rule(feature: Feature) -> Feature:
    """The feature with the loops that bound filled areas."""
    rule = feature.properties["rule"]
    loops = [curve for curve in feature.curves if curve.start == curve.end]
    if rule is None or not loops:
        return feature
    found = filled(loops, rule)
    if found.loops == loops:
        return feature
    others = [curve for curve in feature.curves if curve.start != curve.end]
    notes = tuple(f"{feature.name}: {note}" for note in found.notes)
    return replace(feature, curves=(*found.loops, *others), rings=tuple(found.rings), notes=(*feature.notes, *notes))
