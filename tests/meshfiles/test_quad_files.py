"""Quadrilaterals in mesh files: written by all formats that hold them, and read back."""

import dataclasses
import json
import xml.etree.ElementTree as ET

import meshio
import numpy as np
import pytest
from commands import command
from meshio.abaqus._abaqus import abaqus_to_meshio_type
from quadrilaterals import cells_by_places, facets_by_places, mixed, of_order
from sandwiches import written
from squares import holed_square

from bubblemesh.api import Mesh
from bubblemesh.errors import FileError, MeshWarning
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.meshfiles.fields import read_field
from bubblemesh.meshfiles.formats import FORMATS
from bubblemesh.meshfiles.groups import facet_ids, region_ids
from bubblemesh.meshfiles.read import read_mesh, read_triangles
from bubblemesh.meshfiles.sources.layers import flattened
from bubblemesh.meshfiles.sources.source import Block, Source
from bubblemesh.meshfiles.whole_mesh import whole_mesh

HOLDING = [(name, order) for name, form in FORMATS.items() if form.quads for order in form.orders]
OTHERS = [name for name, form in FORMATS.items() if not form.quads]
WITHOUT_FACETS = ("vtu", "vtk", "pvtu", "xdmf", "dat")  # as far as they are read
WITHOUT_REGIONS = ("su2", "gr3")
OWN = ("gr3", "2dm", "ugrid")  # which meshio does not read
PARTS = 5


@pytest.mark.parametrize(("form", "order"), HOLDING)
def test_cells_labels_and_regions_are_read_back(form, order, tmp_path):
    mesh = mixed()
    path = written(of_order(mesh, order), tmp_path, form)
    found, notes = whole_mesh(path)
    assert tuple(note for note in notes if not note.startswith("sets of nodes are left out")) == (
        ("has cells of higher order: their corners are read",) if order == 2 and form != "openfoam" else ()
    )
    assert len(found.triangles) == len(mesh.triangles)
    assert len(found.quads) == len(mesh.quads)
    expected = cells_by_places(mesh)
    regions = cells_by_places(found)
    assert regions.keys() == expected.keys()
    if form not in WITHOUT_REGIONS:
        assert regions == expected
    if form not in WITHOUT_FACETS:
        of_facets = {name: getattr(mesh, name)[mesh.outer] for name in ("facets", "facet_labels", "facet_middles")}
        rim = dataclasses.replace(mesh, **of_facets)
        assert facets_by_places(found) == facets_by_places(rim if form == "gr3" else mesh)
    areas = signed_areas(found.points, found.triangles)
    assert (areas > 0).all()
    assert areas.sum() == pytest.approx(signed_areas(mesh.points, mesh.triangles).sum(), rel=1e-12)


# Those that meshio does not read so: it numbers the nodes of msh4 anew, and knows no nine nodes in MED and mixed XDMF.
@pytest.mark.parametrize(
    ("form", "order"),
    [each for each in HOLDING if each[0] not in ("msh4", *OWN) and each not in (("med", 2), ("xdmf", 2))],
)
def test_each_format_holds_the_cells_as_they_are(form, order, tmp_path, monkeypatch):
    """As meshio reads them, which shares nothing with this package but the writers of a few formats."""
    mesh = of_order(mixed(), order)
    path = written(mesh, tmp_path, form)
    for name, kind in (("3", "triangle"), ("4", "quad"), ("6", "triangle6"), ("8", "quad8")):
        for family in ("CPS", "CPE"):  # of which meshio does not know all
            monkeypatch.setitem(abaqus_to_meshio_type, family + name, kind)
    if form == "pvtu":
        path = tmp_path / "plate_0.vtu"
    read = meshio.read(path, file_format="gmsh" if path.suffix == ".msh" else None)
    found = {}
    for block in read.cells:
        found.setdefault(block.type, []).append(np.asarray(block.data))
    found = {kind: np.concatenate(blocks) for kind, blocks in found.items()}
    (triangles, _), (quads, _) = mesh.cells
    n = len(mesh.points)
    if form == "openfoam":
        assert same(found["wedge"], np.hstack([triangles, triangles + n]))
        assert same(found["hexahedron"], np.hstack([quads, quads + n]))
        assert same(found["triangle"], np.vstack([triangles + n, triangles[:, ::-1]]))
        sides = np.hstack([mesh.facets, mesh.facets[:, ::-1] + n])
        assert same(found["quad"], np.vstack([sides, quads + n, quads[:, ::-1]]))
    elif form == "dat":  # has one kind of cells
        assert same(found["quad"], np.vstack([triangles[:, [0, 1, 2, 2]], quads]))
    elif form.startswith("inp"):
        left_out = np.setdiff1d(np.arange(n), np.concatenate([triangles.ravel(), quads[:, :8].ravel()]))
        assert len(left_out) == (len(quads) if order == 2 else 0)
        number = np.cumsum(~np.isin(np.arange(n), left_out)) - 1  # meshio counts those that are there
        assert {kind: len(cells) for kind, cells in found.items()} == {
            {1: "triangle", 2: "triangle6"}[order]: len(triangles),
            {1: "quad", 2: "quad8"}[order]: len(quads),
        }
        assert same(found[{1: "quad", 2: "quad8"}[order]], number[quads[:, :8]])
        assert same(found[{1: "triangle", 2: "triangle6"}[order]], number[triangles])
        np.testing.assert_allclose(read.points[:, :2], np.delete(mesh.points, left_out, axis=0), atol=1e-13)
    else:
        assert same(found[{1: "triangle", 2: "triangle6"}[order]], triangles)
        assert same(found[{1: "quad", 2: "quad9"}[order]], quads)
    if not form.startswith("inp"):
        np.testing.assert_array_equal(read.points[:n, :2], mesh.points)


def same(found, expected):
    """Whether the rows are the same, in any order."""
    return sorted(found.tolist()) == sorted(expected.tolist())


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("form", ["msh", "msh-ascii", "msh4", "med", "mesh"])
def test_gmsh_reads_the_cells(gmsh, form, order, tmp_path):
    if order not in FORMATS[form].orders:
        pytest.skip("has no second order")
    mesh = of_order(mixed(), order)
    gmsh.clear()
    gmsh.open(str(written(mesh, tmp_path, form)))
    tags, points, _ = gmsh.model.mesh.getNodes()
    order_of = np.argsort(tags)
    np.testing.assert_allclose(points.reshape(-1, 3)[order_of, :2], mesh.points, atol=1e-15)
    place = {tag: k for k, tag in enumerate(tags[order_of])}
    for nodes, _ in mesh.cells:
        kind = {3: 2, 4: 3, 6: 9, 9: 10}[nodes.shape[1]]
        _, found = gmsh.model.mesh.getElementsByType(kind)
        assert same(np.array([place[node] for node in found]).reshape(nodes.shape), nodes)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("form", ["msh", "msh-ascii"])
def test_mfem_reads_the_cells_and_their_area(form, order, tmp_path):
    mfem = pytest.importorskip("mfem.ser")
    flat = mixed()
    read = mfem.Mesh(str(written(of_order(flat, order), tmp_path, form)))
    areas = [read.GetElementVolume(k) for k in range(read.GetNE())]
    assert len(areas) == sum(len(cells.nodes) for cells in flat.cells)
    assert min(areas) > 0
    assert sum(areas) == pytest.approx(signed_areas(flat.points, flat.triangles).sum(), rel=1e-12)


@pytest.mark.parametrize("form", OTHERS)
def test_other_formats_get_the_triangles(form, tmp_path):
    mesh = mixed()
    written(mesh, tmp_path / "a", form)
    written(mesh.in_triangles(), tmp_path / "b", form)
    contents = [
        {path.name: path.read_bytes() for path in folder.iterdir() if not path.name.endswith(".report.json")}
        for folder in (tmp_path / "a", tmp_path / "b")
    ]
    assert contents[0] == contents[1]


@pytest.mark.parametrize("form", ["vtu", "msh", "xdmf", "su2", "med", "openfoam", "pvtu", "msh4"])
def test_a_mesh_of_quadrilaterals_alone(form, tmp_path):
    mesh = mixed()
    mesh = dataclasses.replace(mesh, quads=np.arange(len(mesh.triangles)).reshape(-1, 2))
    assert len(mesh.cells) == 1
    found, _ = whole_mesh(written(mesh, tmp_path, form))
    assert cells_by_places(found).keys() == cells_by_places(mesh).keys()
    if form == "xdmf":
        (topology,) = ET.parse(tmp_path / "plate.xdmf").iter("Topology")
        assert topology.get("TopologyType") == "Quadrilateral"


@pytest.mark.parametrize("order", [1, 2])
def test_surfaces_of_input_files_name_sides_of_their_elements(order, tmp_path):
    mesh = of_order(mixed(), order)
    lines = written(mesh, tmp_path, "inp").read_text().splitlines()
    elements, corners, found, surface = {}, 3, set(), None
    for line in lines:
        if line.startswith("*"):
            corners = 4 if "CPS4" in line or "CPS8" in line else 3
            inside, surface = line.startswith("*ELEMENT"), line.startswith("*SURFACE")
        elif inside:
            number, *nodes = (int(word) - 1 for word in line.split(","))
            elements[number] = nodes[:corners]
        elif surface:
            number, side = line.split(", S")
            nodes = elements[int(number) - 1]
            found.add((nodes[int(side) - 1], nodes[int(side) % len(nodes)]))
    assert sorted(elements) == list(range(sum(len(cells.nodes) for cells in mesh.cells)))
    assert found == {tuple(ends) for ends in mesh.facets[:, :2].tolist()}


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("form", ["vtu", "vtk", "pvtu", "xdmf", "msh4", "dat"])
def test_parts_of_cells_are_read_back(form, order, tmp_path):
    if order not in FORMATS[form].orders:
        pytest.skip("has no second order")
    mesh = of_order(mixed(), order).partitioned(PARTS)
    owner = mesh.partition.owner
    assert (owner[mesh.quads[:, 0]] == owner[mesh.quads[:, 1]]).all()
    read = read_mesh(written(mesh, tmp_path, form))
    found = cells_by_places(read.mesh, read.cell_data["partition"])
    assert found == cells_by_places(mesh, owner)


def test_ghosts_are_whole_cells(tmp_path):
    mesh = mixed().partitioned(PARTS)
    path = written(mesh, tmp_path, "pvtu")
    halos = [set(mesh.cell_numbers[mesh.partition.halo(part)].tolist()) for part in range(PARTS)]
    owner = {cell: part for cell, part in zip(mesh.cell_numbers.tolist(), mesh.partition.owner.tolist(), strict=True)}
    nodes = [row for cells in mesh.cells for row in cells.nodes.tolist()]
    for part in range(PARTS):
        piece = meshio.read(path.with_name(f"plate_{part}.vtu"))
        numbers, ghost = (np.concatenate(piece.cell_data[name]) for name in ("GlobalElementId", "vtkGhostType"))
        assert set(numbers[ghost == 1].tolist()) == halos[part]
        assert set(numbers[ghost == 0].tolist()) == {cell for cell, k in owner.items() if k == part}
        known = piece.point_data["GlobalNodeId"]
        rows = [known[row].tolist() for block in piece.cells for row in block.data]
        assert rows == [nodes[cell] for cell in numbers.tolist()]
    text = written(mesh, tmp_path, "msh4").read_text()
    ghosts = text.split("$GhostElements\n")[1].split("\n$End")[0].splitlines()[1:]
    before = 1 + len(mesh.labelled_nodes) + len(mesh.facets)
    found = {(part, int(row.split()[0]) - before) for row in ghosts for part in map(int, row.split()[3:])}
    assert found == {(part + 1, cell) for part, halo in enumerate(halos) for cell in halo}
    assert all(owner[int(row.split()[0]) - before] == int(row.split()[1]) - 1 for row in ghosts)
    lines = written(mesh, tmp_path, "msh-ascii").read_text().split("$Elements\n")[1].splitlines()[1:]
    rows = [list(map(int, line.split())) for line in lines if line.split()[1:2] in (["2"], ["3"])]
    tags = [row[5 : 3 + row[2]] for row in rows]
    assert [each[1] - 1 for each in tags] == [owner[cell] for cell in range(len(rows))]
    assert {(-part, cell) for cell, each in enumerate(tags) for part in each[2:]} == found


def test_fields_of_quadrilaterals_are_means_of_their_halves(tmp_path):
    mesh = mixed()
    values = np.arange(len(mesh.triangles), dtype=float) ** 2
    for form in ("vtu", "xdmf"):
        FORMATS[form].write(mesh, {"h": values}, tmp_path / f"a.{form}")
        read = read_mesh(tmp_path / f"a.{form}")
        halves = values.copy()
        halves[mesh.quads] = values[mesh.quads].mean(axis=1)[:, None]
        assert cells_by_places(read.mesh, read.cell_data["h"]) == cells_by_places(mesh, halves)


def test_one_format_is_made_of_another(tmp_path):
    mesh = mixed()
    path = written(mesh, tmp_path, "msh")
    code, _, said = command("partition", path, 3, "--format", "vtu", "--format", "msh4", "-o", tmp_path / "out", "-q")
    assert (code, said) == (0, "")
    for ending in ("vtu", "msh"):
        found = read_mesh(next((tmp_path / "out").glob(f"*.{ending}"))).mesh
        assert cells_by_places(found).keys() == cells_by_places(mesh).keys()


def test_quality_and_pictures_of_quadrilaterals(tmp_path):
    mesh = mixed()
    code, text, said = command("quality", written(mesh, tmp_path, "vtu"), "--json")
    assert (code, said) == (0, "")
    found = json.loads(text)
    assert (found["nodes"], found["triangles"]) == (len(mesh.points), len(mesh.triangles))
    assert found["area"] == pytest.approx(signed_areas(mesh.points, mesh.triangles).sum())
    code, _, said = command("plot", tmp_path / "plate.vtu", "-o", tmp_path / "a.svg")
    assert code == 0, said


def plane(folder, points, *cells):
    points = np.pad(np.array(points, float), ((0, 0), (0, 1)))
    meshio.Mesh(points, [(kind, np.array(rows)) for kind, rows in cells]).write(folder / "a.vtu")
    return folder / "a.vtu"


def test_a_quadrilateral_is_cut_where_the_largest_angle_is_least(tmp_path):
    kite = [(0, 0), (4, -1), (8, 0), (4, 1)]
    for turn in range(4):
        cell = np.roll([0, 1, 2, 3], turn)
        found = read_mesh(plane(tmp_path, kite, ("quad", [cell]))).mesh
        assert set(found.triangles[0]) & set(found.triangles[1]) == {1, 3}
        assert found.quads.tolist() == [[0, 1]]


def test_one_that_is_not_convex_is_cut_inside_and_two_triangles(tmp_path):
    dart = [(0, 0), (2, 1), (0, 4), (-2, 1)]
    dart[2] = (0, 0.5)
    for cell in ([0, 1, 2, 3], [3, 2, 1, 0], [1, 2, 3, 0]):
        path = plane(tmp_path, dart, ("quad", [cell]))
        with pytest.warns(MeshWarning, match="1 quadrilateral is not convex: triangles are read in their place"):
            found = Mesh.read(path)
        assert len(found.quads) == 0
        assert set(found.triangles[0]) & set(found.triangles[1]) == {0, 2}
        assert (signed_areas(found.points, found.triangles) > 0).all()


def test_one_with_a_node_twice_is_a_triangle(tmp_path):
    path = plane(tmp_path, [(0, 0), (1, 0), (1, 1), (0, 1)], ("quad", [[0, 1, 2, 2], [3, 3, 0, 2], [0, 3, 2, 0]]))
    found = read_triangles(path)
    assert [set(row) for row in found.triangles.tolist()] == [{0, 1, 2}, {0, 2, 3}, {0, 2, 3}]
    assert found.cells.tolist() == [0, 1, 2]
    assert len(found.quads) == 0


@pytest.mark.parametrize("cell", [[0, 1, 3, 2], [0, 4, 1, 4], [0, 0, 1, 1], [0, 4, 1, 0]])
def test_one_that_crosses_itself_or_has_no_area_is_refused(cell, tmp_path):
    path = plane(tmp_path, [(0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0)], ("quad", [[0, 1, 2, 3], cell]))
    if cell == [0, 4, 1, 0]:  # a triangle, if a flat one
        assert len(read_triangles(path).triangles) == 3
        return
    with pytest.raises(FileError, match=r"a\.vtu: a quadrilateral has no area or crosses itself at \("):
        read_triangles(path)


def test_quadrilaterals_with_nodes_of_their_own_are_joined(tmp_path):
    mesh = holed_square(6)
    mesh = dataclasses.replace(mesh, quads=np.arange(len(mesh.triangles)).reshape(-1, 2))
    (cells,) = mesh.cells
    path = plane(tmp_path, mesh.points[cells.nodes.ravel()], ("quad", np.arange(cells.nodes.size).reshape(-1, 4)))
    found = read_mesh(path).mesh
    assert len(found.points) == len(mesh.points)
    assert cells_by_places(dataclasses.replace(found, regions=("domain",))).keys() == cells_by_places(mesh).keys()


@pytest.mark.parametrize("upside_down", [False, True])
@pytest.mark.parametrize(("wedge", "hexahedron"), [("wedge", "hexahedron"), ("wedge15", "hexahedron20")])
def test_a_layer_of_solids_is_its_lower_side(wedge, hexahedron, upside_down):
    """As CalculiX makes of plane elements, with nodes on edges after the corners."""
    mesh = mixed()
    n = len(mesh.points)
    points = np.vstack([np.pad(mesh.points, ((0, 0), (0, 1)), constant_values=z) for z in (-0.5, 0.5)])
    blocks = []
    for kind, (nodes, _) in zip((wedge, hexahedron), mesh.cells, strict=True):
        sides = [nodes + n, nodes] if upside_down else [nodes, nodes + n]
        more = {"wedge15": 9, "hexahedron20": 12}.get(kind, 0)
        blocks.append(Block(kind, np.hstack([*sides, np.full((len(nodes), more), 2 * n - 1)])))
    found = flattened(Source(points, blocks, {}, {"material": [np.full(len(block.data), 7) for block in blocks]}))
    assert [block.type for block in found.cells] == ["triangle", "quad"]
    for block, (nodes, _) in zip(found.cells, mesh.cells, strict=True):
        np.testing.assert_array_equal(block.data, nodes)
    tilted = dataclasses.replace(found, points=points + 0.1 * points[:, :1] * [0, 0, 1], cells=blocks)
    assert flattened(tilted) is tilted


def test_fields_on_quadrilaterals_are_cut_as_before(tmp_path):
    points = [(0, 0), (1, 0), (1, 1), (0, 1)]
    mesh = meshio.Mesh(np.pad(points, ((0, 0), (0, 1))), [("quad", [[0, 1, 2, 3]])], {"h": np.arange(4.0)})
    mesh.write(tmp_path / "a.vtu")
    assert read_field(tmp_path / "a.vtu", "h").triangles.tolist() == [[0, 1, 2], [0, 2, 3]]


@pytest.mark.parametrize("order", [1, 2])
def test_meshio_gets_quadrilaterals(order):
    mesh = of_order(mixed(), order)
    found = mesh.to_meshio()
    kinds = {1: ["line", "triangle", "quad"], 2: ["line3", "triangle6", "quad9"]}[order]
    assert [block.type for block in found.cells] == ["vertex", *kinds]
    for cells, block, ids in zip(mesh.cells, found.cells[2:], found.cell_data["gmsh:physical"][2:], strict=True):
        np.testing.assert_array_equal(block.data, cells.nodes)
        np.testing.assert_array_equal(ids, region_ids(mesh)[cells.triangles[:, 0]])
    counted = sum(len(rows) for name in mesh.regions for rows in found.cell_sets[name][2:])
    assert counted == sum(len(cells.nodes) for cells in mesh.cells)
    assert len(found.cells[1].data) == len(facet_ids(mesh))


@pytest.mark.parametrize("order", [1, 2])
def test_pyvista_gets_quadrilaterals(order):
    pyvista = pytest.importorskip("pyvista")
    mesh = of_order(mixed(), order)
    grid = mesh.to_pyvista()
    assert isinstance(grid, pyvista.UnstructuredGrid)
    kinds, counts = np.unique(grid.celltypes, return_counts=True)
    expected = {1: {3: 2, 5: 0, 9: 1}, 2: {21: 2, 22: 0, 28: 1}}[order]
    sizes = [*(len(cells.nodes) for cells in mesh.cells), len(mesh.facets)]
    assert dict(zip(kinds.tolist(), counts.tolist(), strict=True)) == {kind: sizes[k] for kind, k in expected.items()}


def test_scikit_fem_gets_triangles():
    mesh = mixed()
    np.testing.assert_array_equal(np.sort(mesh.to_skfem().t.T, axis=1), np.sort(mesh.triangles, axis=1))
