"""Every format that meshio or Gmsh reads, written and read back: points, triangles and every group, however many."""

import dataclasses
import json

import meshio
import numpy as np
import pytest
import skfem
from sandwiches import sandwich
from solver_programs import python_with, run
from squares import fields_of, holed_square

from bubblemesh.meshfiles.formats import FORMATS
from bubblemesh.meshfiles.groups import facet_ids, group_names, node_ids, region_ids
from bubblemesh.meshfiles.mesh_files import MeshFiles
from bubblemesh.meshfiles.writing import write_files

ODD = (
    *(
        "on",
        "no",
        "null",
        "0",
        "-1",
        "1e5",
        "~",
        "*",
        "#",
        "$Nodes",
        "%d",
        "{}",
        "a b",
        "a,b",
        "a;b",
        "a'b",
        "<b>&amp;",
    ),
    *(
        "äußere Wand",
        "日本",
        "🙂",
        "e\u0301",
        "Wall",
        "wall",
        "WALL",
        "w" * 126 + "1",
        "w" * 126 + "2",
        "NALL",
        "front",
    ),
)


def names(kind, count):
    """Odd names, then numbered ones, that differ between kinds."""
    return tuple(f"{name[-120:]}{kind}" for name in ODD[:count]) + tuple(
        f"{kind}group{k}" for k in range(count - len(ODD))
    )


def with_groups(labels, regions, points):
    """A square with a hole, whose facets, triangles and some nodes are in so many groups."""
    mesh = holed_square(cells=18)
    mesh = dataclasses.replace(mesh, labels=names("", labels), facet_labels=np.arange(len(mesh.facets)) % labels)
    mesh = dataclasses.replace(
        mesh, regions=names(".", regions), triangle_regions=np.arange(len(mesh.triangles)) % regions
    )
    at = np.arange(points) * (len(mesh.points) // max(points, 1))
    return dataclasses.replace(mesh, labelled_nodes=at, node_labels=np.arange(points), point_labels=names(":", points))


@pytest.fixture(scope="module", params=[(1, 1, 0), (80, 80, 40)], ids=["few", "two hundred"])
def mesh(request):
    made = with_groups(*request.param)
    assert len(group_names(made)) == sum(request.param)
    return made


@pytest.fixture
def written(mesh, tmp_path):
    """Writes the mesh in a format, and gives the path of the main file and the words for the names."""

    def write(form):
        files = write_files(mesh, fields_of(mesh), {}, MeshFiles(tmp_path, "plate", [form]))["files"]
        return tmp_path / files[0], FORMATS[form].names(mesh)

    return write


def cells_of(mesh):
    """Cells of each group as sorted tuples of nodes, by dimension and id."""
    kinds = [(1, mesh.facets, facet_ids), (2, mesh.triangles, region_ids), (0, mesh.labelled_nodes[:, None], node_ids)]
    found = {}
    for dimension, cells, ids in kinds:
        for cell, number in zip(cells.tolist(), ids(mesh).tolist(), strict=True):
            found.setdefault((dimension, number), []).append(tuple(cell))
    return found


def gathered(blocks, dimension=None):
    """The same of blocks of cells with their ids."""
    found = {}
    for cells, ids in blocks:
        for cell, number in zip(cells.tolist(), np.abs(ids).tolist(), strict=True):
            found.setdefault((len(cell) - 1 if dimension is None else dimension, number), []).append(tuple(cell))
    return found


def only(cells, *dimensions):
    return {group: members for group, members in cells.items() if group[0] in dimensions}


@pytest.mark.parametrize("form", ["msh", "msh-ascii"])
def test_meshio_reads_msh(mesh, written, form):
    path, words = written(form)
    read = meshio.read(path, file_format="gmsh")
    np.testing.assert_array_equal(read.points[:, :2], mesh.points)
    blocks = [(b.data, ids) for b, ids in zip(read.cells, read.cell_data["gmsh:physical"], strict=True)]
    assert gathered(blocks) == cells_of(mesh)
    assert {name: tuple(group) for name, group in read.field_data.items()} == group_names(mesh)
    assert all(name == word for name, word in words.items())


@pytest.mark.parametrize("form", ["msh", "msh-ascii"])
def test_gmsh_reads_msh(gmsh, mesh, written, form):
    path, _ = written(form)
    gmsh.open(str(path))
    tags, points, _ = gmsh.model.mesh.getNodes()
    np.testing.assert_array_equal(points.reshape(-1, 3)[np.argsort(tags), :2], mesh.points)
    assert {gmsh.model.getPhysicalName(*g): g[::-1] for g in gmsh.model.getPhysicalGroups()} == group_names(mesh)
    found = {}
    for dimension, number in gmsh.model.getPhysicalGroups():
        for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, number):
            (nodes,) = gmsh.model.mesh.getElements(dimension, entity)[2]
            cells = nodes.reshape(-1, dimension + 1).astype(int) - 1
            found |= gathered([(cells, np.full(len(cells), number))])
    assert found == cells_of(mesh)


@pytest.mark.parametrize("form", ["mesh", "med"])
def test_gmsh_reads_medit_and_med(gmsh, mesh, written, form):
    path, words = written(form)
    gmsh.clear()  # else the meshes of two MED files become one
    gmsh.open(str(path))
    tags, points, _ = gmsh.model.mesh.getNodes()
    np.testing.assert_array_equal(points.reshape(-1, 3)[np.argsort(tags), :2], mesh.points)
    found, place = {}, {tag: k for k, tag in enumerate(np.sort(tags))}
    for dimension, entity in gmsh.model.getEntities():
        (nodes,) = gmsh.model.mesh.getElements(dimension, entity)[2]
        cells = [tuple(place[node] for node in cell) for cell in nodes.reshape(-1, dimension + 1)]
        groups = gmsh.model.getPhysicalGroupsForEntity(dimension, entity)
        name = gmsh.model.getPhysicalName(dimension, groups[0]) if form == "med" else entity
        found[dimension, name] = found.get((dimension, name), []) + cells
    names = {group.id: words[name] if words else group.id for name, group in group_names(mesh).items()}
    assert found == {(d, names[number]): cells for (d, number), cells in only(cells_of(mesh), 1, 2).items()}


VTK = """
import json
import sys
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOLegacy import vtkUnstructuredGridReader
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
from vtkmodules.vtkIOXdmf2 import vtkXdmfReader

readers = {"vtk": vtkUnstructuredGridReader, "vtu": vtkXMLUnstructuredGridReader, "xdmf": vtkXdmfReader}
reader = readers[sys.argv[1].rpartition(".")[2]]()
reader.SetFileName(sys.argv[1])
if hasattr(reader, "ReadAllScalarsOn"):
    reader.ReadAllScalarsOn()
    reader.ReadAllFieldsOn()
reader.Update()
grid = reader.GetOutputDataObject(0)
data = grid.GetCellData()
found = {data.GetArrayName(k): vtk_to_numpy(data.GetArray(k)).tolist() for k in range(data.GetNumberOfArrays())}
found["points"] = vtk_to_numpy(grid.GetPoints().GetData())[:, :2].tolist()
found["cells"] = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).tolist()
found["kinds"] = sorted({grid.GetCellType(k) for k in range(grid.GetNumberOfCells())})
print(json.dumps(found))
"""


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("form", ["vtu", "vtk", "xdmf"])
def test_vtk_reads_its_formats(tmp_path, form, order):
    python = python_with("vtkmodules.vtkIOXdmf2")
    if python is None:
        pytest.skip("the Python package vtk is not installed, so that VTK's reading of the files is not tested")
    flat = with_groups(3, 2, 0)
    mesh = flat if order == 1 else flat.second_order()[0]
    (name, *_) = write_files(mesh, fields_of(flat), {}, MeshFiles(tmp_path, "plate", [form]))["files"]
    found = json.loads(run([python, "-c", VTK, str(tmp_path / name)], tmp_path))
    np.testing.assert_array_equal(found.pop("points"), mesh.points)
    np.testing.assert_array_equal(np.reshape(found.pop("cells"), mesh.triangles.shape), mesh.triangles)
    assert found.pop("kinds") == [{1: 5, 2: 22}[order]]
    expected = {"material": region_ids(mesh).tolist()} | {name: v.tolist() for name, v in fields_of(flat).items()}
    assert found == expected


@pytest.mark.parametrize("form", ["vtu", "vtk", "xdmf", "dat"])
def test_meshio_reads_triangles_with_data(mesh, written, form, tmp_path):
    path, _ = written(form)
    read = meshio.read(path)
    np.testing.assert_array_equal(read.points[:, :2], mesh.points)
    np.testing.assert_array_equal(read.cells_dict["triangle"], mesh.triangles)
    found = gathered([(read.cells_dict["triangle"], read.cell_data["material"][0].astype(int))])
    assert found == only(cells_of(mesh), 2)
    for name, values in fields_of(mesh).items():
        np.testing.assert_array_equal(read.cell_data[name][0], values)
    if form == "xdmf":
        facets = meshio.read(tmp_path / "plate_facets.xdmf")
        np.testing.assert_array_equal(facets.points, mesh.points)
        assert gathered([(facets.cells_dict["line"], facets.cell_data["label"][0])]) == only(cells_of(mesh), 1)
        for one in (read, facets):
            assert {name: tuple(group) for name, group in one.field_data.items()} == group_names(mesh)


@pytest.mark.parametrize("form", ["vtu", "vtk", "xdmf", "mesh", "dat"])
def test_the_sidecar_names_every_id(mesh, written, form):
    path, _ = written(form)
    sidecar = json.loads(path.with_name("plate.labels.json").read_text(encoding="utf-8"))
    assert {name: (entry["id"], entry["dimension"]) for name, entry in sidecar.items()} == group_names(mesh)
    nodes = {entry["id"]: entry["nodes"] for entry in sidecar.values() if entry["dimension"] == 0}
    assert nodes == {number: [k for (k,) in cells] for (_, number), cells in only(cells_of(mesh), 0).items()}


def test_meshio_reads_medit(mesh, written):
    read = meshio.read(written("mesh")[0])
    np.testing.assert_array_equal(read.points, mesh.points)
    blocks = [(b.data, ids) for b, ids in zip(read.cells, read.cell_data["medit:ref"], strict=True)]
    assert gathered(blocks) == only(cells_of(mesh), 1, 2)
    ids = read.point_data["medit:ref"]
    assert all(ids[node] == number for (_, number), cells in only(cells_of(mesh), 0).items() for (node,) in cells)


@pytest.mark.parametrize("form", ["inp", "inp-strain"])
def test_meshio_reads_an_input_file(mesh, written, form):
    path, words = written(form)
    if form == "inp-strain":  # meshio knows elements of plane stress only
        path.write_text(path.read_text().replace("TYPE=CPE3", "TYPE=CPS3"))
    read = meshio.read(path)
    np.testing.assert_array_equal(read.points[:, :2], mesh.points)
    cells = cells_of(mesh)
    offset = np.cumsum([0, *(len(block.data) for block in read.cells)])
    triangles = np.concatenate([block.data for block in read.cells])
    for name, (number, dimension) in group_names(mesh).items():
        if dimension == 2:
            mine = np.concatenate([k + part for k, part in zip(offset, read.cell_sets[words[name]], strict=False)])
            assert [tuple(cell) for cell in triangles[mine.astype(int)].tolist()] == cells[2, number]
        else:
            nodes = {node for cell in cells[dimension, number] for node in cell}
            assert set(read.point_sets[words[name]].tolist()) == nodes


def test_meshio_reads_su2(mesh, written):
    path, words = written("su2")
    read = meshio.read(path)
    np.testing.assert_array_equal(read.points, mesh.points)
    np.testing.assert_array_equal(read.cells_dict["triangle"], mesh.triangles)
    cells = cells_of(mesh)
    assert [tuple(line) for line in read.cells_dict["line"].tolist()] == [
        line for number in range(1, len(mesh.labels) + 1) for line in cells[1, number]
    ]
    markers = [line[12:] for line in path.read_text().splitlines() if line.startswith("MARKER_TAG= ")]
    assert markers == [words[name] for name in mesh.labels]


def test_meshio_reads_med(mesh, written):
    path, words = written("med")
    read = meshio.read(path)
    np.testing.assert_array_equal(read.points, mesh.points)
    blocks = [(b.data, ids) for b, ids in zip(read.cells, read.cell_data["cell_tags"], strict=True)]
    assert gathered(blocks) == only(cells_of(mesh), 1, 2)
    found = {abs(number): name for number, (name,) in {**read.cell_tags, **read.point_tags}.items()}
    assert found == {number: words[name] for name, (number, _) in group_names(mesh).items()}
    (at,) = np.nonzero(read.point_data["point_tags"])
    assert gathered([(at[:, None], read.point_data["point_tags"][at])]) == only(cells_of(mesh), 0)


def test_meshio_reads_the_prisms_for_openfoam(mesh, written):
    path, words = written("openfoam")
    read = meshio.read(path, file_format="gmsh")
    n = len(mesh.points)
    np.testing.assert_array_equal(read.points[:n, :2], mesh.points)
    cells, blocks = cells_of(mesh), {}
    for block, ids in zip(read.cells, read.cell_data["gmsh:physical"], strict=True):
        blocks.setdefault(block.type, []).append((block.data, ids))
    prisms = gathered([(cells[:, :3], ids) for cells, ids in blocks["wedge"]])
    quads = gathered([(cells[:, :2], ids) for cells, ids in blocks["quad"]])
    assert prisms | quads == only(cells, 1, 2)
    expected = {
        words[name]: (number, dimension + 1) for name, (number, dimension) in group_names(mesh).items() if dimension
    }
    found = {name: tuple(group) for name, group in read.field_data.items() if name not in {"front", "back"}}
    assert found == expected


def test_meshio_reads_the_words_for_netgen(mesh, written):
    path, words = written("ngsolve")
    read = meshio.read(path, file_format="gmsh")
    np.testing.assert_array_equal(read.points[:, :2], mesh.points)
    blocks = [(b.data, ids) for b, ids in zip(read.cells, read.cell_data["gmsh:physical"], strict=True)]
    assert gathered(blocks) == cells_of(mesh)
    assert {name: tuple(group) for name, group in read.field_data.items()} == {
        words[name]: tuple(group) for name, group in group_names(mesh).items()
    }
    assert path.read_text().startswith("$MeshFormat\n2.2 0 8\n")
    assert not any(" " in word for word in words.values())


def test_of_lines_dealii_gets_those_of_the_boundary_alone(mesh, tmp_path):
    whole = sandwich() if len(mesh.labels) == 1 else mesh
    path = form_of(whole, tmp_path, "dealii")
    read = meshio.read(path, file_format="gmsh")
    assert [block.type for block in read.cells] == ["line", "triangle"]
    np.testing.assert_array_equal(read.cells[0].data, whole.facets[whole.outer])
    np.testing.assert_array_equal(read.cell_data["gmsh:physical"][0], facet_ids(whole)[whole.outer])
    np.testing.assert_array_equal(read.cell_data["gmsh:physical"][1], region_ids(whole))
    known = {name: tuple(group) for name, group in read.field_data.items()}
    here = {*facet_ids(whole)[whole.outer].tolist(), *region_ids(whole).tolist()}
    assert known == {name: tuple(group) for name, group in group_names(whole).items() if group.id in here}


def test_sfepy_gets_ids_of_triangles_and_of_nodes(mesh, written):
    path, words = written("sfepy")
    assert words is None
    read = meshio.read(path)
    assert_same = np.testing.assert_array_equal
    assert_same(read.points, np.pad(mesh.points, ((0, 0), (0, 1))))
    assert_same(read.cells_dict["triangle"], mesh.triangles)
    assert_same(read.cell_data["mat_id"][0], region_ids(mesh))
    ids = read.point_data["node_groups"]
    labelled = {node for (a, b) in mesh.facets.tolist() for node in (a, b)} | set(mesh.labelled_nodes.tolist())
    assert set(np.flatnonzero(ids).tolist()) == labelled
    assert_same(ids[mesh.labelled_nodes], node_ids(mesh))


@pytest.mark.parametrize("order", [1, 2])
def test_scikit_fem_keeps_all_labels_and_regions(mesh, order, tmp_path, caplog):
    whole = sandwich(("a:b", "a_b", "top", "left", "hole"), ("steel", "top")) if len(mesh.labels) == 1 else mesh
    written = whole if order == 1 else whole.second_order()[0]
    form = FORMATS["skfem"]
    path = form_of(written, tmp_path, "skfem")
    read = {1: skfem.MeshTri1, 2: skfem.MeshTri2}[order].load(path)
    assert caplog.records == []
    words, groups = form.names(written), group_names(written)
    lines = {words[name]: group.id for name, group in groups.items() if group.dimension == 1}
    areas = {words[name]: group.id for name, group in groups.items() if group.dimension == 2}
    assert (set(read.boundaries), set(read.subdomains)) == (set(lines), set(areas))
    # scikit-fem numbers the corners before the other nodes, as this package does.
    np.testing.assert_allclose(read.p.T[: len(whole.points)], whole.points)
    for name, number in lines.items():
        found = np.sort(read.facets[:, np.asarray(read.boundaries[name])], axis=0).T
        mine = np.sort(whole.facets[facet_ids(whole) == number], axis=1)
        assert sorted(map(tuple, found.tolist())) == sorted(map(tuple, mine.tolist()))
    for name, number in areas.items():
        np.testing.assert_array_equal(read.subdomains[name], np.flatnonzero(region_ids(whole) == number))


def form_of(mesh, folder, form):
    """Write a mesh in one format, and return the path of its main file."""
    return folder / form / write_files(mesh, {}, {}, MeshFiles(folder / form, "plate", [form]))["files"][0]


def test_every_format_is_read_back_here_or_by_numpy():
    here = {"msh", "msh-ascii", "vtu", "vtk", "xdmf", "dat", "mesh", "inp", "inp-strain", "su2", "med", "openfoam"}
    here |= {"ngsolve", "dealii", "sfepy", "skfem"}
    here |= {"fort.14", "gr3", "2dm", "slf", "ugrid"}  # in test_coasts.py
    here |= {"pos"}  # in test_written_views.py
    here |= {"msh4", "pvtu"}  # with partitions, in test_partition_files.py
    assert here | {"nodes.csv", "nodes.npz"} == set(FORMATS)
