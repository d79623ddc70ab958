from itertools import product

import numpy as np
import pytest
from lattices import uniform
from sweeps import sweep

from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.spacing.grid import cells as grid_cells
from bubblemesh.spacing.grid.cells import leaves, leaves_in_blocks
from bubblemesh.spacing.spacing import Spacing

SQUARE = Domain.of(rings.rectangle(0, 0, 1, 1))
DOMAINS = {
    "square": SQUARE,
    "strip": Domain.of(rings.rectangle(-3, 1, 5, 1.5)),
    "angle": Domain.of(rings.polygon([(0, 0), (2, 0), (2, 0.3), (0.3, 0.3), (0.3, 2), (0, 2)])),
    "ring": Domain.of(rings.circle((1, 1), 2), [rings.circle((0.5, 1), 1.2)]),
}
SPACINGS = {
    "uniform": lambda x, y: np.full(x.shape, 0.1),
    "gentle": lambda x, y: 0.04 + 0.05 * np.hypot(x - 1, y),
    "steep": lambda x, y: np.minimum(0.01 + 0.8 * np.hypot(x - 0.2, y - 0.1), 0.2),
    "step": lambda x, y: np.where(x < 0.7, 0.2, 0.04),
}


def cells(domain="square", spacing="uniform", fraction=1 / 3):
    function = Spacing(SPACINGS[spacing], floor=0.005)
    return DOMAINS[domain], function, leaves(DOMAINS[domain], function, fraction)


@pytest.mark.long
@pytest.mark.parametrize("domain", DOMAINS)
def test_leaves_cover_the_area_of_the_domain(domain):
    domain = DOMAINS[domain]
    errors = []
    for d in (0.06, 0.03, 0.015):
        found = leaves(domain, uniform(d), 1 / 3)
        errors.append((found.sides**2).sum() / domain.polygon.area - 1)
        # Cells count by their centres: what is wrong is half a cell all along the boundary at most.
        assert abs(errors[-1]) * domain.polygon.area <= domain.polygon.length * found.sides.max() / 2
    assert abs(errors[-1]) < 0.015


@pytest.mark.long
@pytest.mark.parametrize("spacing", SPACINGS)
@pytest.mark.parametrize("domain", DOMAINS)
def test_every_place_off_the_boundary_is_in_one_leaf(domain, spacing):
    domain, d, found = cells(domain, spacing)
    x0, y0, x1, y1 = domain.bounds
    points = np.random.default_rng(0).uniform([x0, y0], [x1, y1], (600, 2))
    farthest = found.sides.max() / np.sqrt(2)
    # A cell of that size reaches so far beyond its centre; the spacing in it may differ from that at the point.
    inside = points[domain.signed_distance(points) > np.minimum(farthest, 0.3 * d.extended(points))][:150]
    _, point = np.nonzero((np.abs(found.centers[:, None] - inside) < found.sides[:, None, None] / 2).all(axis=2))
    assert len(inside) > 40
    assert sorted(point.tolist()) == list(range(len(inside)))


@pytest.mark.parametrize("fraction", [0.1, 1 / 3, 0.5, 4.0])
@pytest.mark.parametrize("spacing", SPACINGS)
@pytest.mark.parametrize("domain", ["square", "ring"])
def test_leaves_are_as_small_as_asked_for_and_no_smaller(domain, spacing, fraction):
    domain, d, found = cells(domain, spacing, fraction)
    assert domain.contains(found.centers).all()
    np.testing.assert_array_equal(found.d, d(found.centers))
    assert (found.sides <= fraction * found.d).all()
    x0, y0, _, _ = domain.bounds
    size = domain.size
    doubled = 2 * found.sides
    parents = [x0, y0] + (np.floor((found.centers - [x0, y0]) / doubled[:, None]) + 0.5) * doubled[:, None]
    assert ((doubled > fraction * d.extended(parents)) | (doubled > size)).all()


def test_uniform_leaves_of_a_square_are_a_grid():
    found = leaves(SQUARE, uniform(0.2), 1 / 3)
    assert len(found.centers) == 256
    np.testing.assert_array_equal(found.sides, 1 / 16)
    np.testing.assert_array_equal(found.d, 0.2)


@pytest.mark.parametrize("spacing", SPACINGS)
def test_leaves_follow_each_other_along_a_curve(spacing):
    _, _, found = cells("square", spacing)
    step = np.abs(np.diff(found.centers, axis=0))
    touching = (found.sides[:-1] + found.sides[1:]) / 2
    np.testing.assert_allclose(step.max(axis=1), touching, rtol=1e-12)  # they have an edge in common
    assert (step.min(axis=1) < 0.999 * touching).all()


@pytest.mark.parametrize(("domain", "spacing", "most"), sweep(product(DOMAINS, SPACINGS, [30, 100, 300]), quick=13))
def test_leaves_in_blocks_are_the_same_in_the_same_order(domain, spacing, most, monkeypatch):
    domain, d, whole = cells(domain, spacing, 1.0)
    monkeypatch.setattr(grid_cells, "MOST_AT_ONCE", most)
    blocks = list(leaves_in_blocks(domain, d, 1.0))
    assert len(blocks) > len(whole.sides) / (4 * most)
    assert max(len(block.sides) for block in blocks) <= 4 * most
    for found, expected in zip(leaves(domain, d, 1.0), whole, strict=True):
        np.testing.assert_array_equal(found, expected)


def test_spacing_that_grows_a_thousandfold_from_a_point():
    steep = Spacing(lambda x, y: 0.0005 + 0.5 * np.hypot(x - 0.3, y - 0.7))
    found = leaves(SQUARE, steep, 1 / 3)
    assert found.d.max() / found.d.min() > 500
    assert (found.sides**2).sum() == pytest.approx(1, rel=1e-12)
    assert len(found.sides) < 20_000


def test_spacing_that_exists_in_the_domain_only():
    def function(x, y):
        with np.errstate(invalid="ignore"):
            return 0.05 + 0.1 * np.sqrt(np.hypot(x - 0.5, y - 1) - 1.2)

    domain = DOMAINS["ring"]
    found = leaves(domain, Spacing(function, floor=0.02), 1 / 3)
    assert (found.sides**2).sum() == pytest.approx(domain.polygon.area, rel=0.02)


def test_spacing_larger_than_the_domain_leaves_its_box():
    found = leaves(SQUARE, uniform(100.0), 1 / 3)
    assert found.centers.tolist() == [[0.5, 0.5]]
    assert found.sides.tolist() == [1.0]


def test_domain_without_leaves_in_the_middle_of_its_box():
    found = leaves(DOMAINS["ring"], uniform(100.0), 1 / 3)
    assert found.centers.shape == (len(found.sides), 2)
    assert found.d.shape == found.sides.shape
