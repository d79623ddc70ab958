"""Rings of a file: curves joined where their ends meet."""

from collections.abc import Sequence
from dataclasses import replace
from functools import reduce
from operator import add
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import GeometryError, prefixed
from bubblemesh.geometry import rings
from bubblemesh.geometry.paths import Point, Ring, as_point
from bubblemesh.geometry.rings import ArcTo, LineTo, Piece, SplineTo, end_of
from bubblemesh.messages import just_above, place
from bubblemesh.readers.copies import without_copies
from bubblemesh.readers.features import CompoundCurve
from bubblemesh.readers.slips import Slips, clean_loop

JOIN = 1e-9  # of the drawing's size: ends that differ by rounding meet
MOST_NAMED = 5
WIDEST_GAP = 0.05  # of the drawing's size: wider ones are no slips of drawing


class Link(NamedTuple):
    """A curve in a loop, from node ``begin`` to node ``end``; against its own direction if ``backward``."""

    curve: int
    backward: bool
    begin: int
    end: int


class Joined(NamedTuple):
    """Rings of curves, notes on gaps that were closed, and what was dropped."""

    rings: list[Ring]
    notes: list[str]
    slips: Slips


def rings_of_curves(curves: Sequence[CompoundCurve], join: float | None) -> Joined:
    """Rings of the curves; what is given twice counts once.

    Ends nearer to each other than ``join`` meet in their common mean; by default they may differ by rounding only.
    GeometryError if an end meets no other one, or more than one.
    """
    curves, slips = without_copies(curves)
    loops, notes = _closed(curves, join)
    made = [_ring(loop) for loop in loops]
    dropped = (some for _, some in made)
    return Joined([ring for ring, _ in made if ring is not None], notes, reduce(add, dropped, slips))


def _closed(curves: Sequence[CompoundCurve], join: float | None) -> tuple[list[list[CompoundCurve]], list[str]]:
    """Curves that close each other, and notes on gaps."""
    closed = [[curve] for curve in curves if curve.start == curve.end]
    curves = [curve for curve in curves if curve.start != curve.end]
    if not curves:
        return closed, []
    ends = np.array([point for curve in curves for point in (curve.start, curve.end)], float)
    rounding = JOIN * _extent(curves)
    reach = rounding if join is None else join
    node = _clustered(ends, reach)
    _require_pairs(curves, ends, node, WIDEST_GAP * _extent(curves))
    meet = np.column_stack([np.bincount(node, ends[:, k]) / np.bincount(node) for k in range(2)])
    gap = np.hypot(*(ends - meet[node]).T)
    notes = []
    if 2 * gap.max() > rounding:
        widest = int(gap.argmax())
        gaps = len(np.unique(node[2 * gap > rounding]))
        notes.append(f"{gaps} gaps joined, the widest ({2 * gap[widest]:.3g}) at {place(ends[widest])}")
    open_ = [[_moved(curves[link.curve], link, meet) for link in loop] for loop in _loops(node.reshape(-1, 2))]
    return closed + open_, notes


def _extent(curves: Sequence[CompoundCurve]) -> float:
    """The longer side of the box around all points that the curves are given by."""
    points = [curve.start for curve in curves]
    for piece in (piece for curve in curves for piece in curve.pieces):
        points += piece.through if isinstance(piece, SplineTo) else [piece.to]
    return float(np.ptp(np.array(points), axis=0).max())


def _clustered(ends: Floats, reach: float) -> Integers:
    """Number (m,) of the meeting place of each end."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(ends).query_pairs(reach, output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(ends), len(ends)))
    return connected_components(links, directed=False)[1].astype(np.int64)


def _require_pairs(curves: Sequence[CompoundCurve], ends: Floats, node: Integers, widest: float) -> None:
    """Every meeting place must have two ends; messages advise to join gaps that are not wider than ``widest``."""
    count = np.bincount(node)[node]
    loose = np.flatnonzero(count == 1)
    if len(loose):
        gaps = [f"{curves[k // 2].name} at {place(ends[k])}" for k in loose[:MOST_NAMED].tolist()]
        more = f" and {len(loose) - MOST_NAMED} more" if len(loose) > MOST_NAMED else ""
        raise GeometryError(f"open ends: {', '.join(gaps)}{more}: {_advice(ends, loose, widest)}")
    crowded = np.flatnonzero(count > 2)
    if len(crowded):
        k = int(crowded[0])
        names = sorted({curves[j // 2].name for j in np.flatnonzero(node == node[k]).tolist()})
        raise GeometryError(
            f"{count[k]} ends meet at {place(ends[k])} ({', '.join(names[:MOST_NAMED])}): a ring passes a point once; "
            "remove double lines, or choose a layer or feature"
        )


def _advice(ends: Floats, loose: Integers, widest: float) -> str:
    """Advice on how to close the gaps at loose ends."""
    from scipy.spatial import cKDTree

    if len(loose) < 2:
        return "close the curve"
    distances, _ = cKDTree(ends[loose]).query(ends[loose], k=2)
    gap = np.asarray(distances)[:, 1]
    told = f"the next one is {gap[0]:.3g} away from the first: draw what is missing"
    if not 0 < gap.max() <= widest:
        return told
    join = just_above(gap.max())
    closed = (np.bincount(_clustered(ends, float(join))) == 2).all()
    return f"{told}, or set join: {join}, which closes all gaps" if closed else told


def _loops(node: Integers) -> list[list[Link]]:
    """Closed walks along curves (m, 2), given by the nodes at their ends."""
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
    """The curve run as the link tells, with its ends at the meeting places."""
    run = reversed_curve(curve) if link.backward else curve
    stops = [run.start, *(end_of(piece) for piece in run.pieces)]
    new = [as_point(meet[link.begin]), *stops[1:-1], as_point(meet[link.end])]
    pieces = (_between(*ends) for ends in zip(run.pieces, stops, new, new[1:], strict=False))
    return CompoundCurve(new[0], tuple(pieces), run.name)


def _between(piece: Piece, start: Point, new_start: Point, new_end: Point) -> Piece:
    """The piece from ``start`` with moved ends: an arc keeps its angle, a spline its inner points."""
    if isinstance(piece, LineTo):
        return piece._replace(to=new_end)
    if isinstance(piece, SplineTo):
        return piece._replace(through=[*piece.through[:-1], new_end])
    if new_start == start and new_end == piece.to:
        return piece
    # Points as complex numbers: the similarity that takes the old chord to the new one takes the centre along.
    p, q, c, a, b = (complex(*point) for point in (start, piece.to, piece.center, new_start, new_end))
    center = c + a - p if p == q else a + (c - p) * ((b - a) / (q - p))
    return piece._replace(to=new_end, center=(center.real, center.imag))


def reversed_curve(curve: CompoundCurve) -> CompoundCurve:
    """The curve run the other way."""
    starts = [curve.start, *(end_of(piece) for piece in curve.pieces[:-1])]
    pieces: list[Piece] = []
    for start, piece in zip(reversed(starts), reversed(curve.pieces), strict=True):
        if isinstance(piece, SplineTo):
            pieces.append(piece._replace(through=[*reversed(list(piece.through)[:-1]), start]))
        elif isinstance(piece, ArcTo):
            pieces.append(piece._replace(to=start, left=not piece.left))
        else:
            pieces.append(piece._replace(to=start))
    return CompoundCurve(curve.end, tuple(pieces), curve.name)


def _ring(curves: Sequence[CompoundCurve]) -> tuple[Ring | None, Slips]:
    """The ring along curves that follow each other, if it has an area; arcs of one circle become the whole circle."""
    pieces = [piece for curve in curves for piece in curve.pieces]
    names = list(dict.fromkeys(curve.name for curve in curves))
    origin = names[0] if len(names) == 1 else f"{names[0]} and {len(names) - 1} more"
    with prefixed(origin):
        circle = _whole_circle(pieces)
        if circle is not None:
            return replace(circle, origin=origin), Slips()
        start, pieces, slips = clean_loop(curves[0].start, pieces)
        return (replace(rings.path(start, pieces), origin=origin) if pieces else None), slips


def _whole_circle(pieces: Sequence[Piece]) -> Ring | None:
    """The circle that the pieces make up, if they are arcs of one and have one label."""
    arcs = [piece for piece in pieces if isinstance(piece, ArcTo)]
    if len(arcs) < len(pieces) or len({(piece.left, piece.label) for piece in arcs}) > 1:
        return None
    centers, ends = np.array([arc.center for arc in arcs], float), np.array([arc.to for arc in arcs], float)
    radii = np.hypot(*(ends - centers).T)
    if np.ptp(centers, axis=0).max() > JOIN * radii.max() or np.ptp(radii) > JOIN * radii.max():
        return None
    return rings.circle(centers.mean(axis=0).tolist(), float(radii.mean()), arcs[0].label)
