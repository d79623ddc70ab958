"""Features of files, projected to the plane of a case, if its coordinates are places on the earth."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError, prefixed
from bubblemesh.geometry.paths import as_point
from bubblemesh.geometry.projecting import (
    projected,
    projected_if_near,
    projected_line,
    projected_ring,
    projected_system,
    projected_vertices,
)
from bubblemesh.geometry.rings import LineTo
from bubblemesh.geometry.systems import full_turn, require_system
from bubblemesh.readers.features import CompoundCurve, Feature, FeatureCollection, require_on_the_earth, vertices_of
from bubblemesh.readers.selection import Selection
from bubblemesh.readers.systems import require_one_system


def projected_features(path: Path, content: FeatureCollection, selection: Selection) -> list[Feature]:
    """The selected features of a file, projected to the plane of the case if it has one.

    The same CaseError as `Selection.of`, and CaseError for curves that are not straight and for a unit of length, which
    places on the earth do not have; without a projection, for a file in another system than those before it.
    """
    features = selection.of(content.features)
    system = projected_system()
    if system is None:
        require_one_system(path, content, vertices_of(features))
        return features
    if selection.factor(content) != 1:
        raise CaseError("units and scale are not for coordinates with a crs: leave them out")
    points = vertices_of(features)
    require_system(system, content.system, content.degrees, points)
    if full_turn(system) is not None:
        require_on_the_earth(features)
    projected(points)  # all at once: they decide on the plane, and are checked
    return [_projected(one) for one in features]


def _projected(one: Feature) -> Feature:
    with prefixed(one.name):
        return replace(
            one,
            areas=tuple(tuple(map(projected_ring, area)) for area in one.areas),
            rings=tuple(map(projected_ring, one.rings)),
            curves=tuple(map(_curve, one.curves)),
            points=tuple(map(as_point, projected_vertices(np.array(one.points, float).reshape(-1, 2)))),
            slips=one.slips.moved(projected_if_near),
        )


def _curve(curve: CompoundCurve) -> CompoundCurve:
    straight = [piece for piece in curve.pieces if isinstance(piece, LineTo)]
    if len(straight) < len(curve.pieces):
        raise CaseError("crs: a line is curved, and cannot be projected: give straight ones")
    points: Floats = np.array([curve.start, *(piece.to for piece in straight)])
    places, side = projected_line(points)
    start, *others = map(as_point, places)
    labels = [straight[k].label for k in side]
    return CompoundCurve(start, tuple(map(LineTo, others, labels)), curve.name)
