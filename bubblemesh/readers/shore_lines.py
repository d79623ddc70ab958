"""Lines of the shore with the land on their left, closed along a box: the faces between them that are land."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import ROUNDING, Floats, Integers
from bubblemesh.errors import CaseError
from bubblemesh.geometry.rings import end_of
from bubblemesh.messages import counted
from bubblemesh.readers.features import Feature

FEW = 0.05  # of the sides of a face: so many may say the opposite by mistake


def given_place(point: Floats) -> str:
    """Text of a point in messages while a file is read: in the coordinates of the file."""
    x, y = point.tolist()
    return f"({x:.6g}, {y:.6g})"


class ShoreLine(NamedTuple):
    """A line (k, 2) with the land on its left, and the name of its feature."""

    points: Floats
    feature: str


def shore_lines(features: Sequence[Feature]) -> list[ShoreLine]:
    """Lines of features, in their direction; rings end where they begin. CaseError if there are none."""
    found = [
        ShoreLine(np.array([curve.start, *map(end_of, curve.pieces)], float), one.name)
        for one in features
        for curve in one.curves
    ]
    for one in features:
        loops = [ring.vertices for ring in (*one.rings, *(ring for area in one.areas for ring in area))]
        found += [ShoreLine(np.array([*loop, loop[0]], float), one.name) for loop in loops]
    if not found:
        raise CaseError("has no lines: give lines of the shore, or polygons")
    return found


def left_of(
    lines: Sequence[ShoreLine], cut: shapely.Geometry, frame: shapely.Polygon
) -> tuple[list[shapely.Polygon], tuple[str, ...]]:
    """Faces of a frame that are on the left of lines, and notes; ``cut`` is the part of the lines in the frame.

    CaseError, with the place and the feature, if a face is on the left of some lines and on the right of others, or if
    a line, other than a short spur, ends in it.
    """
    edges = shapely.get_parts(shapely.node(shapely.union_all([cut, frame.boundary])))
    made, bridges, spurs, _ = shapely.polygonize_full(edges)
    faces = shapely.orient_polygons(shapely.get_parts(made))
    # So near to a line, places count as on it.
    shore = _Shore(lines, ROUNDING * max(np.ptp(shapely.get_coordinates(frame), axis=0)))
    votes = shore.votes(faces)
    loose = [spur for some in (spurs, bridges) for spur in shapely.get_parts(some).tolist()]
    notes = _spur_notes(faces, votes.sum(axis=1), loose, shore)
    for face, (right, left) in zip(faces, votes, strict=True):
        if min(left, right) > FEW * (left + right):
            where, feature = shore.odd_one(face, left < right)
            raise CaseError(
                f"{feature} runs against the other lines around it at {where}, and land has to be on the left of each: "
                "turn it, or close the gaps between the lines"
            )
    return [face for face, (right, left) in zip(faces, votes, strict=True) if left > right], notes


class _Shore:
    """The segments of all lines, with which sides of faces are compared."""

    def __init__(self, lines: Sequence[ShoreLine], near: float) -> None:
        self.near = near
        self.features = [line.feature for line in lines]
        self.owner = np.repeat(np.arange(len(lines)), [len(line.points) - 1 for line in lines])
        self.segments = np.vstack([np.stack([line.points[:-1], line.points[1:]], axis=1) for line in lines])
        self.tree = shapely.STRtree(shapely.linestrings(self.segments))

    def votes(self, faces: Sequence[shapely.Polygon]) -> Floats:
        """Lengths (n, 2) of the sides of each face along lines, with the face on the right and on the left of these."""
        return np.array([np.bincount(left, length, 2) for length, left, _, _ in map(self._along, faces)])

    def odd_one(self, face: shapely.Polygon, left: bool) -> tuple[str, str]:
        """Middle of the longest side of a face along lines that have it on the given side, and the line's feature."""
        length, is_left, middles, segments = self._along(face)
        k = int(np.argmax(np.where(is_left == left, length, -1.0)))
        return given_place(middles[k]), self.features[self.owner[segments[k]]]

    def feature_at(self, point: Floats) -> str:
        """Feature of the line that is nearest to a point."""
        return self.features[self.owner[self.tree.nearest(shapely.Point(point))]]

    def _along(self, face: shapely.Polygon) -> tuple[Floats, Integers, Floats, Integers]:
        """Sides of a face that are on lines, with the boundary of the face counter-clockwise.

        Returns
        -------
        tuple
            Lengths (k,); whether lines have the face on their left, as 0 or 1 (k,); middles (k, 2); numbers (k,) of the
            segments on which they are.
        """
        rings = [shapely.get_coordinates(ring) for ring in (face.exterior, *face.interiors)]
        starts, ends = (np.vstack([ring[part] for ring in rings]) for part in (slice(-1), slice(1, None)))
        middles = (starts + ends) / 2
        side, segment = self.tree.query(shapely.points(middles), "dwithin", distance=self.near)
        along = ends[side] - starts[side]
        direction = self.segments[segment, 1] - self.segments[segment, 0]
        left = ((along * direction).sum(axis=1) > 0).astype(np.int64)
        return np.hypot(*along.T), left, middles[side], segment


def _spur_notes(
    faces: Sequence[shapely.Polygon], around: Floats, spurs: Sequence[shapely.Geometry], shore: _Shore
) -> tuple[str, ...]:
    """Note on short pieces of lines that bound nothing; CaseError if in a face they are long, compared to its sides."""
    if not spurs:
        return ()
    middles = [spur.interpolate(0.5, normalized=True) for spur in spurs]
    spur, face = shapely.STRtree(faces).query(middles, predicate="intersects")
    length = np.bincount(face, shapely.length(spurs)[spur], len(faces))
    for k in np.flatnonzero(length > FEW * around).tolist():
        inside = np.vstack([shapely.get_coordinates(spurs[one])[[0, -1]] for one in spur[face == k]])
        end = inside[np.argmax(shapely.distance(shapely.points(inside), faces[k].boundary))]
        raise CaseError(
            f"{shore.feature_at(end)} ends at {given_place(end)}, in the box: continue it to another line, or to "
            "a side of the box"
        )
    first = given_place(shapely.get_coordinates(spurs[0])[0])
    return (f"{counted(len(spurs), 'piece')} of lines that bound nothing left out, the first at {first}",)
