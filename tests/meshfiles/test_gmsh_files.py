"""Files of Gmsh: all versions that are read, their data at some nodes and of some elements, damaged ones."""

import numpy as np
import pytest

from bubblemesh.errors import FileError
from bubblemesh.meshfiles.fields import read_nodal_field
from bubblemesh.meshfiles.read import read_mesh
from bubblemesh.meshfiles.sources.gmsh import read_msh

FORMS = [(2.2, 0), (2.2, 1), (4.0, 0), (4.1, 0), (4.1, 1)]
HEAD = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
MESH = """$PhysicalNames
2
1 5 "low side"
2 7 "rock"
$EndPhysicalNames
$Nodes
4
11 0 0 0
7 1 0 0
9 1 1 0
30 0 1 0
$EndNodes
$Elements
4
5 15 2 0 1 11
1 1 2 5 1 11 7
8 2 2 7 1 11 7 9
3 2 4 7 1 1 1 11 9 30
$EndElements
"""


def data(name, time, step, rows, kind="NodeData"):
    values = "\n".join(" ".join(map(str, row)) for row in rows)
    return f'${kind}\n1\n"{name}"\n1\n{time}\n3\n{step}\n{len(rows[0]) - 1}\n{len(rows)}\n{values}\n$End{kind}\n'


@pytest.fixture
def written(tmp_path):
    def write(text):
        (tmp_path / "a.msh").write_bytes(text if isinstance(text, bytes) else text.encode())
        return tmp_path / "a.msh"

    return write


@pytest.fixture
def square(gmsh, request):
    """A square of Gmsh in the form of the test; the triangles and nodes of it."""
    version, binary = request.param
    options = {"Mesh.MshFileVersion": version, "Mesh.Binary": binary, "Mesh.MeshSizeMax": 0.4, "Mesh.SaveAll": 1}
    before = {name: gmsh.option.getNumber(name) for name in options}
    gmsh.clear()
    gmsh.model.add("square")
    gmsh.model.occ.addRectangle(0, 0, 0, 2, 1)
    gmsh.model.occ.synchronize()
    for name, value in options.items():
        gmsh.option.setNumber(name, value)
    gmsh.model.mesh.generate(2)
    yield gmsh.model.mesh.getElementsByType(2)[0], gmsh.model.mesh.getNodes()[0]
    for name, value in before.items():
        gmsh.option.setNumber(name, value)
    gmsh.clear()


@pytest.mark.parametrize("square", FORMS, indirect=True)
def test_views_that_gmsh_writes_with_their_mesh(gmsh, square, tmp_path):
    triangles, nodes = square
    path = tmp_path / "a.msh"
    views = {
        "c": ("ElementData", triangles, [1.0]),  # there are lines and points as well
        "p": ("NodeData", nodes[:5], [1.0]),
        "v": ("NodeData", nodes, [1.0, 2.0, 0.0]),
    }
    for k, (name, (kind, numbers, factors)) in enumerate(views.items()):
        view = gmsh.view.add(name)
        for step in (0, 1):
            rows = [[(1 + step) * factor * number for factor in factors] for number in numbers.tolist()]
            gmsh.view.addModelData(view, step, "square", kind, numbers, rows, time=step / 2)
        gmsh.view.write(view, str(path), append=k > 0)
    read = read_mesh(path)
    assert read.notes == tuple(f"holds 2 times of {name}: the last one, 0.5, is read" for name in ("p", "v", "c"))
    assert sorted(read.cell_data["c"]) == sorted(2.0 * triangles)
    assert sorted(read.point_data["v"][:, 1]) == sorted(4.0 * nodes)
    known = ~np.isnan(read.point_data["p"])
    assert sorted(read.point_data["p"][known]) == sorted(2.0 * nodes[:5])
    np.testing.assert_array_equal(read.point_data["v"][known, 0], read.point_data["p"][known])


@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
def test_numbers_may_be_any_and_a_mark_before_the_text_does_no_harm(written, mark):
    text = HEAD + MESH + data("c", 0, 0, [(3, 30.0)], "ElementData") + data("u", 0, 0, [(30, 3.5), (7, 1.5)])
    read = read_mesh(written(mark + text.encode()))
    assert read.mesh.points.tolist() == [[0, 0], [1, 0], [1, 1], [0, 1]]
    assert read.mesh.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert (read.mesh.regions, read.mesh.labels) == (("rock",), ("low side",))
    np.testing.assert_array_equal(read.point_data["u"], [np.nan, 1.5, np.nan, 3.5])
    np.testing.assert_array_equal(read.cell_data["c"], [np.nan, 30])


@pytest.mark.parametrize(("times", "which"), [((0.5, 0.25), "0.5"), ((0, 0), "step 2")])
def test_the_latest_of_several_times_is_read_and_told(written, times, which):
    rows = [(11, 1), (7, 2), (9, 3), (30, 4)]
    steps = [(time, 2 - k, [(i, (k + 1) * u) for i, u in rows]) for k, time in enumerate(times)]
    path = written(HEAD + MESH + "".join(data("u", *step) for step in steps))
    found = read_nodal_field(path, "u")
    assert found.values[:, 0].tolist() == [1, 2, 3, 4]
    assert found.notes == (f"holds 2 times of u: the last one, {which}, is read",)


def test_data_at_corners_are_left_out_with_a_note(written):
    text = data("u", 0, 0, [(8, 3, 1, 2)], "ElementNodeData")
    assert read_mesh(written(HEAD + MESH + text)).notes == (
        "data at the corners of each element ($ElementNodeData) are left out",
    )


def test_version_4_is_4_0_as_gmsh_writes_it_or_4_1_as_others_do(written):
    nodes = "{}\n2 1 0 4\n{}\n$EndNodes\n"
    places = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"]
    old = nodes.format("1 4", "\n".join(f"{k} {at}" for k, at in enumerate(places, 1)))
    new = nodes.format("1 4 1 4", "\n".join(["1", "2", "3", "4", *places]))
    cells = "2 1 2 2\n1 1 2 3\n2 1 3 4\n$EndElements\n"
    head = HEAD.replace("2.2", "4")
    for text in (f"$Nodes\n{old}$Elements\n1 2\n{cells}", f"$Nodes\n{new}$Elements\n1 2 1 2\n{cells}"):
        found = read_msh(written(head + text))
        assert found.points[:, :2].tolist() == [[0, 0], [1, 0], [1, 1], [0, 1]]
        assert found.cells[0].data.tolist() == [[0, 1, 2], [0, 2, 3]]


def test_bytes_may_be_in_the_other_order(written):
    nodes = np.array([(k, at) for k, at in enumerate([(0, 0, 0), (1, 0, 0), (1, 1, 0)], 1)], ">i4, (3,)>f8")
    cells = np.array([2, 1, 2, 1, 0, 1, 1, 2, 3], ">i4")
    head = HEAD.replace("2.2 0 8\n", "2.2 1 8\n\0\0\0\1\n").encode()
    body = b"$Nodes\n3\n%b\n$EndNodes\n$Elements\n1\n%b\n$EndElements\n" % (nodes.tobytes(), cells.tobytes())
    assert read_msh(written(head + body)).cells[0].data.tolist() == [[0, 1, 2]]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("$NOD\n1\n", "has no $MeshFormat: it is no mesh of Gmsh, or of its version 1"),
        (HEAD.replace("2.2", "3"), "is of version 3 of Gmsh's format: let Gmsh write version 4.1, or 2.2"),
        (HEAD, "has no $Nodes: it is cut off, or holds no mesh"),
        (HEAD + MESH[:-40], "it ends too early: there is no $EndElements"),
        (HEAD + MESH.replace("4\n11", "5\n11"), "it ends too early: it has 16 of 20 numbers of Nodes"),
        (HEAD + MESH.replace("4\n5 15", "5\n5 15"), "it ends too early: it has 0 of 3 numbers of Elements"),
        (HEAD + MESH.replace("7 1 0 0", "7 1 O 0"), "its section Nodes holds what is no number: it is damaged"),
        (HEAD + MESH.replace("8 2 2", "8 2.5 2"), "its section Elements has numbers that are not whole"),
        (HEAD + MESH.replace("8 2 2", "8 999 2"), "has elements of the kind 999 of Gmsh, which is not known here"),
        (HEAD + MESH.replace("8 2 2", "8 2 -6"), "its elements are not as Gmsh writes them: the file is damaged"),
        (HEAD + MESH.replace("$Nodes\n4", "$Nodes\n-4"), "its section Nodes has a count below 0"),
        (HEAD + MESH.replace("$Nodes\n4", "$Nodes\nfour"), "its counts of nodes are no whole numbers"),
        (HEAD + MESH.replace("7 1 0 0", "6 1 0 0"), "names the node 7, which is not there: the file is damaged"),
        (
            HEAD + MESH + data("u", 0, 0, [(6, 1.0)]),
            "its data u: names the node 6, which is not there",
        ),
    ],
)
def test_damaged_files_are_told_in_words(written, text, told):
    with pytest.raises(FileError) as error:
        read_mesh(written(text))
    assert told in str(error.value)
