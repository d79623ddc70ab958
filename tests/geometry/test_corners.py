import json

import numpy as np
import pytest

from bubblemesh.case import load_case
from bubblemesh.geometry import rings
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.corners import bends_of, turns
from bubblemesh.problem.domain import case_domain

CASE = {
    "outer": {"polygon": [[0, 0], [4, 0], [6, 2], [0, 2]], "labels": ["low", "right", "high", "left"]},
    "holes": [{"rectangle": [0.5, 0.5, 1, 1], "label": "hole"}],
    "lines": [{"path": [[2, 1], [3, 1], [3, 1.5]], "label": "line"}, {"path": [[0, 2], [0.2, 1.8]], "label": "tied"}],
    "points": [{"at": [0.2, 0.2], "label": "point"}],
}


@pytest.mark.parametrize(
    ("labels", "expected"),
    [
        (["hole"], {corner: 90 for corner in [(0.5, 0.5), (1, 0.5), (1, 1), (0.5, 1)]}),
        (["line"], {(2, 1): 180, (3, 1): 90, (3, 1.5): 180}),
        (["low", "right", "high", "left"], {}),
        (["low"], {(4, 0): 45}),
        (["tied", "high"], {(0.2, 1.8): 180}),
        (["point"], {}),
    ],
)
def test_directions_to_walls_turn_around_their_ends_and_bends_in_the_domain(labels, expected):
    domain = case_domain(load_case("a.yaml", text=json.dumps({"domain": CASE, "spacing": 1})))
    boundary = domain.boundary
    found = turns(boundary, np.isin(np.array(boundary.labels)[boundary.label], labels))
    turning = {tuple(boundary.corners[k].tolist()): np.degrees(found[k]) for k in np.flatnonzero(found > 1e-6)}
    assert turning == pytest.approx(expected)


def regular(sides):
    angle = -2 * np.pi * np.arange(sides) / sides
    return rings.polygon((0.2 * np.column_stack([np.cos(angle), np.sin(angle)]) + [1, 2]).tolist())


@pytest.mark.parametrize(
    ("hole", "around"),
    [
        (rings.circle((1, 2), 0.2).reversed(), True),
        (regular(24), True),
        (regular(6), False),
        (rings.circle((1, 2), 0.2), False),
    ],
    ids=["circle", "polygon", "sharp", "outer"],
)
def test_round_rings_with_the_domain_outside_bend_around_their_centres(hole, around):
    boundary = Boundary.of([hole])
    found, radii = bends_of(boundary, np.ones(len(boundary.ring), bool), 0.5)
    assert (len(found) > 0) == around
    np.testing.assert_allclose(found, np.broadcast_to([1.0, 2.0], found.shape), atol=1e-9)
    np.testing.assert_allclose(radii, 0.2)
    assert len(bends_of(boundary, np.zeros(len(boundary.ring), bool), 0.5)[0]) == 0
