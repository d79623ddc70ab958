"""What other programs read back from the files: the same points, triangles, labels and fields, exactly."""

import dataclasses
import io
from xml.etree import ElementTree as ET

import h5py
import meshio
import numpy as np
import pytest
import skfem
from squares import fields_of, holed_square

from bubblemesh import Mesh, MeshWarning
from bubblemesh.meshfiles.mesh_files import MeshFiles
from bubblemesh.meshfiles.read import read_mesh
from bubblemesh.meshfiles.writing import write_files, write_stream

FORMATS = ("msh", "vtu", "vtk", "xdmf")
NAMES = {
    "plain": ("bottom", "right", "top", "left", "hole"),
    "odd": ("on", "no", "äußere Wand", "1", "a'b & <c>"),
    "as the region": ("domain", "right", "top", "left", "hole"),
}


@pytest.fixture(scope="module", params=NAMES)
def mesh(request):
    return holed_square(labels=NAMES[request.param])


@pytest.fixture(scope="module")
def fields(mesh):
    return fields_of(mesh)


@pytest.fixture(scope="module")
def folder(mesh, fields, tmp_path_factory):
    folder = tmp_path_factory.mktemp("files")
    write_files(mesh, fields, {}, MeshFiles(folder, "plate", list(FORMATS)))
    return folder


def region_of(mesh):
    return "domain" if "domain" not in mesh.labels else "domain_region"


def facets_by_label(mesh):
    """Return the boundary edges of each label as a set of sorted pairs."""
    return {
        label: {tuple(sorted(pair)) for pair in mesh.facets[mesh.facet_labels == index].tolist()}
        for index, label in enumerate(mesh.labels)
    }


def assert_same_points(found, mesh):
    np.testing.assert_array_equal(found[:, :2], mesh.points)
    np.testing.assert_array_equal(found[:, 2:], 0)


def assert_same_fields(found, fields):
    for name, values in fields.items():
        assert found[name][0].dtype.newbyteorder("=") == np.float64
        np.testing.assert_array_equal(found[name][0], values)


# msh


def test_meshio_reads_the_msh_file(mesh, folder):
    read = meshio.read(folder / "plate.msh", file_format="gmsh")
    assert_same_points(read.points, mesh)
    assert [block.type for block in read.cells] == ["line", "triangle"]
    np.testing.assert_array_equal(read.cells_dict["line"], mesh.facets)
    np.testing.assert_array_equal(read.cells_dict["triangle"], mesh.triangles)
    names = {name: tuple(group) for name, group in read.field_data.items()}
    assert names == {**{label: (i + 1, 1) for i, label in enumerate(mesh.labels)}, region_of(mesh): (6, 2)}
    for data in ("gmsh:physical", "gmsh:geometrical"):
        lines, triangles = read.cell_data[data]
        np.testing.assert_array_equal(lines, mesh.facet_labels + 1)
        assert set(triangles) == {6}


def test_the_msh_file_is_binary_version_two(folder):
    assert (folder / "plate.msh").read_bytes().startswith(b"$MeshFormat\n2.2 1 8\n\x01\x00\x00\x00\n$EndMeshFormat\n")


def test_scikit_fem_reads_boundaries_and_subdomain_by_name(mesh, folder, caplog):
    read = skfem.MeshTri.load(folder / "plate.msh")
    assert caplog.records == []
    np.testing.assert_array_equal(read.p.T, mesh.points)
    np.testing.assert_array_equal(np.sort(read.t.T), np.sort(mesh.triangles))
    found = {
        name: {tuple(sorted(pair)) for pair in read.facets[:, indices].T.tolist()}
        for name, indices in read.boundaries.items()
    }
    assert found == facets_by_label(mesh)
    assert {name: len(indices) for name, indices in read.subdomains.items()} == {region_of(mesh): len(mesh.triangles)}


def test_scikit_fem_integrates_over_the_boundary_of_the_hole(mesh, folder):
    read = skfem.MeshTri.load(folder / "plate.msh")
    basis = skfem.FacetBasis(read, skfem.ElementTriP1(), facets=mesh.labels[4])
    assert skfem.Functional(lambda w: 1 + 0 * w.x[0]).assemble(basis) == pytest.approx(4)


def elements_of_group(gmsh, dimension, tag):
    """Return the (m, dimension + 1) node tags of a physical group's elements, and their tags."""
    nodes, elements = [], []
    for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, tag):
        _, element_tags, node_tags = gmsh.model.mesh.getElements(dimension, entity)
        nodes += [np.reshape(tags, (-1, dimension + 1)) for tags in node_tags]
        elements += list(element_tags)
    return np.concatenate(nodes).astype(np.int64), np.concatenate(elements)


def test_gmsh_reads_its_own_format(gmsh, mesh, folder):
    gmsh.open(str(folder / "plate.msh"))
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    assert sorted(tags) == list(range(1, len(mesh.points) + 1))
    assert_same_points(coordinates.reshape(-1, 3)[np.argsort(tags)], mesh)
    groups = gmsh.model.getPhysicalGroups()
    names = {gmsh.model.getPhysicalName(*group): group for group in groups}
    assert names == {**{label: (1, i + 1) for i, label in enumerate(mesh.labels)}, region_of(mesh): (2, 6)}
    seen = []
    for index, label in enumerate(mesh.labels):
        nodes, elements = elements_of_group(gmsh, *names[label])
        np.testing.assert_array_equal(nodes - 1, mesh.facets[mesh.facet_labels == index])
        seen += list(elements)
    nodes, elements = elements_of_group(gmsh, 2, 6)
    np.testing.assert_array_equal(nodes - 1, mesh.triangles)
    seen += list(elements)
    assert sorted(seen) == list(range(1, len(mesh.facets) + len(mesh.triangles) + 1))
    assert gmsh.logger.getLastError() == ""


# VTK


@pytest.mark.parametrize("ending", ["vtu", "vtk"])
def test_meshio_reads_the_vtk_files(mesh, fields, folder, ending):
    read = meshio.read(folder / f"plate.{ending}")
    assert_same_points(read.points, mesh)
    assert [block.type for block in read.cells] == ["triangle"]
    np.testing.assert_array_equal(read.cells[0].data, mesh.triangles)
    assert list(read.cell_data) == ["material", "quality", "target_spacing"]
    assert read.cell_data["material"][0].dtype.newbyteorder("=") == np.int64
    assert set(read.cell_data["material"][0]) == {6}
    assert_same_fields(read.cell_data, fields)


@pytest.mark.parametrize("kind", ["i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "f4", "f8"])
def test_a_vtk_file_of_meshio_is_read_with_numbers_of_all_kinds(kind, tmp_path):
    points, triangles = [(0.0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)]
    data = {"layer": [np.array([7], kind)]}
    meshio.Mesh(points, [("triangle", triangles)], cell_data=data).write(tmp_path / "a.vtk")
    assert read_mesh(tmp_path / "a.vtk").cell_data["layer"].tolist() == [7]


def test_the_vtk_file_has_the_version_that_all_know(folder):
    assert (folder / "plate.vtk").read_bytes().startswith(b"# vtk DataFile Version 4.2\n")


# XDMF


def test_meshio_reads_both_xdmf_files(mesh, fields, folder):
    read = meshio.read(folder / "plate.xdmf")
    np.testing.assert_array_equal(read.points, mesh.points)
    assert [block.type for block in read.cells] == ["triangle"]
    np.testing.assert_array_equal(read.cells[0].data, mesh.triangles)
    assert list(read.cell_data) == ["material", "quality", "target_spacing"]
    assert set(read.cell_data["material"][0]) == {6}
    assert_same_fields(read.cell_data, fields)

    facets = meshio.read(folder / "plate_facets.xdmf")
    np.testing.assert_array_equal(facets.points, mesh.points)
    assert [block.type for block in facets.cells] == ["line"]
    np.testing.assert_array_equal(facets.cells[0].data, mesh.facets)
    assert list(facets.cell_data) == ["label"]
    np.testing.assert_array_equal(facets.cell_data["label"][0], mesh.facet_labels + 1)
    for file in (read, facets):
        names = {name: tuple(group) for name, group in file.field_data.items()}
        assert names == {**{label: (i + 1, 1) for i, label in enumerate(mesh.labels)}, region_of(mesh): (6, 2)}


@pytest.mark.parametrize(("stem", "topology", "width"), [("plate", "Triangle", "3"), ("plate_facets", "Polyline", "2")])
def test_the_xdmf_files_are_as_dolfinx_wants_them(folder, stem, topology, width):
    grids = ET.parse(folder / f"{stem}.xdmf").findall("./Domain/Grid")
    assert [grid.get("Name") for grid in grids] == ["Grid"]
    (grid,) = grids
    assert grid.find("Geometry").get("GeometryType") == "XY"
    assert grid.find("Topology").get("TopologyType") == topology
    assert grid.find("Topology").get("NodesPerElement") == width
    types = {}
    for item in grid.iter("DataItem"):
        file, path = item.text.split(":")
        assert file == f"{stem}.h5"  # relative, so that the folder can move
        with h5py.File(folder / file) as heavy:
            assert heavy[path].shape == tuple(int(number) for number in item.get("Dimensions").split())
            types[path] = heavy[path].dtype
    # dolfinx reads points as float64, topology as int64 and, from the first attribute, tags as int32.
    assert list(types.values())[:3] == [np.float64, np.int64, np.int32]
    assert grid.find("Attribute").get("Name") == {"plate": "material", "plate_facets": "label"}[stem]


def test_the_xdmf_files_can_move_together(mesh, folder, tmp_path):
    for name in ("plate.xdmf", "plate.h5"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    np.testing.assert_array_equal(meshio.read(tmp_path / "plate.xdmf").points, mesh.points)


def test_the_stream_of_xdmf_needs_no_other_file(mesh, fields, tmp_path):
    stream = io.BytesIO()
    write_stream(mesh, fields, "xdmf", stream)
    (tmp_path / "piped.xdmf").write_bytes(stream.getvalue())
    read = meshio.read(tmp_path / "piped.xdmf")
    np.testing.assert_array_equal(read.points, mesh.points)
    np.testing.assert_array_equal(read.cells_dict["triangle"], mesh.triangles)
    assert set(read.cell_data["material"][0]) == {6}
    assert_same_fields(read.cell_data, fields)


def test_small_and_large_coordinates_survive_in_every_format(tmp_path):
    for scale in (1e-12, 1e15):
        square = holed_square()
        square = dataclasses.replace(square, points=square.points * scale)
        write_files(square, fields_of(square), {}, MeshFiles(tmp_path / str(scale), "plate", list(FORMATS)))
        for ending in FORMATS:
            assert_same_points(meshio.read(tmp_path / str(scale) / f"plate.{ending}").points, square)


def test_labelled_edges_that_no_triangle_has_are_left_out_and_told(tmp_path):
    points = [[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    lines = np.array([[0, 1], [1, 3], [1, 0], [2, 3]])
    cells = {"line": lines, "triangle": np.array([[0, 1, 2], [0, 2, 3]])}
    data = {"gmsh:physical": [np.array([1, 1, 1, 2]), np.array([5, 5])]}
    meshio.Mesh(points, cells, cell_data=data).write(tmp_path / "a.msh", file_format="gmsh22", binary=False)
    with pytest.warns(MeshWarning, match="1 labelled edge that no triangle has: left out"):
        mesh = Mesh.read(tmp_path / "a.msh")
    assert sorted(np.sort(mesh.facets, axis=1).tolist()) == [[0, 1], [0, 3], [1, 2], [2, 3]]
    mesh.write(tmp_path / "b.msh")
