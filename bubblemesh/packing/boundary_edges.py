"""Straight boundary edges in place of the true curves: what they would cut off, and what they leave outside."""

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers, each_once, taken
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.distance.chord_runs import ChordRuns
from bubblemesh.geometry.distance.nearest_chord import nearest_chord
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.periodic import counterparts
from bubblemesh.messages import place
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.spacing.spacing import Spacing

NEAREST_TO_CHORD = 0.5  # in units of spacing; a perfect packing has 0.87, and nearer nodes make flat triangles
NEAREST_ON_CURVE = 0.05  # in units of spacing, along the boundary
SAMPLES = 9  # points of an arc whose convex hull stands for it
MOST_HALVINGS = 60
MOST_ADDED = 500_000  # bubbles between curves; those that need more are the same but for rounding


def split_cutting_edges(bubbles: Bubbles, domain: Domain, spacing: Spacing) -> Bubbles:
    """Bubbles with more of them on curves whose straight edges would cut off other parts of the boundary.

    GeometryError if curves are so near to each other that no edges fit between them.
    """
    boundary, most = domain.boundary, len(bubbles) + MOST_ADDED
    if not boundary.curved.any():
        return bubbles
    for _ in range(MOST_HALVINGS):
        edges, edge_piece = boundary.edges(bubbles.piece, bubbles.s)
        begin, end = boundary.arcs(edges, edge_piece, bubbles.s)
        cut = np.flatnonzero(_cutting(bubbles, domain, edges, edge_piece, begin, end))
        if len(cut) == 0:
            break
        piece = edge_piece[cut]
        s = boundary.wrapped(piece, (begin[cut] + end[cut]) / 2)
        _, other, at = counterparts(boundary, domain.periodic, piece, s)
        uncut = ~np.isin(other, piece)
        piece, s = np.append(piece, other[uncut]), np.append(s, at[uncut])
        x = boundary.points(piece, s)
        if len(bubbles) + len(x) > most:
            raise GeometryError(
                f"two curves at {place(x[0])} are so near to each other that no edges fit between them: let them "
                "share the curve, or move them apart"
            )
        bubbles = bubbles.append(x, spacing(x), piece, s)
    return bubbles


def _cutting(
    bubbles: Bubbles, domain: Domain, edges: Integers, edge_piece: Integers, begin: Floats, end: Floats
) -> Booleans:
    """Boundary edges (e,) that have another one, or the end of one that follows, between their chord and their arc.

    Only chords that run through the domain can have one: between the others and their arcs there are no edges.
    """
    samples = begin[:, None] + np.linspace(0, 1, SAMPLES) * (end - begin)[:, None]
    piece = np.repeat(edge_piece, SAMPLES)
    x = domain.boundary.points(piece, domain.boundary.wrapped(piece, samples.ravel())).reshape(-1, SAMPLES, 2)
    x[:, 0], x[:, -1] = bubbles.x[edges[:, 0]], bubbles.x[edges[:, 1]]
    hulls = shapely.convex_hull(shapely.linestrings(x))
    chord, offset = x[:, -1] - x[:, 0], x - x[:, :1]
    within = (chord[:, :1] * offset[:, :, 1] < chord[:, 1:] * offset[:, :, 0]).any(axis=1)
    through = np.flatnonzero((within | domain.boundary.inner[edge_piece]) & domain.boundary.curved[edge_piece])
    cutting = np.zeros(len(edges), bool)
    mine, other = shapely.STRtree(hulls).query(hulls[through], predicate="intersects")
    mine = through[mine]
    mine, other = mine[mine != other], other[mine != other]
    shared = (edges[mine][:, :, None] == edges[other][:, None, :]).any(axis=1)
    cutting[mine[~shared.any(axis=1) | shared.all(axis=1)]] = True
    mine, other, far = (column[shared.sum(axis=1) == 1] for column in (mine, other, ~shared))
    ends = bubbles.x[edges[other][far]]
    cutting[mine[shapely.contains_properly(hulls[mine], shapely.points(ends))]] = True
    return cutting


def drop_strays(bubbles: Bubbles, domain: Domain) -> Bubbles:
    """Bubbles without those that ran into others on the boundary, and those outside the straight boundary edges."""
    bubbles = _separated(bubbles, domain)
    inside = _inside_chords(bubbles, domain)
    if inside.all():
        return bubbles
    keep = np.concatenate([np.arange(bubbles.boundary_count), bubbles.boundary_count + np.flatnonzero(inside)])
    return bubbles.select(keep)


def _separated(bubbles: Bubbles, domain: Domain) -> Bubbles:
    """Bubbles without sliding ones that are as good as at a corner, or at the sliding one before."""
    while True:
        edges, edge_piece = domain.boundary.edges(bubbles.piece, bubbles.s)
        begin, end = domain.boundary.arcs(edges, edge_piece, bubbles.s)
        near = edges[end - begin < NEAREST_ON_CURVE * bubbles.d[edges].mean(axis=1)]
        # Of two sliding bubbles the later one goes, and then another look is needed at what it was next to.
        gone = near.max(axis=1)
        gone = each_once(gone[gone >= bubbles.corners])
        if len(gone) == 0:
            return bubbles
        bubbles = bubbles.select(np.delete(np.arange(len(bubbles)), gone))


def _inside_chords(bubbles: Bubbles, domain: Domain) -> Booleans:
    """Interior bubbles (k,), all inside the domain, that are inside the polygon of the boundary nodes too."""
    edges, piece = domain.boundary.edges(bubbles.piece, bubbles.s)
    x, d = bubbles.x[bubbles.interior], bubbles.d[bubbles.interior]
    runs = ChordRuns.of(*np.moveaxis(bubbles.x[edges], 1, 0))
    near = nearest_chord(runs, x)
    share, foot = runs.feet(x, near)
    (ax, ay), (bx, by) = (x - taken(runs.start, near)).T, (taken(runs.end, near) - taken(runs.start, near)).T
    behind = (bx * ay - by * ax <= 0) & (share > 0) & (share < 1)  # else the nearest point is a node, on true curves
    behind &= ~domain.boundary.inner[piece[near]]
    return ~behind & (np.hypot(*(x - foot).T) > NEAREST_TO_CHORD * d)
