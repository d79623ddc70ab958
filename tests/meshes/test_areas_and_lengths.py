"""Areas of regions and lengths of labels: of a mesh whose figures are known, and added up from pieces."""

from dataclasses import replace

import numpy as np
import pytest
from squares import holed_square

from bubblemesh.meshes.areas_and_lengths import RegionSums, areas_and_lengths
from bubblemesh.meshes.quality import signed_areas


def test_areas_and_lengths_of_a_square_with_a_hole():
    mesh = holed_square(9)  # of the side 3
    right = mesh.points[mesh.triangles].mean(axis=1)[:, 0] > 1 / 3 + 2
    mesh = replace(mesh, regions=("left", "right"), triangle_regions=right.astype(np.int64))
    found = areas_and_lengths(mesh, signed_areas(mesh.points, mesh.triangles))
    assert [row[:2] for row in found["regions"]] == [("left", 2 * 45), ("right", 2 * 27)]
    assert [row.area for row in found["regions"]] == pytest.approx([5, 3])
    assert [row[:2] for row in found["labels"]] == [*((name, 9) for name in mesh.labels[:4]), ("hole", 12)]
    assert [row.length for row in found["labels"]] == pytest.approx([3, 3, 3, 3, 4])


def test_lengths_are_those_between_corners_in_second_order_too():
    mesh = holed_square(3)
    curved, _ = mesh.second_order()
    areas = signed_areas(curved.points, curved.triangles)
    assert areas_and_lengths(curved, areas) == areas_and_lengths(mesh, areas)


def test_pieces_may_know_different_regions_and_regions_may_share_a_name():
    pieces = [RegionSums.of(np.array([1.0, 2.0]), np.array([0, 2])), RegionSums.of(np.array([4.0]), np.array([3]))]
    pieces.append(RegionSums.of(np.zeros(0), np.zeros(0, np.int64)))
    total = RegionSums.together(pieces)
    assert total.named(("rest", "none", "grain"), np.array([0, 1, 2, 2, 1])) == (("rest", 1, 1.0), ("grain", 2, 6.0))
