"""Lines that do not close as they are: what programs and hands draw a little too long or too short."""

import numpy as np
import pytest

from bubblemesh.case import load_case
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.repair import THIN
from bubblemesh.problem.prepare import prepare

SIZE = 10.0


def drawn(tmp_path, lines):
    """A file with lines, each of some points."""
    parts = ", ".join(f"({', '.join(f'{x!r} {y!r}' for x, y in line)})" for line in np.array(lines, float).tolist())
    (tmp_path / "a.wkt").write_text(f"MULTILINESTRING({parts})")


def problem_of(tmp_path, over):
    """Problem of a square of four lines that reach beyond their corners by so much (8,), each at its two ends."""
    a, b = 0.0, SIZE
    lines = [
        [(a - over[0], a), (b + over[1], a)],
        [(b, a - over[2]), (b, b + over[3])],
        [(b + over[4], b), (a - over[5], b)],
        [(a, b + over[6]), (a, a - over[7])],
    ]
    drawn(tmp_path, lines)
    return prepared(tmp_path, "repair: true")


def prepared(tmp_path, key):
    return prepare(load_case(tmp_path / "a.yaml", text=f"domain: {{file: a.wkt, {key}}}\nspacing: 2\n"))


def test_areas_too_small_to_be_drawn_are_filled(tmp_path):
    a, b, tiny = 0.0, SIZE, THIN * SIZE / 3
    square = [[(a, a), (b, a)], [(b, a), (b, b)], [(b, b), (a, b)], [(a, b), (a, a)]]
    triangle = [[(2, 2), (2 + tiny, 2)], [(2 + tiny, 2), (2, 2 + tiny)], [(2, 2 + tiny), (2, 2)]]
    drawn(tmp_path, [*square, *triangle, [(a, a), (2, 2)], [(2, 2), (b, b)]])
    domain = prepared(tmp_path, "repair: true").domain
    assert domain.polygon.area == pytest.approx(SIZE**2, abs=1e-9)
    assert len(domain.polygon.interiors) == 0


def test_a_reach_within_which_all_lines_are_is_no_gap(tmp_path):
    """It would take minutes to link each end to each of the lines, and tell nothing."""
    drawn(tmp_path, [[(1, y), (9, y)] for y in np.linspace(0, SIZE, 600)])
    with pytest.raises(GeometryError, match="600 ends meet"):
        prepared(tmp_path, "repair: {gap: 0.5}")


@pytest.mark.parametrize("over", [1e-5, 8e-4, 9e-4, 1e-3, 1.1e-3, 2e-3, 0.01, 0.1])
@pytest.mark.parametrize("ends", [[1, 2], range(8)], ids=["one corner", "all corners"])
def test_ends_beyond_corners_are_left_out(tmp_path, over, ends):
    problem = problem_of(tmp_path, np.where(np.isin(range(8), ends), over, 0.0))
    assert problem.domain.polygon.area == pytest.approx(SIZE**2, abs=4 * SIZE * over if over < 1e-4 else 1e-9)
    assert problem.expected_nodes < 50  # nothing is finer than the square


@pytest.mark.long
@pytest.mark.parametrize("seed", range(100))
def test_ends_beyond_corners_by_anything_are_left_out(tmp_path, seed):
    random = np.random.default_rng(seed)
    over = SIZE * 10 ** random.uniform(-6, -2, 8) * random.integers(0, 2, 8)
    problem = problem_of(tmp_path, over)
    assert problem.domain.polygon.area == pytest.approx(SIZE**2, abs=0.05)
    assert problem.expected_nodes < 60
