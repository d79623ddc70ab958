"""Triangles that rings enclose are those that pythoncdt leaves."""

import numpy as np
import pytest
from twins import needs_compiler

from bubblemesh.kernels.enclosing import enclosed
from bubblemesh.meshes import triangulation
from bubblemesh.meshes.triangulation import linked

TURN = 2 * np.pi


def circle(radius, count, begin=0.0, share=1.0):
    """Points on a circle, or on a share of it."""
    angle = begin + TURN * share * np.arange(count) / count
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def ring(first, count):
    """Sides between numbers from the first one on."""
    return np.column_stack([first + np.arange(count), first + np.roll(np.arange(count), -1)])


def asked(monkeypatch):
    """What `enclosed` has found, which `linked` keeps."""
    found = []

    def noted(*arguments):
        found.append(enclosed(*arguments))
        return found[-1]

    monkeypatch.setattr(triangulation, "enclosed", noted)
    return found


@needs_compiler
@pytest.mark.parametrize("seed", range(8))
def test_nested_rings_with_lines_between_them_enclose_what_pythoncdt_leaves(seed, monkeypatch):
    random = np.random.default_rng(seed)
    counts = random.integers(5, 40, 4)
    rings = [circle(radius, count, random.random()) for radius, count in zip((1, 0.8, 0.5, 0.3), counts, strict=True)]
    line, free = circle(0.65, 6, random.random(), 0.5), random.uniform(-1.2, 1.2, (60, 2))
    points = np.concatenate([*rings, line, free])
    begin = np.cumsum([0, *counts])
    walls = np.concatenate([ring(first, count) for first, count in zip(begin[:-1], counts, strict=True)])
    between = ring(begin[-1], 6)[:-1]
    both = np.concatenate([walls, between])
    two_sided = np.arange(len(both)) >= len(walls)
    found = asked(monkeypatch)
    mine = linked(points, both, two_sided)
    monkeypatch.setattr(triangulation, "enclosed", lambda *arguments: None)
    known = linked(points, both, two_sided)
    assert len(found[0]) > 0
    for one, other in zip(mine, known, strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_side_that_passes_through_a_node_is_left_to_pythoncdt(monkeypatch):
    points = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0], [0.5, 0.5]])
    found = asked(monkeypatch)
    triangles, edges = linked(points, ring(0, 4))
    assert found == [None]
    assert (len(triangles), len(edges)) == (5, 10)
