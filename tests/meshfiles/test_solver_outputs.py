"""Solutions as solvers write them: each file gives the same nodes, triangles and values."""

import meshio
import numpy as np
import pytest
from solver_files import apart, dolfinx_xdmf, frd, freefem_msh, medit, vtk_binary, vtu
from squares import holed_square

from bubblemesh.errors import CaseError, FileError
from bubblemesh.meshfiles.fields import read_nodal_field
from bubblemesh.meshfiles.merging import places
from bubblemesh.meshfiles.read import read_mesh, read_triangles

MESH = holed_square(6)
POINTS, TRIANGLES = MESH.points + 1 / 3, MESH.triangles
U = np.exp(POINTS[:, 0]) * np.cos(2 * POINTS[:, 1])
WITH_NODES_OF_THEIR_OWN = apart(POINTS, TRIANGLES, U)


def corners(points, triangles, values):
    """Places and values of the triangles' corners, in the order of their centroids; no triangle turns over."""
    at = points[triangles]
    order = np.lexsort(np.round(at.mean(axis=1), 4).T)
    first = np.lexsort(np.round(np.moveaxis(at, 2, 0), 4).reshape(2, -1, 3), axis=1)[order]
    chosen = np.take_along_axis(triangles[order], first, axis=1)
    return points[chosen], values[chosen]


def assert_same(found, name, rel=1e-12):
    assert found.name == name
    assert found.points.shape == POINTS.shape
    assert found.triangles.shape == TRIANGLES.shape
    assert found.triangles.max() < len(found.points)
    at, values = corners(found.points, found.triangles, found.values[:, 0])
    places, exact = corners(POINTS, TRIANGLES, U)
    np.testing.assert_allclose(at, places, rtol=rel, atol=rel)
    np.testing.assert_allclose(values, exact, rtol=rel, atol=rel)


# VTK's XML files


@pytest.mark.parametrize("how", ["ascii", "joint", "separate", "compressed", "raw", "base64"])
@pytest.mark.parametrize("nodes", ["shared", "of each cell"])
def test_every_encoding_of_vtu(how, nodes, tmp_path):
    points, cells, u = (POINTS, TRIANGLES, U) if nodes == "shared" else WITH_NODES_OF_THEIR_OWN
    assert_same(read_nodal_field(vtu(tmp_path / "a.vtu", points, cells, {"u": u}, how), None), "u")


@pytest.mark.parametrize(
    "options",
    [
        {"how": "separate", "attributes": 'version="2.2"'},  # MFEM
        {"how": "ascii", "attributes": 'version="2.2"', "kind": 69},  # dolfinx
        {"how": "compressed", "header": "u8"},
        {"how": "separate", "header": "u8", "order": ">"},
        {"how": "raw", "header": "u8", "order": ">"},
        {"how": "raw", "attributes": ""},  # FreeFEM gives no version
        {"how": "joint", "kind": 7},  # polygons of three nodes
    ],
)
def test_versions_orders_of_bytes_and_kinds_of_cells(options, tmp_path):
    assert_same(read_nodal_field(vtu(tmp_path / "a.vtu", POINTS, TRIANGLES, {"u": U}, **options), None), "u")


@pytest.mark.parametrize("how", ["raw", "compressed"])
def test_copies_of_nodes_in_single_precision_are_one(how, tmp_path):
    points, cells, u = WITH_NODES_OF_THEIR_OWN
    points = points * (1 + 1e-7 * np.random.default_rng(0).uniform(-1, 1, points.shape))
    path = vtu(tmp_path / "a.vtu", points, cells, {"u": u}, how, real="f4")
    assert_same(read_nodal_field(path, None), "u", 1e-6)
    assert len(read_triangles(path).points) == len(POINTS)
    assert len(read_mesh(path).mesh.points) == len(POINTS)


@pytest.mark.parametrize("kind", [22, 69])
def test_of_six_nodes_the_corners_count_and_that_is_told(kind, tmp_path):
    curved, _ = MESH.second_order()
    points = curved.points + 1 / 3
    u = np.exp(points[:, 0]) * np.cos(2 * points[:, 1])
    found = read_nodal_field(vtu(tmp_path / "a.vtu", points, curved.triangles, {"u": u}, kind=kind), None)
    assert_same(found, "u")
    assert found.notes == ("has cells of higher order: they count as linear triangles, with the values at the corners",)


def test_several_pieces_and_the_cells_that_another_process_has(tmp_path):
    left = np.flatnonzero(POINTS[TRIANGLES].mean(axis=1)[:, 0] < POINTS[:, 0].mean())
    halves = [np.setdiff1d(np.arange(len(TRIANGLES)), left), left]
    pieces = []
    for k, half in enumerate(halves):
        both = np.append(half, halves[1 - k][:2])  # the last two are copies
        nodes, cells = np.unique(TRIANGLES[both], return_inverse=True)
        path = vtu(tmp_path / f"{k}.vtu", POINTS[nodes], cells.reshape(-1, 3), {"u": U[nodes]})
        ghost = " ".join("0" * len(half)) + " 1 1"
        data = f'<CellData><DataArray type="UInt8" Name="vtkGhostType" format="ascii">{ghost}</DataArray></CellData>'
        path.write_text(path.read_text().replace("</Piece>", data + "</Piece>"))
        pieces.append(path)
    list_of = "".join(f'<Piece Source="{path.name}"/>' for path in pieces)
    (tmp_path / "a.pvtu").write_text(
        f'<VTKFile type="PUnstructuredGrid"><PUnstructuredGrid GhostLevel="1">{list_of}</PUnstructuredGrid></VTKFile>'
    )
    found = read_nodal_field(tmp_path / "a.pvtu", None)
    assert_same(found, "u")
    inside = [path.read_text().split("UnstructuredGrid>")[1].removesuffix("</") for path in pieces]
    (tmp_path / "both.vtu").write_text(
        f'<VTKFile type="UnstructuredGrid"><UnstructuredGrid>{"".join(inside)}</UnstructuredGrid></VTKFile>'
    )
    assert_same(read_nodal_field(tmp_path / "both.vtu", None), "u")


def test_of_a_list_of_times_the_last_one_is_read_and_that_is_told(tmp_path):
    for name, factor in (("a0.vtu", 3.0), ("a1.vtu", 2.0), ("a2.vtu", 1.0)):
        vtu(tmp_path / name, POINTS, TRIANGLES, {"u": factor * U})
    entries = "".join(f'<DataSet timestep="{t}" part="0" file="a{k}.vtu"/>' for t, k in ((0, 0), (1, 1), (1, 2)))
    (tmp_path / "a.pvd").write_text(f'<VTKFile type="Collection"><Collection>{entries}</Collection></VTKFile>')
    found = read_nodal_field(tmp_path / "a.pvd", None)
    assert_same(found, "u")
    assert found.notes == ("holds 2 times: the last one, 1, is read",)


@pytest.mark.parametrize("name", ["/etc/a.vtu", "../a.vtu", ""])
def test_lists_lead_nowhere_else(name, tmp_path):
    text = f'<VTKFile><Collection><DataSet timestep="0" file="{name}"/></Collection></VTKFile>'
    (tmp_path / "a.pvd").write_text(text)
    with pytest.raises(FileError, match="which is not below its own folder"):
        read_nodal_field(tmp_path / "a.pvd", None)


# XDMF


def test_xdmf_of_dolfinx_includes_its_mesh_at_each_time(tmp_path):
    found = read_nodal_field(dolfinx_xdmf(tmp_path / "a.xdmf", POINTS, TRIANGLES, U / 2), None)
    assert_same(found, "u")
    assert found.notes == ("holds 3 times: the last one, 1, is read",)
    assert read_nodal_field(dolfinx_xdmf(tmp_path / "a.xdmf", POINTS, TRIANGLES, U, (0.0,)), None).notes == ()


def meshio_series(path):
    """A series of three times as meshio writes it, its text."""
    with meshio.xdmf.TimeSeriesWriter(path) as writer:
        writer.write_points_cells(np.pad(POINTS, ((0, 0), (0, 1))), [("triangle", TRIANGLES)])
        for time in (0.0, 0.5, 1.0):
            writer.write_data(time, point_data={"u": time * U})
    return path.read_text()


def test_series_of_meshio(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # where meshio writes the numbers
    meshio_series(tmp_path / "a.xdmf")
    found = read_nodal_field(tmp_path / "a.xdmf", "u")
    np.testing.assert_array_equal(found.values[:, 0], U)
    assert found.notes == ("holds 3 times: the last one, 1, is read",)


def test_parts_of_xdmf_that_are_not_known_are_told(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = meshio_series(tmp_path / "a.xdmf")
    (tmp_path / "b.xdmf").write_text(text.replace("<Time", '<Set Name="a" /><Time'))
    assert read_nodal_field(tmp_path / "b.xdmf", "u").notes[1:] == ("parts of grids are left out: Set",)
    (tmp_path / "c.xdmf").write_text(text.replace("2003/XInclude", "3003/XInclude"))
    with pytest.raises(FileError, match=r"a grid without nodes or cells, but with what is not read: .*3003"):
        read_nodal_field(tmp_path / "c.xdmf", "u")


@pytest.mark.parametrize("place", ["//Grid[@Name='mesh']", "/Xdmf/Domain/Grid[1]", '/Xdmf/Domain/Grid[@Name="mesh"]'])
def test_other_ways_to_name_the_mesh(place, tmp_path):
    path = dolfinx_xdmf(tmp_path / "a.xdmf", POINTS, TRIANGLES, U, (0.0,))
    text = path.read_text().replace("/Xdmf/Domain/Grid[@GridType='Uniform'][1]", place.replace('"', "&quot;"))
    path.write_text(text)
    assert_same(read_nodal_field(path, None), "u")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("Grid[@GridType='Uniform'][1]", "Grid[7]", "includes .* which is nowhere in it"),
        ("xpointer=", 'href="b.xdmf" xpointer=', "includes another file, b.xdmf: write all into one"),
        (":/Function/u/0_0", ":/Function/v", "a.h5 has no numbers at /Function/v"),
        ('TopologyType="Triangle"', 'TopologyType="Blob"', "holds cells of the kind 'Blob'"),
        ('CollectionType="Temporal"', 'CollectionType="Spatial"', "holds a grid in several pieces: write it as one"),
        ("</Xdmf>", "", "is no mesh that can be read .no element found"),
    ],
)
def test_reasons_of_xdmf(old, new, message, tmp_path):
    path = dolfinx_xdmf(tmp_path / "a.xdmf", POINTS, TRIANGLES, U, (0.0,))
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(FileError, match=rf"a\.xdmf: .*{message}"):
        read_nodal_field(path, None)


# CalculiX, Medit, FreeFEM


@pytest.mark.parametrize("layer", [False, True])
def test_results_of_calculix_also_of_the_layer_that_it_makes_of_plane_elements(layer, tmp_path):
    path = frd(tmp_path / "a.frd", POINTS, TRIANGLES, U, layer)
    assert_same(read_nodal_field(path, "NDTEMP"), "NDTEMP", 2e-5)
    found = read_nodal_field(path, "DISP")
    assert found.values.shape == (len(POINTS), 3)
    assert_same(found, "DISP", 2e-5)
    assert found.notes == ()
    assert read_mesh(path).mesh.regions == ("region 1",)
    with pytest.raises(CaseError, match=r"has data of 2 names at its nodes \(DISP, NDTEMP\)"):
        read_nodal_field(path, None)


def test_of_several_steps_the_last_one_is_read(tmp_path):
    found = read_nodal_field(frd(tmp_path / "a.frd", POINTS, TRIANGLES, U / 3, times=(1.0, 2.0, 3.0)), "NDTEMP")
    assert_same(found, "NDTEMP", 2e-5)
    assert found.notes == ("holds 3 times: the last one, 3, is read",)


@pytest.mark.parametrize(
    ("lines", "message"),
    [(20, "ends within a block"), (0, "holds no nodes of a result file")],
)
def test_results_that_end_early(lines, message, tmp_path):
    path = frd(tmp_path / "a.frd", POINTS, TRIANGLES, U)
    path.write_text("\n".join(["    1C", *path.read_text().splitlines()[1:][:lines]]))
    with pytest.raises(FileError, match=rf"a\.frd: {message}"):
        read_nodal_field(path, "DISP")


@pytest.mark.parametrize("ending", [".mesh", ".sol"])
def test_a_mesh_of_medit_with_its_solution_beside(ending, tmp_path):
    path = medit(tmp_path / "a.mesh", POINTS, TRIANGLES, U).with_suffix(ending)
    assert_same(read_nodal_field(path, None), "solution")
    assert read_mesh(path).mesh.regions == ("region 3",)


def test_solutions_that_do_not_fit_their_mesh(tmp_path):
    medit(tmp_path / "a.mesh", POINTS, TRIANGLES, U)
    medit(tmp_path / "b.mesh", POINTS[:9], TRIANGLES[:1], U[:9])
    (tmp_path / "a.sol").write_text((tmp_path / "b.sol").read_text())
    with pytest.raises(FileError, match=r"a\.sol: is for 9 nodes, the mesh beside it has 48"):
        read_nodal_field(tmp_path / "a.mesh", None)
    (tmp_path / "b.mesh").unlink()
    with pytest.raises(FileError, match=r"is a solution without a mesh: put b\.mesh beside it"):
        read_nodal_field(tmp_path / "b.sol", None)


def test_meshes_of_freefem_share_the_ending_of_gmsh(tmp_path):
    read = read_mesh(freefem_msh(tmp_path / "a.msh", POINTS, TRIANGLES, MESH.facets))
    np.testing.assert_array_equal(read.mesh.points, POINTS)
    np.testing.assert_array_equal(read.mesh.triangles, TRIANGLES)
    np.testing.assert_array_equal(read.mesh.facets, MESH.facets)
    assert (read.mesh.labels, read.mesh.regions) == (("label 1",), ("region 3",))


def test_binary_vtk_of_freefem_with_its_table_of_colours(tmp_path):
    assert_same(read_nodal_field(vtk_binary(tmp_path / "a.vtk", POINTS, TRIANGLES, U), None), "u")


@pytest.mark.parametrize("version", ["vtk42", "vtk51"])
def test_binary_vtk_of_other_programs(version, tmp_path):
    blocks = [("line", MESH.facets[:, :2]), ("triangle", TRIANGLES)]
    data = {"u": U, "v": np.column_stack([U, U, 0 * U])}
    mesh = meshio.Mesh(np.column_stack([POINTS, 0 * U]), blocks, data, {"c": [np.ones(len(b)) for _, b in blocks]})
    meshio.write(tmp_path / "a.vtk", mesh, file_format=version, binary=True)
    assert_same(read_nodal_field(tmp_path / "a.vtk", "u"), "u")


def test_binary_vtk_that_ends_too_early_or_holds_nonsense(tmp_path):
    content = vtk_binary(tmp_path / "a.vtk", POINTS, TRIANGLES, U).read_bytes()
    short = [content[: len(content) * k // 40] for k in range(4, 39)]
    wrong = [
        content.replace(b"CELLS", b"CELLS -"),
        content.replace(b"double", b"doubel"),
        content.replace(b"FIELD", b"F"),
    ]
    huge = [
        content.replace(b"POINTS ", b"POINTS 9999999999999"),
        content.replace(b"Data 1", b"Data 99999999999999999999"),
    ]
    for text in (*short, *wrong, *huge):
        (tmp_path / "b.vtk").write_bytes(text)
        with pytest.raises((FileError, CaseError), match=r"b\.vtk: "):
            read_nodal_field(tmp_path / "b.vtk", None)


# Nodes of each cell


def test_both_sides_of_a_crack_that_opens_stay_apart(tmp_path):
    """A square cut from the left to its middle: u jumps there, and nodes on both sides are in one place."""
    x, y = np.meshgrid(np.arange(5.0), np.arange(5.0))
    points = np.column_stack([x.ravel(), y.ravel()])
    k = (np.arange(4)[:, None] * 5 + np.arange(4)).ravel()
    triangles = np.vstack([np.column_stack([k, k + 1, k + 6]), np.column_stack([k, k + 6, k + 5])])
    above = points[triangles].mean(axis=1)[:, 1] > 2
    u = np.where((above[:, None]) & (points[triangles][..., 0] < 2), 1.0, 0.0).ravel()
    path = vtu(tmp_path / "a.vtu", *apart(points, triangles, points[:, 0])[:2], {"u": u})
    found = read_nodal_field(path, None)
    # Only nodes on the line y = 2 with x < 2 are there twice; the last one, at x = 2, is the tip.
    assert len(found.points) == 25 + 2
    copies = found.points[(found.points[:, 1] == 2) & (found.points[:, 0] < 2)]
    np.testing.assert_array_equal(copies[np.lexsort(copies.T)], [[0, 2], [0, 2], [1, 2], [1, 2]])


def test_a_solution_that_jumps_everywhere_is_refused(tmp_path):
    points, cells, _ = WITH_NODES_OF_THEIR_OWN
    path = vtu(tmp_path / "a.vtu", points, cells, {"u": np.repeat(np.arange(len(cells)), 3).astype(float)})
    with pytest.raises(CaseError, match=r"a\.vtu: u jumps from cell to cell, .*: write its interpolation by linear"):
        read_nodal_field(path, None)


def test_places_are_as_exact_as_the_coordinates():
    points = np.array([[1.0, 0], [1 + 1e-15, 0], [1 + 1e-9, 0], [0, 1]])
    assert places(points, np.finfo(float).eps).tolist() == [places(points, np.finfo(float).eps)[0]] * 2 + [
        *places(points, np.finfo(float).eps)[2:]
    ]
    assert len(set(places(points, np.finfo(float).eps).tolist())) == 3
    assert len(set(places(points, np.finfo(np.float32).eps).tolist())) == 2


def test_very_many_nodes_in_one_place_are_no_mesh():
    points = 1 + 1e-12 * np.random.default_rng(0).uniform(size=(5000, 2))
    with pytest.raises(FileError, match="very many nodes are in one place"):
        places(points, 1e-9)


# Reasons


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.vtu", "hello", "is no XML: syntax error"),
        ("a.vtu", '<VTKFile type="PolyData"/>', "holds PolyData: only an UnstructuredGrid"),
        ("a.msh", "$MeshFormat\n9.9 0 8\n$EndMeshFormat\n", "is of version 9\\.9 of Gmsh's format"),
        ("a.msh", "hello\n", r"has no \$MeshFormat: it is no mesh of Gmsh"),
        (
            "a.inp",
            "*NODE\n1, 0, 0\n*ELEMENT, TYPE=ABC\n1, 1, 1, 1\n",
            "has elements of the type ABC, which is not known",
        ),
        ("a.su2", "hello\n", "has no NPOIN or no NELEM: it is no mesh of SU2"),
        (
            "a.mesh",
            "MFEM mesh v1.0\n",
            "is a mesh of MFEM's own format, which is not read: write the solution as ParaView",
        ),
        ("a.mesh", "hello\n", "has no Dimension 2 or 3"),
        ("a.h5", "x", "holds the numbers of an XDMF file: give the .xdmf file beside it"),
        ("a.xyz", "x", "is no mesh that can be read"),
        (
            "a.off",
            "OFF\n3 1 0\n0 0 0\n1 0",
            "is no mesh that can be read .its numbers are not as its format asks for: cannot reshape",
        ),
        (
            "a.avs",
            "3 1 0 0 0\n1 0 0 0\n",
            "is no mesh that can be read .it ends too early, or holds less than it tells",
        ),
        ("a.inp", b"*NODE\n1, 0, \xff\n", "is no mesh that can be read .it holds bytes that are no text"),
        ("a.msh", "3 1 0\n0 0 0\n1 0 0\n", "it ends too early: it has 6 of 13 numbers"),
    ],
)
def test_the_reason_is_told_with_the_file(name, content, message, tmp_path):
    (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(FileError, match=rf"{name}: ({message})") as caught:
        read_nodal_field(tmp_path / name, None)
    assert "format that its ending names" not in str(caught.value)
