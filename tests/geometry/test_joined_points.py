"""Points beside the boundary or a line, moved onto it by ``join``."""

import pytest

from bubblemesh.case import load_case
from bubblemesh.errors import GeometryError
from bubblemesh.problem.prepare import prepare

HILL = """
domain:
  outer: {polygon: [[-50, -50], [50, -50], [50, 0], [0, 1.004], [-50, 0]]}
  lines: [{path: [[-20, -20], [20, -20]], label: seam}]
  points: [POINTS]
spacing: 10
"""


@pytest.mark.parametrize(
    ("point", "place"),
    [
        ("{at: [0, 1], label: E1, join: 0.01}", (0, 1.004)),
        ("{at: [-50, -10.001], label: E1, join: 0.01}", (-50, -10.001)),
        ("{at: [-50.009, -10], label: E1, join: 0.01}", (-50, -10)),
        ("{at: [3, -20.009], label: E1, join: 0.01}", (3, -20)),
        ("{file: e.csv, name: id, join: 10, scale: 0.001}", (-50, -10)),
    ],
)
def test_points_are_joined_to_what_is_within_their_reach(tmp_path, point, place):
    (tmp_path / "e.csv").write_text("x,y,id\n-50009,-10000,E1\n")
    (tmp_path / "a.yaml").write_text(HILL.replace("POINTS", point))
    domain = prepare(load_case(tmp_path / "a.yaml")).domain
    (found,) = domain.parts.points
    assert found.at == pytest.approx(place, abs=1e-12)
    told = [note for note in domain.notes if "joined to lines and rings" in note and "'E1'" in note]
    assert len(told) == (place != (-50, -10.001))


def test_points_beyond_their_reach_stay():
    text = HILL.replace("POINTS", "{at: [0, -5], label: E1, join: 0.01}")
    assert prepare(load_case("a.yaml", text=text)).domain.parts.points[0].at == (0, -5)


@pytest.mark.parametrize("at", [(0, 1.00399), (-49.99995, -10)])
def test_points_beside_the_boundary_are_named_with_the_key_that_moves_them(at):
    text = HILL.replace("POINTS", f"{{at: {list(at)}, label: E1}}")
    with pytest.raises(GeometryError, match="join beside the point 'E1' moves it there"):
        prepare(load_case("a.yaml", text=text))
