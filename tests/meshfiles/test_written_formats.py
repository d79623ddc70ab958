"""Every format read back: points, cells, groups."""

import csv
import dataclasses
import json
import math
import re

import meshio
import numpy as np
import pytest
import skfem
from sandwiches import ODD, names_of, sandwich, written
from squares import holed_square

from bubblemesh.meshfiles.groups import facet_ids, group_names, node_ids, plain_words, region_ids
from bubblemesh.meshfiles.write.nodes import nodes_of


def parts_by_label(mesh):
    """Return the facets of each label as a set of sorted pairs."""
    return {
        label: {tuple(sorted(pair)) for pair in mesh.facets[mesh.facet_labels == index, :2].tolist()}
        for index, label in enumerate(mesh.labels)
    }


@pytest.mark.parametrize("form", ["msh", "msh-ascii"])
def test_meshio_reads_msh(mesh, tmp_path, form):
    read = meshio.read(written(mesh, tmp_path, form), file_format="gmsh")
    np.testing.assert_array_equal(read.points, np.pad(mesh.points, ((0, 0), (0, 1))))
    assert [block.type for block in read.cells] == ["vertex", "line", "triangle"]
    for cells, found in zip((mesh.labelled_nodes[:, None], mesh.facets, mesh.triangles), read.cells, strict=True):
        np.testing.assert_array_equal(found.data, cells)
    for name in ("gmsh:physical", "gmsh:geometrical"):
        for ids, found in zip((node_ids(mesh), facet_ids(mesh), region_ids(mesh)), read.cell_data[name], strict=True):
            np.testing.assert_array_equal(found, ids)
    assert {name: tuple(group) for name, group in read.field_data.items()} == group_names(mesh)


def test_binary_msh_is_what_meshio_writes(mesh, tmp_path):
    right, left = (np.flatnonzero(mesh.facet_labels == label) for label in (1, 3))
    mesh = dataclasses.replace(mesh, periodic=np.column_stack([left, right]))
    mesh.to_meshio(columns=3).write(tmp_path / "meshio.msh", file_format="gmsh22", binary=True)
    mesh.write(tmp_path / "own.msh")
    assert (tmp_path / "own.msh").read_bytes() == (tmp_path / "meshio.msh").read_bytes()


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
    ids = {0: node_ids(mesh), 1: facet_ids(mesh), 2: region_ids(mesh)}
    cells = {0: mesh.labelled_nodes[:, None], 1: mesh.facets, 2: mesh.triangles}
    for tag, dimension in group_names(mesh).values():
        found = [
            np.reshape(nodes, (-1, cells[dimension].shape[1]))
            for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, tag)
            for nodes in gmsh.model.mesh.getElements(dimension, entity)[2]
        ]
        np.testing.assert_array_equal(np.concatenate(found) - 1, cells[dimension][ids[dimension] == tag])
    assert gmsh.logger.getLastError() == ""


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
    assert refs[mesh.labelled_nodes].tolist() == [9, 10]
    rest = np.setdiff1d(np.arange(len(mesh.points)), mesh.labelled_nodes)
    np.testing.assert_array_equal(refs[rest] > 0, np.isin(rest, mesh.facets))


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
    for word, node in zip(words[8:], mesh.labelled_nodes, strict=True):
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
    assert np.flatnonzero(read.point_data["point_tags"]).tolist() == sorted(mesh.labelled_nodes)


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
    assert arrays["label"][mesh.labelled_nodes].tolist() == ["corner", "probe"]


def test_normals_of_a_square_point_out_of_it():
    mesh = holed_square()
    nodes = nodes_of(mesh, mesh.outer)
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
