import re
from dataclasses import replace

import numpy as np
import pytest

from bubblemesh.errors import BubblemeshError
from bubblemesh.meshes.conformity import area_error, require_conforming
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.messages import place

GRID = np.arange(5)


def plate(offset=0.0, scale=1.0):
    """A square of 4 x 4 cells without the middle four, every cell halved."""
    number = np.full((5, 5), -1)
    kept = [(i, j) for i in GRID for j in GRID if (i, j) != (2, 2)]
    for k, (i, j) in enumerate(kept):
        number[i, j] = k
    cells = [(i, j) for i in range(4) for j in range(4) if not (1 <= i <= 2 and 1 <= j <= 2)]
    triangles = []
    for i, j in cells:
        a, b, c, d = number[i, j], number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]
        triangles += [(a, b, c), (a, c, d)]
    outer = [(i, 0) for i in range(4)] + [(4, j) for j in range(4)]
    outer += [(4 - i, 4) for i in range(4)] + [(0, 4 - j) for j in range(4)]
    hole = [(1, 1), (1, 2), (1, 3), (2, 3), (3, 3), (3, 2), (3, 1), (2, 1)]
    facets = [(number[p], number[q]) for loop in (outer, hole) for p, q in zip(loop, loop[1:] + loop[:1], strict=True)]
    points = offset + scale * np.array(kept, float)
    return Mesh(points, np.array(triangles), np.array(facets), np.zeros(len(facets), int), ("wall",))


def fault_of(mesh):
    """What the check finds; None if it passes."""
    try:
        require_conforming(mesh)
    except BubblemeshError as error:
        return str(error)
    return None


def test_good_mesh_passes():
    mesh = plate()
    assert area_error(mesh) == 0
    assert fault_of(mesh) is None


@pytest.mark.parametrize("scale", [1e15, 1e-12])
@pytest.mark.parametrize("offset", [0, 1e6])
def test_good_mesh_passes_at_any_scale_and_place(offset, scale):
    assert fault_of(plate(offset * scale, scale)) is None


def test_inverted_triangle_is_found():
    mesh = plate()
    triangles = mesh.triangles.copy()
    triangles[3] = triangles[3, ::-1]
    where = re.escape(place(mesh.points[triangles[3]].mean(axis=0)))
    with pytest.raises(BubblemeshError, match=f"flat or inverted at {where}"):
        require_conforming(replace(mesh, triangles=triangles))


def test_flat_triangle_is_found():
    mesh = plate()
    points = mesh.points.copy()
    points[0] = points[6]
    with pytest.raises(BubblemeshError, match="flat or inverted"):
        require_conforming(replace(mesh, points=points))


def test_unused_node_is_found():
    mesh = plate()
    with pytest.raises(BubblemeshError, match=r"belongs to no triangle at \(7, 8\)"):
        require_conforming(replace(mesh, points=np.vstack([mesh.points, [7, 8]])))


def test_missing_triangle_is_found():
    mesh = plate()
    with pytest.raises(BubblemeshError, match="the boundary is not met"):
        require_conforming(replace(mesh, triangles=mesh.triangles[1:], triangle_regions=[]))


def test_missing_boundary_edge_is_found():
    mesh = plate()
    with pytest.raises(BubblemeshError, match=r"the boundary is not met at \(0.5, 0\)"):
        require_conforming(replace(mesh, facets=mesh.facets[1:], facet_labels=mesh.facet_labels[1:], facet_middles=[]))


def labelled(mesh, *pairs):
    facets = np.vstack([mesh.facets, *pairs])
    return replace(mesh, facets=facets, facet_labels=np.zeros(len(facets), int), facet_middles=np.zeros((0, 2)))


def test_an_inner_edge_may_be_labelled():
    mesh = plate()
    with_line = labelled(mesh, mesh.triangles[0][[0, 2]])
    assert with_line.outer.tolist() == [True] * len(mesh.facets) + [False]
    assert area_error(with_line) == 0
    require_conforming(with_line)


def test_a_label_on_what_is_no_edge_is_found():
    mesh = plate()
    with pytest.raises(BubblemeshError, match="the boundary is not met"):
        require_conforming(labelled(mesh, [0, len(mesh.points) - 1]))


def test_an_edge_labelled_twice_is_found():
    mesh = plate()
    inner = mesh.triangles[0][[0, 2]]
    with pytest.raises(BubblemeshError, match="labelled twice"):
        require_conforming(labelled(mesh, inner, inner[::-1]))


def test_boundary_run_the_wrong_way_has_the_wrong_area():
    mesh = plate()
    with pytest.raises(BubblemeshError, match="the area is off"):
        require_conforming(replace(mesh, facets=np.vstack([mesh.facets[:16], mesh.facets[16:, ::-1]])))


def test_triangle_counted_twice_is_found():
    mesh = plate()
    with pytest.raises(BubblemeshError):
        require_conforming(
            replace(mesh, triangles=np.vstack([mesh.triangles, mesh.triangles[:1]]), triangle_regions=[])
        )


def test_doubled_mesh_has_twice_the_area():
    mesh = plate()
    assert area_error(replace(mesh, triangles=np.tile(mesh.triangles, (2, 1)), triangle_regions=[])) == pytest.approx(1)
