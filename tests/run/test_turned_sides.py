"""Periodic sides that are one another turned: sectors of machines, wedges with their tip, and what else a case has."""

import json

import numpy as np
import pytest
from invariants import check_edges
from partitions import mesh_of

from bubblemesh.case import load_case
from bubblemesh.meshes.edges import directed_sides, one_sided
from bubblemesh.meshes.periodic import motion_text
from bubblemesh.problem.prepare import prepare
from bubblemesh.run.estimate import estimate
from bubblemesh.run.pipeline import mesh_case

SECTORS = 7
ANGLE = 2 * np.pi / SECTORS
TURN = np.array([[np.cos(ANGLE), -np.sin(ANGLE)], [np.sin(ANGLE), np.cos(ANGLE)]])
SECTOR = """
parameters: {a: 2*pi/7}
domain:
  outer:
    path:
      - [1, 0]
      - {to: [2, 0], label: right}
      - {arc: {to: [2*cos(a), 2*sin(a)], center: [0, 0], turn: left}, label: yoke}
      - {to: [cos(a), sin(a)], label: left}
      - {arc: {to: [1, 0], center: [0, 0], turn: right}, label: shaft}
  periodic: [[right, left]]
"""
REGIONS = """  regions:
    - {name: coil, ring: {circle: {center: [1.4, 0], radius: 0.15}}}
    - {name: next, ring: {circle: {center: [1.4*cos(a), 1.4*sin(a)], radius: 0.15}}}
  lines: [{path: [[1.7, 0], {arc: {to: [1.7*cos(a), 1.7*sin(a)], center: [0, 0], turn: left}}], label: gap}]
"""
WEDGE = """
parameters: {a: 2*pi/7}
domain:
  outer:
    path:
      - [0, 0]
      - {to: [2, 0], label: right}
      - {arc: {to: [2*cos(a), 2*sin(a)], center: [0, 0], turn: left}, label: yoke}
      - {to: [0, 0], label: left}
  periodic: [[right, left]]
"""
# A passage with skewed walls: the ends of its sides are turned as well as their bends.
SPIRAL = """
parameters: {a: 2*pi/7}
domain:
  outer:
    path:
      - [1, 0]
      - {spline: {through: [[1.5*cos(0.3), 1.5*sin(0.3)], [2*cos(0.4), 2*sin(0.4)]]}, label: right}
      - {arc: {to: [2*cos(a+0.4), 2*sin(a+0.4)], center: [0, 0], turn: left}, label: yoke}
      - {spline: {through: [[1.5*cos(a+0.3), 1.5*sin(a+0.3)], [cos(a), sin(a)]]}, label: left}
      - {arc: {to: [1, 0], center: [0, 0], turn: right}, label: shaft}
  periodic: [[right, left]]
"""
GRADED = "spacing: '0.08 + 0.1*abs(y)'\npacking: {effort: fast}\n"


def check_turned(mesh):
    """The nodes (k,) on the right side and (k,) on the left one; fail unless these are the former turned."""
    (sides,) = mesh.periodic_sides
    right, left = sides.nodes.T if mesh.labels[sides.first] == "right" else sides.nodes.T[::-1]
    for nodes, label in ((right, "right"), (left, "left")):
        assert set(nodes.tolist()) == set(mesh.facets[mesh.facet_labels == mesh.labels.index(label)].ravel().tolist())
    np.testing.assert_allclose(mesh.points[right] @ TURN.T, mesh.points[left], rtol=0, atol=1e-12)
    sign = 1 if mesh.labels[sides.first] == "right" else -1
    assert sides.angle == pytest.approx(sign * np.degrees(ANGLE), abs=1e-9)
    np.testing.assert_allclose(sides.center, [0, 0], atol=1e-12)
    np.testing.assert_allclose(sides.moved(mesh.points[sides.nodes[:, 0]]), mesh.points[sides.nodes[:, 1]], atol=1e-12)
    return right, left


def result_of(text, **keys):
    """Result of a sector with more keys."""
    keys = {"packing": {"effort": "fast"}} | keys
    return mesh_case(load_case("a.yaml", text=text + "".join(f"{key}: {json.dumps(keys[key])}\n" for key in keys)))


@pytest.mark.parametrize(
    "text", [SECTOR + REGIONS, WEDGE, SPIRAL], ids=["regions across the sides", "with its tip", "spiral"]
)
def test_copies_of_a_sector_fill_the_ring_node_to_node(text):
    mesh = mesh_of(text + GRADED)
    right, left = check_turned(mesh)
    check_edges(mesh)
    n, t = len(mesh.points), len(mesh.triangles)
    points, number = [mesh.points], np.arange(n)
    for _ in range(SECTORS - 1):
        points.append(points[-1] @ TURN.T)
    joined = number + n * np.arange(SECTORS)[:, None]
    for k in range(SECTORS):  # the left side of each sector is the right one of the next
        np.testing.assert_allclose(points[k][left], points[(k + 1) % SECTORS][right], rtol=0, atol=1e-12)
        joined[k, left] = joined[(k + 1) % SECTORS, right]
    tip = np.intersect1d(left, right)
    joined[:, tip] = tip
    triangles = joined[:, mesh.triangles].reshape(-1, 3)
    assert len(triangles) == SECTORS * t
    rim = one_sided(directed_sides(triangles), SECTORS * n)
    on_rim = np.isin(
        mesh.facet_labels, [mesh.labels.index(label) for label in ("yoke", "shaft") if label in mesh.labels]
    )
    assert len(rim) == SECTORS * on_rim.sum()


def test_the_finer_side_decides():
    mesh = mesh_of(SECTOR + "spacing: '0.05 + 0.2*abs(y)'\n")
    assert len(check_turned(mesh)[0]) == 21


@pytest.mark.parametrize("text", [SECTOR + REGIONS, WEDGE, SPIRAL])
def test_nodes_of_second_order_match(text):
    mesh = result_of(text, spacing=0.2, output={"order": 2}).mesh
    assert mesh.order == 2
    check_turned(mesh)


@pytest.mark.parametrize("text", [SECTOR + REGIONS, WEDGE])
def test_sides_match_in_a_mesh_of_parts(text):
    result = result_of(text, spacing=0.07, parts=3)
    assert result.report.parts.number == 3
    check_turned(result.mesh)
    check_edges(result.mesh)


@pytest.mark.parametrize("on", [["shaft", "yoke"], ["yoke"], ["right", "left"]])
def test_sides_match_where_layers_end_on_them_and_where_they_have_some(on):
    result = result_of(SECTOR, spacing=0.1, layers=[{"on": on, "first": 0.01, "growth": 1.3, "count": 5}])
    right, _ = check_turned(result.mesh)
    heights = np.hypot(*result.mesh.points[right].T) - 1
    if on == ["shaft", "yoke"]:
        layers = 0.01 * np.cumsum(1.3 ** np.arange(5))
        assert np.isclose(heights[:, None], [*layers, *(1 - layers)], atol=1e-3).any(axis=0).all()


def test_sides_are_split_alike():
    mesh = result_of(SECTOR, spacing={"value": 0.4, "across": 0}, angle_min=30, largest=0.004).mesh
    assert len(check_turned(mesh)[0]) > 8


@pytest.mark.parametrize("text", [SECTOR, WEDGE])
def test_a_metric_that_turns_with_the_sides_is_the_same_on_both(text):
    metric = {"across": 0.05, "along": 0.2, "angle": "atan2(y, x) + pi/3"}
    result = result_of(text, spacing=0.3, metric=metric)
    check_turned(result.mesh)
    assert not any("periodic" in warning for warning in result.report.warnings)


def test_a_metric_that_does_not_turn_with_the_sides_is_told():
    result = result_of(SECTOR, spacing=0.3, metric={"across": 0.05, "along": 0.2, "angle": 0})
    check_turned(result.mesh)
    assert any("between periodic sides, at (1, 0) and (0.6" in warning for warning in result.report.warnings)


@pytest.mark.parametrize("a", ["pi", "3*pi/2"])
def test_a_wedge_may_be_half_of_a_disc_or_more(a):
    (sides,) = (mesh := mesh_of(WEDGE.replace("2*pi/7", a) + "spacing: 0.3\n")).periodic_sides
    here, there = mesh.points[sides.nodes.T]
    np.testing.assert_allclose(np.hypot(*here.T), np.hypot(*there.T), atol=1e-12)
    assert (sides.nodes[:, 0] == sides.nodes[:, 1]).sum() == 1
    assert np.cos(np.radians(sides.angle)) == pytest.approx({"pi": -1, "3*pi/2": 0}[a], abs=1e-12)


def test_a_cell_of_fourfold_symmetry_has_two_turned_pairs():
    square = "domain: {outer: {rectangle: [0, 0, 1, 1], labels: [b, r, t, l]}, periodic: [[b, l], [t, r]]}\n"
    mesh = mesh_of(square + "spacing: '0.04 + 0.1*x'\n")
    assert {(sides.angle, *sides.center.tolist()) for sides in mesh.periodic_sides} == {(-90, 0, 0), (90, 1, 1)}


CELL = "domain: {outer: {rectangle: [0, 0, 1, 0.5], labels: [b, r, t, l]}, periodic: [[r, l], [b, t]]}\n"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (WEDGE.replace("2*pi/7", "pi/4"), ["right to left: turned by 45 degrees about (0, 0)"]),
        (SPIRAL, ["right to left: turned by 51.42857143 degrees about (0, 0)"]),
        (CELL, ["r to l: moved by (-1, 0)", "b to t: moved by (0, 0.5)"]),
        (
            CELL.replace("0, 0, 1, 0.5", "1000.1, 0.3, 1000.8, 0.4"),
            ["r to l: moved by (-0.7, 0)", "b to t: moved by (0, 0.1)"],
        ),
    ],
)
def test_how_sides_are_moved_is_told_before_a_run_and_after_it(text, told):
    case = load_case("a.yaml", text=text + "spacing: 0.25\n")
    problem = prepare(case)
    size = problem.domain.size
    figures, result = estimate(problem), mesh_case(case)
    assert [motion_text(row, size) for row in figures["periodic_sides"]] == told
    assert result.report["periodic_sides"] == figures["periodic_sides"]
    moves = {
        (result.mesh.labels[sides.first], result.mesh.labels[sides.second]): sides
        for sides in result.mesh.periodic_sides
    }
    for row in figures["periodic_sides"]:
        names = row["side"], row["with"]
        sides, sign = (moves[names], 1) if names in moves else (moves[names[::-1]], -1)
        if "shift" in row:
            assert row["shift"] == pytest.approx((sign * sides.shift).tolist(), abs=1e-9)
        else:
            assert row["angle"] == pytest.approx(sign * sides.angle, abs=1e-9)
            assert row["center"] == pytest.approx(sides.center.tolist(), abs=1e-9)
