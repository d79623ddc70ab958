"""Rings traced from the pieces that bound an area, whatever curves these were cut from."""

from dataclasses import replace

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers, each_once, ring_area
from bubblemesh.geometry.boundary import COLUMNS, Boundary
from bubblemesh.geometry.corners import CornerFans, corner_fans
from bubblemesh.geometry.curves import Family, selected
from bubblemesh.geometry.nesting import smallest_around


def face(boundary: Boundary, rim: Booleans) -> tuple[Boundary, Integers]:
    """The boundary of the area on the left of the rim, a mask (p,) of pieces, and the old numbers (p,) of its pieces.

    The pieces of the rim come first, ring by ring, outer rings first; all others are inner pieces. The ring numbers of
    the given boundary are those of rings from which pieces may have been cut: at a corner where only such pieces meet,
    a piece is followed by one of the same ring.
    """
    loops = _loops(boundary, rim)
    chords = _chords(boundary)
    outlines = [np.concatenate([chords[piece] for piece in loop.tolist()]) for loop in loops]
    areas = np.array([ring_area(points) for points in outlines])
    outer, holes = np.flatnonzero(areas > 0), np.flatnonzero(areas <= 0)
    shapes = np.array([shapely.Polygon(points) for points in outlines], dtype=object)
    owner = smallest_around(shapes[holes], shapes[outer])
    order = [loops[k] for k in (*outer, *holes)]
    pieces = np.concatenate([*order, np.flatnonzero(~rim)])
    inner = len(pieces) - sum(map(len, order))
    ring = np.repeat(np.append(np.arange(len(order)), -1), [*map(len, order), inner])
    traced = replace(boundary.select(pieces), ring=ring, area_of_ring=(*range(len(outer)), *owner.tolist()))
    return traced, pieces


def compact(boundary: Boundary, kept: Integers) -> tuple[Boundary, Integers]:
    """The boundary without curves and corners that it does not need, and the old numbers (c,) of its corners.

    Corners ``kept`` (k,), such as embedded points, stay.
    """
    columns = {name: getattr(boundary, name).copy() for name in COLUMNS}
    families = list[Family]()
    for k, curves in enumerate(boundary.families):
        mine = boundary.kind == k
        used, columns["index"][mine] = np.unique(boundary.index[mine], return_inverse=True)
        columns["kind"][mine] = len(families)
        families += [selected(curves, used)] if len(used) else []
    open_ = ~boundary.closed
    corners = each_once(np.concatenate([boundary.start[open_], boundary.end[open_], kept]))
    for name in ("start", "end"):
        columns[name][open_] = np.searchsorted(corners, columns[name][open_])
    labels, columns["label"] = np.unique(boundary.label, return_inverse=True)
    names = tuple(boundary.labels[label] for label in labels.tolist())
    small = replace(boundary, **columns, families=tuple(families), corners=boundary.corners[corners], labels=names)
    return small, corners


def _loops(boundary: Boundary, rim: Booleans) -> list[Integers]:
    """Pieces of the rim in the order of each ring, which begins with its first piece."""
    pieces = np.flatnonzero(rim)
    leaving = np.bincount(boundary.start[pieces[~boundary.closed[pieces]]], minlength=len(boundary.corners))
    after = np.full(len(boundary.kind), -1)
    first = np.full(len(boundary.corners), -1)
    open_ = pieces[~boundary.closed[pieces]]
    first[boundary.start[open_]] = open_
    after[open_] = first[boundary.end[open_]]
    unclear = open_[leaving[boundary.end[open_]] > 1]
    if len(unclear):
        fans = corner_fans(boundary)
        for piece in unclear.tolist():
            after[piece] = _following(boundary, rim, fans, piece)
    after[pieces[boundary.closed[pieces]]] = pieces[boundary.closed[pieces]]
    loops, left = [], rim.copy()
    following = after.tolist()
    for piece in pieces.tolist():
        if left[piece]:
            loop = [piece]
            while (piece := following[piece]) != loop[0]:
                loop.append(piece)
            loops.append(np.array(loop))
            left[loops[-1]] = False
    return loops


def _following(boundary: Boundary, rim: Booleans, fans: CornerFans, piece: int) -> int:
    """The piece of the rim that goes on from a corner of several: the next one clockwise.

    Where only rings meet it is one of the same ring. Each piece so follows one other.
    """
    at = np.flatnonzero(fans.corner == boundary.end[piece])
    here = int(np.flatnonzero((fans.piece[at] == piece) & ~fans.forward[at])[0])
    clockwise = np.roll(at, -here)[::-1]  # from the one before it to itself, as fans are counter-clockwise
    others = [int(fans.piece[k]) for k in clockwise if fans.forward[k] and rim[fans.piece[k]]]
    ring = boundary.ring[piece]
    only_rings = ring >= 0 and (boundary.ring[others] >= 0).all()
    return next((other for other in others if only_rings and boundary.ring[other] == ring), others[0])


def _chords(boundary: Boundary) -> list[Floats]:
    """Points (k, 2) at which the chords of each piece start."""
    piece, s, _ = boundary.stations()
    starts = boundary.chord_starts(piece, s)
    return np.split(starts, np.searchsorted(piece, np.arange(1, len(boundary.kind))))
