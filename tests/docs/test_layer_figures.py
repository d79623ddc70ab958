"""The benchmark of boundary layers measures what it says, and its page has all that it makes."""

import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from paths import ROOT

from benchmarks.layers import gradients
from benchmarks.layers.figures import Figures, measured, straight_area, wrong
from benchmarks.layers.gradients import CLOSE, FLOWS, Needed, isotropic, needed, with_layers
from benchmarks.layers.made import Made
from benchmarks.layers.page import FEWEST, page
from benchmarks.layers.runs import Run, run
from benchmarks.layers.section import Checked, Section, Written, section
from benchmarks.layers.shapes import bare, naca, shapes, thickness
from benchmarks.layers.tools import FANS, OURS, PLAIN
from benchmarks.layers.with_gmsh import COARSEST
from bubblemesh.case import load_case

PAGE = (ROOT / "docs" / "layer-figures.md").read_text()
FIRST, GROWTH, COUNT, WIDTH = 0.01, 1.5, 4, 0.25
PLATE = {
    "domain": {"outer": {"polygon": [[0, 0], [1, 0], [1, 1], [0, 1]], "label": "wall"}},
    "layers": [{"on": "wall", "first": FIRST, "growth": GROWTH, "count": COUNT}],
}


def structured(heights, lean=0.0):
    """A square in rows of the heights, and one up to its top; inner columns of its first row lean by so much."""
    rows = np.append(np.cumsum([0, *heights]), 1.0)
    columns = np.linspace(0, 1, round(1 / WIDTH) + 1)
    x, y = np.meshgrid(columns, rows)
    x[1:-1, 1:-1] += lean
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]))
    triangles = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    ring = np.concatenate([number[0, :-1], number[:-1, -1], number[-1, :0:-1], number[:0:-1, 0]])
    walls = np.column_stack([number[0, :-1], number[0, 1:]])
    return Made(np.column_stack([x.ravel(), y.ravel()]), triangles, np.column_stack([ring, np.roll(ring, -1)]), walls)


def test_figures_are_those_of_a_mesh_in_rows():
    found = measured(structured(FIRST * GROWTH ** np.arange(COUNT)), PLATE)
    assert [found.least, found.mean, found.largest] == pytest.approx([1, 1, 1])
    assert found.growth == pytest.approx(GROWTH)
    assert found.kept == found.steady == 1
    assert [found.upright, found.least_upright] == pytest.approx([90, 90])
    assert found.aspect == pytest.approx(WIDTH / FIRST)


def test_figures_tell_what_differs_from_the_requested_layers():
    other = measured(structured(2 * FIRST * 1.2 ** np.arange(COUNT), lean=FIRST), PLATE)
    assert other.mean == pytest.approx(2)
    assert other.growth == pytest.approx(1.2)
    assert other.kept == other.steady == 0
    assert other.least_upright == pytest.approx(np.degrees(np.arctan(2)), abs=0.01)


def test_a_mesh_in_rows_has_no_fault():
    assert wrong(structured([FIRST]), PLATE) == []


def test_faults_of_meshes_are_seen():
    made = structured([FIRST])
    flipped = np.concatenate([made.triangles[1:], made.triangles[:1, ::-1]])
    assert "1 triangles are flat or clockwise" in wrong(replace(made, triangles=flipped), PLATE)
    assert "1 edges of walls are not in the mesh" in wrong(replace(made, walls=np.array([[0, 2]])), PLATE)
    smaller = replace(made, points=0.5 * made.points)
    assert any("area differs from that of the domain" in fault for fault in wrong(smaller, PLATE))
    moved = made.points.copy()
    moved[np.flatnonzero((moved[:, 0] == 1) & (moved[:, 1] == FIRST)), 1] *= 1.1
    periodic = PLATE | {"domain": PLATE["domain"] | {"periodic": [["left", "right"]]}}
    assert wrong(made, periodic) == []
    assert wrong(replace(made, points=moved), periodic) == ["nodes on periodic sides differ"]


@pytest.mark.parametrize("keys", shapes().values(), ids=shapes())
def test_all_shapes_are_cases(keys):
    case = load_case("shape.yaml", text=json.dumps(keys))
    assert len(case.layers) == 1
    assert load_case("shape.yaml", text=json.dumps(bare(keys))).layers in (None, ())
    assert thickness(keys) > 5 * keys["layers"][0]["first"]


def test_areas_are_known_where_sides_are_straight():
    drawn = shapes()
    assert straight_area(drawn["backward step"]) == pytest.approx(20)
    assert straight_area(drawn["comb"]) == pytest.approx(2 * 1.5 - 8 * 0.1 * 1 + 0.1, abs=0.2)
    assert straight_area(drawn["interface"]) == pytest.approx(4)
    assert straight_area(drawn["airfoil, blunt edge"]) is None


def test_profiles_are_as_thick_as_their_digits_say():
    blunt, sharp = naca("0012"), naca("0012", sharp=True)
    assert np.ptp(blunt[:, 1]) == pytest.approx(0.12, abs=1e-3)
    assert np.hypot(*(blunt[0] - blunt[-1])) == pytest.approx(0.00252)
    assert np.allclose(sharp[0], [1, 0], atol=1e-12)
    assert np.hypot(*(sharp[0] - sharp[-1])) > 1e-4
    assert naca("4412")[:, 1].max() > 0.09


def figures_of(**others):
    rest = dict.fromkeys(("least", "mean", "largest", "kept", "steady"), 1.0)
    return Figures(**({"nodes": 100, "growth": 1.2, "upright": 90, "least_upright": 80, "aspect": 9} | rest | others))


def test_the_page_tells_who_has_valid_meshes_and_how_fast():
    ours, theirs = Run(0.3, 0.2, 0.8, figures_of()), Run(0.1, 0.05, 0.4, figures_of(nodes=90))
    failed = Run(failure="Edge not recovered")
    runs = {"gear": {OURS: ours, FANS: failed, PLAIN: theirs}, "comb": {OURS: ours, FANS: failed, PLAIN: failed}}
    flow = {FLOWS[0].name: (Needed(0.01, 100, 0.009), Needed(0.01, 450, 0.009))}
    sections = {"quads": Section(10, 2.0, Written(10, 7, {"wing": 4}, 2.0), Checked("Mesh OK", 30, 3, 0.5, 99))}
    text = page(runs, flow, sections, "Python", 3)
    assert "Valid meshes: bubblemesh 2 of 2, Gmsh 1." in text
    assert "takes 3.0 times the time of Gmsh" in text
    assert "Of whole programs that is 2.0 times (2.0 to 2.0)." in text
    assert "over all of these shapes, is 2.0 times" in text
    assert "**none**: Edge not recovered" in text
    assert "fewer nodes is **not reached**: at least 4.5 times" in text
    assert "| quads | 10 | 7 | wing: 4 | 0e+00 | Mesh OK | 30° / 3° | 0.50 | 99 |" in text
    absent = {"quads": replace(sections["quads"], openfoam=None)}
    assert "not installed here" in page(runs, flow, absent, "Python", 3)


def test_the_page_has_all_shapes_and_flows():
    for name in (*shapes(), *(flow.name for flow in FLOWS)):
        assert f"| {name} |" in PAGE, name
    assert "**none**" not in "".join(line for line in PAGE.splitlines() if "| bubblemesh |" in line)
    assert f"The goal of {FEWEST} times fewer nodes is reached" in PAGE


@pytest.mark.long
@pytest.mark.parametrize("tool", [OURS, FANS, PLAIN])
def test_a_shape_is_meshed_by_both_tools(tool):
    if tool != OURS:
        pytest.importorskip("gmsh")
    found = run("periodic sides", tool)
    assert found.failure == ""
    assert 0.95 < found.figures.mean < 1.05
    assert found.figures.growth == pytest.approx(1.2, abs=0.01)
    assert found.seconds > 0


@pytest.mark.long
def test_layers_need_a_fifth_of_the_nodes_for_the_gradient_at_the_wall():
    flow = FLOWS[-1]
    layered, even = needed(flow, with_layers), needed(flow, isotropic)
    assert max(layered.error, even.error) <= CLOSE
    assert FEWEST * layered.nodes < even.nodes


@pytest.mark.long
def test_the_error_of_the_gradient_falls_with_the_first_height(monkeypatch):
    monkeypatch.setattr(gradients, "CLOSE", 0.0)
    coarse, fine = (needed(replace(FLOWS[1], start=size), with_layers, most=1) for size in (2e-3, 1e-3))
    assert fine.error == pytest.approx(coarse.error / 2, rel=0.3)


@pytest.mark.solver
@pytest.mark.parametrize("cells", ["triangles", "quads"])
def test_a_section_is_sound_for_su2_and_openfoam(cells):
    found = section(cells, size=0.05, count=25)
    assert found.su2.nodes == found.nodes
    assert found.su2.area == pytest.approx(found.area, rel=1e-12)
    assert set(found.su2.markers) == {"far", "wing"}
    if found.openfoam is None:
        pytest.skip("no checkMesh of OpenFOAM is installed")
    assert found.openfoam.verdict == "Mesh OK"
    assert cells == "triangles" or found.openfoam.mean_orthogonality < 10


def test_a_growth_that_is_not_named_is_that_of_case_files():
    near = [term for keys in shapes().values() if isinstance(keys["spacing"], dict) for term in keys["spacing"]["near"]]
    assert COARSEST == 0.2
    assert all(term.get("growth", COARSEST) == COARSEST for term in near)


def test_a_program_of_gmsh_loads_next_to_nothing_of_ours():
    listed = "import sys, benchmarks.layers.program; print(*(name for name in sys.modules if name[:6] == 'bubble'))"
    done = subprocess.run([sys.executable, "-c", listed], cwd=ROOT, check=True, capture_output=True, text=True)
    assert set(done.stdout.split()) == {
        "bubblemesh",
        "bubblemesh.arrays",
        "bubblemesh.process",
        "bubblemesh.process.resources",
    }
