"""Pages of runs and batches: what they hold, and what a real browser makes of them."""

import base64
import dataclasses
import json
import re
import zlib
from datetime import datetime
from html.parser import HTMLParser

import matplotlib as mpl
import numpy as np
import pytest
from browser import Browser, started
from typer.testing import CliRunner

from bubblemesh.case import load_case
from bubblemesh.cli import app
from bubblemesh.meshes.histograms import histogram
from bubblemesh.meshes.quality import radius_ratios
from bubblemesh.pages.charts import Line, histogram_chart, line_chart
from bubblemesh.pages.embedding import fixed_point, json_block, relative
from bubblemesh.pages.index import index_page
from bubblemesh.pages.json_text import readable_json
from bubblemesh.pages.markup import Markup, filled, joined, tag
from bubblemesh.pages.places import linked_places
from bubblemesh.pages.report import report_page
from bubblemesh.pages.scene import COLORMAP
from bubblemesh.run.pipeline import mesh_case

CASE = """
name: composite
domain:
  outer: {rectangle: [10, -3, 12, -2], labels: [bottom, right, top, left]}
  region: matrix
  regions: [{name: fibre, ring: {circle: {center: [11.4, -2.5], radius: 0.2}}, spacing: 0.06}]
  holes: [{circle: {center: [10.5, -2.5], radius: 0.2}, label: hole}]
  points: [{at: [10.9, -2.8], label: well}]
spacing: 0.1
"""
NASTY = ["</script><script>alert(1)</script>", "a\"b onload='x'", "it's & <b>", "漢字 größe $name", "<!--", "\\u003c"]
WRITTEN = datetime(2024, 3, 7, 16, 5)
FILES = ["composite.msh", "composite.report.json", "composite.html"]


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    path = tmp_path_factory.mktemp("case") / "composite.yaml"
    path.write_text(CASE)
    return mesh_case(load_case(path))


def page_of(result, mesh=None, **changes):
    report = {**result.report, "files": FILES, **changes}
    return report_page(mesh or result.mesh, result.fields, report, result.speeds, WRITTEN)


@pytest.fixture(scope="module")
def page(result):
    return page_of(result)


class Elements(HTMLParser):
    """The elements of a page in their order, and the text of each."""

    def __init__(self, text):
        super().__init__()
        self.found = []
        self.feed(text)

    def handle_starttag(self, name, attributes):
        self.found.append([name, dict(attributes), ""])

    def handle_data(self, data):
        if self.found:
            self.found[-1][2] += data

    def named(self, name, **attributes):
        return [e for e in self.found if e[0] == name and attributes.items() <= e[1].items()]


# Text


def test_text_is_escaped_wherever_it_goes():
    nasty = "<b>&\"'</b>"
    assert (
        tag("p", nasty, title=nasty)
        == '<p title="&lt;b&gt;&amp;&quot;&#x27;&lt;/b&gt;">&lt;b&gt;&amp;&quot;&#x27;&lt;/b&gt;</p>'
    )
    assert joined(Markup("<i>"), nasty, None, 3) == "<i>&lt;b&gt;&amp;&quot;&#x27;&lt;/b&gt;3"
    assert tag("input", checked=True, hidden=False, data_x=1, class_="a") == '<input checked data-x="1" class="a">'
    page = filled("page.html", title=nasty, policy="", style="$body", body=tag("p", "$title"), script="", width="")
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
    assert "".join(re.split(r"<[^>]*>", markup)) == joined(message)


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


# Charts


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
    chart = Elements(line_chart("v", "step", [Line("a", points, True)], 1e-5, 1, logarithmic=logarithmic))
    (line,) = chart.named("polyline")
    x, y = np.array([pair.split(",") for pair in line[1]["points"].split()], float).T
    assert np.allclose((x - x[0]) / (x[1] - x[0]), [0, 1, 2, 4], atol=0.01)
    heights = np.log10([value for _, value in points]) if logarithmic else np.array([value for _, value in points])
    assert np.allclose((y - y[0]) / (y[3] - y[0]), (heights - heights[0]) / (heights[3] - heights[0]), atol=0.01)
    assert len(chart.named("circle")) == 4


# The page as text


def integers(page, name):
    """An array of the page, as a reader of its format would unpack it."""
    ((_, attributes, text),) = Elements(page).named("script", id=name)
    content = zlib.decompress(base64.b64decode(text))
    width = int(attributes["data-width"])
    planes = np.frombuffer(content, np.uint8).reshape(width, -1).astype(np.int64)
    return sum(plane << (8 * rank) for rank, plane in enumerate(planes))


def test_the_page_holds_the_mesh(page, result):
    mesh = result.mesh
    head = json.loads(Elements(page).named("script", id="head")[0][2])
    points = integers(page, "points").reshape(2, -1).T / (2**32 - 1) * head["extent"] + head["origin"]
    assert np.abs(points - mesh.points).max() < 1e-9 * head["extent"]
    columns = integers(page, "triangles").reshape(3, -1)
    steps = np.where(columns % 2, -(columns + 1) // 2, columns // 2)
    first = np.cumsum(steps[0])
    assert np.array_equal(np.stack([first, first + steps[1], first + steps[2]], axis=1), mesh.triangles)
    q = radius_ratios(mesh.points, mesh.triangles)
    assert np.abs(integers(page, "quality") / (2**16 - 1) - q).max() < 1e-5
    assert np.array_equal(integers(page, "region"), mesh.triangle_regions)
    facets = integers(page, "facets").reshape(2, -1).T
    for k, label in enumerate(head["labels"]):
        mine = facets[label["start"] : label["start"] + label["count"]]
        assert label["name"] == mesh.labels[k]
        assert np.array_equal(mine, mesh.facets[mesh.facet_labels == k])
    assert [q[t] for t in head["worst"]] == sorted(q)[:10]
    assert [region["name"] for region in head["regions"]] == ["matrix", "fibre"]
    for region in head["regions"]:
        assert mesh.regions[mesh.triangle_regions[region["at"]]] == region["name"]
    assert head["points"] == [{"name": "well", "node": int(mesh.vertices[0])}]


def test_triangles_of_any_order_of_nodes_survive_the_packing():
    triangles = np.random.default_rng(0).integers(0, 5_000_000, (100, 3))
    steps = relative(triangles).astype(np.int64).T
    signed = np.where(steps % 2, -(steps + 1) // 2, steps // 2)
    first = np.cumsum(signed[0])
    assert np.array_equal(np.stack([first, first + signed[1], first + signed[2]], axis=1), triangles)
    assert fixed_point(np.array([-1, 0.0, 0.5, 1, 2]), 0, 1, np.uint16).tolist() == [0, 0, 32768, 65535, 65535]


def test_the_page_asks_nothing_of_the_network_and_runs_its_own_script_only(page):
    elements = Elements(page)
    assert not re.findall(r"https?:|//[a-z]+\.|@import|url\(", page)
    policy = elements.named("meta", **{"http-equiv": "Content-Security-Policy"})[0][1]["content"]
    assert policy.startswith("default-src 'none'; img-src data:; style-src 'sha256-")
    assert "unsafe" not in policy
    assert {img[1]["src"][:22] for img in elements.named("img")} == {"data:image/png;base64,"}
    assert {a[1]["href"] for a in elements.named("a")} == {f"./{name}" for name in FILES}
    assert len(elements.named("script", type="module")) == 1
    assert not [e for e in elements.found if any(key.startswith("on") or key == "style" for key in e[1])]


def test_the_page_tells_what_the_report_tells(page, result):
    report = result.report
    text = re.sub(r"<[^>]*>", " ", page)
    q = radius_ratios(result.mesh.points, result.mesh.triangles)
    for part in (
        f"{report['nodes']:,}",
        f"{report['quality']['mean']:.4f}",
        f"{report['spacing']['mean']:.3f}",
        "7 March 2024, 16:05",
        "seed 0",
        "1 warning",
        f"{q.min():.4f}",
        report["stop_reason"],
        *report["seconds"],
        *(f"{row['quality_mean']:.4f}" for row in report["rounds"]),
        "&quot;region&quot;: &quot;matrix&quot;",
    ):
        assert part in text, part


def test_names_with_markup_are_text_in_every_part_of_the_page(result):
    labels = tuple(NASTY[k % len(NASTY)] + str(k) for k in range(len(result.mesh.labels)))
    mesh = dataclasses.replace(result.mesh, labels=labels, regions=(NASTY[0], NASTY[1]), point_labels=(NASTY[2],))
    parameters = {**result.report["parameters"], "name": NASTY[0]}
    page = page_of(result, mesh, case=NASTY[0], warnings=[NASTY[0], NASTY[4]], parameters=parameters, method=NASTY[1])
    elements = Elements(page)
    assert len(elements.named("script")) == 8
    assert not [e for e in elements.found if any(key.startswith("on") for key in e[1])]
    assert elements.named("title")[0][2].strip() == f"{NASTY[0]} - bubblemesh report"
    assert elements.named("h1")[0][2].strip() == NASTY[0]


def test_a_mesh_of_second_order_far_from_the_origin(result):
    far = dataclasses.replace(result.mesh, points=result.mesh.points + 1e9, facet_middles=np.zeros((0, 2)))
    curved, _ = far.second_order()
    page = page_of(result, curved)
    head = json.loads(Elements(page).named("script", id="head")[0][2])
    points = integers(page, "points").reshape(2, -1).T / (2**32 - 1) * head["extent"]
    assert np.abs(points - (curved.points - head["origin"])).max() < 1e-9 * head["extent"]
    assert len(integers(page, "triangles")) == 3 * len(curved.triangles)


# The command


def run(folder, *arguments):
    (folder / "a.yaml").write_text(CASE.replace("0.06", "0.1"))
    done = CliRunner().invoke(app, ["run", str(folder / "a.yaml"), *map(str, arguments)])
    return done.exit_code, done.stderr


def test_run_writes_the_page_with_the_other_files_and_counts_its_time(tmp_path):
    code, said = run(tmp_path, "-o", tmp_path / "out/", "--report", "--format", "msh")
    assert code == 0, said
    assert {path.name for path in (tmp_path / "out").iterdir()} == set(FILES)
    report = json.loads((tmp_path / "out/composite.report.json").read_text())
    assert sorted(report["files"]) == sorted(FILES)
    seconds = dict(report["seconds"])
    assert seconds["page"] > 0
    assert seconds.pop("total") == pytest.approx(sum(seconds.values()))
    page = Elements((tmp_path / "out/composite.html").read_text())
    assert {a[1]["href"] for a in page.named("a")} == {f"./{name}" for name in FILES}


@pytest.mark.parametrize(
    ("options", "written"),
    [
        (["--set", "output.report=true"], True),
        (["--set", "output.report=true", "--no-report"], False),
        ([], False),
    ],
)
def test_the_case_may_ask_for_the_page_and_the_option_is_over_it(options, written, tmp_path):
    assert run(tmp_path, "-o", tmp_path / "plate.vtk", *options)[0] == 0
    assert (tmp_path / "plate.html").exists() == written


def test_a_page_cannot_go_to_the_standard_output_nor_over_the_case(tmp_path):
    code, said = run(tmp_path, "-o", "-", "--report")
    assert (code, said) == (2, "error: --report: there is no place for its files with -o -: drop one of them\n")
    (tmp_path / "composite.html").mkdir()
    assert run(tmp_path, "-o", f"{tmp_path}/", "--report")[0] == 5
    assert {path.name for path in tmp_path.iterdir()} == {"a.yaml", "composite.html"}


# The report in a browser


@pytest.fixture(scope="module")
def browser():
    driver = started()
    yield Browser(driver)
    driver.quit()


@pytest.fixture(scope="module")
def file(page, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "composite.html"
    path.write_text(page, encoding="utf-8")
    return path


@pytest.fixture
def opened(browser, file):
    """The page, freshly opened."""
    browser.open(file)
    return browser


def drawn(browser):
    return int(browser.find("#mesh").get_attribute("data-drawn"))


def zoomed(browser):
    return float(browser.text("#zoomed").removeprefix("zoom "))


def told(browser, places):
    """What the tip tells at places on the canvas: a list of terms and texts for each, None where it is hidden."""
    return browser.js(
        """
        const [places] = arguments, canvas = document.getElementById("mesh"), tip = document.getElementById("tip");
        const box = canvas.getBoundingClientRect();
        return places.map(([x, y]) => {
          const at = { clientX: box.left + canvas.clientLeft + x, clientY: box.top + canvas.clientTop + y };
          canvas.dispatchEvent(new PointerEvent("pointermove", { pointerId: 9, ...at }));
          return tip.hidden ? null : [...tip.querySelectorAll("dd")].map((cell) => cell.textContent);
        });
        """,
        places,
    )


def fitted(browser, mesh):
    """Places (n, 2) of points on the canvas when it shows the whole mesh, by the definition of that."""
    width, height = browser.js("const c = document.getElementById('mesh'); return [c.clientWidth, c.clientHeight]")
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    scale = min((width - 72) / (high - low)[0], (height - 72) / (high - low)[1])
    return lambda points: (points - (low + high) / 2) * scale * [1, -1] + [width / 2, height / 2]


def test_it_opens_without_complaint_and_draws_every_triangle(opened, result):
    assert opened.complaints() == []
    assert drawn(opened) == len(result.mesh.triangles)
    assert opened.text("#seen").startswith(
        f"{len(result.mesh.triangles)} of {len(result.mesh.triangles)} triangles drawn"
    )
    assert opened.js("return performance.getEntriesByType('resource').length") == 0


def test_every_triangle_is_where_it_belongs_and_tells_its_facts(opened, result):
    mesh = result.mesh
    centres = fitted(opened, mesh)(mesh.points[mesh.triangles].mean(axis=1))
    facts = told(opened, centres.tolist())
    q = radius_ratios(mesh.points, mesh.triangles)
    for t, (number, quality, _, region, *corners) in enumerate(facts):
        assert int(number) == t + 1
        assert float(quality) == pytest.approx(q[t], abs=1e-4)
        assert region == mesh.regions[mesh.triangle_regions[t]]
        places = np.array([corner.strip("()").split(", ") for corner in corners], float)
        assert np.abs(places - mesh.points[mesh.triangles[t]]).max() < 1e-6
    hole = fitted(opened, mesh)(np.array([[10.5, -2.5], [10.2, -1.9]]))
    assert told(opened, hole.tolist()) == [None, None]


def pixels(browser, places):
    return browser.js(
        """
        const canvas = document.getElementById("mesh"), context = canvas.getContext("2d");
        return arguments[0].map(([x, y]) => [...context.getImageData(x, y, 1, 1).data].slice(0, 3));
        """,
        np.floor(places).tolist(),
    )


def test_colours_are_those_of_the_scale_and_can_be_chosen(opened, result):
    mesh = result.mesh
    for part in ("edges", "names"):
        opened.click(f"[data-part={part}]")
    sample = np.linspace(0, len(mesh.triangles) - 1, 60).astype(int)
    centres = fitted(opened, mesh)(mesh.points[mesh.triangles[sample]].mean(axis=1))
    q = radius_ratios(mesh.points, mesh.triangles)[sample]
    low = json.loads(opened.text("#head"))["limits"]["quality"][0]
    levels = np.round(np.clip((q - low) / (1 - low), 0, 1) * 255).astype(int)
    wanted = (mpl.colormaps[COLORMAP](levels)[:, :3] * 255).round()
    assert np.abs(np.array(pixels(opened, centres)) - wanted).max() <= 3
    choose(opened, "region")
    by_region = {}
    for t, color in zip(sample, pixels(opened, centres), strict=True):
        by_region.setdefault(int(mesh.triangle_regions[t]), set()).add(tuple(color))
    assert [len(colors) for colors in by_region.values()] == [1, 1]
    assert by_region[0] != by_region[1]
    choose(opened, "none")
    assert len({tuple(color) for color in pixels(opened, centres)}) == 1
    shown = opened.js(
        "return [...document.querySelectorAll('[data-legend]')].filter(e => !e.hidden).map(e => e.dataset.legend)"
    )
    assert shown == ["none"]


@pytest.mark.parametrize("times", [0, 5, 12])
def test_there_are_no_gaps_between_triangles(opened, result, times):
    for part in ("edges", "names"):
        opened.click(f"[data-part={part}]")
    middle = opened.js("const c = document.getElementById('mesh'); return [c.clientWidth / 2, c.clientHeight / 2]")
    for _ in range(times):
        wheel(opened, middle, -100)
    empty = opened.js(
        """
        const canvas = document.getElementById("mesh"), { width, height } = canvas;
        const alpha = canvas.getContext("2d").getImageData(0, 0, width, height).data.filter((_, k) => k % 4 === 3);
        return [...alpha.keys()].filter((k) => alpha[k] < 255).map((k) => [k % width, Math.floor(k / width)]);
        """
    )
    width, height = (2 * size for size in middle)
    scale = zoomed(opened) * min((width - 72) / 2, height - 72)
    x, y = ((np.reshape(empty, (-1, 2)) + 0.5 - middle) / scale).T
    inside = (np.abs(x) < 1) & (np.abs(y) < 0.5) & (np.hypot(x + 0.5, y) > 0.2)
    # The boundary has lines upon it, and the hole's curve is a polygon.
    near = (np.abs(np.abs(x) - 1) < 0.02) | (np.abs(np.abs(y) - 0.5) < 0.02) | (np.hypot(x + 0.5, y) < 0.23)
    assert len(empty) > 1000 or times
    assert not (inside & ~near).any()


def choose(browser, colouring):
    script = (
        "const c = document.getElementById('colouring'); c.value = arguments[0]; c.dispatchEvent(new Event('change'))"
    )
    browser.js(script, colouring)
    browser.drawn()


def test_the_wheel_zooms_around_the_pointer(opened, result):
    mesh = result.mesh
    t = len(mesh.triangles) // 2
    (place,) = fitted(opened, mesh)(mesh.points[mesh.triangles[[t]]].mean(axis=1)).tolist()
    for _ in range(4):
        wheel(opened, place, -500)
    assert zoomed(opened) == pytest.approx(np.exp(4 * 500 * 0.0018), rel=0.01)
    assert 0 < drawn(opened) < len(mesh.triangles) / 20
    ((number, *_),) = told(opened, [place])
    assert int(number) == t + 1
    for _ in range(8):
        wheel(opened, place, 500)
    assert zoomed(opened) == 0.25  # as far as it goes
    assert drawn(opened) + int(opened.find("#mesh").get_attribute("data-hidden")) == len(mesh.triangles)


def wheel(browser, place, delta):
    browser.js(
        """
        const canvas = document.getElementById("mesh"), box = canvas.getBoundingClientRect();
        const [[x, y], deltaY] = arguments;
        const at = { clientX: box.left + canvas.clientLeft + x, clientY: box.top + canvas.clientTop + y };
        canvas.dispatchEvent(new WheelEvent("wheel", { ...at, deltaY, cancelable: true }));
        """,
        place,
        delta,
    )
    browser.drawn()


def test_the_wheel_scrolls_the_page_on_when_the_picture_comes_along(opened):
    opened.js("dispatchEvent(new Event('scroll'))")
    wheel(opened, [200, 200], -500)
    assert zoomed(opened) == 1


def test_dragging_moves_clicking_selects(opened, result):
    from selenium.webdriver.common.action_chains import ActionChains

    mesh, canvas = result.mesh, opened.find("#mesh")
    opened.js("arguments[0].scrollIntoView({ block: 'center' })", canvas)
    place = fitted(opened, mesh)
    start = place(mesh.points[mesh.triangles[[7]]].mean(axis=1))[0]
    middle = opened.js("const c = arguments[0]; return [c.offsetWidth / 2, c.offsetHeight / 2]", canvas)
    x, y = (start - middle + 1).round().astype(int).tolist()
    ActionChains(opened.driver, duration=20).move_to_element_with_offset(canvas, x, y).click().perform()
    opened.drawn()
    assert opened.text("#selected").startswith("triangle8quality q")
    ActionChains(opened.driver, duration=20).click_and_hold().move_by_offset(60, 30).release().perform()
    opened.drawn()
    ((number, *_),) = told(opened, [(start + np.array([60, 30])).tolist()])
    assert int(number) == 8
    assert zoomed(opened) == 1
    assert opened.text("#selected").startswith("triangle8quality q")  # a drag selects nothing
    opened.click("#fit")
    ((number, *_),) = told(opened, [start.tolist()])
    assert int(number) == 8


def test_two_fingers_pinch(opened):
    opened.js(
        """
        const canvas = document.getElementById("mesh"), box = canvas.getBoundingClientRect();
        const send = (kind, id, x, y) => canvas.dispatchEvent(
          new PointerEvent(kind, { pointerId: id, pointerType: "touch", clientX: box.left + x, clientY: box.top + y }));
        send("pointerdown", 1, 200, 150);
        send("pointerdown", 2, 300, 150);
        send("pointermove", 2, 400, 150);
        send("pointermove", 1, 100, 150);
        send("pointerup", 1, 100, 150);
        send("pointerup", 2, 400, 150);
        """
    )
    opened.drawn()
    assert zoomed(opened) == pytest.approx(3, rel=0.01)
    assert opened.text("#selected").startswith("None")


def test_keys_move_zoom_select_and_go_through_the_worst(opened, result):
    from selenium.webdriver.common.keys import Keys

    canvas = opened.find("#mesh")

    def press(*keys):
        canvas.send_keys(*keys)
        opened.drawn()

    press("++")
    assert zoomed(opened) == pytest.approx(2.25, rel=0.01)
    press("-")
    assert zoomed(opened) == pytest.approx(1.5, rel=0.01)
    before = drawn(opened)
    press(*[Keys.ARROW_RIGHT] * 6)
    assert drawn(opened) < before
    press("0")
    assert drawn(opened) == len(result.mesh.triangles)
    press(Keys.ENTER)
    width, height = opened.js("const c = arguments[0]; return [c.clientWidth, c.clientHeight]", canvas)
    ((number, *_),) = told(opened, [[width / 2, height / 2]])
    assert opened.text("#selected").startswith(f"triangle{number}")
    worst = np.argsort(radius_ratios(result.mesh.points, result.mesh.triangles), kind="stable") + 1
    for keys, t in (("n", worst[0]), ("n", worst[1]), ("p", worst[0]), ("p", worst[9])):
        press(keys)
        assert opened.text("#selected").startswith(f"triangle{t}quality")
    press(Keys.ESCAPE)
    assert opened.text("#selected").startswith("None")


def test_worst_triangles_and_places_of_warnings_are_shown(opened, result):
    q = radius_ratios(result.mesh.points, result.mesh.triangles)
    opened.click("button.worst[data-rank='2']")
    t = np.argsort(q, kind="stable")[2]
    assert opened.text("#selected").startswith(f"triangle{t + 1}quality q{q[t]:.4f}"[:-1])
    assert zoomed(opened) > 1.2
    width, height = opened.js("const c = document.getElementById('mesh'); return [c.clientWidth, c.clientHeight]")
    ((number, *_),) = told(opened, [[width / 2, height / 2]])
    assert int(number) == t + 1
    opened.click("#fit")
    button = opened.find(".warnings button.place")
    place = np.array([float(button.get_attribute(f"data-{axis}")) for axis in "xy"])
    opened.click(".warnings button.place")
    assert zoomed(opened) > 1.2
    ((_, _, _, _, *corners),) = told(opened, [[width / 2, height / 2]])
    triangle = np.array([corner.strip("()").split(", ") for corner in corners], float)
    assert np.hypot(*(triangle - place).T).min() < 0.1


def test_a_label_stands_out_alone(opened):
    opened.click("button.label[data-label='4']")
    pressed = "return [...document.querySelectorAll('button.label')].map((b) => b.getAttribute('aria-pressed'))"
    assert opened.js(pressed) == ["false"] * 4 + ["true", "false"]
    opened.click("button.label[data-label='4']")
    assert set(opened.js(pressed)) == {"false"}


def luminance(rgb):
    linear = [c / 3294.6 if c <= 10 else ((c / 255 + 0.055) / 1.055) ** 2.4 for c in rgb]
    return np.dot(linear, [0.2126, 0.7152, 0.0722])


@pytest.mark.parametrize("dark", [False, True])
def test_texts_have_contrast_in_both_themes(browser, file, dark):
    browser.open(file, dark=dark)
    pairs = browser.js(
        """
        const behind = (e) => {
          const colour = getComputedStyle(e).backgroundColor;
          return colour === "rgba(0, 0, 0, 0)" && e.parentElement ? behind(e.parentElement) : colour;
        };
        const names = "h1, h2, p, dt, dd, small, td, th, a, button, li, summary, pre, figcaption, span";
        const texts = document.querySelectorAll(names);
        const svg = [...document.querySelectorAll("svg text")];
        return [...new Set([
          ...[...texts].map((e) => `${getComputedStyle(e).color}|${behind(e)}`),
          ...svg.map((e) => `${getComputedStyle(e).fill}|${behind(e)}`),
        ])];
        """
    )
    assert len(pairs) >= 6
    for pair in pairs:
        lights = [luminance(list(map(int, re.findall(r"\d+", color)[:3]))) + 0.05 for color in pair.split("|")]
        assert max(lights) / min(lights) >= 4.5, pair
    page = browser.js("return getComputedStyle(document.body).backgroundColor")
    assert (page == "rgb(255, 255, 255)") != dark


def test_the_picture_follows_a_change_of_the_theme(opened):
    corner = "return [...document.getElementById('mesh').getContext('2d').getImageData(0, 0, 900, 400).data].join()"
    light = opened.js(corner)
    opened.media(dark=True)
    opened.drawn()
    assert opened.js(corner) != light


def test_print_has_a_still_picture_and_no_controls(opened):
    displayed = "return [...document.querySelectorAll(arguments[0])].map((e) => e.offsetParent !== null)"
    assert opened.js(displayed, ".viewer, .static") == [True, False]
    opened.media(print_=True)
    assert opened.js(displayed, ".viewer, .static") == [False, True]
    assert not any(opened.js(displayed, "canvas, select, input, button.worst, .toolbar button"))
    assert opened.js("return document.querySelector('.static img').naturalWidth") > 600
    assert opened.pdf().startswith(b"%PDF")


def test_the_picture_takes_no_notice_of_being_printed(opened, result):
    opened.click("button.worst[data-rank='1']")
    before = zoomed(opened), drawn(opened)
    opened.media(print_=True)
    for _ in range(3):  # frames, until all observers have been told
        opened.drawn()
    opened.media()
    opened.drawn()
    assert opened.complaints() == []
    assert (zoomed(opened), drawn(opened)) == before
    opened.click("#fit")
    assert drawn(opened) == len(result.mesh.triangles)


def test_without_scripts_there_are_picture_and_figures(browser, file):
    browser.open(file, scripts=False)
    browser.command("Emulation.setScriptExecutionDisabled", value=False)
    assert browser.find(".static img").is_displayed()
    assert not browser.find(".viewer").is_displayed()
    assert not browser.find("button.worst").is_displayed()
    assert "Mean quality q" in browser.find("main").text


def test_a_browser_that_cannot_unpack_shows_the_still_picture(browser, file):
    script = browser.command("Page.addScriptToEvaluateOnNewDocument", source="delete window.DecompressionStream")
    browser.command("Emulation.setDeviceMetricsOverride", width=1280, height=900, deviceScaleFactor=1, mobile=False)
    browser.driver.get(file.as_uri())
    browser.wait("return !document.getElementById('failure').hidden")
    browser.command("Page.removeScriptToEvaluateOnNewDocument", **script)
    assert browser.find(".static img").is_displayed()
    assert "still picture" in browser.find("#failure").text


def test_it_fits_a_telephone(browser, file):
    browser.open(file, width=390, height=844)
    assert browser.js("return document.documentElement.scrollWidth") <= 390
    assert browser.js("return document.getElementById('mesh').clientWidth") > 340
    assert browser.complaints() == []


def test_nothing_in_names_is_run(browser, result, tmp_path):
    labels = tuple(NASTY[k % len(NASTY)] + str(k) for k in range(len(result.mesh.labels)))
    mesh = dataclasses.replace(result.mesh, labels=labels, regions=(NASTY[0], "<img src=x onerror=alert(3)>"))
    page = page_of(result, mesh, case="<svg onload=alert(4)>", warnings=NASTY)
    (tmp_path / "nasty.html").write_text(page, encoding="utf-8")
    browser.open(tmp_path / "nasty.html")  # an alert would end this test
    assert browser.complaints() == []
    assert browser.driver.title == "<svg onload=alert(4)> - bubblemesh report"
    assert drawn(browser) == len(mesh.triangles)
    assert [
        button.text.rsplit(None, 1)[0] for button in browser.driver.find_elements("css selector", "button.label")
    ] == [label for label in labels]


# The index


ROWS = [
    {
        "case": "b",
        "exit_code": 0,
        "nodes": 500,
        "triangles": 900,
        "quality_mean": 0.98,
        "quality_p01": 0.9,
        "quality_min": 0.7,
    }
    | {"spacing_std": 0.07, "seconds": 1.5, "report": "b folder/b#1.html", "warnings": 2, "sweep": {"packing.w2": 0.5}},
    {"case": "a-2", "exit_code": 3, "message": "a.yaml: domain: <b> at (0, 1)", "warnings": []},
    {"case": "a-10", "exit_code": 4, "nodes": 4000, "triangles": 7900, "quality_mean": 0.95, "quality_p01": 0.8}
    | {"quality_min": 0.42, "spacing_std": 0.1, "seconds": 75.0, "report": "a-10.html", "error": "quality_min is 0.42"},
    {"case": "</script><b>", "exit_code": 0, "nodes": 60, "triangles": 90, "quality_mean": 0.99, "quality_p01": 0.97}
    | {"quality_min": 0.96, "spacing_std": 0.02, "seconds": 0.1, "warnings": ["one"], "sweep": {"packing.w2": 0.7}},
]


def test_the_index_lists_every_case_with_its_link_and_message():
    elements = Elements(index_page(ROWS))
    assert [e[1]["href"] for e in elements.named("a")] == ["./b%20folder/b%231.html", "./a-10.html"]
    text = index_page(ROWS)
    assert "4 cases: 2 done, 1 missed a requirement, 1 failed. 4,560 nodes in 1 min 17 s." in text
    assert "a.yaml: domain: &lt;b&gt; at (0, 1)" in text
    assert "quality_min is 0.42" in text
    assert "packing.w2" in text
    assert len(elements.named("svg", **{"class": "range"})) == 3
    assert len(elements.named("script")) == 1
    assert not re.findall(r"https?:", text)


def test_an_index_of_nothing_and_of_failures_only():
    assert "0 cases" in index_page([])
    assert "1 failed" in index_page([{"case": "a", "exit_code": 1}])


@pytest.fixture(scope="module")
def index(tmp_path_factory):
    path = tmp_path_factory.mktemp("index") / "index.html"
    path.write_text(index_page(ROWS), encoding="utf-8")
    return path


def cases(browser):
    return browser.js("return [...document.querySelectorAll('tbody th')].map((cell) => cell.textContent)")


def messages(browser):
    """The message below each case that has one."""
    return browser.js(
        """
        const rows = [...document.querySelectorAll("tr.message")];
        return Object.fromEntries(
          rows.map((row) => [row.previousElementSibling.cells[0].textContent, row.textContent]));
        """
    )


def heads(browser):
    buttons = browser.driver.find_elements("css selector", "th button")
    return {button.text: button for button in buttons}


@pytest.mark.parametrize(
    ("column", "order"),
    [
        ("Case", ["</script><b>", "a-2", "a-10", "b"]),
        ("Nodes", ["</script><b>", "b", "a-10", "a-2"]),
        ("Mean q", ["a-10", "b", "</script><b>", "a-2"]),
        ("Time", ["</script><b>", "b", "a-10", "a-2"]),
        ("Warnings", ["a-10", "</script><b>", "b", "a-2"]),
        ("packing.w2", ["b", "</script><b>", "a-2", "a-10"]),
    ],
)
def test_columns_sort_by_click_and_gaps_stay_last(browser, index, column, order):
    browser.open(index)
    assert browser.complaints() == []
    button = heads(browser)[column]
    button.click()
    assert cases(browser) == order
    assert button.find_element("xpath", "..").get_attribute("aria-sort") == "ascending"
    button.click()
    gaps = {"packing.w2": 2, "Case": 0}.get(column, 1)
    known, missing = (order[:-gaps], order[-gaps:]) if gaps else (order, [])
    assert cases(browser) == [*reversed(known), *missing]
    assert messages(browser) == {"a-2": "a.yaml: domain: <b> at (0, 1)", "a-10": "quality_min is 0.42"}
    assert browser.js("return document.querySelectorAll('[aria-sort]').length") == 1


def test_columns_sort_by_the_keyboard(browser, index):
    from selenium.webdriver.common.keys import Keys

    browser.open(index)
    heads(browser)["Least q"].send_keys(Keys.ENTER)
    assert cases(browser) == ["a-10", "b", "</script><b>", "a-2"]
    heads(browser)["Least q"].send_keys(Keys.SPACE)
    assert cases(browser) == ["</script><b>", "b", "a-10", "a-2"]


def test_a_message_is_as_wide_as_the_table(browser, index):
    browser.open(index)
    table, message = browser.js(
        "return ['table', '.message td'].map((name) => document.querySelector(name).getBoundingClientRect().width)"
    )
    assert message >= table - 2


def test_a_case_without_mesh_has_no_number_of_warnings():
    cells = [cell[2] for cell in Elements(index_page(ROWS[1:2])).named("td")]
    assert cells.count("0") == 0
    assert "0" in [cell[2] for cell in Elements(index_page([ROWS[2]])).named("td")]


def test_a_printed_index_has_heads_of_plain_text_and_no_hints(browser, index):
    browser.open(index, print_=True)
    assert browser.js("return getComputedStyle(document.querySelector('th button')).display") == "contents"
    assert not browser.find(".note.screen").is_displayed()
    sizes = browser.js("return ['td', '.message td'].map((e) => getComputedStyle(document.querySelector(e)).fontSize)")
    assert sizes[0] == sizes[1]


def test_a_printed_report_hides_no_part_of_its_tables(opened):
    opened.media(print_=True)
    overflows = "return [...document.querySelectorAll('.scroll')].map((part) => getComputedStyle(part).overflowX)"
    assert set(opened.js(overflows)) == {"visible"}


def test_the_index_fits_a_telephone_in_the_dark(browser, index):
    browser.open(index, width=390, height=844, dark=True)
    assert browser.js("return document.documentElement.scrollWidth") <= 390
    browser.js("document.querySelector('.scroll').scrollLeft = 300")
    browser.drawn()
    lefts = "return ['tbody th', '.message div', 'main .note'].map((e) => document.querySelector(e)"
    places = browser.js(f"{lefts}.getBoundingClientRect())")
    assert all(place["left"] >= 0 and place["right"] <= 390 for place in places)
    assert browser.complaints() == []
