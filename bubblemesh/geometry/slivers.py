"""Slivers: narrow gaps that neighbours leave open between each other."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.arrangement import NEARLY
from bubblemesh.geometry.borders import widths
from bubblemesh.geometry.nesting import Shapes, holes_of

LONG = 5.0  # area of a sliver in terms of its width's square, at least: where borders part at an angle there is less
WHOLE = 0.999  # of a hole: a gap with as much of it is all of it


class Slivers(NamedTuple):
    """Gaps between neighbours, the widest first."""

    widths: Floats  # (s,)
    places: Floats  # (s, 2)
    beside: Integers  # (s, 2), numbers of the two shapes beside the gap
    holes: Floats  # (s,), areas of those that are whole holes, else 0


def slivers(shapes: Shapes, names: Sequence[str], width: float) -> Slivers:
    """Gaps up to a ``width`` between valid polygons (n,) of different names: holes, and what is longer than wide."""
    none = Slivers(np.zeros(0), np.zeros((0, 2)), np.zeros((0, 2), np.int64), np.zeros(0))
    if len(set(names)) < 2:
        return none
    size = float(np.ptp(shapely.total_bounds(shapes).reshape(2, 2), axis=0).max())
    whole = shapely.union_all(shapes)
    gaps = shapely.get_parts(shapely.difference(closed(whole, width), whole))
    gaps = gaps[shapely.area(gaps) > (NEARLY * size) ** 2]
    wide = widths(gaps)
    enclosed = _enclosed(gaps, whole)
    thin = (wide > NEARLY * size) & (enclosed | (shapely.area(gaps) > LONG * wide**2))
    gaps, wide, enclosed = gaps[thin], wide[thin], enclosed[thin]
    gap, shape = shapely.STRtree(shapes).query(gaps, predicate="dwithin", distance=width / 100)
    beside = [list(dict.fromkeys(shape[gap == k].tolist())) for k in range(len(gaps))]
    pairs = [next(([a, b] for a in some for b in some if names[a] != names[b]), None) for some in beside]
    order = [k for k in np.argsort(-wide, kind="stable").tolist() if pairs[k]]
    if not order:
        return none
    places = shapely.get_coordinates(shapely.point_on_surface(gaps[order]))
    beside_them = np.array([pairs[k] for k in order], np.int64)
    return Slivers(wide[order], places, beside_them, np.where(enclosed, shapely.area(gaps), 0.0)[order])


def _enclosed(gaps: Shapes, whole: shapely.Geometry) -> Booleans:
    """Whether each of some gaps (n,) in a shape is a hole of it, as where three neighbours nearly meet."""
    holes = holes_of(whole)
    gap, hole = shapely.STRtree(holes).query(shapely.point_on_surface(gaps), predicate="within")
    enclosed = np.zeros(len(gaps), bool)
    enclosed[gap] = shapely.area(gaps[gap]) > WHOLE * shapely.area(holes[hole])
    return enclosed


def closed(shape: shapely.Geometry, width: float) -> shapely.Geometry:
    """A shape with all gaps narrower than a width filled."""
    return shapely.buffer(shapely.buffer(shape, width / 2, join_style="mitre"), -width / 2, join_style="mitre")


def hole_count(shape: shapely.Geometry) -> int:
    """Number of holes of all parts of a shape."""
    return int(shapely.get_num_interior_rings(shapely.get_parts(shape)).sum())
