"""`bubblemesh convert MESH TO`."""

import json

import numpy as np
import pytest
from commands import command, contents

from bubblemesh.meshes.mesh import Mesh

CASE = """domain:
  outer: {rectangle: [0, 0, 2, 1], labels: [bottom, right, top, left]}
  regions: [{name: core, ring: {circle: {center: [1, 0.5], radius: 0.3}}}]
spacing: 0.2
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A mesh with labels and a region, as Gmsh's file and in second order."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "case.yaml").write_text(CASE)
    for name, options in (("a.msh", []), ("b.vtu", ["--set", "output.order=2"])):
        code, _, said = command("run", folder / "case.yaml", "-o", folder / name, "-q", *options)
        assert code == 0, said
    return folder


def sides(mesh):
    """Labels of the facets by their nodes' places."""
    ends = np.sort(mesh.points[mesh.facets].round(9).view("f8,f8")[..., 0], axis=1)
    return {tuple(map(tuple, pair)): mesh.labels[label] for pair, label in zip(ends, mesh.facet_labels, strict=True)}


@pytest.mark.parametrize("ending", ["med", "su2", "mesh"])
def test_the_mesh_and_its_labels_are_the_same(ending, made, tmp_path):
    code, out, said = command("convert", made / "a.msh", tmp_path / f"c.{ending}", "-q")
    assert (code, out, said) == (0, "", "")
    first, second = Mesh.read(made / "a.msh"), Mesh.read(tmp_path / f"c.{ending}")
    assert np.array_equal(first.points, second.points)
    assert np.array_equal(first.triangles, second.triangles)
    outer = {ends: label for ends, label in sides(first).items() if label in ("bottom", "right", "top", "left")}
    assert len(outer) == first.outer.sum()
    assert outer.items() <= sides(second).items()


def test_the_figures_are_shown_and_a_solver_is_known(made, tmp_path):
    code, out, said = command("convert", made / "a.msh", f"{tmp_path}/", "--for", "calculix", "--json")
    assert code == 0
    report = json.loads(out)
    assert report["triangles"] == len(Mesh.read(made / "a.msh").triangles)
    assert f"{report['triangles']}" in said
    assert (tmp_path / "a.inp").exists()


def test_of_second_order_the_corners_are_written(made, tmp_path):
    code, _, said = command("convert", made / "b.vtu", tmp_path / "b.su2", "-q")
    assert (code, said) == (0, f"warning: {made / 'b.vtu'}: has cells of higher order: their corners are read\n")
    assert np.array_equal(Mesh.read(tmp_path / "b.su2").triangles, Mesh.read(made / "a.msh").triangles)


@pytest.mark.parametrize(
    ("arguments", "exit_code", "message"),
    [
        (["a.msh", "a.msh"], 5, "would overwrite"),
        (["a.msh", "c.xyz"], 2, "unknown ending"),
        (["none.msh", "c.vtu"], 5, "cannot be read"),
    ],
)
def test_what_cannot_be_converted_is_refused(arguments, exit_code, message, made, monkeypatch):
    monkeypatch.chdir(made)
    before = contents(made)
    code, out, said = command("convert", *arguments)
    assert (code, out) == (exit_code, "")
    assert message in said
    assert contents(made) == before
