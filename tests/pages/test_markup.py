"""Parts of pages: escaped text, JSON, charts."""

import json
import re

import numpy as np
import pytest
from report_pages import NASTY, Elements

from bubblemesh.meshes.histograms import histogram
from bubblemesh.meshfiles.text import readable_json
from bubblemesh.pages.charts import ChartLine, histogram_chart, line_chart
from bubblemesh.pages.markup import Markup, from_template, html, linked_places, tag
from bubblemesh.pages.scene import json_block


def test_text_is_escaped_wherever_it_goes():
    nasty = "<b>&\"'</b>"
    assert (
        tag("p", nasty, title=nasty)
        == '<p title="&lt;b&gt;&amp;&quot;&#x27;&lt;/b&gt;">&lt;b&gt;&amp;&quot;&#x27;&lt;/b&gt;</p>'
    )
    assert html(Markup("<i>"), nasty, None, 3) == "<i>&lt;b&gt;&amp;&quot;&#x27;&lt;/b&gt;3"
    assert tag("input", checked=True, hidden=False, data_x=1, class_="a") == '<input checked data-x="1" class="a">'
    page = from_template(
        "page.html", title=nasty, policy="", style="$body", body=tag("p", "$title"), script="", width=""
    )
    assert page.count("&lt;b&gt;") == 1
    assert "<p>$title</p>" in page


@pytest.mark.parametrize("text", NASTY)
def test_data_in_json_cannot_end_its_element(text):
    block = json_block("head", {"name": text, "array": np.arange(3)})
    ((name, attributes, content),) = Elements(block).found
    assert (name, attributes["id"]) == ("script", "head")
    assert json.loads(content) == {"name": text, "array": [0, 1, 2]}
    assert "<" not in content


@pytest.mark.parametrize(
    ("message", "places"),
    [
        ("the worst triangle, at (0.5, -1), has 3", [(0.5, -1)]),
        ("from (1e-05, 2.5e+20) to (-0.25, 7)", [(1e-5, 2.5e20), (-0.25, 7)]),
        ("a size (0.3) of <b> (x, y), and (1, 2, 3)", []),
        ("(1e999, 1)", []),
    ],
)
def test_places_in_messages_become_buttons(message, places):
    markup = linked_places(message)
    buttons = Elements(markup).named("button")
    assert [(float(b[1]["data-x"]), float(b[1]["data-y"])) for b in buttons] == places
    assert "".join(re.split(r"<[^>]*>", markup)) == html(message)


def test_json_for_readers_is_the_same_data_in_short_lines():
    data = {"a": [[0.5, 1], [2, 3]] * 40, "ü": {"b": [], "c": None}, "long": ["x" * 30] * 9, "text": '"\n'}
    text, omitted = readable_json(data, 10_000)
    assert json.loads(text) == data
    assert omitted == 0
    assert max(map(len, text.splitlines())) <= 96
    assert '  "ü": {"b": [], "c": null},' in text.splitlines()
    head, omitted = readable_json(data, 5)
    assert head.splitlines() == text.splitlines()[:5]
    assert omitted == len(text.splitlines()) - 5


def test_bars_are_as_high_as_their_shares():
    counted = histogram(np.repeat([0.05, 0.15, 0.35, 2], [1, 3, 6, 2]), 0, 0.4, 4)
    chart = Elements(histogram_chart("q", counted, "triangles", [0, 0.4]))
    heights = [float(bar[1]["height"]) for bar in chart.named("rect")]
    assert heights[2] == 0
    assert np.allclose(np.array(heights) / heights[0], [1, 3, 0, 6], atol=0.01)
    titles = [element[2] for element in chart.named("title")]
    assert titles[0] == "q. Histogram of 12 triangles. Most, 50%, are from 0.3 to 0.4."
    assert titles[1:] == [
        "0 to 0.1: 1 triangles, 8.3%",
        "0.1 to 0.2: 3 triangles, 25.0%",
        "0.2 to 0.3: 0 triangles, 0.0%",
        "0.3 to 0.4: 6 triangles, 50.0%",
    ]
    assert chart.named("span", **{"class": "note"})[0][2] == "2 above"


@pytest.mark.parametrize("logarithmic", [False, True])
def test_lines_go_through_their_points(logarithmic):
    points = [(0, 1e-4), (1, 1e-3), (2, 1e-2), (4, 1e-1)]
    chart = Elements(line_chart("v", "step", [ChartLine("a", points, True)], 1e-5, 1, logarithmic=logarithmic))
    (line,) = chart.named("polyline")
    x, y = np.array([pair.split(",") for pair in line[1]["points"].split()], float).T
    assert np.allclose((x - x[0]) / (x[1] - x[0]), [0, 1, 2, 4], atol=0.01)
    heights = np.log10([value for _, value in points]) if logarithmic else np.array([value for _, value in points])
    assert np.allclose((y - y[0]) / (y[3] - y[0]), (heights - heights[0]) / (heights[3] - heights[0]), atol=0.01)
    assert len(chart.named("circle")) == 4
