"""Regions given by points inside them: the faces of a domain that rings and lines enclose around these."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple, TypeAlias

import numpy as np
import shapely

from bubblemesh.arrays import Floats
from bubblemesh.errors import GeometryError, about
from bubblemesh.geometry.arrangement import NEARLY
from bubblemesh.geometry.arrangement.bellies import NEWTON_STEPS, bellies
from bubblemesh.geometry.arrangement.crossings import chord_boxes
from bubblemesh.geometry.arrangement.open_ends import OpenEnds
from bubblemesh.geometry.arrangement.overlay import Assembly
from bubblemesh.geometry.arrangement.regions import InnerParts, Region, RegionsAround, Seed
from bubblemesh.geometry.arrangement.walks import EnclosedFaces
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.paths import Ring
from bubblemesh.messages import place

SEPARATE = "draw a line from side to side between them, or give both the same name"

Polygon: TypeAlias = "shapely.Polygon | shapely.MultiPolygon"


class SeededRegions(NamedTuple):
    """Regions that are faces, the sides of pieces in them, and notes on these."""

    regions: list[Region]
    sides: RegionsAround  # those on the left of all pieces are numbered before those on the right
    notes: list[str]
    faces: EnclosedFaces | None = None  # between all pieces, if there are such regions


def seeded_regions(
    parts: InnerParts, rings: Sequence[Ring], boundary: Boundary, single: Boundary, size: float, polygon: Polygon
) -> SeededRegions:
    """The regions of the seeds among the parts of a domain, the polygon, of some size.

    Parameters
    ----------
    parts
        Inner parts, without what lies outside of the domain.
    rings
        Rings of the domain, with the domain on their left.
    boundary
        The boundary of the rings.
    single
        All noded pieces, each once.

    Raises
    ------
    GeometryError
        If a seed is outside of the domain or on a line, or if two with different names are in one face; with the place.
    """
    none = np.zeros(0, np.int64)
    if not parts.seeds:
        return SeededRegions([], RegionsAround(none, none), [])
    _require_inside(parts.seeds, single, size, polygon)
    faces = EnclosedFaces.of(single)
    ends = OpenEnds(parts.lines, single, size)
    seeds = dict[int, Seed]()  # the first one in each face
    for seed, face in zip(parts.seeds, faces.around(_places(parts.seeds)).tolist(), strict=True):
        if (first := seeds.setdefault(face, seed)).name != seed.name:
            with about(seed.key):
                raise _not_separated(first, seed, ends.advice(faces.around(ends.places) == face) or SEPARATE)
    before = Boundary.of(rings, boundary.area_of_ring).with_inner(parts.paths)
    sides = [*(ring.sides for ring in rings), *(path.sides for path in parts.paths)]
    assembly = Assembly(faces.boundary, before, [side.curve for some in sides for side in some])
    regions = [_region(seed, assembly, faces, face) for face, seed in seeds.items()]
    number = np.full(len(faces.areas) + 1, -1)  # of faces, OUTSIDE the last one
    number[[*seeds]] = np.arange(len(seeds))
    region = number[faces.of_all_sides.ravel()]
    inside = np.flatnonzero(region >= 0)
    notes = [note for seed in parts.seeds for note in seed.notes]
    return SeededRegions(regions, RegionsAround(inside, region[inside]), notes, faces)


def _places(seeds: Sequence[Seed]) -> Floats:
    return np.array([seed.at for seed in seeds], float)


def _region(seed: Seed, assembly: Assembly, faces: EnclosedFaces, face: int) -> Region:
    """The region that is a face; its sides have the labels of what they lie on."""
    (area,) = assembly.areas(*(faces.beside == face))
    return Region(replace(area.about(seed.key), name=seed.name), seed.name, f"{seed.name}-rim", seed.entry, named=False)


def _require_inside(seeds: Sequence[Seed], boundary: Boundary, size: float, polygon: Polygon) -> None:
    """Check that seeds are in the domain, and on no piece; GeometryError about the first one that is not."""
    points = _places(seeds)
    chords = chord_boxes(boundary, size)
    point, chord = chords.boxes.query(shapely.points(points), predicate="intersects")
    piece = chords.piece[chord]
    s = boundary.foot(points[point], piece, chords.s[chord] + chords.step[chord] / 2, NEWTON_STEPS)
    met = np.hypot(*(boundary.points(piece, boundary.wrapped(piece, s)) - points[point]).T) <= NEARLY * size
    on = dict(zip(point[met].tolist(), piece[met].tolist(), strict=True))
    inside = shapely.contains_xy(polygon, points)
    between = bellies(boundary.select(np.flatnonzero(~boundary.inner)), points)
    np.logical_xor.at(inside, between.point, True)
    for number, seed in enumerate(seeds):
        where = (
            f"on {boundary.labels[boundary.label[on[number]]]!r}" if number in on else "outside the domain or in a hole"
        )
        if number in on or not inside[number]:
            with about(seed.key):
                raise GeometryError(
                    f"the point of region {seed.name!r} at {place(seed.at)} lies {where}: move it into the part of the "
                    "domain that it names",
                    mendable=False,
                )


def _not_separated(one: Seed, other: Seed, advice: str) -> GeometryError:
    """The error of two seeds with different names in one face."""
    return GeometryError(
        f"no line separates the points of regions {one.name!r} at {place(one.at)} and {other.name!r} at "
        f"{place(other.at)}: {advice}",
        mendable=False,
    )
