"""Features of files, projected to the plane of a case, if its coordinates are places on the earth."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError, prefixed
from bubblemesh.geometry.map_projection import MapProjection
from bubblemesh.geometry.paths import as_point
from bubblemesh.geometry.rings import LineTo
from bubblemesh.geometry.systems import LARGEST_PLACE, are_off_the_earth, full_turn, require_system
from bubblemesh.readers.features import CompoundCurve, Feature, FeatureCollection, vertices_of
from bubblemesh.readers.selection import Selection
from bubblemesh.readers.systems import require_one_system


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
        _require_coordinates(points, features)
        require_system(system, content.system, content.degrees, points)
    if not (content.degrees or full_turn(system)) or not are_off_the_earth(points).any():
        return
    for one in features:
        own = vertices_of([one])
        bad = np.flatnonzero(are_off_the_earth(own))
        if len(bad):
            x, y = own[bad[0]].tolist()
            raise CaseError(
                f"{one.name}: vertex {bad[0] + 1} at ({x:g}, {y:g}) is no longitude and latitude: correct it, or "
                "crs.from if all are metres"
            )


def _require_coordinates(points: Floats, features: Sequence[Feature]) -> None:
    """Check the coordinates of features, with those of vertices that a ring lost, as one far away is a spike."""
    any_far = (np.abs(points) > LARGEST_PLACE).any()
    for one in features:
        largest = max(one.slips.largest, np.abs(vertices_of([one])).max(initial=0.0) if any_far else 0.0)
        if largest > LARGEST_PLACE:
            raise CaseError(f"{one.name}: {largest:g} is no coordinate on the earth: correct it")


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
