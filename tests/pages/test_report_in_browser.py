"""The page of a run in a browser: what it shows, and how it answers."""

import dataclasses
import json
import re

import numpy as np
import pytest
from report_pages import NASTY, page_of

from bubblemesh.meshes.quality import radius_ratios
from bubblemesh.pictures.colouring import QUALITY, MeshData, colouring_of


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
    expected = (QUALITY(levels)[:, :3] * 255).round()
    assert np.abs(np.array(pixels(opened, centres)) - expected).max() <= 3
    choose(opened, "region")
    by_region = {}
    for t, color in zip(sample, pixels(opened, centres), strict=True):
        by_region.setdefault(int(mesh.triangle_regions[t]), set()).add(tuple(color))
    assert [len(colors) for colors in by_region.values()] == [1, 1]
    choose(opened, "size")
    size = colouring_of(mesh, MeshData(), "size")
    expected = (size.colormap(size.norm(size.values[sample]))[:, :3] * 255).round()
    assert np.abs(np.array(pixels(opened, centres)) - expected).max() <= 4
    choose(opened, "region")
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


def test_a_printed_report_hides_no_part_of_its_tables(opened):
    opened.media(print_=True)
    overflows = "return [...document.querySelectorAll('.scroll')].map((part) => getComputedStyle(part).overflowX)"
    assert set(opened.js(overflows)) == {"visible"}


@pytest.mark.long
def test_a_mesh_of_very_many_triangles_opens_scrolls_and_shows_its_edges_from_near(browser, result, tmp_path):
    """More than have their edges drawn at once."""
    from benchmarks.pages import page_of_square

    def image(edges):
        browser.js(
            "const box = document.querySelector('[data-part=edges]'); if (box.checked !== arguments[0]) box.click()",
            edges,
        )
        browser.drawn()
        return browser.js("return document.getElementById('mesh').toDataURL()")

    path = tmp_path / "large.html"
    path.write_text(page_of_square(200, result), encoding="utf-8")
    assert path.stat().st_size < 3e6
    browser.open(path)
    assert browser.js("return document.getElementById('colouring').value") == "size"
    assert not browser.js("return document.querySelector('[data-legend=size]').hidden")
    assert drawn(browser) + int(browser.find("#mesh").get_attribute("data-hidden")) == 80_000
    assert image(edges=True) == image(edges=False)
    for _ in range(5):
        wheel(browser, [400, 300], -500)
    assert 0 < drawn(browser) < 1000
    assert image(edges=True) != image(edges=False)
    browser.js("window.scrollTo(0, document.body.scrollHeight)")
    browser.drawn()
    assert browser.js("return window.scrollY") > 500
    assert browser.complaints() == []
