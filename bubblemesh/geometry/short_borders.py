"""Short borders between areas that share all of their borders: their two ends become one point."""

import numpy as np
import shapely

from bubblemesh.arrays import Floats, Integers, different_rows
from bubblemesh.geometry.coverage import is_coverage
from bubblemesh.geometry.nesting import Shapes

MEETING = 3  # borders in a point where areas meet


def without_short_borders(shapes: Shapes, length: float) -> tuple[Shapes, Floats, float]:
    """Polygons (n,) with exactly shared borders, where points in which borders meet are one if they are near.

    These are the ends of a side not longer than ``length``, both inside: at the rim of all polygons a needle would be
    left. Also the points (m, 2) that are gone, and how far they were moved at most. Polygons that would vanish or cross
    stay.
    """
    given = shapely.get_coordinates(shapes)
    points, number = different_rows(given)
    sides = _sides(shapes, number.ravel())
    place = _places(points, sides, length)
    while True:
        moved = np.flatnonzero(place != np.arange(len(points)))
        made = _moved(shapes, points[place][number.ravel()])
        wrong = ~shapely.is_valid(made) | (shapely.area(made) <= 0)
        if not wrong.any() or len(moved) == 0:
            break
        owner = np.repeat(np.arange(len(shapes)), shapely.get_num_coordinates(shapes))
        stay = np.unique(number.ravel()[wrong[owner]])  # vertices of polygons that would vanish
        kept = np.isin(np.arange(len(points)), stay) | np.isin(place, stay)
        place = np.where(kept, np.arange(len(points)), place)
    if not is_coverage(made):
        return shapes, points[:0], 0.0
    off = np.hypot(*(points[place] - points).T)
    return made, points[moved], float(off.max(initial=0.0))


def _sides(shapes: Shapes, number: Integers) -> Integers:
    """Sides (k, 3) of the polygons: two vertices, the lower number first, and how many polygons have the side."""
    _, ring = shapely.get_coordinates(shapely.get_rings(shapes), return_index=True)
    same = np.flatnonzero(np.diff(ring) == 0)
    pairs = np.sort(np.column_stack([number[same], number[same + 1]]), axis=1)
    rows, count = np.unique(pairs, axis=0, return_counts=True)
    return np.column_stack([rows, count])


def _places(points: Floats, sides: Integers, length: float) -> Integers:
    """Number (p,) of the vertex to which each vertex is moved, most of them to themselves."""
    degree = np.bincount(sides[:, :2].ravel(), minlength=len(points))
    rim = np.zeros(len(points), bool)
    rim[sides[sides[:, 2] == 1, :2]] = True
    first, second = sides[:, 0], sides[:, 1]
    long = np.hypot(*(points[first] - points[second]).T)
    meeting = (degree >= MEETING) & ~rim
    short = np.flatnonzero((long <= length) & meeting[first] & meeting[second])
    place, used = np.arange(len(points)), set[int]()
    for k in short[np.argsort(long[short], kind="stable")].tolist():
        a, b = int(first[k]), int(second[k])  # as points ascend: also the same one of two in a periodic copy
        if a not in used and b not in used:  # chains of short sides do not fall together
            place[b] = a
            used |= {a, b}
    return place


def _moved(shapes: Shapes, coordinates: Floats) -> Shapes:
    """The polygons with other coordinates, without points twice in a row."""
    made = shapely.set_coordinates(shapes.copy(), coordinates)
    return np.asarray(shapely.remove_repeated_points(made), dtype=object)
