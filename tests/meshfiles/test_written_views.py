"""Views of Gmsh that are written: read back here, and background fields for Gmsh."""

import json
from contextvars import copy_context

import numpy as np
import pytest
from commands import command
from metrics import FRONT, metric_case
from squares import fields_of, holed_square
from sweeps import sweep

from bubblemesh import load_case, mesh_case
from bubblemesh.meshes.quality import Measures
from bubblemesh.meshes.tensors import axes
from bubblemesh.meshfiles.fields import read_nodal_field
from bubblemesh.meshfiles.writing import write_alone
from bubblemesh.problem.prepare import prepare

CASE = {"domain": {"outer": {"rectangle": [0, 0, 1, 1]}}, "spacing": 0.06, "packing": {"effort": "fast"}}


@pytest.fixture(scope="module")
def mesh():
    return mesh_case(metric_case(FRONT, packing={"effort": "fast"})).mesh


def test_the_metric_is_read_back(mesh, tmp_path):
    mesh.write(tmp_path / "a.pos")
    read = read_nodal_field(tmp_path / "a.pos", None)
    tensors = read.values[:, [0, 1, 4]]
    assert read.name == "metric"
    assert len(read.points) == len(mesh.points)
    np.testing.assert_allclose(tensors, prepare(metric_case(FRONT)).spacing.at(read.points), rtol=1e-12)
    # In space they are positive, and ask for nothing finer across the plane.
    np.testing.assert_allclose(read.values[:, 8], axes(tensors).along ** -2)
    np.testing.assert_array_equal(read.values[:, [1, 2, 5]], read.values[:, [3, 6, 7]])
    assert not read.values[:, [2, 5]].any()


def test_a_case_takes_the_metric_of_a_view(mesh, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mesh.write("a.pos")
    (tmp_path / "b.yaml").write_text(json.dumps(CASE | {"metric": {"file": "a.pos"}}))
    code, _, told = command("run", "b.yaml", "-o", "b.vtu", "-q")
    assert code == 0, told
    again = json.loads((tmp_path / "b.report.json").read_text())
    assert again["nodes"] == pytest.approx(len(mesh.points), rel=0.03)
    assert again["quality"]["mean"] > 0.97


def test_adapt_writes_a_view_of_the_solutions_metric(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "first.yaml").write_text(json.dumps(CASE))
    mesh = mesh_case(load_case("first.yaml")).mesh
    values = np.tanh((mesh.points[:, 1] - 0.5) / 0.05)
    lines = ["MeshVersionFormatted 2", "Dimension 2", "SolAtVertices", str(len(values)), "1 1"]
    mesh.write("u.mesh")
    (tmp_path / "u.sol").write_text("\n".join([*lines, *map(repr, values.tolist()), "End", ""]))
    arguments = "adapt first.yaml --solution u.mesh --anisotropic --nodes 300 -o next.pos -q"
    code, _, told = command(*arguments.split())
    assert code == 0, told
    read = read_nodal_field(tmp_path / "next.pos", None)
    assert (read.values[:, 4] / read.values[:, 0]).max() > 9  # short across the layer


def test_a_mesh_without_a_metric_has_its_spacing_or_its_sizes(tmp_path):
    mesh = holed_square()
    spacing = fields_of(mesh)["target_spacing"]
    sides = np.mean(Measures(mesh.points, mesh.triangles).sides, axis=0)
    for fields, expected in (({"target_spacing": spacing}, spacing), ({}, sides)):
        write_alone(mesh, fields, tmp_path / "a.pos")
        text = (tmp_path / "a.pos").read_text().splitlines()
        assert text[0] == 'View "target_spacing" {'
        found = [[float(word) for word in row[:-2].split("{")[1].split(",")] for row in text[1:-1]]
        np.testing.assert_array_equal(found, np.repeat(expected[:, None], 3, axis=1))


METRIC = {"metric": {"angle": 0, "across": 20_000}}
FILE, STREAM, FOLDER = ["-o", "a.pos"], ["--format", "pos", "-o", "-"], ["--format", "msh", "--format", "pos"]


@pytest.mark.parametrize(
    ("place", "extra"),
    sweep([(FILE, {}), (FILE, METRIC), (STREAM, METRIC), (STREAM, {}), (FOLDER, {}), (FOLDER, METRIC)], quick=3),
)
def test_sizes_are_not_written_in_other_coordinates_than_those_of_the_plane(place, extra, tmp_path, monkeypatch):
    pytest.importorskip("pyproj")
    monkeypatch.chdir(tmp_path)
    outer = {"polygon": [[-5, 60], [5, 60], [5, 64], [-5, 64]]}
    case = {"crs": {"from": "EPSG:4326", "to": "EPSG:4326"}, "domain": {"outer": outer}, "spacing": 60_000} | extra
    (tmp_path / "a.yaml").write_text(json.dumps(case))
    code, _, told = command("run", "a.yaml", "-q", *place)
    assert code == 2
    assert "pos holds sizes, which are no lengths in the system of crs.to: set crs.to: auto" in told
    assert [path.name for path in tmp_path.iterdir()] == ["a.yaml"]
    code, _, told = copy_context().run(command, "run", "a.yaml", "-q", "--set", "crs.to=auto", *place)
    assert code == 0, told


def test_gmsh_takes_the_metric_as_its_background(mesh, tmp_path, gmsh):
    mesh.write(tmp_path / "a.pos")
    gmsh.merge(str(tmp_path / "a.pos"))
    gmsh.model.add("square")
    gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
    gmsh.model.occ.synchronize()
    field = gmsh.model.mesh.field.add("PostView")
    gmsh.model.mesh.field.setNumber(field, "ViewIndex", 0)
    gmsh.model.mesh.field.setAsBackgroundMesh(field)
    for source in ("ExtendFromBoundary", "FromPoints", "FromCurvature"):
        gmsh.option.setNumber(f"Mesh.MeshSize{source}", 0)
    gmsh.option.setNumber("Mesh.Algorithm", 7)  # BAMG, which knows metrics
    gmsh.model.mesh.generate(2)
    tags, _, _ = gmsh.model.mesh.getNodes()
    assert len(tags) == pytest.approx(len(mesh.points), rel=0.25)
