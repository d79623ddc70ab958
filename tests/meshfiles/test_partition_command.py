"""`bubblemesh partition MESH N`, and `--partition N` of the commands on cases."""

import json
import re

import numpy as np
import pytest
from commands import command, contents, refused
from sandwiches import sandwich, written
from solver_files import vtu
from squares import holed_square

import bubblemesh
from bubblemesh.meshes import division
from bubblemesh.meshfiles.read import read_mesh

CASE = """domain: {outer: {rectangle: [0, 0, 2, 1]}}
spacing: 0.2
output: {partition: 3}
"""
FIGURES = {"parts", "by", "triangles", "imbalance", "edge_cut", "shared_nodes", "halo", "in_several_pieces"}


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "case.yaml").write_text(CASE)
    return tmp_path


def parts_of(path):
    return np.unique(read_mesh(path).cell_data["partition"]).tolist()


def test_a_case_with_the_key(here):
    code, text, said = command("run", "case.yaml", "-o", "out", "--json")
    assert code == 0, said
    report = json.loads(text)
    assert report["partition"].keys() == FIGURES
    assert report["partition"]["parts"] == report["parameters"]["output"]["partition"] == 3
    assert "partition" in report["seconds"]
    assert "partition  3 parts by" in said
    assert parts_of(here / "out" / "case.vtu") == [0, 1, 2]


def test_the_option_goes_over_the_key_and_a_mesh_without_it_is_the_same(here):
    for folder, options in (("a", ["--partition", "5"]), ("b", ["--set", "output.partition=null"])):
        assert command("run", "case.yaml", "-o", folder, "-q", *options)[0] == 0
    (here / "plain.yaml").write_text(CASE.replace("output", "# output") + "name: case\n")
    assert command("run", "plain.yaml", "-o", "c", "-q")[0] == 0
    assert parts_of(here / "a" / "case.vtu") == [0, 1, 2, 3, 4]
    assert (here / "b" / "case.vtu").read_bytes() == (here / "c" / "case.vtu").read_bytes()
    assert (here / "b" / "case.msh").read_bytes() == (here / "c" / "case.msh").read_bytes()
    assert "partition" not in json.loads((here / "c" / "case.report.json").read_text())


def test_the_python_result_has_the_partition(here):
    result = bubblemesh.mesh_case(bubblemesh.load_case("case.yaml"))
    assert result.mesh.partition.count == 3
    assert result.report["partition"]["parts"] == 3


def test_pieces_are_among_the_files_and_may_not_overwrite_the_case(here):
    code, text, _ = command("run", "case.yaml", "-o", "out", "--format", "pvtu", "--json", "-q")
    files = json.loads(text)["files"]
    assert code == 0
    assert files == ["case.pvtu", "case_0.vtu", "case_1.vtu", "case_2.vtu", "case.labels.json", "case.report.json"]
    assert sorted(files) == sorted(path.name for path in (here / "out").iterdir())


@pytest.mark.parametrize(
    ("value", "message"),
    [("0", "must be greater than 0 (found 0)"), ("x", "must be a whole number (found the text 'x')")],
)
def test_a_wrong_number_of_parts_has_its_place(here, value, message):
    said = refused(here, CASE.replace("3}", f"{value}}}"), 2)
    assert said == f"error: case.yaml:3: output.partition: {message}\n"


@pytest.mark.parametrize("arguments", [["run"], ["run", "--dry-run"], ["check"]])
def test_many_more_parts_than_triangles_are_refused_before_the_work(here, arguments, monkeypatch):
    monkeypatch.setattr("bubblemesh.run.pipeline.pack", None)
    code, _, said = command(*arguments, "case.yaml", "--partition", "100000", "-q")
    assert code == 2
    assert re.match(
        r"error: --partition: output\.partition: a mesh of about \d\d nodes, .* for each of 100000 parts", said
    )
    assert contents(here).keys() == {"case.yaml"}


def test_a_few_more_parts_than_triangles_are_refused_with_the_place(here):
    code, _, said = command("run", "case.yaml", "-o", "out", "--partition", "200", "-q")
    assert code == 2
    assert said.startswith("error: --partition: output.partition: a mesh of ")
    assert said.endswith(" parts, not 200\n")
    assert not (here / "out").exists()
    (here / "case.yaml").write_text(CASE.replace("3}", "200}"))
    assert command("run", "case.yaml", "-q")[2].startswith("error: case.yaml:3: output.partition: a mesh of ")


def test_so_many_files_are_refused_before_the_work(here):
    code, _, said = command("run", "case.yaml", "--partition", "1000000000", "--format", "pvtu")
    assert (code, said) == (2, "error: .pvtu has a file for each part, 10,000 at most: ask for fewer parts\n")


def test_formats_without_a_place_are_told(here):
    formats = ("--format", "inp", "--format", "vtu", "--format", "su2")
    code, text, said = command("run", "case.yaml", "-o", "out", *formats, "--json", "-q")
    assert code == 0
    assert said.startswith("warning: there is no place for the partition in inp, su2: msh, vtu,")
    assert said.removeprefix("warning: ").rstrip() in json.loads(text)["warnings"]
    _, _, said = command("run", "case.yaml", "-o", "-", "--format", "su2", "-q")
    assert "no place for the partition in su2" in said


def test_geometry_is_told_in_place_of_metis(here, monkeypatch):
    monkeypatch.setattr(division, "find_spec", lambda name: None)
    code, text, said = command("run", "case.yaml", "-o", "out", "--json", "-q")
    assert code == 0
    assert said.startswith("warning: the mesh is divided by geometry: METIS is not installed")
    assert json.loads(text)["partition"]["by"] == "geometry"


@pytest.mark.usefixtures("workers_in_threads")
def test_a_batch_divides_each_case(here):
    code, _, said = command("batch", "case.yaml", "-o", "all", "--partition", "4", "-j", "1", "-q")
    assert code == 0, said
    assert parts_of(here / "all" / "case.vtu") == [0, 1, 2, 3]


# Meshes that exist already


@pytest.mark.parametrize("form", ["msh", "vtu", "xdmf", "med", "msh4", "pvtu"])
def test_a_mesh_of_any_format_keeps_its_labels_and_regions(here, form):
    mesh = sandwich(regions=("steel", "glass"))
    path = written(mesh, here / "old", form)
    code, text, said = command("partition", path, "4", "--format", "msh4", "--json", "-q")
    told = {"med": f"warning: {path}: sets of nodes are left out: corner, probe\n"}
    assert (code, said) == (0, told.get(form, ""))
    report = json.loads(text)
    assert report["files"] == ["plate-4.msh", "plate-4.report.json"]
    assert report["partition"].keys() == FIGURES
    assert report == json.loads((here / "plate-4.report.json").read_text())
    read = read_mesh(here / "plate-4.msh")
    assert np.unique(read.cell_data["partition"]).tolist() == [0, 1, 2, 3]
    assert set(read.mesh.regions) == set(mesh.regions)
    assert set(read.mesh.labels) == ({"boundary"} if form in ("vtu", "pvtu", "xdmf") else set(mesh.labels))


def test_where_the_results_go(here):
    path = written(holed_square(), here / "old", "vtu")
    before = contents(here / "old")
    assert command("partition", path, "2", "-o", "a.pvtu", "-q")[0] == 0
    assert command("partition", path, "2", "-o", "there/", "-q")[0] == 0
    assert command("partition", path, "2", "-q")[0] == 0
    assert sorted(path.name for path in here.glob("*.*tu")) == ["a.pvtu", "a_0.vtu", "a_1.vtu", "plate-2.vtu"]
    assert sorted(path.name for path in (here / "there").glob("plate-2.*")) == [
        *("plate-2.labels.json", "plate-2.msh", "plate-2.report.json", "plate-2.vtu")
    ]
    code, out, _ = command("partition", path, "2", "-o", "-", "--format", "msh-ascii", "-q")
    assert code == 0
    assert out.startswith("$MeshFormat\n2.2 0 8\n")
    assert contents(here / "old") == before


def test_the_figures_are_shown(here):
    code, out, said = command("partition", written(holed_square(), here, "msh"), "2")
    assert (code, out) == (0, "")
    assert "2 parts by" in said
    assert "plate-2.msh, plate-2.vtu" in said


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["old.vtu", "0"], 2, "old.vtu: a mesh of 144 triangles has from 1 to 144 parts, not 0"),
        (["old.vtu", "145"], 2, "old.vtu: a mesh of 144 triangles has from 1 to 144 parts, not 145"),
        (["none.vtu", "2"], 5, "none.vtu: "),
        (["old.vtu", "2", "-o", "old.vtu"], 5, "old.vtu: the results would overwrite this file"),
        (["old.vtu", "2", "--format", "stl"], 2, "--format: unknown format 'stl'"),
        (["old.vtu", "2", "-o", "-", "--json"], 2, "--json and -o - would both write"),
    ],
)
def test_what_cannot_be_done_is_told(here, arguments, code, message):
    mesh = holed_square()
    vtu(here / "old.vtu", mesh.points, mesh.triangles, {})
    before = contents(here)
    found, out, said = command("partition", *arguments)
    assert (found, out == "") == (code, "--json" not in arguments)
    assert said.startswith(f"error: {message}"), said
    assert contents(here) == before


def test_what_is_left_out_of_a_file_is_told(here):
    mesh, _ = holed_square().second_order()
    _, _, said = command("partition", written(mesh, here, "vtu"), "2", "-q")
    assert "warning: " in said
    assert "has cells of higher order: their corners are read" in said
