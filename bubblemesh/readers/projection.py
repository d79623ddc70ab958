"""Features of files, projected to the plane of a case, if its coordinates are places on the earth."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError, prefixed
from bubblemesh.geometry.map_projection import MapProjection
from bubblemesh.geometry.paths import Point, as_point
from bubblemesh.geometry.rings import LineTo
from bubblemesh.geometry.systems import are_off_the_earth, full_turn, require_system
from bubblemesh.readers.features import CompoundCurve, Feature, FeatureCollection, vertices_of
from bubblemesh.readers.selection import Selection
from bubblemesh.readers.systems import require_one_system

NO_PLACE = {
    True: "no longitude and latitude: correct it, or crs.from if all are metres",
    False: "no place on the earth: correct it",
}


def projected_features(
    path: Path, content: FeatureCollection, selection: Selection, projection: MapProjection
) -> list[Feature]:
    """The selected features of a file, projected to the plane of the case if it has one.

    The same CaseError as `Selection.of`, and CaseError for curves that are not straight and for a unit of length, which
    places on the earth do not have; without a projection, for a file in another system than those before it.
    """
    features = selection.of(content.features)
    if projection.system is None:
        require_one_system(path, content, vertices_of(features))
        return features
    if selection.factor(content) != 1:
        raise CaseError("units and scale are not for coordinates with a crs: leave them out")
    points = vertices_of(features)
    require_places(points, features, content, projection.system)
    projection.points(points)  # all at once: they are checked
    return [_projected(one, projection) for one in features]


def require_places(points: Floats, features: Sequence[Feature], content: FeatureCollection, system: str | None) -> None:
    """Check that points (n, 2) of features are places on the earth: in a system, or else in degrees if a file says so.

    CaseError if the file is in another system, or with the feature that has a vertex which is no place.
    """
    if system is not None:
        _require_no_place_lost(features)
        require_system(system, content.system, content.degrees, points)
    degrees = bool(content.degrees) or full_turn(system) is not None
    if (system is None and not degrees) or not are_off_the_earth(points, degrees).any():
        return
    for one in features:
        points = vertices_of([one])
        bad = np.flatnonzero(are_off_the_earth(points, degrees))
        if len(bad):
            raise CaseError(f"{one.name}: vertex {bad[0] + 1} at {_pair(points[bad[0]])} is {NO_PLACE[degrees]}")


def _require_no_place_lost(features: Sequence[Feature]) -> None:
    """Check rings that vertices were dropped from: if one is very far away, all others are one point beside it."""
    for one in features:
        farthest = one.slips.farthest
        if farthest is not None and are_off_the_earth(np.array([farthest]), degrees=False).any():
            raise CaseError(f"{one.name}: {_pair(farthest)} is {NO_PLACE[False]}")


def _pair(point: Point | Floats) -> str:
    """Text of a point that is no place on the earth, as it is given."""
    x, y = point
    return f"({x:g}, {y:g})"


def _projected(one: Feature, projection: MapProjection) -> Feature:
    with prefixed(one.name):
        return replace(
            one,
            areas=tuple(tuple(map(projection.ring, area)) for area in one.areas),
            rings=tuple(map(projection.ring, one.rings)),
            curves=tuple(_curve(curve, projection) for curve in one.curves),
            points=tuple(map(as_point, projection.points(np.array(one.points, float).reshape(-1, 2)))),
            slips=one.slips.moved(projection.near),
        )


def _curve(curve: CompoundCurve, projection: MapProjection) -> CompoundCurve:
    straight = [piece for piece in curve.pieces if isinstance(piece, LineTo)]
    if len(straight) < len(curve.pieces):
        raise CaseError("crs: a line is curved, and cannot be projected: give straight ones")
    points: Floats = np.array([curve.start, *(piece.to for piece in straight)])
    places, side = projection.line(points)
    start, *others = map(as_point, places)
    labels = [straight[k].label for k in side]
    return CompoundCurve(start, tuple(map(LineTo, others, labels)), curve.name)
