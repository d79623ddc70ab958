"""Cases whose coordinates are places on the earth: true lengths, systems, units, and what is refused."""

import json
import pickle
import re
from contextlib import nullcontext

import numpy as np
import pytest
import shapely
from commands import command
from invariants import check_mesh

from bubblemesh import mesh
from bubblemesh.adaptivity.adapt import adapted
from bubblemesh.adaptivity.target import Target
from bubblemesh.case import load_case
from bubblemesh.errors import CaseError, GeometryError
from bubblemesh.geometry.paths import Line, Polyline
from bubblemesh.geometry.plane import BENT, Plane
from bubblemesh.geometry.rings import circle, polygon
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.problem.domain import case_domain
from bubblemesh.problem.prepare import prepare
from bubblemesh.problem.projection import projection_of
from bubblemesh.readers import simple_features
from bubblemesh.run.pipeline import mesh_case
from bubblemesh.spacing.quantities import value_of

pyproj = pytest.importorskip("pyproj")
EARTH = pyproj.Geod(ellps="WGS84")
BOX = {"outer": {"rectangle": [-6.5, 49.2, 1.7, 56.3], "labels": ["south", "east", "north", "west"]}}
DEGREES = {"from": "EPSG:4326", "to": "EPSG:4326"}


def case(domain=BOX, spacing=40e3, crs=DEGREES, **keys):
    data = {"domain": domain, "spacing": spacing, "crs": crs, "packing": {"effort": "fast"}}
    return load_case("sea.yaml", text=json.dumps(data | keys))


def lengths(mesh):
    """Lengths (e,) on the ground of edges, and their middles (e, 2), of a mesh in degrees."""
    ends = mesh.points[unique_edges(mesh.triangles)[0]]
    (lon0, lat0), (lon1, lat1) = ends[:, 0].T, ends[:, 1].T
    return EARTH.inv(lon0, lat0, lon1, lat1)[2], ends.mean(axis=1)


# The plane


@pytest.mark.parametrize("middle", [(-2.4, 52.75), (100.0, 0.0), (15.0, 70.0), (150.0, -45.0)])
def test_the_plane_keeps_lengths_but_for_its_scale(middle):
    plane = Plane("EPSG:4326", None, middle)
    random = np.random.default_rng(0)
    points = np.array(middle) + random.uniform(-6, 6, (200, 2))
    ahead = np.column_stack(EARTH.fwd(*points.T, random.uniform(0, 360, 200), np.full(200, 100.0))[:2])
    found = plane.to(points)
    step = np.hypot(*(plane.to(ahead) - found).T)
    np.testing.assert_allclose(step / 100, plane.scale(*found.T), rtol=2e-5)
    np.testing.assert_allclose(plane.given(found), points, atol=1e-9)


def test_a_plane_travels_to_other_processes():
    plane = Plane.about("EPSG:4326", None, np.array([[1.0, 50], [3, 52]]))
    again = pickle.loads(pickle.dumps(plane))
    assert again == plane
    assert again.middle == (2.0, 51.0)
    np.testing.assert_allclose(again.to(np.array([[2.0, 51]])), 0, atol=1e-6)


def test_long_sides_are_polylines_where_they_would_be_bent_too_much():
    ring = polygon([(-10, 50), (10, 50), (10, 50.5), (-10, 50.5)], labels=["a", "b", "c", "d"])
    plane = Plane("EPSG:4326", None, (0.0, 50.0))
    found = plane.ring(ring)
    assert [side.label for side in found.sides] == ["a", "b", "c", "d"]
    np.testing.assert_allclose(found.vertices, plane.to(np.array(ring.vertices)))
    kinds = [type(side.curve) for side in found.sides]
    assert kinds == [Polyline, Line, Polyline, Line]
    points = found.sides[0].curve.points
    assert len(points) > 5
    middles = plane.to((plane.given(points[:-1]) + plane.given(points[1:])) / 2)
    off = np.hypot(*(middles - (points[:-1] + points[1:]) / 2).T) / np.hypot(*np.diff(points, axis=0).T)
    assert off.max() <= 1.05 * BENT


# Meshes


@pytest.fixture(scope="module")
def sea():
    return mesh_case(case())


def test_edges_are_as_long_on_the_ground_as_the_spacing(sea):
    check_mesh(sea.mesh)
    assert sea.mesh.points.min(axis=0) == pytest.approx([-6.5, 49.2], abs=1e-9)
    assert sea.mesh.points.max(axis=0) == pytest.approx([1.7, 56.3], abs=2e-3)
    found, _ = lengths(sea.mesh)
    assert found.mean() == pytest.approx(40e3, rel=0.03)
    assert sea.report["quality"]["mean"] > 0.95


def test_the_spacing_is_that_on_the_ground_far_from_the_middle_too():
    wide = {"outer": {"rectangle": [-20, 40, 20, 62], "label": "open"}}
    plane, places = Plane("EPSG:4326", None, (0.0, 51.0)), np.array([[0.0, 51], [19, 41], [-19, 61], [10, 55]])
    at = plane.to(places)
    assert plane.scale(*at.T).max() > 1.02  # where a spacing that forgot it would be off
    in_plane = prepare(case(wide, 150e3)).spacing(at) / 1000  # a thousandth: lengths hardly bend
    ahead = plane.given(at + in_plane[:, None] * [0.6, 0.8])
    np.testing.assert_allclose(EARTH.inv(*places.T, *ahead.T)[2], 150.0, rtol=1e-4)


def test_a_program_that_goes_on_in_a_plane_gets_places_there():
    prepare(case())
    with pytest.raises(CaseError, match=r"is -0.\d+ at \(0, 0\)"):
        mesh([[0, 0], [1, 0], [1, 1], [0, 1]], "x - 0.3")


@pytest.mark.parametrize(
    "outer",
    [
        {"circle": {"center": [10, 50], "radius": "30 km"}},
        {"path": [[9.6, 50], {"spline": {"through": [[10, 49.7], [10.4, 50], [10, 50.3], [9.6, 50]]}}]},
    ],
    ids=["circle", "spline"],
)
def test_data_is_read_all_over_a_domain_whose_sides_are_curves(tmp_path, outer):
    x, y = np.linspace(9, 11, 41), np.linspace(49, 51, 41)
    np.savez(tmp_path / "sizes.npz", x=x, y=y, d=np.where(x > 10, 3000.0, 2000.0) + 0 * y[:, None])
    head = "ncols 41\nnrows 41\nxllcenter 9\nyllcenter 49\ncellsize 0.05\n"
    rows = np.where(x > 10, 3000, 2000) + 0 * y[:, None].astype(int)
    (tmp_path / "grid.asc").write_text(head + "\n".join(" ".join(map(str, row)) for row in rows))
    for file in ("sizes.npz", "grid.asc"):
        problem = prepare(case({"outer": outer}, {"raster": {"file": str(tmp_path / file)}}))
        assert not problem.warnings
        found = problem.before_rules(problem.domain.plane.to(np.array([[9.7, 50.0], [10.3, 50.0]]))) / 1000
        np.testing.assert_allclose(found, [2, 3], rtol=1e-3)


def test_the_report_tells_the_systems_and_the_scale(sea):
    told = sea.report["crs"]
    assert (told["source"], told["target"]) == ("EPSG:4326", "EPSG:4326")
    assert "+proj=sterea +lat_0=52.75 +lon_0=-2.4" in told["plane"]
    assert told["scale"][0] == pytest.approx(1, abs=1e-9)
    assert 1.001 < told["scale"][1] < 1.003


def test_a_mesh_is_written_in_the_system_that_is_asked_for(sea):
    metres = mesh_case(case(crs={"from": 4326, "to": 32630})).mesh
    to = pyproj.Transformer.from_crs(4326, 32630, always_xy=True)
    np.testing.assert_allclose(metres.points, np.column_stack(to.transform(*sea.mesh.points.T)), atol=1e-3)
    plane = mesh_case(case(crs={"from": "EPSG:4326"})).mesh
    assert np.hypot(*plane.points.mean(axis=0)) < 50e3
    np.testing.assert_array_equal(plane.triangles, sea.mesh.triangles)


def test_metres_are_given_as_well():
    corners = [[400e3, 100e3], [500e3, 100e3], [500e3, 200e3], [400e3, 200e3]]
    found = mesh_case(case({"outer": {"polygon": corners}}, 10e3, {"from": "EPSG:27700", "to": "EPSG:27700"})).mesh
    assert found.points.max(axis=0) == pytest.approx([500e3, 200e3], abs=5)


def test_second_order_is_written_too():
    keys = {"outer": {"circle": {"center": [2, 51], "radius": "50 km"}}}
    mesh = mesh_case(case(keys, "10 km", output={"order": 2})).mesh
    edge = mesh.points[mesh.facets]
    _, _, far = EARTH.inv(np.full(edge.shape[:2], 2.0), np.full(edge.shape[:2], 51.0), edge[..., 0], edge[..., 1])
    np.testing.assert_allclose(far, 50e3, rtol=1e-4)
    np.testing.assert_allclose(mesh.facet_middles, mesh.points[mesh.facets[:, 2]])


@pytest.mark.parametrize(
    "near",
    [
        {"point": [-2.0, 53.0], "size": "4 km", "growth": 0.2},
        {"line": [[-2.0, 53.0], [-2.0, 53.1]], "size": "4 km", "growth": 0.2},
    ],
)
def test_places_in_the_spacing_are_given_ones(near):
    mesh = mesh_case(case(spacing={"value": "40 km", "near": near})).mesh
    found, at = lengths(mesh)
    finest = at[np.argsort(found)[:10]]
    assert np.abs(finest - [-2.0, 53.0]).max() < 0.5


def test_x_and_y_in_the_spacing_are_given_ones():
    found, at = lengths(mesh_case(case(spacing="20e3 + 5e3 * (y - 49)")).mesh)
    np.testing.assert_allclose((found / (20e3 + 5e3 * (at[:, 1] - 49))).mean(), 1, rtol=0.03)
    with pytest.raises(CaseError, match=r"x and y, in the system of crs.from, and distance, in metres"):
        prepare(case(spacing="y * distance()"))
    assert prepare(case(spacing="10e3 + 0.2 * distance()")).survey.extremes.minimum > 9e3


def test_data_are_at_given_places(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    np.savez(tmp_path / "d.npz", d=[[20e3, 60e3], [20e3, 60e3]], x=[-6.5, 1.7], y=[49.2, 56.3])
    problem = prepare(case(spacing={"raster": {"file": "d.npz"}}))
    assert problem.warnings == ()
    plane = problem.domain.plane
    at = plane.to(np.array([[-6.4, 50.0], [1.6, 55.0]]))
    expected = np.array([20488, 59512]) * plane.scale(*at.T)
    np.testing.assert_allclose(problem.spacing(at), expected, rtol=1e-4)
    np.savez(tmp_path / "d.npz", d=[[20e3, 60e3], [20e3, 60e3]], x=[16.5, 17.7], y=[49.2, 56.3])
    (warning,) = prepare(case(spacing={"raster": {"file": "d.npz"}})).warnings
    assert "the data is in [15.9, 18.3] x [45.65, 59.85], the domain in [-6.5, 1.7]" in warning


def test_embedded_points_and_lines_are_given_ones():
    keys = BOX | {"points": [{"at": [-2.0, 52.0]}], "lines": [{"path": [[-3.0, 51.0], [-1.0, 51.0]], "label": "ferry"}]}
    mesh = mesh_case(case(keys)).mesh
    np.testing.assert_allclose(mesh.points[mesh.labelled_nodes], [[-2, 52]], atol=1e-9)
    ferry = mesh.points[mesh.facets[mesh.facet_labels == mesh.labels.index("ferry")]]
    assert ferry[..., 0].min() == pytest.approx(-3, abs=1e-9)
    assert ferry[..., 1].max() == pytest.approx(51.02, abs=0.02)  # straight in the plane


# What meets as given meets in the plane


def nodes_of(mesh, label):
    """Places of the nodes of a label's edges."""
    ends = mesh.facets[mesh.facet_labels == mesh.labels.index(label)]
    return set(map(tuple, mesh.points[ends].reshape(-1, 2).round(9).tolist()))


LEVEE = {"path": [[9.15, 47.5], [9.15, 48]], "label": "levee"}
LAND = {"rectangle": [8, 47, 10, 48], "label": "rim"}
METRES = {"from": "EPSG:32632", "to": "EPSG:32632"}
PLAIN = [500000, 5297000, 520000, 5303000]


@pytest.mark.parametrize(
    ("domain", "crs", "size", "labels", "at"),
    [
        ({"outer": LAND, "lines": [LEVEE]}, DEGREES, 20e3, ("levee", "rim"), (9.15, 48)),
        (
            {"outer": LAND, "lines": [LEVEE, {"path": [[8.5, 47.2], [9.15, 47.7]], "label": "b"}]},
            DEGREES,
            20e3,
            ("levee", "b"),
            (9.15, 47.7),
        ),
        (
            {
                "outer": LAND,
                "lines": [{"path": [[8.5, 47.6], [9.5, 47.6]], "label": "b"}, LEVEE | {"path": [[9, 47.6], [9, 47.8]]}],
            },
            DEGREES,
            20e3,
            ("levee", "b"),
            (9, 47.6),
        ),
        (
            {
                "outer": {"rectangle": PLAIN, "label": "rim"},
                "lines": [{"path": [[505e3, 5300200], [52e4, 5300200]], "label": "levee"}],
            },
            METRES,
            2000,
            ("levee", "rim"),
            (52e4, 5300200),
        ),
        (
            {
                "outer": {"path": [[8, 48], [8, 47], [10, 47], [10, 48]], "label": "rim"},
                "lines": [LEVEE],
            },
            DEGREES,
            20e3,
            ("levee", "rim"),
            (9.15, 48),
        ),
        (
            {"outer": LAND, "holes": [{"polygon": [[9.2, 48], [9.6, 47.6], [9.7, 47.9]], "label": "hole"}]},
            DEGREES,
            20e3,
            ("hole", "rim"),
            (9.2, 48),
        ),
    ],
    ids=["line on side", "line in a vertex's place", "line on line", "metres", "line on path", "hole on side"],
)
def test_a_vertex_on_a_straight_side_is_a_node_of_both(domain, crs, size, labels, at):
    mesh = mesh_case(case(domain, size, crs)).mesh
    one, other = (nodes_of(mesh, label) for label in labels)
    assert one & other == {at}


def test_regions_share_what_they_share_as_given():
    west = {"name": "west", "ring": {"polygon": [[8.2, 47.4], [8.6, 47.4], [8.6, 47.9], [8.2, 47.9]]}}
    east = {"name": "east", "ring": {"polygon": [[8.6, 47.2], [10, 47.2], [10, 47.8], [8.6, 47.8]]}}
    south = {"name": "south", "ring": {"polygon": [[8.1, 47], [9.9, 47], [9.9, 47.2], [8.1, 47.2]]}}
    result = mesh_case(case({"outer": LAND, "regions": [west, east, south]}, 20e3))
    places = set(map(tuple, result.mesh.points.round(9).tolist()))
    assert {(8.6, 47.4), (8.6, 47.8), (10, 47.2), (10, 47.8), (8.1, 47), (9.9, 47), (8.6, 47.2), (9.9, 47.2)} <= places
    assert result.report["quality"]["min"] > 0.5  # in the plane: no slivers


def test_points_on_straight_sides_are_on_the_boundary():
    points = [{"at": [9.15, 48], "label": "north"}, {"at": [9.4, 47], "label": "south"}]
    mesh = mesh_case(case({"outer": LAND, "points": points}, 20e3)).mesh
    assert {(9.15, 48), (9.4, 47)} <= nodes_of(mesh, "rim")


def test_rings_are_overlaid_as_given():
    cut = {"polygon": [[9, 47.7], [9.5, 47.7], [9.5, 48], [9, 48]], "label": "cut"}
    mesh = mesh_case(case({"outer": {"minus": [LAND, cut]}}, 20e3)).mesh
    inside = (mesh.points[:, 0] > 9 + 1e-9) & (mesh.points[:, 0] < 9.5 - 1e-9) & (mesh.points[:, 1] > 47.702)
    assert not inside.any()
    assert nodes_of(mesh, "rim") & nodes_of(mesh, "cut") == {(9, 48), (9.5, 48)}


def test_sides_that_no_vertex_lies_on_get_none():
    keys = {"outer": LAND, "lines": [LEVEE | {"path": [[9.15, 47.5], [9.15, 47.999]]}]}
    ring = case_domain(case(keys)).boundary
    assert len(ring.corners) == 6
    middle = {"outer": LAND, "points": [{"at": [8, 47.5]}]}  # the sides to the west and east hardly bend
    assert len(case_domain(case({"outer": LAND})).boundary.corners) == 4
    assert len(case_domain(case(middle)).boundary.corners) == 5


def test_vertices_on_short_sides_of_what_is_cut_are_nodes_of_both():
    wide = {"polygon": [[0, 40], [20, 40], [20, 55], [0, 55]]}
    keys = {
        "outer": {"intersection": [wide, {"rectangle": [9, 47.9, 9.1, 48]}]},
        "lines": [
            {"path": [[9.03, 47.95], [9.031, 47.951]], "label": "short"},
            {"path": [[9.0305, 47.9505], [9.05, 47.94]], "label": "end"},
        ],
    }
    lines = {line.label: line for line in case_domain(case(keys)).parts.lines}
    assert lines["end"].vertices[0] in lines["short"].vertices


def test_lines_in_the_sea_meet_where_they_do_as_given(in_folder):
    feature_file(in_folder / "isle.geojson", "Polygon", [[1, 50], [1.2, 50], [1.2, 50.2], [1, 50]])
    keys = {"box": [0, 49, 4, 51], "shoreline": {"file": "isle.geojson"}}
    keys["lines"] = [
        {"path": [[1, 49.5], [3, 49.5]], "label": "long"},
        {"path": [[2.3, 49.5], [2.4, 49.9]], "label": "end"},
    ]
    lines = {line.label: line for line in case_domain(case(keys)).parts.lines}
    assert lines["end"].vertices[0] in lines["long"].vertices


@pytest.mark.parametrize(
    ("keys", "middle"),
    [
        ({"points": [{"at": [9.9, 47.9]}], "outer": LAND}, (9, 47.5)),
        ({"outer": [{"circle": {"center": [8.5, 47.25], "radius": "9 km"}}, LAND]}, (8.5, 47.25)),
        ({"outer": {"path": [[8, 47], [10, 47], [10, 48]]}}, (8, 47)),
        ({"file": "land.geojson", "lines": [LEVEE]}, (9, 47.5)),
        ({"regions": [{"name": "a", "at": [8.5, 47.25]}, {"file": "land.geojson", "name": "name"}]}, (8.5, 47.25)),
    ],
    ids=["outer", "circle", "path", "file", "regions"],
)
def test_the_plane_is_about_the_first_of_what_the_domain_is_made_of(keys, middle, in_folder):
    feature_file(in_folder / "land.geojson", "Polygon", [[8, 47], [10, 47], [10, 48], [8, 48], [8, 47]])
    found = case(keys)
    assert projection_of(found.domain, found.crs).plane.middle == middle


def test_vertices_of_files_are_nodes_of_the_sides_that_they_lie_on(in_folder):
    feature_file(in_folder / "land.geojson", "Polygon", [[8, 47], [10, 47], [10, 48], [8, 48], [8, 47]])
    (in_folder / "line.csv").write_text("9.15,47.5\n9.15,48\n")
    (in_folder / "points.csv").write_text("x,y,name\n9.6,48,a\n9.7,47,b\n")
    keys = {"file": "land.geojson", "label": "rim", "lines": [{"file": "line.csv"}], "points": [{"file": "points.csv"}]}
    domain = case_domain(case(keys))
    corners = set(map(tuple, domain.plane.given(domain.boundary.corners).round(9).tolist()))
    assert {(9.15, 48), (9.6, 48), (9.7, 47)} <= corners


@pytest.mark.parametrize(
    ("corners", "lines", "ends"),
    [
        ([[8, 47], [10, 47], [10, 48], [8, 48]], [LEVEE], nullcontext()),
        ([[8, 47], [10, 48], [10, 47], [8, 48]], [], pytest.raises(GeometryError, match="in domain mends it")),
    ],
    ids=["a line on a side", "invalid"],
)
def test_a_file_is_parsed_once(corners, lines, ends, in_folder, monkeypatch):
    feature_file(in_folder / "land.geojson", "Polygon", [*corners, corners[0]])
    parsed, parse = [], simple_features.read_geojson
    monkeypatch.setattr(simple_features, "read_geojson", lambda *given: parsed.append(given) or parse(*given))
    with ends:
        case_domain(case({"file": "land.geojson", "lines": lines}))
    assert len(parsed) == 1


def feature_file(path, kind, points, system=None):
    crs = {} if system is None else {"crs": {"type": "name", "properties": {"name": f"urn:ogc:def:crs:EPSG::{system}"}}}
    shape = {"type": kind, "coordinates": [points] if kind == "Polygon" else points}
    path.write_text(json.dumps({"type": "Feature", "properties": {}, "geometry": shape} | crs))


@pytest.mark.parametrize(
    ("system", "line", "told"),
    [
        (
            25833,
            [[2e5, 53e5], [3e5, 54e5]],
            "its coordinates are in ETRS89 / UTM zone 33N (EPSG:25833), those of land.",
        ),
        (
            4326,
            [[9, 47.85], [9.1, 47.9]],
            "its coordinates are in WGS 84 (EPSG:4326), those of land.geojson in WGS 84 / ",
        ),
        (
            None,
            [[9, 47.85], [9.1, 47.9]],
            "all of its coordinates are in the range of degrees, and those of land.geojson",
        ),
        (25832, [[505e3, 5299e3], [515e3, 5301e3]], None),
        (None, [[505e3, 5299e3], [515e3, 5301e3]], None),
    ],
)
def test_files_of_one_domain_are_in_one_system_without_crs(system, line, told, in_folder):
    x0, y0, x1, y1 = PLAIN
    feature_file(in_folder / "land.geojson", "Polygon", [[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]], 32632)
    feature_file(in_folder / "line.geojson", "LineString", line, system)
    text = json.dumps({"domain": {"file": "land.geojson", "lines": [{"file": "line.geojson"}]}, "spacing": 500})
    if told is None:
        assert case_domain(load_case("a.yaml", text=text)).labels[-1] == "line-1"
        return
    with pytest.raises(CaseError) as error:
        case_domain(load_case("a.yaml", text=text))
    assert f"line.geojson: {told}" in str(error.value)


def test_places_in_metres_are_told_to_a_tenth_of_a_metre():
    domain = {
        "outer": {"rectangle": PLAIN},
        "points": [{"at": [508187.46, 5298123.45]}, {"at": [508187.46, 5298123.45]}],
    }
    with pytest.raises(GeometryError, match=r"both at \(508187.5, 5298123\.[45]\)"):
        case_domain(case(domain, 2000, METRES))


def test_lines_of_files_keep_their_labels(in_folder):
    levees = {"type": "LineString", "coordinates": [[9.12, 47.87], [9.2, 47.87], [9.2, 47.9]]}
    long = {"type": "LineString", "coordinates": [[8.1, 47.3], [9.9, 47.3]]}
    features = [
        {"type": "Feature", "properties": {"name": name}, "geometry": shape}
        for name, shape in (("levee-N", levees), ("road", long))
    ]
    (in_folder / "lines.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    domain = case_domain(case({"outer": LAND, "lines": [{"file": "lines.geojson"}]}))
    assert domain.labels == ("rim", "levee-N", "road")


# Files


def coast(path, points, holes=()):
    rings = [[*ring, ring[0]] for ring in (points, *holes)]
    shape = {"type": "Polygon", "coordinates": rings}
    path.write_text(json.dumps({"type": "Feature", "properties": {"name": "sea"}, "geometry": shape}))


@pytest.fixture
def in_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    x, y = np.cos(np.linspace(0, 2 * np.pi, 80)[:-1]), np.sin(np.linspace(0, 2 * np.pi, 80)[:-1])
    around = np.column_stack([2.0123 + 2 * x, 51.0456 + 1.2 * y]).tolist()
    islands = [np.column_stack([2 + k + r * x, 51 + 0.6 * r * y]).tolist() for k, r in ((0, 0.1), (0.5, 0.005))]
    coast(tmp_path / "coast.geojson", around, islands)
    return tmp_path


def test_lengths_and_areas_of_files_are_those_on_the_ground(in_folder):
    keys = {"file": "coast.geojson", "smallest": "5 km2"}
    result = mesh_case(case(keys, "8 km"))
    (change,) = result.report["repairs"]
    assert change["what"] == "1 hole below 5e+06 left out"
    assert result.mesh.points.mean(axis=0) == pytest.approx([2, 51], abs=0.1)
    assert not any("degrees" in warning for warning in result.report["warnings"])
    found, at = lengths(result.mesh)
    away = np.hypot(*(at - [2, 51]).T) > 0.6  # from the island, whose sides are shorter
    assert found[away].mean() == pytest.approx(8e3, rel=0.05)


def test_degrees_with_sizes_in_metres_are_refused(in_folder):
    text = "domain: {file: coast.geojson}\nspacing: {value: 8000, near: {label: sea, size: 200}}\n"
    with pytest.raises(CaseError, match=r"spacing: is 200 where it is finest.*add crs: \{from: EPSG:4326\}"):
        prepare(load_case("a.yaml", text=text))
    assert prepare(load_case("a.yaml", text=text.replace("8000", "0.4").replace("200", "0.1")))
    (in_folder / "case.yaml").write_text(text)
    code, _, said = command("check", "case.yaml")
    assert (code, "add crs: {from: EPSG:4326}" in said.replace("\n", " ")) == (2, True)


PAGES = [  # systems of the mesh, whether places of messages or figures are in it, and its box
    pytest.param("auto", True, (-3500, 3500), (-5600, 5600), marks=pytest.mark.long),
    pytest.param("EPSG:4326", True, (3, 3.1), (52, 52.1), marks=pytest.mark.long),
    ("EPSG:32631", False, (499_000, 508_000), (5.76e6, 5.78e6)),
]
SPIKE = [[3, 52], [3.1, 52], [3.1, 52.1], [3.05, 52.02], [3, 52.1]]  # too sharp for all layers


@pytest.mark.parametrize(("to", "buttons", "x", "y"), PAGES)
def test_places_of_a_page_are_those_of_its_mesh(to, buttons, x, y, in_folder):
    (in_folder / "a.yaml").write_text(
        f"crs: {{from: EPSG:4326, to: '{to}'}}\nspacing: 2 km\npacking: {{effort: fast}}\n"
        f"domain: {{outer: {{polygon: {SPIKE}}}}}\nlayers: [{{on: outer, first: 200, count: 8}}]\n"
    )
    assert command("run", "a.yaml", "--report", "--quiet")[0] == 0
    page = (in_folder / "a.html").read_text()
    centres = np.array(re.findall(r"<td>\(([-\d.]+), ([-\d.]+)\)</td>", page), float)
    assert len(centres) > 3
    assert np.abs(centres).max() > max(map(abs, (*x, *y))) / 10  # these are no degrees in place of metres
    shown = np.array(re.findall(r'data-x="([-\d.]+)" data-y="([-\d.]+)"', page), float).reshape(-1, 2)
    assert bool(len(shown)) == buttons
    for places in (centres, shown):
        assert ((places >= [x[0], y[0]]) & (places <= [x[1], y[1]])).all()


def test_a_coarse_mesh_of_a_small_square_is_no_coast_in_degrees(in_folder):
    square = {"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]]}
    (in_folder / "square.geojson").write_text(json.dumps(square))
    text = "domain: {file: square.geojson}\nspacing: 1.2\n"
    assert len(prepare(load_case("a.yaml", text=text)).domain.bounds) == 4
    with pytest.raises(CaseError, match=r"add crs: \{from: EPSG:4326\}"):
        prepare(load_case("a.yaml", text=text.replace("1.2", "2.5")))


def test_messages_tell_given_places(in_folder):
    problem = prepare(case({"file": "coast.geojson"}, "30 km"))
    told = [text for text in problem.warnings if "(" in text]
    assert told
    assert all("e+0" not in text.partition(" at (")[2] for text in told)


SQUARE = {"outer": {"polygon": [[3, 52], [3.1, 52], [3.1, 52.1], [3, 52.1]]}}
SOUTH_WEST, SOUTH_EAST, NORTH_EAST, NORTH_WEST = SQUARE["outer"]["polygon"]


def lines(*paths):
    return [{"type": "LineString", "coordinates": path} for path in paths]


def ring(*points):
    return {"type": "Polygon", "coordinates": [[*points, points[0]]]}


def areas(**rings):
    return [
        {"type": "Feature", "geometry": ring(*points), "properties": {"name": name}} for name, points in rings.items()
    ]


def labelled(at, *labels):
    point = {"type": "Point", "coordinates": at}
    return [{"type": "Feature", "geometry": point, "properties": {"label": label}} for label in labels]


U = [NORTH_EAST, SOUTH_EAST, SOUTH_WEST, NORTH_WEST]
WEST = [SOUTH_WEST, [3.05, 52], [3.05, 52.1], NORTH_WEST]
IN_FILE, LINES = {"file": "a.geojson"}, SQUARE | {"lines": [{"file": "a.geojson", "join": 50}]}
REGIONS = {"regions": [{"file": "a.geojson", "name": "name"}]}
MENDED = {"regions": [{"file": "a.geojson", "name": "name", "repair": {"gap": 20}}]}


@pytest.mark.parametrize(
    ("features", "domain", "told"),
    [
        (lines(U, [NORTH_EAST, [3.02, 52.1]]), IN_FILE, "open ends: feature 0 at (3, 52.1), feature 1 at (3.02, 52.1)"),
        (lines(U, [NORTH_EAST, [3.0001, 52.1]]), IN_FILE | {"join": 20}, "the widest (6.85) at (3.0001, 52.1)"),
        (lines(U, U[::3], U[::-3]), IN_FILE | {"repair": False}, "1 double line dropped, the first at (3, 52.1)"),
        (
            lines([*U, NORTH_EAST], [SOUTH_WEST, [3.2, 52.2]]),
            IN_FILE | {"open": "skip"},
            "1 open curve left out, at (3, 52)",
        ),
        ([ring(*U[:2], *U[1:])], IN_FILE, "1 duplicate point dropped, the first at (3.1, 52)"),
        ([ring(U[0], [3.2, 52.1], *U)], IN_FILE, "1 spike dropped, the first at (3.2, 52.1)"),
        ([ring([2.9, -80], *U[::-1], U[3])], IN_FILE, "1 spike dropped, the first at (2.9, -80)"),
        ([ring([2.9, 98], *U[::-1], U[3])], IN_FILE, "1 spike dropped"),  # no place of the earth
        ([ring(U[0], U[2], U[1], U[3])], IN_FILE, "crosses or touches itself at (3.05, 52.0501)"),
        ([ring(*U[:3], [3.1, 1e200])], IN_FILE, "point 4 at (3.1, 1e+200): coordinates must be finite"),
        (labelled([3.05, 52.05], "a", "b"), SQUARE | {"points": [IN_FILE]}, "others: 'b' at (3.05, 52.05), where"),
        (
            lines([[3.02, 52.02], [3.05, 52.05]], [[3.0501, 52.05], [3.08, 52.06]]),
            LINES,
            "1 end of lines joined, the widest gap (6.86) at (3.0501, 52.05)",
        ),
        (
            areas(w=WEST, e=[[3.0501, 52], *U[1::-1], [3.0501, 52.1]]),
            MENDED,
            "closed, the widest (6.9) of 'w' and 'e' at (3.0501, 52)",
        ),
        (areas(w=WEST, e=[[3.04, 52], *U[1::-1], [3.04, 52.1]]), REGIONS, "overlap by 6.9e+02 at (3.045, 52.05)"),
        ([], {"outer": {"polygon": [SOUTH_WEST, *U[1::-1], NORTH_EAST, NORTH_WEST]}}, "point (3.1, 52.1) merged"),
        ([], {"outer": {"rectangle": [3, 52, 3, 52.1]}}, "the ring at (3, 52) has fewer than three different points"),
    ],
)
def test_what_is_told_of_files_and_keys_is_at_given_places(features, domain, told, in_folder):
    (in_folder / "a.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    try:
        texts = prepare(case(domain, "4 km", {"from": "EPSG:4326"})).warnings
    except (CaseError, GeometryError) as error:
        texts = (str(error),)
    assert [told in text for text in texts].count(True) == 1, texts


def test_hole_points_and_inner_lines_of_a_file_are_places_on_the_earth(in_folder):
    nodes = [*U[::-1], [3.02, 52.02], [3.04, 52.02], [3.03, 52.04], [3.06, 52.06], [3.08, 52.08]]
    sides = [(1, 2), (2, 3), (3, 4), (4, 1), (5, 6), (6, 7), (7, 5), (8, 9)]
    rows = ["9 2 0 0", *(f"{number} {x} {y}" for number, (x, y) in enumerate(nodes, 1))]
    rows += ["8 0", *(f"{number} {a} {b}" for number, (a, b) in enumerate(sides, 1)), "1", "1 3.03 52.025"]
    (in_folder / "a.poly").write_text("\n".join(rows) + "\n")
    domain = prepare(case({"file": "a.poly"}, "2 km")).domain
    assert shapely.get_num_interior_rings(domain.polygon) == 1
    (line,) = domain.parts.lines
    np.testing.assert_allclose(domain.plane.given(np.array(line.vertices)), nodes[-2:])
    (in_folder / "a.poly").write_text("\n".join(rows[:-1]) + "\n1 3.07 52.03\n")
    with pytest.raises(GeometryError, match=r"the hole point \(3\.07, 52\.03\) is outside the outer ring"):
        prepare(case({"file": "a.poly"}, "2 km"))


def test_a_vertex_of_a_file_that_is_no_place_is_told_with_its_feature(in_folder):
    data = json.loads((in_folder / "coast.geojson").read_text())
    data["geometry"]["coordinates"][0][6] = [2, 154.2]
    (in_folder / "coast.geojson").write_text(json.dumps(data))
    with pytest.raises(
        CaseError, match=r"coast.geojson: feature 0 \(sea\): vertex 7 at \(2, 154.2\) is no longitude and latitude"
    ):
        prepare(case({"file": "coast.geojson"}))


@pytest.mark.parametrize(
    ("keys", "crs", "message"),
    [
        (BOX, {"from": "EPSG:99999"}, r"crs.from: 'EPSG:99999' is no known coordinate reference system"),
        (BOX, {"from": "EPSG:4326", "to": "moon"}, r"crs.to: 'moon' is no known coordinate reference system"),
        (BOX, {"from": "EPSG:4978"}, r"crs.from: 'EPSG:4978' is no system of longitude and latitude"),
        ({"outer": {"rectangle": [0, 80, 10, 89.5]}}, DEGREES, "reaches within 1 degree of a pole"),
        ({"outer": {"rectangle": [0, 80, 10, 95]}}, DEGREES, r"\(10, 95\) is no longitude and latitude"),
        ({"outer": {"rectangle": [-179, -10, 179, 10]}}, DEGREES, "spans 358 degrees of longitude: if it crosses"),
        ({"outer": {"rectangle": [-60, -40, 60, 40]}}, DEGREES, "km from the middle of the domain"),
        (
            {"outer": {"rectangle": [1e8, 1e8, 2e8, 2e8]}},
            {"from": "EPSG:25832"},
            r"the outer ring: \(1e\+08, 1e\+08\) is no place of EPSG:25832: correct it, or crs.from",
        ),
        ({"file": "coast.geojson", "scale": 1000}, DEGREES, "coast.geojson: units and scale are not for coordinates"),
        (
            {"outer": {"path": [[0, 50], [2, 50], {"arc": {"to": [0, 50], "center": [1, 50], "turn": "left"}}]}},
            DEGREES,
            "crs: an arc cannot be projected",
        ),
    ],
)
def test_what_no_plane_is_for_is_refused(keys, crs, message, in_folder):
    with pytest.raises(CaseError, match=message):
        prepare(case(keys, crs=crs))


def test_curves_cannot_be_projected():
    with pytest.raises(CaseError, match="a side is a curve"):
        Plane("EPSG:4326", None, (1.0, 50.0)).ring(circle((1, 50), 0.1))


def test_the_date_line_may_be_crossed_by_continuous_longitudes():
    pacific = {"outer": {"rectangle": [176, -10, 184, -5]}}
    found = mesh_case(case(pacific, "100 km", {"from": "EPSG:4326"})).mesh
    assert np.ptp(found.points[:, 0]) == pytest.approx(885e3, rel=0.02)
    written = mesh_case(case(pacific, "100 km", {"from": "EPSG:4326", "to": "EPSG:4326"})).mesh
    np.testing.assert_allclose(
        [written.points.min(axis=0), written.points.max(axis=0)], [[176, -10], [184, -5]], atol=0.02
    )


def test_a_file_in_degrees_is_not_in_metres(in_folder):
    pyogrio = pytest.importorskip("pyogrio")
    square = np.array([shapely.to_wkb(shapely.box(1.01, 50.02, 2.03, 51.04))], dtype=object)
    options = {"field_data": [np.array(["a"], object)], "fields": ["n"], "geometry_type": "Polygon"}
    pyogrio.raw.write("a.gpkg", geometry=square, driver="GPKG", crs="EPSG:4326", **options)
    with pytest.raises(CaseError, match=r"a.gpkg: crs.from: EPSG:27700 is in metres, and the file says"):
        prepare(case({"file": "a.gpkg"}, crs={"from": "EPSG:27700"}))
    assert prepare(case({"file": "a.gpkg"}, "10 km")).warnings == ()


SQUARE = [[500000, 5500000], [500900, 5500000], [500900, 5500900], [500000, 5500900], [500000, 5500000]]
NO_CODE = (  # as Esri's programs name it
    'PROJCS["WGS_1984_UTM_Zone_32N",GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",SPHEROID["WGS_1984",6378137.0,298.257223563]],'
    'PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],'
    'PARAMETER["False_Easting",500000.0],PARAMETER["False_Northing",0.0],PARAMETER["Central_Meridian",9.0],'
    'PARAMETER["Scale_Factor",0.9996],PARAMETER["Latitude_Of_Origin",0.0],UNIT["Meter",1.0]]'
)


def declaring(system):
    """A square in metres as GeoJSON that names its system."""
    named = {"crs": {"type": "name", "properties": {"name": system}}} if system else {}
    feature = {"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [SQUARE]}}
    return json.dumps({"type": "FeatureCollection", "features": [feature]} | named)


@pytest.mark.parametrize(
    ("file", "text", "given"),
    [
        ("a.geojson", declaring("urn:ogc:def:crs:EPSG::32632"), "EPSG:32633"),
        ("a.wkt", f"SRID=32632;{shapely.Polygon(SQUARE).wkt}", "EPSG:32633"),
        (
            "a.wkb",
            shapely.to_wkb(shapely.set_srid(shapely.Polygon(SQUARE), 32632), hex=True, include_srid=True),
            "EPSG:25833",
        ),
        ("a.geojson", declaring("EPSG:32632"), "EPSG:27700"),
        ("a.geojson", declaring("EPSG:32118"), "EPSG:2263"),
        ("a.geojson", declaring(NO_CODE), "EPSG:32633"),
    ],
)
def test_a_file_that_names_another_system_is_refused(in_folder, file, text, given):
    (in_folder / file).write_text(text)
    with pytest.raises(
        CaseError, match=rf"its coordinates are in .*(UTM|New York).*, and crs.from is {given}: give that"
    ):
        prepare(case({"file": file}, 100, {"from": given}))
    shore = {"box": [500000, 5500000, 501000, 5501000], "shoreline": {"file": file}}
    with pytest.raises(CaseError, match=rf"{file}: its coordinates are in .*, and crs.from is {given}: give that"):
        prepare(case(shore, 100, {"from": given}))


@pytest.mark.parametrize("system", ["EPSG:32632", "EPSG:25832", NO_CODE, "an unknown one", None])
def test_a_file_may_name_the_system_in_other_words(in_folder, system):
    (in_folder / "a.geojson").write_text(declaring(system))
    assert case_domain(case({"file": "a.geojson"}, 100, {"from": "EPSG:32632"})).polygon.area == pytest.approx(
        810e3, rel=2e-3
    )


def test_a_map_in_the_range_of_degrees_is_in_no_system_of_metres(in_folder):
    text = shapely.box(8, 50, 9, 51).wkt
    (in_folder / "a.wkt").write_text(text)
    with pytest.raises(CaseError, match=r"a.wkt: crs.from: EPSG:3857 is in metres, and all .* in the range of degrees"):
        prepare(case({"file": "a.wkt"}, 100, {"from": "EPSG:3857"}))
    (in_folder / "a.wkt").write_text(f"SRID=3857;{text}")
    assert case_domain(case({"file": "a.wkt"}, 0.3, {"from": "EPSG:3857"})).polygon.area == pytest.approx(1, rel=0.1)


# Units


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        *[("200 m", "length", 200), ("5km", "length", 5000), ("1.5e2 cm", "length", 1.5), ("10 nmi", "length", 18520)],
        *[("2 in", "length", 0.0508), ("10inch", "length", 0.254), ("3 ft", "length", 0.9144)],
        *[("5 km2", "area", 5e6), (".5 ha", "area", 5000), ("12.42 h", "time", 44712), ("10 min", None, 600)],
    ],
)
def test_quantities(text, dimension, value):
    assert value_of(text, dimension, allowed=True) == pytest.approx(value)


def test_quantities_are_for_cases_of_the_earth_and_of_their_dimension():
    assert case(spacing={"value": "h", "minimum": "2 km"}, parameters={"h": "10 km"}).spacing.minimum == 2000
    for text in ("10 km", "10um", "5 µm", "5nm", "3mil"):
        with pytest.raises(CaseError, match=rf"spacing: {text} has a unit: give the number alone, in the unit of the"):
            load_case("a.yaml", text=f"domain: {{outer: {{rectangle: [0, 0, 1, 1]}}}}\nspacing: {text}\n")
    with pytest.raises(CaseError, match=r"spacing.maximum: .*10 nm is no length: give one in mm, cm, m, km, nmi"):
        case(spacing={"maximum": "10 nm"})
    with pytest.raises(CaseError, match=r"spacing.maximum: .*10 km2 is no length: give one in mm, cm, m, km, nmi"):
        case(spacing={"maximum": "10 km2"})
    with pytest.raises(CaseError, match=r"largest: .*10 km is no area: give one in m2, ha, km2"):
        case(largest="10 km")


def test_solutions_are_in_the_plane():
    advice = "run the case with crs.to: auto, solve on that mesh, and adapt with crs.to: auto"
    with pytest.raises(CaseError, match=f"crs.to: the solution has to be on a mesh in the plane: {advice}"):
        adapted(case(), None, Target())


@pytest.mark.parametrize(("keys", "told"), [("", None), (", units: um", "units: um made its lengths metres")])
def test_lengths_of_a_unit_that_the_case_names_are_no_degrees(keys, told, tmp_path):
    (tmp_path / "a.geojson").write_text('{"type": "Polygon", "coordinates": [[[0, 0], [80, 0], [80, 80], [0, 0]]]}')
    text = f"domain: {{file: a.geojson{keys}}}\nspacing: 500\n"
    found = load_case(tmp_path / "a.yaml", text=text)
    if told is None:
        with pytest.raises(CaseError, match="coordinates in degrees"):
            prepare(found)
    else:
        assert any(told in warning for warning in prepare(found).warnings)
