"""The section on boundary layers of a run's page, and what of the page leaves their cells out."""

import base64
import io
import json
import re

import pytest
from PIL import Image
from report_pages import Elements, page_of

from bubblemesh.case import load_case
from bubblemesh.pages.layers import layers_section
from bubblemesh.run.pipeline import mesh_case

CASE = """
name: channel
domain:
  outer: {rectangle: [0, 0, 1.2, 0.6], labels: [wall, outlet, wall, inlet]}
  holes: [{circle: {center: [0.4, 0.3], radius: 0.1}, label: "<i>pin</i>"}]
spacing: 0.06
packing: {effort: fast}
layers:
  - {on: wall, first: 0.004, count: 4}
  - {on: "<i>pin</i>", first: 0.003, growth: 1.3, count: 20}
"""


@pytest.fixture(scope="module")
def layered(tmp_path_factory):
    path = tmp_path_factory.mktemp("layers") / "channel.yaml"
    path.write_text(CASE)
    return mesh_case(load_case(path))


def section_of(page):
    found = re.search(r'<section aria-labelledby="layers-title">.*?</section>', page, re.DOTALL)
    return found and found[0]


@pytest.fixture(scope="module")
def section(layered):
    """The section of the page of this run."""
    return section_of(page_of(layered))


def test_each_label_has_a_row_and_the_lowest_column_a_place(layered, section):
    wall, pin = layered.report["layers"]
    rows = [re.findall(r"<td[^>]*>(.*?)</td>", row) for row in re.findall(r"<tr>(.*?)</tr>", section)][1:]
    assert [row[0] for row in rows] == ["wall", "&lt;i&gt;pin&lt;/i&gt;"]
    assert rows[0][1:7] == ["4", str(wall["columns"]), "100.0%", "0.004 x 1.000", "100.0%", f"{wall['thickness']:.3g}"]
    assert rows[0][7] == f"{wall['orthogonality']['least']:.0f}, {wall['angle_max']['degrees']:.0f}°"
    assert rows[0][10] == ""
    numbers = [int(number) for number in re.findall(r"\d+", rows[1][1])]
    assert [*sorted({pin["count"]["least"], pin["count"]["most"]}), 20] == numbers
    assert rows[1][9] == f"{pin['across_front']:.2f}"
    lowest = pin["shortest"][0]
    assert rows[1][10].startswith(f"{lowest['layers']} at <button")
    (button, again) = Elements(section).named("button")
    assert [float(button[1][key]) for key in ("data-x", "data-y")] == pytest.approx(lowest["at"], abs=1e-5)
    assert again[1] == button[1]


def test_the_table_fits_into_1200_pixels(browser, layered, tmp_path):
    row = layered.report["layers"][1]
    row = row | {"shortest": [{"layers": 5, "at": [-0.0201618, -0.0132085]}], "columns": 12345, "region": "water"}
    (tmp_path / "a.html").write_text(page_of(layered, layers=[row]))
    browser.open(tmp_path / "a.html", width=1200)
    assert browser.js("const all = document.querySelector('.dense'); return all.scrollWidth <= all.clientWidth")


def test_a_picture_shows_the_wall(layered, section):
    ((_, attributes, _),) = Elements(section).named("img")
    picture = Image.open(io.BytesIO(base64.b64decode(attributes["src"].partition(",")[2])))
    assert min(picture.size) > 300
    assert len(picture.convert("RGB").getcolors(10**6)) > 20
    assert "where they are lowest" in section
    assert "in the middle of the wall" in layers_section(layered.mesh, layered.report["layers"][:1], in_plane=True)


def test_without_layers_there_is_no_section(page):
    assert section_of(page) is None
    assert "of the ideal number" in page


def test_worst_triangles_and_histograms_are_those_beside_the_layers(layered):
    q = layered.fields["quality"]
    inside = q < 0.5
    assert inside.sum() > 20
    layered.fields["layer"] = inside.astype(float)
    page = page_of(layered)
    del layered.fields["layer"]
    head = json.loads(Elements(page).named("script", id="head")[0][2])
    assert [q[t] for t in head["worst"]] == sorted(q[~inside])[:10]
    assert f"Histogram of {(~inside).sum()} triangles." in page
    assert "layers included" in page
    assert "of the ideal number" not in page
