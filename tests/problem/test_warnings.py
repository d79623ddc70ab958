import re

import numpy as np
import pytest

from bubblemesh.case import load_case
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.narrow_parts import FacingWalls
from bubblemesh.geometry.rings import ArcTo, LineTo, circle, path, polygon, rectangle
from bubblemesh.problem.prepare import prepare
from bubblemesh.problem.warnings import (
    RefiningEdges,
    far_shorter_edges,
    limited_growth,
    narrow_parts,
    refined_boundary,
    sharp_angles,
)
from bubblemesh.spacing.rules.grading import LimitedSpacing
from bubblemesh.spacing.rules.resolution import SteepestPlace
from bubblemesh.spacing.rules.rules import Rules
from bubblemesh.spacing.rules.sources import Sources, coarse_curves, short_pieces
from bubblemesh.spacing.spacing import Spacing


def uniform(d):
    return Spacing(lambda x, y: np.full(x.shape, float(d)))


NONE = Sources(np.zeros((0, 2)), np.zeros(0))


def _refined(domain, spacing, coarse=NONE):
    short = short_pieces(domain, spacing)
    return refined_boundary(short, coarse, RefiningEdges.of(domain, short))


RADIAL = Spacing(lambda x, y: np.hypot(x, y) / 8)
SQUARE = rectangle(-1, -1, 1, 1)
ECCENTRIC = path(
    (0.1, 0),
    [
        LineTo((1, 0)),
        ArcTo((-1, 0), (0, 0), True),
        LineTo((-0.9, 0)),
        ArcTo((0.1, 0), (-0.4, 0), False),
    ],
)
HARMLESS = {
    "square": (Domain.of(SQUARE), uniform(0.1)),
    "coarse square": (Domain.of(SQUARE), uniform(0.9)),
    "disc": (Domain.of(circle((0, 0), 1)), uniform(0.05)),
    "coarse disc": (Domain.of(circle((0, 0), 1)), uniform(0.9)),
    "annulus": (Domain.of(circle((0, 0), 2), [circle((0, 0), 0.5)]), RADIAL),
    "rectangle": (Domain.of(rectangle(-1, -2, 1, 2)), uniform(0.1)),
    "perforated square": (Domain.of(SQUARE, [circle((0, 0), 0.4)]), RADIAL),
    "valley": (Domain.of(rectangle(-3, -3, 3, 3)), Spacing(lambda x, y: 0.2 * np.abs(np.hypot(x, y) - 2) + 0.15)),
    "steep valley": (
        Domain.of(rectangle(-3, -3, 3, 3)),
        Spacing(lambda x, y: 0.35 * np.abs(np.hypot(x, y) - 2) + 0.05),
    ),
    "eccentric half annulus": (Domain.of(ECCENTRIC), uniform(0.05)),
    "slot outside": (
        Domain.of(polygon([(0, 0), (1, 0), (1, 1), (0.53, 1), (0.53, 0.5), (0.47, 0.5), (0.47, 1), (0, 1)])),
        uniform(0.08),
    ),
}
harmless = pytest.mark.parametrize(("domain", "spacing"), HARMLESS.values(), ids=HARMLESS)


@harmless
def test_no_false_alarm_of_sharp_angles(domain, spacing):
    assert sharp_angles(domain) == []


@harmless
def test_no_false_alarm_of_narrow_parts(domain, spacing):
    assert narrow_parts(FacingWalls(domain), spacing, None, None) == []


@pytest.mark.parametrize("half_width", [1e-6, 1e-7, 1e-8])
@pytest.mark.parametrize("turn", [0, 1.2, 4.3])
def test_the_tip_of_a_slit_is_no_sharp_corner_and_that_of_a_needle_is(half_width, turn):
    square = np.array([(0, -1), (1, -1), (1, 1), (0, 1)])
    slit = np.array([(0, half_width), (0.5, 0), (0, -half_width)])
    turned = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    assert sharp_angles(Domain.of(polygon(np.vstack([square, slit]) @ turned))) == []
    needle = np.array([(1, -1), (1, -half_width), (1.5, 0), (1, half_width), (1, 1), (0, 1), (0, -1)])
    assert len(sharp_angles(Domain.of(polygon(needle @ turned)))) == 1


@pytest.mark.parametrize("degrees", [1, 3, 4.9])
@pytest.mark.parametrize("turn", [0, 2.5, 4.3])
def test_sharp_corner_is_named_with_its_angle(degrees, turn):
    a = np.radians([0, degrees]) + turn
    needle = polygon([(2, 3), *(np.array([2, 3]) + np.column_stack([np.cos(a), np.sin(a)]))])
    assert sharp_angles(Domain.of(needle)) == [
        f"the angle at (2, 3) is {degrees:.2g} degrees: triangles there are as sharp in any mesh"
    ]


@pytest.mark.parametrize("degrees", [5.1, 45, 180, 355.1, 359])
def test_other_corners_are_not_sharp(degrees):
    a = np.radians(degrees * np.array([0, 0.25, 0.5, 0.75, 1]))
    assert sharp_angles(Domain.of(polygon([(0, 0), *np.column_stack([np.cos(a), np.sin(a)])]))) == []


def test_spike_of_a_hole_is_not_sharp_in_the_domain():
    hole = polygon([(0, 0), (0.5, -0.01), (0.5, 0.01)])
    assert sharp_angles(Domain.of(SQUARE, [hole])) == []


@pytest.mark.parametrize(
    ("outer", "holes", "place"),
    [
        (SQUARE, [circle((0.1, -0.5), 0.5)], r"\(0.1, -1\)"),
        (circle((0, 0), 1), [circle((0.5 * np.cos(1), 0.5 * np.sin(1)), 0.5)], r"\(0.540\d+, 0.841\d+\)"),
        (SQUARE, [circle((-0.3, 0.5), 0.3), circle((0.3, 0.5), 0.3)], r"\(.*, 0.5\)"),
        (SQUARE, [polygon([(0.5, -1), (0.9, -0.99), (0.5, -0.5)])], r"\(0.5, -1\)"),
    ],
)
def test_wedge_beside_a_contact_is_sharp(outer, holes, place):
    (warning,) = sharp_angles(Domain.of(outer, holes))
    assert re.search(place, warning)


@pytest.mark.parametrize("angle", [0, 0.37, 1.48, 3, 5.2])
def test_tangent_circles_make_wedges_of_no_angle(angle):
    inner = circle((0.5 * np.cos(angle), 0.5 * np.sin(angle)), 0.5)
    (warning,) = sharp_angles(Domain.of(circle((0, 0), 1), [inner]))
    assert "is 0 degrees" in warning


def test_wide_contact_is_not_sharp():
    assert sharp_angles(Domain.of(SQUARE, [polygon([(0.5, -1), (0.9, -0.5), (0.1, -0.5)])])) == []


NARROW = {
    "thin plate": (Domain.of(rectangle(0, 0, 1, 0.04)), 0.08, 0.04),
    "thin ring": (Domain.of(circle((0, 0), 1), [circle((0, 0), 0.95)]), 0.1, 0.05),
    "hole near a wall": (Domain.of(SQUARE, [circle((0.7, 0), 0.28)]), 0.1, 0.02),
    "hole near a hole": (Domain.of(SQUARE, [rectangle(-0.5, -0.5, -0.02, 0.5), circle((0.3, 0), 0.28)]), 0.1, 0.04),
    "slot of the domain": (
        Domain.of(polygon([(0, 0), (1, 0), (1, 1), (0.53, 1), (0.53, 2), (0.47, 2), (0.47, 1), (0, 1)])),
        0.09,
        0.06,
    ),
    "spacing larger than the domain": (Domain.of(SQUARE), 3, 2),
}


@pytest.mark.parametrize(("domain", "d", "width"), NARROW.values(), ids=NARROW)
def test_narrow_wall_is_named_with_its_width(domain, d, width):
    (warning,) = narrow_parts(FacingWalls(domain), uniform(d), None, None)
    words = warning.split()
    assert words[:3] == ["the", "domain", "is"]
    assert float(words[3]) == pytest.approx(width, rel=0.05)
    assert f"narrower than the spacing there ({d:.3g})" in warning


@pytest.mark.parametrize(("domain", "d", "width"), NARROW.values(), ids=NARROW)
def test_walls_wider_than_the_spacing_are_not_narrow(domain, d, width):
    assert narrow_parts(FacingWalls(domain), uniform(0.9 * width), None, None) == []


def test_short_edges_are_counted_and_the_shortest_is_named():
    domain = Domain.of(polygon([(0, 0), (1, 0), (1, 0.97), (0.96, 1), (0.02, 1), (0, 0.98)]))
    (warning,) = _refined(domain, uniform(0.1))
    assert "2 boundary edges are shorter than the spacing" in warning
    assert "(0.0283) at (0.02, 1)" in warning


def test_one_short_edge_is_not_a_plural():
    domain = Domain.of(polygon([(0, 0), (1, 0), (1, 0.97), (0.96, 1), (0, 1)]))
    (warning,) = _refined(domain, uniform(0.1))
    assert "1 boundary edge is shorter than the spacing, the shortest (0.05) at (1, 0.97)" in warning


@pytest.mark.parametrize(("step", "least", "told"), [(0.001, 0, 1), (0.02, 0, 0), (0.001, 0.09, 0)])
def test_edges_far_shorter_than_the_spacing_are_told_if_it_grows_from_them(step, least, told):
    outer = f"[[0, 0], [0.5, 0], [{0.5 + step}, 0], [1, 0], [1, 1], [0, 1]]"
    spacing = f"{{value: 0.1, growth: 0.3, minimum: {least}}}" if least else "{value: 0.1, growth: 0.3}"
    problem = prepare(load_case("a.yaml", text=f"domain: {{outer: {{polygon: {outer}}}}}\nspacing: {spacing}\n"))
    found = far_shorter_edges(problem.domain, problem.before_rules, problem.rules, None)
    text = f"1 boundary edge is shorter than the spacing, the shortest ({step:g}) at (0.5, 0): the mesh is finer around"
    assert found == told * [f"{text} them"]
    assert set(found) <= set(problem.warnings)


def test_tight_curve_is_named():
    domain = Domain.of(SQUARE, [circle((0, 0), 0.05)])
    (warning,) = refined_boundary(NONE, coarse_curves(domain, uniform(0.2)), RefiningEdges(0, 0, 0))
    assert "too coarse for the curve at" in warning
    assert "reduced to 0.0524" in warning


@harmless
def test_boundary_that_fits_the_spacing_is_not_mentioned(domain, spacing):
    if spacing(np.array([[1.0, 1.0]]))[0] == 0.08:
        return  # the slot's end is shorter than its spacing
    assert _refined(domain, spacing, coarse_curves(domain, spacing)) == []


@pytest.mark.parametrize(
    ("keys", "spacing", "told"),
    [
        ("units: mm", "3", "30 times the size of the domain (0.1): are its units those of the domain (units: mm made"),
        (
            "scale: 0.001",
            '"3 + x"',
            "at least 30 times the size of the domain (0.1): are its units those of the domain?",
        ),
        ("scale: 0.001", "{maximum: 3, growth: 0.2}", "30 times the size of the domain (0.1): are its units those of"),
        ("scale: 0.001", "{maximum: 3, near: {label: outer, size: 0.01}}", ""),
        ("scale: 0.001", "{maximum: 0.1, growth: 0.2}", ""),
        ("scale: 0.001", "0.1", ""),
    ],
)
def test_a_spacing_larger_than_the_domain_is_told_before_all_else(tmp_path, keys, spacing, told):
    (tmp_path / "a.wkt").write_text("POLYGON ((0 0, 100 0, 100 50, 0 50, 0 0))")
    (tmp_path / "a.yaml").write_text(f"domain: {{file: a.wkt, {keys}}}\nspacing: {spacing}\n")
    warnings = prepare(load_case(tmp_path / "a.yaml")).warnings
    assert [told in text for text in warnings if "times the size" in text] == [True] * bool(told)
    assert not told or told in warnings[0]


@pytest.mark.parametrize(
    ("share", "ratio", "told"),
    [
        (0.0, 1.0, None),  # a jump that is smaller than what is looked at
        (1e-4, 1.004, None),
        (1e-4, 3.0, "it is held to 0.4, finer on less than 0.1% of the area, at most 3 times"),
        (0.25, 3.0, "it is held to 0.4, finer on 25.0% of the area, at most 3 times"),
    ],
)
def test_a_limit_of_growth_that_changes_nothing_is_not_told(share, ratio, told):
    grading = LimitedSpacing(uniform(1), SteepestPlace((0.5, 0.5), 1.0, 4.5), share, ratio)
    texts = limited_growth(grading, None, None)
    assert texts == ([] if told is None else [f"the spacing grows by 4.5 per length at (0.5, 0.5), from 1: {told}"])


@pytest.mark.parametrize(
    ("rules", "width", "expected"),
    [
        (Rules(across=0.0), 0.06, "only boundary nodes fit"),
        (Rules(), 0.06, None),
        (Rules(), 0.04, "only boundary nodes fit; across: 1.5 in the spacing makes it finer there"),
        (Rules(across=2.0), 0.04, "only boundary nodes fit; across: 3 in the spacing makes it finer there"),
        (Rules(minimum=0.1), 0.04, "only boundary nodes fit"),
    ],
)
def test_what_is_left_of_filled_parts_is_told_where_triangles_are_poor_with_what_fills_it(rules, width, expected):
    domain = Domain.of(
        rectangle(-1, -1, 1, 1), [rectangle(-0.5, -0.5, 0.5, -width / 2), rectangle(-0.5, width / 2, 0.5, 0.5)]
    )
    found = narrow_parts(FacingWalls(domain), uniform(0.1), None, None, rules)
    assert [text.partition("): ")[2] for text in found] == ([] if expected is None else [expected])


def test_a_thin_cap_that_the_spacing_fits_has_no_warning():
    text = """
domain:
  outer: {rectangle: [0, 0, 4, 4]}
  regions: [{name: fibre, ring: {circle: {center: [-0.436, 2], radius: 0.5}}}]
spacing: {value: 0.17, across: 1}
"""
    assert prepare(load_case("cap.yaml", text=text)).warnings == ()
