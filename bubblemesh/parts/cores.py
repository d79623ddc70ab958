"""Core and band of a packed part: what is done for good, and what seams may change yet."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers, ShortIntegers, any_of_rows, contained, each_once
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.census import Census
from bubblemesh.meshes.conformity import require_piece
from bubblemesh.meshes.edges import directed_sides, edge_keys, find_keys, one_sided
from bubblemesh.meshes.quality import Measures
from bubblemesh.meshes.triangulation import regions, sorted_triangles
from bubblemesh.packing.methods import Method
from bubblemesh.packing.net import unconnected
from bubblemesh.parts.division import Places
from bubblemesh.parts.seams import JUNCTION, SEAM, near
from bubblemesh.parts.store import Store
from bubblemesh.parts.work import Deadline, Packed, Record, packed
from bubblemesh.spacing.spacing import Spacing

BEYOND = 3  # edges that the band is wider than what the seams move


class Band(NamedTuple):
    """Nodes of a part on its boundary and along its cuts, and the triangles along the cuts."""

    x: Floats  # (n, 2): corners, then what slides on pieces, then the others
    corners: int
    piece: Integers  # (b,): pieces of the part on which nodes slide
    s: Floats  # (b,): arc lengths there
    triangles: Integers  # (t, 3)
    rim: Integers  # (r, 2): sides of them beyond which the core is
    rim_region: Integers  # (r,): region of the whole there


class Core(NamedTuple):
    """Core of a part: its triangles that are in no band."""

    x: Floats  # (m, 2): places of the nodes that the band has not
    triangles: ShortIntegers  # (t, 3): numbers of the band's nodes, then of these
    region: ShortIntegers  # (t,): region of the whole
    quality: Floats  # (t,): radius ratio, if figures are wanted
    target: Floats  # (t,): wanted spacing, if figures are wanted


class Margin(NamedTuple):
    """Margin of a packed part: all that is known of it beside its core."""

    band: Band
    census: Census | None  # of the core, if it has triangles and figures are wanted
    valence: Integers  # (n,): edges of the core at each node of the band, but for those of the rim
    regions: Integers  # (k,): of the core
    nodes: int  # of the core
    triangles: int
    record: Record


class Part(NamedTuple):
    """A packed part."""

    core: Core
    margin: Margin


def packed_part(
    domain: Domain,
    places: Places,
    spacing: Spacing,
    wanted: Spacing | None,
    method: Method,
    expected_nodes: float,
    max_nodes: int,
    deadline: Deadline,
) -> Part:
    """Pack a part by itself, and split it; figures are made if the wanted spacing is given."""
    return split(domain, places, packed(domain, spacing, method, expected_nodes, max_nodes, deadline), wanted)


def kept_part(store: Store, number: int, *given: Any) -> Margin:
    """Pack a part as `packed_part`, and keep it in a store; only what seams need of it is given on."""
    part = packed_part(*given)
    store.keep(number, part)
    return part.margin


def split(domain: Domain, places: Places, done: Packed, wanted: Spacing | None) -> Part:
    """Split a packed part into its core and its band, with the figures of the core if the wanted spacing is given."""
    net, n = replace(unconnected(done.bubbles, domain), triangles=done.triangles), len(done.bubbles)
    bubbles, triangles = net.bubbles, net.triangles
    on_cuts = bubbles.corners + np.flatnonzero(places.on_cut[bubbles.piece])
    moving = near(net, np.append(places.ends, on_cuts), SEAM + BEYOND) | near(net, places.ends, JUNCTION + BEYOND)
    in_band = any_of_rows(moving[triangles])
    shared = np.arange(n) < bubbles.boundary_count
    shared[triangles[in_band]] = True
    order = np.concatenate([np.flatnonzero(shared), np.flatnonzero(~shared)])
    number, count = np.empty(n, np.int64), int(shared.sum())
    number[order] = np.arange(n)
    x, facets, piece = bubbles.x[order], number[net.facets], net.facet_piece
    near_cuts, rest = (sorted_triangles(number[triangles[mine]]) for mine in (in_band, ~in_band))
    region = regions(np.concatenate([near_cuts, rest]), facets, places.left[piece], places.right[piece])
    sides = directed_sides(near_cuts)
    open_ = np.sort(one_sided(sides, n))
    walls = np.sort(edge_keys(facets[~net.two_sided], n))
    at_rim = open_[~contained(edge_keys(sides[open_], n), walls)]
    rim, rim_region = sides[at_rim], region[at_rim % max(len(near_cuts), 1)]
    band = Band(x[:count], bubbles.corners, bubbles.piece, bubbles.s, near_cuts, rim, rim_region)
    own, valence = np.arange(n) >= count, np.zeros(n, np.int64)
    quality, target, census = np.zeros(0), np.zeros(0), None
    if wanted is not None and len(rest):
        measures = Measures(x, rest)
        edges = measures.edges[0]
        require_piece(measures, facets, rim, own)
        mine = np.ones(len(edges), bool)
        mine[find_keys(edge_keys(edges, n), edge_keys(np.sort(rim, axis=1), n))] = False
        valence = np.bincount(edges[mine].ravel(), minlength=n)
        census = Census.of(measures, wanted.between, mine, own, valence)
        quality, target = measures.radius_ratios, wanted.between(x, rest)
    inner = region[len(near_cuts) :]
    core = Core(x[count:], rest.astype(np.int32), inner.astype(np.int32), quality, target)
    sizes = len(core.x), len(rest)
    return Part(core, Margin(band, census, valence[:count], each_once(inner), *sizes, done.record))
