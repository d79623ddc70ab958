"""What subpaths of one element bound together by its fill rule."""

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.errors import GeometryError
from bubblemesh.geometry import rings
from bubblemesh.geometry.polygonal_copy import outline
from bubblemesh.geometry.rings import LineTo
from bubblemesh.messages import counted
from bubblemesh.readers.features import CompoundCurve

MOST_PAIRS = 200_000_000  # of faces and chords: a second or two


def filled(loops: Sequence[CompoundCurve], rule: str) -> tuple[list[CompoundCurve], tuple[str, ...]]:
    """Loops that bound what is filled, each other's holes included, and notes on what was changed.

    By ``evenodd`` what an odd number of loops is around is filled, else (nonzero) what they do not turn around as often
    to the left as to the right. Loops that cross are replaced by the rims of what they fill, of straight lines.
    """
    outlines = [_outline(loop) for loop in loops]
    shapes = np.array([shapely.Polygon(points) for points in outlines], dtype=object)
    if not _cross(shapes):
        kept = _bounding(shapes, [_is_left(points) for points in outlines], rule)
        dropped = len(loops) - int(kept.sum())
        what = f"{counted(dropped, 'subpath')} within what is filled left out, by fill-rule nonzero"
        return [loop for loop, keep in zip(loops, kept, strict=True) if keep], (what,) if dropped else ()
    faces = [
        face
        for face in shapely.get_parts(
            shapely.polygonize([shapely.union_all([*map(shapely.LineString, map(_closed, outlines))])])
        )
    ]
    if len(faces) * sum(map(len, outlines)) > MOST_PAIRS:
        return list(loops), ()
    spots = shapely.get_coordinates([shapely.point_on_surface(face) for face in faces])
    turns = sum((_turns(points, spots) for points in outlines), np.zeros(len(spots), np.int64))
    whole = shapely.union_all(
        [face for face, number in zip(faces, turns.tolist(), strict=True) if _is_filled(number, rule)]
    )
    label, name = loops[0].pieces[0].label, loops[0].name
    made = []
    for part in shapely.get_parts(whole).tolist():
        for ring in (part.exterior, *part.interiors):
            start, *others = [(x, y) for x, y in shapely.get_coordinates(ring).tolist()]
            made.append(CompoundCurve(start, tuple(LineTo(point, label) for point in others), name))
    rims = counted(len(made), "ring")
    note = f"subpaths that cross are united by fill-rule {rule}: what they bound is {rims} of straight lines"
    return made, (note,)


def area_of(loop: CompoundCurve) -> float:
    """Area within a loop, in terms of the square of its extent."""
    points = _outline(loop)
    x, y = (points - points[0]).T
    size = float(np.ptp(points, axis=0).max())
    return abs(float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))) / 2 / size**2 if size > 0 else 0.0


def _outline(loop: CompoundCurve) -> Floats:
    """Points (m, 2) along a loop; three times its start if it has no extent."""
    try:
        return outline(rings.path(loop.start, loop.pieces))
    except GeometryError:
        return np.array([loop.start] * 3)


def _closed(points: Floats) -> Floats:
    return np.vstack([points, points[:1]])


def _is_left(points: Floats) -> bool:
    x, y = (points - points[0]).T
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) > 0


def _cross(shapes: "NDArray[np.object_]") -> bool:
    """Whether loops cross themselves or each other, or are the same."""
    if not shapely.is_valid(shapes).all():
        return True
    i, j = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    i, j = i[i < j], j[i < j]
    return bool((shapely.overlaps(shapes[i], shapes[j]) | shapely.equals(shapes[i], shapes[j])).any())


def _bounding(shapes: "NDArray[np.object_]", left: list[bool], rule: str) -> Booleans:
    """Mask (k,) of the loops on whose two sides it is filled on one alone."""
    if rule == "evenodd":
        return np.ones(len(shapes), bool)
    turn = np.where(left, 1, -1)
    inner, around = shapely.STRtree(shapes).query(shapes, predicate="covered_by")
    inner, around = inner[inner != around], around[inner != around]
    outside = np.bincount(inner, turn[around], minlength=len(shapes)).astype(np.int64)
    return np.asarray((outside != 0) != (outside + turn != 0))


def _is_filled(turns: int, rule: str) -> bool:
    return turns % 2 == 1 if rule == "evenodd" else turns != 0


def _turns(points: Floats, spots: Floats) -> Integers:
    """How often a loop through points (m, 2) turns around each of the spots (n, 2), to the left."""
    (ax, ay), (bx, by) = points.T, np.roll(points, -1, axis=0).T
    found = np.zeros(len(spots), np.int64)
    for k, (x, y) in enumerate(spots.tolist()):
        side = (bx - ax) * (y - ay) - (by - ay) * (x - ax)
        found[k] = int(np.sum((ay <= y) & (by > y) & (side > 0))) - int(np.sum((ay > y) & (by <= y) & (side < 0)))
    return found
