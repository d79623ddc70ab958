"""Refinement to a least angle and largest areas, against a brute look at all angles."""

import json
import math
import random
from functools import cache
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from invariants import check_area, check_mesh
from sweeps import sweep

import bubblemesh
from bubblemesh.case import load_case
from bubblemesh.errors import CaseError, LimitError
from bubblemesh.problem.prepare import prepare
from bubblemesh.process import stopwatch
from bubblemesh.run import time_limit
from bubblemesh.run.pipeline import mesh_case

PLATE = {"rectangle": [0, 0, 2, 1], "labels": ["bottom", "right", "top", "left"]}
NEAR_CIRCLES = {
    "outer": PLATE,
    "holes": [{"circle": {"center": [x, 0.5], "radius": 0.3}} for x in (0.5, 1.105)],
}
COARSE, MEDIUM = ({"value": value, "across": 0} for value in (0.2, 0.1))


def meshed(domain, **keys):
    keys = {"spacing": COARSE, "angle_min": 25, **keys}
    if keys.get("method", "multilevel") == "multilevel":
        keys = {"packing": {"effort": "fast"}, **keys}
    return result_of(json.dumps({"domain": domain, **keys}))


@cache
def result_of(text):
    """Result of the text of a case: rows of a test look at the same ones."""
    return mesh_case(load_case("a.yaml", text=text))


def angles_at(mesh):
    """Angle in degrees and node of all corners of triangles, one by one."""
    for triangle in mesh.triangles[:, :3].tolist():
        for k in range(3):
            a, b, c = (mesh.points[triangle[(k + j) % 3]] for j in range(3))
            u, v = b - a, c - a
            yield math.degrees(math.atan2(abs(u[0] * v[1] - u[1] * v[0]), u @ v)), triangle[k]


def areas(mesh):
    a, b, c = np.moveaxis(mesh.points[mesh.triangles[:, :3]], 1, 0)
    return ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2


def wedge(degrees):
    a = math.radians(degrees)
    return {"outer": {"polygon": [[0, 0], [2, 0], [2 * math.cos(a), 2 * math.sin(a)]]}}


def random_polygon(seed):
    """A polygon around the origin, with corners of all kinds."""
    random_ = random.Random(seed)
    count = random_.randint(4, 16)
    turns = sorted(random_.uniform(0, 2 * math.pi) for _ in range(count))
    ring = [[r * math.cos(a), r * math.sin(a)] for a in turns for r in [random_.uniform(0.3, 1)]]
    return {"outer": {"polygon": ring}}


def spiky_polygon(seed):
    """A star with arms and bays that are some degrees wide."""
    random_ = random.Random(seed)
    turns = sorted(random_.uniform(0, 2 * math.pi) for _ in range(20))
    ring = [[r * math.cos(a), r * math.sin(a)] for k, a in enumerate(turns) for r in [1 if k % 2 else 0.25]]
    return {"outer": {"polygon": ring}}


def corner_angles(ring):
    """Inner angles in degrees at the vertices of a counter-clockwise polygon."""
    x = np.array(ring)
    ahead, back = np.roll(x, -1, axis=0) - x, np.roll(x, 1, axis=0) - x
    turn = np.arctan2(ahead[:, 0] * back[:, 1] - ahead[:, 1] * back[:, 0], (ahead * back).sum(axis=1))
    return np.degrees(np.mod(turn, 2 * np.pi))


@pytest.mark.parametrize("angle", sweep([30, 28, 29], quick=2))
def test_the_angle_holds_between_circles_that_nearly_touch(angle):
    before, after = (meshed(NEAR_CIRCLES, angle_min=a, spacing=MEDIUM) for a in (0, angle))
    assert before.report["quality"]["angle_min"] < angle
    assert min(a for a, _ in angles_at(after.mesh)) >= angle - 1e-6
    check_mesh(after.mesh)
    refinement = after.report["refinement"]
    assert refinement["least_angle"] == pytest.approx(after.report["quality"]["angle_min"])
    assert refinement["nodes_added"] == len(after.mesh.points) - len(before.mesh.points)
    assert not refinement["excused"]
    assert "refinement" not in before.report
    assert after.verdict is None


def test_new_nodes_lie_on_the_true_curves():
    mesh = meshed(NEAR_CIRCLES, angle_min=30, spacing=MEDIUM).mesh
    holes = [k for k, label in enumerate(mesh.labels) if label.startswith("hole")]
    nodes = np.unique(mesh.facets[np.isin(mesh.facet_labels, holes)])
    radii = np.min([np.hypot(*(mesh.points[nodes] - [x, 0.5]).T) for x in (0.5, 1.105)], axis=0)
    np.testing.assert_allclose(radii, 0.3, rtol=1e-12)


def test_a_mesh_that_is_good_enough_stays_as_it_is():
    before, after = (meshed({"outer": PLATE}, angle_min=a) for a in (0, 20))
    np.testing.assert_array_equal(before.mesh.points, after.mesh.points)
    assert after.report["refinement"]["nodes_added"] == 0


@pytest.mark.parametrize("degrees", [3, 10, 20, 24])
def test_only_a_sharper_corner_is_excused_and_told(degrees):
    result = meshed(wedge(degrees))
    (excused,) = result.report["refinement"]["excused"]
    assert excused["at"] == [0.0, 0.0]
    assert excused["angle"] == pytest.approx(degrees, rel=0.5)
    (told,) = (line for line in result.report["warnings"] if line.startswith("angle_min: 25 holds but in a corner"))
    assert "degrees at (0, 0): no mesh can do better there" in told
    assert result.verdict is None


@pytest.mark.parametrize("degrees", [26, 35, 45, 59])
def test_a_corner_that_is_not_sharper_is_not_excused(degrees):
    result = meshed(wedge(degrees))
    assert not result.report["refinement"]["excused"]
    assert min(a for a, _ in angles_at(result.mesh)) >= 25 - 1e-6


@pytest.mark.long
@settings(max_examples=25, deadline=None)
@given(st.integers(0, 100_000), st.sampled_from([20.0, 25.0, 30.0]), st.sampled_from([0.1, 0.3]))
def test_random_polygons_have_the_angle_but_near_sharper_corners(seed, angle, spacing):
    domain = random_polygon(seed)
    ring = domain["outer"]["polygon"]
    try:
        result = meshed(domain, angle_min=angle, spacing={"value": spacing, "across": 0}, limits={"max_nodes": 50_000})
    except bubblemesh.errors.GeometryError:
        return  # the ring crosses itself
    check_mesh(result.mesh)
    assert result.verdict is None
    corners = corner_angles(ring)
    sharp = {tuple(vertex) for vertex, corner in zip(ring, corners, strict=True) if corner < angle}
    excused = {tuple(corner["at"]) for corner in result.report["refinement"]["excused"]}
    assert excused <= sharp
    if not sharp:
        assert min(a for a, _ in angles_at(result.mesh)) >= angle - 1e-6


@pytest.mark.parametrize("spacing", [0.3, 0.1])
def test_touching_circles_end(spacing):
    domain = {"outer": {"circle": {"center": [0, 0], "radius": 1}}}
    domain["holes"] = [{"circle": {"center": [0.2, 0], "radius": 0.8}}]
    result = meshed(domain, spacing={"value": spacing, "across": 0}, angle_min=30)
    assert result.verdict is None
    assert {tuple(np.round(corner["at"], 12)) for corner in result.report["refinement"]["excused"]} <= {(1.0, 0.0)}


REGIONS = {
    "outer": PLATE,
    "regions": [
        {"name": "blade", "ring": {"polygon": [[0.2, 0.2], [1.8, 0.3], [1.7, 0.6]]}},
        {"name": "core", "ring": {"circle": {"center": [1, 0.8], "radius": 0.1}}, "largest": 0.0004},
    ],
    "lines": [{"path": [[0.1, 0.5], [0.5, 0.52]], "label": "crack"}],
    "points": [{"at": [0.12, 0.13], "label": "gauge"}],
}


def test_regions_lines_and_points_stay():
    result = meshed(REGIONS, angle_min=28, spacing={"value": 0.25, "across": 0})
    mesh = result.mesh
    check_area(mesh)
    assert set(mesh.regions) == {"domain", "blade", "core"}
    assert [list(corner["at"]) for corner in result.report["refinement"]["excused"]] in ([], [[0.2, 0.2]])
    area = areas(mesh)
    core = mesh.triangle_regions == mesh.regions.index("core")
    assert area[core].max() <= 0.0004 * (1 + 1e-8)
    assert area[~core].max() > 0.004
    np.testing.assert_array_equal(mesh.points[mesh.labelled_nodes], [[0.12, 0.13]])


def test_periodic_sides_are_split_alike():
    domain = {"outer": PLATE, "periodic": [["left", "right"]]}
    domain["holes"] = [{"circle": {"center": [0.11, 0.5], "radius": 0.1}}]
    result = meshed(domain, angle_min=30, largest=0.004, spacing={"value": 0.4, "across": 0, "minimum": 0.3})
    (sides,) = result.mesh.periodic_sides
    assert len(sides.nodes) > 8
    ends = result.mesh.points[sides.nodes]
    np.testing.assert_allclose(ends[:, 1] - ends[:, 0], np.tile(sides.shift, (len(ends), 1)), atol=1e-12)
    assert areas(result.mesh).max() <= 0.004 * (1 + 1e-8)
    assert min(a for a, _ in angles_at(result.mesh)) >= 30 - 1e-6


@pytest.mark.long
@pytest.mark.parametrize("method", ["accelerated", "fnpbs", "bpm"])
def test_every_method_is_refined(method):
    mesh = meshed(NEAR_CIRCLES, angle_min=25, method=method, largest=0.01).mesh
    assert min(a for a, _ in angles_at(mesh)) >= 25 - 1e-6
    assert areas(mesh).max() <= 0.01 * (1 + 1e-8)


def test_second_order_keeps_its_corners():
    mesh = meshed(NEAR_CIRCLES, output={"order": 2}).mesh
    assert mesh.order == 2
    assert min(a for a, _ in angles_at(mesh)) >= 25 - 1e-6


def test_areas_are_mostly_met_by_the_spacing():
    result = meshed({"outer": PLATE}, angle_min=0, largest=0.001, spacing=0.2)
    nodes = len(result.mesh.points)
    assert areas(result.mesh).max() <= 0.001 * (1 + 1e-8)
    assert result.report["refinement"]["nodes_added"] < 0.02 * nodes
    assert nodes < 2 * (2 / 0.001) / 2


def test_a_limit_on_nodes_ends_the_refinement_with_the_mesh():
    domain = {"outer": PLATE, "holes": [{"rectangle": [0.5, 0.0001, 1.5, 0.5]}]}
    result = meshed(domain, limits={"max_nodes": 1000})
    assert isinstance(result.verdict, LimitError)
    assert "stopped by limits.max_nodes: 1000: the mesh is made, but the least angle is" in str(result.verdict)
    assert len(result.mesh.points) <= 1000
    check_mesh(result.mesh)


def test_a_limit_on_time_ends_a_refinement_that_would_take_minutes_with_or_without_a_mesh():
    domain = {"outer": PLATE, "holes": [{"rectangle": [0.5, 1e-8, 1.5, 0.5]}]}
    try:  # 100 million nodes in the strip
        end = meshed(domain, angle_min=30, spacing={"value": 0.2, "across": 0}, limits={"seconds": 0.5}).verdict
    except LimitError as error:
        end = error
    assert isinstance(end, LimitError)
    assert str(end).startswith("limits.seconds: ")


def test_a_limit_on_time_that_is_met_in_the_refinement_is_told(monkeypatch):
    def enter(stage):
        if stage == "refinement":
            monkeypatch.setattr(time_limit, "time_left", lambda: 0.0)

    monkeypatch.setattr(stopwatch, "enter", enter)
    result = meshed(NEAR_CIRCLES, angle_min=30, spacing=MEDIUM, limits={"seconds": 100})
    reason = "the time limit of 100 s"
    assert str(result.verdict) == f"limits.seconds: stopped by {reason}: the mesh is as it was then"
    assert (result.report["stop_reason"], result.report["finished"]) == (reason, False)
    ended = [told for told in result.report["warnings"] if told.startswith(reason)]
    assert ended == [f"{reason} ended the refinement for angle_min, largest or overconstrained: the mesh is valid"]


def test_without_demands_nothing_is_done():
    case = {"domain": NEAR_CIRCLES, "spacing": 0.2}
    asked = case | {"angle_min": 20, "largest": 1.0}
    demanded = [prepare(load_case("a.yaml", text=json.dumps(some))).task.demanded for some in (case, asked)]
    assert demanded == [(), ("angle_min", "largest")]


def test_python_programs_have_the_same_keys():
    import shapely

    mesh = bubblemesh.mesh(shapely.box(0, 0, 2, 1), 0.3, angle_min=30, largest=0.01)
    assert areas(mesh).max() <= 0.01 * (1 + 1e-8)
    with pytest.raises(CaseError, match="angle_min: must be from 0 to 30"):
        bubblemesh.mesh(shapely.box(0, 0, 2, 1), 0.3, angle_min=40)


def on_rings_only(mesh):
    """Number of triangles all of whose nodes are on the rings, one by one."""
    on_rings = set(mesh.facets[mesh.outer].ravel().tolist())
    return sum(on_rings.issuperset(triangle) for triangle in mesh.triangles.tolist())


OVERCONSTRAINED = {
    "corner": ({"outer": {"polygon": [[0, 0], [1, 0], [0.5, 0.8]]}}, 0.4),
    "one triangle": ({"outer": {"polygon": [[0, 0], [1, 0], [0.5, 0.8]]}}, 2),
    "sharp corner": ({"outer": {"polygon": [[0, 0], [1, 0], [0.97, 0.2]]}}, 0.1),
    "channel": ({"outer": {"rectangle": [0, 0, 4, 0.1]}}, 0.12),
    "line from wall to wall": (
        {"outer": {"rectangle": [0, 0, 1, 0.4]}, "lines": [{"path": [[0, 0.2], [1, 0.2]], "label": "crack"}]},
        0.5,
    ),
    "periodic channel": (
        {"outer": {"rectangle": [0, 0, 2, 0.1], "labels": ["a", "b", "c", "d"]}, "periodic": [["b", "d"]]},
        0.12,
    ),
}


@pytest.mark.parametrize("angle", [0, 20])
@pytest.mark.parametrize(("domain", "size"), OVERCONSTRAINED.values(), ids=OVERCONSTRAINED)
def test_each_triangle_has_a_node_inside_if_that_is_asked_for(domain, size, angle):
    keys = {"spacing": {"value": size, "across": 0}, "angle_min": angle}
    plain, split = meshed(domain, **keys), meshed(domain, overconstrained="split", **keys)
    assert on_rings_only(plain.mesh) > 0
    assert on_rings_only(split.mesh) == 0
    check_mesh(split.mesh)
    check_area(split.mesh)
    refinement = split.report.refinement
    assert (refinement.overconstrained, refinement.stopped) == (0, None)
    assert refinement.nodes_added == len(split.mesh.points) - len(meshed(domain, **keys | {"angle_min": 0}).mesh.points)


@pytest.mark.parametrize("seed", sweep(range(12), quick=4))
def test_each_triangle_of_a_random_polygon_has_a_node_inside(seed):
    split = meshed(random_polygon(seed), overconstrained="split", angle_min=0)
    assert on_rings_only(split.mesh) == 0
    check_mesh(split.mesh)
    assert split.verdict is None


@pytest.mark.parametrize("degrees", [5, 10, 15, 25, 35, 39])
def test_corners_less_than_twice_the_angle_are_excused_where_each_triangle_has_a_node_inside(degrees):
    result = meshed(wedge(degrees), angle_min=20, overconstrained="split")
    refinement = result.report.refinement
    assert result.verdict is None
    assert (refinement.overconstrained, refinement.stopped) == (0, None)
    assert refinement.least_angle >= 20
    assert refinement.nodes_added < 200
    if degrees < 39:
        assert [0.0, 0.0] in [excused["at"] for excused in result.report["refinement"]["excused"]]


@pytest.mark.parametrize(("seed", "angle"), sweep(product(range(6), [20, 25]), quick=4))
def test_sharp_corners_end_with_both_demands_and_no_tiny_edges(seed, angle):
    result = meshed(spiky_polygon(seed), spacing={"value": 0.1}, angle_min=angle, overconstrained="split")
    check_mesh(result.mesh)
    assert len(result.mesh.points) < 3 * len(meshed(spiky_polygon(seed), spacing={"value": 0.1}).mesh.points)
    edges = result.mesh.points[result.mesh.triangles]
    shortest = np.hypot(*np.moveaxis(edges - np.roll(edges, 1, axis=1), 2, 0)).min()
    assert shortest > 1e-7
    if result.verdict is not None:  # it is told where
        assert "too near to each other to be split, as at (" in str(result.verdict)


@pytest.mark.parametrize("seed", sweep(range(6), quick=2))
def test_what_smoothing_throws_out_of_the_domain_is_put_back(seed):
    """Nodes that have left the domain have no edges, whose mean length is no number."""
    check_mesh(meshed(spiky_polygon(seed), angle_min=30, overconstrained="split").mesh)


def test_triangles_that_may_not_be_split_are_told():
    domain, size = OVERCONSTRAINED["channel"]
    keys = {"spacing": {"value": size, "across": 0}, "overconstrained": "split"}
    nodes = len(meshed(domain, **keys | {"overconstrained": None}, angle_min=0).mesh.points)
    stopped = meshed(domain, **keys, angle_min=0, limits={"max_nodes": nodes + 3})
    assert isinstance(stopped.verdict, LimitError)
    left = on_rings_only(stopped.mesh)
    assert left > 0
    assert stopped.report.refinement.overconstrained == left
    assert f"{left} triangles with all nodes on the boundary are left" in str(stopped.verdict)
