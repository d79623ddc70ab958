import numpy as np
import pytest
from examples import EXAMPLES
from lattices import uniform

from bubblemesh.case import load_case
from bubblemesh.errors import GeometryError, LimitError
from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.quality import radius_ratios
from bubblemesh.packing.boundary_edges import split_cutting_edges
from bubblemesh.packing.net import connect
from bubblemesh.packing.placement.subdivision import HierarchicalSubdivision
from bubblemesh.problem.prepare import prepare
from bubblemesh.spacing.spacing import Spacing

ENOUGH = 100_000
SQUARE = Domain.of(rings.rectangle(-3, -3, 3, 3))
RING_SPACING = Spacing(lambda x, y: 0.2 * np.abs(np.hypot(x, y) - 2) + 0.15, floor=0.075)
DENSE_SPACING = Spacing(lambda x, y: 0.35 * np.abs(np.hypot(x, y) - 2) + 0.05, floor=0.025)


def placed(domain, spacing, **weights):
    return HierarchicalSubdivision(**weights)(domain, spacing, ENOUGH)


@pytest.mark.parametrize(("w2", "nodes"), [(1, 1420), (0.8, 1139), (0.7, 983), (0.6, 826), (0.57, 660)])
def test_interior_weight_gives_the_counts_of_the_paper(w2, nodes):
    assert len(placed(SQUARE, RING_SPACING, w2=w2)) == nodes


@pytest.mark.parametrize(("w1", "nodes"), [(0.8, 1404), (0.9, 1404), (1, 1420), (1.2, 1444), (1.5, 1460), (2, 1508)])
def test_boundary_weight_gives_the_counts_of_the_paper(w1, nodes):
    assert len(placed(SQUARE, RING_SPACING, w1=w1)) == nodes


def test_initial_triangulation_is_that_of_the_paper():
    bubbles = placed(SQUARE, RING_SPACING)
    assert bubbles.boundary_count == 80
    triangles = connect(bubbles, SQUARE).triangles
    assert len(triangles) == 2758
    q = radius_ratios(bubbles.x, triangles)
    assert q.mean() == pytest.approx(0.974, abs=5e-4)
    assert q.min() == pytest.approx(0.464, abs=5e-4)


def test_dense_example_has_the_count_of_the_paper():
    assert len(placed(SQUARE, DENSE_SPACING, w2=0.6)) == 1822


def test_first_example_changes_its_interior_exactly_at_one_weight():
    domain = Domain.of(rings.rectangle(-1, -2, 1, 2))
    side = 8 / np.sqrt(3) / 2**5
    weight = 0.1 / side  # at which rhombi of the fifth level are split, all at once
    assert weight == pytest.approx(0.6928, abs=5e-5)
    below, at, above = (placed(domain, uniform(0.1), w2=w2) for w2 in (weight * (1 - 1e-6), weight, 1.0))
    assert len(below) < len(at) == len(above)


@pytest.mark.parametrize("example", ["1", "2", "3", "4"])
def test_bubbles_are_inside_and_keep_their_clearance(example):
    problem = prepare(load_case("example.yaml", text=EXAMPLES[example]))
    bubbles = problem.method.placement(problem.domain, problem.packing_spacing, ENOUGH)
    distance = problem.domain.signed_distance(bubbles.x)
    assert np.abs(distance[: bubbles.boundary_count]).max() < 1e-12
    assert (distance[bubbles.interior] > 0.3 * bubbles.d[bubbles.interior]).all()
    np.testing.assert_array_equal(bubbles.d, problem.packing_spacing(bubbles.x))


def test_runaway_subdivision_stops_at_the_limit():
    scheme = HierarchicalSubdivision()
    with pytest.raises(LimitError, match=r"limits.max_nodes: the spacing needs more than 100 nodes"):
        scheme(SQUARE, uniform(0.02), 100)
    with pytest.raises(LimitError):
        scheme(SQUARE, Spacing(lambda x, y: np.where(np.abs(x) < 3, 10.0, 1e-12), floor=1.0), 100)


def test_spacing_larger_than_the_domain_leaves_the_corners():
    bubbles = placed(SQUARE, uniform(100.0))
    np.testing.assert_array_equal(bubbles.x, SQUARE.boundary.corners)


@pytest.mark.parametrize("scale", [1e15, 1e-12, 2.0**40])
def test_placement_does_not_depend_on_the_unit_of_length(scale):
    unit = placed(SQUARE, RING_SPACING, w2=0.6)
    large = placed(
        Domain.of(rings.rectangle(-3 * scale, -3 * scale, 3 * scale, 3 * scale)),
        Spacing(lambda x, y: scale * RING_SPACING.function(x / scale, y / scale), floor=0.075 * scale),
        w2=0.6,
    )
    np.testing.assert_allclose(large.x / scale, unit.x, atol=1e-12)


@pytest.mark.parametrize("curve", [rings.circle((0, 0), 1), rings.ellipse((0, 0), (1, 1), 45)])
def test_closed_curve_is_divided_evenly(curve):
    domain = Domain.of(curve)
    bubbles = placed(domain, uniform(0.2))
    assert bubbles.corners == 0
    assert bubbles.boundary_count == 32
    np.testing.assert_allclose(np.diff(bubbles.s), domain.boundary.lengths[0] / 32, rtol=1e-9)


def test_chords_of_a_coarse_curve_do_not_cut_the_boundary_next_to_it():
    domain = Domain.of(rings.circle((0, 0), 1), [rings.circle((0, 0), 0.985)])
    bubbles = placed(domain, uniform(0.5))
    net = connect(bubbles, domain)
    assert len(bubbles) == bubbles.boundary_count
    assert len(net.triangles) == len(net.facets)


def test_chords_of_a_coarse_curve_do_not_cut_off_a_hole():
    domain = Domain.of(
        rings.circle((0, 0), 1), [rings.circle((0.995 * np.cos(np.pi / 16), 0.995 * np.sin(np.pi / 16)), 0.002)]
    )
    bubbles = placed(domain, uniform(0.5))
    net = connect(bubbles, domain)
    edges, edge_piece = net.facets, net.facet_piece
    outer = bubbles.x[edges[domain.boundary.ring[edge_piece] == 0]]
    middle = outer.mean(axis=1)
    hole = domain.boundary.ring[edge_piece] == 1
    nearest = np.hypot(*(middle[:, None] - bubbles.x[edges[hole, 0]]).transpose(2, 0, 1))
    chord = outer[nearest.min(axis=1).argmin()]
    (ax, ay), (bx, by) = chord[1] - chord[0], (bubbles.x[edges[hole, 0]] - chord[0]).T
    assert (ax * by - ay * bx > 0).all()


def test_chords_do_not_cut_a_curve_that_touches():
    domain = Domain.of(rings.circle((0, 0), 1), [rings.circle((0.5, 0), 0.5)])
    fine = placed(domain, uniform(0.1))
    outer = domain.boundary.ring[fine.piece] == 0
    slides = np.flatnonzero(~outer | (np.arange(len(outer)) % 8 == 0))
    coarse = fine.select(np.concatenate([np.arange(fine.corners), fine.corners + slides]))
    with pytest.raises(GeometryError, match="ntersecting constraint edges"):
        connect(coarse, domain)
    whole = split_cutting_edges(coarse, domain, uniform(0.1))
    assert len(connect(whole, domain).triangles) > 0
    assert len(coarse) < len(whole) < fine.boundary_count
