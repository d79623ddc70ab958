"""Curves that form no ring beside those that do: what is advised works."""

import re

import numpy as np
import pytest

from bubblemesh.case import load_case
from bubblemesh.errors import GeometryError
from bubblemesh.problem.domain import case_domain
from bubblemesh.readers.rings.open_curves import on_rings

SQUARE = ["0 0, 4 0", "4 0, 4 4", "4 4, 0 4", "0 4, 0 0"]
BORE = ["1 1, 2 1, 2 2, 1 1"]
TICKS = ["4 4, 5 4", "5 3.9, 5 4.1", "-1 2, 5 2", "2 -1, 2 5"]
GAP = ["0 0, 4 0", "4 0.01, 4 4", "4 4, 0 4", "0 4, 0 0"]
WIDE_GAP = ["0 0, 4 0", "4 1, 4 4", "4 4, 0 4", "0 4, 0 0"]


@pytest.fixture
def domain(written):
    def read(lines, keys=""):
        written("lines.wkt", "\n".join(f"LINESTRING ({line})" for line in lines))
        return case_domain(load_case(written("case.yaml", f"domain: {{file: lines.wkt{keys}}}\nspacing: 0.3\n")))

    return read


def advice(domain, lines):
    with pytest.raises(GeometryError) as caught:
        domain(lines)
    message = str(caught.value)
    return message, [", " + " , ".join(re.findall(r"(?:join|open): \S+", way)) for way in message.split("; or ")]


def test_open_curves_are_left_out_where_asked_with_their_count_and_places(domain):
    found = domain(SQUARE + BORE + TICKS, ", open: skip")
    assert (found.polygon.area, found.hole_count) == (15.5, 1)
    (note,) = found.notes
    assert note == "lines.wkt: 4 open curves left out, at (4, 4), (5, 3.9), (-1, 2), (2, -1)"


@pytest.mark.parametrize(
    ("lines", "areas"),
    [
        (SQUARE + BORE + TICKS, [15.5]),
        (SQUARE + TICKS[:1], [16]),
        (GAP + BORE, [15.5]),
        (GAP, [16]),
        (GAP + BORE + TICKS[1:], [15.5]),
        ([*WIDE_GAP, "1 1, 3 1, 3 3, 1 1"], [2]),
    ],
)
def test_each_way_that_is_named_works(domain, lines, areas):
    message, ways = advice(domain, lines)
    assert "ends" in message
    found = [domain(lines, keys.replace(" ,", ",")) for keys in ways]
    assert [one.polygon.area for one in found[: len(areas)]] == pytest.approx(areas, rel=0.01), message


def test_a_join_is_advised_only_where_gaps_are_narrow(domain):
    message, _ = advice(domain, [*WIDE_GAP, *BORE])
    assert "lines.wkt: open ends: feature 0 (line 1) at (4, 0), feature 1 (line 2) at (4, 1); the" in message
    assert "; the widest gap to a next one is 1, at (4, 0): set open: skip, which leaves out" in message
    assert "forms no ring (1 ring stays); what closes by itself: feature 4 (line 5): choose by feature: 4" in message
    message, _ = advice(domain, WIDE_GAP)
    assert message.endswith("draw what is missing and remove double lines, or choose a layer or feature")


def test_a_line_between_two_rings_is_part_of_none(domain):
    squares = [*SQUARE, "8 0, 9 0", "9 0, 9 1", "9 1, 8 1", "8 1, 8 0"]
    found = domain([*squares, "4 0, 6 0.2", "6 0.2, 8 0"], ", open: skip, part: all")
    assert (found.polygon.area, found.piece_count) == (17, 2)
    assert found.notes == ("lines.wkt: 2 open curves left out, at (4, 0), (6, 0.2)",)


@pytest.mark.parametrize("seed", range(5))
def test_curves_on_rings_are_those_that_leave_their_ends_connected(seed):
    rng = np.random.default_rng(seed)
    nodes = rng.integers(0, 20, (24, 2))

    def reached(start, edges):
        seen = {start}
        for _ in range(20):
            seen |= {b for one in edges for a, b in (one, one[::-1]) if a in seen}
        return seen

    edges = nodes.tolist()
    twin = [b in reached(a, [e for j, e in enumerate(edges) if j != k]) for k, (a, b) in enumerate(edges)]
    assert on_rings(nodes).tolist() == twin
    assert 0 < sum(twin) < 24


def test_a_drawing_of_many_strokes_is_read_in_time(domain):
    ticks = [f"{k / 1000} 5, {k / 1000} 6" for k in range(4000)]
    found = domain([*SQUARE, *ticks], ", open: skip")
    assert found.polygon.area == 16
    assert "4,000 open curves left out, the first at (0, 5), " in found.notes[0]
