"""The page of a run: what it holds, and that it is sound."""

import base64
import dataclasses
import json
import re
import zlib

import numpy as np
import pytest
from quadrilaterals import mixed
from report_pages import CASE, FILES, NASTY, Elements, page_of
from typer.testing import CliRunner

from bubblemesh.cli import app
from bubblemesh.meshes.quality import radius_ratios, signed_areas
from bubblemesh.pages.scene import Scene, fixed_point, relative
from bubblemesh.pictures.colouring import MeshData, colouring_of


def integers(page, name):
    """An array of the page, as a reader of its format would unpack it."""
    ((_, attributes, text),) = Elements(page).named("script", id=name)
    content = zlib.decompress(base64.b64decode(text))
    width = int(attributes["data-width"])
    planes = np.frombuffer(content, np.uint8).reshape(width, -1).astype(np.int64)
    return sum(plane << (8 * rank) for rank, plane in enumerate(planes))


@pytest.mark.long
def test_the_page_holds_the_mesh(page, result):
    mesh = result.mesh
    head = json.loads(Elements(page).named("script", id="head")[0][2])
    points = integers(page, "points").reshape(2, -1).T / (2**32 - 1) * head["extent"] + head["origin"]
    assert np.abs(points - mesh.points).max() < 1e-9 * head["extent"]
    columns = integers(page, "triangles").reshape(3, -1)
    steps = np.where(columns % 2, -(columns + 1) // 2, columns // 2)
    first = np.cumsum(steps[0])
    assert np.array_equal(np.stack([first, first + steps[1], first + steps[2]], axis=1), mesh.triangles)
    q = radius_ratios(mesh.points, mesh.triangles)
    assert np.abs(integers(page, "quality") / (2**16 - 1) - q).max() < 1e-5
    size = colouring_of(mesh, MeshData(), "size")
    assert np.abs(integers(page, "size") / (2**8 - 1) - size.norm(size.values).clip(0, 1)).max() < 1 / 2**8
    assert np.array_equal(integers(page, "region"), mesh.triangle_regions)
    facets = integers(page, "facets").reshape(2, -1).T
    for k, label in enumerate(head["labels"]):
        mine = facets[label["start"] : label["start"] + label["count"]]
        assert label["name"] == mesh.labels[k]
        assert np.array_equal(mine, mesh.facets[mesh.facet_labels == k])
    assert [q[t] for t in head["worst"]] == sorted(q)[:10]
    assert [region["name"] for region in head["regions"]] == ["matrix", "fibre"]
    for region in head["regions"]:
        assert mesh.regions[mesh.triangle_regions[region["at"]]] == region["name"]
    assert head["points"] == [{"name": "well", "node": int(mesh.labelled_nodes[0])}]


def test_diagonals_of_quadrilaterals_are_told():
    mesh = mixed()
    scene = Scene.of(mesh, {"target_spacing": np.full(len(mesh.triangles), 0.3)}, 10)
    triangle, side = np.divmod(integers(str(scene.blocks()), "diagonals"), 3)
    assert np.array_equal(triangle.reshape(-1, 2), mesh.quads)
    ends = np.sort([mesh.triangles[triangle, side], mesh.triangles[triangle, (side + 1) % 3]], axis=0)
    assert np.array_equal(ends[:, ::2], ends[:, 1::2])
    plain = Scene.of(mesh.in_triangles(), {"target_spacing": np.full(len(mesh.triangles), 0.3)}, 10)
    assert len(integers(str(plain.blocks()), "diagonals")) == 0


def test_triangles_of_any_order_of_nodes_survive_the_packing():
    triangles = np.random.default_rng(0).integers(0, 5_000_000, (100, 3))
    steps = relative(triangles).astype(np.int64).T
    signed = np.where(steps % 2, -(steps + 1) // 2, steps // 2)
    first = np.cumsum(signed[0])
    assert np.array_equal(np.stack([first, first + signed[1], first + signed[2]], axis=1), triangles)
    assert fixed_point(np.array([-1, 0.0, 0.5, 1, 2]), 0, 1, np.uint16).tolist() == [0, 0, 32768, 65535, 65535]


def test_the_page_asks_nothing_of_the_network_and_runs_its_own_script_only(page):
    elements = Elements(page)
    assert not re.findall(r"https?:|//[a-z]+\.|@import|url\(", page)
    policy = elements.named("meta", **{"http-equiv": "Content-Security-Policy"})[0][1]["content"]
    assert policy.startswith("default-src 'none'; img-src data:; style-src 'sha256-")
    assert "unsafe" not in policy
    assert {img[1]["src"][:22] for img in elements.named("img")} == {"data:image/png;base64,"}
    assert {a[1]["href"] for a in elements.named("a")} == {f"./{name}" for name in FILES}
    assert len(elements.named("script", type="module")) == 1
    assert not [e for e in elements.found if any(key.startswith("on") or key == "style" for key in e[1])]


def test_the_page_tells_what_the_report_tells(page, result):
    report = result.report
    text = re.sub(r"<[^>]*>", " ", page)
    q = radius_ratios(result.mesh.points, result.mesh.triangles)
    for part in (
        f"{report['nodes']:,}",
        f"{report['quality']['mean']:.4f}",
        f"{report['spacing']['mean']:.3f}",
        "7 March 2024, 16:05",
        "seed 0",
        "1 warning",
        f"{q.min():.4f}",
        report["stop_reason"],
        *report["seconds"],
        *(f"{row['quality_mean']:.4f}" for row in report["rounds"]),
        "&quot;region&quot;: &quot;matrix&quot;",
    ):
        assert part in text, part


def tables(page):
    """Cells of each table of a page, by its caption."""
    found = re.findall(r"<caption>(.*?)</caption>(.*?)</table>", page, re.DOTALL)
    return {caption: re.findall(r"<td[^>]*>(.*?)</td>", body) for caption, body in found}


def test_regions_and_labels_have_their_areas_and_lengths(page, result):
    mesh, told = result.mesh, tables(page)
    areas = signed_areas(mesh.points, mesh.triangles)
    rows = [(name, mesh.triangle_regions == k) for k, name in enumerate(mesh.regions)]
    cells = [cell for name, mine in rows for cell in (name, f"{mine.sum():,}", f"{areas[mine].sum():.6g}")]
    assert told["Areas of regions"] == cells
    assert told["Lengths of labels"][::3] == list(mesh.labels)
    assert told["Lengths of labels"][2] == "2"


def test_motions_of_periodic_sides_are_told(result):
    turn = {"side": "a<b", "with": "c", "angle": 45.0, "center": [10.0, -3.0]}
    told = re.search(r"Periodic sides: ([^<]*)</p>", page_of(result, periodic_sides=[turn]))
    assert told[1] == "a&lt;b to c: turned by 45 degrees about (10, -3)."


def test_of_very_many_regions_the_page_shows_the_first(result):
    many = [{"name": f"grain {k}", "triangles": 1, "area": 1.0} for k in range(103)]
    page = page_of(result, regions=many)
    assert len(tables(page)["Areas of regions"]) == 300
    assert "3 more rows in the JSON report." in page


def test_names_with_markup_are_text_in_every_part_of_the_page(result):
    labels = tuple(NASTY[k % len(NASTY)] + str(k) for k in range(len(result.mesh.labels)))
    mesh = dataclasses.replace(result.mesh, labels=labels, regions=(NASTY[0], NASTY[1]), point_labels=(NASTY[2],))
    parameters = {**result.report["parameters"], "name": NASTY[0]}
    rows = {"regions": [{"name": name, "triangles": 1, "area": 1.0} for name in NASTY]}
    rows["labels"] = [{"name": name, "edges": 1, "length": 1.0} for name in NASTY]
    rows |= {"warnings": [NASTY[0], NASTY[4]], "parameters": parameters, "method": NASTY[1]}
    page = page_of(result, mesh, **rows, case=NASTY[0])
    elements = Elements(page)
    assert len(elements.named("script")) == 10
    assert not [e for e in elements.found if any(key.startswith("on") for key in e[1])]
    assert elements.named("title")[0][2].strip() == f"{NASTY[0]} - bubblemesh report"
    assert elements.named("h1")[0][2].strip() == NASTY[0]


def test_a_mesh_of_second_order_far_from_the_origin(result):
    far = dataclasses.replace(result.mesh, points=result.mesh.points + 1e9, facet_middles=np.zeros((0, 2)))
    curved, _ = far.second_order()
    page = page_of(result, curved)
    head = json.loads(Elements(page).named("script", id="head")[0][2])
    points = integers(page, "points").reshape(2, -1).T / (2**32 - 1) * head["extent"]
    assert np.abs(points - (curved.points - head["origin"])).max() < 1e-9 * head["extent"]
    assert len(integers(page, "triangles")) == 3 * len(curved.triangles)


def run(folder, *arguments):
    (folder / "a.yaml").write_text(CASE.replace("0.06", "0.1"))
    done = CliRunner().invoke(app, ["run", str(folder / "a.yaml"), *map(str, arguments)])
    return done.exit_code, done.stderr


@pytest.mark.long
def test_run_writes_the_page_with_the_other_files_and_counts_its_time(tmp_path):
    code, said = run(tmp_path, "-o", tmp_path / "out/", "--report", "--format", "msh")
    assert code == 0, said
    assert {path.name for path in (tmp_path / "out").iterdir()} == set(FILES)
    report = json.loads((tmp_path / "out/composite.report.json").read_text())
    assert sorted(report["files"]) == sorted(FILES)
    seconds = dict(report["seconds"])
    assert seconds["page"] > 0
    assert seconds.pop("total") == pytest.approx(sum(seconds.values()))
    page = Elements((tmp_path / "out/composite.html").read_text())
    assert {a[1]["href"] for a in page.named("a")} == {f"./{name}" for name in FILES}


@pytest.mark.long
@pytest.mark.parametrize(
    ("options", "written"),
    [
        (["--set", "output.report=true"], True),
        (["--set", "output.report=true", "--no-report"], False),
        ([], False),
    ],
)
def test_the_case_may_ask_for_the_page_and_the_option_is_over_it(options, written, tmp_path):
    assert run(tmp_path, "-o", tmp_path / "plate.vtk", *options)[0] == 0
    assert (tmp_path / "plate.html").exists() == written


@pytest.mark.long
def test_a_page_cannot_go_to_the_standard_output_nor_over_the_case(tmp_path):
    code, said = run(tmp_path, "-o", "-", "--report")
    assert (code, said) == (2, "error: --report: there is no place for its files with -o -: drop one of them\n")
    (tmp_path / "composite.html").mkdir()
    assert run(tmp_path, "-o", f"{tmp_path}/", "--report")[0] == 5
    assert {path.name for path in tmp_path.iterdir()} == {"a.yaml", "composite.html"}
