"""The plane of a domain whose coordinates are places on the earth, and which vertices lie on its sides as given."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

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
from bubblemesh.geometry.contacts_as_given import contacts_between
from bubblemesh.geometry.map_projection import UNPROJECTED, MapProjection
from bubblemesh.geometry.plane import Plane
from bubblemesh.geometry.rings import LineTo, end_of
from bubblemesh.problem.crs import AUTO, require_known_systems
from bubblemesh.problem.files import parts_of
from bubblemesh.problem.lines_and_points import named_in_file
from bubblemesh.problem.shapes import given_ring, pieces_of
from bubblemesh.readers.features import CompoundCurve, Feature
from bubblemesh.readers.selection import Purpose

NO_POINTS, NO_SIDES = np.empty((0, 2)), np.empty((0, 2, 2))


class Given(NamedTuple):
    """What a part of a domain gives, in coordinates as given."""

    places: Floats = NO_POINTS  # (n, 2) that the plane is about if they are the first
    vertices: Floats = NO_POINTS  # (m, 2) that may lie on the sides of others
    sides: Floats = NO_SIDES  # (k, 2, 2) straight ones, between vertices


def projection_of(keys: DomainKeys, crs: CrsKeys | None) -> MapProjection:
    """Projection of a domain to a plane about the first of what it is made of; CaseError for an unknown system.

    What cannot be read is left out here: to read the domain is an error.
    """
    if crs is None:
        return UNPROJECTED
    require_known_systems(crs)
    parts = parts_of(keys)
    if isinstance(keys, RingDomain):  # the outer ring is the first
        parts = chain(*map(parts_of, several(keys.outer)), parts_of(keys.model_copy(update={"outer": ()})))
    given = list(map(_given, parts))
    first = next((one.places for one in given if len(one.places)), np.zeros((1, 2)))
    plane = Plane.about(crs.source, None if crs.to == AUTO else crs.to, first)
    vertices, sides = (np.concatenate([one[k] for one in given]) for k in (1, 2))
    return MapProjection(plane, contacts_between(sides, vertices))


def _given(part: Strict) -> Given:
    """What a part of a domain gives without the parts within it; nothing if it cannot be read."""
    gives = next((GIVEN[kind] for kind in type(part).__mro__ if kind in GIVEN), None)
    with suppress(BubblemeshError):
        return Given() if gives is None else gives(part)
    return Given()


def _by_features(features: Sequence[Feature]) -> Given:
    """What features give."""
    rings = (ring for one in features for ring in (*one.rings, *chain(*one.areas)))
    loops = [np.array(ring.vertices, float).reshape(-1, 2) for ring in rings]
    sides = [np.stack([loop, np.roll(loop, -1, axis=0)], axis=1) for loop in loops]
    lines = list[Floats]()
    for curve in (curve for one in features for curve in one.curves):
        lines.append(np.array([curve.start, *map(end_of, curve.pieces)]))
        straight = [isinstance(piece, LineTo) for piece in curve.pieces]
        sides.append(np.stack([lines[-1][:-1], lines[-1][1:]], axis=1)[straight])
    points = (np.array(one.points, float).reshape(-1, 2) for one in features)
    vertices = np.concatenate([NO_POINTS, *loops, *lines, *points])
    return Given(vertices, vertices, np.concatenate([NO_SIDES, *sides]))


def _by_path(keys: PathLine) -> Given:
    """What a path gives, which begins at the place that the plane may be about."""
    start, pieces = pieces_of(keys, UNPROJECTED)
    closing = [LineTo(start)] if isinstance(keys, PathRing) else []
    curve = CompoundCurve(start, (*pieces, *closing), "")
    return _by_features([Feature("", curves=(curve,))])._replace(places=np.array([start]))


def _by_file(keys: SelectedFile, purpose: Purpose = "rings") -> Given:
    """What the features that are chosen of a file give."""
    selection = named_in_file(keys)
    return _by_features(selection.of(readers.read_content(Path(keys.file), selection, purpose).features))


GIVEN: Mapping[type[Strict], Callable[[Any], Given]] = {
    ShoreDomain: lambda keys: Given(np.reshape(keys.box, (2, 2))),
    CircleRing: lambda keys: Given(np.array([keys.circle.center])),
    EllipseRing: lambda keys: Given(np.array([keys.ellipse.center])),
    RegionSeed: lambda keys: Given(np.array(keys.points)),
    EmbeddedPoint: lambda keys: _by_features([Feature("", points=(keys.at,))]),
    RectangleRing: lambda keys: _by_features([Feature("", rings=(given_ring(keys),))]),
    PolygonRing: lambda keys: _by_features([Feature("", rings=(given_ring(keys),))]),
    PathLine: _by_path,
    SelectedFile: _by_file,
    LineFile: partial(_by_file, purpose="lines"),
    PointFile: partial(_by_file, purpose="points"),
    RegionFile: partial(_by_file, purpose="points"),
}
"""By the models of a case and of what they share, so that there is a row for all that has coordinates."""
