"""The page that compares the cases of a batch."""

import re

import pytest
from report_pages import Elements

from bubblemesh.pages.index import index_page

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
    assert "packing.<wbr>w2" in text
    assert len(elements.named("svg", **{"class": "range"})) == 3
    assert len(elements.named("script")) == 1
    assert not re.findall(r"https?:", text)


def test_an_index_of_nothing_and_of_failures_only():
    assert "no cases" in index_page([])
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


def test_the_index_fits_a_telephone_in_the_dark(browser, index):
    browser.open(index, width=390, height=844, dark=True)
    assert browser.js("return document.documentElement.scrollWidth") <= 390
    browser.js("document.querySelector('.scroll').scrollLeft = 300")
    browser.drawn()
    lefts = "return ['tbody th', '.message div', 'main .note'].map((e) => document.querySelector(e)"
    places = browser.js(f"{lefts}.getBoundingClientRect())")
    assert all(place["left"] >= 0 and place["right"] <= 390 for place in places)
    assert browser.complaints() == []


def test_words_and_keys_stay_whole_in_1200_pixels(browser, tmp_path):
    row = ROWS[2] | {"sweep": {"parameters.h": 0.1, "packing.seed": 12}}
    (tmp_path / "index.html").write_text(index_page([row]))
    browser.open(tmp_path / "index.html", width=1200)
    line = 22  # pixels
    assert browser.js("return document.querySelector('td.text').clientHeight") <= 2 * line + 8
    heights = browser.js("return [...document.querySelectorAll('thead button')].map((head) => head.offsetHeight)")
    assert max(heights[2:4]) <= 2 * line  # after the dots of keys
    assert browser.js("const all = document.querySelector('.scroll'); return all.scrollWidth <= all.clientWidth")


def test_three_swept_keys_fit_into_1280_pixels(browser, tmp_path):
    sweep = {"parameters.radius": 0.1, "packing.effort": "best", "packing.seed": 12}
    figures = {"quality_mean": 0.98541, "quality_p01": 0.9221, "quality_min": 0.906, "nodes": 1_234_567}
    figures |= {"triangles": 2_345_678, "spacing_std": 0.0742, "seconds": 125.0, "warnings": 12}
    row = {"case": "plate-with-a-long-name-r=0.1-effort=best-seed=12", "exit_code": 0, "sweep": sweep, **figures}
    (tmp_path / "index.html").write_text(index_page([row] * 3))
    browser.open(tmp_path / "index.html", width=1280)
    scroll = "document.querySelector('.scroll')"
    assert browser.js(f"return {scroll}.scrollWidth <= {scroll}.clientWidth")
    assert "xa0" not in browser.js("return document.body.innerText")


@pytest.mark.parametrize("width", [390, 1280])
def test_long_names_keys_and_messages_fit_and_controls_are_large_enough(browser, width, tmp_path):
    long = {
        "nodes": 123_456,
        "triangles": 245_678,
        "seconds": 3675.5,
        "sweep": {"domain.holes.0.circle.radius": 0.1 * 3},
    }
    rows = [{**ROWS[0], **long, "case": f"a-very-long-name-for-a-plate-radius={n}-spacing=0.{n}"} for n in range(30)]
    rows += [{"case": "bad" * 20, "exit_code": 3, "message": "cases/" + "x" * 300 + ": domain: nothing"}]
    (tmp_path / "index.html").write_text(index_page(rows), encoding="utf-8")
    browser.open(tmp_path / "index.html", width=width)
    assert browser.js("return document.documentElement.scrollWidth") <= width
    if width == 1280:
        assert browser.js("const all = document.querySelector('.scroll'); return all.scrollWidth <= all.clientWidth")
    assert browser.js("return document.querySelector('tbody th').getBoundingClientRect().width") < 0.5 * width
    boxes = browser.js("return [...document.querySelectorAll('a, button')].map((each) => each.getBoundingClientRect())")
    assert min(min(box["width"], box["height"]) for box in boxes) >= 24
