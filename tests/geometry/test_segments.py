import numpy as np
import pytest
import shapely

from bubblemesh.geometry.segments import segments_meet


@pytest.mark.parametrize(
    "grid", [2, 5, 1000, None], ids=["mostly touching", "often touching", "rarely touching", "random"]
)
def test_segments_meet_as_exact_predicates_say(grid):
    random = np.random.default_rng(1)
    ends = random.random((5000, 2, 2, 2)) if grid is None else random.integers(0, grid + 1, (5000, 2, 2, 2)) / grid
    met = segments_meet(ends[:, 0], ends[:, 1])
    assert 0 < met.sum() < len(met)
    exact = shapely.intersects(shapely.linestrings(ends[:, 0]), shapely.linestrings(ends[:, 1]))
    assert np.array_equal(met, exact)


def test_an_end_a_rounding_beside_a_segment_is_seen_where_it_is():
    """The end of one lies on the other, or next to it by the least number there is."""
    segment = np.array([[0.0, 0.0], [1.0, 3.0]])
    on = np.array([0.25, 0.75])
    beside = np.stack([on, [np.nextafter(0.25, 0), 0.75], [np.nextafter(0.25, 1), 0.75]])
    others = np.stack([np.stack([point, [2.0, 0.0]]) for point in beside])
    assert segments_meet(np.repeat(segment[None], 3, axis=0), others).tolist() == [True, True, False]


def test_no_segments_meet_none():
    assert segments_meet(np.zeros((0, 2, 2)), np.zeros((0, 2, 2))).shape == (0,)
