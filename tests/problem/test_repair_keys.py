"""The keys of a repair, what they tell, and messages that name the key where it helps."""

import json

import pytest

from bubblemesh.case import load_case, overrides_of
from bubblemesh.errors import BubblemeshError
from bubblemesh.problem.domain import case_domain
from bubblemesh.readers import point_lists
from bubblemesh.run.pipeline import mesh_case

BOW = "[[0, 0], [2, 2], [2, 0], [0, 2]]"


def case(text, **options):
    return load_case("a.yaml", text=f"domain: {text}\nspacing: 0.5\n", overrides=overrides_of(**options))


def domain(text, **options):
    return case_domain(case(text, **options))


@pytest.mark.parametrize(
    "text",
    [
        f"{{outer: {{polygon: {BOW}, repair: true}}}}",
        f"{{outer: {{polygon: {BOW}}}, repair: true}}",
        f"{{outer: {{polygon: {BOW}, repair: {{gap: 0.01}}}}}}",
    ],
)
def test_a_ring_is_mended_by_its_key_or_the_domains(text):
    found = domain(text)
    assert found.polygon.area == 2
    assert [change.at for change in found.changes] == [(1, 1)]


def test_the_option_repairs_the_domain():
    assert domain(f"{{outer: {{polygon: {BOW}}}}}", repair=True).polygon.area == 2


@pytest.mark.parametrize(
    ("text", "key"),
    [
        (f"{{outer: {{polygon: {BOW}}}}}", "domain.outer"),
        ("{outer: {rectangle: [0, 0, 4, 4]}, holes: [{rectangle: [3, 3, 5, 5]}]}", "domain"),
        (f"{{outer: {{rectangle: [-1, -1, 4, 4]}}, holes: [{{polygon: {BOW}}}]}}", "domain.holes.0"),
    ],
)
def test_messages_name_the_key_where_it_helps(text, key):
    with pytest.raises(BubblemeshError, match=f"; repair: true in {key} mends it$"):
        domain(text)


def test_messages_do_not_name_the_key_where_it_does_not_help():
    with pytest.raises(BubblemeshError) as error:
        domain("{outer: {rectangle: [0, 0, 4, 4]}, holes: [{rectangle: [-1, -1, 5, 5]}]}")
    assert "repair" not in str(error.value)


def test_a_file_is_mended_before_its_parts_are_chosen(tmp_path):
    squares = [[[0, 0], [2, 0], [2, 2], [0, 2], [0, 0]]], [[[1, 1], [3, 1], [3, 3], [1, 3], [1, 1]]]
    (tmp_path / "a.geojson").write_text(json.dumps({"type": "MultiPolygon", "coordinates": squares}))
    with pytest.raises(BubblemeshError, match="repair: true in domain"):
        domain(f"{{file: {tmp_path}/a.geojson}}")
    found = domain(f"{{file: {tmp_path}/a.geojson, repair: true, scale: 10}}")
    assert found.polygon.area == 700
    assert [(change.what, change.area) for change in found.changes] == [("areas that overlap united", -100)]


@pytest.fixture
def two_squares(tmp_path):
    """A file with a square and another part of its size, from some x on."""

    def write(x):
        path = tmp_path / "a.csv"
        path.write_text(f"0 0\n1 0\n1 1\n0 1\n\n{x} 0\n2 0\n2 1\n{x} 1\n")
        return path

    return write


@pytest.mark.parametrize("x", [1, 1.00015])  # with a common side, and with a gap below 1e-4 of both
def test_a_repair_that_makes_one_area_of_several_is_named(two_squares, x):
    path = two_squares(x)
    with pytest.raises(BubblemeshError, match=r"choose by part: .*; repair: true in domain mends it$"):
        domain(f"{{file: {path}}}")
    assert domain(f"{{file: {path}, repair: true}}").piece_count == 1


def test_a_file_with_areas_apart_is_read_once_to_be_refused(two_squares, monkeypatch):
    read, seen = point_lists.read_rings, []
    monkeypatch.setattr(point_lists, "read_rings", lambda path: seen.append(path) or read(path))
    path = two_squares(1.001)
    with pytest.raises(BubblemeshError, match="choose by part: largest") as error:
        domain(f"{{file: {path}}}")
    assert "repair" not in str(error.value)
    assert seen == [path]


def test_lines_that_cross_and_do_not_close_are_mended(tmp_path):
    lines = [[[-0.1, 0], [4.1, 0]], [[4, -0.1], [4, 4.1]], [[4, 4], [0, 4.0001]], [[0, 4.1], [0, -0.1]]]
    lines += [[[1, 1], [2, 1], [2, 2], [1, 2], [1, 1]]]
    (tmp_path / "a.geojson").write_text(json.dumps({"type": "MultiLineString", "coordinates": lines}))
    with pytest.raises(BubblemeshError, match="repair: true in domain"):
        domain(f"{{file: {tmp_path}/a.geojson}}")
    found = domain(f"{{file: {tmp_path}/a.geojson, repair: true}}")
    assert found.polygon.area == pytest.approx(15, abs=1e-3)
    assert found.hole_count == 1
    assert any("loose line" in change.what for change in found.changes)


def test_the_report_has_the_repairs():
    report = mesh_case(case(f"{{outer: {{polygon: {BOW}, repair: true}}}}")).report
    assert report["repairs"] == [{"what": "ring that crosses or touches itself", "at": [1, 1], "area": 2}]
    assert "repairs" not in mesh_case(case("{outer: {rectangle: [0, 0, 1, 1]}}")).report


def test_a_repair_with_nothing_to_mend_keeps_the_holes():
    text = "domain: {outer: {rectangle: [0, 0, 6, 6]}, holes: [{rectangle: [1, 1, 5, 5]}], repair: true}\nspacing: 1\n"
    found = case_domain(load_case("x.yaml", text=text))
    assert (found.polygon.area, found.hole_count, found.changes) == (20, 1, ())


@pytest.mark.parametrize("repair", ["", ", repair: true"])
@pytest.mark.parametrize("kind", ["polygon", "lines"])
def test_the_island_of_a_lake_that_is_a_hole_is_meshed(tmp_path, kind, repair):
    lake, island = "1 1, 5 1, 5 5, 1 5, 1 1", "2 2, 4 2, 4 4, 2 4, 2 2"
    shapes = {"polygon": f"POLYGON (({lake}), ({island}))", "lines": f"LINESTRING ({lake})\nLINESTRING ({island})"}
    path = tmp_path / "lake.wkt"
    path.write_text(shapes[kind])
    text = f"domain: {{outer: {{rectangle: [0, 0, 6, 6]}}, holes: [{{file: {path}}}]{repair}}}\nspacing: 1\n"
    found = case_domain(load_case("x.yaml", text=text))
    assert (found.polygon.area, found.piece_count, found.hole_count) == (24, 2, 1)
    found = case_domain(load_case("x.yaml", text=f"domain: {{outer: {{file: {path}}}}}\nspacing: 1\n"))
    assert (found.polygon.area, found.piece_count, found.hole_count) == (12, 1, 1)
