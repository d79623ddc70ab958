"""Every format read back: points, cells, ids and names, of meshes with regions, inner lines and labelled points."""

import csv
import dataclasses
import json
import math
import re

import meshio
import numpy as np
import pytest
import skfem
from invariants import check_mesh
from test_output import fields_of, holed_square

from bubblemesh.errors import CaseError
from bubblemesh.meshes.conformity import require_conforming
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles import FORMATS, write_file, write_files
from bubblemesh.meshfiles.groups import facet_ids, group_names, region_ids, vertex_ids
from bubblemesh.meshfiles.names import plain_words
from bubblemesh.meshfiles.solvers import FORMATS_FOR, FormatName, Solver
from bubblemesh.meshfiles.write.nodes import nodes_of

ODD = ("on", "no", "äußere Wand", "1, 2", "a'b & <c>")


def sandwich(labels=("bottom", "right", "top", "left", "hole"), regions=("steel", "glass fibre")):
    """The square with a hole, its left third another region, and two labelled points."""
    mesh = holed_square(labels=labels)
    region = (mesh.points[mesh.triangles, 0].mean(axis=1) < mesh.points[:, 0].min() + 1).astype(int)
    owner = {side: k for k, t in enumerate(mesh.triangles.tolist()) for side in zip(t, t[1:] + t[:1], strict=True)}
    between = [side for side, k in owner.items() if region[k] == 0 and region[owner.get(side[::-1], k)] == 1]
    return dataclasses.replace(
        mesh,
        facets=np.vstack([mesh.facets, between]),
        facet_labels=np.append(mesh.facet_labels, np.full(len(between), 5)),
        labels=(*labels, "interface"),
        regions=regions,
        triangle_regions=region,
        vertices=np.array([0, len(mesh.points) - 1]),
        vertex_labels=np.array([0, 1]),
        point_labels=("corner", "probe"),
        facet_middles=np.zeros((0, 2)),
    )


@pytest.fixture(scope="module", params=["plain", "odd"])
def mesh(request):
    return sandwich() if request.param == "plain" else sandwich(ODD, ("domain", "on"))


def written(mesh, folder, form):
    """Write a mesh in one format, and return the path of its main file."""
    corners = dataclasses.replace(mesh, triangles=mesh.triangles[:, :3])
    files = write_files(mesh, fields_of(corners), {}, folder, "plate", [form])["files"]
    return folder / files[0]


def parts_by_label(mesh):
    """Return the facets of each label as a set of sorted pairs."""
    return {
        label: {tuple(sorted(pair)) for pair in mesh.facets[mesh.facet_labels == index, :2].tolist()}
        for index, label in enumerate(mesh.labels)
    }


def names_of(mesh):
    """Names of labels, regions and points as the groups have them."""
    names = list(group_names(mesh))
    ends = np.cumsum([len(mesh.labels), len(mesh.regions)])
    return names[: ends[0]], names[ends[0] : ends[1]], names[ends[1] :]


# Record and table


def test_every_format_and_solver_of_the_case_file_is_in_the_tables():
    assert tuple(FORMATS) == FormatName.__args__
    assert tuple(FORMATS_FOR) == Solver.__args__
    assert {form for forms in FORMATS_FOR.values() for form in forms} <= set(FORMATS)


def test_a_simple_mesh_has_one_region_and_no_points():
    mesh = holed_square()
    assert mesh.regions == ("domain",)
    assert mesh.order == 1
    assert len(mesh.vertices) == 0
    np.testing.assert_array_equal(mesh.triangle_regions, np.zeros(len(mesh.triangles)))
    np.testing.assert_array_equal(mesh.facet_middles, mesh.points[mesh.facets].mean(axis=1))


def test_a_mesh_with_regions_lines_and_points_is_sound(mesh):
    check_mesh(mesh)
    require_conforming(mesh)


def test_ids_of_labels_regions_and_points_never_collide():
    mesh = sandwich()
    assert group_names(mesh) == {
        **{"bottom": (1, 1), "right": (2, 1), "top": (3, 1), "left": (4, 1), "hole": (5, 1), "interface": (6, 1)},
        **{"steel": (7, 2), "glass fibre": (8, 2), "corner": (9, 0), "probe": (10, 0)},
    }
    assert set(facet_ids(mesh)) == {1, 2, 3, 4, 5, 6}
    assert set(region_ids(mesh)) == {7, 8}
    assert vertex_ids(mesh).tolist() == [9, 10]


def test_one_name_for_several_things_becomes_several_names():
    mesh = dataclasses.replace(sandwich(regions=("top", "top_region")), point_labels=("top", "hole"))
    labels, regions, points = names_of(mesh)
    assert labels[2] == "top"
    assert regions == ["top_region_region", "top_region"]
    assert points == ["top_point", "hole_point"]


def test_a_name_for_two_labels_is_refused():
    with pytest.raises(CaseError, match="the name 'a' is there twice"):
        group_names(holed_square(labels=("a", "b", "c", "a", "e")))


def test_sides_are_the_triangles_left_of_the_facets(mesh):
    for (triangle, side), (a, b) in zip(mesh.sides, mesh.facets, strict=True):
        corners = mesh.triangles[triangle].tolist()
        assert (corners[side], corners[(side + 1) % 3]) == (a, b)
    assert mesh.outer.tolist() == (mesh.facet_labels < 5).tolist()


def test_plain_words_are_words_and_differ():
    words = plain_words(dataclasses.replace(sandwich(ODD), point_labels=("Steel", "STEEL_9")), reserved=("ON",))
    assert all(re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]*", word) for word in words.values())
    assert len({word.upper() for word in words.values()} - {"ON"}) == len(words)
    assert words["äußere Wand"] == "au_ere_Wand"
    assert words["steel"] == "steel"


# Gmsh


@pytest.mark.parametrize("form", ["msh", "msh-ascii"])
def test_meshio_reads_msh(mesh, tmp_path, form):
    read = meshio.read(written(mesh, tmp_path, form), file_format="gmsh")
    np.testing.assert_array_equal(read.points, np.pad(mesh.points, ((0, 0), (0, 1))))
    assert [block.type for block in read.cells] == ["vertex", "line", "triangle"]
    for cells, found in zip((mesh.vertices[:, None], mesh.facets, mesh.triangles), read.cells, strict=True):
        np.testing.assert_array_equal(found.data, cells)
    for name in ("gmsh:physical", "gmsh:geometrical"):
        for ids, found in zip((vertex_ids(mesh), facet_ids(mesh), region_ids(mesh)), read.cell_data[name], strict=True):
            np.testing.assert_array_equal(found, ids)
    assert {name: tuple(group) for name, group in read.field_data.items()} == group_names(mesh)


@pytest.mark.parametrize("form", ["msh", "msh-ascii"])
def test_scikit_fem_reads_msh(mesh, tmp_path, form):
    read = skfem.MeshTri.load(written(mesh, tmp_path, form))
    labels, regions, _ = names_of(mesh)
    found = {
        name: {tuple(sorted(pair)) for pair in read.facets[:, indices].T.tolist()}
        for name, indices in read.boundaries.items()
    }
    # It knows facets of the boundary only in this format.
    assert found == {name: pairs for name, pairs in parts_by_label(mesh).items() if name != "interface"}
    counts = np.bincount(mesh.triangle_regions)
    assert {name: len(cells) for name, cells in read.subdomains.items()} == dict(zip(regions, counts, strict=True))
    assert labels == list(mesh.labels)


@pytest.mark.parametrize("form", ["msh", "msh-ascii"])
@pytest.mark.parametrize("order", [1, 2])
def test_gmsh_reads_msh(gmsh, mesh, tmp_path, form, order):
    mesh = mesh if order == 1 else mesh.second_order()[0]
    gmsh.open(str(written(mesh, tmp_path, form)))
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    order_of = np.argsort(tags)
    np.testing.assert_array_equal(tags[order_of], np.arange(1, len(mesh.points) + 1))
    np.testing.assert_array_equal(coordinates.reshape(-1, 3)[order_of, :2], mesh.points)
    named = {gmsh.model.getPhysicalName(*group): group[::-1] for group in gmsh.model.getPhysicalGroups()}
    assert named == group_names(mesh)
    ids = {0: vertex_ids(mesh), 1: facet_ids(mesh), 2: region_ids(mesh)}
    cells = {0: mesh.vertices[:, None], 1: mesh.facets, 2: mesh.triangles}
    for tag, dimension in group_names(mesh).values():
        found = [
            np.reshape(nodes, (-1, cells[dimension].shape[1]))
            for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, tag)
            for nodes in gmsh.model.mesh.getElements(dimension, entity)[2]
        ]
        np.testing.assert_array_equal(np.concatenate(found) - 1, cells[dimension][ids[dimension] == tag])
    assert gmsh.logger.getLastError() == ""


# Medit


def test_meshio_reads_medit(mesh, tmp_path):
    path = written(mesh, tmp_path, "mesh")
    assert path.read_text().startswith("MeshVersionFormatted 2\nDimension 2\n")
    read = meshio.read(path)
    np.testing.assert_array_equal(read.points, mesh.points)
    np.testing.assert_array_equal(read.cells_dict["line"], mesh.facets)
    np.testing.assert_array_equal(read.cells_dict["triangle"], mesh.triangles)
    lines, triangles = read.cell_data["medit:ref"]
    np.testing.assert_array_equal(lines, facet_ids(mesh))
    np.testing.assert_array_equal(triangles, region_ids(mesh))
    refs = read.point_data["medit:ref"]
    assert refs[mesh.vertices].tolist() == [9, 10]
    rest = np.setdiff1d(np.arange(len(mesh.points)), mesh.vertices)
    np.testing.assert_array_equal(refs[rest] > 0, np.isin(rest, mesh.facets))


# Abaqus and CalculiX


def keyword_blocks(path):
    """Keyword with its options, and the rows of numbers or words, of each block of an input file."""
    for block in re.split(r"^\*(?=[A-Z])", path.read_text(), flags=re.M)[1:]:
        head, *rows = block.splitlines()
        keyword, *options = head.split(", ")
        yield (
            keyword,
            dict(option.split("=") for option in options),
            [row.split(", ") for row in rows if not row.startswith("**")],
        )


@pytest.mark.parametrize(("form", "kind"), [("inp", "CPS"), ("inp-strain", "CPE")])
@pytest.mark.parametrize("order", [1, 2])
def test_sets_of_an_input_file(mesh, tmp_path, form, kind, order):
    mesh = mesh if order == 1 else mesh.second_order()[0]
    path = written(mesh, tmp_path, form)
    blocks = list(keyword_blocks(path))
    words = list(plain_words(mesh, reserved=("NALL", "EALL")).values())
    points = {int(row[0]): tuple(map(float, row[1:])) for key, _, rows in blocks if key == "NODE" for row in rows}
    assert list(points) == list(range(1, len(mesh.points) + 1))
    np.testing.assert_array_equal([points[k] for k in points], np.pad(mesh.points, ((0, 0), (0, 1))))
    elements = {}
    for word, index in zip(words[6:8], (0, 1), strict=True):
        (rows,) = (rows for key, o, rows in blocks if key == "ELEMENT" and o["ELSET"] == word)
        assert [o["TYPE"] for key, o, _ in blocks if key == "ELEMENT"] == [f"{kind}{3 * order}"] * 2
        numbers = np.array(rows, int)
        np.testing.assert_array_equal(numbers[:, 0] - 1, np.flatnonzero(mesh.triangle_regions == index))
        elements |= {int(row[0]): row[1:] for row in numbers}
    np.testing.assert_array_equal([elements[k + 1] for k in range(len(mesh.triangles))], mesh.triangles + 1)
    for index, word in enumerate(words[:6]):
        mine = mesh.facets[mesh.facet_labels == index]
        (rows,) = (rows for key, o, rows in blocks if key == "NSET" and o["NSET"] == word)
        assert max(map(len, rows)) <= 16
        assert {int(k) - 1 for row in rows for k in row} == set(mine.ravel().tolist())
        (rows,) = (rows for key, o, rows in blocks if key == "SURFACE" and o["NAME"] == word)
        sides = [(int(element), int(side[1:]) - 1) for element, side in rows]
        pairs = [(elements[element][side] - 1, elements[element][(side + 1) % 3] - 1) for element, side in sides]
        assert pairs == [tuple(pair) for pair in mine[:, :2].tolist()]
    for word, node in zip(words[8:], mesh.vertices, strict=True):
        assert [rows for key, o, rows in blocks if key == "NSET" and o["NSET"] == word] == [[[str(node + 1)]]]


def test_names_that_input_files_cannot_hold_are_explained(tmp_path):
    path = written(sandwich(ODD), tmp_path, "inp")
    assert "** au_ere_Wand stands for äußere Wand\n" in path.read_text()
    sidecar = json.loads((tmp_path / "plate.labels.json").read_text())
    assert sidecar["äußere Wand"] == {"id": 3, "dimension": 1, "written": {"inp": "au_ere_Wand"}}
    assert sidecar["on"] == {"id": 1, "dimension": 1}


def test_numbers_of_an_input_file_fit_their_fields(tmp_path):
    mesh = dataclasses.replace(sandwich(), facet_middles=np.zeros((0, 2)))
    mesh = dataclasses.replace(mesh, points=-mesh.points * 1.2345678901234567e-5)
    ((_, _, rows),) = (block for block in keyword_blocks(written(mesh, tmp_path, "inp")) if block[0] == "NODE")
    assert max(len(number) for row in rows for number in row) == 20
    np.testing.assert_allclose([[float(x), float(y)] for _, x, y, _ in rows], mesh.points, rtol=1e-13)


# SU2


def test_su2_has_a_marker_for_each_label(mesh, tmp_path):
    text = written(mesh, tmp_path, "su2").read_text()
    head, *markers = text.split("MARKER_TAG= ")
    numbers = {key: int(count) for key, count in re.findall(r"(\w+)= (\d+)", head)}
    assert numbers == {"NDIME": 2, "NELEM": len(mesh.triangles), "NPOIN": len(mesh.points), "NMARK": 6}
    rows = [line.split() for line in head.splitlines() if "=" not in line]
    cells, points = rows[: len(mesh.triangles)], rows[len(mesh.triangles) :]
    np.testing.assert_array_equal(np.array(cells, int), np.insert(mesh.triangles, 0, 5, axis=1))
    np.testing.assert_array_equal(np.array(points, float), mesh.points)
    for index, (marker, word) in enumerate(zip(markers, plain_words(mesh).values(), strict=False)):
        name, count, *lines = marker.splitlines()
        mine = mesh.facets[mesh.facet_labels == index]
        assert (name, count) == (word, f"MARKER_ELEMS= {len(mine)}")
        np.testing.assert_array_equal(np.array([line.split() for line in lines], int), np.insert(mine, 0, 3, axis=1))


# MED


@pytest.mark.parametrize("order", [1, 2])
def test_meshio_reads_med(mesh, tmp_path, order):
    mesh = mesh if order == 1 else mesh.second_order()[0]
    read = meshio.read(written(mesh, tmp_path, "med"))
    np.testing.assert_array_equal(read.points, mesh.points)
    for cells, found in zip((mesh.facets, mesh.triangles), read.cells, strict=True):
        np.testing.assert_array_equal(found.data, cells)
    lines, triangles = read.cell_data["cell_tags"]
    np.testing.assert_array_equal(lines, -facet_ids(mesh))
    np.testing.assert_array_equal(triangles, -region_ids(mesh))
    words = list(plain_words(mesh).values())
    assert read.cell_tags == {-(k + 1): [word] for k, word in enumerate(words[:8])}
    assert read.point_tags == {9: [words[8]], 10: [words[9]]}
    assert np.flatnonzero(read.point_data["point_tags"]).tolist() == sorted(mesh.vertices)


# OpenFOAM


def test_openfoam_gets_a_layer_of_prisms_with_closed_patches(mesh, tmp_path):
    read = meshio.read(written(mesh, tmp_path, "openfoam"), file_format="gmsh")
    n, t = len(mesh.points), len(mesh.triangles)
    prisms, quads, triangles = (read.cells_dict[kind] for kind in ("wedge", "quad", "triangle"))
    np.testing.assert_array_equal(prisms, np.hstack([mesh.triangles, mesh.triangles + n]))
    np.testing.assert_array_equal(read.points[:n, :2], mesh.points)
    np.testing.assert_array_equal(read.points[:n, :2], read.points[n:, :2])
    assert set(read.points[:n, 2]) == {0.0}
    (height,) = set(read.points[n:, 2])
    assert height == pytest.approx(1 / 3 / math.sqrt(2))
    names = {name: tuple(group) for name, group in read.field_data.items()}
    words = list(plain_words(mesh, reserved=("FRONT", "BACK")).values())
    assert {name for name, (_, dimension) in names.items() if dimension == 2} == {*words[:6], "front", "back"}
    assert {name for name, (_, dimension) in names.items() if dimension == 3} == set(words[6:8])
    ids = {block.type: [] for block in read.cells}
    for block, tags in zip(read.cells, read.cell_data["gmsh:physical"], strict=True):
        ids[block.type] += list(tags)
    np.testing.assert_array_equal(ids["wedge"], region_ids(mesh))
    np.testing.assert_array_equal(ids["quad"], facet_ids(mesh))
    assert ids["triangle"] == [names["front"][0]] * t + [names["back"][0]] * t
    # Every face of one prism alone is in a patch; faces between two are in none, but for the interface.
    faces = {}
    for a, b, c, d, e, f in prisms.tolist():
        for face in ((a, b, c), (d, e, f), (a, b, e, d), (b, c, f, e), (c, a, d, f)):
            faces[frozenset(face)] = faces.get(frozenset(face), 0) + 1
    outer = {face for face, count in faces.items() if count == 1}
    assert {frozenset(face) for face in triangles.tolist()} < outer
    boundary = quads[mesh.outer].tolist()
    assert {frozenset(face) for face in (*triangles.tolist(), *boundary)} == outer


def test_patches_named_like_those_of_the_plane_get_other_names(tmp_path):
    mesh = holed_square(labels=("front", "Back", "c", "d", "e"))
    path = written(mesh, tmp_path, "openfoam")
    read = meshio.read(path, file_format="gmsh")
    assert {"front", "back", "front_1", "Back_2", "domain"} < set(read.field_data)


# Nodes alone


def test_nodes_as_table_and_arrays(mesh, tmp_path):
    with written(mesh, tmp_path, "nodes.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    arrays = np.load(written(mesh, tmp_path, "nodes.npz"))
    assert list(rows[0]) == list(arrays) == ["x", "y", "boundary", "label", "nx", "ny"]
    for name in ("x", "y", "nx", "ny"):
        np.testing.assert_array_equal([float(row[name]) for row in rows], arrays[name])
    assert [row["label"] for row in rows] == arrays["label"].tolist()
    np.testing.assert_array_equal([row["boundary"] == "1" for row in rows], arrays["boundary"])
    np.testing.assert_array_equal(np.column_stack([arrays["x"], arrays["y"]]), mesh.points)
    inner = np.setdiff1d(mesh.facets[~mesh.outer], mesh.facets[mesh.outer])
    assert arrays["boundary"].sum() == len(np.unique(mesh.facets[mesh.outer]))
    assert set(arrays["label"][inner]) == {"interface"}
    assert not arrays["boundary"][inner].any()
    assert arrays["label"][mesh.vertices].tolist() == ["corner", "probe"]


def test_normals_of_a_square_point_out_of_it():
    nodes = nodes_of(holed_square())
    by_label = {"bottom": (0, -1), "right": (1, 0), "top": (0, 1), "left": (-1, 0)}
    x, y = nodes.x - nodes.x.min(), nodes.y - nodes.y.min()
    corner = np.isclose(x % 3, 0) & np.isclose(y % 3, 0)
    for label, normal in by_label.items():
        mine = (nodes.label == label) & ~corner & ~np.isclose(x % 3, 3)
        assert mine.sum() >= 7
        np.testing.assert_allclose(np.column_stack([nodes.nx, nodes.ny])[mine], [normal] * mine.sum(), atol=1e-12)
    lower_left = np.flatnonzero(np.isclose(x, 0) & np.isclose(y, 0))
    np.testing.assert_allclose(
        [nodes.nx[lower_left], nodes.ny[lower_left]], [[-math.sqrt(0.5)], [-math.sqrt(0.5)]], atol=1e-12
    )
    assert set(np.hypot(nodes.nx, nodes.ny)[~nodes.boundary]) == {0.0}


# Sidecar


@pytest.mark.parametrize("form", FORMATS)
def test_the_sidecar_is_there_where_a_format_needs_it(tmp_path, form):
    files = write_files(sandwich(regions=("a", "b")), {}, {}, tmp_path, "plate", [form])["files"]
    needed = form in {"vtu", "vtk", "xdmf", "mesh", "su2", "dat", "openfoam"}
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
    write_files(mesh, {}, {}, tmp_path, "plate", [form, "vtu"])
    sidecar = json.loads((tmp_path / "plate.labels.json").read_text())
    assert {entry["dimension"] for entry in sidecar.values() if "written" in entry} == dimensions


@pytest.mark.parametrize("form", FORMATS)
def test_without_points_the_sidecar_is_there_for_ids_only(tmp_path, form):
    files = write_files(holed_square(), {}, {}, tmp_path, "plate", [form])["files"]
    assert ("plate.labels.json" in files) == (form in {"vtu", "vtk", "xdmf", "mesh", "dat"})


def test_the_format_of_an_ending_is_the_first_that_has_it(tmp_path):
    mesh = holed_square()
    for name, start in (("a.msh", b"$MeshFormat\n2.2 1 8"), ("a.inp", b"*HEADING"), ("b.nodes.csv", b"x,y,boundary")):
        assert write_file(mesh, {}, {}, tmp_path / name)["files"][0] == name
        assert (tmp_path / name).read_bytes().startswith(start)


# Second order


def test_second_order_adds_one_node_for_each_edge():
    mesh = sandwich()
    curved, straight = mesh.second_order()
    assert (curved.order, straight) == (2, 0)
    pairs, _ = unique_edges(mesh.triangles)
    assert len(curved.points) == len(mesh.points) + len(pairs)
    corners = curved.points[curved.triangles[:, :3]]
    for k in range(3):
        middle = (corners[:, k] + corners[:, (k + 1) % 3]) / 2
        np.testing.assert_allclose(curved.points[curved.triangles[:, 3 + k]], middle, atol=1e-15)
    np.testing.assert_allclose(
        curved.points[curved.facets[:, 2]], curved.points[curved.facets[:, :2]].mean(axis=1), atol=1e-15
    )
    np.testing.assert_array_equal(np.unique(curved.triangles), np.arange(len(curved.points)))


@pytest.mark.parametrize("form", [name for name, form in FORMATS.items() if 2 in form.orders])
def test_second_order_survives(tmp_path, form):
    mesh, _ = sandwich(regions=("a", "b")).second_order()
    path = written(mesh, tmp_path, form)
    if form in {"inp", "inp-strain"}:
        return  # read by a parser of its own above; meshio knows one of the two kinds only
    read = meshio.read(path, file_format="gmsh" if path.suffix == ".msh" else None)
    np.testing.assert_array_equal(read.points[:, :2], mesh.points)
    np.testing.assert_array_equal(read.cells_dict["triangle6"], mesh.triangles)
    if form == "xdmf":
        read = meshio.read(tmp_path / "plate_facets.xdmf")
    if form in {"msh", "msh-ascii", "xdmf", "med"}:
        np.testing.assert_array_equal(read.cells_dict["line3"], mesh.facets)


@pytest.mark.parametrize("form", [name for name, form in FORMATS.items() if 2 not in form.orders])
def test_formats_without_second_order_say_so(tmp_path, form):
    mesh, _ = sandwich().second_order()
    with pytest.raises(CaseError, match=rf"{form} has no form for triangles of order 2: choose among msh, vtu"):
        write_files(mesh, {}, {}, tmp_path / "new", "plate", ["msh", form])
    assert list(tmp_path.iterdir()) == []


def test_a_triangle_that_would_fold_over_stays_straight():
    triangle = Mesh(
        points=np.array([[0.0, 0], [1, 0], [0.5, 0.1]]),
        triangles=np.array([[0, 1, 2]]),
        facets=np.array([[0, 1], [1, 2], [2, 0]]),
        facet_labels=np.zeros(3, int),
        labels=("a",),
        facet_middles=np.array([[0.5, 0.2], [0.75, 0.05], [0.25, 0.05]]),
    )
    curved, straight = triangle.second_order()
    assert straight == 1
    np.testing.assert_array_equal(curved.points[curved.facets[0, 2]], [0.5, 0])
    outward, straight = dataclasses.replace(
        triangle, facet_middles=np.array([[0.5, -0.05], [0.75, 0.05], [0.25, 0.05]])
    ).second_order()
    assert straight == 0
    np.testing.assert_array_equal(outward.points[outward.facets[0, 2]], [0.5, -0.05])
