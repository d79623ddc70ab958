"""Corners of a few degrees, as where a layer of the ground thins to nothing."""

import math

import numpy as np
import pytest
from invariants import check_area, check_edges
from sweeps import sweep

from bubblemesh.case import load_case
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.rings import polygon
from bubblemesh.meshes.quality import angles
from bubblemesh.packing.pinch_outs import pinch_outs
from bubblemesh.run.pipeline import mesh_case

SECTION = """
domain:
  outer: {{rectangle: [0, 0, 50, 30]}}
  regions:{regions}
spacing: {{maximum: {spacing}, growth: 0.2}}
packing: {{seed: {seed}}}
"""


def section(*rings, seed=0, spacing=4):
    """The mesh of a section with layers between points."""
    regions = "".join(
        f"\n  - {{name: r{number}, ring: {{polygon: {list(map(list, ring))}}}}}" for number, ring in enumerate(rings)
    )
    return meshed(SECTION.format(regions=regions, seed=seed, spacing=spacing))


def meshed(text):
    mesh = mesh_case(load_case("a.yaml", text=text)).mesh
    check_edges(mesh)
    check_area(mesh)
    return mesh


def largest_angle(mesh):
    return angles(mesh.points, mesh.triangles).max()


@pytest.mark.parametrize("seed", sweep([0, 1, 2, 3], quick=1))
@pytest.mark.parametrize("degrees", sweep([0.5, 1, 2, 4, 4.9], quick=3))
def test_triangles_in_a_pinch_out_are_not_flat(degrees, seed):
    """They were, with angles up to 175 degrees."""
    mesh = section([(0, 12), (45, 12), (0, 12 + 45 * math.tan(math.radians(degrees)))], seed=seed)
    assert largest_angle(mesh) < 116


def test_two_pinch_outs_may_have_a_side_in_common():
    mesh = section([(5, 15), (50, 14), (50, 15)], [(5, 15), (50, 15), (50, 16)])
    assert largest_angle(mesh) < 116


def test_a_lens_has_a_pinch_out_at_either_end():
    mesh = section([(2, 12), (25, 11.1), (48, 12), (25, 12.9)], spacing=2)
    assert largest_angle(mesh) < 116


LENS = """
domain:
  outer: {{rectangle: [0, 0, 30, 10]}}
  lines:
    - {{path: [[0, 4], [30, 4]], label: ROCK}}
    - {{path: [[5, 4], [{x}, {top}], [25, 4]], label: LENS}}
  region: soil
  regions: [{{name: lens, at: [15, 4.02]}}]
spacing: {spacing}
"""


@pytest.mark.parametrize("x", [15, 12.3])
@pytest.mark.parametrize(("height", "spacing"), sweep([(0.15, 2), (0.05, 3), (0.4, 2), (0.2, 1), (0.1, 0.5)], quick=1))
def test_the_crown_of_a_lens_has_an_opposite_node(height, spacing, x):
    """Angles there were up to 177 degrees."""
    mesh = meshed(LENS.format(x=x, top=4 + height, spacing=spacing))
    assert largest_angle(mesh) < 116
    assert np.abs(mesh.points - [x, 4]).max(axis=1).min() < 0.02


def wedge(degrees, turn=0.0):
    a = np.radians([0, degrees]) + turn
    return polygon([(2, 3), *(np.array([2, 3]) + np.column_stack([np.cos(a), np.sin(a)]))])


@pytest.mark.parametrize(("degrees", "count"), [(1, 1), (4.9, 1), (5.1, 0)])
def test_pinch_outs_are_corners_below_five_degrees(degrees, count):
    assert len(list(pinch_outs(Domain.of(wedge(degrees, turn=0.7))))) == count


def test_sides_that_are_periodic_keep_their_nodes():
    text = """
    domain:
      outer: {rectangle: [0, 0, 4, 3], labels: [bottom, right, top, left]}
      regions: [{name: seam, ring: {polygon: [[0, 0], [0.1, 3], [0, 3]]}}]
      periodic: [[left, right]]
    spacing: 0.5
    """
    mesh = meshed(text)
    left, right = (np.sort(mesh.points[mesh.points[:, 0] == x, 1]) for x in (0, 4))
    np.testing.assert_allclose(left, right)
