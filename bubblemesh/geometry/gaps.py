"""Gaps between areas: the narrow strips that repairs fill."""

from collections.abc import Iterator, Sequence

import numpy as np
import shapely

from bubblemesh.geometry.nesting import Shapes, made_valid, polygons_of

FLAT_STRIP = 1e-6  # of a gap's square: strips of less area are due to rounding
LONG_STRIP = 10  # least length, in gaps, of a strip that begins where its areas touch in a point
AROUND = 8  # times its reach: distance of a strip from points where others touch, more than its corners need


def strips_between(
    polygons: Shapes, owners: Sequence[set[int]], gap: float, reach: float
) -> Iterator[tuple[shapely.Polygon, shapely.Polygon]]:
    """The strips between polygons (n,) that are nearer to each other than a gap, and the same extended by ``reach``.

    Polygons with a common owner, an area of which both are made, have no strip between them.
    """
    tree = shapely.STRtree(polygons)
    i, j = tree.query(polygons, predicate="dwithin", distance=gap)
    for a, b in zip(i[i < j].tolist(), j[i < j].tolist(), strict=True):
        if owners[a] & owners[b]:
            continue
        both = shapely.union_all([polygons[a], polygons[b]])
        closed = _closed(shapely.MultiPolygon([polygons[a], polygons[b]]), gap)
        for strip in polygons_of(shapely.difference(closed, both)):
            if strip.area > FLAT_STRIP * gap * gap and _is_between(strip, polygons[a], polygons[b], gap, reach):
                reaching = shapely.buffer(strip, reach, join_style="mitre")
                # It must not reach over a point in which another polygon touches one of both.
                others = np.setdiff1d(tree.query(reaching, predicate="intersects"), [a, b])
                for touched in shapely.intersection(polygons[others], both):
                    reaching = shapely.difference(reaching, touched.buffer(AROUND * reach))
                yield strip, reaching


def _closed(shape: shapely.Geometry, gap: float) -> shapely.Geometry:
    """A shape with its gaps filled, as far as there are sides across."""
    with np.errstate(divide="ignore", invalid="ignore"):  # GEOS divides by zero where sides go straight on
        wide = shapely.buffer(shape, gap / 2, join_style="mitre")
        closed = shapely.buffer(wide, -gap / 2, join_style="mitre")
    # At sharp corners its sides may cross.
    return closed if closed.is_valid else made_valid(closed)


def _is_between(strip: shapely.Polygon, a: shapely.Polygon, b: shapely.Polygon, gap: float, near: float) -> bool:
    """Whether a strip beside two polygons lies between them.

    If they touch in a point, a strip from there must be long. A wedge that soon becomes wider than the gap stays open,
    since closing its tip would turn the contact into a neck. A strip along one side only is due to rounding.
    """
    if shapely.distance(strip, a) > near or shapely.distance(strip, b) > near:
        return False
    common = shapely.get_parts(shapely.intersection(a, b))
    if np.count_nonzero(shapely.dwithin(common, strip, near)) != 1:
        return True
    points = shapely.get_coordinates(strip)
    middle = shapely.points((points[1:] + points[:-1]) / 2)
    length = np.hypot(*np.diff(points, axis=0).T)
    to_a, to_b = shapely.distance(middle, a), shapely.distance(middle, b)
    facing = [length[(one <= near) & (other <= gap)].sum() for one, other in ((to_a, to_b), (to_b, to_a))]
    return min(facing) > LONG_STRIP * gap
