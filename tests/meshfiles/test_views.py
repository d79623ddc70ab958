"""Views of Gmsh as text."""

import numpy as np
import pytest

from bubblemesh import load_case
from bubblemesh.errors import FileError
from bubblemesh.meshfiles.fields import read_nodal_field
from bubblemesh.meshfiles.read import read_mesh
from bubblemesh.problem.prepare import prepare

SQUARE = np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]], float)
CASE = """
name: a
domain: {outer: {rectangle: [0, 0, 1, 1]}}
spacing: 0.4
metric: {file: sizes.pos}
"""


def tensor(x, y):
    """Ellipses of 0.1 along y, and from 0.1 to 0.4 along x, as a matrix in space."""
    return [(0.1 * 4 ** (1 - x)) ** -2, 0, 0, 0, 100, 0, 0, 0, 1]


def view(kind="TT", function=tensor, steps=1, more=""):
    """A view with the square's two triangles, as Gmsh writes it."""
    rows = []
    for corners in SQUARE.tolist():
        places = ",".join(f"{x},{y},0" for x, y in corners)
        values = [value * (step + 1) / steps for step in range(steps) for x, y in corners for value in function(x, y)]
        rows.append(f"{kind}({places}){{{','.join(map(repr, values))}}};")
    return "\n".join(["// a remark {", 'View "background mesh" {', more, *rows, "TIME{0};", "};", ""])


def written(tmp_path, text):
    path = tmp_path / "sizes.pos"
    path.write_text(text, encoding="utf-8")
    return path


def test_tensors_of_a_view_are_a_metric(tmp_path):
    written(tmp_path, view(more='SP(0,0,0){1}; /* a\nremark */ T3(0,0,0,1){"text"};'))
    (tmp_path / "case.yaml").write_text(CASE)
    problem = prepare(load_case(tmp_path / "case.yaml"))
    found = problem.spacing.axes(np.array([[0.0, 0.3], [0.5, 0.5], [1.0, 0.6]]))
    np.testing.assert_allclose(found.across, 0.1, rtol=1e-6)
    np.testing.assert_allclose(found.along, [0.4, 0.2, 0.1], rtol=1e-6)
    np.testing.assert_allclose(np.abs(found.direction[:2]), [[1, 0], [1, 0]], atol=1e-6)


def test_triangles_share_the_nodes_in_the_same_places(tmp_path):
    read = read_nodal_field(written(tmp_path, view("ST", lambda x, y: [x + 2 * y])), None)
    assert read.name == "background mesh"
    assert len(read.points) == 4
    np.testing.assert_allclose(read.values[:, 0], read.points @ [1, 2])
    assert len(read_mesh(tmp_path / "sizes.pos").mesh.points) == 4


def test_a_byte_order_mark_does_no_harm(tmp_path):
    path = written(tmp_path, "\ufeff" + view("ST", lambda x, y: [x]).partition("\n")[2])
    assert len(read_mesh(path).mesh.points) == 4
    path = tmp_path / "freefem.msh"
    path.write_text("\ufeff3 1 0\n0 0 0\n1 0 0\n1 1 0\n1 2 3 0\n", encoding="utf-8")
    assert len(read_mesh(path).mesh.points) == 3


def test_of_several_steps_the_last_one_is_read(tmp_path):
    read = read_nodal_field(written(tmp_path, view("VT", lambda x, y: [x, y, 0], steps=3)), None)
    np.testing.assert_allclose(read.values[:, :2], read.points)
    assert read.notes == ("of 3 steps the last one is read",)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty"),
        ("$PostFormat\n1.4 0 8\n", "does not begin with View"),
        (view()[:-20], "line 5 is no element of a view, .* or it ends too early"),
        (view()[:-4], "line 6 is no element of a view, .* or it ends too early"),
        (view() + view(), "line 9 follows after the view: give a file of one view"),
        (view("SS"), "line 4: holds SS: only triangles are read, ST, VT or TT"),
        (view(more=view("ST", lambda x, y: [1]).splitlines()[3]), "line 4: holds TT after ST: give a view of one kind"),
        (view("TT", lambda x, y: [1, 0, 1]), "line 4: has 9 coordinates and 9 values: TT takes 9, and 27 for each"),
        (view().replace(",0){", "){", 1), "line 4: has 8 coordinates and 27 values"),
        (view().replace("100", "1oo"), "its values are no numbers"),
        (view().replace("(0.0,", "(x,"), "its coordinates are no numbers"),
        ('View "empty" {\n};\n', "holds no triangles"),
    ],
)
def test_a_broken_view_is_refused_with_its_place(tmp_path, text, message):
    with pytest.raises(FileError, match=message):
        read_nodal_field(written(tmp_path, text), None)
