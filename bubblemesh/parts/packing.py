"""The packing of one part, and how it is split into its core and its margin."""

from dataclasses import replace

import numpy as np

from bubblemesh.arrays import any_of_rows, contained, each_once
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.census import Census
from bubblemesh.meshes.conformity import require_piece
from bubblemesh.meshes.edges import directed_sides, edge_keys, find_keys, one_sided
from bubblemesh.meshes.quality import Measures
from bubblemesh.meshes.triangulation import regions, sorted_triangles
from bubblemesh.packing.net import unconnected
from bubblemesh.packing.rounds import Packed, Record
from bubblemesh.parts.division import Places
from bubblemesh.parts.part import Band, Core, Margin, Part
from bubblemesh.parts.seams import JUNCTION, SEAM, near
from bubblemesh.parts.store import Store
from bubblemesh.parts.work import Terms, packed
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing

WIDER = 3  # edges that the band is wider than what the seams move


@record
class PartJob:
    """A part that is to be packed."""

    domain: Domain
    places: Places
    expected_nodes: float
    terms: Terms


def packed_part(job: PartJob) -> Part:
    """Pack a part by itself, and split it; figures are made if its terms have a target."""
    return split(job.domain, job.places, packed(job.domain, job.expected_nodes, job.terms), job.terms.target)


def kept_part(store: Store, number: int, job: PartJob) -> Margin:
    """Pack a part as `packed_part`, and keep it in a store; only what seams need of it is given on."""
    part = packed_part(job)
    store.keep(number, part)
    return part.margin


def split(domain: Domain, places: Places, done: Packed, target: Spacing | None) -> Part:
    """Split a packed part into its core and its band, with the figures of the core if a target is given."""
    net = replace(unconnected(done.net.bubbles, domain), triangles=done.net.triangles)
    n = len(net.bubbles)
    bubbles, triangles = net.bubbles, net.triangles
    on_cuts = bubbles.corners + np.flatnonzero(places.on_cut[bubbles.piece])
    moving = near(net, np.append(places.ends, on_cuts), SEAM + WIDER) | near(net, places.ends, JUNCTION + WIDER)
    in_band = any_of_rows(moving[triangles])
    shared = np.arange(n) < bubbles.boundary_count
    shared[triangles[in_band]] = True
    order = np.concatenate([np.flatnonzero(shared), np.flatnonzero(~shared)])
    number, count = np.empty(n, np.int64), int(shared.sum())
    number[order] = np.arange(n)
    x = bubbles.x[order]
    facets = number[net.facets]
    piece = net.facet_piece
    near_cuts, rest = (sorted_triangles(number[triangles[mine]]) for mine in (in_band, ~in_band))
    region = regions(np.concatenate([near_cuts, rest]), facets, places.left[piece], places.right[piece])
    sides = directed_sides(near_cuts)
    open_ = np.sort(one_sided(sides, n))
    walls = np.sort(edge_keys(facets[~net.two_sided], n))
    at_rim = open_[~contained(edge_keys(sides[open_], n), walls)]
    rim, rim_region = sides[at_rim], region[at_rim % max(len(near_cuts), 1)]
    band = Band(x[:count], bubbles.corners, bubbles.piece, bubbles.s, near_cuts, rim, rim_region)
    own, valence = np.arange(n) >= count, np.zeros(n, np.int64)
    inner = region[len(near_cuts) :]
    quality = np.zeros(0)
    targets = np.zeros(0)
    census = None
    if target is not None and len(rest):
        measures = Measures(x, rest)
        edges = measures.edges[0]
        require_piece(measures, facets, rim, own)
        mine = np.ones(len(edges), bool)
        mine[find_keys(edge_keys(edges, n), edge_keys(np.sort(rim, axis=1), n))] = False
        valence = np.bincount(edges[mine].ravel(), minlength=n)
        census = Census.of(measures, inner, target.between, mine, own, valence)
        quality, targets = measures.radius_ratios, target.between(x, rest)
    core = Core(x[count:], rest.astype(np.int32), inner.astype(np.int32), quality, targets)
    sizes = len(core.x), len(rest)
    told = done.start, Record.in_turn(done.rounds)
    figures = target is not None, census, valence[:count]
    return Part(core, Margin(band, *figures, each_once(inner), *sizes, *told))
