"""Boundary layers in meshes: exact heights, fans, ends, and what goes on beside them."""

import json
from dataclasses import replace
from functools import cache
from itertools import product

import numpy as np
import pytest
from invariants import check_area, check_arrays, check_edges, check_facets_do_not_cross, check_labels
from sweeps import sweep

import bubblemesh
from bubblemesh import console
from bubblemesh.arrays import members
from bubblemesh.case import load_case
from bubblemesh.console.report import show_quality
from bubblemesh.errors import CaseError, LimitError
from bubblemesh.geometry.domain import NOTHING_HELD
from bubblemesh.layers.figures import layer_figures
from bubblemesh.layers.heights import AT_ONCE, reached
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.quads import corner_angles, quadrilaterals
from bubblemesh.meshes.quality import Measures
from bubblemesh.problem.prepare import prepare
from bubblemesh.run.estimate import estimate
from bubblemesh.run.pipeline import mesh_case
from bubblemesh.spacing.spacing import Spacing

SIDES = ["bottom", "right", "top", "left"]
CHANNEL = {"outer": {"rectangle": [0, 0, 4, 2], "labels": SIDES}}
DISC = {"circle": {"center": [2, 1], "radius": 0.5}, "label": "disc"}
AROUND = {"outer": {"rectangle": [0, 0, 4, 2], "label": "far"}, "holes": [DISC]}
FIVE = {"first": 0.01, "growth": 1.5, "count": 5}
TOPS = 0.01 * np.cumsum(1.5 ** np.arange(5))


def run(domain, *layers, spacing=0.1, **keys):
    """Result of a case, whose mesh is sound."""
    case = {"domain": domain, "spacing": spacing, "layers": layers, "packing": {"effort": "fast"}, **keys}
    return meshed(json.dumps(case))


@cache
def meshed(text):
    """Result of the text of a case: several tests look at the same ones."""
    result = mesh_case(load_case("a.yaml", text=text))
    if result.mesh.order == 1:
        check(result.mesh)
    return result


def prepared(domain, *layers, spacing=0.1):
    """Problem of a case."""
    case = {"domain": domain, "spacing": spacing, "layers": layers}
    return prepare(load_case("a.yaml", text=json.dumps(case)))


def layers_of(problem, label):
    """Figures of the layers on a label, before anything is packed."""
    return next(row for row in layer_figures(problem.rest.strips) if row.label == label)


def check(mesh):
    """Fail unless the mesh is sound; nodes of inner lines are among those of the boundary."""
    for invariant in (check_arrays, check_edges, check_facets_do_not_cross, check_area, check_labels):
        invariant(mesh)


def row_of(result, label):
    return next(row for row in result.report["layers"] if row["label"] == label)


def has_nodes(x, points):
    """Whether there is a node, of those at ``x`` (n, 2), at each of the points, but for rounding."""
    near = np.abs(x[:, None] - np.asarray(points)[None]).max(axis=2).min(axis=0)
    return (near < 1e-12).all()


def test_layers_on_a_straight_wall_are_at_their_heights_at_all_its_nodes():
    result = run(CHANNEL, {"on": "bottom", **FIVE})
    mesh = result.mesh
    wall = np.unique(mesh.points[mesh.points[:, 1] == 0, 0])
    assert has_nodes(mesh.points, [(x, y) for x in wall for y in TOPS])
    below = mesh.points[(mesh.points[:, 1] < TOPS[-1] + 1e-9)]
    assert len(below) == len(wall) * 6
    row = row_of(result, "bottom")
    assert row["first"] == pytest.approx({"least": 1, "mean": 1, "largest": 1, "kept": 1})
    assert row["count"] == {"wanted": 5, "least": 5, "most": 5}
    assert (row["complete"], row["compressed"]) == (1, 1)
    assert row["orthogonality"]["least"] == pytest.approx(90)
    assert row["aspect"] == pytest.approx(wall[1] / 0.01)


def test_triangles_that_close_steps_are_not_divided():
    tubes = [{"circle": {"center": [x, 0], "radius": 0.01}, "label": "tube"} for x in (0, 0.03)]
    domain = {"outer": {"rectangle": [-0.06, -0.04, 0.06, 0.04]}, "holes": tubes}
    result = run(domain, {"on": "tube", "first": 0.0003, "until": "isotropic"}, spacing={"value": 0.006, "across": 4})
    mesh, layer = result.mesh, result.fields["layer"]
    in_layers = Measures(mesh.points, mesh.triangles[layer > 0])
    assert 90 < in_layers.angles.max() < 150


def test_the_last_columns_follow_the_walls_beside_and_have_their_labels():
    mesh = run(CHANNEL, {"on": "bottom", **FIVE}).mesh
    for label, x in (("left", 0), ("right", 4)):
        nodes = np.unique(mesh.facets[mesh.facet_labels == mesh.labels.index(label)])
        heights = mesh.points[nodes, 1]
        assert (mesh.points[nodes, 0] == x).all()
        assert np.abs(heights[:, None] - TOPS).min(axis=0) == pytest.approx(np.zeros(5), abs=1e-12)


def test_a_curved_wall_that_the_last_column_follows_is_followed_exactly():
    half = {
        "path": [
            [0, 0],
            {"to": [2, 0], "label": "bottom"},
            {"arc": {"to": [0, 0], "center": [1, 0], "turn": "left"}, "label": "dome"},
        ]
    }
    mesh = run({"outer": half}, {"on": "bottom", **FIVE}).mesh
    nodes = np.unique(mesh.facets[mesh.facet_labels == mesh.labels.index("dome")])
    assert np.hypot(*(mesh.points[nodes] - [1, 0]).T) == pytest.approx(np.ones(len(nodes)))
    assert len(nodes) > 10


def test_layers_around_a_disc_are_on_circles():
    mesh = run(AROUND, {"on": "disc", **FIVE}).mesh
    radius = np.hypot(*(mesh.points - [2, 1]).T)
    count = np.isclose(radius, 0.5, rtol=0, atol=1e-12).sum()
    for top in TOPS:
        assert np.isclose(radius, 0.5 + top, rtol=0, atol=1e-12).sum() == count


@pytest.mark.parametrize(("corners", "columns"), [("fans", 4), ("plain", 1)])
def test_a_convex_corner_has_a_fan_unless_it_is_plain(corners, columns):
    box = {
        "outer": {"rectangle": [0, 0, 4, 2], "label": "far"},
        "holes": [{"rectangle": [1, 0.5, 3, 1.5], "label": "box"}],
    }
    problem = prepared(box, {"on": "box", "first": 0.01, "growth": 1.2, "count": 3, "corners": corners})
    first = np.hypot(*(problem.rest.strips.x - [3, 1.5]).T)
    length = 0.01 if corners == "fans" else 0.01 * np.sqrt(2)
    assert np.isclose(first, length, rtol=0, atol=1e-12).sum() == columns
    assert layers_of(problem, "box").first["kept"] == 1


def test_a_concave_corner_has_one_column_and_the_requested_heights_above_both_walls():
    nodes = prepared(CHANNEL, {"on": ["bottom", "left"], **FIVE}).rest.strips.x
    assert has_nodes(nodes, [(top, top) for top in TOPS])


def test_walls_with_different_layers_meet_in_one_column():
    few, many = {"first": 0.02, "growth": 1.2, "count": 2}, {"first": 0.005, "growth": 1.3, "count": 12}
    problem = prepared(CHANNEL, {"on": "bottom", **few}, {"on": "left", **many})
    assert layers_of(problem, "left").first["kept"] == 1
    # From there they grow by a factor of 1.7 from column to column: .005, .0085, .0145, .02.
    assert layers_of(problem, "bottom").first["kept"] == pytest.approx(1 - 0.3 / 4)


LOW_FANS = {
    "thin layers": [{"on": ["floor", "step"], "first": 0.001, "count": 5}],
    "two kinds": [{"on": "floor", "first": 0.0008, "until": "isotropic"}, {"on": "step", "first": 0.016, "count": 4}],
    "two counts": [{"on": "floor", "first": 0.0008, "count": 20}, {"on": "step", "first": 0.016, "count": 4}],
}


@pytest.mark.parametrize("layers", LOW_FANS.values(), ids=LOW_FANS)
def test_beside_a_low_fan_nodes_of_the_wall_are_near_each_other_and_heights_rise_along_it(layers):
    ring = [[0, 0], [1, 0], [1, -0.6], [1.6, -0.6], [1.6, 0.8], [0, 0.8]]
    outer = {"polygon": ring, "labels": ["floor", "step", "far", "far", "far", "far"]}
    result = run({"outer": outer}, *layers, spacing=0.1)
    in_layers = Measures(result.mesh.points, result.mesh.triangles[result.fields["layer"] > 0])
    assert in_layers.angles.max() < 130
    assert result.report["quality"]["min"] > 0.7


def test_the_largest_angle_of_the_cells_is_told_and_warned_of_near_180_degrees():
    outer = {"rectangle": [0, 0, 2, 1], "labels": SIDES}
    result = run({"outer": outer}, {"on": "bottom", "ends": "taper", "first": 0.02, "count": 3}, spacing=0.2)
    (row,) = result.report["layers"]
    in_layers = result.mesh.triangles[result.fields["layer"] > 0]
    angles = Measures(result.mesh.points, in_layers).angles.max(axis=1)
    assert row["angle_max"]["degrees"] == angles.max()
    np.testing.assert_array_equal(row["angle_max"]["at"], result.mesh.points[in_layers[angles.argmax()]].mean(axis=0))
    (found,) = layer_figures(prepared({"outer": outer}, {"on": "bottom", **FIVE}, spacing=0.2).rest.strips)
    assert found.angle_max is None
    assert found.flat is None
    told = [replace(found, angle_max={"degrees": d, "at": (1.0, 0.5)}).flat for d in (174.0, 176.0)]
    assert told[0] is None
    assert "a triangle of them at (1, 0.5) has an angle of 176.0 degrees: make the spacing on the wall finer" in told[1]


def test_columns_with_the_layers_of_another_wall_are_not_counted_as_columns_of_this_one():
    ring = [[0, 0], [1, 0], [1, -0.6], [1.6, -0.6], [1.6, 0.8], [0, 0.8]]
    outer = {"polygon": ring, "labels": ["floor", "step", "far", "far", "far", "far"]}
    floor = {"on": "floor", "first": 0.0002, "growth": 1.1, "count": 40}
    problem = prepared({"outer": outer}, floor, {"on": "step", "first": 0.01, "count": 4}, spacing=0.1)
    step = layers_of(problem, "step")
    assert step.count["most"] == step.count["wanted"] == 4
    assert step.lacks == ()


def test_fronts_of_flat_triangles_that_close_steps_are_divided_if_the_spacing_asks_for_much_shorter_edges():
    rest = prepared(CHANNEL, {"on": "bottom", "ends": "taper", **FIVE}, spacing=0.1).rest
    rest = replace(rest, domain=replace(rest.domain, held=NOTHING_HELD))
    flat = np.flatnonzero(rest.is_flat)
    assert len(flat) > 2
    length = rest.domain.boundary.lengths[flat]
    for size, held in ((0.51 * length.max(), flat), (0.49 * length.min(), [])):
        domain = rest.held_at_steps(Spacing(lambda x, y, d=size: np.full_like(x, d), size)).domain
        np.testing.assert_array_equal(domain.held.pieces, held)


def test_a_wall_that_goes_on_straight_without_layers_has_them_end_one_by_one():
    plate = {
        "outer": {"polygon": [[0, 0], [2, 0], [4, 0], [4, 1], [0, 1]], "labels": ["free", "plate", "far", "far", "far"]}
    }
    result = run(plate, {"on": "plate", **FIVE})
    wall = np.sort(result.mesh.points[(result.mesh.points[:, 1] == 0) & (result.mesh.points[:, 0] >= 2), 0])
    for layers, x in enumerate(wall[:5]):
        column = result.mesh.points[np.isclose(result.mesh.points[:, 0], x, atol=1e-9), 1]
        assert np.isclose(column[:, None], TOPS, rtol=0, atol=1e-12).any(axis=0).sum() == layers
    assert row_of(result, "plate")["shortest"][0] == {"layers": 0, "at": [2.0, 0.0]}


def test_ends_may_taper_where_they_could_follow():
    nodes = prepared(CHANNEL, {"on": "bottom", "ends": "taper", **FIVE}).rest.strips.x
    left = nodes[nodes[:, 0] == 0, 1]
    assert not np.isclose(left[:, None], TOPS, rtol=0, atol=1e-9).any()


def test_a_line_has_layers_on_both_sides_and_around_its_tips():
    domain = {**CHANNEL, "lines": [{"path": [[1, 1], [3, 1]], "label": "crack"}]}
    problem = prepared(domain, {"on": "crack", **FIVE})
    assert has_nodes(problem.rest.strips.x, [(2, 1 + sign * top) for sign in (1, -1) for top in TOPS])
    assert has_nodes(problem.rest.strips.x, [(3 + top, 1) for top in TOPS])
    assert layers_of(problem, "crack").complete == 1


@pytest.mark.parametrize("keys", [{}, {"corners": "plain"}, {"growth": 1}])
def test_thin_layers_on_both_sides_of_a_line_do_not_see_each_other(keys):
    domain = {**CHANNEL, "lines": [{"path": [[1, 1], [3, 1]], "label": "crack"}]}
    row = layers_of(prepared(domain, {"on": "crack", "first": 0.001, "count": 3, **keys}), "crack")
    assert (row.complete, row.low) == (1, 0)


def test_embedded_points_keep_layers_away():
    domain = {**CHANNEL, "points": [{"at": [2.03, 0.0994], "label": "probe"}]}
    result = run(domain, {"on": "bottom", "first": 0.01, "count": 6})
    assert result.report["quality"]["min"] > 0.2


@pytest.mark.parametrize("region", [None, "low", "domain"])
def test_an_interface_has_layers_in_the_regions_that_ask_for_them(region):
    low = {"ring": {"rectangle": [0, 0, 1, 1], "label": "mid"}, "name": "low"}
    entry = {"on": "mid", **FIVE, **({} if region is None else {"region": region})}
    mesh = run({"outer": {"rectangle": [0, 0, 1, 2], "labels": SIDES}, "regions": [low]}, entry).mesh
    for sign, name in ((-1, "low"), (1, "domain")):
        has = has_nodes(mesh.points, [(0, 1 + sign * top) for top in TOPS])
        assert has == (region in (None, name))
    above = mesh.points[mesh.triangles].mean(axis=1)[:, 1] > 1
    assert (np.array(mesh.regions)[mesh.triangle_regions] == np.where(above, "domain", "low")).all()


TWO_REGIONS = {
    "outer": {"rectangle": [0, 0, 2, 1], "labels": SIDES},
    "region": "fluid",
    "regions": [{"name": "solid", "ring": {"rectangle": [0, 0, 2, 0.3]}}],
}
WALLS_OF_FLUID = {"on": ["solid-rim", "left", "right"], "region": "fluid"}


@pytest.mark.parametrize("cells", ["triangles", "quads"])
@pytest.mark.parametrize("until", [{"count": 1}, {"until": "isotropic"}])
def test_layers_taper_where_the_wall_beside_has_some_on_its_other_side_only(until, cells):
    layers = {"first": 0.002, **until, "cells": cells}
    entries = {**WALLS_OF_FLUID, **layers}, {**layers, "on": "left", "region": "solid"}
    found = layer_figures(prepared(TWO_REGIONS, *entries, spacing=0.05).rest.strips)
    (mine,) = [row for row in found if row.region == "solid"]
    assert mine.count["least"] == 0
    assert mine.first["kept"] > 0.8
    others = [row for row in found if row.region == "fluid"]
    assert [row.first["kept"] for row in others] == [1, 1, 1]


def test_a_line_that_ends_on_a_wall_with_layers_on_its_other_side_has_layers_that_taper():
    domain = {**TWO_REGIONS, "lines": [{"path": [[1, 0], [1, 0.3]], "label": "fin"}]}
    layers = {"first": 0.002, "until": "isotropic"}
    problem = prepared(domain, {"on": "solid-rim", "region": "fluid", **layers}, {"on": "fin", **layers}, spacing=0.05)
    assert layers_of(problem, "solid-rim").first["kept"] == 1
    assert layers_of(problem, "fin").first["kept"] > 0.8


@pytest.mark.parametrize("lower", ["fluid", "solid"])
@pytest.mark.parametrize("side", ["left", "right"])
def test_the_column_between_two_entries_on_a_wall_has_the_lower_first_height(side, lower):
    entries = [
        {"on": side, "region": region, "first": 0.001 if region == lower else 0.003, "until": "isotropic"}
        for region in ("fluid", "solid")
    ]
    strips = prepared(TWO_REGIONS, *entries, spacing=0.05).rest.strips
    assert has_nodes(strips.x, [(0.001 if side == "left" else 1.999, 0.3)])
    (row,) = [row for row in layer_figures(strips) if row.region == lower]
    assert row.first == pytest.approx({"least": 1, "mean": 1, "largest": 1, "kept": 1})


NEEDLE = [[0, 0], [0.174, 0], [0.574, 0.926], [0.974, 0], [2, 0], [2, 1], [0, 1]]
TIPS = {
    "needle": ({"outer": {"polygon": NEEDLE, "labels": [*"bnnbr", "top", "l"]}}, 0.15),
    "line": (
        {
            "outer": {"rectangle": [0, 0, 2, 1], "labels": ["b", "r", "top", "l"]},
            "lines": [{"path": [[0.5, 0.9], [1.2, 0.1]], "label": "line"}],
        },
        0.06,
    ),
}


@pytest.mark.parametrize("tip", TIPS)
def test_layers_end_before_the_tip_of_what_has_none(tip):
    domain, spacing = TIPS[tip]
    layers = {"on": "top", "first": 0.004, "until": "isotropic", "cells": "quads"}
    assert run(domain, layers, spacing=spacing).report["quality"]["min"] > 0.3


@pytest.mark.parametrize("stop", [[[2.01, 0.3], [2.01, 0.8]], [[2.01, 0.3], [2.01, 0.5], [2.01, 0.8]]])
def test_a_wall_with_layers_leaves_room_for_those_around_a_tip_across(stop):
    domain = {
        "outer": {"rectangle": [0, 0, 3, 1], "label": "far"},
        "lines": [{"path": [[0.5, 0.5], [2, 0.5]], "label": "plate"}, {"path": stop, "label": "stop"}],
    }
    problem = prepared(domain, {"on": ["plate", "stop"], "first": 0.004, "thickness": 0.05}, spacing=0.05)
    compressed = {label: layers_of(problem, label).first["least"] for label in ("plate", "stop")}
    assert compressed["plate"] == pytest.approx(compressed["stop"], rel=0.1)
    assert compressed["plate"] > 0.2


@pytest.mark.parametrize(("x", "y"), [(5e5, 5e6), (-3e6, 10.0)])
def test_a_place_far_from_the_origin_changes_no_layers(x, y):
    def at(x, y):
        wing = np.array([[1, 0], [0.997, 0.0004], [0.5, 0.08], [0, 0], [0.5, -0.08], [0.997, -0.0004]])
        wing += [x, y]
        outer = {"rectangle": [x - 1, y - 1, x + 2, y + 1], "label": "far"}
        return {"outer": outer, "holes": [{"polygon": wing.tolist(), "label": "wing"}]}

    layers = {"on": "wing", "first": 0.001, "until": "isotropic"}
    here, there = (layers_of(prepared(at(*origin), layers), "wing") for origin in ((0, 0), (x, y)))
    assert here.first["kept"] == there.first["kept"] == 1
    assert (here.count, here.complete) == (there.count, there.complete)


@pytest.mark.parametrize(
    ("edges", "radius"),
    sweep([(5, 0.7), (5, 1.1), (5, 1.3), (5, 1.9), (9, 1.4), (8, 2.5), (12, 3), (20, 5), (40, 10), (90, 20)], quick=5),
)
def test_fillets_of_short_edges_at_concave_corners_leave_first_heights_as_they_are(edges, radius):
    first = 0.001
    turn = np.linspace(np.pi, 1.5 * np.pi, edges + 1)
    arc = np.array([1, 0]) + radius * first * (1 + np.column_stack([np.cos(turn), np.sin(turn)]))
    polygon = [[0, 0.5], [1, 0.5], *arc.tolist(), [3, 0], [3, 1], [0, 1]]
    labels = ["wall"] * (len(polygon) - 3) + ["out", "top", "in"]
    domain = {"outer": {"polygon": polygon, "labels": labels}}
    row = layers_of(prepared(domain, {"on": "wall", "first": first, "until": "isotropic"}, spacing=0.05), "wall")
    assert row.first["kept"] > 0.995
    assert row.compressed == 1


@pytest.mark.parametrize("finer", ["bottom", "right"])
def test_where_two_kinds_of_layers_meet_the_lower_ones_are_in_the_corner(finer):
    heights = {"bottom": 0.01, "right": 0.01} | {finer: 0.002}
    layers = [{"on": label, "first": first, "until": "isotropic"} for label, first in heights.items()]
    problem = prepared(CHANNEL, *layers)
    nodes = problem.rest.strips.x
    assert has_nodes(nodes, [(4 - 0.002, 0.002)])
    across = 0 if finer == "bottom" else 1
    wall = nodes[np.abs(nodes[:, 1 - across] - (0 if finer == "bottom" else 4)) < 1e-12]
    low = np.sort(np.abs(nodes[:, 1 - across] - wall[0, 1 - across]))
    assert low[len(wall)] == pytest.approx(0.002)
    assert layers_of(problem, finer).first["kept"] == 1


def test_periodic_sides_match_where_layers_end_on_them():
    mesh = run({**CHANNEL, "periodic": [["left", "right"]]}, {"on": ["bottom", "top"], **FIVE}).mesh
    (sides,) = mesh.periodic_sides
    left, right = mesh.points[sides.nodes.T]
    assert right - left == pytest.approx(np.tile([4.0, 0.0], (len(left), 1)))
    assert np.isclose(left[:, 1][:, None], TOPS, rtol=0, atol=1e-12).any(axis=0).all()


@pytest.mark.parametrize("entries", [1, 2])
def test_periodic_sides_match_also_where_walls_meet_them_at_other_angles(entries):
    outer = {"polygon": [[0, 0], [1, 0.4], [4, 0], [4, 2], [0, 2]], "labels": ["a", "b", "right", "top", "left"]}
    both = [{"on": ["a", "b"], **FIVE}]
    layers = both if entries == 1 else [{"on": "a", **FIVE}, {"on": "b", **FIVE, "first": 0.02}]
    mesh = run({"outer": outer, "periodic": [["left", "right"]]}, *layers).mesh
    left, right = mesh.points[mesh.periodic_sides[0].nodes.T]
    assert right - left == pytest.approx(np.tile([4.0, 0.0], (len(left), 1)))


def test_periodic_sides_may_have_layers_themselves():
    mesh = run({**CHANNEL, "periodic": [["left", "right"]]}, {"on": ["left", "right"], **FIVE}).mesh
    assert len(mesh.periodic_sides[0].nodes) > 15


DEMANDS = {"angle_min": 28}, {"largest": 0.001}, {"overconstrained": "split"}


@pytest.mark.parametrize(("keys", "gap"), sweep([*product(DEMANDS, [0.3, 0.01])], quick=3))
def test_nodes_on_periodic_sides_with_layers_match_whatever_is_asked_for(gap, keys):
    # The narrow gap has no room for layers on one side, whose wall stays as it is.
    disc = {"circle": {"center": [0.65, 0.505], "radius": 0.495 - gap}, "label": "disc"}
    outer = {"rectangle": [0, 0, 1.3, 1], "labels": SIDES}
    layers = {"on": ["bottom", "top"], "first": 0.02, "until": "isotropic"}
    domain = {"outer": outer, "holes": [disc], "periodic": [["bottom", "top"]]}
    result = run(domain, layers, spacing=0.06, packing={}, **keys)
    assert result.verdict is None
    nodes = result.mesh.periodic_sides[0].nodes
    assert len(nodes) > 20
    below, above = result.mesh.points[nodes[np.argsort(result.mesh.points[nodes[:, 0], 0])].T]
    np.testing.assert_allclose(above - below, np.tile([0, 1], (len(nodes), 1)), atol=1e-9)
    assert (min(row["count"]["least"] for row in result.report["layers"]) == 0) == (gap < 0.1)


PARTS, BOTH = {"parts": 3}, {"angle_min": 28, "largest": 0.002}


@pytest.mark.parametrize(("keys", "order"), sweep([(PARTS, 1), (BOTH, 1), (BOTH, 2), (PARTS, 2)], quick=2))
def test_nodes_that_parts_or_demands_set_on_fronts_divide_the_cells_below(keys, order):
    result = run(AROUND, {"on": "disc", **FIVE, "cells": "quads"}, **keys, output={"order": order})
    assert row_of(result, "disc")["complete"] == 1
    if "angle_min" in keys:
        assert result.report["quality"]["angle_min"] >= 28 - 1e-9
    assert 0 < len(result.mesh.quads) <= row_of(result, "disc")["columns"] * 5


def test_cells_are_quadrilaterals_if_asked_for():
    for cells, many in (("triangles", 0), ("quads", 5)):
        mesh = run(CHANNEL, {"on": "bottom", **FIVE, "cells": cells}).mesh
        assert len(mesh.quads) == many * ((mesh.points[:, 1] == 0).sum() - 1)


def test_cells_with_an_angle_near_180_degrees_are_no_quadrilaterals():
    """Beside the bump columns lean towards each other. The report tells the largest angle of the others."""
    floor = [[0, 0], [1, 0], [1.02, 0.06], [1.04, 0], [2.2, 0]]
    outer = {"polygon": [*floor, [2.2, 0.5], [0, 0.5]], "labels": ["floor"] * 4 + ["far"] * 3}
    result = run(
        {"outer": outer}, {"on": "floor", "first": 0.006, "until": "isotropic", "cells": "quads"}, spacing=0.06
    )
    mesh, (row,) = result.mesh, result.report["layers"]
    angles = np.degrees(corner_angles(mesh.points[quadrilaterals(mesh.triangles, mesh.quads)]))
    in_layers = result.fields["layer"] > 0
    halves = Measures(mesh.points, mesh.triangles[in_layers]).angles
    assert 150 < angles.max() <= 170
    assert row["angle_max"]["degrees"] == max(angles.max(), halves.max())


@pytest.mark.parametrize("cells", ["triangles", "quads"])
def test_second_order_layers_follow_the_curve(cells):
    result = run(AROUND, {"on": "disc", "cells": cells, **FIVE}, output={"order": 2})
    mesh = result.mesh
    corners = np.hypot(*(mesh.points[mesh.triangles[:, :3]] - [2, 1]).swapaxes(0, -1)).T
    middles = np.hypot(*(mesh.points[mesh.triangles[:, 3:]] - [2, 1]).swapaxes(0, -1)).T
    checked = 0
    for level in (0.0, *TOPS):
        along = np.isclose(corners, 0.5 + level, rtol=0, atol=1e-9)
        for k in range(3):
            both = along[:, k] & along[:, (k + 1) % 3]
            # The bulge of the wall's curve, in terms of the edge's length, differs from that of the circle a little.
            assert middles[both, k] == pytest.approx(np.full(both.sum(), 0.5 + level), abs=2e-4)
            checked += both.sum()
    assert checked > 200
    assert not any("straight second-order" in text for text in result.report["warnings"])


@pytest.mark.parametrize("ends", ["follow", "taper"])
def test_layers_may_end_on_a_wall_that_goes_on_beside_them(ends):
    hole = {"polygon": [[0.5, 0], [0, 0.5], [-0.5, 0], [0, -0.5]], "label": "hole"}
    domain = {
        "outer": {"rectangle": [-1.6, -0.9, 1.9, 1], "label": "far"},
        "holes": [hole],
        "lines": [{"path": [[-1.2, 0.3], [1.5, 0.45]], "label": "line"}],
    }
    layers = {"on": "line", "first": 0.025, "growth": 1.1, "count": 5, "ends": ends}
    assert row_of(run(domain, layers, spacing=0.05), "line")["count"]["most"] == 5


def test_layers_until_isotropic_end_where_they_are_as_high_as_wide():
    row = row_of(run(CHANNEL, {"on": "bottom", "first": 0.001, "growth": 1.2, "until": "isotropic"}), "bottom")
    last = 0.001 * 1.2 ** (row["count"]["most"] - 1)
    assert last * (1 + 1e-9) >= 0.1 / 1.2
    assert last <= 0.1
    assert 0.7 < row["across_front"] < 1.5


@pytest.mark.parametrize("heights", [{"until": "isotropic"}, {"count": 40}], ids=["isotropic", "count"])
def test_layers_around_a_wire_go_on_where_the_spacing_grows(heights):
    wire = {"outer": {"rectangle": [-0.5, -0.5, 0.5, 0.5]}, "holes": [{"circle": {"center": [0, 0], "radius": 0.02}}]}
    wire["holes"][0]["label"] = "wire"
    spacing = {"near": {"label": "wire", "size": 0.004, "growth": 0.2}, "maximum": 0.05}
    result = run(wire, {"on": "wire", "first": 2e-4, **heights}, spacing=spacing)
    row = row_of(result, "wire")
    height = 2e-4 * 1.2 ** (row["count"]["least"] - 1)
    below = row["thickness"] - height / 2
    assert height == pytest.approx(min(0.05, 0.004 + 0.2 * below), rel=0.2)
    assert 0.7 < row["across_front"] < 1.5


@pytest.mark.parametrize("heights", [{"until": "isotropic"}, {"count": 30}], ids=["isotropic", "count"])
def test_no_layer_is_higher_than_the_spacing_at_its_own_place(heights):
    spacing = {"value": 0.2, "near": {"label": "top", "size": 0.01, "growth": 0.12}}
    problem = prepared({**CHANNEL}, {"on": "bottom", "first": 0.005, **heights}, spacing=spacing)
    strips = problem.rest.strips
    owner, level = members(strips.heights.count)
    top, below = (reached(strips.columns, strips.heights, owner, level + k) for k in (1, 0))
    x = strips.columns.at[owner] + np.array([0, 1]) * ((top + below) / 2)[:, None]
    assert (top - below <= problem.spacing(x) * (1 + 1e-9)).all()
    assert (top - below).max() < 0.8 * problem.spacing(np.array([[2.0, 0.0]]))[0]


@pytest.mark.parametrize(
    "spacing",
    ["0.2 if hypot(x, y) < 0.12 else 0.012", "min(0.2, max(0.012, 0.2 - 3*(hypot(x, y) - 0.05)))"],
    ids=["jump", "slope"],
)
def test_layers_end_where_the_spacing_falls_by_more_than_the_way(spacing):
    wire = {"circle": {"center": [0, 0], "radius": 0.05}, "label": "wire"}
    domain = {"outer": {"rectangle": [-0.3, -0.3, 0.3, 0.3]}, "holes": [wire]}
    problem = prepared(domain, {"on": "wire", "first": 0.004, "count": 30}, spacing=spacing)
    strips = problem.rest.strips
    owner, level = members(strips.heights.count)
    top, below = (reached(strips.columns, strips.heights, owner, level + k) for k in (1, 0))
    x = strips.columns.places(owner, (top + below) / 2, level + 1)
    assert (top - below <= problem.spacing(x) * (1 + 1e-9)).all()
    assert strips.heights.count.min() > 5


def test_columns_around_a_slender_hole_part_no_more_than_the_uniform_spacing_allows():
    slender = {"ellipse": {"center": [0, 0], "radii": [0.6, 0.03]}, "label": "slender"}
    domain = {"outer": {"rectangle": [-9, -9, 9, 9]}, "holes": [slender]}
    problem = prepared(domain, {"on": "slender", "first": 0.004, "growth": 1, "count": 80}, spacing=0.3)
    assert (problem.rest.strips.heights.count == 80).all()


def test_a_slot_has_layers_also_where_the_spacing_is_defined_in_the_domain_only():
    slot = {"outer": {"rectangle": [0, 0, 4, 0.02], "labels": SIDES}}
    layers = {"on": ["bottom", "top"], "first": 0.05, "count": 2}
    assert layers_of(prepared(slot, layers, spacing="0.1 + 0*sqrt(y*(0.02 - y))"), "bottom").count["least"] > 0


def test_the_spacing_is_asked_for_several_layers_at_once(monkeypatch):
    asked = []
    one = Spacing.anywhere_towards

    def counted(spacing, points, directions):
        asked.append(len(points))
        return one(spacing, points, directions)

    monkeypatch.setattr(Spacing, "anywhere_towards", counted)
    most = prepared(AROUND, {"on": "disc", "first": 1e-4, "growth": 1.2, "count": 30}, spacing=0.1).rest.strips.heights
    assert (most.count == 30).all()
    assert len(asked) == -(-30 // AT_ONCE)


def test_a_thickness_is_reached_with_a_growth_near_the_given_one():
    problem = prepared(CHANNEL, {"on": "bottom", "first": 0.004, "thickness": 0.2, "growth": 1.3})
    row = layers_of(problem, "bottom")
    assert row.thickness == pytest.approx(0.2)
    assert row.growth == pytest.approx(1.3, rel=0.05)


@pytest.mark.parametrize("ends", ["follow", "taper"])
def test_columns_that_end_as_they_have_to_are_no_cause_for_a_warning(ends):
    layers = {"on": ["bottom", "left"], "first": 0.001, "growth": 1.2, "until": "isotropic", "ends": ends}
    told = run(CHANNEL, layers).report["warnings"]
    assert not [text for text in told if "less than half" in text]
    assert not told or ends == "taper"


@pytest.mark.parametrize("x", [0.6, 1.0, 1.4])
def test_the_last_columns_follow_walls_at_45_to_135_degrees(x):
    line = {"path": [[1, 0], [x, 0.4]], "label": "line"}
    domain = {"outer": {"rectangle": [0, 0, 2, 1], "label": "far"}, "lines": [line]}
    problem = prepared(domain, {"on": "line", "first": 0.0005, "count": 10}, spacing=0.05)
    assert not problem.rest.strips.columns.ends.any()


def test_a_note_on_columns_that_end_before_names_no_key_that_the_case_does_not_have():
    line = {"path": [[1, 0], [1.4, 0.1]], "label": "line"}
    domain = {"outer": {"rectangle": [0.5, 0, 1.9, 0.5], "label": "far"}, "lines": [line]}
    warnings = run(domain, {"on": "line", "first": 0.0005, "count": 10}, spacing=0.05).report["warnings"]
    (text,) = (text for text in warnings if "times as high" in text)
    assert "or they end one by one at an end of the wall" in text
    assert "taper" not in text


def test_layers_that_end_long_before_they_are_isotropic_are_told():
    """A short wall between others has too few columns for one layer fewer from column to column."""
    step = {"outer": {"polygon": [[0, 1], [1, 1], [1, 0.5], [4, 0.5], [4, 2], [0, 2]], "labels": ["a", "w", *"abcd"]}}
    layers = {"on": "w", "first": 1e-6, "growth": 1.3, "until": "isotropic", "ends": "taper"}
    (text,) = (text for text in run(step, layers).report["warnings"] if "times as high" in text)
    assert "since columns end before they are as high as wide" in text


def test_with_a_thickness_no_count_is_advised_since_layers_would_be_thinner():
    result = run(CHANNEL, {"on": "bottom", "first": 0.002, "thickness": 0.02})
    (text,) = (text for text in result.report["warnings"] if "times as high" in text)
    assert "first with until: isotropic, in place of thickness" in text
    assert "count" not in text


def test_the_count_that_is_advised_lets_sizes_pass():
    keys = {"on": "bottom", "first": 0.002, "growth": 1.2}
    (text,) = (text for text in run(CHANNEL, {**keys, "count": 9}).report["warnings"] if "times as high" in text)
    count = int(text.split("count: ")[1].split()[0])
    result = run(CHANNEL, {**keys, "count": count})
    assert not [text for text in result.report["warnings"] if "times as high" in text]
    assert row_of(result, "bottom")["complete"] == 1


@pytest.mark.parametrize(("first", "growth", "count"), sweep([(0.004, 1.15, 6), (0.02, 1.25, 1), (0.001, 1.3, 4)], 1))
def test_the_count_that_is_advised_is_enough_around_a_body(first, growth, count):
    body = {"rectangle": [0.5, 0.4, 1.7, 1.6], "label": "body"}
    domain = {"outer": {"rectangle": [-0.5, -0.6, 2.7, 2.6], "label": "far"}, "holes": [body]}
    keys = {"on": "body", "first": first, "growth": growth}
    (text,) = (text for text in run(domain, {**keys, "count": count}).report["warnings"] if "times as high" in text)
    advised = int(text.split("count: ")[1].split()[0])
    result = run(domain, {**keys, "count": advised})
    assert not [text for text in result.report["warnings"] if "times as high" in text]


def test_the_packing_above_layers_settles_soon_at_the_number_of_nodes_that_the_spacing_asks_for():
    domain = {"outer": {"rectangle": [0, 0, 1.2, 0.41], "label": "wall"}}
    spacing, layers = "min(0.004 + 0.1*hypot(x - 0.2, y - 0.2), 0.012)", {"first": 4e-4, "until": "isotropic"}
    result = run(domain, {"on": "wall", **layers}, spacing=spacing)
    expected = prepared(domain, {"on": "wall", **layers}, spacing=spacing).expected_nodes
    assert len(result.mesh.points) == pytest.approx(expected, rel=0.015)
    assert len(result.report["rounds"]) <= 7


def test_thin_cells_of_fans_do_not_hide_that_sizes_jump_at_the_walls():
    body = {"rectangle": [0.5, 0.4, 0.9, 0.6], "label": "body"}
    domain = {"outer": {"rectangle": [0.2, 0.1, 1.2, 0.9], "label": "far"}, "holes": [body]}
    result = run(domain, {"on": "body", "first": 0.0016, "count": 2}, spacing=0.08)
    assert row_of(result, "body")["across_front"] > 10
    assert any("times as high" in text for text in result.report["warnings"])


def test_no_count_is_advised_that_a_case_may_not_have():
    box = {"outer": {"rectangle": [0, 0, 0.5, 0.5], "labels": SIDES}}
    keys = {"on": "bottom", "first": 1e-7, "growth": 1.01, "count": 500}
    (text,) = (text for text in run(box, keys).report["warnings"] if "times as high" in text)
    assert text.endswith(": until: isotropic lets sizes pass without a jump")


def test_no_count_is_advised_where_there_is_no_room_for_more_layers():
    slot = {"outer": {"rectangle": [0, 0, 3, 0.03], "labels": ["wall", "out", "wall", "in"]}}
    result = run(slot, {"on": "wall", "first": 0.0004, "growth": 1.25, "count": 12}, spacing=0.06)
    (text,) = (text for text in result.report["warnings"] if "times as high" in text)
    assert "since columns end before they have all layers: something is in their way, or" in text
    assert "count" not in text
    assert "isotropic" not in text


def test_the_largest_jump_is_told_with_its_place(capsys):
    layers = {"on": "bottom", "first": 0.004, "growth": 1.3, "until": "isotropic", "ends": "taper"}
    result = run(CHANNEL, layers, spacing=0.1)
    row = row_of(result, "bottom")
    assert row["across_front"] < 2 < 10 < row["farthest"]["ratio"]
    x, _ = row["farthest"]["at"]
    assert min(x, 4 - x) < 0.3  # where layers end one by one
    show_quality(result.report, console.terminal)
    assert "(up to" in "".join(capsys.readouterr())


@pytest.mark.parametrize(("first", "layers"), [(0.025, 2), (0.026, 2), (0.033, 1), (0.05, 1)])
def test_equal_corners_have_equally_many_layers_whatever_the_first_height(first, layers):
    room = {"outer": {"rectangle": [-1, -1, 1, 1], "label": "wall"}}
    strips = prepared(room, {"on": "wall", "first": first, "until": "isotropic"}, spacing=0.05).rest.strips
    corners = (np.abs(strips.columns.at) == 1).all(axis=1)
    assert set(strips.heights.count[corners].tolist()) == {layers}


@pytest.mark.parametrize(
    ("width", "advice"),
    [
        (0.06, ", and there is no room for more of them: a finer spacing lets sizes pass"),
        (0.07, ": until: isotropic, or count: 9, for which most columns have room, lessens that; a finer spacing lets"),
        (2, ": until: isotropic, or count: 22 lets sizes pass without a jump"),
    ],
)
def test_of_the_layers_that_let_sizes_pass_as_many_are_advised_as_walls_across_leave_room_for(width, advice):
    domain = {"outer": {"rectangle": [0, 0, 1, width], "labels": ["wall", "out", "wall", "in"]}}
    result = run(domain, {"on": "wall", "first": 0.001, "count": 8}, spacing=0.05)
    (text,) = (text for text in result.report["warnings"] if "times as high" in text)
    assert advice in text


def test_columns_of_more_layers_have_the_room_that_they_turn_to_in_corners():
    domain, keys = {"outer": {"rectangle": [0, 0, 2, 1], "label": "wall"}}, {"on": "wall", "first": 0.002}
    row = row_of(run(domain, {**keys, "count": 5}, spacing=0.05), "wall")
    assert (row["advised"], row["fitting"]) == (18, 18)
    assert layers_of(prepared(domain, {**keys, "count": 18}, spacing=0.05), "wall").complete > 0.5


def test_a_first_layer_as_high_as_the_spacing_is_there_all_along():
    problem = prepared(CHANNEL, {"on": "bottom", "first": 0.1, "growth": 1.2, "until": "isotropic", "ends": "taper"})
    row = layers_of(problem, "bottom")
    assert row.count["least"] == 0  # at the ends alone
    assert row.complete == pytest.approx(39 / 41)


@pytest.mark.parametrize("periodic", [False, True])
def test_above_walls_at_two_angles_to_one_that_columns_follow_no_first_layer_is_higher_than_asked_for(periodic):
    outline = {"polygon": [[0, 0.5], [1, 0], [2, 0], [2, 1.5], [1, 1.5], [0, 2]], "labels": ["w", "w", *"rttl"]}
    line = {"path": [[1, 0], [1, 1]], "label": "line"}
    domain = {"outer": outline, "periodic": [["l", "r"]]} if periodic else {"outer": outline, "lines": [line]}
    first = layers_of(prepared(domain, {"on": "w", **FIVE}), "w").first
    assert first["least"] == pytest.approx(2 / 5**0.5)
    assert first["largest"] == pytest.approx(1)


@pytest.mark.parametrize("cut", sweep([1e-6, 1e-4, 1e-3, 4e-3], quick=2))
def test_a_chamfer_takes_no_layers_away(cut):
    """Columns of its two fans part, however near to each other they stand."""
    corners = [[1, 0.5], [2 - cut, 0.5], [2, 0.5 + cut], [2, 1.5], [1, 1.5]]
    domain = {"outer": {"rectangle": [0, 0, 4, 2], "label": "far"}, "holes": [{"polygon": corners, "label": "hole"}]}
    row = layers_of(prepared(domain, {"on": "hole", "first": 0.005, "count": 8}), "hole")
    assert row.count == {"wanted": 8, "least": 8, "most": 8}
    assert (row.complete, row.compressed, row.first["kept"]) == (1, 1, 1)


@pytest.mark.parametrize("raised", [1e-6, 1e-3, 0.05])
def test_a_vertex_close_to_another_one_on_a_plain_wall_takes_no_layers_away(raised):
    """Whether the wall is straight, or bent a little there."""
    floor = [[0, 0], [1, 0], [1.001, 0], [2, raised]]
    outer = {"polygon": [*floor, [2, 1], [0, 1]], "labels": ["floor"] * 3 + ["far"] * 3}
    row = layers_of(prepared({"outer": outer}, {"on": "floor", "first": 0.01, "count": 8}, spacing=0.05), "floor")
    assert row.count["least"] >= 5
    assert (row.compressed, row.first["kept"]) == (1, 1)


@pytest.mark.parametrize("length", [1e-5, 0.0015, 0.0029, 0.0031, 0.01, 0.03])
@pytest.mark.parametrize("slope", sweep([0, 0.15, -0.15], quick=1))
def test_a_short_edge_on_a_straight_wall_is_below_layers_as_high_as_it_is_long(length, slope):
    """Its columns become one, and the nodes beside are as far apart as those of the whole wall."""

    def layers_with(*between):
        outer = {
            "polygon": [[0, 0], *between, [1, 0], [1, 0.6], [0, 0.6]],
            "labels": ["w"] * (1 + len(between)) + SIDES[1:],
        }
        spacing = {"value": 0.1, "labels": {"w": 0.04}, "growth": 0.2}
        return prepared({"outer": outer}, {"on": "w", "first": 0.001, "until": "isotropic"}, spacing=spacing)

    problem, plain = layers_with([0.5, 0], [0.5 + length, slope * length]), layers_with()
    row, whole = layers_of(problem, "w"), layers_of(plain, "w")
    assert (row.count["least"], row.columns) == (21, whole.columns)
    assert row.first["kept"] > 0.99 if slope == 0 else row.first["kept"] > 0.9
    front, other = (shortest_front(one.rest.strips) for one in (problem, plain))
    assert front > 0.6 * other
    assert problem.warnings == ()


def shortest_front(strips):
    ends = strips.x[strips.fronts[strips.top[strips.columns.pair[:, 0]] != strips.top[strips.columns.pair[:, 1]]]]
    return np.hypot(*np.diff(ends, axis=1)[:, 0].T).min()


def test_a_side_between_longer_ones_has_columns_of_its_own_up_to_the_front():
    places = [[0, 0], [0.4, 0], [0.6, 0], [1, 0]]
    outer = {"polygon": [*places, [1, 0.6], [0, 0.6]], "labels": ["w"] * 3 + SIDES[1:]}
    problem = prepared({"outer": outer}, {"on": "w", "first": 0.001, "until": "isotropic"}, spacing=0.04)
    assert layers_of(problem, "w").count["least"] == 21
    assert not problem.rest.strips.columns.pinch.any()


@pytest.mark.parametrize(("up", "along"), sweep([(3e-4, 0), (-3e-4, 0), (1e-5, 0), (9e-4, 0), (-4e-4, 3e-4)], quick=3))
def test_a_step_lower_than_the_first_layer_takes_no_layers_away(up, along):
    outer = {
        "polygon": [[0, 0], [0.5, 0], [0.5 + along, up], [1, up], [1, 0.6], [0, 0.6]],
        "labels": ["w"] * 3 + SIDES[1:],
    }
    spacing = {"value": 0.1, "labels": {"w": 0.04}, "growth": 0.2}
    result = run({"outer": outer}, {"on": "w", "first": 0.001, "until": "isotropic"}, spacing=spacing)
    row = row_of(result, "w")
    assert (row["count"]["least"], row["complete"]) == (21, 1)
    assert row["first"]["kept"] > 0.9
    assert row["angle_max"]["degrees"] < 155
    assert result.report["warnings"] == []


def test_a_step_about_as_high_as_the_first_layer_is_told_with_its_remedy():
    outer = {
        "polygon": [[0, 0], [0.5, 0], [0.5, 0.002], [1, 0.002], [1, 0.6], [0, 0.6]],
        "labels": ["w"] * 3 + SIDES[1:],
    }
    problem = prepared({"outer": outer}, {"on": "w", "first": 0.001, "until": "isotropic"}, spacing=0.04)
    (warning,) = problem.warnings
    assert "beside an edge that is shorter than 3 first heights: simplify, beside what is drawn" in warning


@pytest.mark.parametrize("width", [2e-4, 1e-3])
def test_a_groove_below_a_first_layer_that_no_node_is_above_leaves_a_sound_mesh(width):
    groove = [[0.5, 0], [0.5, -3e-4], [0.5 + width, -3e-4], [0.5 + width, 0]]
    outer = {"polygon": [[0, 0], *groove, [1, 0], [1, 0.6], [0, 0.6]], "labels": ["w"] * 5 + SIDES[1:]}
    run({"outer": outer}, {"on": "w", "first": 0.001, "count": 4}, spacing=0.1)


def shortest_edge_beside_layers(result):
    mesh, packed = result.mesh, result.fields["layer"] == 0
    edges, _ = unique_edges(mesh.triangles[packed])
    return np.hypot(*(mesh.points[edges[:, 0]] - mesh.points[edges[:, 1]]).T).min()


BAR = [[1, 0.4], [1.3, 0.4], [1.3, 0.6], [1, 0.6]]


def chamfered(cut):
    return {"polygon": [*BAR[:2], [1.3, 0.6 - cut], [1.3 - cut, 0.6], BAR[3]], "label": "bar"}


def rounded(radius):
    arc = {"to": [1.3 - radius, 0.6], "center": [1.3 - radius, 0.6 - radius], "turn": "left"}
    return {"path": [*BAR[:2], [1.3, 0.6 - radius], {"arc": arc}, BAR[3]], "label": "bar"}


@pytest.mark.parametrize(
    "hole",
    sweep([shape(size) for shape in (chamfered, rounded) for size in (1e-4, 1e-3, 1.2e-3)], quick=3),
)
def test_columns_part_evenly_around_small_chamfers_and_fillets(hole):
    """However thick the layers are: what is on them is as coarse as on those around a sharp corner."""
    layers = {"on": "bar", "first": 0.004, "until": "isotropic"}
    outer = {"rectangle": [0.5, 0, 1.8, 1], "label": "far"}
    sharp = run({"outer": outer, "holes": [{"polygon": BAR, "label": "bar"}]}, layers, spacing=0.08)
    result = run({"outer": outer, "holes": [hole]}, layers, spacing=0.08)
    assert shortest_edge_beside_layers(result) > 0.6 * shortest_edge_beside_layers(sharp)
    assert result.report["nodes"] < 1.06 * sharp.report["nodes"]
    assert row_of(result, "bar")["count"] == row_of(sharp, "bar")["count"]
    assert row_of(result, "bar")["first"]["kept"] == 1
    assert result.report["warnings"] == sharp.report["warnings"] == []


@pytest.mark.parametrize("radius", [1e-4, 1e-3, 1.2e-3])
def test_small_fillets_at_concave_corners_are_as_corners_also_if_they_are_arcs(radius):
    problem = prepared(inner_fillet(radius), {"on": "wall", "first": 0.004, "until": "isotropic"}, spacing=0.08)
    row = layers_of(problem, "wall")
    assert row.count["least"] >= 10
    assert row.first["kept"] == 1
    assert problem.warnings == ()


def inner_fillet(radius):
    arc = {"to": [3 - radius, 1], "center": [3 - radius, 1 - radius], "turn": "left"}
    return {"outer": {"path": [[0, 0], [3, 0], [3, 1 - radius], {"arc": arc}, [0, 1]], "label": "wall"}}


@pytest.mark.parametrize(
    ("radius", "heights"), sweep(product([1.5e-3, 3e-3, 5e-3], [{"count": 8}, {"until": "isotropic"}]), quick=3)
)
def test_fillets_of_a_radius_about_the_first_height_are_as_corners(radius, heights):
    layers = {"on": "wall", "first": 0.004, **heights}
    rows = [layers_of(prepared(inner_fillet(r), layers, spacing=0.08), "wall") for r in (0.0001, radius)]
    assert rows[0].count == rows[1].count
    assert (rows[1].compressed, rows[1].first["kept"]) == (1, pytest.approx(1))


@pytest.mark.parametrize(
    ("hole", "rule"),
    [(chamfered(1e-3), {"growth": 0.2}), (rounded(1e-3), {"growth": 0.2}), (rounded(1e-3), {"per_circle": 24})],
)
def test_rules_of_the_spacing_make_nothing_finer_at_edges_hidden_below_layers(hole, rule):
    domain = {"outer": {"rectangle": [0.5, 0, 1.8, 1], "label": "far"}, "holes": [hole]}
    layers = {"on": "bar", "first": 0.004, "until": "isotropic"}
    problems = [prepared(domain, layers, spacing=spacing) for spacing in (0.08, {"value": 0.08, **rule})]
    nodes, same = (problem.rest.strips.x for problem in problems)
    np.testing.assert_array_equal(nodes, same)


def test_a_wall_whose_edges_are_all_as_corners_has_no_first_heights(capsys):
    cut = 0.0099
    corners = [[0, 0], [2, 0], [2, 2 - cut], [2 - cut, 2], [0, 2]]
    domain = {"outer": {"polygon": corners, "labels": ["w", "w", "chamfer", "w", "w"]}}
    result = run(domain, {"on": ["w", "chamfer"], "first": 0.03, "count": 2}, spacing=0.2)
    row = row_of(result, "chamfer")
    assert row["first"] == {}
    assert row_of(result, "w")["first"]["kept"] == pytest.approx(1)
    show_quality(result.report, console.terminal)
    (line,) = (line for line in "".join(capsys.readouterr()).splitlines() if "chamfer:" in line)
    assert "first" not in line
    assert "aspect" not in line


L_SHAPE = np.array([[1, 0.5], [2.5, 0.5], [2.5, 1], [1.8, 1], [1.8, 1.6], [1, 1.6]])


def filleted(corners, radius, edges):
    """A ring of straight sides whose corners are rounded off by so many edges."""
    points = []
    for before, corner, after in zip(np.roll(corners, 1, axis=0), corners, np.roll(corners, -1, axis=0), strict=True):
        back, ahead = ((end - corner) / np.hypot(*(end - corner)) for end in (before, after))
        center = corner + radius * (back + ahead)  # of right angles
        begin, end = -ahead, -back
        turn = np.pi / 2 * np.arange(edges + 1)[:, None] / edges
        points.append(center + radius * (np.cos(turn) * begin + np.sin(turn) * end))
    return np.concatenate(points).tolist()


@pytest.mark.parametrize(
    ("edges", "radius"),
    sweep([(1, 1e-5), (1, 1e-3), (2, 1e-3), (2, 1e-5), (5, 1e-5), (5, 1e-3)], quick=3),
)
@pytest.mark.parametrize("inside", [True, False])
def test_fillets_far_smaller_than_the_first_layer_are_as_corners(radius, edges, inside):
    """One column stands on all nodes of a concave one; convex ones have fans."""
    ring = {"polygon": filleted(L_SHAPE, radius, edges), "label": "wall"}
    domain = (
        {"outer": ring} if inside else {"outer": {"rectangle": [0.7, 0.2, 2.8, 1.9], "label": "far"}, "holes": [ring]}
    )
    result = run(domain, {"on": "wall", "first": 0.004, "count": 8, "cells": "quads"}, spacing=0.08)
    row = row_of(result, "wall")
    assert row["count"] == {"wanted": 8, "least": 8, "most": 8}
    assert (row["complete"], row["compressed"], row["first"]["kept"]) == (1, 1, 1)
    assert row["first"]["least"] > 0.98  # on the edge of a chamfer itself
    assert not [text for text in result.report["warnings"] if "shorter than the spacing" in text]


def test_corners_across_from_each_other_have_equally_many_layers():
    tee = [[0, 0], [4, 0], [4, 1], [2.3, 1], [2.3, 3], [1.7, 3], [1.7, 1], [0, 1]]
    domain = {"outer": {"polygon": tee, "labels": ["wall", "out", "wall", "wall", "up", "wall", "wall", "in"]}}
    strips = prepared(domain, {"on": "wall", "first": 0.004, "until": "isotropic"}, spacing=0.08).rest.strips
    columns = strips.columns
    corners = [np.hypot(*(columns.start - at).T) < 1e-9 for at in ((1.7, 1), (2.3, 1))]
    assert [set(strips.heights.count[corner].tolist()) for corner in corners] == [{14}, {14}]


def test_a_corner_at_which_a_ring_begins_has_the_layers_of_its_other_corners():
    square = {"polygon": [[0, 0], [0, 0.5], [0.5, 0.5], [0.5, 0]], "label": "body"}
    domain = {"outer": {"rectangle": [-1, -1, 2, 2], "label": "far"}, "holes": [square]}
    # Edges of the wall are shorter than three first heights.
    strips = prepared(domain, {"on": "body", "first": 0.02, "until": "isotropic"}, spacing=0.05).rest.strips
    assert (strips.heights.count == 6).all()


@pytest.mark.parametrize("edges", [1, 2, 5])
def test_layers_go_on_until_they_are_isotropic_beside_small_fillets(edges):
    ring = {"polygon": filleted(L_SHAPE, 2e-3, edges), "label": "wall"}
    domain = {"outer": {"rectangle": [0, 0, 4, 2], "label": "far"}, "holes": [ring]}
    row = layers_of(
        prepared(domain, {"on": "wall", "first": 0.006, "growth": 1.3, "until": "isotropic"}, spacing=0.08), "wall"
    )
    assert row.first["kept"] == 1
    assert row.compressed == 1
    assert row.count["least"] >= 7


@pytest.mark.parametrize(("edges", "length"), sweep([(1, 1.4), (2, 0.8), (3, 0.6), (8, 1), (8, 1.4)], quick=3))
def test_layers_go_around_convex_fillets_whose_edges_are_about_as_long_as_the_first_height(edges, length):
    box = np.array([[1, 0.5], [2.5, 0.5], [2.5, 1.6], [1, 1.6]])
    ring = {"polygon": filleted(box, 0.004 * length / (2 * np.sin(np.pi / 4 / edges)), edges), "label": "wall"}
    domain = {"outer": {"rectangle": [0, 0, 4, 2], "label": "far"}, "holes": [ring]}
    layers = {"on": "wall", "first": 0.004, "count": 8}
    row = layers_of(prepared(domain, layers, spacing={"value": 0.08, "growth": 0.2}), "wall")
    assert row.count["least"] == 8
    assert (row.complete, row.compressed, row.first["kept"]) == (1, 1, 1)


@pytest.mark.parametrize(
    ("edges", "length"),
    sweep([(1, 1.4), (2, 0.8), (3, 1), (12, 0.33), (12, 0.5), (8, 1), (8, 1.4), (8, 2.5), (16, 1)], quick=5),
)
def test_layers_go_around_concave_fillets_whose_edges_are_about_as_long_as_the_first_height(edges, length):
    """As around a corner, in which the columns of the fillet are one, from the first layer on or above."""
    radius = 0.004 * length / (2 * np.sin(np.pi / 4 / edges))
    domain = {"outer": {"polygon": filleted(L_SHAPE, radius, edges), "label": "wall"}}
    layers = {"on": "wall", "first": 0.004, "count": 8}
    row = layers_of(prepared(domain, layers, spacing={"value": 0.08, "growth": 0.2}), "wall")
    assert row.count["least"] == 8
    assert (row.compressed, row.first["kept"]) == (1, 1)


@pytest.mark.parametrize("keys", [{}, {"cells": "quads"}, {"output": {"order": 2}}])
def test_columns_of_a_fillet_become_one_above_the_first_layers(keys):
    """Below they go up from its nodes: its radius is 5 first heights."""
    ring = filleted(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), 0.02, 8)
    layers = {"on": "wall", "first": 0.004, "count": 8, **{key: keys[key] for key in keys if key == "cells"}}
    result = run({"outer": {"polygon": ring, "label": "wall"}}, layers, spacing=0.08, output=keys.get("output", {}))
    tops = 0.004 * np.cumsum(1.2 ** np.arange(8))
    assert has_nodes(result.mesh.points, [(top, top) for top in tops[2:]])
    count = len(result.mesh.facets)
    layer = result.fields["layer"]
    assert (np.bincount(layer.astype(int))[1:3] == 2 * count).all()
    assert row_of(result, "wall")["angle_max"]["degrees"] < 140
    assert (row_of(result, "wall")["complete"], row_of(result, "wall")["first"]["kept"]) == (1, 1)


def test_on_a_wall_drawn_of_edges_below_the_first_height_layers_are_as_high_as_beside():
    floor = [[x, 0] for x in (*np.arange(0, 2, 0.1).round(3), *np.arange(2, 4, 0.02).round(3), 4)]
    domain = {"outer": {"polygon": [*floor, [4, 2], [0, 2]], "labels": ["floor"] * (len(floor) - 1) + [*"abc"]}}
    row = layers_of(prepared(domain, {"on": "floor", "first": 0.03, "until": "isotropic"}, spacing=0.1), "floor")
    assert row.count["least"] == row.count["wanted"] == 7
    assert row.complete == row.first["kept"] == 1


def test_a_column_on_several_nodes_goes_up_from_where_the_walls_would_meet():
    ring = filleted(np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]), 1e-3, 3)
    mesh = run({"outer": {"polygon": ring, "label": "wall"}}, {"on": "wall", **FIVE}, spacing=0.2).mesh
    assert has_nodes(mesh.points, [(top, top) for top in TOPS])
    wall = np.unique(mesh.facets)
    assert (np.hypot(*mesh.points[wall].T) < 2e-3).sum() == 4


@pytest.mark.parametrize(("size", "growth"), [(0.004, 0.2), (0.0051, 0.1)])
def test_beside_a_place_too_fine_for_layers_there_are_fewer_ones_but_none_compressed(size, growth):
    spacing = {"value": 0.1, "near": {"point": [2, 0], "size": size, "growth": growth}}
    row = layers_of(prepared(CHANNEL, {"on": "bottom", "first": 0.005, "count": 6}, spacing=spacing), "bottom")
    assert row.compressed == 1
    assert row.first["kept"] > 0.99
    assert row.count["least"] <= 3 < row.count["most"] == 6


def test_the_lowest_columns_are_those_with_the_fewest_layers():
    """Between two discs columns are short; wide ones are much lower than asked for also with more layers."""
    discs = [{"circle": {"center": [x, 1], "radius": 0.2}, "label": "disc"} for x in (1, 1.41)]
    spacing = {"near": {"label": "disc", "size": 0.02, "growth": 0.2}, "maximum": 0.12}
    layers = {"on": "disc", "first": 0.0008, "until": "isotropic"}
    problem = prepared({**CHANNEL, "holes": discs}, layers, spacing=spacing)
    row = layers_of(problem, "disc")
    told = [lowest["layers"] for lowest in row.shortest]
    assert told == sorted(told)
    (lack,) = row.lacks
    assert told[0] == lack.layers == row.count["least"]
    assert abs(lack.at[0] - 1.205) < 0.01
    assert any(f"the lowest of these with {row.count['least']} layers at (1." in text for text in problem.warnings)


def test_a_wall_with_edges_below_the_first_height_has_no_layers_and_is_told():
    """Edges are 4/51 long, a little less than the spacing."""
    problem = prepared(CHANNEL, {"on": "bottom", "first": 0.0786, "until": "isotropic"}, spacing=0.079)
    row = layers_of(problem, "bottom")
    assert row.count == {"wanted": 1, "least": 0, "most": 0}
    assert (row.complete, row.low) == (0, 1)
    (text,) = problem.warnings
    assert "'bottom': 100.00% of the wall has no layer, as at (0.078" in text


def test_the_share_of_a_wall_with_edges_below_the_first_height_is_told():
    spacing = "where(x > 2, 0.02, 0.1)"
    problem = prepared(CHANNEL, {"on": "bottom", "first": 0.03, "until": "isotropic"}, spacing=spacing)
    row = layers_of(problem, "bottom")
    (text,) = (text for text in problem.warnings if "layers on" in text)
    assert float(text.split("'bottom': ")[1].split("%")[0]) == pytest.approx(50, abs=1)
    assert 0.8 < row.low <= 1 - row.complete
    assert row.shortest[0]["layers"] == 0


@pytest.mark.parametrize("keys", [{"first": 0.001, "count": 12, "growth": 2}, {"first": 0.01, "count": 25}])
def test_where_layers_end_by_the_spacing_the_warning_says_so(keys):
    problem = prepared(CHANNEL, {"on": "bottom", **keys}, spacing=0.08)
    (lack,) = layers_of(problem, "bottom").lacks
    assert (lack.reason, lack.share) == ("spacing", 1)
    (text,) = problem.warnings
    assert "since no layer becomes higher than the spacing: ask for fewer layers or less growth, or make" in text


def test_columns_beside_a_place_with_a_finer_spacing_end_by_that():
    spacing = {"value": 0.1, "near": {"point": [2, 0], "size": 0.004, "growth": 0.2}}
    layers = {"on": "bottom", "first": 0.005, "count": 10, "growth": 1.3}
    (lack,) = layers_of(prepared(CHANNEL, layers, spacing=spacing), "bottom").lacks
    assert (lack.reason, lack.layers) == ("spacing", 0)
    assert lack.at == pytest.approx((2, 0), abs=0.01)


def test_columns_that_part_are_not_said_to_end_by_the_height_of_their_layers():
    wire = {"outer": {"rectangle": [-1, -1, 1, 1]}, "holes": [{"circle": {"center": [0, 0], "radius": 0.02}}]}
    wire["holes"][0]["label"] = "wire"
    problem = prepared(wire, {"on": "wire", "first": 2e-4, "growth": 1.05, "count": 100}, spacing=0.01)
    assert [lack.reason for lack in layers_of(problem, "wire").lacks] == ["others"]


def test_a_wall_whose_neighbour_has_few_layers_is_told_if_much_of_it_is_low():
    """From 4 layers on it takes 41 columns to have 45 layers, and the wall has fewer."""
    few = {"on": "left", "first": 0.004, "growth": 1.5, "count": 4}
    many = {"on": "bottom", "first": 0.001, "growth": 1.1, "until": "isotropic"}
    problem = prepared({"outer": {"rectangle": [0, 0, 3, 1], "labels": SIDES}}, many, few, spacing=0.08)
    row = layers_of(problem, "bottom")
    (lack,) = row.lacks
    assert lack.reason == "neighbours"
    assert lack.share == row.low > 0.75
    assert layers_of(problem, "left").lacks == ()
    (text,) = problem.warnings
    assert "of the columns are less than half as high as asked for" in text
    assert "since columns near them have few layers and neighbours differ by one at most" in text


@pytest.mark.parametrize("keys", [{"first": 2e-4}, {"first": 4e-4, "growth": 1.3}])
def test_columns_around_the_noses_of_a_small_body_are_not_low_beside_those_on_its_flanks(keys):
    """On the flanks layers are as high as wide; where columns part they could go on to several times that height."""
    body = {"ellipse": {"center": [0, 0], "radii": [0.075, 0.01]}, "label": "body"}
    domain = {"outer": {"rectangle": [-3, -3, 3, 3]}, "holes": [body]}
    spacing = {"near": {"label": "body", "size": 0.012, "growth": 0.2}, "maximum": 0.4}
    row = layers_of(prepared(domain, {"on": "body", "until": "isotropic", **keys}, spacing=spacing), "body")
    assert row.complete < 0.5
    assert (row.low, row.lacks) == (0, ())


LOW_FIRST = {"on": ["left", "right"], "first": 2e-4, "until": "isotropic"}
SHORT = {"outer": {"rectangle": [0, 0, 1, 0.5], "labels": SIDES}}


def test_a_wall_that_loses_its_first_height_beside_walls_with_lower_ones_is_told():
    result = run(SHORT, {"on": "bottom", "first": 0.02, "count": 2}, LOW_FIRST, spacing=0.05)
    row = row_of(result, "bottom")
    assert row["first"]["kept"] == pytest.approx(0.1)
    assert row["complete"] < 0.2
    (lack,) = row["lacks"]
    assert lack["reason"] == "first"
    assert lack["share"] == pytest.approx(0.84, abs=0.01)
    assert row["low"] == 0
    told = [text for text in result.report["warnings"] if "'bottom'" in text]
    assert "of the wall has a lower first layer than asked for, as at (0.05, 0)" in told[0]
    assert told[1].endswith("as the last layer, since first heights rise only gradually beside walls with lower ones")


STRAIGHT = {"outer": {"polygon": [[0, 0], [1, 0], [2, 0], [2, 1], [0, 1]], "labels": ["a", "b", "o", "t", "i"]}}


@pytest.mark.parametrize(("first", "growth", "count", "least"), [(4e-4, 1.2, 20, 19), (0.002, 1.1, 20, 17)])
def test_where_first_heights_differ_on_a_straight_wall_both_have_about_as_many_layers_as_asked_for(
    first, growth, count, least
):
    other = {"on": "b", "first": first, "growth": growth, "count": count}
    strips = prepared(STRAIGHT, {"on": "a", "first": 2e-4, "count": 20}, other, spacing=0.03).rest.strips
    assert strips.heights.count.min() >= least


def test_beside_a_wall_of_fewer_and_higher_layers_columns_have_one_more_from_one_to_the_next():
    other = {"on": "b", "first": 0.01, "growth": 1.1, "count": 28}
    spacing = {"value": 0.1, "labels": {"a": 0.03, "b": 0.03}, "growth": 0.2}
    problem = prepared(STRAIGHT, {"on": "a", "first": 2e-4, "until": "isotropic"}, other, spacing=spacing)
    columns, count = problem.rest.strips.columns, problem.rest.strips.heights.count
    fewest = count[columns.ladder == 1].min()
    place = columns.start[:, 0]
    along = count[(place <= 1) & (columns.start[:, 1] == 0)][
        np.argsort(place[(place <= 1) & (columns.start[:, 1] == 0)])
    ]
    assert fewest >= 10
    assert (np.diff(along)[along[1:] < 28] == -1).all()


@pytest.mark.parametrize(("first", "spacing"), [(0.004, 0.05), (2e-4, 0.0201)])
def test_nearer_first_heights_and_a_finer_spacing_keep_them(first, spacing):
    other = {**LOW_FIRST, "first": first}
    problem = prepared(SHORT, {"on": "bottom", "first": 0.02, "count": 2}, other, spacing=spacing)
    row = layers_of(problem, "bottom")
    assert row.first["kept"] > 0.5
    assert "first" not in [lack.reason for lack in row.lacks]


@pytest.mark.parametrize(
    ("keys", "advice"),
    [({"first": 0.002, "count": 4}, "or count: "), ({"first": 0.002, "thickness": 0.02}, "in place of thickness")],
)
def test_an_estimate_tells_about_how_high_triangles_are_beside_layers(keys, advice):
    wall = {"on": "bottom", **keys}
    figures = estimate(prepared(SHORT, wall, spacing=0.05))
    (row,) = figures["layers"]
    found = row_of(run(SHORT, wall, spacing=0.05), "bottom")
    assert row["across_front"] == pytest.approx(found["across_front"], rel=0.2)
    (told,) = figures["warnings"]
    assert f"triangles beside them are about {row['across_front']:.3g} times as high as the last layer: " in told
    assert advice in told


def test_an_estimate_tells_no_jump_where_sizes_pass():
    figures = estimate(prepared(SHORT, {"on": "bottom", "first": 0.002, "until": "isotropic"}, spacing=0.05))
    assert figures["layers"][0]["across_front"] == pytest.approx(1, abs=0.3)
    assert figures["warnings"] == []


def test_the_advised_number_of_layers_is_one_that_most_columns_have_beside_a_wall_with_few():
    few, wall = {"on": ["left", "right"], "first": 0.004, "count": 1}, {"on": "bottom", "first": 0.004, "count": 2}
    row = row_of(run(SHORT, wall, few, spacing=0.05), "bottom")
    assert 2 < row["fitting"] < row["advised"]
    strips = prepared(SHORT, {**wall, "count": row["fitting"]}, few, spacing=0.05).rest.strips
    counts = strips.heights.count[strips.columns.ladder == 0]
    assert np.mean(counts >= row["fitting"]) >= 0.5


def test_few_columns_beside_a_neighbour_with_few_layers_are_not_told():
    few = {"on": "left", "first": 0.004, "growth": 1.5, "count": 4}
    many = {"on": "bottom", "first": 0.002, "growth": 1.3, "until": "isotropic"}
    problem = prepared(CHANNEL, many, few, spacing=0.08)
    assert 0 < layers_of(problem, "bottom").low < 0.25
    assert problem.warnings == ()


@pytest.mark.parametrize(("first", "growth", "told"), [(0.001, 1.2, False), (0.0004, 1.1, True)])
def test_columns_that_part_are_complete_and_warned_of_above_ten(first, growth, told):
    """Columns on a disc of the spacing's radius end where they would be twice as far apart as the spacing."""
    wire = {"circle": {"center": [0, 0], "radius": 0.1}, "label": "wire"}
    domain = {"outer": {"rectangle": [-1, -1, 1, 1]}, "holes": [wire]}
    result = run(domain, {"on": "wire", "first": first, "growth": growth, "until": "isotropic"})
    row = row_of(result, "wire")
    assert row["complete"] == 1
    assert row["across_front"] > 1.5
    assert (row["across_front"] > 10) == told
    assert any("times as high" in text for text in result.report["warnings"]) == told


def test_each_place_is_told_once_among_the_lowest_columns():
    """All columns of the fan at a corner near a wall are short."""
    box = {"polygon": [[2, 0.02], [3, 1], [2, 1.9], [1, 1]], "label": "box"}
    row = layers_of(prepared({**CHANNEL, "holes": [box]}, {"on": "box", **FIVE}, spacing=0.1), "box")
    places = [lowest["at"] for lowest in row.shortest]
    assert (2, 0.02) in places
    assert len(places) == len(set(places)) > 1


@pytest.mark.parametrize("seed", sweep(range(3), quick=1))
def test_on_a_shore_that_is_rough_between_its_nodes_first_heights_are_kept(seed):
    """A ring of thousands of short edges that turn to and fro by some degrees."""
    random, count = np.random.default_rng(seed), 4000
    angle = 2 * np.pi * np.arange(count) / count
    radius = 1000 * (1 + 0.1 * np.sin(3 * angle)) + 0.1 * random.standard_normal(count)
    ring = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]).tolist()
    box = {"outer": {"rectangle": [-2000, -2000, 2000, 2000], "label": "sea"}}
    island = {"polygon": ring, "corners": 30, "label": "shore"}
    row = layers_of(prepared({**box, "holes": [island]}, {"on": "shore", "first": 1, "count": 8}, spacing=60), "shore")
    assert row.first["kept"] > 0.99


@pytest.mark.parametrize("spacing", [0.6, 0.7, 0.8])
def test_a_curve_with_few_nodes_has_no_fans(spacing):
    disc = {"circle": {"center": [0, 0], "radius": 1}, "label": "disc"}
    domain = {"outer": {"rectangle": [-4, -4, 4, 4], "label": "far"}, "holes": [disc]}
    row = layers_of(prepared(domain, {"on": "disc", "first": 1e-4, "count": 5}, spacing=spacing), "disc")
    assert row.columns == round(2 * np.pi / spacing)
    assert row.first["kept"] == 1


def test_a_label_named_twice_is_refused():
    with pytest.raises(CaseError, match=r"layers\.0\.on: 'bottom' is named twice"):
        prepared(CHANNEL, {"on": ["bottom", "bottom"], "first": 0.01, "count": 2}, spacing=0.1)


def test_a_first_layer_below_what_numbers_far_from_the_origin_hold_is_refused():
    far = {"outer": {"rectangle": [1e6, 1e6, 1e6 + 4, 1e6 + 4], "labels": SIDES}}
    with pytest.raises(CaseError, match=r"beside coordinates up to 1e.*by move beside each ring"):
        prepared(far, {"on": "bottom", "first": 4.1e-10, "count": 5}, spacing=0.1)
    run(far, {"on": "bottom", "first": 1e-6, "count": 5}, spacing=0.5)


def test_layers_in_a_slot_are_compressed_and_told():
    slot = {"outer": {"rectangle": [0, 0, 4, 0.02], "labels": SIDES}}
    problem = prepared(slot, {"on": ["bottom", "top"], "first": 0.01, "count": 6}, spacing={"value": 0.1, "across": 0})
    row = layers_of(problem, "bottom")
    assert row.compressed < 0.5
    assert row.complete == 0
    (text,) = [text for text in problem.warnings if "'bottom'" in text and "less than half" in text]
    assert "compressed to 0." in text


def test_beside_a_gap_layers_are_compressed_along_few_edges_only():
    baffle = {"path": [[1, 0.01], [1, 0.6]], "label": "baffle"}
    domain = {"outer": {"rectangle": [0, 0, 2, 1], "label": "far"}, "lines": [baffle]}
    problem = prepared(domain, {"on": "baffle", "first": 0.004, "count": 8}, spacing=0.05)
    columns, factor = problem.rest.strips.columns, problem.rest.strips.heights.factor
    low, high = np.sort(factor[columns.pair], axis=1).T
    assert factor.min() < 0.5
    assert (high <= 1.7 * low * (1 + 1e-12)).all()
    assert columns.at[factor < 1, 1].max() < 0.07  # the second node above the tip


CROSS = {
    "outer": {"rectangle": [0, 0, 2, 1], "label": "far"},
    "lines": [{"path": [[0.5, y], [1.5, 1 - y]], "label": "wall"} for y in (0.4, 0.6)],
}
SPIKE = {"outer": {"polygon": [[-1, 0], [-0.08, 0], [0, -0.9], [0.08, 0], [1, 0], [1, 1], [-1, 1]], "label": "wall"}}
CHANNEL_OF_SHORT_WAYS = {"outer": {"rectangle": [0, 0, 1, 0.032], "labels": ["wall", "out", "wall", "in"]}}


@pytest.mark.parametrize(
    ("domain", "first", "least"), [(CROSS, 0.002, 0.5), (SPIKE, 0.002, 0.25), (CHANNEL_OF_SHORT_WAYS, 0.001, 0.6)]
)
def test_layers_leave_room_for_triangles_as_high_as_edges_allow(domain, first, least):
    result = run(domain, {"on": "wall", "first": first, "until": "isotropic"}, spacing=0.05, packing={})
    assert result.report["quality"]["min"] > least
    assert row_of(result, "wall")["first"]["mean"] > 0.9


def test_sizes_that_jump_are_told_with_the_count_that_lets_them_pass():
    result = run(CHANNEL, {"on": "bottom", "first": 0.001, "growth": 1.2, "count": 4})
    (text,) = [text for text in result.report["warnings"] if "times as high as the last" in text]
    count = int(text.split("count: ")[1].split()[0])
    again = run(CHANNEL, {"on": "bottom", "first": 0.001, "growth": 1.2, "count": count})
    assert row_of(again, "bottom")["across_front"] < 1.5
    assert again.report["warnings"] == []


def test_the_report_tells_the_quality_of_what_is_packed():
    result = run(CHANNEL, {"on": "bottom", **FIVE})
    assert result.report["quality"]["min"] > 0.5 > result.mesh.quality().min
    assert result.report["nodes"] == len(result.mesh.points)
    assert "quality_min" not in json.dumps(result.report["warnings"])


def test_a_number_of_nodes_counts_those_of_layers():
    result = run(CHANNEL, {"on": "bottom", **FIVE}, spacing={"value": 0.1, "nodes": 1500})
    assert len(result.mesh.points) == pytest.approx(1500, rel=0.02)


def test_python_programs_ask_for_layers_as_cases_do():
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    mesh = bubblemesh.mesh(
        square, 0.1, layers=[{"on": "outer", "first": 0.02, "count": 3, "growth": 1.5}], effort="fast"
    )
    check(mesh)
    assert has_nodes(mesh.points, [(0.02, 0.02), (0.05, 0.05), (0.095, 0.095)])
    with pytest.raises(CaseError, match=r"mesh\(\): layers.0.on: there is no side or line 'wall': allowed: outer"):
        bubblemesh.mesh(square, 0.1, layers=[{"on": "wall", "first": 0.02, "count": 3}])


@pytest.mark.parametrize(
    ("entries", "keys", "kind", "message"),
    [
        (
            [{"on": "botom", **FIVE}],
            {},
            CaseError,
            "layers.0.on: there is no side or line 'botom': did you mean 'bottom'",
        ),
        (
            [{"on": "bottom", "first": 0.1}],
            {},
            CaseError,
            "must have two of first, count and thickness, or first and until",
        ),
        (
            [{"on": "bottom", "first": 0.1, "count": 3, "thickness": 1}],
            {},
            CaseError,
            "must have two of first, count and thickness",
        ),
        ([{"on": "bottom", "first": 0.01, "until": "isotropic", "growth": 1}], {}, CaseError, "needs a growth above 1"),
        ([{"on": "bottom", "count": 4, "until": "isotropic"}], {}, CaseError, "until: isotropic goes with first"),
        ([{"on": "bottom", "first": 0.2, "thickness": 0.1}], {}, CaseError, "must not be higher than all of them"),
        ([{"on": "bottom", **FIVE, "growth": 0.9}], {}, CaseError, "growth: must be at least 1"),
        ([{"on": "bottom", **FIVE, "growth": 2.5}], {}, CaseError, "growth: must be at most 2"),
        ([{"on": "bottom", "first": 0.3, "count": 3}], {}, CaseError, "higher than the spacing across these walls"),
        ([{"on": "bottom", **FIVE}] * 2, {}, CaseError, "layers.1.on: 'bottom' has layers already, by layers.0"),
        ([{"on": "bottom", **FIVE, "region": "x"}], {}, CaseError, "layers.0.region: there is no region 'x'"),
        (
            [{"on": "bottom", **FIVE}],
            {"method": "accelerated", "packing": {}},
            CaseError,
            "layers: bubbles would slide along them",
        ),
        ([{"on": "bottom", **FIVE, "count": 300}], {"limits": {"max_nodes": 900}}, LimitError, "max_nodes"),
        ([], {}, CaseError, "layers: must have at least one entry"),
        (
            [{"on": "bottom", "first": 1e-9, "thickness": 1, "growth": 1}],
            {},
            CaseError,
            "this makes 1000000000 layers, which is too many",
        ),
        (
            [{"on": "bottom", "first": 1e-6, "growth": 1.0001, "until": "isotropic"}],
            {},
            CaseError,
            "layers, which is too many",
        ),
        ([{"on": "bottom", "count": 200, "thickness": 0.1}], {}, CaseError, "too low for numbers beside"),
    ],
)
def test_what_cannot_be_is_told_with_its_key(entries, keys, kind, message):
    with pytest.raises(kind, match=message):
        run(CHANNEL, *entries, **keys)


def test_a_periodic_side_has_layers_only_with_its_counterpart():
    with pytest.raises(CaseError, match="the sides 'left' and 'right' match: name both, or none"):
        run({**CHANNEL, "periodic": [["left", "right"]]}, {"on": "left", **FIVE})
