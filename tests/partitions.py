"""Cases with regions and what is embedded: how tests mesh them, and what every such mesh must hold."""

from collections import Counter
from functools import cache
from itertools import pairwise

import numpy as np
import shapely

from bubblemesh.case import load_case
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.meshes.triangulation import regions
from bubblemesh.packing.rounds import rounds
from bubblemesh.problem.prepare import prepare
from bubblemesh.run.pipeline import mesh_case

# Outline whose left and right sides are arcs, one the other moved.
MOONS = """
  outer:
    path:
      - [0, 0]
      - {to: [2, 0], label: bottom}
      - {arc: {to: [2, 1], center: [2, 0.5], turn: left}, label: right}
      - {to: [0, 1], label: top}
      - {arc: {to: [0, 0], center: [0, 0.5], turn: right}, label: left}
"""


@cache
def domain_of(text):
    """The checked domain of a case text without a spacing, made once."""
    return prepare(load_case("parts.yaml", text=text + "\nspacing: 0.2\n")).domain


def packed(text, method="multilevel"):
    """Domain and last net of a case."""
    problem = prepare(load_case("parts.yaml", text=text, method=method))
    domain = problem.domain
    levels = problem.method.levels(domain, problem.packing_spacing, problem.expected_nodes)
    *_, last = rounds(problem.method.placement(domain, levels[0], 100_000), domain, levels, problem.method)
    return domain, last.net


@cache
def mesh_of(text):
    """The mesh of a case, made once."""
    return mesh_case(load_case("parts.yaml", text=text)).mesh


def region_of(domain, net):
    """Region (t,) of each triangle."""
    left, right = (side[net.facet_piece] for side in (domain.boundary.left, domain.boundary.right))
    return regions(net.triangles, net.facets, left, right)


def areas_of(domain, net):
    """Area of each region by name, as meshed."""
    region, area = region_of(domain, net), signed_areas(net.bubbles.x, net.triangles)
    names = [domain.parts.rest, *(one.name for one in domain.parts.regions)]
    return {name: float(area[region == k].sum()) for k, name in enumerate(names)}


def innermost(domain, points):
    """Region (m,) of points by looking into every region, the largest first."""
    found = np.zeros(len(points), int)
    for k in sorted(range(len(domain.parts.regions)), key=lambda k: -domain.parts.regions[k].polygon.area):
        found[shapely.contains_xy(domain.parts.regions[k].polygon, points)] = k + 1
    return found


def check_pieces(domain, aside=1e-4):
    """Fail unless pieces meet at corners only, and have the right regions beside their middles."""
    b = domain.boundary
    numbers = np.arange(len(b.kind))
    middle, tangent = b.points(numbers, b.lengths / 2), b.tangents(numbers, b.lengths / 2)
    normal = aside * np.column_stack([-tangent[:, 1], tangent[:, 0]])
    assert b.left.tolist() == innermost(domain, middle + normal).tolist()
    inner = np.flatnonzero(b.inner)
    assert b.right[inner].tolist() == innermost(domain, (middle - normal)[inner]).tolist()
    assert set(b.right[~b.inner].tolist()) == {-1}
    assert shapely.contains_xy(domain.polygon, middle[inner]).all()
    open_ = np.flatnonzero(~b.closed)
    zero = np.zeros(len(open_))
    np.testing.assert_allclose(b.points(open_, zero), b.corners[b.start[open_]], atol=1e-8)
    np.testing.assert_allclose(b.points(open_, b.lengths[open_]), b.corners[b.end[open_]], atol=1e-8)
    piece, s, step = b.stations()
    ends = np.stack([b.points(piece, s), b.points(piece, s + step)], axis=1)
    for side, corner, joint in ((0, b.start, np.diff(piece, prepend=-1)), (1, b.end, np.diff(piece, append=-1))):
        here = np.flatnonzero((joint != 0) & ~b.closed[piece])
        ends[here, side] = b.corners[corner[piece[here]]]
    chords = shapely.linestrings(ends)
    crossing = shapely.STRtree(chords).query(chords, predicate="crosses")
    assert (piece[crossing[0]] == piece[crossing[1]]).all()


def check_net(domain, net):
    """Fail unless the net is conforming, and its triangles are in the regions that they lie in."""
    x, triangles = net.bubbles.x, net.triangles
    assert set(triangles.ravel().tolist()) == set(range(len(x))), "a node is unused"
    assert len({tuple(point) for point in x.tolist()}) == len(x), "two nodes coincide"
    area = signed_areas(x, triangles)
    assert area.min() > 0
    sides = Counter(side for i, j, k in triangles.tolist() for side in pairwise((i, j, k, i)))
    assert set(sides.values()) == {1}, "an edge has two triangles on one side"
    one, two = ([tuple(facet) for facet in net.facets[which].tolist()] for which in (~net.two_sided, net.two_sided))
    assert sorted(one) == sorted((i, j) for i, j in sides if (j, i) not in sides), "facets of rings are free edges"
    assert all((i, j) in sides and (j, i) in sides for i, j in two), "inner facets are edges of two triangles"
    assert len({frozenset(facet) for facet in one + two}) == len(net.facets), "a facet comes twice"
    assert set(net.facet_piece.tolist()) == set(range(len(domain.boundary.kind)))
    found, expected = region_of(domain, net), innermost(domain, x[triangles].mean(axis=1))
    if not domain.boundary.curved.any():
        assert found.tolist() == expected.tolist()
        for k, region in enumerate(domain.parts.regions, start=1):
            inside = region.polygon.intersection(domain.polygon)
            for other in domain.parts.regions:
                if other.polygon.area < region.polygon.area:
                    inside = inside.difference(other.polygon)
            np.testing.assert_allclose(area[found == k].sum(), inside.area, rtol=1e-9)
    else:
        assert (found == expected).mean() > 0.97
