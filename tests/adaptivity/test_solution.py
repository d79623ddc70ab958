"""Whether the mesh of a solution is one of the domain."""

import numpy as np
import pytest

import bubblemesh
from bubblemesh.adaptivity.solution import Solution, require_coverage
from bubblemesh.errors import CaseError
from bubblemesh.geometry import rings
from bubblemesh.geometry.arrangement.regions import InnerParts
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.triangulation import triangulated

SQUARE = Domain.of(rings.rectangle(0, 0, 1, 1))
RIDDLED = Domain.of(rings.rectangle(0, 0, 1, 1), [rings.circle((0.5, 0.5), 0.1)])
DISC = Domain.of(rings.circle((0, 0), 1))


def mesh_of(domain, d=0.12):
    return bubblemesh.mesh(domain, d)


def refusal(domain, points, triangles):
    """Why a mesh is refused; None if it is not."""
    try:
        require_coverage(domain, points, triangles)
    except CaseError as error:
        return str(error)
    return None


@pytest.mark.long
@pytest.mark.parametrize("domain", [SQUARE, RIDDLED, DISC])
@pytest.mark.parametrize("d", [0.05, 0.3, 1.0])
def test_own_meshes_cover_their_domains_however_coarse(domain, d):
    mesh = mesh_of(domain, d)
    assert refusal(domain, mesh.points, mesh.triangles) is None


def test_a_polygon_in_a_circle_covers_the_disc():
    angle = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    points = np.vstack([np.column_stack([np.cos(angle), np.sin(angle)]), [[0, 0]]])
    triangles = np.column_stack([np.full(12, 12), np.arange(12), (np.arange(12) + 1) % 12])
    assert refusal(DISC, points, triangles) is None


def test_a_mesh_of_more_than_the_domain_names_a_node_outside():
    mesh = mesh_of(SQUARE)
    found = refusal(RIDDLED, mesh.points, mesh.triangles)
    x, y = (float(part) for part in found.split("node at (")[1].split(")")[0].split(", "))
    assert "leaves the domain" in found
    assert np.hypot(x - 0.5, y - 0.5) < 0.1
    shifted = mesh.points + np.array([0, 0.2])
    assert "is 0.2 outside" in refusal(SQUARE, shifted, mesh.triangles)


def test_a_mesh_of_less_than_the_domain_names_where_it_ends():
    mesh = mesh_of(RIDDLED)
    assert "does not cover the domain: it ends at (0." in refusal(SQUARE, mesh.points, mesh.triangles)
    half = mesh.triangles[(mesh.points[mesh.triangles][..., 0] < 0.45).all(axis=1)]
    used = np.unique(half)
    found = refusal(RIDDLED, mesh.points[used], np.searchsorted(used, half))
    assert 0.3 < float(found.split("it ends at (")[1].split(",")[0]) < 0.45


def test_a_part_left_out_between_nodes_on_the_boundary_is_told_by_the_area():
    tab = [(0, 0), (1, 0), (1, 0.4), (2, 0.4), (2, 0.5), (1, 0.5), (1, 1), (0, 1)]
    square = bubblemesh.mesh(Domain.of(rings.polygon([p for p in tab if p[0] < 2])), 0.1)
    found = refusal(Domain.of(rings.polygon(tab)), square.points, square.triangles)
    assert "has an area of 1, the domain one of 1.1" in found


def test_three_triangles_at_an_edge_are_no_plane_mesh():
    points = np.array([[0.0, 0], [1, 0], [0, 1], [1, 1], [0.5, 1]])
    triangles = np.array([[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    assert "3 triangles meet at the edge from (0, 0) to (1, 0)" in refusal(SQUARE, points, triangles)


def test_an_open_crack_is_where_the_domain_has_a_line():
    crack = rings.open_path((0.2, 0.5), [rings.LineTo((0.8, 0.5))], "crack")
    cracked = Domain.of(rings.rectangle(0, 0, 1, 1), parts=InnerParts(lines=(crack,)))
    slit = [(0.2, 0.5), (0.5, 0.5 - 1e-9), (0.8, 0.5), (0.5, 0.5 + 1e-9)]
    x, y = np.mgrid[0:1:11j, 0:1:11j].reshape(2, -1)
    grid = np.column_stack([x, y])
    grid = grid[(np.abs(y - 0.5) > 0.01) | (x < 0.19) | (x > 0.81)]
    points = np.vstack([slit, [[0, 0], [1, 0], [1, 1], [0, 1]], grid[~((grid % 1 == 0).all(axis=1))]])
    triangles = triangulated(points, np.vstack([[[0, 1], [1, 2], [2, 3], [3, 0]], hull(points)]))
    require_coverage(cracked, points, triangles)
    assert "it ends at (0.5, 0.5" in refusal(SQUARE, points, triangles)


POINTS, TRIANGLES = [(0, 0), (1, 0), (0, 1)], [(0, 1, 2)]


@pytest.mark.parametrize(
    ("points", "triangles", "values", "told"),
    [
        ([(0, 0), (1, 0, 2), (0, 1)], TRIANGLES, [1, 2, 3], "^points: must be an array of real numbers"),
        ([("a", "b"), (1, 0), (0, 1)], TRIANGLES, [1, 2, 3], r"^points: must be real numbers of shape \(n, 2\)"),
        (POINTS, [(0, 1, 2), (0, 1)], [1, 2, 3], "^triangles: must be an array of whole numbers"),
        (POINTS, TRIANGLES, [1, [2, 3], 4], "^values: must be an array of numbers"),
        (POINTS, TRIANGLES, ["a", "b", "c"], "^values: must be numbers of shape"),
        (POINTS, TRIANGLES, np.ma.array([1, 2, 3], mask=[0, 1, 0]), r"^u is not a number at node 1 "),
        (POINTS, TRIANGLES, np.ma.array([1, 2j, 3], mask=[0, 0, 1]), r"^u is not a number at node 2 "),
        (np.ma.array(POINTS, mask=[[0, 0], [0, 1], [0, 0]]), TRIANGLES, [1, 2, 3], "^points: must be finite"),
    ],
)
def test_what_is_no_solution_is_refused(points, triangles, values, told):
    with pytest.raises(CaseError, match=told):
        bubblemesh.Solution.of(points, triangles, values)


def test_masks_that_hide_nothing_change_nothing():
    found = bubblemesh.Solution.of(*(np.ma.array(given) for given in (POINTS, TRIANGLES, [1, 2, 3])))
    assert found.values.tolist() == [[1], [2], [3]]


def hull(points):
    """Edges along the sides of the unit square."""
    edges = []
    for axis, level in ((1, 0), (0, 1), (1, 1), (0, 0)):
        side = np.flatnonzero(points[:, axis] == level)
        side = side[np.argsort(points[side, 1 - axis])]
        edges.append(np.column_stack([side[:-1], side[1:]]))
    return np.vstack(edges)


def test_a_solution_and_a_domain_equal_nothing_but_themselves():
    one, other = (Solution.of(POINTS, TRIANGLES, np.arange(len(POINTS))) for _ in range(2))
    assert len({one, other, SQUARE, DISC}) == 4
    assert one != other
    assert Domain.of(rings.rectangle(0, 0, 1, 1)) != SQUARE


@pytest.mark.parametrize(
    ("values", "constant"),
    [([0, 0, 0], True), ([3, 3, 3], True), ([1e16, 1e16 + 2, 1e16], True), ([1, 1 + 1e-9, 1], False)],
)
def test_what_is_the_same_everywhere_but_for_rounding_is_constant(values, constant):
    corners = np.array([[0.0, 0], [1, 0], [0, 1]])
    assert Solution.of(corners, np.array([[0, 1, 2]]), np.array(values, float)).constant is constant


def test_points_of_each_triangle_s_own_become_those_of_a_continuous_solution():
    mesh = mesh_of(SQUARE, 0.3)
    points, triangles = mesh.points[mesh.triangles].reshape(-1, 2), np.arange(3 * len(mesh.triangles)).reshape(-1, 3)
    solution = Solution.of(points, triangles, points @ [1.0, 2.0])
    assert len(solution.points) == len(mesh.points)
    np.testing.assert_allclose(solution.values[:, 0], solution.points @ [1.0, 2.0])
    assert refusal(SQUARE, solution.points, solution.triangles) is None
    with pytest.raises(CaseError, match="w jumps from cell to cell, and the estimate takes a continuous solution"):
        Solution.of(points, triangles, np.repeat(np.arange(len(triangles)), 3), "w")
