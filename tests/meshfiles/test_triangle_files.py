"""Meshes of the Triangle program."""

import numpy as np
import pytest

from bubblemesh.errors import FileError
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.meshfiles.fields import read_field
from bubblemesh.meshfiles.read import read_mesh
from bubblemesh.meshfiles.whole_mesh import whole_mesh

NODES = """# made by hand
5 2 1 1
1  0 0   7    1
2  1 0   7.5  1

3  1 1   8    1  # a corner
4  0 1   9    0
5  .5 .5 1    0
"""
TRIANGLES = "4 3 1\n1 1 2 5 10\n2 2 3 5 10\n3 3 4 5 20\n4 4 1 5 20\n# end\n"
# Of Triangle's six nodes the fourth is across from the first.
CURVED_NODES = "6 2 1 0\n0 0 0 1\n1 1 0 1\n2 0 1 1\n3 .5 .5 1\n4 0 .5 1\n5 .5 0 1\n"
CURVED = "1 6 0\n0 0 1 2 3 4 5\n"


@pytest.fixture
def pair(tmp_path):
    def write(nodes, triangles):
        (tmp_path / "a.node").write_text(nodes)
        (tmp_path / "a.ele").write_text(triangles)
        return tmp_path / "a.ele"

    return write


@pytest.mark.parametrize("ending", [".node", ".ele"])
def test_either_of_the_two_files_gives_the_mesh_and_its_data(pair, ending):
    found = read_mesh(pair(NODES, TRIANGLES).with_suffix(ending))
    assert found.mesh.points.tolist() == [[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.5]]
    assert found.mesh.triangles.tolist() == [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]
    assert found.point_data["attribute"].tolist() == [7, 7.5, 8, 9, 1]
    assert found.point_data["marker"].tolist() == [1, 1, 1, 0, 0]
    assert found.cell_data["attribute"].tolist() == [10, 10, 20, 20]


def test_numbers_may_begin_at_zero_and_heads_may_be_short(pair):
    found = read_mesh(pair("3\n0 0 0\n1 1 0\n2 0 1\n", "1\n0 0 1 2\n"))
    assert found.mesh.triangles.tolist() == [[0, 1, 2]]


def test_nodes_halfway_are_where_they_are(pair):
    field = read_field(pair(CURVED_NODES, CURVED), "attribute")
    areas = signed_areas(field.points, field.triangles)
    np.testing.assert_allclose(areas, 1 / 8)


@pytest.mark.parametrize(
    ("nodes", "triangles", "message"),
    [
        ("# nothing\n", TRIANGLES, "a.node: the end of the file: expected the number of nodes"),
        ("0 2 0 0\n", TRIANGLES, "a.node: has no nodes"),
        ("9999999999 2 0 0\n1 0 0\n", TRIANGLES, "a.node: the end of the file: expected a node"),
        ("3 2 0 0\n1 0 0\n2 1\n3 1 1\n", TRIANGLES, "a.node: line 3: expected a node: its number, x, y"),
        ("3 2 5000000 1\n1 0 0\n2 1 1\n3 1 1\n", TRIANGLES, "a.node: line 2: expected a node: .* its attributes"),
        ("3 2 -1 0\n1 0 0\n2 1 1\n3 1 1\n", TRIANGLES, "a.node: line 1: -1 is no count"),
        ("3 3 0 0\n1 0 0 0\n2 1 1 0\n3 1 1 1\n", TRIANGLES, "nodes of 3 dimensions: only meshes of the plane"),
        ("3 2 0 0\n1 0 0\n2 1 x\n3 1 1\n", TRIANGLES, "a.node: line 3: not a row of numbers: '2 1 x'"),
        ("3 2 0 0\n1 0 0\n4 1 0\n3 1 1\n", "1 3 0\n1 1 2 3\n", "line 3: 4 is not the number of the next node"),
        ("3 2 0 0\n.5 0 0\n1.5 1 0\n2.5 1 1\n", "1 3 0\n1 1 2 3\n", "line 2: 0.5 is not .* by whole numbers"),
        ("1.5 2 0 0\n1 0 0\n", TRIANGLES, "a.node: line 1: 1.5 is no count: expected the number of nodes"),
        (NODES, "", "a.ele"),
        (NODES, "# c\n", "a.ele: the end of the file: expected the number of triangles"),
        (NODES, "0 3 0\n", "a.ele: has no triangles"),
        (NODES, "1 4 0\n1 1 2 3 4\n", "cells of 4 nodes"),
        (NODES, "1 3 0\n1 1 2 9\n", r"a.ele: line 2: there is no node 9: they have the numbers 1 to 5"),
        (NODES, "1 3 0\n1 0 1 2\n", "line 2: there is no node 0: "),
        (NODES, "1 3 0\n\n1 1 2 1.5\n", "line 3: there is no node 1.5: "),
        (NODES, "1 3 0\n1 1 2 nan\n", "line 2: there is no node nan: "),
        (NODES, "1 6 0\n1 1 2 3\n", "line 2: expected a triangle: its number, 6 nodes and its attributes"),
        (NODES, "1 3 1\n1 1 2 5\n", "line 2: expected a triangle"),
    ],
)
def test_what_is_damaged_is_told_with_its_line(pair, nodes, triangles, message):
    path = pair(nodes, triangles)
    with pytest.raises(FileError, match=message) as caught:
        read_mesh(path)
    assert str(caught.value).count("a.ele: ") == 1


@pytest.mark.parametrize(("missing", "given"), [(".node", ".ele"), (".ele", ".node")])
def test_the_file_of_the_two_that_is_missing_is_named(missing, given, pair):
    path = pair(NODES, TRIANGLES)
    path.with_suffix(missing).unlink()
    with pytest.raises(FileError, match=f"a{given}: a{missing} beside it: the file cannot be read: No such file"):
        read_mesh(path.with_suffix(given))


@pytest.mark.parametrize(("ending", "what"), [(".poly", "segments"), (".edge", "edges")])
def test_a_file_without_triangles_leads_to_the_one_that_has_them(ending, what, pair):
    path = pair(NODES, TRIANGLES).with_suffix(ending)
    path.write_text("4 1\n")
    with pytest.raises(FileError, match=f"a{ending}: holds {what} without triangles: give the .ele file"):
        read_mesh(path)


# Of the square of NODES as Triangle writes them: a diagonal has a marker, the left side that of no segment.
EDGES = (
    "8 1\n1 1 2 5\n2 2 3 5\n3 4 3 -2\n4 4 1 1\n5 1 5 7\n6 2 5 0\n7 3 5 7\n8 4 5 0\n# Generated by triangle -pqAe a\n"
)
SEGMENTS = "0 2 1 1\n6 1\n1 1 2 5\n2 2 3 5\n3 4 3 -2\n4 4 1 1\n5 5 1 7\n6 3 5 7\n0\n# Generated by triangle\n"


def labelled(mesh):
    """Middles of the edges with each label."""
    middles = mesh.points[mesh.facets].mean(axis=1).tolist()
    return {
        label: sorted(tuple(at) for at, own in zip(middles, mesh.facet_labels, strict=True) if own == k)
        for k, label in enumerate(mesh.labels)
    }


MARKED = {
    "label 5": [(0.5, 0), (1, 0.5)],
    "label -2": [(0.5, 1)],
    "label 1": [(0, 0.5)],
    "label 7": [(0.25, 0.25), (0.75, 0.75)],
}


@pytest.mark.parametrize(
    "beside",
    [
        {".edge": EDGES},
        {".poly": SEGMENTS},
        {".edge": EDGES, ".poly": "damaged"},  # a file of edges has all that is in the other one
        {".edge": "2 0\n1 1 2\n2 2 3\n", ".poly": SEGMENTS},  # without markers
        {".poly": SEGMENTS.replace("0 2 1 1", NODES, 1)},  # what Triangle began with, whose segments stayed whole
    ],
)
def test_attributes_are_regions_and_markers_labels(beside, pair):
    path = pair(NODES, TRIANGLES)
    for ending, text in beside.items():
        path.with_suffix(ending).write_text(text)
    read = read_mesh(path)
    assert labelled(read.mesh) == MARKED
    assert [read.mesh.regions[k] for k in read.mesh.triangle_regions] == ["region 10"] * 2 + ["region 20"] * 2
    assert read.cell_data["attribute"].tolist() == [10, 10, 20, 20]
    assert read.notes == ()
    whole, _ = whole_mesh(path)
    assert set(whole.labels) == set(MARKED)


def test_without_markers_and_whole_attributes_there_are_no_names(pair):
    read = read_mesh(pair(NODES, TRIANGLES.replace(" 10\n", " 10.5\n")))
    assert (read.mesh.labels, read.mesh.regions) == ((), ())
    assert read.cell_data["attribute"].tolist() == [10.5, 10.5, 20, 20]
    path = pair(NODES, "4 3 0\n1 1 2 5\n2 2 3 5\n3 3 4 5\n4 4 1 5\n")
    path.with_suffix(".edge").write_text(EDGES)
    read = read_mesh(path)
    assert (labelled(read.mesh), read.mesh.regions, read.cell_data) == (MARKED, (), {})


@pytest.mark.parametrize(
    ("ending", "text", "message"),
    [
        (".edge", "# c\n", "a.edge: the end of the file: expected the number of edges"),
        (
            ".edge",
            EDGES.partition("6 2")[0],
            "a.edge: the end of the file: expected an edge: its number, two nodes and",
        ),
        (".edge", EDGES.replace("2 2 3 5", "2 2 3"), "a.edge: line 3: expected an edge"),
        (
            ".edge",
            EDGES.replace("2 2 3 5", "2 2 6 5"),
            "a.edge: line 3: there is no node 6: they have the numbers 1 to 5",
        ),
        (
            ".edge",
            EDGES.replace("2 2 3 5", "2 2 4 5"),
            "a.edge: line 3: there is no edge of the mesh from 2 to 4: is it",
        ),
        (".edge", EDGES.replace("2 2 3 5", "2 2 3 .5"), "a.edge: line 3: its marker 0.5 is no whole number"),
        (".edge", EDGES.replace("2 2 3 5", "2 2 3 nan"), "a.edge: line 3: its marker nan is no whole number"),
        (".edge", EDGES.replace("2 2 3 5", "2 2 x 5"), "a.edge: line 3: not a row of numbers"),
        (".poly", "0 2 0 1\n", "a.poly: the end of the file: expected the number of segments"),
        (".poly", SEGMENTS.replace("2 2 3 5", "2 2 4 5"), "a.poly: line 4: there is no edge of the mesh from 2 to 4"),
        (".poly", SEGMENTS.partition("6 3")[0], "a.poly: the end of the file: expected a segment"),
    ],
)
def test_a_damaged_file_of_markers_or_one_of_another_mesh_is_told(ending, text, message, pair):
    path = pair(NODES, TRIANGLES)
    path.with_suffix(ending).write_text(text)
    with pytest.raises(FileError, match=message):
        read_mesh(path)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (("1 1 2 5", "1 1 3 5"), "line 10: there is no edge of the mesh from 1 to 3: is it of another mesh?"),
        (("2  1 0 ", "2  1 .1 "), "line 4: the node 2 is in another place"),
    ],
)
def test_markers_of_segments_that_triangle_divided_are_left_out_with_a_note(change, why, pair):
    path = pair(NODES, TRIANGLES)
    path.with_suffix(".poly").write_text(SEGMENTS.replace("0 2 1 1", NODES.strip(), 1).replace(*change))
    read = read_mesh(path)
    told = "has markers of other edges, which are left out; triangle -e writes those of the mesh"
    assert read.notes == (f"a.poly beside it {told}: {why}",)
    assert read.mesh.labels == ()


def written_as_triangle_does(path, made, zero):
    """Write what the library gives, as the program does: numbers from 0 or 1 on, a remark at the end."""
    k = 0 if zero else 1

    def section(head, columns):
        rows = np.column_stack([np.arange(len(columns[0])) + k, *columns]) if columns else []
        return "".join(f"{' '.join(f'{x:.17g}' for x in row)}\n" for row in [head, *rows])

    nodes, cells, edges = len(made["vertices"]), made["triangles"], made["edges"]
    files = {
        ".node": section([nodes, 2, 0, 1], [made["vertices"], made["vertex_markers"]]),
        ".ele": section([*cells.shape, 1], [cells + k, made["triangle_attributes"]]),
        ".edge": section([len(edges), 1], [edges + k, made["edge_markers"]]),
        ".poly": "0 2 0 1\n"
        + section([len(made["segments"]), 1], [made["segments"] + k, made["segment_markers"]])
        + "0\n",
    }
    for ending, text in files.items():
        path.with_suffix(ending).write_text(f"{text}# Generated by triangle -pqAea.05 plate.poly\n")


@pytest.mark.parametrize("zero", [False, True])
@pytest.mark.parametrize("switches", ["pqAea.05", "pqAea.05o2"])
def test_a_mesh_of_the_program_has_its_regions_and_labels(switches, zero, tmp_path):
    triangle = pytest.importorskip("triangle")
    corners = [[0, 0], [2, 0], [2, 1], [0, 1], [1, 0], [1, 1]]
    plate = {
        "vertices": corners,
        "segments": [[0, 4], [4, 1], [1, 2], [2, 5], [5, 3], [3, 0], [4, 5]],
        "segment_markers": [[5], [5], [2], [0], [0], [3], [7]],
        "regions": [[0.5, 0.5, 1, 0], [1.5, 0.5, 2, 0]],
    }
    path = tmp_path / "plate.1.ele"
    written_as_triangle_does(path, triangle.triangulate(plate, switches), zero)
    lengths = {"label 5": 2, "label 2": 1, "label 1": 2, "label 3": 1, "label 7": 1}
    for ending in (".edge", ".poly"):
        read = read_mesh(path)
        mesh = read.mesh
        along = np.linalg.norm(np.diff(mesh.points[mesh.facets], axis=1)[:, 0], axis=1)
        found = {label: along[mesh.facet_labels == k].sum() for k, label in enumerate(mesh.labels)}
        assert found == pytest.approx(lengths)
        areas = np.bincount(mesh.triangle_regions, signed_areas(mesh.points, mesh.triangles))
        assert dict(zip(mesh.regions, areas, strict=True)) == pytest.approx({"region 1": 1, "region 2": 1})
        assert read.notes == ()
        path.with_suffix(ending).unlink()
    assert read_mesh(path).mesh.labels == ()
