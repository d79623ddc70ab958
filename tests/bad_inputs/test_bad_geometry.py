"""Geometry that breaks meshers, through the whole program: an error with its place, or a sound mesh."""

import re

import numpy as np
import pytest
from bad_cases import UNIT, case, circle, meshed, polygon
from commands import refused
from invariants import check_mesh

from bubblemesh.case import load_case
from bubblemesh.problem.prepare import prepare

BOW = {"polygon": [[0.2, 0.2], [0.8, 0.8], [0.8, 0.2], [0.2, 0.8]]}


LOOP = {"path": [[0.2, 0.2], {"spline": {"through": [[0.8, 0.6], [0.8, 0.2], [0.2, 0.5]]}}]}


EIGHT = {
    "path": [
        [0.5, 0.5],
        {"arc": {"to": [0.5, 0.5], "center": [0.7, 0.5], "turn": "left"}},
        {"arc": {"to": [0.5, 0.5], "center": [0.3, 0.5], "turn": "left"}},
    ]
}


def with_hole(*holes, outer=UNIT):
    return {"outer": outer, "holes": list(holes)}


def with_region(ring):
    return {"outer": {"rectangle": [-9, -9, 9, 9]}, "regions": [{"name": "r", "ring": ring}]}


WHERE = {
    "outer": (lambda ring: {"outer": ring}, "the outer ring"),
    "hole": (with_hole, "hole 1"),
    "region": (with_region, "the ring of region 'r'"),
}


@pytest.mark.parametrize("where", WHERE)
@pytest.mark.parametrize(
    ("ring", "at"),
    [
        (BOW, r"\(0\.5, 0\.5\)"),
        (LOOP, r"\(0\.\d+, 0\.\d+\)"),
        (EIGHT, r"\(0\.5, 0\.5\)"),
        (polygon((0.2, 0.2), (0.6, 0.2), (0.9, 0.2), (0.6, 0.2), (0.6, 0.6), (0.2, 0.6)), r"\(0\.[69], 0\.2\)"),
        (polygon((0.2, 0.2), (0.8, 0.2), (0.8, 0.8), (0.5, 0.2), (0.2, 0.8)), r"\(0\.5, 0\.2\)"),
    ],
    ids=["bow tie", "spline", "figure of eight", "spike", "vertex on a side"],
)
def test_a_ring_that_crosses_or_touches_itself(here, where, ring, at):
    domain, name = WHERE[where]
    message = refused(here, case(domain(ring)), 3)
    assert re.search(rf"domain: {name} crosses or touches itself at {at}: move its points so that it does not", message)


@pytest.mark.parametrize("where", WHERE)
@pytest.mark.parametrize(
    ("ring", "text"),
    [
        (polygon(), "a polygon has no points: give at least three"),
        (polygon((0.1, 0.2)), r"at \(0\.1, 0\.2\) has fewer than three different points: give at least three"),
        (polygon((0.1, 0.2), (0.3, 0.4)), r"\(0\.1, 0\.2\) has fewer than three different points"),
        (polygon((0.1, 0.2), (0.3, 0.4), (0.1, 0.2)), r"\(0\.1, 0\.2\) has fewer than three different points"),
        (polygon(*[(0.1, 0.2)] * 3), r"\(0\.1, 0\.2\) has fewer than three different points"),
        ({"rectangle": [0.1, 0.2, 0.1, 0.7]}, r"\(0\.1, 0\.2\) has fewer than three different points"),
        ({"path": [[0.1, 0.2], [0.3, 0.4]]}, r"\(0\.1, 0\.2\) has fewer than three different points"),
        (
            polygon((0.1, 0.1), (0.2, 0.2), (0.3, 0.3)),
            r"at \(0\.1, 0\.1\) encloses no area: its points lie on one line",
        ),
        (circle(0.5, 0.5, 1e-17), r"at \(0\.5, 0\.5\) is as small as the rounding of its coordinates: move it"),
    ],
)
def test_a_ring_that_encloses_nothing(here, where, ring, text):
    message = refused(here, case(WHERE[where][0](ring)), 3)
    assert re.search(rf"domain: (the outer ring|hole 1|region 'r'|the ring of region 'r').* {text}", message)


@pytest.mark.parametrize(
    ("pieces", "text"),
    [
        ([[1, 0], {"arc": {"to": [0, 1], "center": [0.2, 0.7], "turn": "left"}}], r"is 1.06301 from its center"),
        ([[1, 0], {"arc": {"to": [0, 1], "center": [1e30, 1e30], "turn": "left"}}], r"radius of 1.41e\+30, too large"),
        ([[1, 0], {"arc": {"to": [1, 0], "center": [1, 0], "turn": "left"}}], r"its center and both ends in one point"),
        ([[1, 0], {"spline": {"through": [[1, 0]]}}], r"spline at \(1, 0\) has too few different points"),
    ],
)
@pytest.mark.parametrize("where", [*WHERE, "line"])
def test_a_curve_that_is_none(here, where, pieces, text):
    path = {"path": [[0, 0], *pieces]}
    domain = {"outer": {"rectangle": [-9, -9, 9, 9]}, "lines": [path]} if where == "line" else WHERE[where][0](path)
    message = refused(here, case(domain), 3)
    assert re.search(rf"domain: (the outer ring|hole 1|region 'r'|line 1): .*{text}", message)


HOLES = {
    "outside": ([circle(0.5, 0.5, 0.2), circle(3, 3, 0.5)], r"hole 2 at \(3\.5, 3\) lies outside the outer ring: move"),
    "across": ([circle(1, 0.5, 0.2)], r"hole 1 crosses the outer ring at \(1, 0\.\d+\): move it, or draw"),
    "around": ([circle(0.5, 0.5, 3)], r"hole 1 at \(3\.5, 0\.5\) encloses the outer ring: make it smaller"),
    "overlapping": ([circle(0.4, 0.5, 0.2), circle(0.5, 0.5, 0.2)], r"hole 1 and hole 2 overlap at \(0\.45, .*: join"),
    "nested": ([circle(0.5, 0.5, 0.2), circle(0.5, 0.5, 0.1)], r"hole 2 lies inside hole 1 at \(0\.6, 0\.5\): remove"),
    "twice": ([{"rectangle": [0.2, 0.2, 0.4, 0.4]}] * 2, r"hole 2 lies inside hole 1 at \(0\.2, 0\.2\): remove"),
    "sharing an edge": ([{"rectangle": [0.2, 0, 0.4, 0.4]}], r"hole 1 shares an edge with .* at \(0\.2, 0\): draw"),
    "sharing an edge of a hole": (
        [{"rectangle": [0.2, 0.2, 0.4, 0.4]}, {"rectangle": [0.4, 0.3, 0.6, 0.6]}],
        r"hole 1 and hole 2 share an edge at \(0\.4, 0\.\d\): join",
    ),
    "being the outer ring": ([UNIT], r"hole 1 shares an edge with the outer ring at \(0, 0\)"),
    "cutting the domain": ([circle(0.5, 0.5, 0.5)], r"cut the domain in two at .*: give each part an outer ring"),
}


@pytest.mark.parametrize(("holes", "text"), HOLES.values(), ids=HOLES)
def test_holes_that_do_not_fit(here, holes, text):
    assert re.search(f"domain: .*{text}", refused(here, case(with_hole(*holes)), 3))


TOUCHING = {
    "vertex on a side": ([polygon((0.5, 0), (0.7, 0.3), (0.5, 0.5), (0.3, 0.3))], (0.5, 0), 1e-15),
    "vertex at a vertex": ([polygon((0, 0), (0.5, 0.2), (0.2, 0.5))], (0, 0), 1e-15),
    "circle": ([circle(0.5, 0.3, 0.3)], (0.5, 0), 1e-8),
    "two circles": ([circle(0.3, 0.5, 0.2), circle(0.7, 0.5, 0.2)], (0.5, 0.5), 1e-8),
}


@pytest.mark.long
@pytest.mark.parametrize(("holes", "at", "tolerance"), TOUCHING.values(), ids=TOUCHING)
def test_a_hole_may_touch_in_one_point_which_is_one_node(here, holes, at, tolerance):
    _, mesh = meshed(here, case(with_hole(*holes)))
    check_mesh(mesh)
    distance = np.hypot(*(mesh.points - at).T)
    assert (distance <= tolerance).sum() == (distance < 1e-3).sum() == 1


DOUBLE = {
    "ring": {"outer": polygon((0, 0), (1, 0), (1, 0), (1, 1), (0, 1), (0, 0))},
    "path": {"outer": {"path": [[0, 0], [1, 0], [1, 0], [1, 1], [0, 1], [0, 0]]}},
    "rounded": {"outer": polygon((0, 0), (1, 1e-14), (1, 0), (1, 1), (0, 1))},
    "hole": with_hole(polygon((1, 0), (1, 0), (1.5, 0), (1, 0.5)), outer={"rectangle": [0, -1, 2, 1]}),
    "region": with_region(polygon((0, 0), (1, 0), (1, 0), (1, 1))),
    "line": {"outer": {"rectangle": [0, -1, 2, 1]}, "lines": [{"path": [[0.5, 0.5], [1, 0], [1, 0], [1.5, 0.5]]}]},
}


@pytest.mark.long
@pytest.mark.parametrize("domain", DOUBLE.values(), ids=DOUBLE)
def test_duplicate_points_are_merged_with_a_note(here, domain):
    report, mesh = meshed(here, case(domain, 0.5))
    assert "duplicate point (1, 0) merged" in report["warnings"]
    assert (np.hypot(*(mesh.points - [1, 0]).T) < 1e-3).sum() == 1


def test_many_duplicate_points_are_told_at_once(here):
    points = [(x / 10, 0) for x in range(11) for _ in range(2)]
    report, _ = meshed(here, case({"outer": polygon(*points, (1, 1), (0, 1))}))
    assert report["warnings"][0] == "11 duplicate points merged, the first at (0, 0)"


@pytest.mark.parametrize(
    "domain",
    [
        with_hole(polygon((0.2, 0.2), (0.4, 0.2), (0.4, 0.4)), outer=polygon((0, 1), (1, 1), (1, 0), (0, 0))),
        with_region(polygon((0, 0), (0, 5), (5, 5), (5, 0))),
    ],
)
def test_rings_may_turn_either_way(here, domain):
    def turned(value):
        if isinstance(value, dict):
            return {key: part[::-1] if key == "polygon" else turned(part) for key, part in value.items()}
        return [turned(part) for part in value] if isinstance(value, list) else value

    areas = [meshed(here, case(one, 1.0))[0]["area"] for one in (domain, turned(domain))]
    assert areas[0] == pytest.approx(areas[1], rel=1e-12)


ONE = "outer: {rectangle: [0, 0, 1, 1]}"


@pytest.mark.parametrize("number", [".nan", ".inf", "-.inf", "1e400", "1e71"])
@pytest.mark.parametrize(
    ("key", "text"),
    [
        ("domain.outer.rectangle.2", "outer: {rectangle: [0, 0, N, 1]}"),
        ("domain.outer.polygon.1.0", "outer: {polygon: [[0, 0], [N, 0], [1, 1]]}"),
        ("domain.outer.circle.radius", "outer: {circle: {center: [0, 0], radius: N}}"),
        ("domain.outer.ellipse.center.1", "outer: {ellipse: {center: [0, N], radii: [1, 2]}}"),
        ("domain.outer.path.1.arc.to.0", "outer: {path: [[0, 0], {arc: {to: [N, 0], center: [0, 0], turn: left}}]}"),
        ("domain.outer.path.1.spline.through.0.1", "outer: {path: [[0, 0], {spline: {through: [[1, N]]}}]}"),
        ("domain.holes.0.circle.center.0", ONE + ", holes: [{circle: {center: [N, 0], radius: 1}}]"),
        ("domain.regions.0.ring.rectangle.3", ONE + ", regions: [{name: r, ring: {rectangle: [0, 0, 1, N]}}]"),
        ("domain.lines.0.path.1.1", ONE + ", lines: [{path: [[0, 0], [1, N]]}]"),
        ("domain.points.0.at.0", ONE + ", points: [{at: [N, 0]}]"),
        ("domain.scale", "file: a.csv, scale: N"),
    ],
)  # fmt: skip
def test_a_number_that_is_no_coordinate(here, key, text, number):
    message = refused(here, f"spacing: 0.2\ndomain: {{{text.replace('N', number)}}}\n", 2)
    assert message.startswith(f"error: case.yaml:2: {key}: must be")
    assert message.count("\n") <= 2


ALL_PARTS = {
    "outer": {"rectangle": [0, 0, 4, 4]},
    "holes": [circle(3.2, 3.2, 0.4)],
    "regions": [{"name": "a", "ring": {"rectangle": [0, 0, 1.5, 4]}}, {"name": "b", "ring": circle(2.6, 1.2, 0.8)}],
    "lines": [{"path": [[0.4, 0.4], [3.6, 2.3]]}, {"path": [[0.4, 3.6], [2.4, 0.5]]}],
    "points": [{"at": [2, 3.8]}],
}


@pytest.mark.long
@pytest.mark.parametrize("scale", [1e15, 1e-12])
@pytest.mark.parametrize("offset", [0, 1e5, -1e8])
def test_regions_and_lines_meet_at_any_scale_and_far_from_the_origin(here, scale, offset):
    def moved(value, key=""):
        if isinstance(value, dict):
            return {name: moved(part, name) for name, part in value.items()}
        if isinstance(value, list):
            return [moved(part, key) for part in value]
        return value if isinstance(value, str) else scale * (value + (0 if key == "radius" else offset))

    made = {}
    for name, domain, d in (("plain", ALL_PARTS, 0.5), ("moved", moved(ALL_PARTS), 0.5 * scale)):
        boundary = prepare(load_case("a.yaml", text=case(domain, d))).domain.boundary
        made[name] = boundary.labels, boundary.left.tolist(), boundary.right.tolist(), len(boundary.corners)
    assert made["plain"] == made["moved"]
    _, mesh = meshed(here, case(moved(ALL_PARTS), scale))
    assert mesh.regions == ("domain", "a", "b")


def test_a_domain_whose_coordinates_have_no_digits_left(here):
    far = {"outer": {"rectangle": [1e11, 0, 1e11 + 1, 1]}, "lines": [{"path": [[1e11, 0.5], [1e11 + 0.5, 0.7]]}]}
    message = refused(here, case(far), 3)
    assert "so far from the origin, at (100000000000, 0), that the rounding" in message
    assert "move it nearer to the origin" in message


WARNED = {
    "near lines": (
        {"outer": UNIT, "lines": [{"path": [[0.2, 0.03], [0.8, 0.03]]}]},
        r"for narrow parts: the spacing is [\d.]+ times finer at",
    ),
    "sharp corner": ({"outer": polygon((0, 0), (1, 0), (1, 0.05))}, r"the angle at \(0, 0\) is 2\.9 degrees"),
    "sharp lines": (
        {"outer": UNIT, "lines": [{"path": [[0.2, 0.5], [0.8, 0.5]]}, {"path": [[0.8, 0.53], [0.2, 0.5]]}]},
        r"the angle at \(0\.2, 0\.5\) is 2\.9 degrees",
    ),
    "short edge": (
        {"outer": polygon((0, 0), (0.5, 0), (0.5001, 0), (1, 0), (1, 1), (0, 1))},
        r"for 1 boundary edge shorter than the spacing: .* finer at \(0\.500",
    ),
    "very short edge": (
        {"outer": polygon((0, 0), (1, 0), (1, 1e-10), (1, 1), (0, 1))},
        r"for 1 boundary edge shorter than the spacing: .* finer at \(1, 0\)",
    ),
    "very small hole": (
        with_hole(circle(0.5, 0.5, 1e-12)),
        r"for tight curves: the spacing is .* finer at \(0\.5, 0\.5\)",
    ),
}


@pytest.mark.long
@pytest.mark.parametrize(("domain", "text"), WARNED.values(), ids=WARNED)
def test_what_cannot_be_meshed_well_is_meshed_with_a_warning(here, domain, text):
    report, mesh = meshed(here, case(domain))
    assert any(re.search(text, warning) for warning in report["warnings"]), report["warnings"]
    if not domain.get("lines"):
        check_mesh(mesh)
