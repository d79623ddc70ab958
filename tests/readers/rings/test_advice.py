"""Advice in messages on files: the key with the value that they name works."""

import re

import pytest
from geometry_files import domain
from shapely import affinity, from_wkt

from bubblemesh.case import load_case
from bubblemesh.errors import GeometryError
from bubblemesh.problem.domain import case_domain

GAPS = "LINESTRING (0 0, 4 0)\nLINESTRING (4 0.01, 4 3)\nLINESTRING (3.98 3, 0 3)\nLINESTRING (0 3, 0 0)"
BESIDE = "LINESTRING (1 1, 2 1)\nLINESTRING (0 0, 4 0, 4 3, 0 3, 0 0)\nLINESTRING (1 2, 2 2, 2 2.5, 1 2)"


def message(path, **keys):
    with pytest.raises(GeometryError) as error:
        domain(path, **keys)
    return str(error.value)


def test_gaps_name_the_join_that_closes_all_of_them(written):
    path = written("a.wkt", GAPS)
    text = message(path)
    assert "the widest gap to a next one is 0.02, at (4, 3), the nearest 0.01" in text
    join = float(re.search(r"set join: (\S+), which closes all gaps", text)[1])
    assert 0.02 < join < 0.025
    assert domain(path, join=join).polygon.area == pytest.approx(12, rel=0.01)


@pytest.mark.parametrize(
    ("keys", "part"),
    [
        ("file: a.wkt", True),
        ("file: a.wkt, part: 1", False),
        ("outer: {rectangle: [-1, -1, 9, 4]}, holes: [{file: a.wkt}]", False),
        ("outer: {rectangle: [-1, -1, 9, 4]}, regions: [{name: r, ring: {file: a.wkt}}]", False),
    ],
)
def test_a_part_is_named_only_where_one_has_to_be_chosen(written, keys, part):
    beside = affinity.translate(from_wkt(f"GEOMETRYCOLLECTION ({GAPS.replace('LINE', ', LINE')[2:]})"), 4.5)
    written("a.wkt", "\n".join([GAPS, *(line.wkt for line in beside.geoms)]))
    with pytest.raises(GeometryError) as error:
        case_domain(load_case(written("case.yaml", f"domain: {{{keys}}}\nspacing: 0.5\n")))
    more = " and part: largest" if part else ""
    assert re.search(rf"set join: \S+{more}, which closes all gaps", str(error.value))


@pytest.mark.parametrize("text", ["LINESTRING (0 0, 4 0, 4 3)", GAPS.replace("0 3, 0 0", "0 3, 0 1")])
def test_what_is_missing_is_no_gap_to_join(written, text):
    assert "draw what is missing" in message(written("a.wkt", text))
    assert "join" not in message(written("a.wkt", text))


def test_features_that_close_by_themselves_are_named_the_widest_first(written):
    path = written("a.wkt", BESIDE)
    text = message(path)
    assert re.search(r"what closes by itself: feature 1 .*, feature 2 .*: choose by feature: 1$", text)
    assert domain(path, feature=1).polygon.area == 12


def test_of_chosen_features_no_number_is_named(written):
    assert "closes by itself" not in message(written("a.wkt", BESIDE), feature=0)


def test_repair_keeps_all_pieces_of_what_was_one_area(written):
    written("a.wkt", "POLYGON ((0 0, 2 2, 2 0, 0 2, 0 0))")
    text = "domain: {{file: a.wkt{}}}\nspacing: 0.5\n"
    with pytest.raises(GeometryError, match=r"crosses or touches itself at \(1, 1\).*repair: true in domain mends it"):
        case_domain(load_case(written("case.yaml", text.format(""))))
    found = case_domain(load_case(written("case.yaml", text.format(", repair: true"))))
    assert (found.piece_count, found.polygon.area) == (2, 2)
    found = case_domain(load_case(written("case.yaml", text.format(", repair: true, part: 1"))))
    assert (found.piece_count, found.polygon.area) == (1, 1)


def test_lines_that_lie_on_each_other_leave_no_point_twice(written):
    lines = [(0, 0, 0.6, 0), (0.4, 0, 1, 0), (1, 0, 1, 0.7), (1, 0.7, 0, 0.7), (0, 0.7, 0, 0)]
    written("a.wkt", "\n".join(f"LINESTRING ({a} {b}, {c} {d})" for a, b, c, d in lines))
    found = case_domain(load_case(written("case.yaml", "domain: {file: a.wkt, repair: true}\nspacing: 0.1\n")))
    assert found.polygon.area == pytest.approx(0.7)
    assert len(found.boundary.corners) == 6


@pytest.mark.parametrize("x", [0.4, 0.8, -0.4])
def test_polygons_that_overlap_are_no_holes_of_each_other(written, x):
    corners = [(x, 0), (x + 2, 0), (x + 2, 1.9), (x, 1.9)]
    ring = ", ".join(f"{a} {b}" for a, b in [*corners, corners[0]])
    path = written("a.wkt", f"MULTIPOLYGON (((0 0, 2 0, 2 2, 0 2, 0 0)), (({ring})))")
    assert domain(path, part="largest").polygon.area == 4
    found = case_domain(load_case(written("case.yaml", "domain: {file: a.wkt, repair: true}\nspacing: 0.5\n")))
    assert found.polygon.area == pytest.approx(4 + 1.9 * abs(x))


def test_features_without_a_shape_are_no_regions_and_are_counted(written):
    square = '{"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [1, 1], [0, 0]]]}'
    features = [
        f'{{"type": "Feature", "properties": {{"n": "{n}"}}, "geometry": {g}}}'
        for n, g in (("a", square), ("b", "null"))
    ]
    written("a.geojson", f'{{"type": "FeatureCollection", "features": [{", ".join(features)}]}}')
    found = case_domain(load_case(written("case.yaml", "domain: {regions: {file: a.geojson, name: n}}\nspacing: 1\n")))
    assert [region.name for region in found.parts.regions] == ["a"]
    assert any("left out: 1 empty feature" in note for note in found.notes)


def drawn_in_layers(path, layers):
    import ezdxf

    document = ezdxf.new("R2018")
    for layer, loops in layers.items():
        for points in loops:
            document.modelspace().add_lwpolyline(points, close=len(points) > 2, dxfattribs={"layer": layer})
    document.saveas(path)
    return path


def box(x, y, size):
    return [(x, y), (x + size, y), (x + size, y + size), (x, y + size)]


def test_layers_that_bound_one_area_together_are_advised_first(tmp_path):
    layers = {
        "FRAME": [box(-10, -10, 50), [(20, -10), (20, -5)]],
        "BORES": [box(1, 1, 2), box(5, 5, 2)],
        "OUTLINE": [box(0, 0, 9)],
        "HATCHING": [[(0, 0), (1, 1)]],
    }
    path = drawn_in_layers(tmp_path / "a.dxf", layers)
    text = message(path)
    assert (
        "layers that close by themselves: BORES, OUTLINE: choose by layer: [BORES, OUTLINE]; or set open: skip" in text
    )
    assert "set open: skip and part: largest, which leaves out what forms no ring (4 rings stay)" in text
    assert domain(path, layers=("BORES", "OUTLINE")).polygon.area == pytest.approx(81 - 8)
    assert domain(path, open="skip", part="largest").polygon.area == pytest.approx(2500 - 81)


def test_a_layer_around_all_others_is_left_out_of_what_is_advised(tmp_path):
    layers = {"FRAME": [box(-10, -10, 50)], "BORES": [box(1, 1, 2), box(5, 5, 2)], "OUTLINE": [box(0, 0, 9)]}
    path = drawn_in_layers(tmp_path / "a.dxf", layers | {"AXES": [[(0, 0), (1, 1)]]})
    assert "FRAME, BORES, OUTLINE: choose by layer: [BORES, OUTLINE]" in message(path)


def test_names_of_layers_that_yaml_would_read_otherwise_are_quoted(tmp_path):
    path = drawn_in_layers(tmp_path / "a.dxf", {"1-cut #2": [box(0, 0, 9)], "AXES": [[(0, 0), (1, 1)]]})
    assert message(path).endswith('choose by layer: "1-cut #2"') or 'choose by layer: "1-cut #2"; or' in message(path)


def test_a_part_whose_rings_cross_is_advised_with_its_repair(written):
    bow = "((0 0, 6 6, 6 0, 0 5, 0 0))"
    path = written("a.wkt", f"MULTIPOLYGON ({bow}, ((10 0, 11 0, 11 1, 10 0)))")
    assert "choose by part: largest and repair: true, part: all and repair: true for" in message(path)
    written("a.wkt", f"MULTIPOLYGON (((20 0, 30 0, 30 9, 20 0)), {bow})")
    assert "choose by part: largest, part: all and repair: true for" in message(path)
    text = "domain: {file: a.wkt, part: all, repair: true}\nspacing: 1\n"
    assert case_domain(load_case(written("case.yaml", text))).piece_count == 3
