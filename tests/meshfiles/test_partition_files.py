"""Partitions in mesh files: what each format holds, and what its readers make of it."""

import csv
import dataclasses
import json
import subprocess
import sys
import xml.etree.ElementTree as ET
from itertools import pairwise

import h5py
import meshio
import numpy as np
import pytest
from commands import command
from sandwiches import sandwich, written
from squares import holed_square

from bubblemesh.api import Mesh
from bubblemesh.errors import FileError
from bubblemesh.meshfiles.formats import FORMATS, without_partition
from bubblemesh.meshfiles.groups import facet_ids, group_names, region_ids
from bubblemesh.meshfiles.mesh_files import MeshFiles
from bubblemesh.meshfiles.read import read_mesh
from bubblemesh.meshfiles.writing import write_alone, write_files

HOLDING = [name for name, form in FORMATS.items() if form.partition]
FORMS = [(name, order) for name in HOLDING for order in FORMATS[name].orders]
IN_TRIANGLES = ("vtu", "vtk", "pvtu", "xdmf", "dat", "msh4")  # whose readers here give the part of each triangle
PARTS = 5


def made(order=1):
    mesh = sandwich()
    return (mesh if order == 1 else mesh.second_order()[0]).partitioned(PARTS)


def by_places(mesh, values):
    """Values of triangles by the places of their corners, which need no numbers."""
    return {
        tuple(sorted(map(tuple, corners.round(9).tolist()))): value
        for corners, value in zip(mesh.points[mesh.triangles[:, :3]], values, strict=True)
    }


def other_files(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if not path.name.endswith(".report.json")}


@pytest.mark.parametrize(("form", "order"), FORMS)
def test_a_format_that_holds_a_partition_is_another_file_with_it_and_always_the_same(form, order, tmp_path):
    mesh = made(order)
    for name, each in (("a", mesh), ("b", mesh), ("without", dataclasses.replace(mesh, partition=None))):
        written(each, tmp_path / name, form)
    files = other_files(tmp_path / "a")
    assert files == other_files(tmp_path / "b")
    assert files != other_files(tmp_path / "without")


@pytest.mark.parametrize("form", [name for name in FORMATS if name not in HOLDING])
def test_a_format_without_a_place_for_it_is_the_same_file_with_it(form, tmp_path):
    mesh = made()
    written(mesh, tmp_path / "a", form)
    written(dataclasses.replace(mesh, partition=None), tmp_path / "without", form)
    assert other_files(tmp_path / "a") == other_files(tmp_path / "without")
    assert without_partition([form, "vtu"]) == [form]


@pytest.mark.parametrize(("form", "order"), [(form, order) for form, order in FORMS if form in IN_TRIANGLES])
def test_parts_labels_and_regions_are_read_back(form, order, tmp_path):
    mesh = made(order)
    read = read_mesh(written(mesh, tmp_path, form))
    assert by_places(read.mesh, read.cell_data["partition"]) == by_places(mesh, mesh.partition.owner)
    assert set(read.mesh.regions) == set(mesh.regions)
    regions = np.array(mesh.regions)[mesh.triangle_regions]
    assert by_places(read.mesh, np.array(read.mesh.regions)[read.mesh.triangle_regions]) == by_places(mesh, regions)
    if form != "msh4":
        owner = dict(zip(map(tuple, mesh.points.round(9).tolist()), mesh.partition.node_owner.tolist(), strict=True))
        places = map(tuple, read.mesh.points.round(9).tolist())
        assert [owner[place] for place in places] == read.point_data["owner"].tolist()


@pytest.mark.parametrize("form", [form for form in HOLDING if not form.startswith("nodes")])
def test_quality_and_plot_read_what_has_parts(form, tmp_path):
    path = written(made(), tmp_path, form)
    code, text, said = command("quality", path, "--json")
    assert (code, said) == (0, "")
    assert (json.loads(text)["nodes"], json.loads(text)["triangles"]) == (96, 144)
    if form == "vtu" or form not in IN_TRIANGLES:  # parts of the others are read back above
        code, _, said = command("plot", path, "--color", "partition", "-o", tmp_path / "a.png")
        assert code == (0 if form == "vtu" else 2), said


@pytest.mark.parametrize("form", ["msh", "msh-ascii"])
def test_tags_of_format_2(form, tmp_path):
    mesh = made()
    path = written(mesh, tmp_path, form)
    read = meshio.read(path, file_format="gmsh")
    np.testing.assert_array_equal(read.points[:, :2], mesh.points)
    np.testing.assert_array_equal(read.get_cells_type("triangle"), mesh.triangles)
    np.testing.assert_array_equal(read.get_cell_data("gmsh:physical", "triangle"), region_ids(mesh))
    np.testing.assert_array_equal(read.get_cell_data("gmsh:physical", "line"), facet_ids(mesh))
    found = ascii_tags(path) if form == "msh-ascii" else binary_tags(path)
    holders = [[] for _ in mesh.triangles]
    for part, triangle in mesh.partition.ghosts.tolist():
        holders[triangle].append(-part - 1)
    if form == "msh":
        holders = [[] for _ in mesh.triangles]
    expected = [
        [number, number, 1 + len(ghosts), part + 1, *ghosts]
        for number, part, ghosts in zip(region_ids(mesh).tolist(), mesh.partition.owner.tolist(), holders, strict=True)
    ]
    assert found[2] == expected
    facets = mesh.partition.owner[mesh.sides[:, 0]] + 1
    assert found[1] == [[k, k, 1, part] for k, part in zip(facet_ids(mesh).tolist(), facets.tolist(), strict=True)]
    points = mesh.partition.node_owner[mesh.labelled_nodes] + 1
    assert [tags[2:] for tags in found[15]] == [[1, part] for part in points.tolist()]


def ascii_tags(path):
    """Tags of all elements, by the number of their kind."""
    lines = path.read_text().split("$Elements\n")[1].split("\n$EndElements")[0].splitlines()[1:]
    found = {}
    for line in lines:
        _, kind, count, *rest = map(int, line.split())
        found.setdefault(kind, []).append(rest[:count])
    return found


def binary_tags(path):
    content = path.read_bytes()
    start = content.index(b"\n", content.index(b"$Elements\n") + len(b"$Elements\n")) + 1
    count, place, found = int(content[:start].splitlines()[-1]), start, {}
    while count:
        kind, many, tags = np.frombuffer(content, np.int32, 3, place).tolist()
        width = 1 + tags + {1: 2, 2: 3, 15: 1}[kind]
        rows = np.frombuffer(content, np.int32, many * width, place + 12).reshape(many, width)
        found[kind] = rows[:, 1 : 1 + tags].tolist()
        count, place = count - many, place + 12 + 4 * many * width
    assert content[place:].startswith(b"\n$EndElements")
    return found


@pytest.mark.parametrize(("order", "kind"), [(1, "triangle"), (2, "triangle6")])
def test_pieces_of_vtk_hold_their_halo(order, kind, tmp_path):
    mesh = made(order)
    path = written(mesh, tmp_path, "pvtu")
    names = [piece.get("Source") for piece in ET.parse(path).iterfind("PUnstructuredGrid/Piece")]
    assert names == [f"plate_{part}.vtu" for part in range(PARTS)]
    for part, name in enumerate(names):
        piece = meshio.read(tmp_path / name)
        numbers, nodes = piece.get_cell_data("GlobalElementId", kind), piece.point_data["GlobalNodeId"]
        ghost = piece.get_cell_data("vtkGhostType", kind)
        assert sorted(numbers[ghost == 0]) == np.flatnonzero(mesh.partition.owner == part).tolist()
        assert sorted(numbers[ghost == 1]) == mesh.partition.halo(part).tolist()
        np.testing.assert_array_equal(nodes[piece.get_cells_type(kind)], mesh.triangles[numbers])
        np.testing.assert_array_equal(piece.points[:, :2], mesh.points[nodes])
        np.testing.assert_array_equal(piece.point_data["vtkGhostType"] == 0, mesh.partition.node_owner[nodes] == part)


def test_one_piece_without_a_partition(tmp_path):
    path = written(sandwich(), tmp_path, "pvtu")
    assert sorted(each.name for each in tmp_path.glob("*vtu")) == ["plate.pvtu", "plate_0.vtu"]
    assert len(read_mesh(path).mesh.points) == 96


def test_pieces_without_common_numbers_stay_apart(tmp_path):
    mesh = made()
    path = written(mesh, tmp_path, "pvtu")
    for part in range(PARTS):
        piece = meshio.read(tmp_path / f"plate_{part}.vtu")
        piece.point_data["GlobalNodeId"] = np.arange(len(piece.points))
        piece.write(tmp_path / f"plate_{part}.vtu")
    assert len(read_mesh(path).mesh.points) > 96


def test_xdmf_has_attributes_of_cells_and_nodes(tmp_path):
    mesh = made()
    path = written(mesh, tmp_path, "xdmf")
    found = {}
    with h5py.File(tmp_path / "plate.h5") as file:
        for attribute in ET.parse(path).iter("Attribute"):
            values = file[attribute.find("DataItem").text.split(":")[1]][()]
            found[attribute.get("Name"), attribute.get("Center")] = values.tolist()
    assert next(iter(found)) == ("material", "Cell")  # which dolfinx reads first
    assert found["partition", "Cell"] == mesh.partition.owner.tolist()
    assert found["owner", "Node"] == mesh.partition.node_owner.tolist()


def test_tables_of_nodes_have_their_owner(tmp_path):
    mesh = made()
    expected = mesh.partition.node_owner.tolist()
    rows = list(csv.DictReader(written(mesh, tmp_path / "a", "nodes.csv").read_text().splitlines()))
    assert [int(row["owner"]) for row in rows] == expected
    assert np.load(written(mesh, tmp_path / "b", "nodes.npz"))["owner"].tolist() == expected


def test_all_pieces_are_named_by_what_writes_them(tmp_path):
    assert write_alone(made(), {}, tmp_path / "a.pvtu") == ["a.pvtu", *(f"a_{part}.vtu" for part in range(PARTS))]
    files = write_files(made(), {}, {}, MeshFiles(tmp_path / "b", "plate", ["pvtu", "vtu"]))["files"]
    assert sorted(files) == sorted(path.name for path in (tmp_path / "b").iterdir())
    assert "plate_4.vtu" in files


def test_a_mesh_of_python_is_written_with_its_partition(tmp_path):
    made().write(tmp_path / "a.vtu")
    assert read_mesh(tmp_path / "a.vtu").cell_data["partition"].max() == PARTS - 1
    assert Mesh.read(tmp_path / "a.vtu").partition is None


# Gmsh's format 4


@pytest.mark.parametrize("order", [1, 2])
def test_a_mesh_without_a_partition_in_format_4(order, tmp_path):
    mesh = dataclasses.replace(made(order), partition=None)
    text = written(mesh, tmp_path, "msh4").read_text()
    assert "Partitioned" not in text
    assert "Ghost" not in text
    read = meshio.read(tmp_path / "plate.msh", file_format="gmsh")
    assert {name: tuple(group) for name, group in read.field_data.items()} == group_names(mesh)
    assert (
        by_places(read_mesh(tmp_path / "plate.msh").mesh, region_ids(mesh).tolist()).keys()
        == by_places(mesh, region_ids(mesh)).keys()
    )


@pytest.mark.parametrize("broken", ["$EndPartitionedEntities", "$Entities"])
def test_a_damaged_partition_is_refused(broken, tmp_path):
    path = written(made(), tmp_path, "msh4")
    path.write_text(path.read_text().replace(broken, "$Other", 1))
    with pytest.raises(FileError, match=r"plate\.msh: "):
        read_mesh(path)


@pytest.mark.parametrize(("version", "binary"), [(4.0, 0), (4.1, 0), (4.1, 1)])
def test_partitions_of_gmsh_itself_are_read(gmsh, version, binary, tmp_path):
    gmsh.clear()
    gmsh.model.occ.addRectangle(0, 0, 0, 2, 1)
    gmsh.model.occ.synchronize()
    gmsh.model.addPhysicalGroup(2, [1], name="plate")
    options = {"Mesh.MshFileVersion": version, "Mesh.Binary": binary, "Mesh.PartitionCreateGhostCells": 1}
    before = {name: gmsh.option.getNumber(name) for name in options}
    for name, value in options.items():
        gmsh.option.setNumber(name, value)
    gmsh.model.mesh.generate(2)
    count = len(gmsh.model.mesh.getElementsByType(2)[0])
    gmsh.model.mesh.partition(3)
    gmsh.write(str(tmp_path / "a.msh"))
    for name, value in before.items():
        gmsh.option.setNumber(name, value)
    gmsh.clear()
    read = read_mesh(tmp_path / "a.msh")
    assert len(read.mesh.triangles) == count
    assert set(read.cell_data["partition"]) == {0, 1, 2}
    assert read.mesh.regions == ("plate",)


@pytest.mark.solver
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("form", ["msh", "msh-ascii", "msh4"])
def test_gmsh_knows_the_parts_and_all_groups(gmsh, form, order, tmp_path):
    mesh = made(order)
    gmsh.open(str(written(mesh, tmp_path, form)))
    assert gmsh.model.getNumberOfPartitions() == PARTS
    tags, points, _ = gmsh.model.mesh.getNodes()
    np.testing.assert_array_equal(points.reshape(-1, 3)[np.argsort(tags), :2], mesh.points)
    assert {gmsh.model.getPhysicalName(*g): g[::-1] for g in gmsh.model.getPhysicalGroups()} == group_names(mesh)
    first = len(mesh.labelled_nodes) + len(mesh.facets) + 1
    owner, group = np.full(len(mesh.triangles), -1), np.full(len(mesh.triangles), -1)
    halos = {}
    for dimension, tag in gmsh.model.getEntities():
        parts = gmsh.model.getPartitions(dimension, tag)
        if gmsh.model.getType(dimension, tag) == "Ghost surface":
            ghosts, owners = gmsh.model.mesh.getGhostElements(dimension, tag)
            halos[parts[0] - 1] = sorted(ghosts - first)
            np.testing.assert_array_equal(owners - 1, mesh.partition.owner[ghosts - first])
        elif dimension == 2 and len(parts):
            _, elements, nodes = gmsh.model.mesh.getElements(dimension, tag)
            mine = elements[0] - first
            owner[mine], group[mine] = parts[0] - 1, gmsh.model.getPhysicalGroupsForEntity(dimension, tag)[0]
            np.testing.assert_array_equal(nodes[0].reshape(len(mine), -1) - 1, mesh.triangles[mine])
    np.testing.assert_array_equal(owner, mesh.partition.owner)
    np.testing.assert_array_equal(group, region_ids(mesh))
    if form == "msh4":
        assert halos == {part: mesh.partition.halo(part).tolist() for part in range(PARTS)}


@pytest.mark.solver
def test_gmsh_writes_a_file_for_each_part(gmsh, tmp_path):
    mesh = made()
    gmsh.open(str(written(mesh, tmp_path, "msh4")))
    gmsh.option.setNumber("Mesh.PartitionSplitMeshFiles", 1)
    gmsh.write(str(tmp_path / "split.msh"))
    gmsh.option.setNumber("Mesh.PartitionSplitMeshFiles", 0)
    for part in range(PARTS):
        read = read_mesh(tmp_path / f"split_{part + 1}.msh")
        assert set(read.cell_data["partition"]) == {part}
        owner = by_places(mesh, mesh.partition.owner)
        assert by_places(read.mesh, read.mesh.triangles[:, 0]).keys() == {
            place for place, each in owner.items() if each == part
        }


@pytest.mark.solver
def test_what_gmsh_divides_is_read(gmsh, tmp_path):
    gmsh.open(str(written(sandwich(), tmp_path, "msh4")))
    gmsh.option.setNumber("Mesh.PartitionCreateGhostCells", 1)
    gmsh.model.mesh.partition(4)
    gmsh.write(str(tmp_path / "b.msh"))
    read = read_mesh(tmp_path / "b.msh")
    assert len(read.mesh.triangles) == 144
    assert set(read.cell_data["partition"]) == {0, 1, 2, 3}
    assert set(read.mesh.regions) == {"steel", "glass fibre"}


# In a process of its own: beside other libraries Gmsh's mesher may crash.
MESHED_BY_GMSH = """
import sys, gmsh
gmsh.initialize()
model = gmsh.model.geo
corners = [model.addPoint(x, y, 0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
sides = [model.addLine(corners[k], corners[(k + 1) % 4]) for k in range(4)]
model.addPlaneSurface([model.addCurveLoop(sides)])
model.synchronize()
gmsh.option.setNumber("Mesh.MeshSizeMax", 0.2)
gmsh.option.setNumber("Mesh.MshFileVersion", float(sys.argv[2]))
gmsh.model.mesh.generate(2)
if sys.argv[3] != "1":
    gmsh.model.mesh.partition(int(sys.argv[3]))
gmsh.write(sys.argv[1])
"""


@pytest.mark.solver
@pytest.mark.parametrize("parts", ["1", "4"])
@pytest.mark.parametrize("version", ["2.2", "4.1"])
def test_what_gmsh_writes_without_groups_has_a_boundary(gmsh, version, parts, tmp_path):
    path = tmp_path / "a.msh"
    command = [sys.executable, "-c", MESHED_BY_GMSH, str(path), version, parts]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, timeout=60)
    mesh = Mesh.read(path)
    along = np.diff(mesh.points[mesh.facets], axis=1)[:, 0]
    assert np.hypot(*along.T).sum() == pytest.approx(4)
    assert not any("gmsh" in label for label in mesh.labels)


@pytest.mark.solver
@pytest.mark.parametrize("partition", [False, True])
def test_gmsh_reads_matching_nodes(gmsh, partition, tmp_path):
    mesh = periodic_square()
    path = written(mesh.partitioned(3) if partition else mesh, tmp_path, "msh4")
    gmsh.open(str(path))
    (sides,) = mesh.periodic_sides
    _, copies, originals, _ = gmsh.model.mesh.getPeriodicNodes(1, sides.second + 1)
    assert {(int(a) - 1, int(b) - 1) for a, b in zip(originals, copies, strict=True)} == set(
        map(tuple, sides.nodes.tolist())
    )


def periodic_square():
    """The square with a hole, whose left and right sides match."""
    mesh = holed_square()
    right, left = (np.flatnonzero(mesh.facet_labels == label) for label in (1, 3))
    return dataclasses.replace(mesh, periodic=np.column_stack([left, right]))


def test_format_4_and_2_have_the_same_matching_nodes(tmp_path):
    mesh = periodic_square()
    found = []
    for form in ("msh-ascii", "msh4", "msh"):
        path = written(mesh, tmp_path / form, form)
        ((_, entities, _, nodes),) = meshio.read(path, file_format="gmsh").gmsh_periodic
        found.append((tuple(map(int, entities)), sorted(map(tuple, np.asarray(nodes).tolist()))))
    assert all(a == b for a, b in pairwise(found))


# Other readers


@pytest.mark.solver
def test_processes_of_vtk_read_their_pieces_and_know_ghosts(tmp_path):
    vtk = pytest.importorskip("vtk")
    from vtk.util.numpy_support import vtk_to_numpy

    mesh = made()
    path = written(mesh, tmp_path, "pvtu")
    for part in range(PARTS):
        reader = vtk.vtkXMLPUnstructuredGridReader()
        reader.SetFileName(str(path))
        reader.UpdateInformation()
        reader.UpdatePiece(part, PARTS, 1)
        grid = reader.GetOutput()
        ghost = vtk_to_numpy(grid.GetCellGhostArray())
        numbers = vtk_to_numpy(grid.GetCellData().GetArray("GlobalElementId"))
        assert sorted(numbers[ghost == 0]) == np.flatnonzero(mesh.partition.owner == part).tolist()
        assert set(mesh.partition.halo(part)) <= set(numbers)


@pytest.mark.solver
@pytest.mark.parametrize("form", ["msh", "msh-ascii"])
def test_mfem_has_the_elements_in_the_order_of_the_parts(form, tmp_path):
    mfem = pytest.importorskip("mfem.ser")
    mesh = made()
    read = mfem.Mesh(str(written(mesh, tmp_path, form)))
    found = [sorted(read.GetElement(k).GetVerticesArray()) for k in range(read.GetNE())]
    assert found == np.sort(mesh.triangles, axis=1).tolist()
