import numpy as np
import pytest
from examples import BARE
from lattices import hexagon, packed_hexagon, uniform

from bubblemesh.case import load_case
from bubblemesh.errors import GeometryError
from bubblemesh.geometry import rings
from bubblemesh.geometry.arrangement.regions import InnerParts
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.hilbert import along_hilbert_curve
from bubblemesh.kernels.library import COMPILED, engine
from bubblemesh.meshes import triangulation
from bubblemesh.packing.levels import SPLIT, Doubling, SingleLevel, finer, steepness
from bubblemesh.packing.net import connect, connect_inside
from bubblemesh.packing.placement import Perturbation
from bubblemesh.packing.placement.diffusion import ErrorDiffusion
from bubblemesh.problem.prepare import prepare
from bubblemesh.spacing.grid.cells import leaves
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.survey import ideal_nodes

SQUARE = Domain.of(rings.rectangle(-3, -3, 3, 3))
NECK = 0.3
HALF_OF_IT = [(-3, -1), (-1, -1), (-1, -NECK / 2), (1, -NECK / 2), (1, -1), (3, -1)]
DUMBBELL = Domain.of(rings.polygon([*HALF_OF_IT, *((-x, -y) for x, y in HALF_OF_IT)]))


def graded(gradient):
    """Linear in x, as if it were for the square."""
    return Spacing(lambda x, y: 0.05 + gradient * (x + 3), floor=0.02)


def inside(domain, count=4000, seed=0):
    x0, y0, x1, y1 = domain.bounds
    points = np.random.default_rng(seed).uniform([x0, y0], [x1, y1], (count, 2))
    return points[domain.contains(points)]


def test_single_level_is_the_requested_spacing():
    spacing = uniform(0.1)
    assert SingleLevel()(SQUARE, spacing, 1e6) == (spacing,)


@pytest.mark.parametrize(
    ("nodes", "levels"),
    [(3, 1), (200, 1), (790, 1), (810, 2), (3190, 2), (3210, 3), (12_700, 3), (12_900, 4), (200 * 4**6 + 1, 7)],
)
def test_each_level_has_a_quarter_of_the_bubbles_down_to_the_fewest(nodes, levels):
    found = Doubling()(SQUARE, uniform(0.01), nodes)
    assert len(found) == levels
    for number, spacing in enumerate(reversed(found)):
        np.testing.assert_allclose(spacing(inside(SQUARE, 100)), 0.01 * 2**number, rtol=1e-12)


@pytest.mark.parametrize(("fewest", "levels"), [(100, 3), (200, 3), (400, 2), (5000, 1)])
def test_the_fewest_bubbles_are_an_option(fewest, levels):
    assert len(Doubling(coarsest_nodes=fewest)(SQUARE, uniform(0.1), 4000)) == levels


def test_coarsest_level_has_the_bubbles_that_were_asked_for():
    spacing = uniform(0.06)
    nodes = ideal_nodes(SQUARE, spacing, 10**6, 1e-2)
    coarsest, *_ = Doubling()(SQUARE, spacing, nodes)
    assert 200 <= len(ErrorDiffusion()(SQUARE, coarsest, 10**5)) < 900


@pytest.mark.parametrize(("gradient", "levels"), [(0.25, 1), (0.21, 1), (0.11, 1), (0.09, 2), (0.045, 3), (0.02, 4)])
def test_levels_end_where_the_spacing_gets_steep(gradient, levels):
    assert len(Doubling()(SQUARE, graded(gradient), 1e6)) == levels


def test_steepest_gradient_is_an_option():
    assert len(Doubling(steepest=0.5)(SQUARE, graded(0.11), 1e6)) == 3


def test_small_steep_place_does_not_count():
    def cusp(radius):
        return Spacing(lambda x, y: 0.05 + 0.5 * np.maximum(radius - np.hypot(x, y), 0), floor=0.02)

    assert len(Doubling()(SQUARE, cusp(0.2), 3300)) == 3
    assert len(Doubling()(SQUARE, cusp(2.5), 3300)) == 1


def test_domain_thinner_than_the_cells_of_the_gradient_has_levels():
    strip = Domain.of(rings.rectangle(0, 0, 10, 0.07))
    assert len(leaves(strip, uniform(0.05), 4.0).sides) == 0
    assert len(Doubling()(strip, uniform(0.05), 900)) == 2


def test_jump_that_is_mild_at_the_finest_level_is_graded_at_the_coarse_ones():
    requested = Spacing(lambda x, y: np.where(x < 0.1, 0.03, 0.05), floor=0.01)
    *coarse, _ = Doubling(coarsest_nodes=1)(SQUARE, requested, 64)
    beyond = np.column_stack([np.full(50, 0.12), np.linspace(-2.8, 2.8, 50)])
    for number, spacing in enumerate(reversed(coarse), start=1):
        assert spacing(beyond).max() < 0.045 * 2**number


@pytest.mark.parametrize("gradient", [0.0, 0.03, 0.3])
def test_steepness_of_a_linear_spacing_is_its_gradient(gradient):
    spacing = Spacing(lambda x, y: 0.1 + gradient * (0.6 * x + 0.8 * y + 4.2))
    assert steepness(leaves(SQUARE, spacing, 4.0), spacing) == pytest.approx(gradient, abs=1e-9)


@pytest.mark.parametrize("example", BARE)
def test_coarse_spacing_is_between_the_requested_one_and_its_double(example):
    problem = prepare(load_case("example.yaml", text=BARE[example]))
    scheme = Doubling(coarsest_nodes=1, steepest=3.0)
    *coarse, finest = scheme(problem.domain, problem.packing_spacing, 300)
    assert len(coarse) >= 3
    assert finest is problem.packing_spacing
    points = np.vstack([inside(problem.domain), problem.domain.polygonal_copy.points])
    requested = problem.packing_spacing(points)
    for number, spacing in enumerate(reversed(coarse), start=1):
        d = spacing(points)
        assert (d >= requested).all()
        assert (d <= 2**number * requested * (1 + 1e-12)).all()
        assert d.max() > 1.05 * requested.max()
        assert spacing.floor > 0


def test_narrow_neck_has_bubbles_side_by_side_at_every_level():
    requested = uniform(0.05)
    *coarse, _ = Doubling(coarsest_nodes=1)(DUMBBELL, requested, 4**4)
    assert len(coarse) == 4
    wall = np.column_stack([np.linspace(-0.9, 0.9, 50), np.full(50, NECK / 2)])
    for number, spacing in enumerate(reversed(coarse), start=1):
        d = spacing(wall)
        assert d.max() <= NECK / 2
        assert d.min() >= 0.05
        assert spacing(np.array([[-2.9, 0.0]]))[0] == pytest.approx(min(0.05 * 2**number, 2 / 3), rel=0.1)


def test_curves_keep_their_shape_at_every_level():
    domain = Domain.of(rings.rectangle(-3, -3, 3, 3), [rings.circle((0, 0), 0.3)])
    *coarse, _ = Doubling(coarsest_nodes=1)(domain, uniform(0.05), 4**5)
    angle = np.linspace(0, 2 * np.pi, 40)
    rim = 0.3 * np.column_stack([np.cos(angle), np.sin(angle)])
    for spacing in coarse:
        assert spacing(rim).max() <= np.pi / 3 * 0.3 * 1.1  # between its vertices the background grid is not exact
        assert ErrorDiffusion()(domain, spacing, 10_000).boundary_count >= 4 + 5


def test_spacing_that_exists_in_the_domain_only_has_coarse_levels():
    def function(x, y):
        with np.errstate(invalid="ignore"):
            return 0.03 + 0.02 * np.sqrt(np.hypot(x, y) - 0.49)

    domain = Domain.of(rings.rectangle(-3, -3, 3, 3), [rings.circle((0, 0), 0.5)])
    spacing = Spacing(function, floor=0.015)
    *coarse, _ = Doubling()(domain, spacing, 200 * 4**3 + 1)
    assert len(coarse) >= 2
    for level in coarse:
        start = ErrorDiffusion()(domain, level, 100_000)
        assert len(connect(start, domain).triangles) > len(start)


@pytest.mark.parametrize("side", [2, 5])
def test_refined_perfect_lattice_is_the_lattice_of_half_the_spacing(side):
    domain, _, bubbles = packed_hexagon(side)
    fine = finer(connect(bubbles, domain), domain, uniform(0.5)).bubbles
    expected = hexagon(2 * side) / 2
    assert len(fine) == len(expected)
    assert sorted(map(tuple, fine.x.round(9) + 0.0)) == sorted(map(tuple, expected.round(9) + 0.0))
    assert fine.boundary_count == 12 * side
    np.testing.assert_array_equal(fine.d, 0.5)
    assert not fine.touched.any()


def test_short_edges_are_not_halved():
    domain, _, bubbles = packed_hexagon(5)
    net = connect(bubbles, domain)
    for d, halved in ((1.02 / SPLIT, False), (0.98 / SPLIT, True)):  # of edges of unit length
        inner = finer(net, domain, uniform(d)).bubbles
        assert (len(inner) - inner.boundary_count > len(bubbles)) is halved


def test_refined_bubbles_keep_away_from_the_finer_boundary():
    domain = Domain.of(rings.circle((0, 0), 2), [rings.circle((0.3, 0), 0.8)])
    coarse = ErrorDiffusion()(domain, uniform(0.4), 10_000)
    fine_spacing = Spacing(lambda x, y: 0.17 + 0.01 * x)
    net = connect(coarse, domain)
    fine = finer(net, domain, fine_spacing).bubbles
    at = fine.boundary_count
    distance = domain.signed_distance(fine.x)
    assert (distance[at:] > 0.45 * fine.d[at:]).all()
    assert np.abs(distance[:at]).max() < 1e-12
    np.testing.assert_array_equal(fine.d, fine_spacing(fine.x))
    ends = coarse.x[net.edges[net.inner]]
    middles = ends.mean(axis=1)[np.hypot(*(ends[:, 0] - ends[:, 1]).T) > 0.3]
    deep = domain.signed_distance(middles) > 0.2
    known = {tuple(x) for x in fine.x.tolist()}
    assert all(tuple(x) in known for x in middles[deep].tolist())
    old = coarse.x[coarse.interior]
    assert all(tuple(x) in known for x in old[domain.signed_distance(old) > 0.2].tolist())


def test_refined_bubbles_are_in_the_order_of_the_hilbert_curve():
    domain, _, bubbles = packed_hexagon(4)
    fine = finer(connect(bubbles, domain), domain, uniform(0.5)).bubbles
    steps = np.hypot(*np.diff(fine.x[fine.interior], axis=0).T)
    np.random.default_rng(0).shuffle(shuffled := fine.x[fine.interior].copy())
    assert np.median(steps) < 0.8
    assert steps.mean() < 0.4 * np.hypot(*np.diff(shuffled, axis=0).T).mean()
    assert sorted(along_hilbert_curve(fine.x[fine.interior]).tolist()) == list(range(len(steps) + 1))


ROUND = Domain.of(rings.circle((0, 0), 2), [rings.circle((0.3, 0), 0.8), rings.circle((-1.3, 0), 0.05)])
LINES = (
    rings.open_path((0.5, 0.5), [rings.LineTo((2.5, 0.9)), rings.LineTo((2.2, 1.7))], "wall"),
    rings.open_path((0, 1.2), [rings.LineTo((1.6, 1.2))], "crack"),
)
LINED = Domain.of(rings.rectangle(0, 0, 3, 2), parts=InnerParts(lines=LINES))


def from_origin(least):
    return Spacing(lambda x, y: least * (1 + 0.3 * np.hypot(x, y)))


@pytest.mark.parametrize(
    ("domain", "coarse", "fine"),
    [
        (ROUND, uniform(0.3), uniform(0.15)),
        (ROUND, uniform(0.5), uniform(0.1)),
        (ROUND, from_origin(0.2), uniform(0.17)),  # where it was fine already, few edges are halved
        (DUMBBELL, uniform(0.2), from_origin(0.1)),
        (LINED, uniform(0.25), from_origin(0.1)),
    ],
    ids=["round", "steep", "graded", "dumbbell", "lines"],
)
@pytest.mark.parametrize("seed", range(4))
def test_refined_net_is_that_of_its_bubbles_connected_anew(domain, coarse, fine, seed):
    start = ErrorDiffusion()(domain, coarse, 10_000)
    random = np.random.default_rng(seed)
    net = connect_inside(Perturbation(jitter=0.1)(start, coarse, random), domain, coarse)
    found = finer(net, domain, fine)
    anew = connect(found.bubbles, domain)
    for one in ("facets", "facet_piece", "two_sided", "triangles", "edges"):
        np.testing.assert_array_equal(getattr(found, one), getattr(anew, one))
    assert len(found.bubbles) > len(net.bubbles)
    assert (found.legal is not None) == (engine() == COMPILED)


@pytest.mark.parametrize("fault", [None, GeometryError("constraints cross")])
def test_a_finer_boundary_that_crosses_the_triangles_costs_a_triangulation_of_all(monkeypatch, fault):
    start, coarse = ErrorDiffusion()(ROUND, uniform(0.3), 10_000), uniform(0.3)
    net = connect_inside(Perturbation(jitter=0.1)(start, coarse, np.random.default_rng(0)), ROUND, coarse)

    def linked(points, constraints, two_sided=None):
        if fault is not None:
            raise fault
        return triangulation.linked(points, constraints, two_sided)

    monkeypatch.setattr("bubblemesh.packing.levels.linked", linked)
    found = finer(net, ROUND, uniform(0.15))
    anew = connect(found.bubbles, ROUND)
    np.testing.assert_array_equal(found.triangles, anew.triangles)
    assert (found.legal is not None) == (engine() == COMPILED and fault is None)


def test_levels_do_not_depend_on_the_unit_of_length():
    scale = 2.0**30
    large = Domain.of(rings.polygon(DUMBBELL.boundary.corners * scale))
    points = inside(DUMBBELL, 300)
    for one, other in zip(
        Doubling(coarsest_nodes=1)(DUMBBELL, uniform(0.05), 64),
        Doubling(coarsest_nodes=1)(large, uniform(0.05 * scale), 64),
        strict=True,
    ):
        np.testing.assert_allclose(other(scale * points) / scale, one(points), rtol=1e-9)
