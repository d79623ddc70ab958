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


HOUSES = "[[20, 20], [40, 20], [40, 40], [20, 40]]", "[[40.001, 20], [60, 20], [60, 40], [40.001, 40]]"


def holes_of(tmp_path, *corners):
    """A text of holes of one file, whose features are polygons."""
    rings = [json.loads(ring) for ring in corners]
    shapes = [{"type": "Polygon", "coordinates": [[*ring, ring[0]]]} for ring in rings]
    features = [{"type": "Feature", "properties": {"id": k}, "geometry": shape} for k, shape in enumerate(shapes)]
    (tmp_path / "a.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return f"{{file: {tmp_path}/a.geojson, label: b, KEYS}}"


class TestHoles:
    """Holes that overlap, touch, or leave a narrow gap."""

    def test_a_gap_is_closed_without_leaving_short_edges(self):
        holes = ", ".join(f"{{polygon: {ring}, label: b}}" for ring in HOUSES)
        found = domain(f"{{outer: {{rectangle: [0, 0, 100, 100]}}, holes: [{holes}], repair: {{gap: 0.05}}}}")
        assert (found.hole_count, found.polygon.area) == (1, 10000 - 800)
        assert [(change.what, round(change.area, 9)) for change in found.changes] == [
            ("gap between holes closed", -0.02)
        ]
        assert found.boundary.lengths.min() == pytest.approx(20)

    def test_the_gap_is_that_of_the_file_before_its_scale(self, tmp_path):
        text = "{outer: {rectangle: [0, 0, 1000, 1000]}, holes: [" + holes_of(tmp_path, *HOUSES) + "]}"
        for gap, count in ((0.0005, 2), (0.005, 1)):
            found = domain(text.replace("KEYS", f"scale: 10, repair: {{gap: {gap}}}"))
            assert found.hole_count == count

    @pytest.mark.parametrize("second", ["[[40, 20], [60, 20], [60, 40], [40, 40]]", "[[30, 30], [60, 30], [60, 50]]"])
    def test_holes_of_a_file_are_united(self, tmp_path, second):
        text = "{outer: {rectangle: [0, 0, 100, 100]}, holes: [" + holes_of(tmp_path, HOUSES[0], second) + "]}"
        with pytest.raises(BubblemeshError, match=r"into one hole; repair: true in domain\.holes\.0 mends it"):
            domain(text.replace(", KEYS", ""))
        found = domain(text.replace("KEYS", "repair: true"))
        assert found.hole_count == 1
        assert [change.what.endswith(" united") for change in found.changes] == [True]

    def test_the_hole_of_a_hole_is_meshed(self, tmp_path):
        corners = "[[10, 10], [50, 10], [50, 50], [10, 50]]", "[[20, 20], [40, 20], [40, 40], [20, 40]]"
        text = "{outer: {rectangle: [0, 0, 100, 100]}, holes: [" + holes_of(tmp_path, *corners) + "]}"
        for keys in ("smallest: 1", "repair: true"):
            found = domain(text.replace("KEYS", keys))
            assert (found.hole_count, found.piece_count, found.polygon.area) == (1, 2, 10000 - 1600 + 400)

    def test_houses_around_a_yard_leave_it(self):
        sides = "[10, 10, 50, 20]", "[10, 40.001, 50, 50]", "[10, 20.001, 20, 40]", "[40, 20.001, 50, 40]"
        holes = ", ".join(f"{{rectangle: {side}}}" for side in sides)
        found = domain(f"{{outer: {{rectangle: [0, 0, 100, 100]}}, holes: [{holes}], repair: {{gap: 0.01}}}}")
        assert (found.hole_count, found.piece_count) == (1, 2)
        assert found.polygon.area == pytest.approx(10000 - 1600 + 400, abs=0.05)

    def test_holes_of_one_area_are_joined(self, tmp_path):
        rings = "(0 0, 9 0, 9 9, 0 9, 0 0), (1 1, 4 1, 4 4, 1 4, 1 1), (4.001 2, 6 2, 6 3, 4.001 3, 4.001 2)"
        (tmp_path / "a.wkt").write_text(f"POLYGON ({rings})")
        assert domain(f"{{file: {tmp_path}/a.wkt, repair: {{gap: 0.01}}}}").hole_count == 1

    def test_join_of_polygons_is_told_to_do_nothing(self, tmp_path):
        text = "{outer: {rectangle: [0, 0, 100, 100]}, holes: [" + holes_of(tmp_path, *HOUSES) + "]}"
        (note,) = domain(text.replace("KEYS", "join: 0.05")).notes
        assert "join: 0.05 does nothing here" in note
        assert note.endswith("repair: {gap: 0.05} closes gaps between these")


def test_a_closed_gap_leaves_no_edges_as_short(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("0 0\n20 0\n20 20\n0 20\n\n20.001 0.0004\n40 0\n40 20\n20.001 20\n")
    found = domain(f"{{file: {path}, repair: {{gap: 0.05}}}}")
    assert found.boundary.lengths.min() > 19
    assert found.polygon.area == pytest.approx(800, abs=0.02)


def test_labels_beside_a_closed_gap_stay():
    corners = "[[0, 0], [2, 0], [2, 2], [0, 2]]", "[[2.001, 0], [4, 0], [4, 2], [2.001, 2]]"
    labels = "[a, b, c, d]", "[e, f, g, h]"
    rings = ", ".join(f"{{polygon: {ring}, labels: {names}}}" for ring, names in zip(corners, labels, strict=True))
    found = domain(f"{{outer: [{rings}], repair: {{gap: 0.01}}}}")
    boundary = found.boundary
    names = [boundary.labels[k] for k in boundary.label]
    assert dict(zip(names, boundary.lengths.tolist(), strict=True)) == pytest.approx(
        {"a": 2, "e": 2, "f": 2, "g": 2, "c": 2, "d": 2}, abs=0.002
    )


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


SQUARES = "MULTIPOLYGON (((0 0, 2 0, 2 1, 0 1, 0 0)), ((1 0.5, 3 0.5, 3 2, 1 2, 1 0.5)))"


def test_areas_of_one_region_that_overlap_are_united_by_a_repair_or_a_union(tmp_path):
    path = tmp_path / "a.wkt"
    path.write_text(SQUARES)
    text = "{outer: {rectangle: [-1, -1, 4, 4]}, regions: [{name: si, ring: RING}]}"
    told = (
        r"two areas of region 'si' overlap at .*: make them one by ring: \{union: \[\.\.\.\]\}, of their rings or "
        r"their file; repair: true in domain\.regions\.0\.ring mends it$"
    )
    with pytest.raises(BubblemeshError, match=told):
        domain(text.replace("RING", f"{{file: {path}}}"))
    for ring in (f"{{file: {path}, repair: true}}", f"{{union: [{{file: {path}}}]}}"):
        found = domain(text.replace("RING", ring))
        assert [(region.name, region.polygon.area) for region in found.parts.regions] == [("si", 4.5)]


def test_a_ring_within_another_one_of_a_region_is_no_hole_after_a_repair(tmp_path):
    path = tmp_path / "a.wkt"
    path.write_text("MULTIPOLYGON (((0 0, 3 0, 3 3, 0 3, 0 0)), ((1 1, 2 1, 2 2, 1 2, 1 1)))")
    text = f"{{outer: {{rectangle: [-1, -1, 4, 4]}}, regions: [{{name: si, ring: {{file: {path}, repair: true}}}}]}}"
    assert [region.polygon.area for region in domain(text).parts.regions] == [9]


def test_regions_of_different_names_that_overlap_name_minus():
    rings = "{name: pml, ring: {rectangle: [0, 0, 1, 4]}}", "{name: bus, ring: {rectangle: [0, 1, 4, 2]}}"
    with pytest.raises(
        BubblemeshError, match=r"'pml' and 'bus' overlap at .* by ring: \{minus: \[.*\]\}, or set overlaps: "
    ):
        domain(f"{{outer: {{rectangle: [0, 0, 4, 4]}}, regions: [{', '.join(rings)}]}}")
