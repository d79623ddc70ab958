"""Layers on random walls: always a sound mesh, with the requested heights where nothing is in the way."""

import json

import numpy as np
import pytest
from invariants import check_area, check_arrays, check_edges, check_facets_do_not_cross, check_labels
from random_walls import walled

from bubblemesh.case import load_case
from bubblemesh.problem.prepare import prepare
from bubblemesh.run.pipeline import mesh_problem


@pytest.mark.long
@pytest.mark.parametrize("seed", range(40))
def test_layers_on_random_walls_are_sound(seed):
    problem = prepare(load_case("a.yaml", text=json.dumps(walled(seed))))
    mesh = mesh_problem(problem).mesh
    for invariant in (check_arrays, check_edges, check_facets_do_not_cross, check_area, check_labels):
        invariant(mesh)
    kept, free = first_heights(problem.rest.strips)
    assert kept >= 0.99 * free


def first_heights(strips):
    """Length of walls with the requested first height to 5 % at both ends, and of all where nothing is in the way."""
    columns, heights = strips.columns, strips.heights
    kept = free = 0.0
    for pair in np.flatnonzero(columns.with_first_cells):
        ends = columns.pair[pair]
        if not ((heights.count[ends] > 0) & (heights.factor[ends] == 1)).all():
            continue
        (ax, ay), (bx, by) = columns.start[ends].tolist()
        length = np.hypot(bx - ax, by - ay)
        requested = [columns.ladders[k].first for k in columns.ladder[ends]]
        above = [
            ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / length
            for x, y in strips.x[strips.node(ends, np.ones_like(ends))].tolist()
        ]
        free += length
        kept += length if np.allclose(above, requested, rtol=0.05, atol=0) else 0.0
    return kept, free
