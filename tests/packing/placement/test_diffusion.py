import numpy as np
import pytest
import shapely
from examples import BARE
from lattices import uniform
from metrics import uniform_metric
from scipy.spatial import cKDTree

from bubblemesh.case import load_case
from bubblemesh.errors import LimitError
from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.placement.diffusion import ErrorDiffusion, NearLines, boundary_bubbles, equidistributed
from bubblemesh.problem.prepare import prepare
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.survey import ideal_nodes

ENOUGH = 100_000
SQUARE = Domain.of(rings.rectangle(-3, -3, 3, 3))
RING = Domain.of(rings.circle((0, 0), 2), [rings.ellipse((0.4, 0.2), (0.9, 0.5), 30)])
SPACINGS = {
    "uniform": lambda x, y: np.full(x.shape, 0.1),
    "ring": lambda x, y: 0.1 * np.abs(np.hypot(x, y) - 2) + 0.075,
    "linear": lambda x, y: 0.06 + 0.03 * (x + 3),
    "steep": lambda x, y: 0.01 + 0.3 * np.hypot(x - 1, y + 1),
    "waves": lambda x, y: 0.1 + 0.05 * np.sin(3 * x) * np.cos(2 * y),
}


def placed(domain, function):
    spacing = Spacing(function, floor=0.005)
    return spacing, ErrorDiffusion()(domain, spacing, ENOUGH)


@pytest.fixture(scope="module", params=[(domain, name) for domain in (SQUARE, RING) for name in SPACINGS])
def packing(request):
    domain, name = request.param
    return domain, *placed(domain, SPACINGS[name])


def test_number_of_bubbles_is_the_ideal_one(packing):
    domain, spacing, bubbles = packing
    assert len(bubbles) == pytest.approx(ideal_nodes(domain, spacing, ENOUGH, 1e-3), rel=0.02)


def test_bubbles_are_inside_and_not_at_the_boundary(packing):
    domain, spacing, bubbles = packing
    distance = domain.signed_distance(bubbles.x)
    assert np.abs(distance[: bubbles.boundary_count]).max() < 1e-12
    assert (distance[bubbles.interior] > 0.3 * bubbles.d[bubbles.interior]).all()
    np.testing.assert_array_equal(bubbles.d, spacing(bubbles.x))


def test_no_two_bubbles_are_nearer_than_two_leaves(packing):
    _, _, bubbles = packing
    distance, _ = cKDTree(bubbles.x).query(bubbles.x, k=2)
    assert (distance[:, 1] > 0.15 * bubbles.d).all()


def test_every_part_of_the_domain_has_the_bubbles_of_its_area():
    spacing, bubbles = placed(SQUARE, SPACINGS["ring"])
    x = bubbles.x[bubbles.interior]
    for x0 in (-2, -0.5, 1):
        for y0 in (-2, 0.5):
            part = (x[:, 0] > x0) & (x[:, 0] < x0 + 1.5) & (x[:, 1] > y0) & (x[:, 1] < y0 + 1.5)
            at = (np.arange(300) + 0.5) / 200
            grid = np.stack(np.meshgrid(x0 + at, y0 + at), axis=-1).reshape(-1, 2)
            expected = (2 / np.sqrt(3) / spacing(grid) ** 2).mean() * 1.5**2
            # What a row of bubbles on its rim is off by, at random.
            assert abs(part.sum() - expected) < 2 * np.sqrt(4 * 1.5 / 0.1)


def test_number_inside_is_the_area_off_the_boundary_to_the_nearest_whole_number():
    """All over [-side, side]^2 but a strip of sqrt(3) / 4 spacings, with a bubble for every sqrt(3) / 2 of the rest."""
    for side in np.linspace(1.1, 4, 30):
        domain = Domain.of(rings.rectangle(-side, -side, side, side))
        bubbles = ErrorDiffusion(leaf=0.1)(domain, uniform(1.0), ENOUGH)
        expected = (2 * side - np.sqrt(3) / 2) ** 2 / (np.sqrt(3) / 2)
        inside = len(bubbles) - bubbles.boundary_count
        assert abs(inside - expected) < 0.5 + 0.03 * expected


@pytest.mark.parametrize("leaf", [0.1, 0.2, 1 / 3, 0.5])
def test_number_hardly_depends_on_the_leaves(leaf):
    found = ErrorDiffusion(leaf=leaf)(SQUARE, uniform(0.15), ENOUGH)
    assert len(found) == pytest.approx(ideal_nodes(SQUARE, uniform(0.15), ENOUGH, 1e-3), rel=0.015)


@pytest.mark.parametrize("example", BARE)
def test_examples_start_with_the_ideal_number(example):
    problem = prepare(load_case("example.yaml", text=BARE[example]))
    bubbles = ErrorDiffusion()(problem.domain, problem.packing_spacing, ENOUGH)
    assert len(bubbles) == pytest.approx(problem.expected_nodes, rel=0.04)


@pytest.mark.parametrize("scale", [2.0**-40, 2.0**40])
def test_placement_does_not_depend_on_the_unit_of_length(scale):
    function = SPACINGS["ring"]
    _, unit = placed(SQUARE, function)
    large = Domain.of(rings.rectangle(-3 * scale, -3 * scale, 3 * scale, 3 * scale))
    spacing = Spacing(lambda x, y: scale * function(x / scale, y / scale), floor=0.005 * scale)
    np.testing.assert_allclose(ErrorDiffusion()(large, spacing, ENOUGH).x / scale, unit.x, rtol=1e-12, atol=1e-12)


def test_too_many_bubbles_stop_at_the_limit():
    with pytest.raises(LimitError, match=r"limits.max_nodes: the spacing needs more than 100 nodes: coarsen the sp"):
        ErrorDiffusion()(SQUARE, uniform(0.1), 100)
    with pytest.raises(LimitError, match=r"limits.max_nodes: the metric needs more than 100 nodes: coarsen the metric"):
        ErrorDiffusion()(SQUARE, uniform_metric(0.05, 0.2, 0.3), 100)


def test_spacing_larger_than_the_domain_leaves_the_corners():
    bubbles = ErrorDiffusion()(SQUARE, uniform(100.0), ENOUGH)
    np.testing.assert_array_equal(bubbles.x, SQUARE.boundary.corners)
    curved = ErrorDiffusion()(RING, uniform(100.0), ENOUGH)
    assert len(curved) == curved.boundary_count >= 6


def test_boundary_bubbles_are_the_corners_and_those_in_between():
    spacing = Spacing(SPACINGS["linear"])
    shell = boundary_bubbles(SQUARE, spacing)
    piece, s = equidistributed(SQUARE, spacing)
    assert shell.corners == 4
    assert len(shell) == shell.boundary_count == 4 + len(s)
    np.testing.assert_array_equal(shell.x, np.vstack([SQUARE.boundary.corners, SQUARE.boundary.points(piece, s)]))
    np.testing.assert_array_equal(shell.d, spacing(shell.x))
    assert not shell.touched.any()


def test_chords_of_the_boundary_bubbles_do_not_cut_the_boundary_next_to_them():
    domain = Domain.of(rings.circle((0, 0), 1), [rings.circle((0, 0), 0.985)])
    few, _ = equidistributed(domain, uniform(0.5))
    shell = boundary_bubbles(domain, uniform(0.5))
    assert len(shell) > len(few)
    edges, piece = domain.boundary.edges(shell.piece, shell.s)
    lines = shapely.linestrings(shell.x[edges])
    assert shapely.distance(lines[piece == 0][:, None], lines[piece == 1]).min() > 0


@pytest.mark.parametrize("seed", range(3))
def test_distances_to_facets_are_those_of_the_double_loop(seed):
    rng = np.random.default_rng(seed)
    nodes, facets = rng.random((20, 2)), np.array([rng.choice(20, 2, replace=False) for _ in range(15)])
    points, d = rng.random((60, 2)), 10 ** rng.uniform(-2, 0, 60)
    found = NearLines.between(nodes[facets])(points, d)
    expected = []
    for point in points:
        distances = []
        for a, b in nodes[facets]:
            t = np.clip((point - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
            distances.append(np.hypot(*(point - a - t * (b - a))))
        expected.append(min(distances))
    expected = np.array(expected)
    far = np.isinf(found)
    np.testing.assert_allclose(found[~far], expected[~far], atol=1e-15)
    assert (expected[far] > d[far] / 2).all()
    assert far.any()
    assert (~far).any()
