"""The sidecar that tells the names of groups."""

import dataclasses
import json

import pytest
from sandwiches import ODD, sandwich

from bubblemesh import Mesh
from bubblemesh.meshfiles.formats import FORMATS
from bubblemesh.meshfiles.mesh_files import MeshFiles
from bubblemesh.meshfiles.writing import write_files

COASTS = ("fort.14", "gr3", "2dm", "slf", "ugrid")


@pytest.mark.parametrize("form", FORMATS)
def test_the_sidecar_is_there_where_a_format_needs_it(tmp_path, form):
    files = write_files(sandwich(regions=("a", "b")), {}, {}, MeshFiles(tmp_path, "plate", [form]))["files"]
    needed = form in {"vtu", "vtk", "pvtu", "xdmf", "mesh", "su2", "dat", "openfoam", "skfem", "dealii", "sfepy", "pos"}
    needed |= form in COASTS
    assert ("plate.labels.json" in files) == needed
    if needed:
        sidecar = json.loads((tmp_path / "plate.labels.json").read_text())
        assert list(sidecar.items())[5:9] == [
            ("interface", {"id": 6, "dimension": 1}),
            *[(name, {"id": k, "dimension": 2}) for k, name in ((7, "a"), (8, "b"))],
            ("corner", {"id": 9, "dimension": 0, "nodes": [0]}),
        ]


@pytest.mark.parametrize(
    ("form", "dimensions"), [("su2", {1}), ("openfoam", {1, 2}), ("inp", {0, 1, 2}), ("med", {0, 1, 2}), ("msh", set())]
)
def test_the_sidecar_spells_the_names_that_a_format_holds(tmp_path, form, dimensions):
    mesh = dataclasses.replace(sandwich(ODD, ("glass fibre", "b c")), point_labels=("a corner", "a probe"))
    write_files(mesh, {}, {}, MeshFiles(tmp_path, "plate", [form, "vtu"]))
    sidecar = json.loads((tmp_path / "plate.labels.json").read_text())
    assert {entry["dimension"] for entry in sidecar.values() if "written" in entry} == dimensions


def test_files_in_other_formats_that_are_there_keep_their_spellings(tmp_path):
    mesh = sandwich(ODD, ("glass fibre", "b c"))
    for form in ("inp", "med"):
        write_files(mesh, {}, {}, MeshFiles(tmp_path, "plate", [form]))
    names = {*mesh.labels, *mesh.regions}
    for file in ("plate.inp", "plate.med"):
        found = Mesh.read(tmp_path / file)
        assert names <= {*found.labels, *found.regions}
    both = json.loads((tmp_path / "plate.labels.json").read_text())
    assert {form for entry in both.values() for form in entry.get("written", {})} == {"inp", "med"}
    (tmp_path / "plate.inp").unlink()
    write_files(mesh, {}, {}, MeshFiles(tmp_path, "plate", ["med"]))
    left = json.loads((tmp_path / "plate.labels.json").read_text())
    assert {form for entry in left.values() for form in entry.get("written", {})} == {"med"}


@pytest.mark.parametrize("damaged", ["", "[]", '{"a": 3}', "\udcff"])
def test_a_damaged_sidecar_is_replaced(tmp_path, damaged):
    file = tmp_path / "plate.labels.json"
    file.write_bytes(damaged.encode(errors="surrogateescape"))
    (tmp_path / "plate.inp").touch()
    write_files(sandwich(), {}, {}, MeshFiles(tmp_path, "plate", ["vtu"]))
    assert "interface" in json.loads(file.read_text())
