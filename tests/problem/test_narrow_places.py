"""Narrow parts of a domain: no vertex faces a long edge across one, and what would take too many nodes is left out."""

import json
import math
import random
import re

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.affinity import translate

from bubblemesh.case import load_case
from bubblemesh.errors import LimitError
from bubblemesh.problem.prepare import prepare
from bubblemesh.run.pipeline import mesh_case

LONGEST = 2.5  # edge across a narrow part, in terms of its distance


def case_of(domain, spacing, **more):
    return load_case("a.yaml", text=json.dumps({"domain": domain, "spacing": spacing, **more}))


def box(x0, y0, x1, y1):
    return {"rectangle": [x0, y0, x1, y1]}


def strip_between_holes(gap):
    return {"outer": box(0, 0, 2, 1), "holes": [box(0.5, 0.2, 1.5, 0.5), box(0.5, 0.5 + gap, 1.5, 0.8)]}


def polygons_near_walls(seed):
    """A plate with polygonal holes, each of which nearly touches another one or the rim."""
    random_ = random.Random(seed)
    area = shapely.box(0, 0, 3, 2)
    for _ in range(random_.randint(1, 6)):
        corners, turn, radius = random_.randint(3, 7), random_.uniform(0, 7), random_.uniform(0.1, 0.5)
        x, y = random_.uniform(0.2, 2.8), random_.uniform(0.2, 1.8)
        angles = [turn + 2 * math.pi * k / corners for k in range(corners)]
        hole = shapely.Polygon([(x + radius * math.cos(a), y + radius * math.sin(a)) for a in angles])
        if area.contains(hole):
            (ax, ay), (bx, by) = shapely.shortest_line(hole, area.boundary).coords
            way = max(1 - 10 ** random_.uniform(-3, -0.7) / math.hypot(bx - ax, by - ay), 0)
            hole = translate(hole, way * (bx - ax), way * (by - ay))
            if area.contains(hole) and hole.distance(area.boundary) > 1e-4:
                area -= hole
    holes = [{"polygon": [list(point) for point in hole.coords[:-1]]} for hole in area.interiors]
    return {"outer": box(0, 0, 3, 2), "holes": holes}


def faced_edges(mesh, domain):
    """Length over distance of each boundary edge that a boundary node of another side faces, past any common corner."""
    boundary = domain.boundary
    piece = domain.nearest(mesh.facet_middles).piece.tolist()
    corners = [{start, end} - {-1} for start, end in zip(boundary.start.tolist(), boundary.end.tolist(), strict=True)]
    facets = {frozenset(ends): k for k, ends in enumerate(mesh.facets.tolist())}
    at = {}
    for k, ends in enumerate(mesh.facets.tolist()):
        for node in ends:
            at.setdefault(node, set()).add(piece[k])
    for triangle in mesh.triangles.tolist():
        for node in triangle:
            i, j = (other for other in triangle if other != node)
            facet = facets.get(frozenset((i, j)))
            if node not in at or facet is None:
                continue
            mine = piece[facet]
            if all(other != mine and not corners[other] & corners[mine] for other in at[node]):
                edge = shapely.LineString(mesh.points[[i, j]])
                yield edge.length / edge.distance(shapely.Point(mesh.points[node]))


@pytest.mark.long
@settings(max_examples=12, deadline=None)
@given(st.integers(0, 100_000), st.sampled_from([0.15, 0.3, 0.5]))
def test_no_vertex_faces_a_long_edge_across_a_narrow_part(seed, spacing):
    case = case_of(polygons_near_walls(seed), spacing, packing={"effort": "fast"})
    mesh = mesh_case(case).mesh
    assert max(faced_edges(mesh, prepare(case).domain), default=0) < LONGEST


def test_without_the_rule_a_vertex_does():
    mesh = mesh_case(case_of(strip_between_holes(0.01), {"value": 0.2, "across": 0})).mesh
    domain = prepare(case_of(strip_between_holes(0.01), 0.2)).domain
    assert max(faced_edges(mesh, domain)) > 10


def test_a_domain_without_narrow_parts_keeps_its_spacing():
    problems = [prepare(case_of(strip_between_holes(0.2), spacing)) for spacing in (0.1, {"value": 0.1, "across": 0})]
    assert all(problem.packing_spacing is problem.spacing for problem in problems)
    assert all(problem.warnings == () for problem in problems)


def test_a_narrow_part_is_as_fine_as_it_is_wide():
    problem = prepare(case_of(strip_between_holes(0.05), 0.1))
    d = problem.packing_spacing(np.array([[1.0, 0.525], [1.0, 0.1], [0.2, 0.525]]))
    assert d[0] == pytest.approx(0.05, rel=0.1)
    assert d[1:].tolist() == pytest.approx([0.1, 0.1])
    assert problem.spacing(np.array([[1.0, 0.525]])) == 0.1  # what the case asks for stays


@pytest.mark.parametrize("gap", [1e-4, 1e-8])
def test_narrow_parts_that_take_too_many_nodes_are_left_out_and_told(gap):
    problem = prepare(case_of(strip_between_holes(gap), 0.1))
    assert problem.expected_nodes < 4 * problem.survey.ideal_nodes + 1000
    (warning,) = problem.warnings
    assert warning.startswith(f"the domain is {gap:.3g} wide at (")
    assert warning.endswith("more would take many times the nodes: across: 1 in the spacing forces them")


def test_what_a_case_asks_for_is_refused_if_it_takes_too_many_nodes():
    with pytest.raises(LimitError, match=r"limits.max_nodes: spacing.across asks for more"):
        prepare(case_of(strip_between_holes(1e-8), {"value": 0.1, "across": 1}, limits={"max_nodes": 10_000}))


def test_a_limit_that_was_enough_without_stays_enough():
    plain = case_of(strip_between_holes(0.004), {"value": 0.1, "across": 0})
    limits = {"max_nodes": int(1.1 * prepare(plain).expected_nodes)}
    problem = prepare(case_of(strip_between_holes(0.004), 0.1, limits=limits))
    assert problem.expected_nodes < limits["max_nodes"]


@pytest.mark.long
@pytest.mark.parametrize("nodes", [40, 300, 2000])
def test_a_number_of_nodes_stays_within_reach(nodes):
    problem = prepare(case_of(strip_between_holes(0.004), {"value": 0.1, "nodes": nodes}))
    assert problem.expected_nodes == pytest.approx(nodes, rel=0.02)


@pytest.mark.parametrize("minimum", [0.02, 0.1])
def test_the_minimum_holds_in_narrow_parts(minimum):
    problem = prepare(case_of(strip_between_holes(0.01), {"value": 0.1, "minimum": minimum}))
    assert problem.packing_spacing(np.array([[1.0, 0.505]]))[0] == pytest.approx(minimum, rel=0.05)


def test_detail_that_takes_many_nodes_is_told_once_with_the_keys_that_help():
    problem = prepare(case_of(strip_between_holes(0.02), 0.4))
    (warning,) = problem.warnings
    assert " times those of the spacing, for 4 boundary edges shorter than the spacing and narrow parts" in warning
    assert warning.endswith("(across: 0 in the spacing leaves narrow parts as they are)")
    more = prepare(case_of(strip_between_holes(0.02), {"value": 0.4, "across": 0})).expected_nodes
    assert more < problem.expected_nodes / 2


def strip_beside_a_jump(gap):
    """Regions with a gap between them, within a finer one: the spacing jumps around it."""
    fine = {"name": "fine", "ring": box(2, 2, 8, 8), "spacing": 0.4}
    top, bottom = box(3, 5, 7, 7), box(3, 3, 7, 5 - gap)
    regions = [fine, {"name": "top", "ring": top}, {"name": "bottom", "ring": bottom}]
    return {"outer": box(0, 0, 16, 16), "region": "rest", "regions": regions}


@pytest.mark.parametrize("growth", [{}, {"growth": 0.2}])
def test_detail_is_told_also_where_the_spacing_jumps(growth):
    spacing = {"maximum": 2, **growth}
    plain = prepare(case_of(strip_beside_a_jump(0), spacing))
    assert not [warning for warning in plain.warnings if "times those of the spacing" in warning]
    problem = prepare(case_of(strip_beside_a_jump(0.03), spacing))
    (warning,) = (warning for warning in problem.warnings if "times those of the spacing" in warning)
    times = problem.expected_nodes / plain.expected_nodes
    assert times > 1.5
    assert float(re.search(r"(\S+) times those", warning)[1]) == pytest.approx(times, rel=0.1)


def test_detail_that_takes_few_nodes_is_no_warning_of_its_own():
    problem = prepare(case_of({"outer": box(0, 0, 1, 0.3)}, 0.4))
    assert problem.packing_spacing is not problem.spacing
    assert not [warning for warning in problem.warnings if "times those of the spacing" in warning]


@pytest.mark.parametrize(
    ("line", "keys", "told"),
    [
        ([[4, 1e-4], [6, 9.999]], "", True),  # beside the boundary at both ends
        ([[4, 9.9999], [6, 9.9999]], "", True),
        ([[4, 9.9999], [6, 9.9999]], ", join: 0.01", False),
        ([[4, 9.95], [6, 9.95]], "", False),
    ],
)
def test_a_gap_beside_a_line_that_is_hardly_meant_names_join(line, keys, told):
    text = f"domain: {{outer: {{rectangle: [0, 0, 10, 10]}}, lines: [{{path: {line}, label: a{keys}}}]}}\nspacing: 1"
    warnings = prepare(load_case("a.yaml", text=text)).warnings
    assert any("join beside the line or file closes a gap that is not meant" in text for text in warnings) == told


def test_a_gap_between_drawn_regions_asks_for_the_same_coordinates():
    regions = "[{name: a, ring: {rectangle: [0.5, 0.5, 2, 1.5]}}, {name: b, ring: {rectangle: [2.00001, 0.5, 3, 1.5]}}]"
    text = f"domain: {{outer: {{rectangle: [0, 0, 4, 2]}}, regions: {regions}}}\nspacing: 0.2"
    (warning,) = (text for text in prepare(load_case("a.yaml", text=text)).warnings if "leaves a strip" in text)
    assert "the same coordinates" in warning
    assert "join" not in warning
