"""Files whose coordinates are degrees say so, however they tell it; drawings do not."""

import json

import pytest

from bubblemesh.case import load_case
from bubblemesh.problem.domain import case_domain

UTM = [[500000.0, 5300000.0], [501000.0, 5300000.0], [500500.0, 5300700.0]]
LAKE = [[11.3217, 48.0113], [11.4193, 48.0137], [11.3822, 47.9171]]
PLATE = [[1, 1], [3, 1], [3, 2.5], [1, 2.5]]
SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]
CELL = [[10, 50], [11, 50], [11, 51], [10, 51]]  # of a map, with numbers as people draw
FOIL = [[1.0, 0.00126], [0.5132, 0.0529], [0.0, 0.0], [0.4871, -0.0529]]


def notes(path, text):
    path.write_text(text)
    return case_domain(load_case("a.yaml", text=f"domain: {{file: {path}}}\nspacing: 1\n")).notes


def geojson(points):
    return json.dumps({"type": "Polygon", "coordinates": [[*points, points[0]]]})


def wkt(points):
    return "POLYGON (({}))".format(", ".join(f"{x} {y}" for x, y in [*points, points[0]]))


@pytest.mark.parametrize(("ending", "form"), [("geojson", geojson), ("wkt", wkt)])
def test_degrees_are_told_with_what_follows_and_what_to_do(tmp_path, ending, form):
    (note,) = notes(tmp_path / f"a.{ending}", form(LAKE))
    assert "coordinates look like degrees" in note
    assert "1.49 times too long at latitude 48" in note
    assert "EPSG:32632" in note


@pytest.mark.parametrize("points", [UTM, PLATE, SQUARE, FOIL])
@pytest.mark.parametrize(("ending", "form"), [("geojson", geojson), ("wkt", wkt)])
def test_lengths_are_not_told_to_be_degrees(tmp_path, ending, form, points):
    assert notes(tmp_path / f"a.{ending}", form(points)) == ()


@pytest.mark.parametrize(("ending", "form", "told"), [("geojson", geojson, 1), ("ndjson", geojson, 1), ("wkt", wkt, 0)])
def test_round_numbers_of_a_map_far_from_the_origin_are_degrees(tmp_path, ending, form, told):
    assert sum("coordinates look like degrees" in note for note in notes(tmp_path / f"a.{ending}", form(CELL))) == told


def test_round_numbers_of_a_hole_are_those_of_a_drawing(tmp_path):
    (tmp_path / "a.geojson").write_text(geojson(CELL))
    text = f"domain: {{outer: {{rectangle: [0, 0, 80, 80]}}, holes: [{{file: {tmp_path}/a.geojson}}]}}\nspacing: 1\n"
    assert case_domain(load_case("a.yaml", text=text)).notes == ()


ACROSS = [[179, -17], [-179, -17], [-179, -16], [179, -16]]
EARTH = [[-180, -60], [180, -60], [180, 80], [-180, 80]]
WIDE = [[-100, -50], [100, -50], [100, 50], [-100, 50]]


def test_a_map_across_the_date_line_is_told_how_wide_it_is(tmp_path):
    degrees, width = notes(tmp_path / "a.geojson", geojson(ACROSS))
    assert "EPSG:32760" in degrees
    assert "longitudes jump at the date line, and are taken as they are, 358 degrees apart: add 360" in width


@pytest.mark.parametrize("points", [EARTH, WIDE, [[x % 360, y] for x, y in ACROSS]])
def test_what_does_not_cross_the_date_line_is_not_told_so(tmp_path, points):
    assert not any("date line" in note for note in notes(tmp_path / "a.geojson", geojson(points)))


@pytest.mark.parametrize(
    ("system", "told"), [("urn:ogc:def:crs:OGC:1.3:CRS84", True), ("EPSG:4326", True), ("EPSG:32632", False)]
)
def test_the_system_that_geojson_names_decides(tmp_path, system, told):
    square = {
        "type": "Polygon",
        "coordinates": [[[10.5, 50.5], [11.5, 50.5], [11.5, 51.5], [10.5, 51.5], [10.5, 50.5]]],
    }
    feature = {"type": "Feature", "properties": {}, "geometry": square}
    named = {"type": "name", "properties": {"name": system}}
    text = json.dumps({"type": "FeatureCollection", "crs": named, "features": [feature]})
    assert any("coordinates are degrees" in note for note in notes(tmp_path / "a.geojson", text)) == told


@pytest.mark.parametrize(("number", "told"), [(4326, True), (32632, False)])
def test_the_system_that_wkt_names_decides(tmp_path, number, told):
    text = f"SRID={number};POLYGON((10.5 50, 11.5 50, 11 51, 10.5 50))"
    assert any("coordinates are degrees" in note for note in notes(tmp_path / "a.wkt", text)) == told


@pytest.mark.parametrize(
    ("system", "told"),
    [('GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984"]]', True), ('PROJCS["UTM",GEOGCS["GCS_WGS_1984"]]', False)],
)
def test_the_reference_system_of_a_shapefile_decides(tmp_path, system, told):
    shapely, pyogrio = pytest.importorskip("shapely"), pytest.importorskip("pyogrio")
    shape = shapely.Polygon(PLATE)
    pyogrio.raw.write(
        tmp_path / "a.shp",
        shapely.to_wkb([shape]),
        [],
        [],
        geometry_type="Polygon",
        driver="ESRI Shapefile",
        crs="EPSG:3857",
    )
    (tmp_path / "a.prj").write_text(system)
    found = case_domain(load_case("a.yaml", text=f"domain: {{file: {tmp_path}/a.shp}}\nspacing: 1\n")).notes
    assert any("coordinates are degrees" in note for note in found) == told
