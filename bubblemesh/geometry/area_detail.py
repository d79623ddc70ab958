"""Detail that is left out of areas: small islands and holes, vertices, short borders."""

from collections.abc import Iterator, Sequence
from itertools import compress

import numpy as np
import shapely
from numpy.typing import NDArray

from bubblemesh.arrays import Floats
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.coverage import is_coverage
from bubblemesh.geometry.nesting import enclosures
from bubblemesh.geometry.paths import Line
from bubblemesh.geometry.repair_work import Work, outer_points
from bubblemesh.geometry.short_borders import without_short_borders
from bubblemesh.geometry.small_areas import absorbed, notes_of
from bubblemesh.messages import counted

CLEAR_CHANGE = 0.01  # of the area of a region
MOST_NAMED = 3
TOLERANCES = 12  # tried at most, to find one that leaves no vertex farther off than allowed
CLOSE = 1.05  # two of them are so close that no more are tried in between


def without_small(shapes: Sequence[shapely.Polygon], smallest: float, work: Work) -> list[shapely.Polygon]:
    """The polygons without smaller islands and holes."""
    large = [shapely.Polygon(shape.exterior).area >= smallest for shape in shapes]
    kept, small = list(compress(shapes, large)), [one for one, stays in zip(shapes, large, strict=True) if not stays]
    filled = [hole for shape in kept for hole in map(shapely.Polygon, shape.interiors) if hole.area < smallest]
    _note_small(work, "island", small, smallest, -sum(part.area for part in small))
    _note_small(work, "hole", filled, smallest, sum(part.area for part in filled))
    return [_with_large_holes(shape, smallest) for shape in kept]


def _with_large_holes(shape: shapely.Polygon, smallest: float) -> shapely.Polygon:
    kept = [loop for loop in shape.interiors if shapely.Polygon(loop).area >= smallest]
    return shapely.Polygon(shape.exterior, kept) if len(kept) < len(shape.interiors) else shape


def without_small_neighbours(
    shapes: Sequence[shapely.Polygon], names: Sequence[str], smallest: float, work: Work
) -> tuple[list[shapely.Polygon], list[str]]:
    """The polygons and their names, where smaller ones and holes have become part of what is beside them."""
    curved = any(not isinstance(side.curve, Line) for ring in work.rings for side in ring.sides)
    found = absorbed(np.array(shapes, dtype=object), names, smallest, curved)
    left, given = ([shapes[k] for k in numbers] for numbers in (found.left, found.given))
    gained = shapely.difference(shapely.MultiPolygon(found.filled), shapely.union_all(given)).area
    _note_small(work, "island", left, smallest, -sum(part.area for part in left))
    _note_small(work, "hole", found.filled, smallest, gained)
    _note_small(work, "area", given, smallest, 0.0, "given to a neighbour")
    work.notes += notes_of(found, shapes, names, smallest)
    return found.shapes, found.names


def _note_small(
    work: Work, kind: str, parts: Sequence[shapely.Polygon], smallest: float, area: float, fate: str = "left out"
) -> None:
    """Note the fate of parts of some kind that are below ``smallest``, if there are any, and the area that it gains."""
    if parts:
        largest = max(parts, key=lambda part: part.area)
        of_which = "" if len(parts) == 1 else ", the largest"
        what = f"{counted(len(parts), kind)} below {smallest:g} {fate}{of_which}"
        work.note(what, outer_points(largest)[0], area, map(outer_points, parts))


def require_beside_each_other(shapes: Sequence[shapely.Polygon], names: Sequence[str]) -> None:
    """Refuse polygons within others, which have no border there that could be simplified for both."""
    given = np.array(shapes, dtype=object)
    for inner, outer in zip(*enclosures(given, given), strict=True):
        raise GeometryError(
            f"simplify: {names[inner]!r} lies within {names[outer]!r}, which has no hole there: give it one, or leave "
            "out simplify",
            mendable=False,
        )


def simplified_areas(shapes: Sequence[shapely.Polygon], length: float, work: Work) -> list[shapely.Polygon]:
    """The polygons with fewer vertices, none of them farther than ``length`` from the rings that are left.

    The algorithm of Ramer, Douglas and Peucker; where areas have common sides, which stay so, that of Visvalingam and
    Whyatt. No rings cross afterwards; GeometryError if they do before. Rings with curves stay as they are.
    """
    given = np.array(shapes, dtype=object)
    if not shapely.is_valid(given).all() or not is_coverage(given):
        raise GeometryError("simplify: the rings cross, or the areas overlap: set repair: true as well")
    given = _without_short_borders(given, length, work)
    sparse, off, at = _sparsest(given, length, work)
    count, left = shapely.get_num_coordinates(given).sum(), shapely.get_num_coordinates(sparse).sum()
    if left == count:
        return list(given)
    note = f"{count - left:,} of {count:,} vertices left out, up to {off:.3g} off"
    area = float(shapely.area(sparse).sum() - shapely.area(given).sum())
    work.note(note, at, area, (shapely.get_coordinates(ring)[:-1] for ring in shapely.get_rings(given)))
    return list(sparse)


def changed_areas(
    before: Sequence[shapely.Polygon], after: Sequence[shapely.Polygon], names: Sequence[str]
) -> Iterator[str]:
    """The note on the areas of regions, by their ``names`` (n,), that simplifying has changed clearly, if any."""
    known, number = np.unique(np.array(names, dtype=object), return_inverse=True)
    old, new = (np.bincount(number, shapely.area(shapes)) for shapes in (before, after))
    change = (new - old) / old
    clear = [k for k in np.argsort(-np.abs(change), kind="stable").tolist() if abs(change[k]) >= CLEAR_CHANGE]
    if clear:
        told = [f"{known[k]!r} from {old[k]:.6g} to {new[k]:.6g} ({change[k]:+.1%})" for k in clear[:MOST_NAMED]]
        more = f" and {counted(len(clear) - len(told), 'more region')}" if len(clear) > len(told) else ""
        yield f"simplify changes the areas of regions: {', '.join(told)}{more}: a smaller length changes them less"


def _sparsest(given: "NDArray[np.object_]", length: float, work: Work) -> tuple["NDArray[np.object_]", float, Floats]:
    """The polygons with the largest tolerance for which no vertex is farther off than a length; how far, and where.

    It is found by halving, then by bisection: tolerances of areas bound no distances. They may stay as they are.
    """
    points = shapely.get_coordinates(given)
    best, farthest, at = given, 0.0, points[0]
    tolerance, within, beyond = length, 0.0, np.inf
    for _ in range(TOLERANCES):
        found = []
        for before, after in zip(given, _sparser(given, tolerance), strict=True):
            mixed = _with_curves_kept(before, after, work)
            found.append(mixed if mixed.is_valid else before)
        sparse = np.array(found, dtype=object)
        off = _from_rings(points, sparse)
        if off.max() <= length:
            best, farthest, at, within = sparse, float(off.max()), points[off.argmax()], tolerance
        else:
            beyond = tolerance
        if beyond <= CLOSE * within or within == length:
            break
        tolerance = np.sqrt(within * beyond) if within > 0 else beyond / 2
    return best, farthest, at


def _without_short_borders(given: "NDArray[np.object_]", length: float, work: Work) -> "NDArray[np.object_]":
    """The polygons with borders between them of no more than a length as points, which no vertex left out removes."""
    if any(work.is_curved(outer_points(shapely.Polygon(ring))) for ring in shapely.get_rings(given)):
        return given
    merged, at, off = without_short_borders(given, length)
    if len(at):
        before = (shapely.get_coordinates(ring)[:-1] for ring in shapely.get_rings(given))
        borders = f"{counted(len(at), 'short border')} between areas closed to a point, up to {off:.3g} off"
        work.note(borders, at[0], 0.0, before)
    return merged


def _sparser(given: "NDArray[np.object_]", tolerance: float) -> Sequence[shapely.Polygon]:
    """The polygons with fewer vertices; the tolerance is a length for separate areas, else the root of an area."""
    neighbours = shapely.STRtree(given).query(given, predicate="touches")[0]
    if len(neighbours):
        return list(shapely.coverage_simplify([*given, *_pins(given)], tolerance))[: len(given)]
    made = shapely.get_parts(shapely.simplify(shapely.multipolygons(given), tolerance))
    return list(made) if len(made) == len(given) else list(given)


def _pins(given: "NDArray[np.object_]") -> list[shapely.Polygon]:
    """Triangles outside, two at each corner of the box around all polygons that is one of their vertices.

    A vertex of three polygons stays, and so the frame of a picture does.
    """
    x0, y0, x1, y1 = shapely.total_bounds(given).tolist()
    vertices = set(map(tuple, shapely.get_coordinates(given).tolist()))
    found = list[shapely.Polygon]()
    for x, away in ((x0, x0 - x1), (x1, x1 - x0)):
        for y, up in ((y0, y0 - y1), (y1, y1 - y0)):
            if (x, y) in vertices:
                corner, beyond = (x, y), (x + away, y + up)
                found += [shapely.Polygon([corner, beside, beyond]) for beside in ((x + away, y), (x, y + up))]
    return found


def _from_rings(points: Floats, shapes: "NDArray[np.object_]") -> Floats:
    """Distances (n,) of points (n, 2) from the nearest side of any of the polygons."""
    rims, ring = shapely.get_coordinates(shapely.get_rings(shapes), return_index=True)
    same = np.flatnonzero(np.diff(ring) == 0)
    tree = shapely.STRtree(shapely.linestrings(np.stack([rims[same], rims[same + 1]], axis=1)))
    return np.asarray(tree.query_nearest(shapely.points(points), all_matches=False, return_distance=True)[1])


def _with_curves_kept(before: shapely.Polygon, after: shapely.Polygon, work: Work) -> shapely.Polygon:
    """The polygon ``after``, with its rings as they were ``before`` where these have curves."""
    pairs = zip((before.exterior, *before.interiors), (after.exterior, *after.interiors), strict=True)
    outer, *holes = (old if work.is_curved(outer_points(shapely.Polygon(old))) else new for old, new in pairs)
    return shapely.Polygon(outer, holes)
