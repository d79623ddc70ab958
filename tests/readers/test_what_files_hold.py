"""What real files hold beside one clean polygon: left out with a count, or put right with a count."""

import json

import pytest
import shapely
from geometry_files import HOLE, PLATE, SQUARE, WKT, area, collection, domain, labels_of, read_rings

from bubblemesh.errors import CaseError, GeometryError, LimitError
from bubblemesh.readers.formats import read_areas
from bubblemesh.readers.lines_and_points import read_lines
from bubblemesh.readers.selection import Selection

POINT = {"type": "Point", "coordinates": [9, 9, 3]}
ROAD = {"type": "LineString", "coordinates": [[0, 0], [9, 9], [12, 3]]}


def notes_of(path, **options):
    return [note.partition(": ")[2] for note in domain(path, **options).notes]


class TestBesidePolygons:
    """What bounds nothing, or is not there."""

    def test_points_lines_and_empty_features_are_counted_in_one_note(self, written):
        empty = {"type": "MultiPolygon", "coordinates": []}
        both = {"type": "GeometryCollection", "geometries": [PLATE, POINT, ROAD]}
        names = ("a", "b", "c", "d", "e")
        path = written("a.geojson", collection(both, None, ROAD, empty, POINT, names=names))
        assert area(path) == pytest.approx(15)
        assert notes_of(path) == ["heights (z) are not used", "left out: 2 lines, 2 points, 2 empty features"]

    def test_numbers_of_features_count_the_empty_ones(self, written):
        path = written("a.geojson", collection(None, PLATE))
        assert area(path, feature=1) == pytest.approx(15)
        with pytest.raises(CaseError, match=r"feature 0 \(plate\): it is empty"):
            domain(path, feature=0)

    def test_lines_still_join_where_there_is_no_polygon(self, written):
        shapes = [{"type": "LineString", "coordinates": SQUARE[:3]}, {"type": "LineString", "coordinates": SQUARE[2:]}]
        path = written("a.geojson", collection(*shapes, POINT))
        assert area(path) == pytest.approx(16)
        assert notes_of(path) == ["heights (z) are not used", "left out: 1 point"]

    def test_wkt_of_many_kinds(self, written):
        path = written(
            "a.wkt",
            f"POLYGON EMPTY\nSRID=25832;{WKT}\nPOINT M (1 2 3)\nMULTIPOINT EMPTY; GEOMETRYCOLLECTION (POINT (1 1), "
            "LINESTRING ZM (0 0 1 1, 9 9 1 1))",
        )
        assert area(path) == pytest.approx(15)
        assert notes_of(path) == ["heights (z) are not used", "left out: 1 line, 2 points, 2 empty features"]

    @pytest.mark.parametrize("form", ["binary", "hex"])
    def test_wkb(self, tmp_path, form):
        shape = shapely.set_srid(shapely.from_wkt(WKT), 25832)
        blob = shapely.to_wkb(shape, include_srid=True)
        path = tmp_path / "a.wkb"
        path.write_bytes(blob if form == "binary" else blob.hex().upper().encode() + b"\n")
        assert area(path) == pytest.approx(15)

    @pytest.mark.parametrize("order", [0, 1])
    @pytest.mark.parametrize("flavor", ["extended", "iso"])
    @pytest.mark.parametrize("form", ["binary", "hex"])
    def test_wkb_of_several_geometries(self, tmp_path, form, flavor, order):
        texts = [
            "POLYGON ((0 0, 4 0, 4 4, 0 4, 0 0), (1 1, 2 1, 2 2, 1 2, 1 1))",
            "POINT Z (1 2 3)",
            "MULTIPOINT ((1 2), (3 4))",
            "LINESTRING M (0 0 1, 9 9 2)",
            "POLYGON EMPTY",
            "GEOMETRYCOLLECTION ZM (POINT ZM (1 1 2 3), LINESTRING ZM (0 0 1 1, 9 9 1 1))",
            "MULTIPOLYGON Z (((5 0 1, 8 0 1, 8 1 1, 5 1 1, 5 0 1)), ((9 0 1, 9 2 1, 10 2 1, 10 0 1, 9 0 1)))",
        ]
        with_systems = flavor == "extended"
        blobs = [
            shapely.to_wkb(
                shapely.set_srid(shapely.from_wkt(text), 25832 * with_systems),
                output_dimension=4,
                byte_order=order,
                flavor=flavor,
                include_srid=with_systems,
            )
            for text in texts
        ]
        path = tmp_path / "a.wkb"
        path.write_bytes(b"".join(blobs) if form == "binary" else b"\n".join(blob.hex().encode() for blob in blobs))
        assert area(path, part="all") == pytest.approx(15 + 3 + 2)
        assert notes_of(path, part="all") == [
            "heights (z) are not used",
            "left out: 2 lines, 4 points, 1 empty feature",
        ]
        path.write_bytes(b"".join(blobs)[:-3])
        with pytest.raises(CaseError, match="feature 6: not a valid geometry"):
            area(path, part="all")

    @pytest.mark.parametrize(("name", "mark"), [("a.geojsonl", ""), ("a.ndjson", "\x1e")])
    def test_an_object_in_each_line(self, written, name, mark):
        features = json.loads(collection(PLATE, POINT))["features"]
        path = written(name, "\n".join(mark + json.dumps(feature) for feature in features) + "\n\n")
        assert area(path, feature={"name": "plate"}) == pytest.approx(15)

    def test_shapefiles_with_null_geometries(self, tmp_path):
        pyogrio = pytest.importorskip("pyogrio")
        import numpy as np

        shapes = np.array([None, shapely.to_wkb(shapely.from_wkt(WKT))], dtype=object)
        for name, driver in (("a.shp", "ESRI Shapefile"), ("a.gpkg", "GPKG")):
            pyogrio.raw.write(
                tmp_path / name, geometry=shapes, field_data=[np.array(["x", "y"], dtype=object)], fields=["name"],
                geometry_type="Polygon", driver=driver, crs="EPSG:3857",
            )  # fmt: skip
            assert notes_of(tmp_path / name) == ["left out: 1 empty feature"]
            assert area(tmp_path / name, feature=1) == pytest.approx(15)


class TestTopologies:
    """TopoJSON."""

    def topology(self, **more):
        # Two squares with a common side, as steps on a grid of halves.
        arcs = [[[2, 0], [0, 2]], [[2, 2], [-2, 0], [0, -2], [2, 0]], [[2, 2], [2, 0], [0, -2], [-2, 0]]]
        squares = [
            {"type": "Polygon", "arcs": [[0, 1]], "properties": {"name": "west"}},
            {"type": "MultiPolygon", "arcs": [[[2, 0]]], "id": 7, "properties": {"name": "east"}},
            {"type": None, "properties": {}},
            {"type": "Point", "coordinates": [4, 4]},
        ]
        objects = {"squares": {"type": "GeometryCollection", "geometries": squares}}
        transform = {"scale": [0.5, 0.5], "translate": [10, 0]}
        return json.dumps({"type": "Topology", "arcs": arcs, "objects": objects, "transform": transform} | more)

    @pytest.mark.parametrize("name", ["a.topojson", "a.json"])
    def test_objects_are_layers_and_features(self, written, name):
        path = written(name, self.topology())
        for choice, x in (({"name": "west"}, 10), ({"id": 7}, 11)):
            assert domain(path, feature=choice, layers=("squares",)).bounds == pytest.approx((x, 0, x + 1, 1))
        assert labels_of(path, feature=1) == [["east"]]

    def test_arcs_used_without_end_are_refused(self, written, monkeypatch):
        monkeypatch.setattr("bubblemesh.readers.topojson.MOST_POSITIONS", 1000)
        objects = {"a": {"type": "MultiLineString", "arcs": [[0] * 600]}}
        with pytest.raises(LimitError, match="its arcs make more than 1,000 positions"):
            domain(written("a.topojson", self.topology(objects=objects)))


class TestSlips:
    """Points twice, spikes, rings without an area, lines given twice."""

    def polygon(self, written, *rings):
        return written("a.geojson", json.dumps({"type": "Polygon", "coordinates": rings}))

    def test_spikes_are_dropped_and_counted(self, written):
        # Spikes in the middle, of two steps, at the start, and beside a point that is given twice.
        x, y = [0, 4, 6, 4, 4, 4, 4, 4, 4, 4, 0, 0, -1, 0], [0, 0, 0, 0, 4, 7, 9, 5, 4, 4, 4, 0, 0, 0]
        ring = [*map(list, zip(x, y, strict=True))]
        path = self.polygon(written, ring)
        (found,) = read_rings(path, Selection())
        assert sorted(found.vertices) == [(0, 0), (0, 4), (4, 0), (4, 4)]
        assert area(path) == pytest.approx(16)
        (note,) = notes_of(path)
        assert note.startswith("1 duplicate point, ")
        assert "spikes dropped, the first at (6, 0)" in note

    def test_a_ring_that_starts_at_a_spike(self, written):
        path = self.polygon(written, [[-1, 0], [4, 0], [4, 4], [0, 4], [0, 0], [-1, 0]])
        (found,) = read_rings(path, Selection())
        assert sorted(found.vertices) == [(0, 0), (0, 4), (4, 0), (4, 4)]

    def test_a_needle_is_no_spike(self, written):
        path = self.polygon(written, [[0, 0], [4, 0], [4, 2], [9, 2.000001], [4, 2.000002], [4, 4], [0, 4], [0, 0]])
        (found,) = read_rings(path, Selection())
        assert len(found.vertices) == 7
        assert found.notes == ()

    def test_rings_without_an_area_are_dropped(self, written):
        flat = [[1, 1], [2, 2], [3, 3], [1, 1]]
        path = self.polygon(written, SQUARE, flat, HOLE, [[3, 1], [3, 1], [3, 1], [3, 1]])
        assert area(path) == pytest.approx(15)
        assert notes_of(path) == ["2 flat rings dropped, the first at (1, 1)"]
        with pytest.raises(GeometryError, match="feature 0: no ring has an area"):
            domain(self.polygon(written, flat))

    def test_slips_of_many_features_are_one_note(self, written):
        square = [[*SQUARE[0]], *SQUARE]
        path = written("a.geojson", collection(*({"type": "Polygon", "coordinates": [square]} for _ in range(3))))
        rings = read_rings(path, Selection())
        assert [ring.notes for ring in rings] == [
            ("a.geojson: 3 duplicate points dropped, the first at (0, 0)",), (), ()
        ]  # fmt: skip

    def test_the_place_of_a_point_that_a_line_has_twice_is_its_own(self, written):
        (line,) = read_lines(written("a.csv", "x,y\n0,1.2\n20,0.8\n20,0.8\n45,2\n45,2\n80,2.5\n"), Selection())
        assert "a.csv: 2 duplicate points dropped, the first at (20, 0.8)" in line.notes

    def test_lines_given_twice_count_once(self, written):
        lines = "LINESTRING (0 0, 4 0, 4 4)\nLINESTRING (4 4, 0 4, 0 0)\nLINESTRING (0 0, 0 4, 4 4)\n"
        path = written("a.wkt", lines + lines.splitlines()[0] + "\nLINEARRING (1 1, 2 1, 2 2, 1 1)" * 2)
        assert area(path) == pytest.approx(15.5)
        assert notes_of(path) == ["3 double lines dropped, the first at (0, 4)".replace("(0, 4)", "(0, 0)")]


def test_only_the_features_that_are_taken_are_looked_at(tmp_path):
    square, broken = [[[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]], [[[0, 0], ["x", 1]]]
    features = [
        {"type": "Feature", "properties": {"NAME": name}, "geometry": {"type": "Polygon", "coordinates": rings}}
        for name, rings in (("a", broken), ("b", square))
    ]
    path = tmp_path / "a.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    (found,) = read_areas(path, Selection(feature={"NAME": "b"}))
    assert len(found.outer.vertices) == 4
    assert read_areas(path, Selection(feature=1))[0] == found
    with pytest.raises(CaseError, match="no pair of numbers"):
        read_areas(path, Selection(feature=0))
