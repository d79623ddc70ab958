"""The sea in a box: land cut out of it, with open, land and island boundaries."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from bubblemesh.arrays import Booleans, Floats, Integers, members
from bubblemesh.case.domain import ShoreDomain
from bubblemesh.errors import GeometryError, prefixed
from bubblemesh.geometry.geography import projected, projected_line
from bubblemesh.geometry.nesting import polygons_of
from bubblemesh.geometry.paths import Area, Line, Point, Polyline, Ring, Side, as_point
from bubblemesh.messages import counted
from bubblemesh.readers.shores import ON_SIDE, land_in

OPEN, LAND, ISLAND = "open", "land", "island"
SHORE = LAND, ISLAND
PARTS_OF_SIDES = 1000  # of the box, before it is projected
STRAIGHT = 1e-7  # of the box's size: how far points are from a straight side that are left out
DETAIL = 0.1  # spacings
SHORT = 0.5  # spacings: of points nearer to each other one is left out, where the detail is auto
SLIVER = 0.25  # of the square of the narrowest width: smaller narrow parts are corners
BAND = 1.05  # ratio of widths that are taken to be one
TOUCHING = 1.07  # a little more than that
PIECE = 16  # sides of a line that are grown at once: the time of long ones goes with the square of their points
LEAST_WIDTH = 1e-6  # of the box's size: a spacing that is none is refused later
HALVINGS = 8  # of the detail where rings cross; then all points stay there
ATTEMPTS = 40  # until none does; after half of them they are whole rings that get more detail

SpacingAt = Callable[[Floats], Floats]
Complex = NDArray[np.complex128]
NO_POINTS: Complex = np.zeros(0, complex)


class Sea(NamedTuple):
    """Parts of the sea, the sides (4) of the box around it, and notes on what was left out."""

    parts: list[shapely.Polygon]
    sides: tuple[Floats, ...]
    notes: tuple[str, ...]


def sea_in_box(keys: ShoreDomain) -> Sea:
    """The sea in the box of a domain, with all detail; errors have the file.

    Parts without an open side, which no tide reaches, and what is smaller than the smallest area are left out.
    """
    x0, y0, x1, y1 = keys.box
    corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)]
    step = max(x1 - x0, y1 - y0) / PARTS_OF_SIDES
    around = shapely.transform(shapely.segmentize(shapely.MultiLineString(list(pairwise(corners))), step), projected)
    straight = STRAIGHT * max(np.ptp(np.array(around.bounds).reshape(2, 2), axis=0))
    sides = tuple(map(shapely.get_coordinates, shapely.get_parts(shapely.simplify(around, straight))))
    shore = keys.shoreline
    with prefixed(shore.file):
        faces = land_in(Path(shore.file), shore.of, shore.layer, keys.box)
        # Cut where the sides of the box are straight still, so that land which ends on one has no sea beside it.
        frame, shape = shapely.segmentize(shapely.box(*keys.box), step), shapely.union_all(faces.shapes)
        sea = frame.intersection(shape) if faces.of_sea else frame.difference(shape)
        parts = [valid for part in polygons_of(sea) for valid in polygons_of(shapely.make_valid(_in_plane(part)))]
        return _kept(shapely.simplify(shapely.MultiPolygon(parts), straight), sides, shore.smallest or 0.0, faces.notes)


def _in_plane(part: shapely.Polygon) -> shapely.Polygon:
    """A part of the sea in the plane, with more points on sides that are not straight there."""
    around, *islands = (projected_line(shapely.get_coordinates(ring)) for ring in (part.exterior, *part.interiors))
    return shapely.Polygon(around, islands)


def _kept(
    sea: shapely.Geometry,
    sides: Sequence[Floats],
    smallest: float,
    told: Sequence[str],
    advice: str = "correct the box, or say of: sea if the shapes are water",
) -> Sea:
    """Parts of the sea that are open and large, without small islands."""
    found, notes = polygons_of(sea), list(told)
    rim = shapely.MultiLineString([shapely.LineString(side) for side in sides])
    size = max(np.ptp(np.vstack(sides), axis=0))
    opened = [part for part in found if part.boundary.intersection(rim.buffer(ON_SIDE * size)).length > 1e-3 * size]
    closed = len(found) - len(opened)
    if closed:
        notes.append(f"{counted(closed, 'part')} of the sea that no open side reaches left out")
    large = [part for part in opened if part.area >= smallest]
    if len(large) < len(opened):
        notes.append(f"{counted(len(opened) - len(large), 'part')} of the sea below {smallest:.6g} left out")
    if opened and not large:
        advice = f"all of it is below smallest: {smallest:.6g}: ask for less"
    if not large:
        raise GeometryError(f"no sea is left in the box: {advice}")
    holes = [[ring for ring in part.interiors if shapely.Polygon(ring).area >= smallest] for part in large]
    dropped = sum(len(part.interiors) for part in large) - sum(map(len, holes))
    if dropped:
        notes.append(f"{counted(dropped, 'island')} below {smallest:.6g} left out")
    parts = [shapely.Polygon(part.exterior, kept) for part, kept in zip(large, holes, strict=True)]
    return Sea(sorted(parts, key=lambda part: -part.area), tuple(sides), tuple(notes))


def fitted(sea: Sea, keys: ShoreDomain, spacing: SpacingAt) -> Sea:
    """The sea without narrow channels and with the detail that a spacing can show."""
    shore, notes = keys.shoreline, list(sea.notes)
    if shore.narrowest is not None:
        given = _points_of(sea.parts)
        sea = without_narrow(sea, spacing, shore.narrowest, shore.smallest or 0.0)
        # Of the arcs that close channels no more points stay than the spacing can show.
        sea = sea._replace(parts=[_simplified(part, sea, _Detail(spacing, SHORT), given) for part in sea.parts])
        notes = list(sea.notes)
    if shore.detail is None:
        return sea
    before = sum(len(shapely.get_coordinates(part)) for part in sea.parts)
    detail = _Detail(spacing, SHORT) if shore.detail == "auto" else _Detail(_same(shore.detail), 0.0)
    parts = [_simplified(part, sea, detail) for part in sea.parts]
    after = sum(len(shapely.get_coordinates(part)) for part in parts)
    if after < before:
        notes.append(f"{before - after:,} of {before:,} points of the shore left out, which its detail does not need")
    return sea._replace(parts=parts, notes=tuple(notes))


class _Detail(NamedTuple):
    """Detail of a shore that is left out: a tenth of a spacing aside, and points that are too near to each other."""

    spacing: SpacingAt
    short: float


def _same(detail: float) -> SpacingAt:
    """A spacing of which the detail is a length."""
    return lambda points: np.full(len(points), detail / DETAIL)


def without_narrow(sea: Sea, spacing: SpacingAt, narrowest: float, smallest: float) -> Sea:
    """The sea without what is narrower than so many of the spacings there, and what only that joins to the open side.

    What stays is covered by discs in the sea whose middles are half of that width away from each point of the shore, as
    the spacing is at that point.
    """
    shape = shapely.union_all(sea.parts)
    size = max(np.ptp(np.vstack(sea.sides), axis=0))

    def half_width(points: Floats) -> Floats:
        return np.maximum(narrowest / 2 * spacing(points), LEAST_WIDTH * size)

    middles = shape.difference(_grown(shape, half_width))
    wide = shapely.union_all([middles, _grown(middles, _touching(shape))])
    parts = polygons_of(shape.difference(wide))
    widths = 2 * half_width(shapely.get_coordinates([part.point_on_surface() for part in parts]))
    narrow = [(part, width) for part, width in zip(parts, widths, strict=True) if part.area > SLIVER * width**2]
    if not narrow:
        return sea
    # A little more, so that no slivers stay between them and the shore.
    cut = shape.difference(shapely.union_all([part.buffer(0.01 * width, join_style="mitre") for part, width in narrow]))
    closed = f"{counted(len(narrow), 'part')} of the sea closed, narrower than {narrowest:g} spacings there"
    return _kept(cut, sea.sides, smallest, (*sea.notes, closed), f"ask for less than narrowest: {narrowest:g}")


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
    return shapely.union_all(shapely.buffer(pieces, radii))


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


def _points_of(parts: Sequence[shapely.Polygon]) -> Complex:
    """All points (n,) of some parts, as complex numbers."""
    return _as_complex(shapely.get_coordinates(parts))


def _as_complex(points: Floats) -> Complex:
    return points[:, 0] + 1j * points[:, 1]


def _simplified(part: shapely.Polygon, sea: Sea, detail: _Detail, kept: Complex = NO_POINTS) -> shapely.Polygon:
    """A part of the sea with fewer points, but those ``kept``; where rings would cross or vanish more of them stay."""
    rings = [shapely.get_coordinates(ring)[:-1] for ring in (part.exterior, *part.interiors)]
    sides = [_of_box(ring, sea.sides) for ring in rings]
    spacings = [detail.spacing(ring) for ring in rings]
    stay = [np.isin(_as_complex(ring), kept) for ring in rings]
    stay = [kept | shared for kept, shared in zip(stay, _shared(rings), strict=True)]
    halvings = [np.zeros(len(ring), np.int64) for ring in rings]
    left = [np.arange(len(ring)) for ring in rings]
    changed = np.arange(len(rings))
    for attempt in range(ATTEMPTS):
        for k in changed.tolist():
            fixed = sides[k] | np.roll(sides[k], 1) | stay[k] | (halvings[k] > HALVINGS)
            left[k] = _few_points(rings[k], fixed, spacings[k] / 2.0 ** halvings[k], detail.short)
        few = [ring[points] for ring, points in zip(rings, left, strict=True)]
        changed = _faulty(few)
        crossing = [_between(left[k], side, len(rings[k])) for k, side in _crossing_sides(few, changed)]
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


def _few_points(ring: Floats, fixed: Booleans, spacing: Floats, short: float) -> Integers:
    """Numbers (k,) of points of a ring (n, 2), so that others are off by a tenth of the spacing (n,) at each at most.

    By Douglas and Peucker, between points that stay: those fixed, and two that are far from each other. Then those are
    left out that are nearer to the last one than ``short`` spacings.
    """
    n, allowed = len(ring), DETAIL * spacing
    far = int(np.argmax(((ring - ring[0]) ** 2).sum(axis=1)))
    stay = np.flatnonzero(fixed) if fixed.sum() > 1 else np.unique([0, far, *np.flatnonzero(fixed).tolist()])
    kept = np.zeros(n, bool)
    kept[stay] = True
    around, tolerance = np.vstack([ring, ring]), np.append(allowed, allowed)
    spans = list(pairwise([*stay.tolist(), int(stay[0]) + n]))
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        inner = around[first + 1 : last]
        off = _distances(inner, around[first], around[last]) / tolerance[first + 1 : last]
        worst = int(np.argmax(off))
        if off[worst] > 1:
            middle = first + 1 + worst
            kept[middle % n] = True
            spans += [(first, middle), (middle, last)]
    if short:
        kept[stay] = False
        kept[_near(ring, np.flatnonzero(kept), stay, short * spacing)] = False
        kept[stay] = True
    return np.flatnonzero(kept)


def _near(ring: Floats, points: Integers, stay: Integers, least: Floats) -> list[int]:
    """Numbers of those of some points (k,) of a ring (n, 2) that are too near to others that are kept.

    They are nearer than the least distance (n,) to the one kept before, or to the next of those that ``stay``.
    """
    near, last = list[int](), ring[stay[-1]]
    following = ring[stay[np.searchsorted(stay, points) % len(stay)]]
    both = np.sort(np.concatenate([points, stay])).tolist()
    ahead = dict(zip(points.tolist(), following, strict=True))
    for k in both:
        if k in ahead and min(np.hypot(*(ring[k] - last)), np.hypot(*(ring[k] - ahead[k]))) < least[k]:
            near.append(k)
        else:
            last = ring[k]
    return near


def _distances(points: Floats, start: Floats, end: Floats) -> Floats:
    """Distances (n,) of points (n, 2) from a segment."""
    along = end - start
    square = float(along @ along)
    t = np.clip((points - start) @ along / square, 0, 1) if square > 0 else np.zeros(len(points))
    return np.hypot(*(points - start - t[:, None] * along).T)


def _of_box(ring: Floats, sides: Sequence[Floats]) -> Booleans:
    """Mask (n,) of the sides of a ring (n, 2), from each point to the next, that are on a side of the box."""
    return _side_of_box(ring, sides) >= 0


def _side_of_box(ring: Floats, sides: Sequence[Floats]) -> Integers:
    """Number (n,) of the side of the box that each side of a ring (n, 2) is on; -1 for those of the shore."""
    size = max(np.ptp(np.vstack(sides), axis=0))
    ends = np.roll(ring, -1, axis=0)
    found = np.full(len(ring), -1)
    for number, side in enumerate(sides):
        line = shapely.LineString(side)
        shapely.prepare(line)
        near = [shapely.dwithin(line, shapely.points(at), ON_SIDE * size) for at in (ring, ends, (ring + ends) / 2)]
        found[np.all(near, axis=0)] = number
    return found


def areas_of_sea(sea: Sea, file: str) -> list[Area]:
    """Areas of the parts of a sea, with the labels open, land and island; the first ring has the notes on the file."""
    areas = [
        Area(_ring(part.exterior, sea.sides, LAND), tuple(_ring(hole, sea.sides, ISLAND) for hole in part.interiors))
        for part in sea.parts
    ]
    first = replace(areas[0].outer, notes=tuple(f"{Path(file).name}: {note}" for note in sea.notes))
    return [replace(areas[0], outer=first), *areas[1:]]


def _ring(loop: shapely.LinearRing, sides: Sequence[Floats], closed: str) -> Ring:
    """A ring whose sides on the box are open, each one curve from corner or shore to the next."""
    points = shapely.get_coordinates(loop)[:-1]
    side = _side_of_box(points, sides)
    first = np.flatnonzero((side != np.roll(side, 1)) | (side < 0))
    start = int(first[0]) if len(first) else 0
    points, side = np.roll(points, -start, axis=0), np.roll(side, -start)
    starts, made = zip(*_sides(points, side, closed), strict=True)
    return Ring(made, starts)


def _sides(points: Floats, side: Integers, closed: str) -> Iterator[tuple[Point, Side]]:
    """Where each side of a ring by points (n, 2) starts, and the side."""
    around = np.vstack([points, points[:1]])
    begin = 0
    while begin < len(points):
        end = begin + 1
        while side[begin] >= 0 and end < len(points) and side[end] == side[begin]:
            end += 1
        label = OPEN if side[begin] >= 0 else closed
        start = as_point(around[begin])
        single = end == begin + 1
        yield start, Side(Line(start, as_point(around[end])) if single else Polyline(around[begin : end + 1]), label)
        begin = end
