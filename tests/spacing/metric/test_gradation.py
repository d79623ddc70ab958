import numpy as np
import pytest
from metrics import random_tensors

from bubblemesh.kernels.tensors import lengths
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.tensors import axes, of_axes
from bubblemesh.meshes.triangulation import triangulated
from bubblemesh.spacing.metric.gradation import SETTLED, graded

SIDES = np.array([[0, 1], [1, 2], [2, 3], [3, 0]])


def scattered(count, seed=0):
    """Points in a square, its corners first, and triangles."""
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    points = np.vstack([corners, np.random.default_rng(seed).uniform(0.01, 0.99, (count, 2))])
    return points, triangulated(points, SIDES)


def require_graded(points, triangles, tensors, growth):
    """By a loop over edges and directions: the enlarged ellipse of each end holds that of the other one."""
    angle = np.linspace(0, np.pi, 37)
    around = np.column_stack([np.cos(angle), np.sin(angle)])
    for i, j in unique_edges(triangles)[0].tolist():
        for origin, end in ((i, j), (j, i)):
            length = lengths(tensors[[origin]], (points[end] - points[origin])[None])[0]
            here = lengths(np.broadcast_to(tensors[origin], (37, 3)), around) / (1 + growth * length)
            assert (lengths(np.broadcast_to(tensors[end], (37, 3)), around) >= here * (1 - 2 * SETTLED)).all()


@pytest.mark.parametrize("seed", range(3))
def test_random_tensors_are_graded_and_nowhere_coarser(seed):
    points, triangles = scattered(60, seed)
    tensors = random_tensors(np.random.default_rng(seed), len(points), 20)
    found = graded(points, triangles, tensors, 0.3)
    require_graded(points, triangles, found, 0.3)
    assert (axes(found).across <= axes(tensors).across * (1 + 1e-9)).all()


def test_sizes_beside_a_jump_grow_linearly_with_the_distance():
    points, triangles = scattered(400)
    narrow = np.where(points[:, 0] < 0.5, 0.01, 0.5)
    jump = of_axes(narrow, np.full(len(narrow), 0.5), np.tile([1.0, 0.0], (len(narrow), 1)))
    found = graded(points, triangles, jump, 0.2)
    np.testing.assert_allclose(found[narrow < 0.1], jump[narrow < 0.1], rtol=1e-6, atol=1e-6)
    far = points[:, 0] > 0.55
    assert axes(found[far]).across.max() < 0.01 + 0.2 * 0.6
    assert axes(found[far]).across.min() > 0.0102
    assert np.median(axes(found[points[:, 0] > 0.9]).across) > 0.015


@pytest.mark.parametrize("growth", [0.2, 0.02])
def test_growth_goes_on_along_hundreds_of_edges(growth):
    """A strip of 400 columns, fine at its left end: sizes grow with the length, h = h0 exp(growth * l) at most."""
    x, y = np.meshgrid(np.arange(401.0), [0.0, 1.0])
    points, (first, above) = np.column_stack([x.ravel(), y.ravel()]), (np.arange(400), 401 + np.arange(400))
    triangles = np.concatenate(
        [np.column_stack([first, first + 1, above]), np.column_stack([first + 1, above + 1, above])]
    )
    sizes = np.where(points[:, 0] == 0, 1.0, 1000.0)
    tensors = np.column_stack([sizes**-2, 0 * sizes, sizes**-2])
    found = graded(points, triangles, tensors, growth)
    require_graded(points, triangles, found, growth)
    along = axes(found).across[:401]
    # Of homogeneous growth the sizes follow h' = growth, whatever the step.
    np.testing.assert_allclose(along, np.minimum(1 + growth * np.arange(401), 1000), rtol=0.01)


def test_an_even_metric_stays_as_it_is():
    points, triangles = scattered(50)
    tensors = np.tile([4.0, 0.5, 1.0], (len(points), 1))
    np.testing.assert_allclose(graded(points, triangles, tensors, 0.1), tensors, rtol=1e-9)
