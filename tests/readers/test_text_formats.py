"""Rings and domains from the text files of other programs."""

import json

import numpy as np
import pytest
from geometry_files import HOLE, PLATE, SQUARE, SVG, WKT, area, collection, domain, labels_of, read_rings

from bubblemesh.errors import CaseError, FileError, GeometryError
from bubblemesh.readers.selection import Selection
from bubblemesh.readers.triangle import read_nodes

FAR = {"type": "Polygon", "coordinates": [[[10, 10], [12, 10], [12, 12], [10, 10]]]}


CSV = "x,y\n0,0\n4,0\n4,4\n0,4\n0,0\n\n1,1\n2,1\n2,2\n1,2\n"


POLY = """# a plate
8 2 0 1
1 0 0 1
2 4 0 1
3 4 4 1
4 0 4 1
5 1 1 2
6 2 1 2
7 2 2 2
8 1 2 2
8 1
1 1 2 5
2 2 3 6
3 3 4 6
4 4 1 0
5 5 6 9
6 6 7 9
7 7 8 9
8 8 5 9
1
1 1.5 1.5
"""


TEXTS = {
    "plate.geojson": json.dumps(PLATE),
    "one.json": collection(PLATE),
    "multi.geojson": json.dumps({"type": "MultiPolygon", "coordinates": [PLATE["coordinates"]]}),
    "lines.geojson": json.dumps(
        {"type": "MultiLineString", "coordinates": [SQUARE[:3], HOLE, list(reversed(SQUARE[2:]))]}
    ),
    "plate.wkt": WKT,
    "lines.wkt": "LINESTRING (0 0, 4 0, 4 4)\nLINESTRING (0 0, 0 4,\n 4 4)\n\nLINEARRING (1 1, 2 1, 2 2, 1 2, 1 1)",
    "z.wkt": WKT.replace("POLYGON", "POLYGON Z").replace(",", " 7,").replace("0))", "0 7))").replace("0)", "0)"),
    "rings.csv": CSV,
    "semicolons.txt": CSV.replace(",", "; "),
    "decimal-commas.csv": "0;0\n4,0;0\n4,0;4,0\n0;4e0\n\n1;1\n2,0; 1\n2;2,0\n1,0\t;2,0\n",
    "blanks.xy": CSV.replace("x,y", "# made by hand").replace(",", "\t "),
    "plate.poly": POLY,
}


TEXTS.pop("z.wkt")


@pytest.mark.parametrize("name", TEXTS)
def test_a_plate_with_a_hole_is_read_from_every_text_format(written, name):
    plate = domain(written(name, TEXTS[name]))
    assert plate.polygon.area == pytest.approx(15)
    assert plate.hole_count == 1


@pytest.mark.parametrize(("name", "text"), [("plate.geojson", json.dumps(FAR)), ("far.csv", "10 10\n12 10\n12 12\n")])
def test_a_file_of_one_ring_is_a_ring(written, name, text):
    (ring,) = read_rings(written(name, text), Selection())
    assert set(ring.vertices) == {(10, 10), (12, 10), (12, 12)}


def test_numbers_may_be_those_of_fortran(written):
    path = written("a.dat", "0.0D+00 0.0d0\n1.0D+01 0.0\n1.0D1 .2D+1\n")
    assert area(path) == pytest.approx(10)


@pytest.mark.parametrize("name", ["a.geojson.gz", "a.svgz", "a.zip"])
def test_a_packed_file_is_to_be_unpacked(written, name):
    with pytest.raises(FileError, match=f"is not read: unpack {name} first"):
        area(written(name, ""))


def test_lengths_are_scaled_or_turned_into_metres(written):
    path = written("plate.wkt", WKT)
    assert area(path, scale=10.0) == pytest.approx(1500)
    assert area(path, unit="mm") == pytest.approx(15e-6)


def test_curves_are_scaled_as_well(written):
    pytest.importorskip("svgelements")
    path = written("c.svg", SVG.format('<circle cx="1" cy="2" r="3"/><ellipse cx="1" cy="2" rx="2" ry="1"/>'))
    plate = domain(path, scale=2.0)
    assert plate.bounds == pytest.approx((-4, -10, 8, 2))
    assert plate.polygon.area == pytest.approx(np.pi * (36 - 8), rel=1e-3)


def test_a_feature_is_chosen_by_number_or_property(written):
    path = written("two.geojson", collection(PLATE, FAR))
    assert area(path, feature=0) == pytest.approx(15)
    assert area(path, feature=1) == pytest.approx(2)
    assert area(path, feature={"name": "far"}) == pytest.approx(2)
    assert area(path, feature={"number": 1}) == pytest.approx(2)


def test_header_lines_and_further_columns_of_a_list_are_left_out_with_a_note(written):
    (ring,) = read_rings(written("foil.dat", "NACA 0012\n1 0 5\n0 0.1 5\n0 -0.1 5\n"), Selection())
    assert len(ring.vertices) == 3
    assert ring.notes == ("foil.dat: columns after the second are not used",)


def test_duplicate_points_of_a_file_are_dropped_with_a_note(written):
    (ring,) = read_rings(written("d.csv", "0 0\n1 0\n1 0\n0 1\n"), Selection())
    assert ring.notes == ("d.csv: 1 duplicate point dropped, the first at (1, 0)",)


def test_markers_of_triangle_become_labels(written):
    assert domain(written("plate.poly", POLY)).boundary.labels == ("5", "6", "outer", "9")


def test_large_markers_are_labels_with_all_their_digits(written):
    text = POLY.replace(" 6\n", " 1000001\n").replace(" 9\n", " 1000002\n")
    assert domain(written("plate.poly", text)).boundary.labels == ("5", "1000001", "outer", "1000002")


@pytest.mark.parametrize("number", [10.1234567, 1000001.0])
def test_numbers_of_properties_are_labels_with_all_their_digits(written, number):
    feature = {"type": "Feature", "properties": {"name": number}, "geometry": FAR}
    assert domain(written("a.geojson", json.dumps(feature))).boundary.labels == (repr(number).removesuffix(".0"),)


@pytest.mark.parametrize(("head", "wrong"), [("3 2 nan 0", "nan"), ("3 inf 0 0", "inf")])
def test_a_head_of_nodes_that_is_no_count_is_told(written, head, wrong):
    with pytest.raises(CaseError, match=f"line 1: {wrong} is no count: expected the number of vertices"):
        read_nodes(written("a.node", f"{head}\n1 0 0\n2 1 0\n3 0 1\n"))


def test_vertices_of_triangle_may_be_in_a_file_of_their_own(written):
    lines = POLY.splitlines()
    written("plate.node", "\n".join(lines[1:10]))
    assert area(written("plate.poly", "\n".join(["0 2 0 1", *lines[10:]]))) == pytest.approx(15)


@pytest.mark.parametrize(
    ("properties", "labels"),
    [
        ({"name": "plate"}, [["plate"], ["None"]]),
        ({"name": "plate", "Label": "rim", "HOLE_LABEL": "bore"}, [["rim"], ["bore"]]),
        ({"NAME": " Côte d'Azur ", "label": None}, [["Côte d'Azur"], ["None"]]),
        ({"label": 3, "hole_label": 4.5}, [["3"], ["4.5"]]),
        ({"label": "", "name": True, "hole_label": ["a"], "title": "b"}, [["None"], ["None"]]),
    ],
)
def test_properties_of_a_polygon_are_labels(written, properties, labels):
    feature = {"type": "Feature", "properties": properties, "geometry": PLATE}
    assert labels_of(written("a.geojson", json.dumps(feature))) == labels


def test_lines_that_join_keep_their_labels(written):
    sides = {"south": SQUARE[:2], "east": SQUARE[1:3], "rest": SQUARE[2:]}
    shapes = [{"type": "LineString", "coordinates": points} for points in sides.values()]
    path = written("a.geojson", collection(*shapes, names=tuple(sides)))
    (ring,) = read_rings(path, Selection())
    assert sorted(side.label for side in ring.sides) == ["east", "rest", "rest", "south"]
    assert labels_of(path) == [["east", "rest", "south"]]


@pytest.mark.parametrize("name", ['a "wall"', "a\\wall", "a\nwall", "w" * 128, "ä" * 127])
def test_a_name_that_no_mesh_file_can_hold_is_no_label(written, name):
    path = written("a.geojson", collection(PLATE, names=(name,)))
    assert labels_of(path) == [["None"], ["None"]]
    (note,) = domain(path).notes
    shown = f" ({name})" if name.isprintable() and len(name) <= 80 else ""
    assert note.startswith(f"a.geojson: feature 0{shown}: {name[:40]!r} is no label, since it is too long or has")


def test_wkt_and_lists_of_points_have_no_labels(written):
    assert labels_of(written("plate.wkt", WKT)) == labels_of(written("plate.csv", CSV)) == [["None"], ["None"]]


FAULTS = {
    "not json": ("a.geojson", "{,}", CaseError, "line 1: not valid JSON"),
    "deep json": ("a.geojson", "[" * 100_000, CaseError, "nested too deep"),
    "no geojson": ("a.geojson", "[1]", CaseError, "feature 0: not a GeoJSON object|no geometry"),
    "no features": ("a.geojson", collection(), CaseError, "no features"),
    "null geometry": ("a.geojson", collection(None), CaseError, r"feature 0 \(plate\): it is empty.* choose another"),
    "point": (
        "a.geojson",
        collection({"type": "Point", "coordinates": [1, 2]}, None),
        CaseError,
        r"there is no ring in it \(but 1 point, 1 empty feature\): give closed curves",
    ),
    "curved wkt": (
        "a.wkt",
        "CIRCULARSTRING (0 0, 1 1, 2 0)",
        CaseError,
        r"feature 0 \(line 1\): its curves .* lines first",
    ),
    "cut wkb": ("a.wkb", "0103000000010000", CaseError, "feature 0: not a valid geometry"),
    "broken record": (
        "a.ndjson",
        '{"type": "Point", "coordinates": [1, 2]}\n{',
        CaseError,
        r"a\.ndjson: line 2: not valid JSON",
    ),
    "record with a key twice": (
        "a.geojsonl",
        '{"type": "Point", "coordinates": [1, 2]}\n\n{"type": 1, "type": 2}',
        CaseError,
        r"a\.geojsonl: line 3: the key 'type' is given twice in one object",
    ),
    "broken topology": (
        "a.topojson",
        '{"type": "Topology", "arcs": [], "objects": {"a": {"type": "Polygon", "arcs": [[0]]}}}',
        CaseError,
        r"not valid TopoJSON: something is missing or of a wrong kind in its objects or arcs: write it anew",
    ),
    "text coordinate": (
        "a.geojson",
        collection({"type": "Polygon", "coordinates": [[[0, 0], [1, "a"], [1, 1], [0, 0]]]}),
        CaseError,
        r"feature 0 \(plate\): no pair of numbers at coordinates\[0, 1\]: give \[x, y\] there \(found \[1, 'a'\]\)",
    ),
    "nan": (
        "a.geojson",
        '{"type": "Polygon", "coordinates": [[[0, 0], [1, NaN], [1, 1], [0, 0]]]}',
        CaseError,
        r"feature 0: point 2 at \(1, nan\): coordinates must be finite",
    ),
    "infinite": ("a.csv", "0 0\n1 inf\n1 1\n", CaseError, r"line 1\): point 2 at \(1, inf\): .* must be finite"),
    "huge": ("a.csv", "0 0\n1 1e71\n1 1\n", CaseError, "must be finite and at most 1e"),
    "nan in wkt": ("a.wkt", "POLYGON ((0 0, nan 1, 1 1, 0 0))", CaseError, "must be finite"),
    "bad wkt": ("a.wkt", "\nPOLYGON ((0 0, 1, 1 1, 0 0))", CaseError, r"feature 0 \(line 2\): not valid WKT"),
    "empty wkt": ("a.wkt", "POLYGON EMPTY", CaseError, "it is empty"),
    "empty file": ("a.wkt", "\n", CaseError, "there is no geometry"),
    "empty list": ("a.csv", "x,y\n", CaseError, "there are no points"),
    "word in a list": ("a.csv", "0 0\n1 0\nhello 3\n", CaseError, "line 3: not a point: 'hello 3'"),
    "one number": ("a.csv", "0 0\n1\n", CaseError, "line 2: one number alone"),
    "two points": ("a.csv", "0 0\n1 1\n", GeometryError, r"ring 0 \(line 1\): .*at least three"),
    "repeated points": ("a.wkt", "POLYGON ((0 0, 1 1, 0 0, 0 0))", GeometryError, "feature 0.*at least three"),
    "open line": (
        "a.wkt",
        "LINESTRING (0 0, 1 0, 1 1, 0.25 0)",
        GeometryError,
        r"open ends: feature 0 \(line 1\) at \(0, 0\), .*; the widest gap to a next one is 0.25, at \(0, 0\): draw",
    ),
    "junction": (
        "a.wkt",
        "LINESTRING (0 0, 1 0)\nLINESTRING (1 0, 1 1, 0 0)\nLINESTRING (1 0, 2 1, 0 0)",
        GeometryError,
        r"3 ends meet at \(0, 0\)|3 ends meet at \(1, 0\)",
    ),
    "several areas": (
        "a.geojson",
        collection(PLATE, FAR),
        GeometryError,
        r"2 separate areas .* part: largest, .* 0: area 15 at \(0, 0\), feature 0 \(plate\); 1: area .*, feature 1",
    ),
    "area in a hole": (
        "a.csv",
        "0 0\n9 0\n9 9\n0 9\n\n1 1\n8 1\n8 8\n1 8\n\n2 2\n7 2\n7 7\n",
        GeometryError,
        r"2 separate areas .* 0: area 32 at \(0, 0\), ring 0 .*; 1: area 12.5 at \(2, 2\), ring 2",
    ),
    "hole point outside": (
        "a.poly",
        POLY.replace("1\n1 1.5 1.5", "2\n1 1.5 1.5\n2 9 9"),
        GeometryError,
        r"\(9, 9\) is out",
    ),
    "no segments": ("a.poly", "3 2 0 0\n1 0 0\n2 4 0\n3 0 4\n0 0\n0\n", CaseError, "it has no segments: give those"),
    "short poly": ("a.poly", "3 2 0 0\n1 0 0\n", CaseError, "end of the file: expected a vertex"),
    "nan poly": (
        "a.poly",
        "nan 2 0 0\n1 0 0\n",
        CaseError,
        "line 1: nan is no count: expected the number of v",
    ),
    "half poly": ("a.poly", "2.5 2 0 0\n1 0 0\n", CaseError, "line 1: 2.5 is no count"),
    "negative poly": (
        "a.poly",
        POLY.replace("1\n1 1.5 1.5", "-5"),
        CaseError,
        "line 20: -5 is no count: expected the number of holes",
    ),
    "unknown vertex": ("a.poly", POLY.replace("5 5 6 9", "5 5 66 9"), CaseError, "line 16: there is no vertex 66"),
    "word in poly": ("a.poly", "x", CaseError, "line 1: not a row of numbers"),
    "latin": ("a.csv", "0 0\n\udce4", CaseError, None),
    "no file": ("missing.csv", None, FileError, "No such file"),
    "unknown ending": ("a.step", "", FileError, r"must end in .geojson, .*\.gpkg"),
}


FAULTS.pop("latin")


@pytest.mark.parametrize(("name", "text", "kind", "message"), FAULTS.values(), ids=FAULTS)
def test_a_faulty_file_is_refused_with_its_name_and_the_place(written, tmp_path, name, text, kind, message):
    path = tmp_path / name if text is None else written(name, text)
    with pytest.raises(kind, match=message) as caught:
        domain(path)
    assert str(caught.value).startswith(f"{path}: ")


def test_bytes_that_are_no_text_are_refused_with_the_line(tmp_path):
    path = tmp_path / "a.csv"
    path.write_bytes(b"0 0\n1 0\n\xe4")
    with pytest.raises(CaseError, match="line 3: not UTF-8"):
        domain(path)


def test_a_folder_is_no_file(tmp_path):
    (tmp_path / "a.csv").mkdir()
    with pytest.raises(FileError, match="it is a folder"):
        domain(tmp_path / "a.csv")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"feature": 2}, "no feature 2: give a number from 0 to 1"),
        ({"feature": {"nmae": "far"}}, "property 'nmae': did you mean 'name'"),
        ({"feature": {"name": "fra"}}, "no feature has name: fra: did you mean 'far'"),
        ({"layers": ("land",)}, "no layer 'land': it has no layers"),
    ],
)
def test_a_choice_that_fits_nothing_says_what_there_is(written, options, message):
    with pytest.raises(CaseError, match=message):
        area(written("two.geojson", collection(PLATE, FAR)), **options)


@pytest.mark.parametrize(("name", "module"), [("a.dxf", "ezdxf"), ("a.svg", "svgelements"), ("a.gpkg", "pyogrio")])
def test_a_missing_extra_is_named(written, monkeypatch, name, module):
    import sys

    for loaded in [key for key in sys.modules if key.startswith(f"bubblemesh.readers.{READER[name]}")]:
        monkeypatch.delitem(sys.modules, loaded)
    for loaded in [module, *(key for key in sys.modules if key.startswith(f"{module}."))]:
        monkeypatch.setitem(sys.modules, loaded, None)
    with pytest.raises(FileError, match=rf'{module} is needed .* pip install "bubblemesh\[{READER[name]}\]"'):
        domain(written(name, ""))


READER = {"a.dxf": "dxf", "a.svg": "svg", "a.gpkg": "gis"}
