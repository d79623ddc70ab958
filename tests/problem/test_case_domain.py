"""Errors of the geometry tell the key, and so the line, of what they are about."""

import pytest

from bubblemesh.case import load_case
from bubblemesh.errors import BubblemeshError, CaseError, located
from bubblemesh.problem.prepare import prepare

CASE = """\
spacing: 0.1
domain:
  outer:
    rectangle: [0, 0, 4, 2]
  holes:
    - {circle: {center: [1, 1], radius: 0.2}}
    - {circle: {center: [3, 1], radius: 0.2}}
  regions:
    - {name: fine, ring: {rectangle: [1.5, 0.5, 2, 1.5]}}
    - {name: core, ring: {rectangle: [2.1, 0.5, 2.5, 1.5]}}
  lines:
    - {path: [[0.2, 0.2], [0.4, 0.2]]}
    - {path: [[0.2, 0.4], [0.4, 0.4]]}
  points:
    - {at: [0.2, 1.6]}
    - {at: [0.4, 1.6], label: well}
  periodic:
    - [left, right]
"""
PLAIN = CASE.partition("  periodic")[0]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("rectangle: [0, 0, 4, 2]", "polygon: [[0, 0], [4, 2], [4, 0], [0, 2]]", "a.yaml:3: domain: the outer ring c"),
        ("[3, 1]", "[9, 1]", "a.yaml:7: domain: hole 2 at (9.2, 1) lies outside"),
        ("[3, 1]", "[1.1, 1]", "a.yaml:7: domain: hole 1 and hole 2 overlap"),
        ("{circle: {center: [3, 1], radius: 0.2}}", "{polygon: []}", "a.yaml:7: domain: hole 2: a polygon has no"),
        ("{circle: {center: [3, 1], radius: 0.2}}", "{file: no.csv}", "a.yaml:7: hole 2: no.csv: the file cannot"),
        ("[2.1, 0.5, 2.5, 1.5]", "[7, 0, 8, 1]", "a.yaml:10: domain: region 'core' at (7, 0) lies outside"),
        ("[2.1, 0.5, 2.5, 1.5]", "[2, 1, 2, 1]", "a.yaml:10: domain: region 'core': the ring at (2, 1) has fewer"),
        ("[0.4, 0.2]]", "[0.2, 0.2]]", "a.yaml:12: domain: line 1: the line at (0.2, 0.2) has no length"),
        ("[0.2, 0.2], [0.4", "[7, 0.2], [8", "a.yaml:12: domain: the line 'line-1' at (7.5, 0.2) lies outside"),
        ("[0.2, 0.4], [0.4, 0.4]", "[0, 1], [0, 2]", "a.yaml:13: domain: the line 'line-2' at (0, 1.5) lies on"),
        ("[0.2, 1.6]", "[0.2, 7]", "a.yaml:15: domain: the point 'point-1' at (0.2, 7) lies outside the domain"),
        ("[0.4, 1.6]", "[3, 1]", "a.yaml:16: domain: the point 'well' at (3, 1) lies outside the domain"),
        ("[0.4, 1.6]", "[0.2, 1.6]", "a.yaml:16: domain: the points 'point-1' and 'well' are both at (0.2, 1.6)"),
        (
            "[0.4, 1.6]",
            "[0.2, 1.60000001]",
            "a.yaml:16: domain: the vertices at (0.2, 1.6) and (0.2, 1.60000001) are 1e-08 ap",
        ),
        (
            "[0.4, 1.6]",
            "[0.4, 1e-8]",
            "a.yaml:16: domain: the vertex at (0.4, 0.00000001) is 1e-08 aw",
        ),
        (
            "[0.2, 0.4], [0.4",
            "[1, 1e-8], [4",
            "a.yaml:13: domain: the vertex at (1, 0.00000001) is 1e-08 aw",
        ),
        (
            "[0.2, 0.4], [0.4, 0.4]",
            "[2.3, 1.69999999], {arc: {to: [1.7, 1.69999999], center: [2, 1.69999999], turn: left}}",
            "a.yaml:13: domain: two curves pass each other at (2, 2) at a distance of 1e-08, next to each other",
        ),
    ],
)
def test_errors_of_the_geometry_tell_the_line(old, new, message):
    assert old in PLAIN
    case = load_case("a.yaml", text=PLAIN.replace(old, new))
    with pytest.raises(BubblemeshError) as caught, located("a.yaml", case.origin):
        prepare(case)
    assert str(caught.value).startswith(message)


def test_periodic_sides_that_are_not_there_tell_the_line():
    case = load_case("a.yaml", text=CASE)
    problem = r"^a\.yaml:17: domain: periodic: there is no side 'left'"
    with pytest.raises(BubblemeshError, match=problem), located("a.yaml", case.origin):
        prepare(case)


def test_two_regions_of_one_name_lead_to_a_ring_of_several():
    rings = [f"{{name: fibre, ring: {{circle: {{center: [{x}, 0.5], radius: 0.2}}}}}}" for x in (0, 1)]
    text = f"domain: {{outer: {{rectangle: [0, 0, 1, 1]}}, regions: [{', '.join(rings)}]}}\nspacing: 0.1"
    with pytest.raises(CaseError, match=r"make several rings one region by ring: \{union: \[\.\.\.\]\} or repeat"):
        load_case("a.yaml", text=text)
