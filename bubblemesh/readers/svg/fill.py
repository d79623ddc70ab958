"""Areas that subpaths of one element bound together by its fill rule."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from bubblemesh.arrays import Booleans, Floats, ring_area
from bubblemesh.errors import GeometryError, LimitError
from bubblemesh.geometry import rings
from bubblemesh.geometry.arrangement.winding import FILL_RULES, FillRule, enclosed_areas, winding_numbers
from bubblemesh.geometry.nesting import enclosures
from bubblemesh.geometry.paths import Area, Ring, outlines
from bubblemesh.messages import counted
from bubblemesh.readers.features import CompoundCurve

FLAT_SUBPATH = 1e-9  # area of a subpath, in squares of its extent, that counts as zero
MOST_CROSSINGS = 20_000  # of subpaths: a few seconds
BATCH = 100  # chords in a block, to bound the memory


class FilledShape(NamedTuple):
    """Outlines of a filled shape: loops as they are, or rings made of them, and notes on changes."""

    loops: list[CompoundCurve]
    rings: list[Ring]
    notes: tuple[str, ...]


def filled(loops: Sequence[CompoundCurve], rule: FillRule) -> FilledShape:
    """Outlines of a shape that loops fill by a rule; inner loops may be holes.

    By ``evenodd``, points within an odd number of loops are filled; by ``nonzero``, points whose winding number is not
    0. Loops that cross are replaced by the boundary of the area that they fill.
    """
    copies = _outlines(loops)
    shapes = np.array([shapely.Polygon(points) for points in copies], dtype=object)
    if not _cross(shapes):
        kept = _bounding(shapes, rule)
        dropped = len(loops) - int(kept.sum())
        what = f"{counted(dropped, 'subpath')} within what is filled left out, by fill-rule nonzero"
        return FilledShape(
            [loop for loop, keep in zip(loops, kept, strict=True) if keep], [], (what,) if dropped else ()
        )
    _require_few_crossings(copies, loops[0].name)
    bounding = [loop for loop, points in zip(loops, copies, strict=True) if np.ptp(points, axis=0).any()]
    straight = ""
    try:
        areas = enclosed_areas(rule, [loop.ring for loop in bounding]) if bounding else []
    except GeometryError as error:
        areas = _enclosed_by_chords(copies, rule, loops[0].pieces[0].label)
        straight = f" of straight lines, since {error}"
    if not areas:
        return FilledShape([], [], (f"{counted(len(loops), 'subpath')} without an area left out",))
    made = [replace(ring, origin=loops[0].name) for area in areas for ring in area.rings]
    rims = counted(len(made), "ring")
    return FilledShape(
        [], made, (f"subpaths that cross are united by fill-rule {rule}: what they bound is {rims}{straight}",)
    )


def _require_few_crossings(outlines: Sequence[Floats], name: str) -> None:
    """LimitError if closed polylines through points (m, 2) cross so often that uniting them would take minutes."""
    lines = shapely.linestrings(_chords(outlines))
    tree, count = shapely.STRtree(lines), 0
    for first in range(0, len(lines), BATCH):
        count += len(tree.query(lines[first : first + BATCH], predicate="crosses")[0])
        if count > 2 * MOST_CROSSINGS:
            raise LimitError(f"{name}: its subpaths cross in more than {MOST_CROSSINGS:,} places: simplify it")


def _chords(outlines: Sequence[Floats]) -> Floats:
    return np.concatenate([np.stack([points, np.roll(points, -1, axis=0)], axis=1) for points in outlines])


def _enclosed_by_chords(outlines: Sequence[Floats], rule: FillRule, label: str | None) -> list[Area]:
    """Areas that closed polylines through points (m, 2) enclose by a rule."""
    chords = _chords(outlines)
    faces = shapely.get_parts(shapely.polygonize([shapely.union_all(shapely.linestrings(chords))]))
    spots = shapely.get_coordinates(shapely.point_on_surface(faces))
    whole = shapely.union_all(faces[FILL_RULES[rule](winding_numbers(chords, spots))])
    found = list[Area]()
    for part in shapely.get_parts(whole).tolist():
        outer, *holes = (
            rings.polygon(shapely.get_coordinates(ring).tolist(), label=label)
            for ring in (part.exterior, *part.interiors)
        )
        found.append(Area(outer, tuple(holes)))
    return found


def area_of(loop: CompoundCurve) -> float:
    """Area within a loop, in squares of its extent."""
    (points,) = _outlines([loop])
    size = float(np.ptp(points, axis=0).max())
    return abs(ring_area(points)) / size**2 if size > 0 else 0.0


def _outlines(loops: Sequence[CompoundCurve]) -> list[Floats]:
    """Points (m, 2) along each loop; three times its start if it has no extent."""
    found, whole = [np.array([loop.start] * 3) for loop in loops], dict[int, Ring]()
    for k, loop in enumerate(loops):
        with suppress(GeometryError):
            whole[k] = loop.ring
    for k, points in zip(whole, outlines(whole.values()), strict=True):
        found[k] = points
    return found


def _cross(shapes: "NDArray[np.object_]") -> bool:
    """Whether loops cross themselves or each other, or are the same."""
    if not shapely.is_valid(shapes).all():
        return True
    i, j = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    i, j = i[i < j], j[i < j]
    return bool((shapely.overlaps(shapes[i], shapes[j]) | shapely.equals(shapes[i], shapes[j])).any())


def _bounding(shapes: "NDArray[np.object_]", rule: FillRule) -> Booleans:
    """Mask (k,) of the loops with a filled area on one side only."""
    if rule == "evenodd":
        return np.ones(len(shapes), bool)
    turn = np.where(shapely.is_ccw(shapely.get_exterior_ring(shapes)), 1, -1)
    inner, around = enclosures(shapes, shapes)
    outside = np.bincount(inner, turn[around], minlength=len(shapes)).astype(np.int64)
    return np.asarray((outside != 0) != (outside + turn != 0))
