"""Rings of a file: curves joined where their ends meet."""

from collections.abc import Sequence
from dataclasses import replace
from functools import reduce
from itertools import chain
from operator import add
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Floats, Integers, components
from bubblemesh.errors import GeometryError, prefixed
from bubblemesh.geometry import rings
from bubblemesh.geometry.paths import Point, Ring, as_point
from bubblemesh.geometry.rings import ArcTo, BezierTo, LineTo, Piece, SplineTo, end_of
from bubblemesh.messages import counted, place, with_labels
from bubblemesh.readers.features import CompoundCurve
from bubblemesh.readers.rings.duplicates import without_copies
from bubblemesh.readers.rings.open_curves import on_rings
from bubblemesh.readers.slips import Slips, clean_loop

JOIN = 1e-9  # of the drawing's size: ends that differ only by rounding meet
MOST_NAMED = 5


class Joining(NamedTuple):
    """Rules by which curves become rings."""

    reach: float | None = None  # ends nearer to each other than this meet; by default those that differ by rounding
    skip: bool = False  # leave out curves that are part of no ring
    mend: bool = False  # if curves form no rings, cut them where they cross, and make rings around what they enclose


class Link(NamedTuple):
    """A curve in a loop, from node ``begin`` to node ``end``; against its own direction if ``backward``."""

    curve: int
    backward: bool
    begin: int
    end: int


class JoinedRings(NamedTuple):
    """Rings of curves, notes on gaps that were closed and curves that were left out, and what was dropped."""

    rings: list[Ring]
    notes: list[str]
    slips: Slips


def rings_of_curves(curves: Sequence[CompoundCurve], joining: Joining) -> JoinedRings:
    """Rings of the curves, without copies of curves.

    Ends that are near enough meet at their mean. GeometryError if an end meets no other end, or several.
    """
    curves, slips = without_copies(curves)
    loops, notes = _closed(curves, joining)
    made = [_ring(loop) for loop in loops]
    dropped = (some for _, some in made)
    return JoinedRings([ring for ring, _ in made if ring is not None], notes, reduce(add, dropped, slips))


def _closed(curves: Sequence[CompoundCurve], joining: Joining) -> tuple[list[list[CompoundCurve]], list[str]]:
    """Lists of curves that form a ring each, and notes on gaps and on open curves."""
    closed = [[curve] for curve in curves if curve.start == curve.end]
    curves = [curve for curve in curves if curve.start != curve.end]
    if not curves:
        return closed, []
    ends, node, notes = *meeting(curves, joining.reach), list[str]()
    rounding = JOIN * longer_side(curves)
    if joining.skip:
        kept = on_rings(node.reshape(-1, 2))
        skipped = [curve for curve, keep in zip(curves, kept.tolist(), strict=True) if not keep]
        curves = [curve for curve, keep in zip(curves, kept.tolist(), strict=True) if keep]
        notes += _skipped(skipped, _labels([*chain.from_iterable(closed), *curves]))
        if not curves:
            return closed, notes
        ends, node = ends[np.repeat(kept, 2)], np.unique(node[np.repeat(kept, 2)], return_inverse=True)[1]
    _require_pairs(curves, ends, node)
    meet = np.column_stack([np.bincount(node, ends[:, k]) / np.bincount(node) for k in range(2)])
    gap = np.hypot(*(ends - meet[node]).T)
    if 2 * gap.max() > rounding:
        widest = int(gap.argmax())
        gaps = len(np.unique(node[2 * gap > rounding]))
        notes.append(f"{counted(gaps, 'gap')} joined, the widest ({2 * gap[widest]:.3g}) at {place(ends[widest])}")
    open_ = [[_moved(curves[link.curve], link, meet) for link in loop] for loop in _loops(node.reshape(-1, 2))]
    return closed + open_, notes


def meeting(curves: Sequence[CompoundCurve], reach: float | None) -> tuple[Floats, Integers]:
    """Ends (2m, 2) of open curves, two of each, and the number (2m,) of the place where each meets others."""
    ends = np.array([point for curve in curves for point in (curve.start, curve.end)], float)
    return ends, _clustered(ends, JOIN * longer_side(curves) if reach is None else reach)


def _labels(curves: Sequence[CompoundCurve]) -> list[str]:
    """Labels of curves, each once."""
    return [*dict.fromkeys(piece.label for curve in curves for piece in curve.pieces if piece.label is not None)]


def _skipped(curves: Sequence[CompoundCurve], known: Sequence[str]) -> list[str]:
    """Note on curves that are part of no ring, with their labels that are not among the ``known`` ones of rings."""
    if not curves:
        return []
    places = ", ".join(place(curve.start) for curve in curves[:MOST_NAMED])
    which = "at" if len(curves) <= MOST_NAMED else "the first at"
    lost = [label for label in _labels(curves) if label not in known]
    return [f"{counted(len(curves), 'open curve')} left out, {which} {places}{with_labels(lost)}"]


def longer_side(curves: Sequence[CompoundCurve]) -> float:
    """The longer side of the box around all points that define the curves."""
    points = [curve.start for curve in curves]
    for piece in (piece for curve in curves for piece in curve.pieces):
        points += piece.through if isinstance(piece, SplineTo) else [piece.to]
    return float(np.ptp(np.array(points), axis=0).max())


def _clustered(ends: Floats, reach: float) -> Integers:
    """Number (m,) of the meeting place of each end."""
    points = shapely.points(ends)
    pairs = shapely.STRtree(points).query(points, predicate="dwithin", distance=reach).T
    return components(pairs, len(ends))


def _require_pairs(curves: Sequence[CompoundCurve], ends: Floats, node: Integers) -> None:
    """Check that each meeting place has two ends."""
    count = np.bincount(node)[node]
    loose = np.flatnonzero(count == 1)
    if len(loose):
        named = [f"{curves[k // 2].name} at {place(ends[k])}" for k in loose[:MOST_NAMED].tolist()]
        more = f" and {len(loose) - MOST_NAMED} more" if len(loose) > MOST_NAMED else ""
        raise GeometryError(f"open ends: {', '.join(named)}{more}{_widest_gap(ends[loose])}")
    crowded = np.flatnonzero(count > 2)
    if len(crowded):
        k = int(crowded[0])
        names = sorted({curves[j // 2].name for j in np.flatnonzero(node == node[k]).tolist()})
        raise GeometryError(
            f"{count[k]} ends meet at {place(ends[k])}, where a ring passes once ({', '.join(names[:MOST_NAMED])})"
        )


def _widest_gap(ends: Floats) -> str:
    """Text on the widest gap between loose ends (n, 2)."""
    if len(ends) == 1:
        return ""
    gap = to_next(ends)
    widest = int(gap.argmax())
    nearest = f", the nearest {gap.min():.3g}" if gap.min() < gap[widest] * (1 - 1e-6) else ""
    return f"; the widest gap to a next one is {gap[widest]:.3g}, at {place(ends[widest])}{nearest}"


def to_next(ends: Floats) -> Floats:
    """Distances (n,) of two points or more (n, 2) from the nearest other one."""
    from scipy.spatial import cKDTree

    return np.asarray(cKDTree(ends).query(ends, 2)[0])[:, 1]


def _loops(node: Integers) -> list[list[Link]]:
    """Closed walks along curves that are given by the nodes (m, 2) at their ends."""
    at: dict[int, list[int]] = {}
    for curve, (begin, end) in enumerate(node.tolist()):
        at.setdefault(begin, []).append(curve)
        at.setdefault(end, []).append(curve)
    used = np.zeros(len(node), bool)
    loops = []
    for first in range(len(node)):
        if used[first]:
            continue
        begin, end = node[first].tolist()
        loop, used[first] = [Link(first, False, begin, end)], True
        while end != begin:
            (curve,) = (k for k in at[end] if not used[k])
            used[curve] = True
            a, b = node[curve].tolist()
            loop.append(Link(curve, a != end, end, b if a == end else a))
            end = loop[-1].end
        loops.append(loop)
    return loops


def _moved(curve: CompoundCurve, link: Link, meet: Floats) -> CompoundCurve:
    """The curve in the direction of the link, with its ends at the meeting places."""
    run = reversed_curve(curve) if link.backward else curve
    stops = [run.start, *(end_of(piece) for piece in run.pieces)]
    new = [as_point(meet[link.begin]), *stops[1:-1], as_point(meet[link.end])]
    pieces = (_between(*ends) for ends in zip(run.pieces, stops, new, new[1:], strict=False))
    return CompoundCurve(new[0], tuple(pieces), run.name)


def _between(piece: Piece, start: Point, new_start: Point, new_end: Point) -> Piece:
    """The piece from ``start`` with moved ends.

    An arc keeps its angle, a Bézier curve its directions at the ends, a spline its inner points. An arc whose ends meet
    becomes a circle, or has no length if it is less than half of one.
    """
    if isinstance(piece, LineTo):
        return piece._replace(to=new_end)
    if isinstance(piece, SplineTo):
        return piece._replace(through=[*piece.through[:-1], new_end])
    if new_start == start and new_end == piece.to:
        return piece
    if isinstance(piece, BezierTo):
        first, second = _carried(piece.first, start, new_start), _carried(piece.second, piece.to, new_end)
        return piece._replace(to=new_end, first=first, second=second)
    # Points as complex numbers: the similarity that maps the old chord to the new one also maps the centre.
    p, q, c, a, b = (complex(*point) for point in (start, piece.to, piece.center, new_start, new_end))
    if a == b and p != q and (((q - c) * (p - c).conjugate()).imag > 0) == piece.left:
        return LineTo(new_end, piece.label)
    center = c + a - (p + q) / 2 if a == b or p == q else a + (c - p) * ((b - a) / (q - p))
    return piece._replace(to=new_end, center=(center.real, center.imag))


def _carried(point: Point, old: Point, new: Point) -> Point:
    """The point, moved by the vector from ``old`` to ``new``."""
    return point[0] + new[0] - old[0], point[1] + new[1] - old[1]


def reversed_curve(curve: CompoundCurve) -> CompoundCurve:
    """The curve in the other direction."""
    starts = [curve.start, *(end_of(piece) for piece in curve.pieces[:-1])]
    pieces: list[Piece] = []
    for start, piece in zip(reversed(starts), reversed(curve.pieces), strict=True):
        if isinstance(piece, SplineTo):
            pieces.append(piece._replace(through=[*reversed(list(piece.through)[:-1]), start]))
        elif isinstance(piece, ArcTo):
            pieces.append(piece._replace(to=start, left=not piece.left))
        elif isinstance(piece, BezierTo):
            pieces.append(piece._replace(to=start, first=piece.second, second=piece.first))
        else:
            pieces.append(piece._replace(to=start))
    return CompoundCurve(curve.end, tuple(pieces), curve.name)


def _ring(curves: Sequence[CompoundCurve]) -> tuple[Ring | None, Slips]:
    """The ring along curves in order, None if it has no area; arcs of one circle become the whole circle."""
    first, *others = curves
    pieces = [piece for curve in curves for piece in curve.pieces]
    names = list(dict.fromkeys(curve.name for curve in curves))
    origin = names[0] if len(names) == 1 else f"{names[0]} and {len(names) - 1} more"
    with prefixed(origin):
        circle = _whole_circle(pieces)
        if circle is not None:
            return replace(circle, origin=origin), Slips()
        start, pieces, slips = clean_loop(first.start, pieces)
        if slips == Slips() and not others:
            return first.ring, slips
        return (replace(rings.path(start, pieces), origin=origin) if pieces else None), slips


def _whole_circle(pieces: Sequence[Piece]) -> Ring | None:
    """The circle that the pieces form, if they are arcs of one circle and have one label; else None."""
    arcs = [piece for piece in pieces if isinstance(piece, ArcTo)]
    if len(arcs) < len(pieces) or len({(piece.left, piece.label) for piece in arcs}) > 1:
        return None
    centers, ends = np.array([arc.center for arc in arcs], float), np.array([arc.to for arc in arcs], float)
    radii = np.hypot(*(ends - centers).T)
    if np.ptp(centers, axis=0).max() > JOIN * radii.max() or np.ptp(radii) > JOIN * radii.max():
        return None
    return rings.circle(centers.mean(axis=0).tolist(), float(radii.mean()), arcs[0].label)
