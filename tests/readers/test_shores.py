"""Land in a box from maps: lines of any length, turns of longitude, gaps of rounding, and what is told of them."""

import json

import numpy as np
import pytest
import shapely

from bubblemesh.errors import CaseError
from bubblemesh.readers.shores import land_in


@pytest.fixture
def land(tmp_path):
    """Function from shapes, a box and their kind to the land there, as one shape, and the notes."""

    def found(shapes, box, of="land", crs=None):
        features = [{"type": "Feature", "properties": {}, "geometry": shapely.geometry.mapping(one)} for one in shapes]
        path = tmp_path / "s.geojson"
        path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
        faces = land_in(path, of, None, tuple(box), crs)
        return shapely.union_all(faces.shapes), faces.notes

    return found


BOX = [0, 50, 2, 51]
WEST = shapely.box(0, 50, 0.5, 51)  # on the left of lines to the north


@pytest.mark.parametrize(
    ("lines", "box", "expected"),
    [
        ([[(0.5, 49), (0.5, 50.4)], [(0.5, 50.4), (0.5, 52)]], BOX, WEST),
        ([[(0.5, y) for y in np.linspace(49, 52, 31)]], BOX, WEST),
        ([[(0.5, 49), (0.5, 52)]], [0.4, 50, 0.6, 50.2], WEST),
        (
            [[(-1, 50.3), (0.5, 50.4), (0.6, 49)]],
            BOX,
            shapely.Polygon([(-1, 50.3), (0.5, 50.4), (0.6, 49), (4, 49), (4, 60), (-1, 60)]),
        ),
        ([[(-3, 40), (8, 40), (1, 52), (-3, 40)]], [0, 49, 3, 52], shapely.Polygon([(-3, 40), (8, 40), (1, 52)])),
    ],
)
def test_sides_of_faces_tell_where_the_land_is_however_long_the_lines_are(land, lines, box, expected):
    shape, notes = land(map(shapely.LineString, lines), box, "lines")
    assert shape.symmetric_difference(shapely.box(*box).intersection(expected)).area < 1e-12
    assert notes == ()


@pytest.mark.parametrize("points", [2, 30])
def test_a_line_that_ends_in_the_box_is_an_error(land, points):
    line = shapely.LineString([(0.5, y) for y in np.linspace(49, 50.6, points)])
    with pytest.raises(CaseError, match=r"^feature 0 ends at \(0.5, 50.6\), in the box: continue it"):
        land([line], BOX, "lines")


def test_a_short_spur_is_left_out_with_a_note(land):
    shore = shapely.LineString([(0.5, 49), (0.5, 50.5), (0.5, 52)])
    spur = shapely.LineString([(0.5, 50.5), (0.52, 50.5)])
    shape, notes = land([shore, spur], BOX, "lines")
    assert shape.equals(WEST)
    assert notes == ("1 piece of lines that bound nothing left out, the first at (0.5, 50.5)",)


def test_of_lines_the_one_that_runs_against_the_others_is_named(land):
    island = shapely.LineString(shapely.Point(1.5, 50.5).buffer(0.1).exterior.coords).reverse()  # land on its left
    shore = shapely.LineString([(0.5, 49), (0.5, 52)])
    assert land([shore, island], BOX, "lines")[0].area == pytest.approx(0.5 + shapely.Polygon(island).area)
    with pytest.raises(CaseError, match=r"^feature 1 runs against the other lines around it at \(1\.[456]\d*, 50\."):
        land([shore, island.reverse()], BOX, "lines")


@pytest.mark.parametrize("line", [False, True])
@pytest.mark.parametrize(
    ("box", "island", "expected"),
    [([357, 50, 359, 51], -2, 358), ([-3, 50, -1, 51], 358, -2), ([-3, 50, -1, 51], -2, -2)],
)
def test_land_is_taken_to_the_turn_of_the_box(land, box, island, expected, line):
    pytest.importorskip("pyproj")
    ring = shapely.Point(island, 50.5).buffer(0.1).exterior.reverse().coords
    shape, notes = land(
        [(shapely.LineString if line else shapely.Polygon)(ring)], box, "lines" if line else "land", "EPSG:4326"
    )
    assert shape.symmetric_difference(shapely.Point(expected, 50.5).buffer(0.1)).area < 1e-9
    assert notes == ()


def test_land_that_was_cut_at_the_date_line_is_one(land):
    pytest.importorskip("pyproj")
    parts = [shapely.box(179.8, -17.1, 180, -16.9), shapely.box(-180, -17.1, -179.8, -16.9)]
    shape, notes = land(parts, [179, -18, 181, -16], "land", "EPSG:4326")
    assert shape.equals(shapely.box(179.8, -17.1, 180.2, -16.9))
    assert notes == ()


def test_metres_have_no_turns(land):
    assert land([shapely.box(357, 50, 358, 51)], [-3, 50, -1, 51])[0].is_empty


@pytest.mark.parametrize(
    ("crs", "bad", "message"),
    [
        ("EPSG:4326", (1e30, 50.5), r"feature 1: 1e\+30 is no coordinate on the earth: correct it"),
        ("EPSG:25832", (1, 1e30), r"feature 1: 1e\+30 is no coordinate on the earth: correct it"),
        ("EPSG:25832", (1, 1e10), r"feature 1: 1e\+10 is no coordinate on the earth: correct it"),
        ("EPSG:4326", (1.2, 150.5), r"feature 1: vertex 3 at \(1.2, 150.5\) is no longitude and latitude: correct it"),
        ("EPSG:4326", (1000, 50.5), r"feature 1: vertex 3 at \(1000, 50.5\) is no longitude and latitude: correct it"),
    ],
)
def test_a_vertex_that_is_no_place_is_refused_with_its_feature(land, crs, bad, message):
    pytest.importorskip("pyproj")
    island = shapely.Polygon([(1, 50.4), (1.2, 50.4), bad, (1, 50.6)])
    with pytest.raises(CaseError, match=f"^{message}"):
        land([shapely.box(1.5, 50.2, 1.8, 50.5), island], BOX, crs=crs)


def test_a_file_that_says_it_is_in_degrees_has_places_also_without_crs(tmp_path):
    path = tmp_path / "s.geojson"
    island = shapely.Polygon([(1, 50.4), (1.2, 50.4), (1.2, 150.5), (1, 50.6)])
    feature = {"type": "Feature", "properties": {}, "geometry": shapely.geometry.mapping(island)}
    data = {"type": "FeatureCollection", "features": [feature]}
    path.write_text(json.dumps(data))
    assert len(land_in(path, "land", None, tuple(BOX)).shapes) == 1
    path.write_text(
        json.dumps(data | {"crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}}})
    )
    with pytest.raises(CaseError, match=r"^feature 0: vertex 3 at \(1.2, 150.5\) is no longitude and latitude"):
        land_in(path, "land", None, tuple(BOX))


@pytest.mark.parametrize(
    ("shapes", "of"),
    [
        ([shapely.box(5, 49, 6, 52)], "land"),
        ([shapely.LineString([(5, 49), (6, 52)])], "lines"),
        ([shapely.box(-1, 49, 6, 52)], "sea"),
    ],
)
def test_a_box_that_no_shore_meets_is_told_with_both_extents(land, shapes, of):
    x0 = -1 if of == "sea" else 5
    told = f"no shore lies in the box [0, 2] x [50, 51]: the shapes of the file are in [{x0}, 6] x [49, 52]"
    assert land(shapes, BOX, of)[1] == (told,)
    assert land([shapely.box(-1, 49, 1, 52)], BOX)[1] == ()


@pytest.mark.parametrize("of", ["land", "sea"])
def test_gaps_of_rounding_between_tiles_are_closed_with_a_note(land, of):
    tiles = [
        shapely.box(0.5, 50, 1, 51),
        shapely.Polygon([(1.0000001, 50), (2, 50), (2, 51), (1, 51), (1.0000001, 50.3)]),
    ]
    shape, notes = land(tiles, BOX, of)
    assert shape.geom_type == "Polygon"
    assert not shape.interiors
    assert notes[0].startswith("gaps of rounding closed between 1 pair of shapes, the first at (1, 50")


def test_tiles_that_meet_and_shapes_that_are_apart_stay_as_they_are(land):
    tiles = [shapely.box(0.5, 50, 1, 51), shapely.box(1, 50, 1.5, 50.3), shapely.box(1.5001, 50, 2, 51)]
    shape, notes = land(tiles, BOX)
    assert shape.equals_exact(shapely.union_all(tiles))
    assert notes == ()


def test_a_shape_that_crosses_itself_is_told(land):
    bow = shapely.Polygon([(0.5, 50.2), (1, 50.6), (1, 50.2), (0.5, 50.6)])
    assert land([bow], BOX)[1] == ("1 shape mended that crossed or touched itself, the first at (0.75, 50.4)",)
