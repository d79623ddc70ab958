"""Channels of the sea that are too narrow for a spacing: they are closed."""

import numpy as np
import shapely

from bubblemesh.arrays import Floats, members
from bubblemesh.geometry.nesting import polygons_of
from bubblemesh.messages import counted
from bubblemesh.problem.shoreline.box import Sea, box_size, open_sea
from bubblemesh.problem.shoreline.thinning import SpacingAt

SLIVER = 0.25  # of the square of the narrowest width: smaller narrow parts are corners
BAND = 1.05  # ratio of widths that are taken to be one
TOUCHING = 1.07  # a little more than that
PIECE = 16  # sides of a line that are grown at once: the time of long ones goes with the square of their points
AT_ONCE, GROUP = 4000, 100  # shapes whose union is made in one call, and neighbours that are united before
LEAST_WIDTH = 1e-6  # of the box's size: a spacing that is not a length is refused later


def without_narrow(sea: Sea, spacing: SpacingAt, narrowest: float, smallest: float) -> Sea:
    """The sea without what is narrower than so many of the spacings there, and what only that joins to the open side.

    What stays is covered by discs in the sea whose middles are half of that width away from each point of the shore, as
    the spacing is at that point.
    """
    shape = shapely.union_all(sea.parts)
    size = box_size(sea.sides)

    def half_width(points: Floats) -> Floats:
        return np.maximum(narrowest / 2 * spacing(points), LEAST_WIDTH * size)

    middles = shape.difference(_grown(shape, half_width))
    wide = shapely.union_all([middles, _grown(middles, _touching(shape))])
    seas = polygons_of(shape)
    apart = [part for part in seas if part.disjoint(wide)]  # narrow all over, and no corners, however small they are
    reached = shapely.MultiPolygon([part for part in seas if part.intersects(wide)]) if apart else shape
    parts = polygons_of(reached.difference(wide))
    widths = 2 * half_width(shapely.get_coordinates([part.point_on_surface() for part in parts]))
    narrow = [(part, width) for part, width in zip(parts, widths, strict=True) if part.area > SLIVER * width**2]
    if not apart and not narrow:
        return sea
    # A little more, so that no slivers stay between them and the shore.
    cut = reached.difference(
        shapely.union_all([part.buffer(0.01 * width, join_style="mitre") for part, width in narrow])
    )
    parts_closed = counted(len(apart) + len(narrow), "part")
    closed = f"{parts_closed} of the sea closed, narrower than {narrowest:g} spacings there"
    wide_sea = sea._replace(parts=polygons_of(cut), notes=(*sea.notes, closed))
    return open_sea(wide_sea, smallest, f"ask for less than narrowest: {narrowest:g}")


def _grown(shape: shapely.Geometry, radius: SpacingAt) -> shapely.Geometry:
    """Area no farther from the boundary of a shape than a radius there, as it is in bands of nearly equal radii."""
    pieces, radii = list[shapely.LineString](), list[float]()
    for part in polygons_of(shape):
        for ring in (part.exterior, *part.interiors):
            points = _with_points_between(shapely.get_coordinates(ring), radius)
            band = np.floor(np.log(1.02 * radius((points[:-1] + points[1:]) / 2)) / np.log(BAND)).astype(np.int64)
            first = np.flatnonzero((np.diff(band, prepend=band[0]) != 0) | (np.arange(len(band)) % PIECE == 0))
            ends = [*first[1:].tolist(), len(band)]
            pieces += [shapely.LineString(points[begin : end + 1]) for begin, end in zip(first, ends, strict=True)]
            radii += (BAND ** band[first].astype(float)).tolist()
    shapes = shapely.buffer(pieces, radii)
    # In one go if they are few; many take much longer so, and nothing could interrupt it.
    while len(shapes) > AT_ONCE:
        groups = np.split(shapes, range(GROUP, len(shapes), GROUP))
        shapes = np.array([shapely.union_all(group) for group in groups], dtype=object)
    return shapely.union_all(shapes)


def _with_points_between(line: Floats, radius: SpacingAt) -> Floats:
    """A line (n, 2) with points (m, 2) in steps of half a radius at most."""
    length = np.hypot(*np.diff(line, axis=0).T)
    least = np.minimum(radius(line[:-1]), radius(line[1:]))
    pieces = np.maximum(np.ceil(2 * length / least), 1).astype(np.int64)
    side, rank = members(pieces)
    share = (rank / pieces[side])[:, None]
    return np.vstack([line[side] * (1 - share) + line[side + 1] * share, line[-1:]])


def _touching(shape: shapely.Geometry) -> SpacingAt:
    """The radii of discs that touch the boundary of a shape, and a little more."""
    rings = [shapely.get_coordinates(ring) for part in polygons_of(shape) for ring in (part.exterior, *part.interiors)]
    sides = np.vstack([np.stack([ring[:-1], ring[1:]], axis=1) for ring in rings])
    tree = shapely.STRtree(shapely.linestrings(sides))

    def radius(points: Floats) -> Floats:
        _, distance = tree.query_nearest(shapely.points(points), return_distance=True, all_matches=False)
        return TOUCHING * np.asarray(distance, float)

    return radius
