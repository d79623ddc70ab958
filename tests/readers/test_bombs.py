"""Small files that would take all time or memory: each is refused, or read, in seconds."""

import json
import signal

import pytest
from geometry_files import SVG, area

from bubblemesh.errors import BubblemeshError, CaseError, LimitError
from bubblemesh.readers.tables import read_columns

SECONDS = 5
MANY = 40_000


@pytest.fixture(autouse=True)
def _in_time():
    def end(number, frame):
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, end)
    signal.alarm(SECONDS)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.mark.parametrize("line", ["1" * MANY, "1" * MANY + "x", " " * MANY + "x", "1" + "0" * MANY + " 1", "1e" * MANY])
def test_long_lines_of_tables(written, line):
    for read in (area, lambda path: read_columns(path, ("x", "y", "d"))):
        with pytest.raises(CaseError, match=r"line \d"):
            read(written("a.csv", f"0 0 1\n{line}\n"))


LAUGHS = "".join(f'<!ENTITY a{k} "{f"&a{k - 1};" * 10}">' for k in range(1, 9))
LONG = "M0 0" + "L1 0L1 1" * 2000
DRAWINGS = {
    "entities within entities": (f'<!DOCTYPE svg [<!ENTITY a0 "a">{LAUGHS}]>', "&a8;", "entity 'a1' is not read"),
    "a long entity": (f'<!DOCTYPE svg [<!ENTITY a "{"a" * 2000}">]>', "&a;", "the entity 'a' is not read"),
    "a long path used often": (
        "", f'<defs><path id="a" d="{LONG}"/></defs>' + '<use href="#a"/>' * 5000, "in long ones"),
    "a style sheet without rules": ("", f"<style>{'a' * MANY}</style>", "it is not made of rules"),
    "an empty rule": ("", f"<style>{'a ' * MANY}{{}}</style>", "it is not made of rules"),
    "an open rule": ("", f"<style>a{{}} b{{{'x ' * MANY}</style>", "it is not made of rules"),
    "open comments": ("", f"<style>{'/*' * MANY}</style>", "a comment in it has no end"),
    "styles for all": ("", f"<style>.a{{{'x:y;' * MANY}}}</style>" + '<rect class="a"/>' * 2000, "sheet is too long"),
    "digits without an end": ("", f'<polygon points="{"1" * MANY}x"/>', "its points are no pairs of numbers"),
    "blanks behind a length": ("", f'<rect width="1{" " * MANY}x" height="1"/>', "width is no length"),
}  # fmt: skip


@pytest.mark.parametrize("name", DRAWINGS)
def test_drawings_that_grow(written, name):
    pytest.importorskip("svgelements")
    before, inside, message = DRAWINGS[name]
    with pytest.raises(BubblemeshError, match=message):
        area(written("a.svg", before + SVG.format(inside)))


def test_entities_of_drawing_programs_and_rules_are_read(written):
    pytest.importorskip("svgelements")
    before = '<!DOCTYPE svg [<!ENTITY ns "http://ns.adobe.com/x/">]>'
    style = "<style>/* of all */ .a{fill:none} @media print {.b{fill:red}} .empty{} </style>"
    assert area(written("a.svg", before + SVG.format(f'{style}<rect class="a" id="&ns;" width="2" height="3"/>'))) == 6


@pytest.mark.parametrize("size", ["0", "0%", "-3", "wide"])
def test_a_drawing_without_a_size(written, size):
    pytest.importorskip("svgelements")
    with pytest.raises(CaseError):
        area(
            written("a.svg", f'<svg xmlns="http://www.w3.org/2000/svg" width="{size}" viewBox="0 0 1 1"><rect/></svg>')
        )


@pytest.mark.parametrize("kind", ["lwpolyline", "hatch"])
def test_blocks_of_long_entities(tmp_path, monkeypatch, kind):
    ezdxf = pytest.importorskip("ezdxf")
    monkeypatch.setattr("bubblemesh.readers.dxf.MOST_COPIES", 3000)
    document = ezdxf.new()
    points = [(k % 7, k) for k in range(3000)]
    for level in range(6):
        block = document.blocks.new(f"B{level}")
        for k in range(5):
            if level:
                block.add_blockref(f"B{level - 1}", (k, 0))
            elif kind == "hatch":
                block.add_hatch().paths.add_polyline_path(points)
            else:
                getattr(block, f"add_{kind}")(points)
    document.modelspace().add_blockref("B5", (0, 0))
    document.saveas(tmp_path / "a.dxf")
    with pytest.raises(LimitError, match="its blocks draw more than 3,000 entities, or as much in long ones"):
        area(tmp_path / "a.dxf")


def test_nested_geometries(written):
    collections = "GEOMETRYCOLLECTION(" * 100_000
    with pytest.raises(CaseError, match="line 1: brackets are nested more than 20 deep"):
        area(written("a.wkt", collections + "POINT(0 0)" + ")" * 100_000))
    for text in ("[" * 100_000, '{"type":"GeometryCollection","geometries":[' * 500 + "]}" * 500):
        with pytest.raises(CaseError):
            area(written("a.geojson", text))
    with pytest.raises(CaseError, match="coordinates must be finite"):
        area(written("a.geojson", json.dumps({"type": "LineString", "coordinates": [[0, 0], [10**299, 10**200]]})))
