"""The sea in a box: land cut out of it, labels, islands, detail, narrow channels."""

import json
from pathlib import Path

import numpy as np
import pytest
import shapely
from commands import command
from invariants import check_mesh

from bubblemesh.case import load_case
from bubblemesh.errors import BubblemeshError, LimitError
from bubblemesh.problem.prepare import prepare
from bubblemesh.problem.shoreline.box import sea_in_box
from bubblemesh.problem.shoreline.channels import BAND, without_narrow
from bubblemesh.problem.shoreline.shoreline import fitted_sea
from bubblemesh.run.pipeline import mesh_case

BOX = [0, 0, 100, 60]
COAST = shapely.Polygon([(80, -20), (85, 15), (78, 30), (90, 45), (84, 90), (200, 90), (200, -20)])
ISLAND, ROCK = shapely.Point(30, 30).buffer(8, quad_segs=40), shapely.Point(50, 10).buffer(0.5)
LAND = [COAST, ISLAND, ROCK]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(shapes, name="coast.geojson"):
    features = [{"type": "Feature", "properties": {}, "geometry": shapely.geometry.mapping(shape)} for shape in shapes]
    Path(name).write_text(json.dumps({"type": "FeatureCollection", "features": features}))


def case(spacing=4, box=BOX, name="coast.geojson", **keys):
    own = {key: keys.pop(key) for key in ("smallest", "detail", "narrowest", "of") if key in keys}
    domain = {"box": box, "shoreline": {"file": name} | own}
    data = {"domain": domain, "spacing": spacing, "packing": {"effort": "fast"}}
    return load_case("sea.yaml", text=json.dumps(data | keys))


def lengths(mesh):
    """Length of the edges of each label."""
    along = np.hypot(*(mesh.points[mesh.facets[:, 1]] - mesh.points[mesh.facets[:, 0]]).T)
    return {label: along[mesh.facet_labels == k].sum() for k, label in enumerate(mesh.labels)}


def sea_of(*shapes):
    return shapely.box(*BOX).difference(shapely.union_all(shapes))


def test_land_is_cut_out_of_the_box_and_sides_have_labels():
    write(LAND)
    result = mesh_case(case(smallest=5))
    check_mesh(result.mesh)
    assert set(result.mesh.labels) == {"open", "land", "island"}
    sea = sea_of(COAST, ISLAND)
    assert result.report["area"] == pytest.approx(sea.area)
    found = lengths(result.mesh)
    assert found["island"] == pytest.approx(ISLAND.exterior.length)
    land = COAST.boundary.intersection(shapely.box(*BOX)).length
    assert found["land"] == pytest.approx(land)
    assert found["open"] == pytest.approx(sea.exterior.length - land)
    assert "coast.geojson: 1 island smaller than 5 left out" in result.report["warnings"]


def test_sides_of_the_box_have_no_nodes_but_corners_and_ends_of_the_shore():
    write(LAND)
    domain = prepare(case(smallest=5)).domain
    corners = {tuple(point) for point in domain.boundary.corners.round(6).tolist()}
    assert {(0.0, 0.0), (0.0, 60.0)} <= corners
    on_box = [point for point in corners if point[0] in (0, 100) or point[1] in (0, 60)]
    assert len(on_box) == 4


def test_shore_is_land_and_islands():
    write(LAND)
    terms = {"value": 8, "near": {"label": "shore", "size": 2, "growth": 0.2}}
    spacing = prepare(case(terms, smallest=5)).spacing
    at = np.array([[38.0, 30], [85, 15], [20, 5]])
    np.testing.assert_allclose(spacing(at), [2, 2, min(2 + 0.2 * (np.hypot(10, 25) - 8), 8)], rtol=1e-3)
    spacing = prepare(case("2 + 0.2*distance('shore')", smallest=5)).spacing
    np.testing.assert_allclose(spacing(at[:2]), 2, rtol=1e-3)
    with pytest.raises(BubblemeshError, match=r"unknown label 'coast'; known: .*shore"):
        prepare(case({"value": 8, "labels": {"coast": 2}}))


@pytest.mark.parametrize(
    "terms",
    [
        {"value": 8, "near": {"label": "shore", "size": 2}},
        {"value": 8, "labels": {"shore": 2}},
        "distance('shore') + 1",
    ],
)
def test_a_box_without_a_shore_is_told(terms):
    write([shapely.box(-50, -50, -20, -20)])
    with pytest.raises(BubblemeshError, match=r"no shore lies in the box: correct the box or the file, or leave out"):
        prepare(case(terms))
    with pytest.raises(BubblemeshError, match=r"unknown label 'island'; known: open$"):
        prepare(case({"value": 8, "labels": {"island": 2}}))


def test_what_no_open_side_reaches_is_left_out():
    write([COAST, shapely.Point(30, 30).buffer(10).difference(shapely.Point(30, 30).buffer(4))])
    problem = prepare(case())
    assert "coast.geojson: 1 part of the sea that no open side reaches left out" in problem.warnings
    assert len(problem.domain.boundary.area_of_ring) == 2


BANKS = {  # of an estuary from the west to the east side of a box
    "north": [(0, 38 + 2 * np.sin(3)), *((x, 38 + 2 * np.sin(3 + x / 9)) for x in range(5, 100, 5)), (100, 36)],
    "south": [(0, 22), *((x, 22 + 2 * np.sin(x / 11)) for x in range(5, 100, 5)), (100, 24)],
}


def banks(off, scale=1.0, corner=(0.0, 0.0)):
    """Land on both sides of an estuary, cut off where the box ends, or by this share of its size within it."""
    (x0, x1), (y0, y1) = (100 * off, 100 - 100 * off), (100 * off, 60 - 100 * off)
    shores = [[(min(max(x, x0), x1), y) for x, y in shore] for shore in BANKS.values()]
    north, south = [(x0, y1), *shores[0], (x1, y1)], [(x0, y0), *shores[1], (x1, y0)]
    return [shapely.Polygon(np.array(corner) + scale * np.array(ring)) for ring in (north, south)]


@pytest.mark.parametrize("off", [0, 1e-9, 1e-7, 1e-6])
def test_land_that_was_cut_at_the_box_leaves_no_slivers_along_it(off):
    write(banks(off))
    result = mesh_case(case(3))
    check_mesh(result.mesh)
    assert set(result.mesh.labels) == {"open", "land"}
    assert lengths(result.mesh)["open"] == pytest.approx(38 + 2 * np.sin(3) - 22 + 36 - 24, rel=1e-5)
    assert result.report["area"] == pytest.approx(sea_of(*banks(0)).area, rel=1e-5)
    assert result.report["quality"]["angle_min"] > 20


@pytest.mark.parametrize("off", [0, 1e-9, 1e-7, 1e-6])
def test_land_that_was_cut_at_the_box_in_degrees_leaves_no_slivers_along_it(off):
    pyproj = pytest.importorskip("pyproj")
    write(banks(off, 0.06, (-6, 50)))
    crs = {"from": "EPSG:4326", "to": "auto"}
    result = mesh_case(case("15 km", box=[-6, 50, 0, 53.6], crs=crs))
    check_mesh(result.mesh)
    assert set(result.mesh.labels) == {"open", "land"}
    ground = pyproj.Geod(ellps="WGS84")
    sea = shapely.box(-6, 50, 0, 53.6).difference(shapely.union_all(banks(0, 0.06, (-6, 50))))
    area, _ = ground.geometry_area_perimeter(shapely.segmentize(sea, 0.01))
    assert result.report["area"] == pytest.approx(abs(area), rel=2e-3)
    mouths = [sea.exterior.intersection(shapely.LineString([(x, 50), (x, 53.6)])) for x in (-6, 0)]
    assert lengths(result.mesh)["open"] == pytest.approx(sum(map(ground.geometry_length, mouths)), rel=2e-3)
    assert result.report["quality"]["angle_min"] > 20


def test_small_parts_of_the_sea_are_left_out():
    write([shapely.box(40, -10, 45, 70), shapely.box(45, 4, 120, 70)])
    assert len(set(prepare(case(spacing=2)).domain.boundary.area_of_ring)) == 2
    problem = prepare(case(smallest=500))
    assert len(set(problem.domain.boundary.area_of_ring)) == 1
    assert "coast.geojson: 1 part of the sea smaller than 500 left out" in problem.warnings


# Detail

WIGGLY = shapely.Polygon(
    [
        (50 + (20 + np.sin(40 * t)) * np.cos(t), 30 + (20 + np.sin(40 * t)) * np.sin(t))
        for t in np.linspace(0, 2 * np.pi, 4000)
    ]
)


def test_detail_leaves_out_what_the_spacing_cannot_show():
    write([WIGGLY])
    keys = case({"value": 8, "near": {"label": "shore", "size": 6, "growth": 0.2}}, detail="auto")
    problem = prepare(keys)
    assert any("points of the shore left out, which its detail does not need" in text for text in problem.warnings)
    assert problem.expected_nodes < 1.3 * prepare(case(6, box=BOX, detail=3)).expected_nodes
    whole = prepare(case({"value": 8, "near": {"label": "shore", "size": 6, "growth": 0.2}}))
    assert problem.expected_nodes < 0.5 * whole.expected_nodes


@pytest.mark.parametrize("detail", [0.05, 0.5, 2])
def test_no_point_is_farther_from_the_shore_than_the_detail(detail):
    write([WIGGLY, ROCK.buffer(0.1)])
    keys = case(detail=detail).domain
    before = sea_in_box(keys)
    after = fitted_sea(before, keys, lambda points: points[:, 0])
    (old,), (new,) = before.parts, after.parts
    assert len(shapely.get_coordinates(new)) < len(shapely.get_coordinates(old))
    far = shapely.distance(shapely.points(shapely.get_coordinates(old)), new.boundary)
    assert far.max() <= detail * (1 + 1e-9)
    assert len(new.interiors) == len(old.interiors)
    assert new.is_valid


def test_rings_that_would_cross_keep_their_points():
    strait = 0.05
    other = shapely.affinity.translate(WIGGLY, 44 + strait, 0)
    box = [0, 0, 140, 60]
    west = WIGGLY.difference(other.buffer(strait))
    write([west, other.difference(west.buffer(strait))])
    keys = case(detail=3, box=box).domain
    (part,) = fitted_sea(sea_in_box(keys), keys, lambda points: points[:, 0]).parts
    assert part.is_valid
    assert len(part.interiors) == 2


def test_islands_that_touch_have_less_detail_too():
    around = shapely.Point(30, 30).buffer(8, quad_segs=200)
    east = shapely.affinity.translate(around, 16, 0)
    write([around, east])
    shared = shapely.intersection(around, east)
    assert shared.geom_type == "Point"
    domain = prepare(case(detail="auto")).domain
    assert len(domain.boundary.corners) < 80
    assert domain.polygon.area == pytest.approx(sea_of(around, east).area, rel=2e-3)


def test_a_ring_that_cannot_have_less_detail_keeps_others_from_nothing():
    """A spit so thin that its sides would cross stays as it is; the island beside it does not."""
    x = np.linspace(60, 110, 400)
    wave = 30 + 2 * np.sin(x)
    spit = shapely.Polygon(np.vstack([np.column_stack([x, wave]), np.column_stack([x, wave + 1e-4])[::-1]]))
    write([spit, shapely.Point(30, 30).buffer(8, quad_segs=200)])
    keys = case(detail=3).domain
    (part,) = fitted_sea(sea_in_box(keys), keys, lambda points: points[:, 0]).parts
    assert part.is_valid
    assert min(len(ring.coords) for ring in part.interiors) < 40


def test_a_shore_keeps_its_points_near_a_crossing_only():
    t = np.linspace(0.1, 2 * np.pi - 0.1, 2000)
    r = 20 + 0.2 * np.sin(300 * t)
    mainland = np.column_stack([35 + r * np.cos(t), 30 + r * np.sin(t)])
    there, back = np.linspace(55, 90, 3000), np.linspace(90, 55, 2891)
    spit = [np.column_stack([x, 30 + off + np.sin(x)]) for x, off in ((there, -1e-3), (back, 1e-3))]
    land = np.vstack([mainland, *spit])
    write([shapely.Polygon(land)])
    keys = case(detail=0.5).domain
    (part,) = fitted_sea(sea_in_box(keys), keys, lambda points: points[:, 0]).parts
    assert part.is_valid
    (ring,) = part.interiors
    left = shapely.get_coordinates(ring)
    assert (left[:, 0] > 56).sum() > 50
    assert (left[:, 0] < 50).sum() < 50


@pytest.mark.parametrize("at_once", [4000, 3])
def test_narrow_channels_are_closed(at_once, monkeypatch):
    monkeypatch.setattr("bubblemesh.problem.shoreline.channels.AT_ONCE", at_once)
    monkeypatch.setattr("bubblemesh.problem.shoreline.channels.GROUP", 2)
    wide, narrow = shapely.box(30, -1, 40, 25), shapely.box(30, 26, 40, 61)  # a channel of 1
    write([wide, narrow])
    assert len(set(prepare(case(spacing=2)).domain.boundary.area_of_ring)) == 1
    problem = prepare(case(spacing=2, narrowest=3))
    assert any("1 part of the sea closed, narrower than 3 spacings there" in text for text in problem.warnings)
    assert len(set(problem.domain.boundary.area_of_ring)) == 2
    x = problem.domain.boundary.corners
    assert not ((x[:, 0] > 31) & (x[:, 0] < 39) & (x[:, 1] > 1) & (x[:, 1] < 59)).any()


FUNNEL = [  # from x = 20, where it is 10 wide, to x = 80, where it is 1 wide
    shapely.Polygon([(20, -1), (80, -1), (80, 29.5), (20, 25)]),
    shapely.Polygon([(20, 61), (80, 61), (80, 30.5), (20, 35)]),
]


def width_at(x):
    return 10 - 9 * (x - 20) / 60


@pytest.mark.parametrize(
    ("spacing", "d"),
    [
        ("1", lambda x: 1 + 0 * x),
        ("0.2 + 0.02*x", lambda x: 0.2 + 0.02 * x),
        ("2 - 0.015*x", lambda x: 2 - 0.015 * x),
        ("0.2 + 0.001*abs(x - 50)", lambda x: 0.2 + 0.001 * abs(x - 50)),  # nowhere narrow
    ],
)
def test_channels_end_where_they_are_narrower_than_so_many_of_the_spacings_there(spacing, d):
    write(FUNNEL)
    problem = prepare(case(spacing=spacing, narrowest=3))
    sea = problem.domain.polygon
    x = np.linspace(20, 80, 601)
    narrow = x[width_at(x) < 3 * d(x)]
    first = narrow.min() if len(narrow) else np.inf
    middle = shapely.contains_xy(sea, x, np.full(len(x), 30))
    reach = 0.75 * width_at(first) if len(narrow) else 0  # the last disc, half of it and something
    assert middle[x < first - 0.5].all()
    assert not middle[(x > first + reach) & (x < 79)].any()
    assert (len(set(problem.domain.boundary.area_of_ring)) == 2) == bool(len(narrow))


@pytest.mark.long
def test_long_shores_are_closed_as_discs_say():
    t = np.linspace(0, 2 * np.pi, 5000, endpoint=False)
    inlets = np.clip((np.cos(12 * t) - 0.95) / 0.02, 0, 1)
    r = 20 + 0.1 * np.sin(700 * t) - 8 * inlets
    write([shapely.Polygon(np.column_stack([50 + r * np.cos(t), 30 + r * np.sin(t)]))])
    before = sea_in_box(case().domain)
    after = without_narrow(before, lambda points: np.full(len(points), 1.0), 3, 0)
    (sea,), (part,) = before.parts, after.parts
    inner, outer = (sea.difference(sea.boundary.buffer(radius)).buffer(1.5) for radius in (1.5, 1.5 / BAND))
    assert inner.intersection(sea).difference(part).area < 1e-3 * sea.area
    assert part.difference(outer).area < 0.25 * 3**2 * 24  # corners that stay
    assert part.area < sea.area - 12 * 5


def test_nothing_but_narrow_parts_is_closed():
    write(LAND)
    domain = prepare(case(spacing=2, narrowest=3, smallest=5)).domain
    assert domain.polygon.symmetric_difference(sea_of(COAST, ISLAND)).area < 1e-3 * domain.polygon.area


@pytest.mark.parametrize("narrowest", [2, 6, 12])
def test_a_separate_narrow_sea_is_closed_however_small_it_is(narrowest):
    write([shapely.box(60, -5, 110, 65).difference(shapely.box(94, 27, 110, 33))])
    problem = prepare(case(spacing=4, narrowest=narrowest))
    assert problem.domain.polygon.area == pytest.approx(60 * 60)
    assert any("1 part of the sea closed" in note for note in problem.domain.notes)


@pytest.mark.parametrize("narrowest", [30, 1000])
def test_a_sea_that_is_narrow_all_over_is_no_sea(narrowest):
    write(LAND)
    advice = f"no sea is left in the box: ask for less than narrowest: {narrowest}"
    with pytest.raises(BubblemeshError, match=advice):
        prepare(case(narrowest=narrowest))


# Kinds of shapes


def test_shapes_may_be_sea():
    write([sea_of(COAST, ISLAND), shapely.box(-20, -20, 0, 80)])
    result = mesh_case(case(of="sea"))
    assert result.report["area"] == pytest.approx(sea_of(COAST, ISLAND).area)
    assert lengths(result.mesh)["island"] == pytest.approx(ISLAND.exterior.length)


def test_lines_are_closed_along_the_box():
    shore = shapely.LineString([(80, -5), (85, 15), (78, 30), (90, 45), (84, 65)])  # land on its right
    island = shapely.geometry.polygon.orient(ISLAND).exterior
    write([shore.reverse(), shapely.LineString(island.coords)])
    result = mesh_case(case(of="lines"))
    land = shapely.Polygon([(80, -5), (85, 15), (78, 30), (90, 45), (84, 65), (200, 65), (200, -5)])
    assert result.report["area"] == pytest.approx(sea_of(land, ISLAND).area)
    assert set(result.mesh.labels) == {"open", "land", "island"}
    write([shore, shapely.LineString(island.coords)])
    with pytest.raises(
        BubblemeshError, match=r"coast.geojson: feature 1 runs against the other lines around it at \(3"
    ):
        prepare(case(of="lines"))


@pytest.mark.parametrize(
    ("shapes", "keys", "message"),
    [
        (
            [shapely.box(-10, -10, 200, 200)],
            {},
            "coast.geojson: no sea is left in the box: correct the box, or say of: sea if the shapes are water",
        ),
        ([shapely.box(200, 0, 300, 60)], {"of": "sea"}, "no sea is left in the box: correct the box$"),
        (
            [shapely.box(10, 10, 20, 20), shapely.box(30, 30, 40, 40)],
            {"of": "sea"},
            "coast.geojson: no part of the sea reaches a side of the box: make the box smaller$",
        ),
        ([shapely.LineString([(0, 0), (50, 50)])], {}, "has no areas: give polygons, or say of: lines"),
        ([shapely.Point(0, 0)], {"of": "lines"}, "has no lines: give lines of the shore, or polygons"),
        (LAND, {"detail": "all"}, r"detail: must be auto or a length above 0 \(found"),
        (LAND, {"detail": -5}, r"detail: must be auto or a length above 0 \(found"),
        (LAND, {"smallest": 1e6}, "no sea is left in the box: all of it is below smallest: 1e.06: ask for less"),
        (LAND, {"of": "rock"}, "domain.shoreline.of: must be 'land', 'sea' or 'lines'"),
        (LAND, {"box": [0, 0, 0, 1]}, "must be .x0, y0, x1, y1. with x0 below x1"),
    ],
)
def test_what_is_no_sea_is_refused(shapes, keys, message):
    write(shapes)
    with pytest.raises(BubblemeshError, match=message):
        prepare(case(**keys))


# On the earth


def test_a_coast_in_degrees_becomes_a_tide_model(folder):
    pytest.importorskip("pyproj")
    shapes = [
        shapely.affinity.translate(shapely.affinity.scale(each, 0.05, 0.05, origin=(0, 0)), -7, 50) for each in LAND
    ]
    far = shapely.box(100, -80, 170, 80)  # which no plane holds
    write([*shapes, far])
    text = {
        "domain": {
            "box": [-7, 50, -2, 53],
            "shoreline": {"file": "coast.geojson", "smallest": "20 km2", "detail": "auto"},
        },
        "crs": {"from": "EPSG:4326", "to": "EPSG:4326"},
        "spacing": {"value": "20 km", "near": {"label": "shore", "size": "5 km", "growth": 0.15}},
        "output": {"for": "adcirc"},
    }
    (folder / "tide.yaml").write_text(json.dumps(text))
    code, _, said = command("run", "tide.yaml", "-o", "out", "-q")
    assert (code, "1 island smaller than 20 km2 left out" in said) == (0, True)
    grid = (folder / "out" / "tide.14").read_text()
    assert "1 = number of open boundaries" in grid
    assert " land boundary 1: land" in grid
    assert " island boundary 2: island" in grid
    points = np.array(
        [line.split()[1:3] for line in grid.splitlines()[2 : 2 + int(grid.split("\n")[1].split()[1])]], float
    )
    np.testing.assert_allclose(points.min(axis=0), [-7, 50], atol=0.01)
    assert points[:, 1].max() == pytest.approx(53, abs=0.01)


def test_lines_may_end_at_the_box(folder):
    pytest.importorskip("pyproj")
    write([shapely.LineString([(1.5, 4), (1.4, 2), (1.6, 0)])])
    crs = {"from": "EPSG:4326"}
    mesh = mesh_case(case("20 km", box=[0, 0, 2, 4], of="lines", crs=crs)).mesh
    assert set(mesh.labels) == {"open", "land"}
    assert lengths(mesh)["open"] == pytest.approx((1.5 + 4 + 1.6) * 111.1e3, rel=0.01)


def test_a_box_in_degrees_with_sizes_in_metres_is_refused():
    write(LAND)
    terms = {"value": 10e3, "near": {"label": "shore", "size": 500}}
    with pytest.raises(BubblemeshError, match=r"spacing: is 500 where it is finest.*add crs: .from: EPSG:4326"):
        prepare(case(terms, box=[-7, 40, 2, 60], smallest=5e6))


@pytest.mark.parametrize("keys", [{"narrowest": 2}, {"detail": "auto"}])
def test_sizes_in_degrees_are_refused_before_the_shore_is_fitted(keys, monkeypatch):
    pytest.importorskip("pyproj")
    monkeypatch.setattr("bubblemesh.problem.shoreline.channels.members", None)  # of points that would take minutes
    monkeypatch.setattr("bubblemesh.problem.shoreline.simplification.thinned", None)
    write([shapely.box(1, 1, 1.5, 1.5)])
    message = r"the spacing needs about 7.11e\+13 nodes.*sizes are in metres \(0.02 degrees are about 2.2 km\): coarsen"
    with pytest.raises(LimitError, match=message):
        prepare(case(0.02, box=[0, 0, 2, 1], crs={"from": "EPSG:4326"}, **keys))


@pytest.mark.parametrize("spacing", [0.02, {"value": 10000, "near": {"label": "land", "size": 0.02}}])
def test_plain_sizes_of_a_domain_in_degrees_are_told_to_be_in_metres(spacing):
    pytest.importorskip("pyproj")
    keys = {"domain": {"outer": {"rectangle": [0, 0, 2, 1], "label": "land"}}, "crs": {"from": "EPSG:4326"}}
    with pytest.raises(LimitError, match=r"sizes are in metres \(0.02 degrees are about 2.2 km\)"):
        prepare(load_case("sea.yaml", text=json.dumps(keys | {"spacing": spacing})))


def test_what_is_finer_in_water_that_is_closed_counts_not_in_full():
    lagoon, channel = shapely.box(45, 10, 95, 50), shapely.box(19, 29, 46, 31)
    write([shapely.box(20, -1, 101, 61).difference(lagoon).difference(channel)])
    terms, limits = "where(x > 45, 1.5, 4)", {"max_nodes": 500}
    assert prepare(case(terms, narrowest=3, limits=limits)).expected_nodes < 300
    with pytest.raises(LimitError, match=r"limits.max_nodes: the spacing needs about"):
        prepare(case(terms, limits=limits))
    message = r"narrowest goes by the spacing before spacing.nodes scales it: give about its true sizes"
    with pytest.raises(LimitError, match=message):
        prepare(case({"value": 0.1, "nodes": 200}, narrowest=3, limits=limits))
