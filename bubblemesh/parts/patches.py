"""Patches: bands of packed parts, whose nodes have numbers that neighbours share; joined, they are one net."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.net import Net, unconnected
from bubblemesh.parts.division import CutDomain, Places
from bubblemesh.parts.ends import merged_ends, spread_ends
from bubblemesh.parts.part import Band
from bubblemesh.spacing.spacing import Spacing


class Patch(NamedTuple):
    """Nodes of a band, by numbers that are theirs in the whole division."""

    node: Integers  # (n,): corners of the division first, then bubbles held on cuts, then each part's own
    x: Floats  # (n, 2)
    piece: Integers  # (n,): piece of the division, -1 for corners and inner nodes
    s: Floats  # (n,): arc length on it
    triangles: Integers  # (t, 3): of these numbers


def patch(division: CutDomain, places: Places, band: Band, first: int) -> Patch:
    """The band of a part as a patch, whose own nodes have the numbers from ``first`` on."""
    boundary = division.boundary
    held = division.held
    corners = band.corners
    piece, s = places.piece[band.piece], band.s
    s = np.where(places.turned[band.piece], boundary.lengths[piece] - s, s)
    node = np.full(len(band.x), -1)
    node[:corners] = places.corner
    common = np.flatnonzero(np.isin(piece, held.pieces))
    order = common[np.lexsort((s[common], piece[common]))]
    mine = np.flatnonzero(np.isin(held.piece, places.piece))
    node[corners + order] = len(boundary.corners) + mine
    own = np.flatnonzero(node < 0)
    node[own] = first + np.arange(len(own))
    pieces, along = np.full(len(node), -1), np.zeros(len(node))
    sliding = slice(corners, corners + len(piece))
    pieces[sliding], along[sliding] = piece, s
    along[corners + order] = held.s[mine]
    return Patch(node, band.x, pieces, along, node[band.triangles])


class JoinedBands(NamedTuple):
    """Net of all bands in the whole domain, which is not Delaunay along the cuts yet, and has no list of edges."""

    net: Net  # of all bubbles on the boundary, and of those of the bands
    along: Integers  # (k,): bubbles on cuts
    ends: Integers  # (j,): those of them at which cuts meet each other, the boundary, or inner lines
    numbers: tuple[Integers, ...]  # of the nodes (n,) of each patch


def join_bands(division: CutDomain, patches: Sequence[Patch], spacing: Spacing) -> JoinedBands:
    """Join the bands of packed parts: what they have in common is there once."""
    whole, boundary = division.whole, division.boundary
    shared = len(boundary.corners) + len(division.held.s)
    node, row = _first_places(np.concatenate([patch.node for patch in patches]))
    x, piece, s = (np.concatenate([getattr(patch, name) for patch in patches])[row] for name in ("x", "piece", "s"))
    triangles = np.concatenate([patch.triangles for patch in patches])
    # The same places on both sides of a cut, whichever way it runs for them.
    held = (node >= len(boundary.corners)) & (node < shared)
    corner = node < len(boundary.corners)
    x[corner] = boundary.corners[node[corner]]
    x[held] = boundary.points(piece[held], s[held])
    number, s = division.on_whole(node, piece, s)
    slides = number >= 0
    kept = node < len(whole.boundary.corners)
    order = np.concatenate([np.flatnonzero(kept), np.flatnonzero(slides), np.flatnonzero(~kept & ~slides)])
    place = np.full(int(node[-1]) + 1, -1)  # by the number in the division
    place[node[order]] = np.arange(len(order))
    touched = np.zeros(len(order), bool)
    bubbles = Bubbles(x[order], spacing.extended(x[order]), number[slides], s[slides], int(kept.sum()), touched)
    ends, on_cut = place[division.ends], place[node[held][division.on_cut[piece[held]]]]
    loose = slides & corner
    loose[loose] = ~whole.tied[number[loose]]
    net = unconnected(bubbles, whole)
    loose_ends = place[node[loose]]
    triangles, stands = merged_ends(bubbles.x, spacing, place[triangles], net.facets, loose_ends)
    stay = stands == np.arange(len(stands))
    rank = (np.cumsum(stay) - 1)[stands]
    if not stay.all():
        bubbles = bubbles.select(np.flatnonzero(stay))
        net = unconnected(bubbles, whole)
    net = replace(net, triangles=rank[triangles])
    net = replace(net, bubbles=spread_ends(net, whole.boundary, rank[loose_ends[stay[loose_ends]]], spacing))
    numbers = tuple(rank[place[patch.node]] for patch in patches)
    return JoinedBands(net, rank[np.concatenate([ends, on_cut])], rank[ends], numbers)


def _first_places(numbers: Integers) -> tuple[Integers, Integers]:
    """Distinct numbers (k,), ascending, and the place where each comes first: for numbers that hardly have gaps."""
    first = np.full(int(numbers.max(initial=-1)) + 1, -1)
    first[numbers[::-1]] = np.arange(len(numbers))[::-1]
    known = np.flatnonzero(first >= 0)
    return known, first[known]
