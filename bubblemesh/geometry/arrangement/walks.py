"""Faces between noded pieces, which are walked around corner by corner, each on its left and on its right.

A piece with one walk on both sides bounds nothing: it is a line with an open end, or a bridge. Of the other walks those
that turn to the left are around faces, those that turn to the right are around holes of these.
"""

from dataclasses import replace
from functools import cached_property

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, components, cross
from bubblemesh.geometry.arrangement.bellies import bellies
from bubblemesh.geometry.arrangement.overlay import directions
from bubblemesh.geometry.arrangement.regions import RegionsAround, innermost
from bubblemesh.geometry.arrangement.winding import crossed
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.records import record

OUTSIDE = -1  # number of what is around all faces


@record
class EnclosedFaces:
    """Faces between pieces, of which each has different ones on its two sides."""

    boundary: Boundary
    loose: Boundary  # pieces with one face on both sides
    kept: Booleans  # (k,): which of all pieces have different ones
    walks: Integers  # (2, p), numbers of the walks on the left and on the right of each piece
    areas: Floats  # (w,), around which walks turn to the left; those above 0 are around the face of the same number
    face: Integers  # (w,), that is on the left of each walk, or OUTSIDE

    @classmethod
    def of(cls, boundary: Boundary) -> "EnclosedFaces":
        """The faces between noded pieces."""
        left, right = walks_beside(boundary)
        kept = left != right
        loose, boundary = boundary.select(np.flatnonzero(~kept)), boundary.select(np.flatnonzero(kept))
        walks = walks_beside(boundary)
        areas = _areas(boundary, walks)
        faces = cls(boundary, loose, kept, walks, areas, np.arange(len(areas)))
        holes = np.flatnonzero(areas <= 0)
        chords = boundary.chords()
        a_chord = np.empty(len(areas), np.int64)
        a_chord[walks[:, chords.piece]] = np.arange(len(chords.piece))
        around = faces.around(chords.start[a_chord[holes]], beside=holes)
        face = faces.face.copy()
        face[holes] = around
        return replace(faces, face=face)

    @property
    def beside(self) -> Integers:
        """Faces (2, p) on the left and on the right of each piece."""
        return self.face[self.walks]

    @cached_property
    def of_all_sides(self) -> Integers:
        """Faces (2, k) on the left and on the right of all pieces, loose ones among them."""
        found = np.empty((2, len(self.kept)), np.int64)
        found[:, self.kept] = self.beside
        middle = self.loose.points(np.arange(len(self.loose.kind)), self.loose.lengths / 2)
        found[:, ~self.kept] = self.around(middle)
        return found

    @cached_property
    def _component(self) -> Integers:
        """Number (w,) of the connected pieces that each walk is along."""
        return components(self.walks.T, len(self.areas))

    def around(self, points: Floats, beside: Integers | None = None) -> Integers:
        """Faces (n,) around points (n, 2), or OUTSIDE.

        Points that are on pieces, ``beside`` the walks (n,), are looked up among the other connected pieces.
        """
        chords = self.boundary.chords()
        met = list(crossed(np.stack([chords.start, chords.end], axis=1), points))
        between = bellies(self.boundary, points)
        point = np.tile(np.concatenate([between.point, *(some for some, _, _ in met)]), 2)
        piece = np.concatenate([between.piece, *(chords.piece[chord] for _, chord, _ in met)])
        walk = self.walks[:, piece].ravel()
        counts = self.areas[walk] > 0
        if beside is not None:
            counts &= self._component[walk] != self._component[beside][point]
        pairs, times = np.unique(point[counts] * len(self.areas) + walk[counts], return_counts=True)
        inside = RegionsAround(*np.divmod(pairs[times % 2 == 1], max(len(self.areas), 1)))
        return innermost(inside, len(points), self.areas) - 1


def walks_beside(boundary: Boundary) -> Integers:
    """Numbers (2, p) of the closed walks along the left and the right sides of noded pieces.

    A walk goes on along the next piece clockwise from the one on which it comes to a corner.
    """
    count = len(boundary.kind)
    piece = np.flatnonzero(~boundary.closed)
    # Of each end of a piece the side whose walk leaves the corner there, and the one whose walk comes to it.
    leaves, comes = np.concatenate([piece, count + piece]), np.concatenate([count + piece, piece])
    corner = np.concatenate([boundary.start[piece], boundary.end[piece]])
    order = np.lexsort((np.concatenate(directions(boundary, piece)), corner))
    leaves, comes, corner = leaves[order], comes[order], corner[order]
    first = np.flatnonzero(np.diff(corner, prepend=-1))
    clockwise = np.arange(len(corner)) - 1
    clockwise[first] = np.append(first[1:], len(corner))[: len(first)] - 1
    return components(np.column_stack([comes, leaves[clockwise]]), 2 * count).reshape(2, count)


def _areas(boundary: Boundary, walks: Integers) -> Floats:
    """Areas (w,) around which walks (2, p) beside pieces turn to the left, by their chords."""
    chords = boundary.chords()
    origin = boundary.corners.mean(axis=0) if len(boundary.corners) else 0.0  # the sum has more digits near it
    swept = cross(chords.start - origin, chords.end - origin) / 2
    areas = np.zeros(int(walks.max(initial=-1)) + 1)
    np.add.at(areas, walks[0, chords.piece], swept)
    np.subtract.at(areas, walks[1, chords.piece], swept)
    return areas
