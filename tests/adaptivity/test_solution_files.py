"""Solutions from files and arrays: what is read, and what is refused."""

import meshio
import numpy as np
import pytest

from bubblemesh.adaptivity.solution import Solution, read_solution
from bubblemesh.adaptivity.target import Target
from bubblemesh.api import adapt
from bubblemesh.case import Case
from bubblemesh.errors import CaseError, FileError
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.meshfiles.fields import AVERAGE, HIGHER_ORDER, read_nodal_field

POINTS = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [9, 9, 0]])
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])
DATA = {"u": np.arange(5.0), "flow": np.arange(15.0).reshape(5, 3), "count": np.arange(5)}


def written(path, cells=(("triangle", TRIANGLES),), points=POINTS, point_data=DATA, **more):
    meshio.Mesh(points, list(cells), point_data=point_data, **more).write(path)
    return path


@pytest.mark.parametrize("ending", ["vtu", "vtk", "xdmf"])
def test_nodes_that_no_triangle_uses_are_left_out(tmp_path, ending):
    path = written(tmp_path / f"a.{ending}")
    found = read_nodal_field(path, "u")
    np.testing.assert_array_equal(found.points, POINTS[:4, :2])
    np.testing.assert_array_equal(found.triangles, TRIANGLES)
    np.testing.assert_array_equal(found.values, np.arange(4.0)[:, None])
    assert read_nodal_field(path, "flow").values.shape == (4, 3)
    assert read_nodal_field(path, "count").values.dtype == float


def test_the_only_data_needs_no_name(tmp_path):
    assert read_nodal_field(written(tmp_path / "a.vtu", point_data={"T": DATA["u"]}), None).name == "T"


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("v", "has no data 'v' at its nodes: it has u, flow, count"),
        (None, "has data of 3 names at its nodes (u, flow, count): choose one by field"),
        ("c", f"c is data of the cells (at the nodes: u, flow, count): {AVERAGE}"),
    ],
)
def test_names_that_are_not_there_tell_the_known_ones(tmp_path, name, message):
    path = written(tmp_path / "a.vtu", cell_data={"c": [np.zeros(2)]})
    with pytest.raises(CaseError) as caught:
        read_nodal_field(path, name)
    assert str(caught.value) == f"{path}: {message}"


def test_the_argument_that_chooses_is_told_as_it_is_called(tmp_path):
    path = written(tmp_path / "a.vtu")
    case = Case(domain={"outer": {"rectangle": [0, 0, 1, 1]}}, spacing=0.5)
    with pytest.raises(CaseError, match=r"choose one by field$"):
        adapt(case, path)
    with pytest.raises(CaseError, match=r"choose one by --field$"):
        read_solution(path, None, Target(mark="--").called("field"))


def test_data_of_cells_alone_is_told_with_what_to_do(tmp_path):
    path = written(tmp_path / "a.vtu", point_data={"owner": DATA["count"]}, cell_data={"c": [np.zeros(2)]})
    with pytest.raises(CaseError, match=r"has no data at its nodes, but of its cells \(c\): write values at the nodes"):
        read_nodal_field(path, None)


@pytest.mark.parametrize("kept", ["point_tags", "node_groups", "owner", "GlobalNodeId", "gmsh:dim_tags"])
def test_numbers_of_groups_and_parts_are_no_solution_unless_named(tmp_path, kept):
    path = written(tmp_path / "a.vtu", point_data={kept: DATA["count"], "u": DATA["u"]})
    assert read_nodal_field(path, None).name == "u"
    assert read_nodal_field(path, kept).name == kept


@pytest.mark.parametrize("kind", ["quad", "quad9"])
def test_quadrilaterals_count_as_two_triangles(tmp_path, kind):
    corners, x = [1, 2, 3, 0], POINTS[:4]
    points = np.concatenate([x, [(x[k] + x[(k + 1) % 4]) / 2 for k in corners], [x.mean(axis=0)]])
    nodes = corners + [4, 5, 6, 7, 8] * (kind == "quad9")
    u = {"u": 2 * points[:, 0] - points[:, 1]}
    found = read_nodal_field(written(tmp_path / "a.vtu", [(kind, [nodes])], points, u), None)
    np.testing.assert_array_equal(found.points[:, 0] * 2 - found.points[:, 1], found.values[:, 0])
    assert len(found.points) == 4
    solution = Solution.of(found.points, found.triangles, found.values)
    assert signed_areas(solution.points, solution.triangles).tolist() == [0.5, 0.5]
    assert found.notes == (HIGHER_ORDER,) * (kind == "quad9")


def test_other_cells_are_refused(tmp_path):
    path = written(tmp_path / "a.vtu", cells=[("tetra", [[0, 1, 2, 4]])])
    with pytest.raises(FileError, match="kind tetra: the estimate is for triangles and quadrilaterals"):
        read_nodal_field(path, "u")
    path = written(tmp_path / "b.vtu", cells=[("line", [[0, 1]])])
    with pytest.raises(FileError, match="holds no triangles"):
        read_nodal_field(path, "u")


@pytest.mark.parametrize("content", [None, b"", b"<VTKFile"])
def test_files_that_are_none_are_errors(tmp_path, content):
    path = tmp_path / "a.vtu"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(FileError):
        read_nodal_field(path, "u")


def test_surfaces_in_space_are_refused(tmp_path):
    with pytest.raises(FileError, match="surface in space"):
        read_nodal_field(written(tmp_path / "a.vtu", points=POINTS + np.arange(5)[:, None] * [0, 0, 0.1]), "u")


def test_clockwise_triangles_are_turned_and_complex_values_have_two_parts():
    found = Solution.of(POINTS[:4, :2], TRIANGLES[:, ::-1], np.arange(4) + 2j)
    np.testing.assert_array_equal(np.sort(found.triangles), np.sort(TRIANGLES))
    (ux, uy), (vx, vy) = (found.points[found.triangles[0, k]] - found.points[found.triangles[0, 0]] for k in (1, 2))
    assert ux * vy - uy * vx > 0
    np.testing.assert_array_equal(found.values, np.column_stack([np.arange(4), np.full(4, 2)]))


@pytest.mark.parametrize("values", [np.zeros(4), np.zeros((3, 1)), np.float64(1)])
def test_a_solution_of_unfitting_shapes_tells_who_makes_one(values):
    with pytest.raises(
        CaseError, match=r"must have the shapes \(n, 2\), \(t, 3\) and \(n, k\): make it by Solution\.of"
    ):
        Solution(POINTS[:4, :2], TRIANGLES, values)


NAN = np.array([0, 1, np.nan, 3])


@pytest.mark.parametrize(
    ("points", "triangles", "values", "message"),
    [
        (POINTS[:4], TRIANGLES, np.zeros(4), r"points: must be real numbers of shape \(n, 2\)"),
        (POINTS[:4, :2] + np.inf, TRIANGLES, np.zeros(4), "points: must be finite"),
        (POINTS[:4, :2], TRIANGLES.astype(float), np.zeros(4), r"triangles: must be whole .*\(2, 3\), type float64\)"),
        (POINTS[:4, :2], TRIANGLES[:0], np.zeros(4), "triangles: must use all of the nodes 0 to 3"),
        (POINTS[:, :2], TRIANGLES, np.zeros(5), "triangles: must use all of the nodes 0 to 4"),
        (POINTS[:4, :2], TRIANGLES + 1, np.zeros(4), "triangles: must be indices of 4 nodes.*found 4 in row 1"),
        (POINTS[:4, :2], TRIANGLES, np.zeros(3), r"values: must be numbers of shape \(4,\)"),
        (POINTS[:4, :2], TRIANGLES, np.array(["a"] * 4), "values: must be numbers"),
        (
            POINTS[:4, :2],
            TRIANGLES,
            np.ones(4, bool),
            r"values: must be numbers of .*\(found the shape \(4,\), type bool\)",
        ),
        (
            POINTS[:4, :2],
            TRIANGLES,
            np.zeros((4, 0)),
            r"values: must be at least one number for each node \(found none\)",
        ),
        (POINTS[:4, :2], TRIANGLES, NAN, r"u is not a number at node 2 \(counted from 0\), at \(1, 1\)"),
        (POINTS[[0, 1, 1], :2] * [[1], [1], [2]], TRIANGLES[:1], np.zeros(3), r"around \(1, 0\) has no area"),
    ],
)
def test_arrays_that_are_no_solution_are_refused(points, triangles, values, message):
    with pytest.raises(CaseError, match=message):
        Solution.of(points, triangles, values)


SINGLE = r"rounded to 0\.5 \(single precision\), about as much as .* save them in double precision"


@pytest.mark.parametrize(
    ("rounded", "told"),
    [
        (lambda points: points.astype(np.float32).astype(float), SINGLE),
        (lambda points: np.array([[float(f"{x:.6g}") for x in row] for row in points]), r"to 10 \(6 digits\)"),
    ],
)
def test_coordinates_that_were_rounded_in_the_file_are_told(rounded, told):
    """Far from the origin, as in UTM, that makes triangles flat."""
    corners = np.array([[0.0, 0], [0.3, 0.1], [0.6, 0.0], [60, 0], [60, 60], [0, 60]]) + np.array([500700.2, 5412000.1])
    triangles = np.array([[0, 2, 1], [1, 2, 4], [2, 3, 4], [0, 1, 5], [1, 4, 5]])
    with pytest.raises(CaseError, match=told):
        Solution.of(rounded(corners), triangles, np.arange(6.0))
    with pytest.raises(CaseError, match=r"no area\Z"):
        Solution.of(np.array([[0, 0], [1000, 0], [2000, 0.0]]), np.array([[0, 1, 2]]), np.arange(3.0))
