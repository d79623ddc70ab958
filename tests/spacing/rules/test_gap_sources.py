import numpy as np
import pytest
from lattices import uniform
from partitions import domain_of, mesh_of

from bubblemesh.errors import LimitError
from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.narrow_parts import FacingWalls
from bubblemesh.meshes.quality import radius_ratios
from bubblemesh.spacing.expression import Expression
from bubblemesh.spacing.rules.gap_sources import GapSources, surely_wide
from bubblemesh.spacing.rules.rules import Rules
from bubblemesh.spacing.spacing import Spacing

PLATE = "domain: {outer: {rectangle: [0, 0, 2, 1]}, "
ALONG = np.linspace(0.6, 1.4, 41)


def level(y):
    """Places along a horizontal line."""
    return np.column_stack([ALONG, np.full(41, y)])


def ring(radius):
    """Places on a circle in the middle of the plate."""
    angle = np.linspace(0, 2 * np.pi, 41)
    return np.array([1, 0.5]) + radius * np.column_stack([np.cos(angle), np.sin(angle)])


def coat(side):
    return f"regions: [{{name: coat, ring: {side}}}]}}"


def disc(name, radius):
    return f"{{name: {name}, ring: {{circle: {{center: [1, 0.5], radius: {radius}}}}}}}"


LAYER = [[0.5, 0.4], [1.5, 0.4], [1.5, 0.43], [0.5, 0.43]]
BLADE = "{through: [[0, 0.06], [-0.5, 0.05], [-1, 0], [-0.5, -0.05], [0, -0.06], [0.5, -0.05], [0.5, 0.05]]}"
NARROW = {
    "coat": (PLATE + coat("{rectangle: [0, 0, 2, 0.05]}"), level(0.025), 0.05),
    "coat, clockwise": (PLATE + coat("{path: [[0, 0], [0, 0.05], [2, 0.05], [2, 0]]}"), level(0.025), 0.05),
    "all but a coat": (PLATE + coat("{rectangle: [0, 0.05, 2, 1]}"), level(0.025), 0.05),
    "nested circles": (PLATE + f"regions: [{disc('a', 0.3)}, {disc('b', 0.27)}]}}", ring(0.285), 0.03),
    "layer": (PLATE + coat(f"{{path: {LAYER}}}"), level(0.415), 0.03),
    "layer, clockwise": (PLATE + coat(f"{{path: {LAYER[::-1]}}}"), level(0.415), 0.03),
    "lines": (
        PLATE + "lines: [{path: [[0.2, 0.5], [1.8, 0.5]]}, {path: [[1.8, 0.55], [0.2, 0.55]]}]}",
        level(0.525),
        0.05,
    ),
    "thin ellipse": (
        PLATE + "regions: [{name: crack, ring: {ellipse: {center: [1, 0.5], radii: [0.8, 0.025]}}}]}",
        np.array([[0.95, 0.5], [1, 0.49], [1, 0.51], [1.1, 0.5]]),
        0.05,
    ),
    "line that ends before a wall": (PLATE + "lines: [{path: [[1, 0.5], [1, 0.97]]}]}", np.array([[1, 0.985]]), 0.03),
    "points": (PLATE + "points: [{at: [1, 0.5]}, {at: [1.05, 0.5]}]}", np.array([[1.025, 0.5]]), 0.05),
    "needle": (
        PLATE + "holes: [{polygon: [[0.9, 0.5], [1, 0.05], [1.1, 0.5]]}]}",
        np.array([[1, 0.025]]),
        0.05,
    ),
    "lens": (
        "domain: {outer: {path: [[-1, 0], {arc: {to: [1, 0], center: [0, 20], turn: left}}, "
        "{arc: {to: [-1, 0], center: [0, -20], turn: left}}]}}",
        np.array([[0, 0]]),
        0.05,
    ),
}


@pytest.mark.long
@pytest.mark.parametrize("growth", [None, 0.15])
@pytest.mark.parametrize(("text", "places", "width"), NARROW.values(), ids=NARROW)
def test_whatever_leaves_a_narrow_part_makes_the_spacing_fine_there(text, places, width, growth):
    d = Rules(growth=growth, across=3)(domain_of(text), uniform(0.2)).spacing(places)
    assert d.max() < 1.05 * width / 3
    assert d.mean() > 0.9 * width / 3


@pytest.mark.long
@pytest.mark.parametrize("x", [0, 0.5, 1.5, 1.9, 1.98])
def test_walls_of_one_smooth_curve_are_resolved_up_to_its_ends(x):
    ellipse = Domain.of(rings.ellipse((0, 0), (2, 0.05)))
    d = Rules(across=3)(ellipse, uniform(0.3)).spacing(np.array([[x, 0.0], [-x, 0.0]]))
    width = 0.1 * np.sqrt(1 - (x / 2) ** 2)
    np.testing.assert_allclose(d, width / 3, rtol=0.12)


def test_disc_counts_as_a_narrow_part_only_if_it_is_small():
    disc = Domain.of(rings.circle((0, 0), 0.5))
    assert Rules(across=3)(disc, uniform(0.33)).ratio == 1.0
    assert Rules(across=3)(disc, uniform(0.4)).spacing(np.zeros((1, 2)))[0] == pytest.approx(1 / 3, rel=0.06)


def test_what_is_narrow_outside_of_the_domain_needs_nothing():
    slit = "holes: [{polygon: [[0.5, 0.5], [1, 0.495], [1.5, 0.5], [1.5, 0.51], [1, 0.515], [0.5, 0.51]]}]}"
    assert len(GapSources(3, 0.4, lambda p: np.zeros(len(p)))(domain_of(PLATE + slit), uniform(0.1))) == 0


@pytest.mark.long
def test_what_is_beside_a_thin_hole_is_left_as_it_is():
    """It is beyond a narrow part for who looks through the hole."""
    hole = "holes: [{rectangle: [0.2, 0.2, 1.8, 0.21]}]}"
    d = Rules(across=2)(domain_of(PLATE + hole), uniform(0.15)).spacing(np.array([[1, 0.35], [1, 0.1]]))
    assert d.tolist() == pytest.approx([0.15, 0.1], rel=0.08)


MESHED = {
    "coat": (PLATE + coat("{path: [[0, 0], [0, 0.08], [2, 0.08], [2, 0]]}"), 3, 0.0, 0.08),
    "lines": (PLATE + "lines: [{path: [[0, 0.5], [2, 0.5]]}, {path: [[2, 0.58], [0, 0.58]]}]}", 3, 0.5, 0.58),
}


@pytest.mark.long
@pytest.mark.parametrize(("text", "across", "low", "high"), MESHED.values(), ids=MESHED)
def test_meshes_have_their_rows_of_nodes_across(text, across, low, high):
    mesh = mesh_of(text + f"\nspacing: {{maximum: 0.2, across: {across}}}")
    x, y = mesh.points.T
    for a in np.arange(0.5, 1.5, 0.1):
        column = (np.abs(x - a) < 0.05) & (y > low + 1e-9) & (y < high - 1e-9)
        rows = (high - low) / across
        assert column.sum() == pytest.approx(2 / np.sqrt(3) * 0.1 * (high - low) / rows**2 - 0.1 / rows, abs=4)
    assert radius_ratios(mesh.points, mesh.triangles).min() > 0.6


TOO_FINE = {
    "strip": Domain.of(rings.rectangle(0, 0, 100, 0.01)),
    "holes": Domain.of(
        rings.rectangle(0, 0, 2, 1), [rings.rectangle(0.5, 0.5, 1.5, 0.6), rings.rectangle(0.5, 0.60001, 1.5, 0.7)]
    ),
}


@pytest.mark.parametrize("domain", TOO_FINE.values(), ids=TOO_FINE)
def test_narrow_parts_that_need_too_many_nodes_are_refused(domain):
    with pytest.raises(LimitError, match=r"limits.max_nodes: spacing.across .* only (0\.01|1e-05) wide: set"):
        Rules(across=100)(domain, uniform(0.5), 100_000)
    assert Rules(across=100, minimum=0.2)(domain, uniform(0.5), 100_000).spacing(np.array([[1, 0.005]])) > 0.19


@pytest.mark.parametrize(
    ("function", "times", "wide"),
    [
        (Expression.parse("0.3 + 0.1*x"), 1.0, True),
        (Expression.parse("0.3 + 0.1*x"), 3.0, False),
        (Expression.parse("0.1*x"), 1.0, False),  # zero at a wall, which the look for gaps refuses
        (Expression.parse("mod(x, 2)/10 + 0.1"), 1.0, False),  # without bounds
    ],
)
def test_a_strip_is_surely_wide_where_bounds_of_the_spacing_are_less(function, times, wide):
    walls = FacingWalls(Domain.of(rings.rectangle(0, 0, 6, 1)))
    assert surely_wide(walls, Spacing(function), times) is wide
