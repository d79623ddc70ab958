"""MED files of Gmsh: families without groups, and names in UTF-8, or in the letters of old programs."""

import h5py
import numpy as np
import pytest

from bubblemesh.meshfiles.med import families
from bubblemesh.meshfiles.read import read_mesh


@pytest.fixture
def square(gmsh):
    """A square of Gmsh, with the numbers of its curves."""
    gmsh.clear()
    gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
    gmsh.model.occ.synchronize()
    yield [tag for _, tag in gmsh.model.getEntities(1)]
    gmsh.clear()


def test_a_model_without_groups(gmsh, square, tmp_path):
    gmsh.model.mesh.generate(2)
    gmsh.write(str(tmp_path / "a.med"))
    mesh = read_mesh(tmp_path / "a.med").mesh
    _, nodes, _ = gmsh.model.mesh.getNodes()
    assert len(mesh.points) == len(nodes) // 3
    assert len(mesh.labels) == len(square)


def test_names_with_letters_of_other_languages(gmsh, square, tmp_path):
    gmsh.model.addPhysicalGroup(2, [1], name="Fläche ä")
    gmsh.model.addPhysicalGroup(1, square, name="край")
    gmsh.model.mesh.generate(2)
    gmsh.write(str(tmp_path / "a.med"))
    mesh = read_mesh(tmp_path / "a.med").mesh
    assert (mesh.labels, mesh.regions) == (("край",), ("Fläche ä",))


def test_names_that_are_no_utf_8(tmp_path):
    rows = np.array([list(name.ljust(80, b"\0")) for name in ("Fläche".encode("latin-1"), b"wall    ")], np.uint8)
    with h5py.File(tmp_path / "a.med", "w") as file:
        family = file.create_group("FAM_-3")
        family.attrs["NUM"] = -3
        family["GRO/NOM"] = rows.view(np.int8)
        assert families(file) == {-3: ["Fläche", "wall"]}
