"""Inputs that break meshers, through the command line: each gets a mesh, or an exit code and a message with the place.

Faulty geometry files are in test_bad_files.py, interrupts in test_interrupts.py.
"""

import errno
import io
import json
import math
import os
import re
import resource
import signal
import subprocess
import sys

import numpy as np
import pytest
from commands import command, contents, refused
from invariants import check_mesh

from bubblemesh.case import load_case
from bubblemesh.problem.problem import prepared
from bubblemesh.run import pipeline
from bubblemesh.run.pipeline import mesh_case

UNIT = {"rectangle": [0, 0, 1, 1]}
BOW = {"polygon": [[0.2, 0.2], [0.8, 0.8], [0.8, 0.2], [0.2, 0.8]]}
LOOP = {"path": [[0.2, 0.2], {"spline": {"through": [[0.8, 0.6], [0.8, 0.2], [0.2, 0.5]]}}]}
EIGHT = {
    "path": [
        [0.5, 0.5],
        {"arc": {"to": [0.5, 0.5], "center": [0.7, 0.5], "turn": "left"}},
        {"arc": {"to": [0.5, 0.5], "center": [0.3, 0.5], "turn": "left"}},
    ]
}


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    """An empty folder that is the present one."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def case(domain, spacing=0.2, **more):
    return json.dumps({"domain": domain, "spacing": spacing, "packing": {"effort": "fast"}} | more)


def circle(x, y, radius):
    return {"circle": {"center": [x, y], "radius": radius}}


def polygon(*points):
    return {"polygon": [list(point) for point in points]}


def with_hole(*holes, outer=UNIT):
    return {"outer": outer, "holes": list(holes)}


def with_region(ring):
    return {"outer": {"rectangle": [-9, -9, 9, 9]}, "regions": [{"name": "r", "ring": ring}]}


def meshed(here, text):
    """Report and mesh of a case that is accepted, whose warnings the command line tells."""
    (here / "case.yaml").write_text(text)
    result = mesh_case(load_case(here / "case.yaml"))
    code, out, message = command("check", "case.yaml", "-q")
    assert (code, out) == (0, "")
    told = [line.removeprefix("warning: ") for line in message.splitlines()]
    assert told == result.report["warnings"][: len(told)]  # those of the finished mesh come after
    return result.report, result.mesh


# Rings

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
    "cutting the domain": ([circle(0.5, 0.5, 0.5)], r"cut the domain in two at .*: give one case for each part"),
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


# The units of length, and what is near to something else

ALL_PARTS = {
    "outer": {"rectangle": [0, 0, 4, 4]},
    "holes": [circle(3.2, 3.2, 0.4)],
    "regions": [{"name": "a", "ring": {"rectangle": [0, 0, 1.5, 4]}}, {"name": "b", "ring": circle(2.6, 1.2, 0.8)}],
    "lines": [{"path": [[0.4, 0.4], [3.6, 2.3]]}, {"path": [[0.4, 3.6], [2.4, 0.5]]}],
    "points": [{"at": [2, 3.8]}],
}


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
        boundary = prepared(load_case("a.yaml", text=case(domain, d))).domain.boundary
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
    "near walls": (
        with_hole(circle(0.5, 0.22, 0.2)),
        r"the domain is 0\.02 wide at \(0\.50?\d*, 0\.0?2?\d*\), narrower",
    ),
    "near lines": (
        {"outer": UNIT, "lines": [{"path": [[0.2, 0.03], [0.8, 0.03]]}]},
        r"leaves a strip of 0\.03 at \(0\.\d+, 0(\.03)?\), narrower than the spacing there",
    ),
    "sharp corner": ({"outer": polygon((0, 0), (1, 0), (1, 0.05))}, r"the angle at \(0, 0\) is 2\.9 degrees"),
    "sharp lines": (
        {"outer": UNIT, "lines": [{"path": [[0.2, 0.5], [0.8, 0.5]]}, {"path": [[0.8, 0.53], [0.2, 0.5]]}]},
        r"the angle at \(0\.2, 0\.5\) is 2\.9 degrees",
    ),
    "short edge": (
        {"outer": polygon((0, 0), (0.5, 0), (0.5001, 0), (1, 0), (1, 1), (0, 1))},
        r"1 boundary edge is shorter than the spacing, the shortest \(0\.0001\) at \(0\.5, 0\)",
    ),
    "very short edge": ({"outer": polygon((0, 0), (1, 0), (1, 1e-10), (1, 1), (0, 1))}, r"the shortest \(1e-10\)"),
    "very small hole": (with_hole(circle(0.5, 0.5, 1e-12)), r"too coarse for the curve at \(0\.5, 0\.5\)"),
}


@pytest.mark.parametrize(("domain", "text"), WARNED.values(), ids=WARNED)
def test_what_cannot_be_meshed_well_is_meshed_with_a_warning(here, domain, text):
    report, mesh = meshed(here, case(domain))
    assert any(re.search(text, warning) for warning in report["warnings"]), report["warnings"]
    if not domain.get("lines"):
        check_mesh(mesh)


# Spacing

SQUARE = "domain: {{outer: {{rectangle: [0, 0, 1, 1]}}}}\nspacing: {}\n"
UNUSABLE = {
    "0*x": r"spacing: is 0 at \([01]\S*, [01]\S*\): it has to be positive and finite",
    "-1 - x": r"spacing: is -[12]\S* at \([01]\S*, [01]\S*\)",
    "x - 0.5": r"spacing: is -0\.\d+ at \([01]\S*, [01]\S*\)",
    "0/(x - x)": r"spacing: is nan at \([01]\S*, [01]\S*\)",
    "1/0": r"spacing: is inf at \([01]\S*, [01]\S*\)",
    "(-1 - x)**0.5": r"spacing: is nan at \([01]\S*, [01]\S*\)",
    "9**9**9**9": r"spacing: is inf at \([01]\S*, [01]\S*\)",
    "abs(x - 0.3) + 0*y": r"spacing: (is 0|falls to \S+) at \(0\.3\d*, 0\.\d+\)",
}


@pytest.mark.parametrize(("spacing", "text"), UNUSABLE.items())
def test_a_spacing_that_is_none_somewhere(here, spacing, text):
    assert re.search(text, refused(here, SQUARE.format(f'"{spacing}"'), 2))


EXPRESSIONS = {
    "-1": "must be greater than 0 (found -1)",
    "0": "must be greater than 0 (found 0)",
    ".nan": "must be a finite number (found nan)",
    ".inf": "must be a finite number (found inf)",
    "true": "must be a number, an expression in x and y, or a mapping",
    "1j": "column 1: only real numbers are allowed in an expression",
    "x.real": "column 1: a dot between names is not allowed",
    "__import__('os')": "column 1: unknown function '__import__'",
    "open('a', 'w')": "column 1: unknown function 'open'",
    "'''a'''": "column 1: only real numbers are allowed in an expression",
    "'[x]'": "column 1: a list is not allowed in an expression",
    "'lambda: 1'": "a lambda is not allowed",
    "max(*[1])": "max takes 2 or more arguments",
    "sqrt(x": "not an expression",
    "x" + "+x" * 500_000: "the expression has 1,000,001 characters: at most 10,000 are allowed",
    "(" * 4000 + "x" + ")" * 4000: "not an expression",
    "-" * 5000 + "x": "the expression is nested too deeply",
    "min(x," * 300 + "1" + ")" * 300: "not an expression",
}


@pytest.mark.parametrize(("spacing", "text"), EXPRESSIONS.items(), ids=[key[:20] for key in EXPRESSIONS])
def test_an_expression_that_is_not_allowed_is_refused_at_once(here, spacing, text):
    message = refused(here, SQUARE.format(spacing), 2)
    assert message.startswith("error: case.yaml:2: spacing: ")
    assert text in message
    assert len(message) < 500


@pytest.mark.parametrize(
    ("spacing", "limit", "needed"),
    [("0.01", 100, 11_900), ("1e-4 + x", 1000, None), ("1e-9", 2_000_000, 1.15e18), ("1e-300", 2_000_000, math.inf)],
)
def test_a_spacing_that_needs_too_many_nodes_is_refused_before_packing(here, spacing, limit, needed):
    message = refused(here, SQUARE.format(spacing) + f"limits: {{max_nodes: {limit}}}\n", 6)
    found = re.search(rf"limits.max_nodes: .* about (\S+) nodes, more than the limit of {limit}: coarsen", message)
    assert float(found.group(1)) > limit
    if needed is not None:
        assert float(found.group(1)) == pytest.approx(needed, rel=0.05)


def test_the_limit_counts_the_nodes_that_short_edges_ask_for(here):
    angles = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    ring = {"polygon": np.column_stack([np.cos(angles), np.sin(angles)]).tolist()}
    assert "max_nodes" in refused(here, case({"outer": ring}, 0.5, limits={"max_nodes": 300}), 6)


@pytest.mark.parametrize("ring", [UNIT, circle(0, 0, 1), polygon((0, 0), (1, 0), (0, 1))])
def test_a_spacing_larger_than_the_domain(here, ring):
    report, mesh = meshed(here, case({"outer": ring}, 100))
    check_mesh(mesh)
    assert report["nodes"] <= 8
    assert report["warnings"]


# The case file

BOMB = "\n".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9 if i else 'x' * 9)}]" for i in range(20))
YAML = {
    "domain: [1\n": (2, "case.yaml:2: not valid YAML", "check the indentation"),
    SQUARE.format(1) + "spacin: 1\n": (2, "case.yaml:3: spacin: unknown key", "did you mean 'spacing'"),
    SQUARE.format(1) + "spacing: 1\n": (2, "case.yaml:3: the key 'spacing' is given twice", "first in line 2"),
    SQUARE.format("!!python/object:os.system x"): (2, "case.yaml:2: the tag", "remove it"),
    SQUARE.format("&a [*a]"): (2, "case.yaml:2: the alias *a is inside its own anchor", "write the values out"),
    "[" * 10_000: (2, "case.yaml:1: nested more than 100 deep", "a case needs far less"),
    BOMB: (2, "more than 5,000,000 values", "use fewer"),
    SQUARE.format(1) + "packing: {efort: best}\n": (2, "case.yaml:3: packing.efort", "'effort'"),
    SQUARE.format(1) + "packing: {effort: most}\n": (2, "case.yaml:3: packing.effort", "best"),
    SQUARE.format(1) + "method: bpm\npacking: {effort: best}\n": (2, "case.yaml:4: packing.effort", "bpm"),
    SQUARE.format(1) + "method: multilvl\n": (2, "case.yaml:3: method", "multilevel"),
    SQUARE.format(1) + 'output: {directory: "a\\0b"}\n': (2, "case.yaml:3: a null character in a text", "remove it"),
    "base: nowhere.yaml\n": (5, "case.yaml:1: base: nowhere.yaml: the case file cannot be read", "No such file"),
    "base: case.yaml\n": (2, "case.yaml:1: base: case.yaml extends itself", "remove one"),
    "": (2, "case.yaml:1: the file is empty", "give at least domain and spacing"),
}  # fmt: skip


@pytest.mark.parametrize(("text", "answer"), YAML.items(), ids=[key[:30] for key in YAML])
def test_a_case_file_that_is_none(here, text, answer):
    code, place, advice = answer
    message = refused(here, text, code)
    assert place in message
    assert advice in message
    assert len(message) < 1500


@pytest.mark.parametrize("name", [".", "nowhere.yaml", "", "a" * 300, "case.yaml/x"])
def test_a_case_that_cannot_be_read(here, name):
    (here / "case.yaml").write_text(SQUARE.format(1))
    code, out, message = command("run", name)
    assert (code, out) == (5, "")
    assert message.startswith("error: ")
    assert "the case file cannot be read: " in message


def test_an_endless_case_is_not_read_to_its_end(here, monkeypatch):
    from bubblemesh.case import yaml as document

    monkeypatch.setattr(document, "MOST_BYTES", 1000)
    code, _, message = command("run", "/dev/zero")
    assert code == 6
    assert "/dev/zero: has more than the 0 MB that are read" in message


# Output

SMALL = SQUARE.format(0.5) + "output: {formats: [msh, xdmf]}\npacking: {effort: fast}\n"


@pytest.mark.parametrize(
    ("output", "text"),
    [
        ("case.yaml/out/", "cannot write case.yaml/out: Not a directory"),
        ("case.yaml/a.msh", "cannot write into case.yaml: it is not a folder"),
        ("old", "cannot write into old: it is not a folder"),
        ("link/", "cannot write into link: it is a symbolic link that leads nowhere"),
        ("round/", "cannot write into round: it is a symbolic link that leads nowhere"),
        ("full/", "cannot write full/case.msh: something that is not a file has this name"),
        ("a" * 300 + "/", "File name too long"),
        ("a" * 300 + ".msh", "File name too long"),
        ("/proc/new/", "cannot write /proc"),
    ],
)
def test_a_place_that_cannot_be_written(here, output, text):
    (here / "case.yaml").write_text(SMALL)
    (here / "old").write_text("old")
    (here / "link").symlink_to("nowhere/at/all")
    (here / "round").symlink_to("round")
    (here / "full/case.msh").mkdir(parents=True)
    before = contents(here)
    code, out, message = command("run", "case.yaml", "-q", "-o", output)
    assert (code, out) == (5, "")
    assert text in message
    assert contents(here) == before


def test_a_missing_folder_is_made(here):
    (here / "case.yaml").write_text(SMALL)
    assert command("run", "case.yaml", "-q", "-o", "a/b/c/") == (0, "", "")
    assert (here / "a/b/c/case.msh").is_file()


class Faults:
    """Makes the file operation of a given number below a folder fail."""

    def __init__(self, folder, number, error):
        self.folder, self.number, self.error, self.count, self.failed = str(folder), number, error, 0, None

    def over(self, function, name):
        def wrapped(*args, **kwargs):
            path = str(args[0]) if args else ""
            writes = name != "open" or any(letter in str(args[1:2]) + kwargs.get("mode", "") for letter in "wxa+")
            there = name == "mkdir" and os.path.isdir(path)  # noqa: PTH112 - which os.mkdir is asked about again
            if path.startswith(self.folder) and writes and not there:
                self.count += 1
                if self.count == self.number:
                    self.failed = name
                    raise OSError(self.error, os.strerror(self.error), path)
            return function(*args, **kwargs)

        return wrapped


@pytest.mark.parametrize("error", [errno.EACCES, errno.ENOSPC])
@pytest.mark.parametrize("old", [True, False])
def test_whatever_fails_while_writing_old_files_stay_and_no_half_ones_are_left(here, monkeypatch, error, old):
    (here / "case.yaml").write_text(SMALL)
    result = mesh_case(load_case(here / "case.yaml"))
    monkeypatch.setattr(pipeline, "mesh_case", lambda *args: result)
    if old:
        assert command("run", "case.yaml", "-q", "-o", "out/")[0] == 0
    before = contents(here)
    operations = []
    for number in range(1, 100):
        faults = Faults(here / "out", number, error)
        with monkeypatch.context() as patched:
            for module, name in ((os, "mkdir"), (os, "replace"), (io, "open"), (os, "link")):
                patched.setattr(module, name, faults.over(getattr(module, name), name))
            code, _, message = command("run", "case.yaml", "-q", "-o", str(here / "out"))
        operations.append(faults.failed)
        if faults.failed in (None, "link"):  # a file system without links
            assert code == 0
            assert before.keys() <= contents(here).keys()
            if faults.failed is None:
                break
        else:
            assert code == 5, (faults.failed, message)
            assert os.strerror(error) in message
            assert "out" in message
            if "link" not in operations:
                assert contents(here) == before
            assert not [name for name in contents(here) if "bubblemesh-" in name]
    assert operations[-1] is None
    assert {"mkdir", "open", "replace"} <= set(operations)
    assert ("link" in operations) == old


@pytest.mark.parametrize("arguments", [["run", "case.yaml", "-q", "-o", "out"], ["init", "new.yaml"]])
def test_a_disk_that_is_full(here, arguments):
    (here / "case.yaml").write_text(SMALL)
    assert command("run", "case.yaml", "-q", "-o", "out")[0] == 0
    before = contents(here)

    def no_room():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (500, 500))

    process = subprocess.run(
        [sys.executable, "-m", "bubblemesh", *arguments],
        capture_output=True,
        text=True,
        preexec_fn=no_room,
        check=False,
    )
    assert process.returncode == 5, process.stderr
    assert "Traceback" not in process.stderr
    assert process.stderr.startswith("error: ")
    assert contents(here) == before


@pytest.mark.parametrize("formats", ["[msh, msh]", "[inp, inp-strain]", "[msh, vtu, msh]"])
def test_the_same_output_named_twice(here, formats):
    (here / "case.yaml").write_text(SMALL.replace("[msh, xdmf]", formats))
    before = contents(here)
    code, _, message = command("run", "case.yaml")
    assert code == 5
    assert "the same file: name" in message
    assert contents(here) == before
