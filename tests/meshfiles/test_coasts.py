"""Files for models of coasts: ADCIRC, SCHISM, SMS, Telemac and UGRID."""

import dataclasses

import h5py
import numpy as np
import pytest
from commands import command
from quadrilaterals import cells_by_places, facets_by_places, mixed
from sandwiches import sandwich, written
from scipy.io import netcdf_file
from squares import holed_square

from bubblemesh.api import Mesh
from bubblemesh.errors import BubblemeshError, FileError
from bubblemesh.meshes.edges import edge_keys
from bubblemesh.meshes.shores import boundary_rings, is_open, stretches
from bubblemesh.meshfiles.groups import facet_ids, region_ids
from bubblemesh.meshfiles.read import read_mesh
from bubblemesh.meshfiles.whole_mesh import whole_mesh, with_boundary

FORMS = {"fort.14": ".14", "gr3": ".gr3", "2dm": ".2dm", "slf": ".slf", "ugrid": ".nc"}

HOLD_QUADS = ("gr3", "2dm", "ugrid")


def sea(labels=("open south", "coast", "open_north", "cliff", "rock")):
    """A square of water, open in the south and the north, with an island, and its depth."""
    mesh = holed_square(labels=labels)
    return dataclasses.replace(mesh, depth=10 + mesh.points @ [3, -2])


def rim(mesh):
    """The mesh with the labels of its boundary alone."""
    of_facets = {name: getattr(mesh, name)[mesh.outer] for name in ("facets", "facet_labels", "facet_middles")}
    return dataclasses.replace(mesh, **of_facets)


# Stretches


@pytest.mark.parametrize(
    ("label", "opened"),
    [
        *[("open", True), ("Open", True), ("open_west", True), ("open-2", True), ("open 3", True), ("open3", True)],
        *[("opening", False), ("land", False), ("reopen", False), ("", False)],
    ],
)
def test_labels_named_open_are_open(label, opened):
    assert is_open(sea(), label) == opened
    assert is_open(dataclasses.replace(sea(), open_labels=("land",)), label) == (label == "land")


def test_stretches_follow_the_boundary_with_the_water_on_their_left():
    mesh = sea()
    found = stretches(mesh)
    assert [(each.kind, each.label, len(each.nodes)) for each in found] == [
        *[("open", "open south", 10), ("land", "coast", 10), ("open", "open_north", 10), ("land", "cliff", 10)],
        ("island", "rock", 12),
    ]
    for each, following in zip(found[:4], [*found[1:4], found[0]], strict=True):
        assert each.nodes[-1] == following.nodes[0]
    keys = edge_keys(mesh.facets, len(mesh.points))
    for each in found:
        nodes = np.append(each.nodes, each.nodes[:1]) if each.kind == "island" else each.nodes
        assert np.isin(edge_keys(np.column_stack([nodes[:-1], nodes[1:]]), len(mesh.points)), keys).all()


def test_a_ring_of_one_label_ends_where_it_begins_unless_it_is_an_island():
    mesh = sea(("shore", "shore-2", "shore-3", "shore-4", "rock"))
    mesh = dataclasses.replace(mesh, facet_labels=4 * (mesh.facet_labels == 4), open_labels=("none",))
    lake, island = stretches(mesh)
    assert (lake.kind, lake.nodes[0] == lake.nodes[-1], len(lake.nodes)) == ("land", True, 37)
    assert (island.kind, len(set(island.nodes.tolist())), len(island.nodes)) == ("island", 12, 12)
    around = dataclasses.replace(mesh, open_labels=("rock",))
    assert [(each.kind, len(each.nodes)) for each in stretches(around)] == [("land", 37), ("open", 13)]


def test_an_island_of_several_labels_is_one_boundary():
    mesh = sea()
    labels = np.where(mesh.facet_labels == 4, np.arange(len(mesh.facets)) % 2 * 3 + 1, mesh.facet_labels)
    *_, island = stretches(dataclasses.replace(mesh, facet_labels=labels))
    assert (island.kind, island.label, len(island.nodes)) == ("island", "coast, rock", 12)


def test_islands_that_meet_in_a_node_are_rings_of_their_own():
    """A square of 4 x 4 cells without those of the second and third on the diagonal."""
    at = np.array([(x, y) for y in range(5) for x in range(5)], float)
    cells = [(x, y) for y in range(4) for x in range(4) if (x, y) not in {(1, 1), (2, 2)}]
    corners = [[x + 5 * y, x + 1 + 5 * y, x + 6 + 5 * y, x + 5 + 5 * y] for x, y in cells]
    triangles = np.array([t for a, b, c, d in corners for t in ((a, b, c), (a, c, d))])
    bare = Mesh(at, triangles, np.zeros((0, 2), int), np.zeros(0, int), ())
    mesh = with_boundary(bare)
    assert sorted(map(len, boundary_rings(mesh))) == [4, 4, 16]
    assert [each.kind for each in stretches(mesh)] == ["land", "island", "island"]


# Round trips


@pytest.mark.parametrize("form", FORMS)
def test_what_is_written_is_read_back(form, tmp_path):
    mesh = dataclasses.replace(mixed(), open_labels=("left", "top"))
    mesh = dataclasses.replace(mesh, depth=np.hypot(*mesh.points.T), points=mesh.points + 1e6 * (form == "slf"))
    found, notes = whole_mesh(written(mesh, tmp_path, form))
    assert notes == ()
    np.testing.assert_array_equal(found.points, mesh.points)
    np.testing.assert_array_equal(found.depth, mesh.depth)
    inner = form in ("2dm", "ugrid")
    assert facets_by_places(found) == facets_by_places(mesh if inner else rim(mesh))
    expected = cells_by_places(mesh if form in HOLD_QUADS else mesh.in_triangles())
    assert cells_by_places(found) == (expected if inner else dict.fromkeys(expected, "domain"))


@pytest.mark.parametrize("form", FORMS)
def test_a_mesh_without_depth_has_none_or_zero(form, tmp_path):
    found, _ = whole_mesh(written(holed_square(), tmp_path, form))
    assert len(found.depth) == (0 if form == "ugrid" else 96)
    assert not found.depth.any()


@pytest.mark.parametrize("form", [*FORMS, "vtu"])
def test_depth_of_second_order_is_that_of_the_middle(form):
    mesh = sea()
    curved, _ = mesh.second_order()
    np.testing.assert_allclose(curved.depth, 10 + curved.points @ [3, -2])


# What the files say


@pytest.mark.parametrize(("form", "land", "island"), [("fort.14", "20", "21"), ("gr3", "0", "1")])
def test_a_grid_has_its_sections(form, land, island, tmp_path):
    mesh = sea()
    lines = written(mesh, tmp_path, form).read_text().splitlines()
    counts = [int(word) for word in lines[1].split()]
    assert counts == [len(mesh.triangles), len(mesh.points)]
    nodes, cells = lines[2 : 2 + counts[1]], lines[2 + counts[1] : 2 + sum(counts)]
    np.testing.assert_array_equal(
        [[float(word) for word in line.split()] for line in nodes],
        np.column_stack([np.arange(1, counts[1] + 1), mesh.points, mesh.depth]),
    )
    expected = np.insert(mesh.triangles + 1, 0, 3, axis=1)
    np.testing.assert_array_equal([[int(word) for word in line.split()][1:] for line in cells], expected)
    rest = iter(lines[2 + sum(counts) :])

    def section(width):
        number, total = (int(next(rest).split()[0]) for _ in range(2))
        heads = []
        for _ in range(number):
            head = next(rest).split()
            heads.append((*head[:width], head[-1]))
            total -= int(head[0])
            for _ in range(int(head[0])):
                assert 1 <= int(next(rest)) <= len(mesh.points)
        assert total == 0
        return heads

    assert section(1) == [("10", "south"), ("10", "open_north")]
    assert section(2) == [("10", land, "coast"), ("10", land, "cliff"), ("12", island, "rock")]
    assert list(rest) == []


def test_a_boundary_condition_of_telemac_for_each_boundary_node(tmp_path):
    mesh = sea()
    path = written(mesh, tmp_path, "slf")
    rows = [line.split(maxsplit=14) for line in path.with_suffix(".cli").read_text().splitlines()]
    assert [int(row[12]) for row in rows] == list(range(1, 49))
    numbers = [int(row[11]) for row in rows]
    assert sorted(numbers) == sorted({*(mesh.facets + 1).ravel().tolist()})
    assert numbers[0] - 1 == np.argmin(mesh.points.sum(axis=1))
    y = mesh.points[np.array(numbers) - 1, 1]
    opened = (y == y.min()) | (y == y.max())
    assert [row[0] for row in rows] == ["5" if each else "2" for each in opened]
    assert rows[0][13:] == ["#", "open: open south"]


def test_telemac_gets_double_precision_only_where_it_serves(tmp_path):
    for move, word, size in ((0.0, b"SERAFIN ", 4), (1e6, b"SERAFIND", 8)):
        mesh = dataclasses.replace(sea(), points=sea().points + move)
        content = written(mesh, tmp_path, "slf").read_bytes()
        assert content[76:84] == word
        n, t = len(mesh.points), len(mesh.triangles)
        sizes = [80, 8, 32, 40, 16, 12 * t, 4 * n, *[size * n] * 2, size, size * n]
        assert len(content) == sum(sizes) + 8 * len(sizes)


@pytest.mark.parametrize("form", ["fort.14", "gr3", "slf"])
def test_open_boundaries_are_read_back(form, tmp_path):
    mesh = dataclasses.replace(holed_square(), open_labels=("left",))
    path = written(mesh, tmp_path, form)
    found = Mesh.read(path)
    assert found.open_labels == ("left",)
    again = path.with_name(f"again{path.suffix}")
    found.write(again)
    boundaries = [each.with_suffix(".cli" if form == "slf" else each.suffix) for each in (path, again)]
    assert boundaries[0].read_bytes().count(b"open") > 0
    assert boundaries[0].read_bytes().count(b"open") == boundaries[1].read_bytes().count(b"open")


@pytest.mark.parametrize("geographic", [False, True])
def test_ugrid_tells_whether_coordinates_are_degrees(geographic, tmp_path):
    path = written(dataclasses.replace(holed_square(), geographic=geographic), tmp_path, "ugrid")
    with netcdf_file(path, mmap=False) as file:
        x, y = (file.variables[f"mesh2d_node_{axis}"] for axis in "xy")
        found = [x.standard_name, y.standard_name, getattr(x, "units", None), getattr(y, "units", None)]
    degrees = [b"longitude", b"latitude", b"degrees_east", b"degrees_north"]
    assert found == (degrees if geographic else [b"projection_x_coordinate", b"projection_y_coordinate", None, None])
    assert Mesh.read(path).geographic == geographic


def test_ugrid_tells_what_its_variables_are(tmp_path):
    mesh = dataclasses.replace(mixed(), depth=np.ones(96))
    with netcdf_file(written(mesh, tmp_path, "ugrid"), mmap=False) as file:
        topology = file.variables["mesh2d"]
        assert (topology.cf_role, topology.topology_dimension) == (b"mesh_topology", 2)
        faces = file.variables["mesh2d_face_nodes"]
        (triangles, _), (quads, _) = mesh.cells
        np.testing.assert_array_equal(faces[: len(triangles), :3], triangles + 1)
        assert (faces[: len(triangles), 3] == faces._FillValue).all()
        np.testing.assert_array_equal(faces[len(triangles) :], quads + 1)
        # Euler: one hole.
        assert len(mesh.points) - len(file.variables["mesh2d_edge_nodes"][:]) + len(faces[:]) == 0
        label = file.variables["mesh2d_edge_label"]
        assert sorted(label[label[:] > 0]) == sorted(facet_ids(mesh))
        assert label.flag_meanings == b"bottom right top left hole interface"
        assert set(file.variables["mesh2d_face_region"][:]) == set(region_ids(mesh))
        assert file.variables["mesh2d_node_z"].positive == b"up"
        np.testing.assert_array_equal(file.variables["mesh2d_node_z"][:], -1)


# Files of other programs

NODES = "1 0 0 5\n2 1 0 6\n3 1 1 7\n4 0 1 8\n"


def labels_of(path):
    mesh = read_mesh(path).mesh
    return dict(zip(mesh.labels, np.bincount(mesh.facet_labels).tolist(), strict=True))


def test_numbers_of_nodes_may_have_gaps_and_a_file_may_end_after_the_cells(tmp_path):
    (tmp_path / "a.gr3").write_text("t\n2 4 ! comment\n10 0 0 5\n7 1 0 6\n3 1 1 7\n1 0 1 8\n1 3 10 7 3\n2 3 10 3 1\n")
    read = read_mesh(tmp_path / "a.gr3")
    assert read.mesh.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert read.point_data["depth"].tolist() == [5, 6, 7, 8]
    assert read.mesh.labels == ()


def test_kinds_of_boundaries_have_names_without_labels(tmp_path):
    (tmp_path / "a.14").write_text(
        f"t\n2 4\n{NODES}1 3 1 2 3\n2 3 1 3 4\n1 = open\n2 = nodes\n2 = first\n1\n2\n"
        "3\n6\n2 22\n2\n3\n2 3\n3 2.0 1.0\n4 2.0 1.0\n2 20 ! land\n4\n1\n"
    )
    assert labels_of(tmp_path / "a.14") == {"open": 1, "land": 2, "weir": 1}


def test_both_sides_of_a_barrier_are_read(tmp_path):
    nodes = NODES + "5 2 0 0\n6 3 0 0\n7 3 1 0\n8 2 1 0\n"
    cells = "1 3 1 2 3\n2 3 1 3 4\n3 3 5 6 7\n4 3 5 7 8\n"
    (tmp_path / "a.grd").write_text(f"t\n4 8\n{nodes}{cells}0\n0\n1\n2\n2 24\n2 5 1 1 1\n3 8 1 1 1\n")
    assert labels_of(tmp_path / "a.grd") == {"weir": 2}


def test_node_strings_and_materials_of_sms(tmp_path):
    (tmp_path / "a.2dm").write_text(
        "MESH2D\nNUM_MATERIALS_PER_ELEM 1\nE3T 1 1 2 3 9\nE4Q 2 2 5 6 3 4\n"
        "ND 1 0.0 0.0 -1.5e0\nND 2 1 0 0\nND 3 1 1 0\nND 5 2 0 0\nND 6 2 1 0\nNS 1 2\n"
        "NS -5\nNS 5 -6 12\nNS 6 3 -1\nBEGPARAMDEF\n"
    )
    read = read_mesh(tmp_path / "a.2dm")
    assert read.mesh.regions == ("region 4", "region 9")
    assert labels_of(tmp_path / "a.2dm") == {"label 1": 2, "label 3": 2, "label 12": 1}
    assert read.point_data["elevation"].tolist() == [-1.5, 0, 0, 0, 0]
    assert len(read.mesh.quads) == 1


@pytest.mark.parametrize("order", "><")
def test_results_of_telemac_are_those_of_the_last_time(order, tmp_path):
    def record(content):
        data = content if isinstance(content, bytes) else np.asarray(content[1], order + content[0]).tobytes()
        length = np.array(len(data), order + "i4").tobytes()
        return length + data + length

    names = [f"{name:16}{unit:16}".encode() for name, unit in (("WATER DEPTH", "M"), ("BOTTOM", "M"))]
    parts = [f"{'a result':72}SERAFIN ".encode(), ("i4", [2, 0]), *names, ("i4", [1, 0, 100, 200, 0, 0, 0, 0, 0, 1])]
    parts += [("i4", [2020, 1, 1, 0, 0, 0]), ("i4", [2, 4, 3, 1]), ("i4", [1, 2, 3, 1, 3, 4]), ("i4", [1, 2, 3, 4])]
    parts += [("f4", [0, 1, 1, 0]), ("f4", [0, 0, 1, 1])]
    for time in (0, 60):
        parts += [("f4", [time]), ("f4", [time, 1, 2, 3]), ("f4", [-1, -2, -3, -4])]
    content = b"".join(map(record, parts))
    (tmp_path / "a.slf").write_bytes(content)
    read = read_mesh(tmp_path / "a.slf")
    assert read.mesh.points.tolist() == [[100, 200], [101, 200], [101, 201], [100, 201]]
    assert read.point_data["water depth"].tolist() == [60, 1, 2, 3]
    assert read.notes == ("has data of 2 times: the last one is taken",)
    assert whole_mesh(tmp_path / "a.slf")[0].depth.tolist() == [1, 2, 3, 4]
    assert read.mesh.labels == ()
    rows = [f"{code} 4 4 0 0 0 0 4 0 0 0 {k} {k}\n" for k, code in ((1, 5), (2, 5), (3, 2), (4, 2))]
    (tmp_path / "a.cli").write_text("".join(rows))
    assert labels_of(tmp_path / "a.slf") == {"open": 1, "land": 3}
    (tmp_path / "a.cli").write_text("2 2 2 0 0 0 0 2 0 0 0 9 1\n")
    with pytest.raises(FileError, match=r"a\.slf: the \.cli file names a node that is not there"):
        read_mesh(tmp_path / "a.slf")
    for end in (len(content) - 3, len(content) - 30, 90):
        (tmp_path / "a.slf").write_bytes(content[:end])
        with pytest.raises(FileError, match=r"a\.slf: "):
            read_mesh(tmp_path / "a.slf")


@pytest.mark.parametrize("turned", [False, True])
def test_ugrid_of_version_4_with_numbers_from_0(turned, tmp_path):
    with h5py.File(tmp_path / "a.nc", "w") as file:
        mesh = file.create_dataset("m", data=0)
        mesh.attrs.update(cf_role="mesh_topology", node_coordinates="m_x m_y", face_node_connectivity="faces")
        mesh.attrs["topology_dimension"] = np.array([2])
        file["m_x"], file["m_y"] = [0.0, 1, 1, 0, 2], [0.0, 0, 1, 1, 0]
        faces = np.array([[0, 1, 2, 3], [1, 4, 2, -9]])
        file["faces"] = faces.T if turned else faces
        file["faces"].attrs.update(_FillValue=-9, start_index=0)
        if turned:
            for dimension, name in enumerate(("corners", "cells")):
                file[name] = np.zeros(file["faces"].shape[dimension])
                file[name].make_scale(name)
                file["faces"].dims[dimension].attach_scale(file[name])
            mesh.attrs["face_dimension"] = "cells"
        file["depth"] = [[0.0] * 5, [1, 2, 3, 4, 5]]
        file["depth"].attrs.update(mesh="m", location="node", _FillValue=3.0)
    read = read_mesh(tmp_path / "a.nc")
    assert (len(read.mesh.triangles), len(read.mesh.quads)) == (3, 1)
    np.testing.assert_array_equal(read.point_data["depth"], [1, 2, np.nan, 4, 5])
    assert read.notes == ("has data of several times: the last one is taken",)


# Damage


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.14", "hello\nworld\n", "its counts of elements and nodes are no whole numbers"),
        ("a.14", "hello\n", "it ends too early: it has 1 of 2 lines"),
        ("a.gr3", "a\n1 9\n1 0 0 0\n", "it ends too early: it has 1 of 10 lines of nodes and elements"),
        ("a.gr3", f"a\n1 4\n{NODES}1 3 1 2 9\n", "names the node 9, which is not there"),
        ("a.gr3", f"a\n1 4\n{NODES}1 5 1 2 3 4 1\n", "has elements of 5 nodes"),
        ("a.14", f"a\n1 4\n{NODES}1 3 1 2 3\n1\n2\n2\n1\n", "it ends too early: it has 1 of 2 nodes of a boundary"),
        ("a.2dm", "MESH2D\n", "has no ND or no E3T and E4Q"),
        ("a.2dm", "E3T 1 1 2 3 1\nND 1 0 0 0\n", "names the node 2, which is not there"),
        ("a.slf", "hello", "does not begin with a title of 80 letters"),
        ("a.nc", "hello", "is no NetCDF file"),
        ("a.nc", "CDF\x01hello", "is a damaged NetCDF file"),
    ],
)
def test_the_reason_is_told_with_the_file(name, content, message, tmp_path):
    (tmp_path / name).write_text(content)
    with pytest.raises(FileError, match=rf"{name}: {message}"):
        read_mesh(tmp_path / name)


@pytest.mark.parametrize("form", FORMS)
def test_damaged_bytes_are_told_with_the_file(form, tmp_path):
    mesh = sandwich()
    path = written(dataclasses.replace(mesh, depth=np.ones(len(mesh.points))), tmp_path, form)
    whole, random = path.read_bytes(), np.random.default_rng(0)
    heads = 400 if form in ("slf", "ugrid") else len(whole)
    for count in range(120):
        content = bytearray(whole)
        places = random.integers(heads if count % 2 else len(whole), size=1 + count % 3)
        for place in places.tolist():
            content[place] = int(random.integers(256))
        path.write_bytes(content[: int(random.integers(len(whole)))] if count % 5 == 0 else content)
        try:
            read_mesh(path)
        except BubblemeshError as error:
            assert str(path) in str(error)  # noqa: PT017 - most damage is none to the format


# The command

CASE = """
domain:
  outer: {rectangle: [0, 0, 2, 1], labels: [south, east, north, west]}
  holes:
    - {circle: {center: [1, 0.5], radius: 0.2}, label: rock}
spacing: 0.2
output: {for: [adcirc, telemac], open: %s}
"""


def test_a_case_names_its_open_boundaries(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bay.yaml").write_text(CASE % "[west, south]")
    assert command("run", "bay.yaml", "-o", "out", "-q")[0] == 0
    text = (tmp_path / "out" / "bay.14").read_text()
    assert "2 = number of open boundaries" in text
    assert " open boundary 1: south" in text
    assert " island boundary 3: rock" in text
    code, _, said = command("quality", "out/bay.14")
    assert code == 0
    (tmp_path / "bay.yaml").write_text(CASE % "west-2")
    code, _, said = command("run", "bay.yaml", "-o", "out", "-q")
    assert code == 2
    assert "output.open: unknown label 'west-2'" in said
