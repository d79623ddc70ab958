"""Rings and domains from the files of other programs, and what is said about faulty ones."""

import json

import numpy as np
import pytest

from bubblemesh.case import load_case
from bubblemesh.errors import CaseError, FileError, GeometryError
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.rings import Arc, Ellipse, Line, Spline
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.meshfiles.groups import group_names
from bubblemesh.problem.domain import case_domain
from bubblemesh.readers.formats import Selection, read_area, read_rings
from bubblemesh.run.pipeline import mesh_case

SQUARE = [[0, 0], [4, 0], [4, 4], [0, 4], [0, 0]]
HOLE = [[1, 1], [2, 1], [2, 2], [1, 2], [1, 1]]
PLATE = {"type": "Polygon", "coordinates": [SQUARE, HOLE]}
FAR = {"type": "Polygon", "coordinates": [[[10, 10], [12, 10], [12, 12], [10, 10]]]}
WKT = "POLYGON ((0 0, 4 0, 4 4, 0 4, 0 0), (1 1, 2 1, 2 2, 1 2, 1 1))"
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
SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="80mm" viewBox="0 0 40 40">{}</svg>'


def collection(*shapes, names=("plate", "far", "third")):
    features = [
        {"type": "Feature", "properties": {"name": name, "number": k}, "geometry": shape}
        for k, (shape, name) in enumerate(zip(shapes, names, strict=False))
    ]
    return json.dumps({"type": "FeatureCollection", "features": features})


@pytest.fixture
def written(tmp_path):
    def write(name, content):
        path = tmp_path / name
        path.write_text(content)
        return path

    return write


def domain(path, **options):
    outer, *holes = read_area(path, Selection(**options))
    return Domain.of(outer, holes)


def area(path, **options):
    return domain(path, **options).polygon.area


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


def test_duplicate_points_of_a_file_are_merged_with_a_note(written):
    (ring,) = read_rings(written("d.csv", "0 0\n1 0\n1 0\n0 1\n"), Selection())
    assert ring.notes == ("d.csv: duplicate point (1, 0) merged",)


def test_markers_of_triangle_become_labels(written):
    assert domain(written("plate.poly", POLY)).boundary.labels == ("5", "6", "outer", "9")


def test_vertices_of_triangle_may_be_in_a_file_of_their_own(written):
    lines = POLY.splitlines()
    written("plate.node", "\n".join(lines[1:10]))
    assert area(written("plate.poly", "\n".join(["0 2 0 1", *lines[10:]]))) == pytest.approx(15)


def labels_of(path, **options):
    """Labels of the outer ring and of the holes."""
    return [sorted({str(side.label) for side in ring.sides}) for ring in read_area(path, Selection(**options))]


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
    "null geometry": ("a.geojson", collection(PLATE, None), CaseError, r"feature 1 \(far\): no geometry"),
    "point": (
        "a.geojson",
        collection(PLATE, {"type": "Point", "coordinates": [1, 2]}),
        CaseError,
        r"feature 1 \(far\): a Point bounds no area",
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
        r"open ends: feature 0 \(line 1\) at \(0, 0\), .* at \(0.25, 0\): the next one is 0.25 away",
    ),
    "junction": (
        "a.wkt",
        "LINESTRING (0 0, 1 0)\nLINESTRING (1 0, 1 1, 0 0)\nLINESTRING (1 0, 2 1, 0 0)",
        GeometryError,
        r"3 ends meet at \(0, 0\)|3 ends meet at \(1, 0\)",
    ),
    "several areas": ("a.geojson", collection(PLATE, FAR), GeometryError, r"2 separate areas, .*choose one by feature"),
    "area in a hole": (
        "a.csv",
        "0 0\n9 0\n9 9\n0 9\n\n1 1\n8 1\n8 8\n1 8\n\n2 2\n7 2\n7 7\n",
        GeometryError,
        r"the ring at \(2, 2\) lies in a hole",
    ),
    "no hole point": (
        "a.poly",
        POLY.replace("1\n1 1.5 1.5", "0"),
        GeometryError,
        r"the ring at \(1, 1\) has no hole point",
    ),
    "hole point outside": (
        "a.poly",
        POLY.replace("1\n1 1.5 1.5", "2\n1 1.5 1.5\n2 9 9"),
        GeometryError,
        r"\(9, 9\) is out",
    ),
    "short poly": ("a.poly", "3 2 0 0\n1 0 0\n", CaseError, "end of the file: expected a vertex"),
    "nan poly": (
        "a.poly",
        "nan 2 0 0\n1 0 0\n",
        CaseError,
        "line 1: nan is no number of rows: expected the number of v",
    ),
    "half poly": ("a.poly", "2.5 2 0 0\n1 0 0\n", CaseError, "line 1: 2.5 is no number of rows"),
    "negative poly": (
        "a.poly",
        POLY.replace("1\n1 1.5 1.5", "-5"),
        CaseError,
        "line 20: -5 is no number of rows: expected the number of holes",
    ),
    "unknown vertex": ("a.poly", POLY.replace("5 5 6 9", "5 5 66 9"), CaseError, "line 16: there is no vertex 66"),
    "word in poly": ("a.poly", "x", CaseError, "line 1: not a row of numbers"),
    "latin": ("a.csv", "0 0\n\udce4", CaseError, None),
    "no file": ("missing.csv", None, FileError, "there is no such file"),
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


def test_an_area_with_holes_is_no_ring(written):
    with pytest.raises(GeometryError, match=r"1 holes is no ring: give it as domain: \{file: plate.wkt\}"):
        read_rings(written("plate.wkt", WKT), Selection())


@pytest.mark.parametrize(("name", "module"), [("a.dxf", "ezdxf"), ("a.svg", "svgelements"), ("a.gpkg", "pyogrio")])
def test_a_missing_extra_is_named(written, monkeypatch, name, module):
    import sys

    for loaded in [key for key in sys.modules if key.startswith(f"bubblemesh.readers.{READER[name]}")]:
        monkeypatch.delitem(sys.modules, loaded)
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(FileError, match=rf'{module} is needed .* pip install "bubblemesh\[{READER[name]}\]"'):
        domain(written(name, ""))


READER = {"a.dxf": "dxf", "a.svg": "svg", "a.gpkg": "gis"}


class TestDrawings:
    """DXF."""

    @pytest.fixture
    def drawn(self, tmp_path):
        ezdxf = pytest.importorskip("ezdxf")

        def save(draw, unit=0):
            document = ezdxf.new()
            document.header["$INSUNITS"] = unit
            draw(document)
            document.saveas(tmp_path / "a.dxf")
            return tmp_path / "a.dxf"

        return save

    def test_all_curves_are_read_as_curves_and_layers_become_labels(self, drawn):
        def draw(document):
            space = document.modelspace()
            space.add_lwpolyline(
                [(0, 0, 0), (10, 0, 1), (10, 6, 0), (0, 6, 0)], "xyb", close=True, dxfattribs={"layer": "RIM"}
            )
            space.add_circle((2, 2), 0.5, dxfattribs={"layer": "BORE"})
            space.add_ellipse((5, 3), (0, 1), 0.5)
            space.add_ellipse((8, 3), (1, 0), 0.5, 0, np.pi)
            space.add_line((9, 3), (7, 3))
            space.add_arc((4, 5), 0.3, 0, 180)
            space.add_arc((4, 5), 0.3, 180, 360)
            space.add_polyline2d([(3, 1, 0), (4, 1, 1), (4, 1.5, 0)], format="xyb").close()
            # As seen from below, x is turned round.
            space.add_arc((-7.5, 1), 0.3, 0, 180, dxfattribs={"extrusion": (0, 0, -1)})
            space.add_arc((7.5, 1), 0.3, 180, 360)

        outer, *holes = read_area(drawn(draw), Selection())
        assert [type(side.curve) for side in outer.sides] == [Line, Arc, Line, Line]
        assert {side.label for side in outer.sides} == {"RIM"}
        kinds = sorted("+".join(type(side.curve).__name__ for side in hole.sides) for hole in holes)
        assert kinds == ["Arc", "Arc", "Arc", "Ellipse", "Line+Arc+Line", "Spline+Line"]
        assert {side.label for hole in holes for side in hole.sides} == {"BORE", None}
        removed = np.pi * (0.25 + 0.5 + 0.25 + 0.09 + 0.09 + 1 / 32) + 0.25
        assert Domain.of(outer, holes).polygon.area == pytest.approx(60 + 4.5 * np.pi - removed, rel=1e-3)

    def test_an_ellipse_keeps_its_axes(self, drawn):
        path = drawn(lambda document: document.modelspace().add_ellipse((5, 3), (0, 2), 0.5))
        (ring,) = read_rings(path, Selection())
        assert isinstance(ring.sides[0].curve, Ellipse)
        assert domain(path).bounds == pytest.approx((4, 1, 6, 5), abs=1e-3)

    def test_splines_are_followed(self, drawn):
        turn = np.linspace(0, 2 * np.pi, 30)
        points = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])

        def draw(document):
            document.modelspace().add_spline(points[:20])
            document.modelspace().add_open_spline([points[19], (1.2, -1.2, 0), (1.2, -0.5, 0), points[0]])

        (ring,) = read_rings(drawn(draw), Selection())
        assert [type(side.curve) for side in ring.sides] == [Spline, Spline]
        radii = np.hypot(*ring.sides[0].curve.knots.T)
        np.testing.assert_allclose(radii, 1, atol=3e-3)

    def test_blocks_are_resolved(self, drawn):
        def draw(document):
            block = document.blocks.new("B")
            block.add_lwpolyline([(0, 0), (1, 0), (1, 1)], close=True)
            document.modelspace().add_blockref("B", (6, 1), dxfattribs={"xscale": 2, "rotation": 90})

        assert area(drawn(draw)) == pytest.approx(1)

    def test_gaps_are_joined_within_a_tolerance_only(self, drawn):
        def draw(document):
            space = document.modelspace()
            space.add_line((0, 0), (4, 0))
            space.add_arc((4, 2), 2, -90, 90)
            space.add_line((4, 4.01), (0, 4))
            space.add_line((0, 4), (0, 0))

        path = drawn(draw)
        with pytest.raises(GeometryError, match=r"open ends: ARC .* at \(4, 4\), LINE .* at \(4, 4.01\).* set join"):
            domain(path)
        plate = domain(path, join=0.1)
        assert plate.notes == ("a.dxf: 1 gaps joined, the widest (0.01) at (4, 4)",)
        assert plate.polygon.area == pytest.approx(16 + 2 * np.pi, rel=5e-3)

    def test_nothing_is_skipped_in_silence(self, drawn):
        def draw(document):
            space = document.modelspace()
            space.add_circle((0, 0), 1)
            space.add_text("A", dxfattribs={"insert": (3, 4), "layer": "NOTES"})
            space.add_circle((5, 5), 1, dxfattribs={"extrusion": (1, 0, 0)})

        notes = domain(drawn(draw)).notes
        assert "a.dxf: 1 TEXT not used, the first on layer NOTES at (3, 4)" in notes
        assert any("1 CIRCLE not used" in note for note in notes)

    def test_layers_are_chosen(self, drawn):
        def draw(document):
            for radius, layer in ((3, "A"), (2, "B"), (1, "C")):
                document.modelspace().add_circle((0, 0), radius, dxfattribs={"layer": layer})

        assert area(drawn(draw), layers=("A", "C")) == pytest.approx(8 * np.pi, rel=1e-3)
        with pytest.raises(CaseError, match="no layer 'D': allowed: A, B, C"):
            area(drawn(draw), layers=("D",))

    def test_a_unit_that_the_header_contradicts_is_noted(self, drawn):
        path = drawn(lambda document: document.modelspace().add_circle((0, 0), 1), unit=4)
        assert domain(path, unit="mm").notes == ()
        assert "its header gives lengths in mm, the case in in" in domain(path, unit="in").notes[0]

    def test_what_is_no_drawing_is_refused(self, written):
        pytest.importorskip("ezdxf")
        with pytest.raises((CaseError, FileError), match=r"a\.dxf: not a"):
            domain(written("a.dxf", "hello"))
        with pytest.raises(CaseError, match="there are no curves"):
            domain(written("a.dxf", "0\nSECTION\n2\nENTITIES\n0\nENDSEC\n0\nEOF\n"))


class TestPictures:
    """SVG."""

    @pytest.fixture(autouse=True)
    def needs(self):
        pytest.importorskip("svgelements")

    def test_y_is_turned_up_transforms_apply_and_lengths_are_the_numbers_of_the_file(self, written):
        path = written("a.svg", SVG.format('<g transform="translate(10 5)"><path d="M0 0 H8 V4 Z"/></g>'))
        (ring,) = read_rings(path, Selection())
        np.testing.assert_allclose(ring.vertices, [(10, -5), (18, -5), (18, -9)], atol=1e-12)

    def test_arcs_circles_and_curves(self, written):
        shapes = (
            '<path d="M0 0 H30 V30 A 10 10 0 0 1 20 40 H0 Z"/><circle cx="5" cy="5" r="2"/>'
            '<path d="M10 10 C 10 20 20 20 20 10 Z"/><path d="M25 20 A 3 1 0 0 1 25 25 Z"/>'
        )
        outer, *holes = read_area(written("a.svg", SVG.format(shapes)), Selection())
        assert [type(side.curve).__name__ for side in outer.sides] == ["Line", "Line", "Arc", "Line", "Line"]
        assert sorted(type(hole.sides[0].curve).__name__ for hole in holes) == ["Arc", "Spline", "Spline"]
        assert Domain.of(outer, []).polygon.area == pytest.approx(1200 - 100 + 25 * np.pi, rel=1e-4)

    def test_a_bezier_curve_is_followed(self, written):
        (ring,) = read_rings(written("a.svg", SVG.format('<path d="M0 0 C 0 20 20 20 20 0 Z"/>')), Selection())
        t = np.linspace(0, 1, 1001)[:, None]
        exact = 3 * t * (1 - t) ** 2 * [0, -20] + 3 * t**2 * (1 - t) * [20, -20] + t**3 * [20, 0]
        away = Domain.of(ring).nearest(exact).distance
        assert away.max() < 1e-4

    def test_names_of_elements_groups_and_layers_are_labels(self, written):
        text = """
          <g inkscape:groupmode="layer" inkscape:label="Umriß" id="layer1"><path id="path10" d="M0 0 H30 V30 H0 Z"/>
            <g id="g5"><path id="path12-3" inkscape:label="Bohrung" d="M1 1 H2 V2 Z"/></g>
            <circle id="vent" class="round" cx="5" cy="5" r="1"/>
            <g id="slots"><rect class="cls-1" x="10" y="10" width="3" height="2"/>
              <rect class="wide cls-1" x="15" y="10" width="3" height="2"/></g>
            <use id="pin" href="#proto" x="20" y="20"/>
          </g>
          <g inkscape:groupmode="layer" inkscape:label="Layer 2"><circle id="circle9" cx="25" cy="10" r="1"/></g>
          <defs><circle id="proto" r="1"/></defs>"""
        head = SVG.replace("<svg", '<svg xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"')
        path = written("a.svg", head.format(text))
        outer, *holes = read_area(path, Selection())
        assert {side.label for side in outer.sides} == {"Umriß"}
        found = [{side.label for side in hole.sides} for hole in holes]
        assert sorted(str(*labels) for labels in found) == ["Bohrung", "None", "pin", "slots", "vent", "wide"]
        assert area(path, layers=("slots",), feature={"label": "wide"}) == pytest.approx(6)
        assert area(path, feature={"id": "vent"}) == pytest.approx(np.pi, rel=1e-3)
        assert area(path, feature={"class": "wide cls-1"}) == pytest.approx(6)
        with pytest.raises(CaseError, match="no layer 'Umriss': did you mean 'Umriß'"):
            area(path, layers=("Umriss",))

    def test_sides_of_a_ring_may_be_paths_of_their_own(self, written):
        text = '<path id="inflow" d="M0 0 V10"/><path id="walls" d="M0 10 H20 M20 0 H0"/><path id="out" d="M20 10 V0"/>'
        found = domain(written("a.svg", SVG.format(text))).boundary
        sides = [(found.labels[k], length) for k, length in zip(found.label, found.lengths, strict=True)]
        assert sorted(sides) == [("inflow", 10), ("out", 10), ("walls", 20), ("walls", 20)]

    def test_what_is_hidden_is_noted(self, written):
        text = '<circle id="c" cx="5" cy="5" r="2"/><g style="display:none"><circle id="old" cx="5" cy="5" r="1"/></g>'
        plate = domain(written("a.svg", SVG.format(text)))
        assert plate.hole_count == 0
        assert plate.notes == ("a.svg: circle 'old' not used, since it is hidden",)

    @pytest.mark.parametrize("shape", ['<path id="a" d="M1 1"/>', '<path id="a" d="M1 1 L1 1"/>'])
    def test_what_has_no_extent_is_noted(self, written, shape):
        plate = domain(written("a.svg", SVG.format(shape + '<circle cx="5" cy="5" r="2"/>')))
        assert plate.notes == ("a.svg: path 'a' not used, since it has no extent",)

    def test_zero_is_not_negative(self, written):
        with pytest.raises(GeometryError, match=r"open ends: feature 0 \(path\) at \(0, 0\), "):
            domain(written("a.svg", SVG.format('<path d="M0 0 H4 V2"/>')))

    def test_what_bounds_nothing_is_noted(self, written):
        path = written("a.svg", SVG.format('<circle cx="5" cy="5" r="2"/><text id="t" x="1" y="2">A</text>'))
        assert domain(path).notes == ("a.svg: text 't' not used",)

    @pytest.mark.parametrize(
        ("content", "message"),
        [("", "no closed paths or shapes"), ("<path d='M0 0 L", "not valid XML"), ("<g>", "not valid XML")],
    )
    def test_faulty_pictures_are_refused(self, written, content, message):
        with pytest.raises(CaseError, match=message):
            domain(written("a.svg", SVG.format(content)))


class TestGeographicFiles:
    """Shapefiles and GeoPackages."""

    @pytest.fixture
    def saved(self, tmp_path):
        pyogrio = pytest.importorskip("pyogrio")
        import shapely

        def save(name, *shapes, layer="land", crs="EPSG:3857"):
            data = np.array([shapely.to_wkb(shapely.from_wkt(text)) for text in shapes], dtype=object)
            names = np.array([f"part {k}" for k in range(len(shapes))], dtype=object)
            driver = {".shp": "ESRI Shapefile", ".gpkg": "GPKG"}[name[name.rindex(".") :]]
            append = {"append": True} if (tmp_path / name).exists() else {}
            pyogrio.raw.write(
                tmp_path / name, geometry=data, field_data=[names], fields=["name"], geometry_type="Polygon",
                driver=driver, crs=crs, layer=layer if driver == "GPKG" else None, **append,
            )  # fmt: skip
            return tmp_path / name

        return save

    @pytest.mark.parametrize("name", ["a.shp", "a.gpkg"])
    def test_polygons_with_holes(self, saved, name):
        path = saved(name, WKT, "POLYGON ((10 10, 12 10, 12 12, 10 10))")
        assert labels_of(path, feature=0) == [["part 0"], ["None"]]
        assert area(path, feature=0) == pytest.approx(15)
        assert area(path, feature={"name": "part 1"}) == pytest.approx(2)

    def test_layers(self, saved):
        saved("a.gpkg", WKT, layer="land")
        path = saved("a.gpkg", "POLYGON ((0 0, 1 0, 1 1, 0 0))", layer="lake")
        assert area(path, layers=("lake",)) == pytest.approx(0.5)
        with pytest.raises(CaseError, match="2 layers: choose one by layer: land, lake"):
            domain(path)
        with pytest.raises(CaseError, match="no layer 'lakes': did you mean 'lake'"):
            domain(path, layers=("lakes",))

    def test_degrees_are_noted(self, saved):
        assert "coordinates are degrees" in domain(saved("a.gpkg", WKT, crs="EPSG:4326")).notes[0]

    def test_what_is_no_such_file_is_refused(self, written):
        pytest.importorskip("pyogrio")
        with pytest.raises(CaseError, match=r"a\.gpkg: not a valid GeoPackage"):
            domain(written("a.gpkg", "hello"))


class TestCases:
    """In a case file."""

    def case(self, written, text):
        return load_case(written("case.yaml", f"domain: {text}\nspacing: 0.5\n"))

    def test_a_domain_is_a_file_beside_the_case(self, written):
        written("plate.wkt", WKT)
        case = self.case(written, "{file: plate.wkt, label: rim, hole_label: bore, units: mm}")
        found = case_domain(case)
        assert found.boundary.labels == ("rim", "bore")
        assert found.polygon.area == pytest.approx(15e-6)

    def test_rings_are_files_and_an_entry_of_holes_may_be_several(self, written):
        written("hole.csv", "1 1\n2 1\n2 2\n\n3 3\n3.5 3\n3.5 3.5\n")
        case = self.case(written, "{outer: {rectangle: [0, 0, 4, 4]}, holes: [{file: hole.csv, label: bore}]}")
        found = case_domain(case)
        assert found.hole_count == 2
        assert found.boundary.labels == ("outer", "bore")

    def test_the_outer_ring_is_one(self, written):
        written("two.csv", "1 1\n2 1\n2 2\n\n3 3\n3.5 3\n3.5 3.5\n")
        case = self.case(written, "{outer: {file: two.csv}}")
        with pytest.raises(GeometryError, match="the outer ring: 2 rings are in the file: choose one"):
            case_domain(case)

    def test_errors_of_a_file_name_the_ring(self, written):
        case = self.case(written, "{outer: {rectangle: [0, 0, 4, 4]}, holes: [{file: a.csv}]}")
        with pytest.raises(FileError, match=r"hole 1: .*a\.csv: the file cannot be read: there is no such file"):
            case_domain(case)

    def test_labels_of_the_case_stand_above_those_of_the_file(self, written):
        written("plate.geojson", collection(PLATE, names=("plate",)))
        found = {"{file: plate.geojson}": ("plate", "hole-1")}
        found["{file: plate.geojson, label: rim, hole_label: bore}"] = ("rim", "bore")
        for text, labels in found.items():
            assert case_domain(self.case(written, text)).boundary.labels == labels

    def test_all_rings_of_a_file_are_one_region(self, written):
        written("fibres.csv", "0.5 0.5\n1.5 0.5\n1.5 1.5\n0.5 1.5\n\n2.5 2.5\n3.5 2.5\n3.5 3.5\n2.5 3.5\n")
        region = "{name: fibres, ring: {file: fibres.csv}, spacing: 0.2}"
        other = "{name: core, ring: {rectangle: [0.75, 0.75, 1.25, 1.25]}}"
        case = self.case(written, "{outer: {rectangle: [0, 0, 4, 4]}, regions: [" + f"{region}, {other}" + "]}")
        mesh = mesh_case(case).mesh
        assert (mesh.labels, mesh.regions) == (("outer", "fibres-rim", "core-rim"), ("domain", "fibres", "core"))
        areas = np.bincount(mesh.triangle_regions, signed_areas(mesh.points, mesh.triangles))
        np.testing.assert_allclose(areas, [14, 1.75, 0.25])
        lengths = np.hypot(*(mesh.points[mesh.facets[:, 1]] - mesh.points[mesh.facets[:, 0]]).T)
        assert lengths[mesh.facet_labels == 1].max() < 0.26
        assert lengths[mesh.facet_labels == 0].min() > 0.27

    def test_a_region_keeps_its_name_though_the_file_calls_its_ring_the_same(self, written):
        written("fibre.geojson", collection({"type": "Polygon", "coordinates": [HOLE]}, names=("fibre",)))
        region = "{name: fibre, ring: {file: fibre.geojson}}"
        case = self.case(written, "{outer: {rectangle: [0, 0, 4, 4]}, regions: [" + region + "]}")
        mesh = mesh_case(case).mesh
        assert (mesh.labels, mesh.regions) == (("outer", "fibre-rim"), ("domain", "fibre"))
        assert group_names(mesh)["fibre"] == (4, 2)

    def test_names_in_a_base_are_relative_to_the_base(self, written, tmp_path):
        (tmp_path / "sub").mkdir()
        written("plate.wkt", WKT)
        written("base.yaml", "domain: {file: plate.wkt}\nspacing: 0.5\n")
        case = load_case(written("sub/case.yaml", "base: ../base.yaml\n"))
        assert case_domain(case).polygon.area == pytest.approx(15)

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("{}", "domain: must be a mapping with exactly one of the keys outer, file"),
            ("{file: a.csv, feature: -1}", "domain.feature: must be a number from 0 on, or a property"),
            ("{file: a.csv, feature: {}}", "domain.feature: must be a number from 0 on, or a property"),
            ("{file: a.csv, units: parsec}", "domain.units: must be 'm', 'km'"),
            ("{file: a.csv, units: mm, scale: 2}", "domain.scale: and units exclude each other"),
            ("{file: a.csv, scale: 0}", "domain.scale: must be greater than 0"),
            ("{file: ''}", "domain.file: must not be empty"),
            ("{file: a.csv, fature: 1}", "domain.fature: unknown key; did you mean 'feature'"),
            ("{file: a.csv, smooth: true}", "domain.smooth: needs corners"),
            ("{outer: {file: a.csv, tolerance: 1}}", "domain.outer.tolerance: needs corners"),
            ("{file: a.csv, corners: 200}", "domain.corners: must be at most 180"),
        ],
    )
    def test_wrong_keys_are_refused(self, written, text, message):
        with pytest.raises(CaseError, match=message):
            self.case(written, text)
