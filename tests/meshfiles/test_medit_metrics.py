"""Metrics in files of Medit: the .sol beside a .mesh, written and read back."""

import json

import numpy as np
import pytest
from commands import command
from metrics import FRONT, metric_case

from bubblemesh import load_case, mesh_case
from bubblemesh.errors import BubblemeshError
from bubblemesh.meshfiles.fields import read_nodal_field
from bubblemesh.problem.prepare import prepare

CASE = {"domain": {"outer": {"rectangle": [0, 0, 1, 1]}}, "spacing": 0.06, "packing": {"effort": "fast"}}


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def ran(here, name="first", formats=("mesh",), **keys):
    (here / f"{name}.yaml").write_text(json.dumps(CASE | {"output": {"formats": formats}} | keys))
    code, _, told = command("run", f"{name}.yaml", "-q")
    assert code == 0, told
    return json.loads((here / f"{name}.report.json").read_text())


def test_the_metric_at_the_nodes_is_written_beside_medits_mesh_and_read_back(here):
    report = ran(here, metric=FRONT)
    assert "first.sol" in report["files"]
    read = read_nodal_field(here / "first.mesh", None)
    requested = prepare(metric_case(FRONT)).spacing
    np.testing.assert_allclose(read.values, requested.at(read.points), rtol=1e-12)
    again = ran(here, "second", metric={"file": "first.mesh"})
    assert again["nodes"] == pytest.approx(report["nodes"], rel=0.03)
    assert again["quality"]["mean"] > 0.97


def test_without_a_metric_or_without_medits_format_there_is_no_such_file(here):
    assert "first.sol" not in ran(here)["files"]
    assert "second.sol" not in ran(here, "second", ("msh",), metric=FRONT)["files"]


@pytest.mark.long
def test_adapt_writes_the_metric_of_the_solution(here):
    ran(here, formats=["vtu"])
    mesh = mesh_case(load_case(here / "first.yaml")).mesh
    lines = ["MeshVersionFormatted 2", "Dimension 2", "SolAtVertices", str(len(mesh.points)), "1 1"]
    values = np.tanh((mesh.points[:, 1] - 0.5) / 0.05).tolist()
    mesh.write(here / "u.mesh")
    (here / "u.sol").write_text("\n".join([*lines, *map(repr, values), "End", ""]))
    code, _, told = command(
        "adapt", "first.yaml", "--solution", "u.mesh", "--anisotropic", "--nodes", "300", "-o", "next.mesh", "-q"
    )
    assert code == 0, told
    read = read_nodal_field(here / "next.mesh", None)
    assert read.values.shape == (len(read.points), 3)
    assert (read.values[:, 2] / read.values[:, 0]).max() > 9  # short across the layer


def with_sol(here, text):
    mesh = mesh_case(metric_case(None)).mesh
    mesh.write(here / "m.mesh")
    (here / "m.sol").write_text(text.format(n=len(mesh.points), one="1 0 1\n"))
    (here / "c.yaml").write_text(json.dumps(CASE | {"metric": {"file": "m.mesh"}}))
    return load_case(here / "c.yaml"), len(mesh.points)


HEAD = "MeshVersionFormatted 2\nDimension {d}\nSolAtVertices\n"


@pytest.mark.parametrize(
    ("text", "match"),
    [
        (
            HEAD.format(d=2) + "3\n1 3\n{one}{one}{one}End\n",
            r"metric: .*m\.sol: is for 3 nodes, the mesh beside it has",
        ),
        (HEAD.format(d=2) + "{n}\n1 3\n{one}{one}", r"metric: .*m\.mesh: .*SolAtVertices"),
        (HEAD.format(d=2) + "{n}\n1 3\n", r"metric: .*m\.mesh: .*SolAtVertices"),
        (HEAD.format(d=4) + "{n}\n1 3\n{one}", r"metric: .*m\.mesh: .*Dimension"),
        ("MeshVersionFormatted 2\nDimension 2\nEnd\n", r"metric: .*m\.sol: has no SolAtVertices"),
        ("", r"metric: .*m\.mesh"),
    ],
)
def test_damaged_files_are_told_with_the_key_and_the_file(here, text, match):
    case, _ = with_sol(here, text)
    with pytest.raises(BubblemeshError, match=match):
        prepare(case)


@pytest.mark.parametrize(
    ("dimension", "kind", "row", "match"),
    [
        (2, 1, "0.1", "solution: has 1 component: a metric has three"),
        (2, 2, "1 0", "solution: has 2 components: a metric has three"),
        (3, 3, "1 0 1 0 0 1", "solution: has 6 components: a metric has three"),
        (2, 3, "1 2 1", r"solution: is not positive definite and finite at \("),
        (2, 3, "nan 0 1", r"solution: is not positive definite and finite at \("),
    ],
)
def test_what_is_no_metric_is_told_with_its_place(here, dimension, kind, row, match):
    case, n = with_sol(here, "")
    (here / "m.sol").write_text(HEAD.format(d=dimension) + f"{n}\n1 {kind}\n" + f"{row}\n" * n + "End\n")
    with pytest.raises(BubblemeshError, match=rf"metric: .*m\.mesh: {match}"):
        prepare(case)
