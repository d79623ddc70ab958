"""Warnings of lines that end just before they meet something."""

import json

import numpy as np
import pytest
import shapely

import bubblemesh
from bubblemesh.case import load_case
from bubblemesh.geometry.arrangement.open_ends import FAR, NEARLY_CLOSED
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.problem.domain import case_domain
from bubblemesh.problem.prepare import prepare

BOX = "domain:\n  outer: {rectangle: [0, 0, 20, 10], labels: [bottom, right, top, left]}\n"
MAIN = "{path: [[1, 5], [19, 5]], label: main}"


def told(lines, spacing="2", more=""):
    """Warnings on ends of lines in a box of 20 by 10."""
    case = load_case("ends.yaml", text=f"{BOX}  lines: [{lines}]\nspacing: {spacing}\n{more}")
    return [text for text in prepare(case).warnings if " ends at " in text]


def branch(gap, more=""):
    """A line that ends above the other one."""
    return f"{MAIN}, {{path: [[8, 9], [10, {5 + gap}]], label: branch{more}}}"


def test_a_confluence_that_misses_is_told_with_the_join_that_closes_it():
    (text,) = told(branch(0.05))
    assert text.startswith("the line 'branch' ends at (10, 5.05), 0.05 from 'main', where the spacing is 2: ")
    assert text.endswith(": join: 0.053 closes the gap")
    assert told(branch(0.05, ", join: 0.053")) == []
    assert told(branch(0.5)) == []


def test_the_spacing_there_decides_and_not_the_size_of_the_domain():
    assert told(branch(0.05), "{value: 2, near: {point: [10, 5.05], size: 0.05}}") == []
    (text,) = told(branch(0.3), "{value: 1, nodes: 40}")
    assert text.startswith("the line 'branch' ends at (10, 5.3), 0.3 from 'main', where the spacing is ")


def test_a_blind_fault_just_below_a_fine_surface_is_meant():
    text = """
domain:
  outer: {rectangle: [-50000, -50000, 50000, 0], label: surface}
  lines:
    - {path: [[-50000, -800], [50000, -800]], label: horizon}
    - {path: [[0, -40], [0, -3000]], label: fault}
  regions: [{name: cover, at: [-40000, -300]}]
spacing: {value: 5000, near: [{label: fault, size: SIZE}]}
"""
    found = prepare(load_case("fault.yaml", text=text.replace("SIZE", "20"))).warnings
    assert not any("fault" in warning for warning in found)
    found = prepare(load_case("fault.yaml", text=text.replace("SIZE", "500"))).warnings
    assert any("the line 'fault' ends at (0, -40), 40 from 'surface', where the spacing is 500" in one for one in found)


def test_own_bends_and_ends_that_meet_something_are_no_gaps():
    staircase = "{path: [[2, 2], [8, 2], [8, 2.1], [8.1, 2.1], [8.1, 2.2]], label: steps}"
    assert told(f"{MAIN}, {staircase}") == []
    assert told(branch(0)) == []
    assert told("{path: [[2, 2], [8, 0]], label: wall}") == []


def test_a_line_that_nearly_closes_is_told_once_and_takes_no_join():
    (text,) = told("{path: [[2, 2], [8, 2], [8, 8], [2, 2.1]], label: loop}")
    assert text.endswith("0.1 from its other end, where the spacing is 2: give the point there, if 0.1 are missing")


def test_a_crack_shorter_than_the_spacing_does_not_nearly_close():
    assert told("{path: [[5, 5], [5.3, 5]], label: crack}") == []


def test_several_ends_are_one_warning_with_the_widest():
    comb = ", ".join(
        f"{{path: [[{x}, 9], [{x}, {5 + gap}]], label: t{x}}}" for x, gap in ((4, 0.2), (8, 0.1), (12, 0.3))
    )
    (text,) = told(f"{MAIN}, {comb}")
    assert text == (
        "the line 't8' ends at (8, 5.1), 0.1 from 'main', where the spacing is 2: join: 0.1 closes the gap (and 2 "
        "more ends, up to 0.3 from something)"
    )


def test_join_is_in_the_lengths_of_the_file(tmp_path):
    lines = [[[1000, 5000], [19000, 5000]], [[8000, 9000], [10000, 5050]]]
    features = [
        {"type": "Feature", "properties": {}, "geometry": {"type": "LineString", "coordinates": line}} for line in lines
    ]
    path = tmp_path / "rivers.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    (text,) = told(f"{{file: {path}, scale: 0.001, label: river}}")
    assert "0.05 from 'river', where the spacing is 2: join: 53 closes the gap" in text
    assert told(f"{{file: {path}, scale: 0.001, label: river, join: 53}}") == []


def test_python_which_has_no_join_is_told_to_give_the_point():
    with pytest.warns(bubblemesh.MeshWarning, match=r"0.05 from 'main', where the spacing is 2: give the point there"):
        bubblemesh.mesh(
            shapely.box(0, 0, 20, 10), 2, lines={"main": np.array([[1, 5], [19, 5]]), "branch": [(8, 9), (10, 5.05)]}
        )


def bends(count, seed, step):
    """Paths (3, 2) of lines with one bend in a box of 20 by 10, of which none meets another one."""
    random, found = np.random.default_rng(seed), []
    for _ in range(20 * count):
        path = (random.uniform((3, 3), (17, 7)) + np.cumsum(random.uniform(-step, step, (3, 2)), axis=0)).round(4)
        if shapely.intersects(shapely.LineString(path).buffer(1e-3), list(map(shapely.LineString, found))).any():
            continue
        found.append(path)
        if len(found) == count:
            break
    return found


def ends_of(paths):
    lines = ", ".join(f"{{path: {path.tolist()}, label: l{number}}}" for number, path in enumerate(paths))
    return case_domain(load_case("ends.yaml", text=f"{BOX}  lines: [{lines}]\nspacing: 2\n")).open_ends


@pytest.mark.parametrize("seed", range(3))
def test_gaps_are_those_to_the_nearest_line_or_side_measured_one_by_one(seed):
    paths = bends(30, seed, 0.8)
    ends = ends_of(paths)
    corners = ends.boundary.corners.tolist()
    reach, walls, expected = 0.5, shapely.box(0, 0, 20, 10).exterior, {}
    for number, path in enumerate(paths):
        others = shapely.union_all([walls, *(shapely.LineString(one) for one in paths if one is not path)])
        first, last = sorted(map(tuple, path[[0, -1]].tolist()), key=lambda end: corners.index([*end]))
        closing = np.hypot(*np.subtract(first, last))
        for end, own in ((first, closing), (last, np.inf)):
            own = own if closing < NEARLY_CLOSED * shapely.LineString(path).length else np.inf
            width = min(own, others.distance(shapely.Point(end)))
            expected |= {end: (pytest.approx(width), f"'l{number}'")} if width <= reach else {}
    gaps = ends.gaps(np.full(len(ends.places), reach))
    assert len(gaps) > 10
    assert any("from its other end" in gap.text for gap in gaps)
    assert {tuple(gap.at.tolist()): (gap.width, gap.text.split()[2]) for gap in gaps} == expected
    assert np.all(np.diff([gap.width for gap in gaps]) >= 0)


def test_a_line_that_goes_there_and_back_has_a_gap_between_the_nearest_of_its_ends():
    ends = ends_of([np.array([(2, 2), (2, 6), (2, 2.1), (8, 2.1), (2, 2.1), (2.3, 2.05)])])
    (gap,) = ends.gaps(np.ones(4))
    assert gap.text == "the line 'l0' ends at (2, 2), 0.3 from its other end"
    assert gap.width == pytest.approx(np.hypot(0.3, 0.05))


@pytest.mark.parametrize("seed", range(3))
def test_advice_names_the_narrowest_gaps_of_some_ends_and_measures_few(seed, monkeypatch):
    ends = ends_of(bends(150, seed, 0.2))
    some = np.random.default_rng(seed).random(len(ends.places)) < 0.7
    gaps = ends.gaps(np.where(some, FAR * ends.size, 0))
    measured, foot = [], Boundary.foot
    monkeypatch.setattr(
        Boundary, "foot", lambda self, points, *rest: measured.append(len(points)) or foot(self, points, *rest)
    )
    told = ends.advice(some)
    assert len(gaps) > 100
    assert told == "; ".join(f"{gap.text} (join: {gap.join} closes that)" if gap.join else gap.text for gap in gaps[:3])
    assert sum(measured) < len(ends.places)
    assert ends.advice(np.zeros(len(ends.places), bool)) == ""
