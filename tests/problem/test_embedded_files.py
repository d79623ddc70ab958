"""Lines and points of a domain from files of all kinds."""

import json

import numpy as np
import pytest

from bubblemesh.case import load_case
from bubblemesh.errors import CaseError, GeometryError
from bubblemesh.geometry.arrangement import clipping
from bubblemesh.geometry.label_distances import require_labels
from bubblemesh.problem.domain import case_domain
from bubblemesh.run.pipeline import mesh_case

SQUARE = "outer: {rectangle: [0, 0, 10, 10]}"


@pytest.fixture
def domain_of(tmp_path):
    def make(keys, **files):
        for name, content in files.items():
            (tmp_path / name.replace("_", ".")).write_text(content)
        (tmp_path / "case.yaml").write_text(f"domain: {{{keys}}}\nspacing: 2\n")
        return case_domain(load_case(tmp_path / "case.yaml"))

    return make


def lines_in(domain):
    return [(line.label, {side.label for side in line.sides}) for line in domain.parts.lines]


class TestLines:
    """`lines: [{file: ...}]`."""

    def test_a_layer_of_a_drawing(self, domain_of, tmp_path):
        ezdxf = pytest.importorskip("ezdxf")
        document = ezdxf.new()
        space = document.modelspace()
        space.add_line((1, 1), (4, 1), dxfattribs={"layer": "CRACK"})
        space.add_arc((5, 5), 2, 0, 90, dxfattribs={"layer": "CRACK"})
        space.add_circle((7, 3), 1, dxfattribs={"layer": "PIPE"})
        document.saveas(tmp_path / "a.dxf")
        found = domain_of(SQUARE + ", lines: [{file: a.dxf, layer: CRACK}, {file: a.dxf, layer: PIPE, label: tube}]")
        assert lines_in(found) == [("line-1", {"CRACK"}), ("line-2", {"CRACK"}), ("tube", {"tube"})]
        inner = found.boundary.inner
        assert found.boundary.lengths[inner].sum() == pytest.approx(3 + np.pi + 2 * np.pi, rel=1e-6)

    def test_tables_are_open_lines_in_the_cases_lengths(self, domain_of):
        found = domain_of(
            SQUARE + ", lines: [{file: a.csv, scale: 2, move: [1, 0]}]", a_csv="x,y\n1,1\n3,1\n\n2,2\n2,4\n"
        )
        assert [line.vertices for line in found.parts.lines] == [((3, 2), (7, 2)), ((5, 4), (5, 8))]

    def test_features_with_names(self, domain_of):
        road = {"type": "LineString", "coordinates": [[1, 1], [4, 4], [4, 4]]}
        place = {"type": "Point", "coordinates": [1, 1]}
        features = [{"type": "Feature", "properties": {"name": "A 1"}, "geometry": shape} for shape in (road, place)]
        content = json.dumps({"type": "FeatureCollection", "features": features})
        found = domain_of(SQUARE + ", lines: [{file: a.geojson}]", a_geojson=content)
        assert lines_in(found) == [("line-1", {"A 1"})]
        assert found.notes == (
            "a.geojson: 1 duplicate point dropped, the first at (4, 4)",
            "a.geojson: left out: 1 point",
        )

    def test_lines_outside_are_an_error_or_left_out(self, domain_of):
        wkt = "LINESTRING (1 1, 4 4)\nLINESTRING (8 8, 14 8)\nLINESTRING (20 20, 30 30)"
        with pytest.raises(GeometryError, match=r"the line 'line-3' \(a\.wkt: .*\) at .* lies outside the domain"):
            domain_of(SQUARE + ", lines: [{file: a.wkt}]", a_wkt=wkt)
        found = domain_of(SQUARE + ", lines: [{file: a.wkt, outside: skip}]")
        assert found.notes == ("1 line left out, outside of the domain",)
        assert found.boundary.lengths[found.boundary.inner].sum() == pytest.approx(3 * np.sqrt(2) + 2)

    def test_a_line_outside_is_looked_at_once_however_many_sides_it_has(self, domain_of, monkeypatch):
        looked_at, middles = [], clipping._middles
        monkeypatch.setattr(clipping, "_middles", lambda curves: looked_at.append(curves) or middles(curves))
        far = "LINESTRING (" + ", ".join(f"{20 + k} {20 + k % 2}" for k in range(50)) + ")"
        domain_of(SQUARE + ", lines: [{file: a.wkt, outside: skip}]", a_wkt=far)
        assert len(looked_at) == 1

    @pytest.mark.parametrize(("label", "told"), [("", "'edge'"), (", label: own", "'own'")])
    def test_an_error_names_the_feature(self, domain_of, label, told):
        shapes = {"road": [[1, 1], [4, 4]], "edge": [[12, 2], [13, 3]]}
        features = [
            {"type": "Feature", "properties": {"name": name}, "geometry": {"type": "LineString", "coordinates": shape}}
            for name, shape in shapes.items()
        ]
        content = json.dumps({"type": "FeatureCollection", "features": features})
        named = rf"the line {told} \(a\.geojson: feature 1 \(edge\)\) at \(12\.5, 2\.5\) lies outside the domain: move"
        with pytest.raises(GeometryError, match=named):
            domain_of(SQUARE + f", lines: [{{file: a.geojson{label}}}]", a_geojson=content)

    def test_a_file_without_lines(self, domain_of):
        with pytest.raises(CaseError, match=r"line 1: .*a\.wkt: there is no line in it \(but 1 point\)"):
            domain_of(SQUARE + ", lines: [{file: a.wkt}]", a_wkt="POINT (1 1)")

    @pytest.mark.parametrize("keys", ["{file: a.csv, repair: true}", "{file: a.csv, part: all}", "{label: a}"])
    def test_keys_of_rings_are_none_of_lines(self, domain_of, keys):
        with pytest.raises(CaseError, match=r"domain\.lines\.0"):
            domain_of(SQUARE + f", lines: [{keys}]", a_csv="0 0\n1 1\n")


WELLS = "ID,X,Y,depth\nW-1,1,1,20\nW-2,2.5,7,30\n,9,9,5\n"


class TestPoints:
    """`points: [{file: ..., name: ...}]`."""

    def test_a_table_with_names(self, domain_of):
        found = domain_of(SQUARE + ", points: [{at: [5, 5]}, {file: a.csv, name: id}]", a_csv=WELLS)
        names = [(point.label, point.at) for point in found.parts.points]
        assert names == [("point-1", (5, 5)), ("W-1", (1, 1)), ("W-2", (2.5, 7)), ("point-4", (9, 9))]

    @pytest.mark.parametrize(
        ("name", "content"),
        [
            ("a.txt", "1 1 100\n2.5 7 200\n9 9 300\n"),
            ("a.node", "# wells\n3 2 1 1\n0 1 1 5 1\n1 2.5 7 5 1\n2 9 9 5 0\n"),
            ("a.wkt", "POINT (1 1)\nMULTIPOINT ((2.5 7), (9 9))"),
            ("a.geojson", '{"type": "MultiPoint", "coordinates": [[1, 1], [2.5, 7, 3], [9, 9], [9, 9]]}'),
        ],
    )
    def test_points_of_all_kinds_of_files(self, domain_of, tmp_path, name, content):
        (tmp_path / name).write_text(content)
        found = domain_of(SQUARE + f", points: [{{file: {name}, label: well}}]")
        assert [point.at for point in found.parts.points] == [(1, 1), (2.5, 7), (9, 9)]
        assert {point.label for point in found.parts.points} == {"well"}

    def test_points_of_drawings_and_shapefiles(self, domain_of, tmp_path):
        ezdxf, pyogrio = pytest.importorskip("ezdxf"), pytest.importorskip("pyogrio")
        import shapely

        document = ezdxf.new()
        document.modelspace().add_point((1, 1), dxfattribs={"layer": "WELLS"})
        document.modelspace().add_circle((5, 5), 1)
        document.saveas(tmp_path / "a.dxf")
        shapes = np.array([shapely.to_wkb(shapely.Point(2, 3))], dtype=object)
        pyogrio.raw.write(
            tmp_path / "b.shp", geometry=shapes, field_data=[np.array(["P7"], dtype=object)], fields=["ID"],
            geometry_type="Point", driver="ESRI Shapefile", crs="EPSG:3857",
        )  # fmt: skip
        found = domain_of(SQUARE + ", points: [{file: a.dxf, name: layer}, {file: b.shp, name: ID}]")
        assert [(point.label, point.at) for point in found.parts.points] == [("WELLS", (1, 1)), ("P7", (2, 3))]

    def test_points_outside_are_counted_and_named(self, domain_of):
        text = WELLS.replace("2.5,7", "25,7").replace("9,9", "9,90")
        with pytest.raises(GeometryError, match=r"2 points lie outside the domain \('W-2' at \(25, 7\), 'point-3' at"):
            domain_of(SQUARE + ", points: [{file: a.csv, name: ID}]", a_csv=text)
        found = domain_of(SQUARE + ", points: [{file: a.csv, name: ID, outside: skip}]")
        assert [point.label for point in found.parts.points] == ["W-1"]
        assert found.notes[-1] == "2 points left out, outside of the domain: 'W-2' at (25, 7), 'point-3' at (9, 90)"
        assert "W-2" not in found.labels

    @pytest.mark.parametrize(
        ("label", "told"),
        [
            ("W-2", "'W-2' lies outside of the domain, at (25, 7), where outside: skip leaves it out"),
            ("point-3", "'point-3' lies outside of the domain, at (9, 90), where"),
            ("far", "'far' lies outside of the domain, at (16, 16), where"),
            ("W-3", "unknown label 'W-3'"),
        ],
    )
    def test_what_was_left_out_is_told_where_its_label_is_asked_for(self, domain_of, label, told):
        text = WELLS.replace("2.5,7", "25,7").replace("9,9", "9,90")
        line = "{path: [[12, 12], [20, 20]], label: far, outside: skip}"
        keys = f"{SQUARE}, points: [{{file: a.csv, name: ID, outside: skip}}], lines: [{line}]"
        found = domain_of(keys, a_csv=text)
        require_labels(found, ["W-1"])
        with pytest.raises(CaseError) as caught:
            require_labels(found, [label])
        assert str(caught.value).startswith(told)

    def test_a_property_that_is_not_there(self, domain_of):
        with pytest.raises(CaseError, match=r"a\.csv: no point has a 'IDs' for its name: did you mean 'ID'"):
            domain_of(SQUARE + ", points: [{file: a.csv, name: IDs}]", a_csv=WELLS)

    def test_a_drawing_in_svg_has_no_points(self, domain_of):
        pytest.importorskip("svgelements")
        svg = '<svg xmlns="http://www.w3.org/2000/svg"><circle r="1"/></svg>'
        with pytest.raises(CaseError, match="there is no point in it, as no drawing in SVG has"):
            domain_of(SQUARE + ", points: [{file: a.svg}]", a_svg=svg)

    @pytest.mark.long
    def test_points_and_lines_are_in_the_mesh(self, tmp_path):
        (tmp_path / "wells.csv").write_text(WELLS)
        (tmp_path / "cracks.wkt").write_text("LINESTRING (3 3, 6 5, 8 3)")
        inner = "points: [{file: wells.csv, name: ID}], lines: [{file: cracks.wkt, label: crack}]"
        (tmp_path / "case.yaml").write_text(f"domain: {{{SQUARE}, {inner}}}\nspacing: 1\n")
        mesh = mesh_case(load_case(tmp_path / "case.yaml")).mesh
        for at in ((1, 1), (2.5, 7), (9, 9), (6, 5)):
            assert np.hypot(*(mesh.points - at).T).min() == 0
        crack = mesh.facets[mesh.facet_labels == mesh.labels.index("crack")]
        length = np.hypot(*(mesh.points[crack[:, 1]] - mesh.points[crack[:, 0]]).T).sum()
        assert length == pytest.approx(np.hypot(3, 2) + np.hypot(2, 2))


POLY = """# two rooms, a crack in one, a pillar in the other; numbers from {first}
11 2 0 1
{vertices}
10 1
{segments}
1
{first} 7.7 2.3
2 # regions: attribute, largest area
{first} 1 1 7 0.1
1 9 9 3
"""
PLACES = [(0, 0), (5, 0), (10, 0), (10, 10), (5, 10), (0, 10), (1, 4), (4, 4), (7, 2), (8, 2), (8, 3)]
ENDS = [(0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (5, 0), (1, 4), (6, 7), (8, 9), (9, 10), (10, 8)]


@pytest.mark.parametrize("first", [0, 1])
def test_inner_segments_of_a_poly_file_are_lines_of_its_domain(domain_of, first):
    vertices = "\n".join(f"{k + first} {x} {y} 0" for k, (x, y) in enumerate(PLACES))
    segments = "\n".join(f"{k + first} {a + first} {b + first} {9 if k == 6 else 0}" for k, (a, b) in enumerate(ENDS))
    content = POLY.format(first=first, vertices=vertices, segments=segments).replace("\n10 1\n", f"\n{len(ENDS)} 1\n")
    found = domain_of("file: a.poly", a_poly=content)
    assert (found.polygon.area, found.hole_count) == (pytest.approx(99.5), 1)
    assert found.boundary.lengths[found.boundary.inner].sum() == pytest.approx(13)
    assert "9" in found.labels
    room = domain_of("file: a.poly, feature: {attribute: 7}")
    assert room.polygon.area == pytest.approx(50)


def test_inner_segments_of_a_poly_file_are_cut_at_its_domain_or_left_out_with_a_note(domain_of):
    square = "1 0 0\n2 4 0\n3 4 4\n4 0 4"
    content = f"9 2 0 0\n{square}\n5 3 3\n6 6 3\n7 6 2\n8 1 1\n9 2 1\n7 1\n1 1 2 1\n2 2 3 1\n3 3 4 1\n4 4 1 1\n"
    found = domain_of("file: a.poly", a_poly=content + "5 5 6 7\n6 6 7 8\n7 8 9 9\n0\n")
    assert found.boundary.lengths[found.boundary.inner].sum() == pytest.approx(1 + 1)
    assert found.labels == ("1", "7", "9")
    assert found.notes == (
        "a.poly: left out, outside of the domain: segment in line 17",
        "a.poly: cut off at the boundary, beyond which they go on: segment in line 16",
    )


# Vertices of a box and of segments in it; segments by their vertices; points of regions; areas of these.
BOX = [(0, 0), (4, 0), (4, 2), (0, 2)]
MEETING = {
    "on sides": ([(2, 0), (2, 2)], [(4, 5)], [(1, 1), (3, 1)], [4, 4]),
    "on slanted sides": ([(2, 1), (4 / 3, 0)], [(0, 2), (4, 5)], [(0.5, 0.1), (1.5, 0.1)], [2 / 3, 10 / 3]),
    "across each other": ([(2, 0), (2, 2), (0, 1), (4, 1)], [(4, 5), (6, 7)], [(1, 0.5), (3, 1.5)], [2, 2]),
    "beyond sides": ([(2, -1), (2, 3)], [(4, 5)], [(1, 1), (3, 1)], [4, 4]),
    "three in a point": (
        [(2, 0), (2, 2), (0, 1), (4, 1)],
        [(4, 5), (0, 2), (6, 7)],
        [(0.5, 0.5), (1.5, 0.5), (3, 0.8)],
        [1, 1, 2],
    ),
}


@pytest.mark.parametrize("name", MEETING)
def test_segments_of_a_poly_file_part_regions_wherever_they_meet(domain_of, name):
    vertices, segments, points, areas = MEETING[name]
    places = "\n".join(f"{k} {x} {y}" for k, (x, y) in enumerate([*BOX, *vertices]))
    rows = "\n".join(f"{k} {a} {b}" for k, (a, b) in enumerate([(0, 1), (1, 2), (2, 3), (3, 0), *segments]))
    seeds = "\n".join(f"{k} {x} {y} {k}" for k, (x, y) in enumerate(points))
    content = f"{4 + len(vertices)} 2\n{places}\n{4 + len(segments)} 0\n{rows}\n0\n{len(points)}\n{seeds}\n"
    found = domain_of("file: a.poly, regions: {file: a.poly, name: attribute}", a_poly=content)
    assert found.polygon.area == pytest.approx(8)
    regions = {region.name: region.polygon.area for region in found.parts.regions}
    assert regions == pytest.approx({str(k): area for k, area in enumerate(areas)})


def test_labels_of_points_in_the_place_of_others_are_told(tmp_path):
    (tmp_path / "wells.csv").write_text("ID,x,y\nW01,0.5,0.5\nW02,0.5,0.5\nW01,0.5,0.5\nW03,0.7,0.5\n")
    text = f"""
domain: {{outer: {{rectangle: [0, 0, 1, 1]}}, points: [{{file: {tmp_path}/wells.csv, name: ID}}]}}
spacing: 0.2
"""
    domain = case_domain(load_case(tmp_path / "case.yaml", text=text))
    assert domain.labels == ("outer", "W01", "W03")
    assert domain.notes[-1] == (
        "wells.csv: 1 label left out, of points in the place of others: 'W02' at (0.5, 0.5), where 'W01' is"
    )


def test_lines_that_run_along_each_other_are_told(tmp_path):
    text = """
domain:
  outer: {rectangle: [0, 0, 80, 60], label: rim}
  lines:
    - {path: [[10, 10], [50, 10]], label: A}
    - {path: [[30, 10], [70, 10]], label: B}
    - {path: [[60, 0], [75, 0], [75, 20]], label: C}
    - {path: [[20, 10], [20, 40]], label: A}
spacing: 9
"""
    domain = case_domain(load_case(tmp_path / "case.yaml", text=text))
    assert sorted(domain.notes) == [
        "the line 'B' runs along 'A' at (40, 10): that part of it has the label 'A' alone",
        "the line 'C' runs along 'rim' at (67.5, 0): that part of it has the label 'rim' alone",
    ]


class TestLinesDrawnOverAnOutline:
    """Loads and supports on layers of their own."""

    @pytest.fixture(autouse=True)
    def drawing(self, tmp_path):
        document = pytest.importorskip("ezdxf").new()
        space = document.modelspace()
        corners = [(0, 0), (9, 0), (9, 3), (0, 3)]
        for start, end in zip(corners, corners[1:] + corners[:1], strict=True):
            space.add_line(start, end, dxfattribs={"layer": "PART"})
        space.add_line((9, 3), (9, 0), dxfattribs={"layer": "LOAD"})
        for layer in ("PART", "BORE"):
            space.add_circle((4, 1.5), 1, dxfattribs={"layer": layer})
        document.saveas(tmp_path / "a.dxf")
        space.add_line((0, 1), (0, 2), dxfattribs={"layer": "FIXED"})
        document.saveas(tmp_path / "b.dxf")

    def test_labels_of_double_lines_are_told(self, domain_of):
        found = domain_of("file: a.dxf")
        assert found.labels == ("PART",)
        assert found.notes == (
            "a.dxf: 2 double lines dropped, the first at (9, 3), and with them 2 labels: 'LOAD', 'BORE'",
        )

    def test_labels_of_open_curves_are_told(self, domain_of):
        note, _ = domain_of("file: b.dxf, open: skip").notes
        assert note == "b.dxf: 1 open curve left out, at (0, 1), and with them 1 label: 'FIXED'"

    def test_as_lines_they_label_the_boundary(self, domain_of):
        found = domain_of("file: b.dxf, layer: PART, lines: [{file: b.dxf, layer: [LOAD, FIXED, BORE]}]")
        boundary = found.boundary
        sums = np.bincount(boundary.label, boundary.lengths, len(boundary.labels))
        lengths = dict(zip(boundary.labels, sums.tolist(), strict=True))
        assert lengths == pytest.approx({"PART": 20, "LOAD": 3, "FIXED": 1, "BORE": 2 * np.pi})
        assert found.notes == ()


def test_equal_rings_of_a_file_are_one_hole_after_a_repair(tmp_path):
    bow_tie, square = (
        [[10, 10], [20, 20], [20, 10], [10, 20], [10, 10]],
        [[50, 50], [60, 50], [60, 60], [50, 60], [50, 50]],
    )
    features = [
        {"type": "Feature", "id": 10 + k, "properties": {}, "geometry": {"type": "Polygon", "coordinates": [ring]}}
        for k, ring in enumerate([bow_tie, square, square])
    ]
    (tmp_path / "feat.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    text = f"""
domain:
  outer: {{rectangle: [0, 0, 100, 100]}}
  holes: [{{file: {tmp_path}/feat.geojson, label: b, repair: true}}]
spacing: 5
"""
    domain = case_domain(load_case(tmp_path / "case.yaml", text=text))
    assert domain.polygon.area == pytest.approx(100**2 - 50 - 100)  # two halves of the bow tie, and one square
