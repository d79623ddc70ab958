"""A part of the sea with fewer points, whose rings do not cross: where they would, more points stay."""

from collections.abc import Iterator, Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from bubblemesh.arrays import Booleans, Floats, Integers, members
from bubblemesh.problem.shoreline.box import side_of_box
from bubblemesh.problem.shoreline.thinning import ShoreDetail, thinned

DETAIL_HALVINGS = 8  # of the detail where rings cross; then all points stay there
ATTEMPTS = 40  # until none does; after half of them they are whole rings that get more detail
NO_POINTS = np.zeros((0, 2))


def simplified(
    part: shapely.Polygon, sides: Sequence[Floats], detail: ShoreDetail, kept: Floats = NO_POINTS
) -> shapely.Polygon:
    """A part of the sea with fewer points, but for those ``kept`` (k, 2) and those on the sides of the box.

    Where rings would cross or vanish, more of their points stay.
    """
    rings = [shapely.get_coordinates(ring)[:-1] for ring in (part.exterior, *part.interiors)]
    on_box = [side_of_box(ring, sides) >= 0 for ring in rings]
    spacings = [detail.spacing(ring) for ring in rings]
    given = _as_complex(kept)
    stay = [np.isin(_as_complex(ring), given) | shared for ring, shared in zip(rings, _shared(rings), strict=True)]
    halvings = [np.zeros(len(ring), np.int64) for ring in rings]
    left = [np.arange(len(ring)) for ring in rings]
    changed = np.arange(len(rings))
    for attempt in range(ATTEMPTS):
        for k in changed.tolist():
            fixed = on_box[k] | np.roll(on_box[k], 1) | stay[k] | (halvings[k] > DETAIL_HALVINGS)
            left[k] = thinned(rings[k], fixed, spacings[k] / 2.0 ** halvings[k], detail.short)
        few = [ring[points] for ring, points in zip(rings, left, strict=True)]
        changed = _faulty(few)
        crossing = [_between(left[k], crossed, len(rings[k])) for k, crossed in _crossing_sides(few, changed)]
        for k, near in zip(changed.tolist(), crossing, strict=True):
            halvings[k] += near if near.any() and attempt < ATTEMPTS // 2 else 1
        changed = np.array([k for k in changed.tolist() if len(left[k]) < len(rings[k])], np.int64)
        if len(changed) == 0:
            break
    made = shapely.Polygon(few[0], few[1:])
    return made if made.is_valid else part


def _crossing_sides(rings: Sequence[Floats], among: Integers) -> Iterator[tuple[int, Integers]]:
    """Numbers (k,) of the sides of each of some rings (n, 2) that meet another side elsewhere than at common ends."""
    if len(among) == 0:
        return
    starts = np.vstack([rings[k] for k in among])
    ends = np.vstack([np.roll(rings[k], -1, axis=0) for k in among])
    lines = shapely.linestrings(np.stack([starts, ends], axis=1))
    first, second = shapely.STRtree(lines).query(lines, predicate="intersects")
    first, second = first[first < second], second[first < second]
    own = np.column_stack([_as_complex(starts), _as_complex(ends)])
    common = (own[first][:, :, None] == own[second][:, None]).any(axis=(1, 2))
    crossing = np.zeros(len(lines), bool)
    bad = ~(common & shapely.touches(lines[first], lines[second]))
    crossing[first[bad]] = crossing[second[bad]] = True
    parts = np.split(crossing, np.cumsum([len(rings[k]) for k in among])[:-1])
    yield from zip(among.tolist(), map(np.flatnonzero, parts), strict=True)


def _between(points: Integers, sides: Integers, n: int) -> Booleans:
    """Mask (n,) of the points of a ring from the start of each of some sides to its end, by those left (k,) of it."""
    last = np.append(points[1:], points[0] + n)
    side, rank = members((last - points)[sides] + 1)
    near = np.zeros(n, bool)
    near[(points[sides][side] + rank) % n] = True
    return near


def _shared(rings: Sequence[Floats]) -> list[Booleans]:
    """Mask (n,) for each of some rings (n, 2) of the points at which it touches another one."""
    _, number, count = np.unique(_as_complex(np.vstack(rings)), return_inverse=True, return_counts=True)
    return np.split(count[number] > 1, np.cumsum([len(ring) for ring in rings])[:-1])


def _faulty(rings: Sequence[Floats]) -> Integers:
    """Numbers (k,) of rings that have no area, or that cross themselves or another one; the first is around others."""
    whole = np.array([len(ring) > 2 and shapely.Polygon(ring).is_valid for ring in rings])
    lines = np.array([shapely.LineString(np.vstack([ring, ring[:1]])) for ring in rings], dtype=object)
    first, second = shapely.STRtree(lines).query(lines, predicate="intersects")
    first, second = first[first < second], second[first < second]
    checked = whole[first] & whole[second]
    first, second = first[checked], second[checked]
    crossing = np.zeros(len(rings), bool)
    for one, other in zip(first.tolist(), second.tolist(), strict=True):
        touching = shapely.covers if one == 0 else shapely.touches
        crossing[[one, other]] |= not touching(shapely.Polygon(rings[one]), shapely.Polygon(rings[other]))
    return np.flatnonzero(~whole | crossing)


def _as_complex(points: Floats) -> NDArray[np.complex128]:
    """Points (n, 2) as numbers (n,), which can be looked up."""
    return points[:, 0] + 1j * points[:, 1]
