"""MED files of Gmsh, meshio and solvers: families, names in UTF-8 or in the letters of old programs, and fields."""

import h5py
import meshio
import numpy as np
import pytest

from bubblemesh.errors import FileError, LimitError
from bubblemesh.meshfiles.fields import read_field
from bubblemesh.meshfiles.inspection import inspected_mesh
from bubblemesh.meshfiles.read import read_mesh
from bubblemesh.meshfiles.sources.med import families

POINTS = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1], [2, 0], [2, 1]])
CELLS = [("line", [[0, 1], [1, 4]]), ("quad", [[0, 1, 2, 3]]), ("triangle", [[1, 4, 5], [1, 5, 2]])]
STEP = "ENS_MAA/mesh/-0000000000000000001-0000000000000000001"
WHOLE = "MED_NO_PROFILE_INTERNAL"


@pytest.fixture
def square(gmsh):
    """A square of Gmsh, with the numbers of its curves."""
    gmsh.clear()
    gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
    gmsh.model.occ.synchronize()
    yield [tag for _, tag in gmsh.model.getEntities(1)]
    gmsh.clear()


@pytest.fixture
def path(tmp_path):
    """A quadrilateral and two triangles beside it, with families, and the fields h and v of nodes and s of cells."""
    tags = [np.array([-1, -1]), np.array([-2]), np.array([-3, -3])]
    cell_data = {"cell_tags": tags, "s": [np.zeros(2), np.ones(1), np.array([2.0, 3])]}
    mesh = meshio.Mesh(POINTS, CELLS, point_data={"h": np.arange(6.0), "v": np.ones((6, 2))}, cell_data=cell_data)
    mesh.cell_tags = {-1: ["wall"], -2: ["left"], -3: ["right"]}
    mesh.write(tmp_path / "a.med")
    return tmp_path / "a.med"


def parts_of(file, field):
    """The content of the only time of a field."""
    (step,) = file[f"CHA/{field}"].values()
    return step


def with_profile(file, field, support, numbers, values):
    """Put values of some nodes or cells in place of all of them."""
    part = parts_of(file, field)[support]
    del part[WHOLE]
    part.attrs["PFL"] = np.bytes_(field)
    part[f"{field}/CO"] = values
    part[field].attrs.update(NBR=len(numbers), NGA=1)
    file[f"PROFILS/{field}/PFL"] = numbers


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


def test_groups_and_fields_of_one_file(path):
    read = read_mesh(path)
    assert (read.mesh.labels, sorted(read.mesh.regions)) == (("wall",), ["left", "right"])
    assert read.point_data["h"].tolist() == [0, 1, 2, 3, 4, 5]
    assert read.point_data["v"].tolist() == [[1, 1]] * 6
    assert read.cell_data["s"].tolist() == [1, 1, 2, 3]


def test_a_field_of_some_kinds_of_cells_or_of_some_cells(path):
    with h5py.File(path, "a") as file:
        del parts_of(file, "s")["MAI.SE2"]
        del parts_of(file, "s")["MAI.QU4"]
        with_profile(file, "h", "NOE", [6, 1], [60.0, 10.0])
    np.testing.assert_array_equal(read_mesh(path).cell_data["s"], [np.nan, np.nan, 2, 3])
    np.testing.assert_array_equal(read_field(path, "h").values, [10, *[np.nan] * 4, 60])
    with h5py.File(path, "a") as file:
        with_profile(file, "s", "MAI.TR3", [2], [7.0])
    np.testing.assert_array_equal(read_mesh(path).cell_data["s"], [np.nan, np.nan, np.nan, 7])


def test_cells_without_a_family(path):
    with h5py.File(path, "a") as file:
        del file[f"{STEP}/MAI/TR3/FAM"]
    mesh = read_mesh(path).mesh
    assert (mesh.labels, sorted(mesh.regions)) == (("wall",), ["left", "region 0"])


def test_a_field_of_two_times_has_them_in_its_names(path):
    with h5py.File(path, "a") as file:
        field = file["CHA/h"]
        (first,) = field
        file.copy(field[first], field, "2")
        field["2"].attrs["PDT"] = 2.5
    assert {"h[0] - 0", "h[1] - 2.5"} <= {*read_mesh(path).point_data}


def test_values_at_the_corners_of_cells_of_two_kinds_are_left_out_with_a_note(path):
    corners = [np.zeros((2, 2, 1)), np.zeros((1, 4, 1)), np.zeros((2, 3, 1))]
    meshio.Mesh(POINTS, CELLS, cell_data={"stress": corners}).write(path)
    read, notes = inspected_mesh(path)
    assert list(read.cell_data) == []
    assert f"{path}: data are left out (stress): cells of one kind have more values than those of another" in notes


@pytest.mark.parametrize(
    ("name", "told"),
    [("ENS_MAA/other", "holds 2 meshes: write a file with one"), ("ENS_MAA/mesh/2", "holds 2 times of its mesh")],
)
def test_a_file_with_several_meshes(path, name, told):
    with h5py.File(path, "a") as file:
        file.create_group(name)
    with pytest.raises(FileError, match=rf"a\.med: {told}"):
        read_mesh(path)


def _text(file):
    cells = file[f"{STEP}/MAI/TR3"]
    del cells["FAM"]
    cells["FAM"] = [b"a", b"b"]


def _three_nodes_in_all(file):
    file[f"{STEP}/MAI/TR3/NOD"].attrs["NBR"] = 3


def _a_count_beyond_all(file):
    file[f"{STEP}/NOE/COO"].attrs["NBR"] = 2**62


@pytest.mark.parametrize("damage", [_text, _three_nodes_in_all, _a_count_beyond_all])
def test_a_file_whose_parts_do_not_fit_together(path, damage):
    with h5py.File(path, "a") as file:
        damage(file)
    with pytest.raises(FileError, match=r"a\.med: .*(the file is damaged|its numbers are not as its format asks for)"):
        read_mesh(path)


def test_few_values_that_become_very_many(path, monkeypatch):
    monkeypatch.setattr("bubblemesh.meshfiles.containment.MOST_UNPACKED", 10_000)
    with h5py.File(path, "a") as file:
        with_profile(file, "h", "NOE", [1], np.zeros(300))
    with pytest.raises(LimitError, match="unpacks to more than"):
        read_mesh(path)
