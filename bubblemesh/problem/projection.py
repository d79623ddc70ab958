"""The plane of a domain whose coordinates are places on the earth, and which vertices lie on its sides as given."""

from collections.abc import Sequence
from contextlib import suppress
from itertools import chain
from pathlib import Path

import numpy as np

from bubblemesh import readers
from bubblemesh.arrays import Floats
from bubblemesh.case.crs import CrsKeys
from bubblemesh.case.domain import DomainKeys, RegionFile, RegionSeed, RingDomain, ShoreDomain
from bubblemesh.case.fields import Strict, several
from bubblemesh.case.geometry_files import SelectedFile
from bubblemesh.case.lines_and_points import EmbeddedPoint, LineFile, PointFile
from bubblemesh.case.shapes import CircleRing, EllipseRing, PathLine, PathRing, PolygonRing, RectangleRing
from bubblemesh.errors import BubblemeshError
from bubblemesh.geometry.map_projection import UNPROJECTED, MapProjection, contacts_of
from bubblemesh.geometry.paths import Point
from bubblemesh.geometry.plane import Plane
from bubblemesh.geometry.rings import LineTo, end_of
from bubblemesh.problem.crs import AUTO, require_known_systems
from bubblemesh.problem.files import parts_of
from bubblemesh.problem.lines_and_points import named_in_file
from bubblemesh.problem.shapes import given_ring, pieces_of
from bubblemesh.readers.features import CompoundCurve, Feature, vertices_of
from bubblemesh.readers.selection import Purpose

Given = tuple[Sequence[Point] | Floats, Sequence[Feature]]
"""Places (n, 2) that the plane is about if they are the first, and what has sides and vertices."""


def projection_of(keys: DomainKeys, crs: CrsKeys | None) -> MapProjection:
    """Projection of a domain to a plane about the first of what it is made of; CaseError for an unknown system.

    What cannot be read or projected is left out here: to read the domain is an error.
    """
    if crs is None:
        return UNPROJECTED
    require_known_systems(crs)
    target = None if crs.to == AUTO else crs.to
    if isinstance(keys, ShoreDomain):  # no line is joined to the shore
        return MapProjection(Plane.about(crs.source, target, np.reshape(keys.box, (2, 2))))
    parts = parts_of(keys)
    if isinstance(keys, RingDomain):  # the outer ring is the first
        parts = chain(*map(parts_of, several(keys.outer)), parts_of(keys.model_copy(update={"outer": ()})))
    given = list(map(_given, parts))
    first = next((places for places, _ in given if len(places)), [(0.0, 0.0)])
    plane = Plane.about(crs.source, target, np.array(first, float))
    features = [one for _, found in given for one in found]
    with suppress(BubblemeshError):
        return MapProjection(plane, contacts_of(plane, _straight_sides(features), vertices_of(features)))
    return MapProjection(plane)


def _given(part: Strict) -> Given:
    """What a part of a domain gives; nothing if it cannot be read."""
    found: Sequence[Feature] = []
    with suppress(BubblemeshError):
        match part:
            case RegionSeed():
                return part.points, []
            case CircleRing(circle=whole) | EllipseRing(ellipse=whole):
                return [whole.center], []
            case PathLine():
                start, pieces = pieces_of(part, UNPROJECTED)
                closing = [LineTo(start)] if isinstance(part, PathRing) else []
                return [start], [Feature("", curves=(CompoundCurve(start, (*pieces, *closing), ""),))]
            case RectangleRing() | PolygonRing():
                found = [Feature("", rings=(given_ring(part),))]
            case EmbeddedPoint():
                found = [Feature("", points=(part.at,))]
            case SelectedFile():
                purpose: Purpose = "lines" if isinstance(part, LineFile) else "rings"
                if isinstance(part, PointFile | RegionFile):
                    purpose = "points"
                selection = named_in_file(part)
                found = selection.of(readers.read_content(Path(part.file), selection, purpose).features)
    return vertices_of(found), found


def _straight_sides(features: Sequence[Feature]) -> Floats:
    """Starts and ends (n, 2, 2) of the straight sides of features."""
    rings = (ring for one in features for ring in (*one.rings, *chain(*one.areas)))
    loops = (np.array(ring.vertices, float).reshape(-1, 2) for ring in rings)
    sides = [np.stack([loop, np.roll(loop, -1, axis=0)], axis=1) for loop in loops]
    for curve in (curve for one in features for curve in one.curves):
        points = np.array([curve.start, *map(end_of, curve.pieces)])
        straight = [isinstance(piece, LineTo) for piece in curve.pieces]
        sides.append(np.stack([points[:-1], points[1:]], axis=1)[straight])
    return np.concatenate([np.empty((0, 2, 2)), *sides])
