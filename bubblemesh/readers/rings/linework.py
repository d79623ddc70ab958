"""Rings of lines that do not close: cut where they cross, extended to near lines, without loose ends."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely

from bubblemesh.arrays import Floats, Integers, components
from bubblemesh.errors import GeometryError
from bubblemesh.geometry import rings
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.nesting import Shapes, polygons_of
from bubblemesh.geometry.paths import Line, Ring, RingChange, Side, as_point
from bubblemesh.geometry.polygonal_copy import PolygonalCopy
from bubblemesh.geometry.repair import THIN
from bubblemesh.geometry.rings import LineTo
from bubblemesh.messages import counted
from bubblemesh.readers.features import CompoundCurve
from bubblemesh.readers.rings.joining import JoinedRings, Joining, rings_of_curves
from bubblemesh.readers.slips import Slips

MOST_LOOSE = 0.1  # of the length of all lines: so much may be left out as loose
OVER = 1e-9  # of the gap: so far an end is extended beyond the line that it meets
MOST_LINKS, ENDS_AT_ONCE = 8, 256  # lines near an end, on the average: a reach with more of them is no gap


def rings_of_linework(curves: Sequence[CompoundCurve], joining: Joining) -> JoinedRings:
    """Rings of the curves; if they do not close, the rings around all areas that their polygonal copies enclose.

    Ends that are near enough to another line are extended to it. Rings that are not connected may be nested.
    GeometryError if no area is enclosed, or much is left out.
    """
    try:
        return rings_of_curves(curves, joining)
    except GeometryError as error:
        problem = error
    copies = [_copy(curve) for curve in curves]
    drawn = [shapely.LineString(points) for points, _ in copies]
    links = _links(drawn, joining.reach or 0.0)
    if links is None:
        raise problem
    noded = shapely.get_parts(shapely.union_all(drawn + links))
    enclosed = [ring for group in _connected(noded) for ring in _around(group)]
    loose = np.concatenate([shapely.get_parts(some) for some in shapely.polygonize_full(noded)[1:3]])
    if not enclosed or shapely.length(loose).sum() > MOST_LOOSE * shapely.length(noded).sum():
        raise problem  # an outline that does not close must not be left out
    ends = np.concatenate([np.stack([points[:-1], points[1:]], axis=1) for points, _ in copies])
    chords = shapely.STRtree(shapely.linestrings(ends))
    labels = [label for _, some in copies for label in some]
    made = [_ring(points, chords, labels, curves[0].name) for points in enclosed]
    what = "lines that do not close cut where they cross, and closed"
    changes = [RingChange(what, as_point(enclosed[0][0]), 0.0, ())]
    if len(loose):
        longest = max(loose, key=shapely.length)
        before = tuple(shapely.get_coordinates(line) for line in loose)
        changes.append(
            RingChange(f"{counted(len(loose), 'loose line')} left out", as_point(longest.coords[0]), 0.0, before)
        )
    return JoinedRings([replace(made[0], changes=tuple(changes)), *made[1:]], [], Slips())


def _copy(curve: CompoundCurve) -> tuple[Floats, list[str | None]]:
    """Points (k, 2) of the polygonal copy of a curve, and the labels of its k - 1 chords."""
    pieces = list(curve.pieces)
    if curve.end != curve.start:
        pieces.append(LineTo(curve.start))
    if len(pieces) == 2 and all(isinstance(piece, LineTo) for piece in pieces):  # there and back again is not a ring
        return np.array([curve.start, curve.end], float), [curve.pieces[0].label]
    ring = rings.path(curve.start, pieces)
    copy = PolygonalCopy.of(Boundary.of([ring]))
    labels = [ring.sides[k].label for k in copy.piece.tolist()]
    if curve.end == curve.start:
        return np.vstack([copy.points, copy.points[:1]]), labels
    return copy.points, labels[:-1]


def _links(lines: Sequence[shapely.LineString], reach: float) -> list[shapely.LineString] | None:
    """Short lines from ends to the nearest place of another line within reach, and a little over it.

    None if so many lines are within reach that their ends do not show which of them was meant.
    """
    if reach == 0 or len(lines) < 2:
        return []
    owner = np.repeat(np.arange(len(lines)), 2)
    ends = shapely.points(np.array([point for line in lines for point in (line.coords[0], line.coords[-1])], float))
    found = np.array(lines, dtype=object)
    tree, pairs, count = shapely.STRtree(found), list[Integers](), 0
    for begin in range(0, len(ends), ENDS_AT_ONCE):
        pair = tree.query(ends[begin : begin + ENDS_AT_ONCE], predicate="dwithin", distance=reach)
        pair[0] += begin
        pairs.append(pair[:, owner[pair[0]] != pair[1]])
        count += pairs[-1].shape[1]
        if count > MOST_LINKS * len(ends):
            return None
    end, other = np.concatenate(pairs, axis=1)
    ways = shapely.shortest_line(ends[end], found[other])
    long = shapely.length(ways) > 0
    coords = shapely.get_coordinates(ways[long]).reshape(-1, 2, 2)
    coords[:, 1] += OVER * (coords[:, 1] - coords[:, 0])
    return list(shapely.linestrings(coords))


def _connected(lines: Shapes) -> list[Shapes]:
    """Groups of noded lines that are connected."""
    group = components(shapely.STRtree(lines).query(lines, predicate="intersects").T, len(lines))
    return [lines[group == number] for number in range(group.max() + 1)]


def _around(lines: Shapes) -> list[Floats]:
    """Rings (m, 2) around the area that connected lines enclose together."""
    x0, y0, x1, y1 = shapely.total_bounds(lines)
    thin = THIN * max(x1 - x0, y1 - y0)
    each = shapely.get_parts(shapely.polygonize(lines))
    wide = shapely.area(each) > thin * shapely.length(each) / 2  # there are slivers where lines lie on each other
    # Without holes, of which small ones would lose all of their points.
    whole = shapely.polygons(shapely.get_exterior_ring(polygons_of(shapely.union_all(each[wide]))))
    sparse = shapely.remove_repeated_points(whole, thin)
    found = np.where(shapely.is_valid(sparse), sparse, whole)
    return [shapely.get_coordinates(part)[:-1] for part in found]


def _ring(points: Floats, chords: shapely.STRtree, labels: Sequence[str | None], origin: str) -> Ring:
    """The ring along points (m, 2), with the labels of the nearest chords."""
    ahead = np.roll(points, -1, axis=0)
    near = chords.nearest(shapely.points((points + ahead) / 2)).tolist()
    ends = zip(map(as_point, points), map(as_point, ahead), near, strict=True)
    sides = tuple(Side(Line(a, b), labels[chord]) for a, b, chord in ends)
    return Ring(sides, tuple(map(as_point, points)), origin=origin)
