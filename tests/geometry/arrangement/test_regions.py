import re

import numpy as np
import pytest
from partitions import areas_of, check_net, packed
from paths import ROOT

from bubblemesh.case import load_case
from bubblemesh.problem.prepare import prepare

PAGE = (ROOT / "docs/regions.md").read_text()
BLOCKS = re.findall(r"```yaml\n(.*?)```", PAGE, flags=re.DOTALL)
METHODS = ["multilevel", "accelerated"]

COMPOSITE = """
domain:
  outer: {rectangle: [0, 0, 4, 2], labels: [bottom, right, top, left]}
  region: matrix
  regions:
    - {name: a, ring: {rectangle: [0, 0, 2, 1]}}
    - {name: b, ring: {rectangle: [2, 0, 5, 1]}, spacing: 0.09}
    - {name: c, ring: {circle: {center: [3, 1.5], radius: 0.2}}, spacing: 0.06}
    - {name: d, ring: {circle: {center: [0, 2], radius: 0.5}}}
  holes:
    - {circle: {center: [1, 0.35], radius: 0.15}, label: hole}
  lines:
    - {path: [[1, 0.75], [1, 1.5], {arc: {to: [1.5, 1.5], center: [1.25, 1.5], turn: right}}], label: crack}
  points:
    - {at: [3.5, 1.5], label: well}
spacing: 0.15
"""
TILES = """
domain:
  outer: {polygon: [[0, 0], [2, 0], [2, 1], [1, 1.5], [0, 1]]}
  regions:
    - {name: a, ring: {rectangle: [0, 0, 1, 0.5]}}
    - {name: b, ring: {polygon: [[1, 0], [3, 0], [3, 3], [1, 0.5]]}}
    - {name: c, ring: {polygon: [[0.2, 0.1], [0.8, 0.2], [0.4, 0.4]]}}
  holes: [{rectangle: [0.9, 0.6, 1.1, 0.8]}]
  lines: [{path: [[0.1, 0.45], [0.9, 1.2], [0.1, 1]], label: crack}]
spacing: 0.1
"""
CRACKS = """
domain:
  outer: {rectangle: [0, 0, 1, 1]}
  lines:
    - {path: [[0.2, 0.2], [0.8, 0.8]], label: one}
    - {path: [[0.2, 0.8], [0.8, 0.2]], label: two}
    - {path: [[0, 0.5], [0.3, 0.5]], label: edge}
spacing: 0.08
"""
TOUCHING = """
domain:
  outer: {rectangle: [0, 0, 1, 1]}
  regions:
    - {name: a, ring: {circle: {center: [0.3, 0.5], radius: 0.2}}}
    - {name: b, ring: {circle: {center: [0.6, 0.5], radius: 0.1}}}
    - {name: c, ring: {circle: {center: [0.3, 0.4], radius: 0.1}}}
    - {name: d, ring: {circle: {center: [0.85, 0.5], radius: 0.15}}}
spacing: 0.05
"""


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("text", [COMPOSITE, TILES, CRACKS, TOUCHING], ids=["composite", "tiles", "cracks", "touching"])
def test_every_region_is_meshed_once_and_lines_are_edges(text, method):
    check_net(*packed(text, method))


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
def test_areas_of_regions(method):
    areas = areas_of(*packed(COMPOSITE, method))
    hole, bend, disc, quarter = np.pi * 0.15**2, np.pi * 0.25**2 / 2, np.pi * 0.2**2, np.pi * 0.5**2 / 4
    assert bend > 0
    expected = {"a": 2 - hole, "b": 2.0, "c": disc, "d": quarter, "matrix": 4 - disc - quarter}
    assert areas == {name: pytest.approx(area, rel=0.03) for name, area in expected.items()}
    assert areas["b"] == pytest.approx(2, rel=1e-12)


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
def test_an_embedded_point_is_a_node(method):
    _, net = packed(COMPOSITE, method)
    assert np.hypot(*(net.bubbles.x - [3.5, 1.5]).T).min() == 0


def spacing_of(text, *points):
    return prepare(load_case("spacing.yaml", text=text)).spacing(np.array(points, float)).tolist()


def test_the_spacing_of_a_region_counts_inside_and_the_finest_on_the_rim():
    points = (1, 0.9), (2.5, 0.5), (3, 1.5), (2, 0.5), (2.5, 1), (3.2, 1.5), (3, 1.8)
    assert spacing_of(COMPOSITE, *points) == [0.15, 0.09, 0.06, 0.09, 0.09, 0.06, 0.15]


def test_a_coarser_region_does_not_coarsen_its_rim():
    assert spacing_of(COMPOSITE.replace("0.09", "0.3"), (2, 0.5), (2.5, 0.5), (2.5, 1)) == [0.15, 0.3, 0.15]


def test_the_innermost_of_nested_regions_has_its_spacing():
    text = """
domain:
  outer: {rectangle: [0, 0, 1, 1]}
  regions:
    - {name: inner, ring: {rectangle: [0.4, 0.4, 0.6, 0.6]}, spacing: 0.2}
    - {name: outer, ring: {rectangle: [0.2, 0.2, 0.8, 0.8]}, spacing: "0.1 + 0*x"}
spacing: 0.3
"""
    assert spacing_of(text, (0.5, 0.5), (0.3, 0.3), (0.1, 0.1), (0.4, 0.5), (0.2, 0.5)) == [0.2, 0.1, 0.3, 0.1, 0.1]


@pytest.mark.long
@pytest.mark.parametrize("text", [text for text in BLOCKS if "spacing:" in text and "file:" not in text])
def test_the_page_s_cases_run(text):
    check_net(*packed(text))


def test_the_page_shows_a_case_of_each_kind():
    shown = "".join(BLOCKS)
    assert all(f"  {key}:" in shown for key in ("regions", "region", "lines", "points", "periodic"))
