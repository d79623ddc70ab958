"""Features of files as regions of one mesh."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import shapely

from bubblemesh.case import load_case
from bubblemesh.errors import CaseError, FileError, GeometryError
from bubblemesh.meshes.conformity import require_conforming
from bubblemesh.meshfiles.formats import FORMATS
from bubblemesh.meshfiles.mesh_files import MeshFiles
from bubblemesh.meshfiles.writing import write_files
from bubblemesh.problem.domain import case_domain
from bubblemesh.problem.prepare import prepare
from bubblemesh.readers.formats import read_regions
from bubblemesh.readers.selection import Selection
from bubblemesh.run.pipeline import mesh_case

WEST, EAST = shapely.box(0, 0, 1, 2), shapely.box(1, 0, 3, 1)
NORTH = shapely.box(1, 1, 3, 2).difference(shapely.box(1.5, 1.25, 2, 1.75))
LAKE = shapely.box(1.5, 1.25, 2, 1.75)


def features(**shapes):
    """GeoJSON of shapes by the names of regions."""
    rows = [
        {"type": "Feature", "properties": {"NAME": name, "zone": name[0]}, "geometry": shapely.geometry.mapping(shape)}
        for name, shape in shapes.items()
    ]
    return json.dumps({"type": "FeatureCollection", "features": rows})


@pytest.fixture
def found(written):
    def read(text, **shapes):
        written("land.geojson", features(**shapes))
        return case_domain(load_case(written("case.yaml", f"domain: {text}\nspacing: 0.3\n")))

    return read


LAND = "{regions: {file: land.geojson, name: NAME}}"


def sizes(domain):
    return {region.name: region.polygon.area for region in domain.parts.regions}


def test_neighbours_are_regions_and_the_domain_is_all_of_them(found):
    domain = found(LAND, west=WEST, east=EAST, north=NORTH)
    assert sizes(domain) == {"west": 2, "east": 2, "north": 1.75}
    assert (domain.polygon.area, domain.piece_count, domain.hole_count) == (5.75, 1, 1)
    assert set(domain.labels) == {"outer", "hole-1", "west-rim", "east-rim"}
    corners = domain.boundary.corners
    assert len(np.unique(corners, axis=0)) == len(corners) == 12
    assert (shapely.get_coordinates(domain.polygon)[:-1] >= 0).all()


def test_a_name_that_is_taken_is_told_with_its_feature_and_what_to_do(found):
    told = r"land\.geojson: feature 1 \(domain\): 'domain' is the name of what regions leave .* or that by region: NAME"
    with pytest.raises(CaseError, match=told):
        found(LAND, west=WEST, domain=EAST)
    named = found("{regions: {file: land.geojson, name: NAME}, region: rest}", west=WEST, domain=EAST)
    assert sizes(named) == {"west": 2, "domain": 2}
    with pytest.raises(CaseError, match=r"land\.geojson: feature 0 \(west\): 'west' is the name of another region too"):
        found(f"{{regions: [{{name: west, ring: {{rectangle: [0, 0, 1, 1]}}}}, {LAND[10:-1]}]}}", west=WEST)


def test_a_region_may_fill_the_hole_of_another_one(found):
    domain = found(LAND, west=WEST, east=EAST, north=NORTH, lake=LAKE)
    assert (domain.polygon.area, domain.hole_count) == (6, 0)
    assert sizes(domain)["lake"] == 0.25


def test_features_of_one_name_are_one_region(found):
    domain = found(LAND.replace("NAME", "zone"), north=NORTH, neck=EAST, west=WEST)
    assert sizes(domain) == {"n": 3.75, "w": 2}


def test_a_list_may_have_regions_of_files_and_others(found):
    disc = "{name: disc, ring: {circle: {center: [-0.5, 0], radius: 0.2}}}"
    regions = f"[{disc}, {{file: land.geojson, name: NAME}}]"
    domain = found(f"{{outer: {{rectangle: [-1, -1, 4, 3]}}, regions: {regions}}}", west=WEST, east=EAST)
    assert [region.name for region in domain.parts.regions] == ["disc", "west", "east"]
    assert domain.polygon.area == 20


@pytest.mark.parametrize("shift", [1e-3, -1e-3])
def test_slivers_and_overlaps_are_closed_up_to_join_and_told(found, shift):
    west = shapely.box(0, 0, 1, 2)
    shapes = {"west": west, "east": shapely.box(1 + shift, 0.2, 3, 0.8), "north": shapely.box(0, 2 + shift / 2, 1, 3)}
    domain = found("{regions: {file: land.geojson, name: NAME, join: 0.01}}", **shapes)
    assert sizes(domain) == pytest.approx({"west": 2, "east": 1.2, "north": 1})
    assert domain.polygon.area == pytest.approx(4.2, rel=1e-12)
    assert domain.piece_count == 1
    (note,) = domain.notes
    assert re.search(r"between 2 pairs of neighbours closed, the widest \(0.001\) of 'west' and 'east' at", note)


def test_borders_of_different_vertices_are_one(found):
    y = np.linspace(0, 2, 41)
    x = 1 + 2e-3 * np.sin(40 * y)
    wavy = shapely.Polygon([(3, 2), (3, 0), *zip(x, y, strict=True)])
    domain = found("{regions: {file: land.geojson, name: NAME, join: 0.01}}", west=WEST, east=wavy)
    assert sizes(domain)["west"] + sizes(domain)["east"] == pytest.approx(domain.polygon.area, rel=1e-12)
    assert (domain.piece_count, domain.hole_count) == (1, 0)


@pytest.mark.parametrize("shift", [3e-7, -1e-3])
def test_without_join_an_error_names_both_the_width_and_the_key_that_helps(found, shift):
    shapes = {"west": WEST, "east": shapely.box(1 + shift, 0.2, 3, 0.8)}
    with pytest.raises(GeometryError) as caught:
        found(LAND, **shapes)
    message = str(caught.value)
    assert re.search(r"land.geojson: 'west' and 'east' (overlap by|are) .* at \(.*\).*: set join: ", message), message
    join = re.search(r"set join: (\S+)", message)[1]
    assert float(join) >= abs(shift)
    domain = found(f"{{regions: {{file: land.geojson, name: NAME, join: {join}}}}}", **shapes)
    assert domain.piece_count == 1


def test_an_overlap_that_no_join_closes_is_told_without_one(found):
    with pytest.raises(
        GeometryError,
        match=r"'west' and 'east' overlap by 0\.2 at .*, too much for a join: .* overlaps: later in ",
    ):
        found(LAND, west=WEST, east=shapely.box(0.8, 0.2, 3, 0.8))


def test_small_features_go_to_their_neighbours_and_small_holes_are_filled(found):
    """A hole of one leaves the border to the other alone; a pixel between two leaves no hole."""
    pixel = shapely.box(1, 0.4, 1.2, 0.6)
    shapes = {"west": WEST.difference(shapely.box(0.4, 0.4, 0.6, 0.6)), "east": EAST.difference(pixel), "spot": pixel}
    domain = found(LAND.replace("}}", ", smallest: 0.1}}"), **shapes)
    assert sizes(domain) == pytest.approx({"west": 2, "east": 2})
    assert (domain.hole_count, set(domain.labels)) == (0, {"outer", "west-rim"})
    assert [change.what for change in domain.changes] == [
        "1 hole below 0.1 left out",
        "1 area below 0.1 given to a neighbour",
    ]
    assert [re.sub(r" at \(.*\)", "", note) for note in domain.notes] == [
        "land.geojson: 1 area below 0.1 given to a neighbour, the largest (0.04) of 'spot' to 'east'",
        "land.geojson: all of 'spot' is below 0.1: no such region is left",
    ]


BOW = shapely.Polygon([(1, 0), (3, 2), (3, 0), (1, 2)])


def test_a_repair_mends_the_rings_of_each_region(found):
    with pytest.raises(
        GeometryError, match=r"region 'east': .* crosses or touches itself at \(2, 1\).*; repair: true in"
    ):
        found(LAND, west=WEST, east=BOW)
    domain = found(LAND.replace("}}", ", repair: true}}"), west=WEST, east=BOW)
    assert [(region.name, region.polygon.area) for region in domain.parts.regions] == [
        ("west", 2),
        ("east", 1),
        ("east", 1),
    ]
    assert [(change.what, change.area) for change in domain.changes] == [("ring that crosses or touches itself", 2)]


def test_a_repair_unites_features_of_one_name_that_overlap(found):
    shapes = {"w1": WEST, "e1": EAST, "e2": shapely.box(2.5, 0, 4, 1)}
    zones = LAND.replace("NAME", "zone")
    with pytest.raises(
        GeometryError, match=r"two features of 'e' overlap by 0\.5 at \(.*\): repair: true unites them$"
    ):
        found(zones, **shapes)
    domain = found(zones.replace("}}", ", repair: true}}"), **shapes)
    assert sizes(domain) == {"w": 2, "e": 3}
    assert [(change.what, change.area) for change in domain.changes] == [("areas that overlap united", -0.5)]


def test_a_feature_within_another_one_of_its_name_is_no_hole_after_a_repair(found):
    zones = LAND.replace("NAME", "zone").replace("}}", ", repair: true}}")
    assert sizes(found(zones, w1=WEST, e1=EAST, e2=shapely.box(1.5, 0.2, 2, 0.8))) == {"w": 2, "e": 2}


def test_a_repair_closes_gaps_between_regions_up_to_its_own(found):
    shapes = {"west": WEST, "east": shapely.box(1.01, 0, 3, 1)}
    assert found(LAND.replace("}}", ", repair: true}}"), **shapes).piece_count == 2
    assert found(LAND.replace("}}", ", repair: {gap: 0.02}}}"), **shapes).piece_count == 1
    with pytest.raises(GeometryError, match=r"repair\.gap: 0\.5 is too much for regions that are 3 wide"):
        found(LAND.replace("}}", ", repair: {gap: 0.5}}}"), **shapes)


def test_what_sticks_out_of_a_neighbour_is_told_with_the_join_that_puts_it_inside(found):
    shapes = {"west": WEST, "east": shapely.box(1.00002, 0, 3, 2), "magnet": shapely.box(1, 0.4, 1.8, 1)}
    with pytest.raises(GeometryError, match=r"'magnet' sticks out of 'east' by 2e-05 at") as caught:
        found(LAND, **shapes)
    join = re.search(r"set join: (\S+)", str(caught.value))[1]
    domain = found(f"{{regions: {{file: land.geojson, name: NAME, join: {join}}}}}", **shapes)
    assert set(domain.labels) >= {"magnet-rim"}
    assert domain.polygon.area == pytest.approx(6)


def test_a_gap_wider_than_join_stays(found):
    domain = found(LAND, west=WEST, east=shapely.box(1.1, 0, 3, 1))
    assert domain.piece_count == 2


@pytest.mark.parametrize(
    ("keys", "kind", "message"),
    [
        ("name: NAMES", CaseError, "unknown property 'NAMES'; did you mean 'NAME'"),
        ("name: NAME, part: all", CaseError, "part is not for regions that share borders"),
        ("name: NAME, join: 1", GeometryError, "join: 1 is too much for regions that are 3 wide"),
    ],
)
def test_what_regions_of_a_file_cannot_be(found, keys, kind, message):
    with pytest.raises(kind, match=message):
        found(f"{{regions: {{file: land.geojson, {keys}}}}}", west=WEST, east=EAST)


def test_a_property_without_values_is_no_name(tmp_path):
    pytest.importorskip("svgelements")
    rect = '<rect id="a" width="40" height="30" fill="#eee"/>'
    (tmp_path / "a.svg").write_text(f'<svg xmlns="http://www.w3.org/2000/svg" width="40" height="30">{rect}</svg>')
    (tmp_path / "a.yaml").write_text("domain: {regions: {file: a.svg, name: class}}\nspacing: 10\n")
    with pytest.raises(CaseError, match=r"no feature has a value of the property 'class': .*; those with values: id"):
        case_domain(load_case(tmp_path / "a.yaml"))


def test_a_name_is_needed(found):
    with pytest.raises(CaseError, match=r"domain\.regions.*\.name: is missing"):
        found("{regions: {file: land.geojson}}", west=WEST)


def test_layers_of_a_drawing_are_regions(written, tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    drawing = ezdxf.new()
    for layer, (x0, x1) in {"STEEL": (0, 1), "COPPER": (1, 3)}.items():
        corners = [(x0, 0), (x1, 0), (x1, 1), (x0, 1)]
        drawing.modelspace().add_lwpolyline(corners, close=True, dxfattribs={"layer": layer})
    drawing.saveas(tmp_path / "parts.dxf")
    text = "domain: {regions: {file: parts.dxf, name: layer}}\nspacing: 0.3\n"
    domain = case_domain(load_case(written("case.yaml", text)))
    assert sizes(domain) == {"STEEL": 1, "COPPER": 2}
    assert domain.polygon.area == 3


def test_curves_stay_curves(written, tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    drawing = ezdxf.new()
    space = drawing.modelspace()
    space.add_lwpolyline([(0, 0), (2, 0), (2, 2), (0, 2)], close=True, dxfattribs={"layer": "PLATE"})
    space.add_lwpolyline([(2, 0, 1), (2, 2, 0)], close=True, format="xyb", dxfattribs={"layer": "CAP"})
    space.add_circle((1, 1), 0.5, dxfattribs={"layer": "CORE"})
    drawing.saveas(tmp_path / "parts.dxf")
    text = "domain: {regions: {file: parts.dxf, name: layer}}\nspacing: 0.3\n"
    domain = case_domain(load_case(written("case.yaml", text)))
    assert sizes(domain).keys() == {"PLATE", "CAP", "CORE"}
    assert domain.polygon.area == pytest.approx(4 + np.pi / 2, rel=1e-4)
    assert domain.nearest(np.array([[4, 1]])).distance == pytest.approx(1, rel=1e-12)


def test_curves_stay_where_small_features_are_left_out(written, tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    drawing = ezdxf.new()
    rings = {
        "A": [(0, 0, 0), (5, 0, 0), (5, 4, -0.3), (5, 6, 0), (5, 10, 0), (0, 10, 0)],
        "B": [(5, 0, 0), (10, 0, 0), (10, 10, 0), (5, 10, 0), (5, 6, -0.3), (5, 4, 0)],
        "C": [(5, 4, 0.3), (5, 6, 0.3)],
    }
    for layer, points in rings.items():
        drawing.modelspace().add_lwpolyline(points, close=True, format="xyb", dxfattribs={"layer": layer})
    drawing.modelspace().add_circle((2, 2), 0.4, dxfattribs={"layer": "D"})
    drawing.saveas(tmp_path / "parts.dxf")
    text = "domain: {regions: {file: parts.dxf, name: layer, smallest: 2}}\nspacing: 1\n"
    domain = case_domain(load_case(written("case.yaml", text)))
    assert sizes(domain) == pytest.approx({"A": 49.593, "B": 49.593}, abs=2e-3)
    assert (domain.hole_count, len(domain.boundary.kind)) == (1, 10)
    notes = " ".join(domain.notes)
    assert "of 'D' to 'A' at (2, 2" in notes
    assert "1 area below 2 left out and given to none, the largest (0.814) of 'C' at (5, 5" in notes


def test_ids_of_a_picture_are_regions(written):
    pytest.importorskip("svgelements")
    shapes = '<rect id="a" width="1" height="2"/><rect id="b" x="1" width="2" height="2"/>'
    written("parts.svg", f'<svg xmlns="http://www.w3.org/2000/svg">{shapes}</svg>')
    text = "domain: {regions: {file: parts.svg, name: id}}\nspacing: 0.3\n"
    assert sizes(case_domain(load_case(written("case.yaml", text)))) == {"a": 2, "b": 4}


@pytest.mark.long
@pytest.mark.parametrize("method", ["multilevel", "accelerated"])
def test_regions_of_files_are_meshed(written, method):
    written("land.geojson", features(west=WEST, east=EAST, north=NORTH, lake=LAKE))
    text = f"""
domain:
  regions: {{file: land.geojson, name: NAME, spacing: 0.1}}
  lines: [{{path: [[0.2, 1.5], [2.8, 0.5]], label: road}}]
spacing: 0.2
method: {method}
"""
    mesh = mesh_case(load_case(written("case.yaml", text))).mesh
    require_conforming(mesh)
    assert mesh.regions == ("west", "east", "north", "lake")
    assert len(mesh.points) > 600
    areas = np.abs(np.linalg.det(np.diff(mesh.points[mesh.triangles], axis=1))) / 2
    np.testing.assert_allclose(np.bincount(mesh.triangle_regions, areas), [2, 2, 1.75, 0.25], rtol=1e-12)


PARTS_OF_POLY = """
13 2 0 0
1 0 0
2 4 0
3 8 0
4 8 4
5 4 4
6 0 4
7 1 1
8 2 1
9 2 2
10 5 1
11 7 1
12 7 3
13 5 3
14 1
1 1 2 1
2 2 3 1
3 3 4 1
4 4 5 1
5 5 6 1
6 6 1 1
7 2 5 0
8 7 8 2
9 8 9 2
10 9 7 2
11 10 11 0
12 11 12 0
13 12 13 0
14 13 10 0
1
1 1.7 1.3
3
1 0.5 0.5 10 0.1
2 4.5 0.5 20 0.05
3 6 2 30 -1
"""


def test_attributes_of_triangle_name_the_parts_that_hold_their_points(written):
    written("parts.poly", PARTS_OF_POLY)
    text = "domain: {regions: {file: parts.poly, name: attribute}}\nspacing: 0.3\n"
    domain = case_domain(load_case(written("case.yaml", text)))
    assert sizes(domain) == {"10": 15.5, "20": 12, "30": 4}
    assert domain.polygon.area == 31.5
    assert domain.notes == ("parts.poly: largest areas of triangles are those of the file in 2 regions (0.05 to 0.1)",)


def test_large_numbers_are_names_with_all_their_digits(written):
    written(
        "parts.poly", PARTS_OF_POLY.replace("0.5 0.5 10", "0.5 0.5 1000001").replace("4.5 0.5 20", "4.5 0.5 1000002")
    )
    text = "domain: {regions: {file: parts.poly, name: attribute}}\nspacing: 0.3\n"
    assert sizes(case_domain(load_case(written("case.yaml", text)))) == {"1000001": 15.5, "1000002": 12, "30": 4}


def test_markers_stay_where_the_file_is_the_domain_as_well(written):
    written("parts.poly", PARTS_OF_POLY)
    text = "domain: {file: parts.poly, regions: {file: parts.poly, name: attribute}}\nspacing: 0.3\n"
    domain = case_domain(load_case(written("case.yaml", text)))
    assert sizes(domain) == {"10": 15.5, "20": 12, "30": 4}
    assert domain.labels[:2] == ("1", "2")


@pytest.mark.parametrize(("name", "driver"), [("land.shp", "ESRI Shapefile"), ("land.gpkg", "GPKG")])
def test_features_of_geographic_files_are_regions(written, tmp_path, name, driver):
    pyogrio = pytest.importorskip("pyogrio")
    shapes = {"west": WEST, "east": EAST, "north": NORTH}
    pyogrio.raw.write(
        tmp_path / name, geometry=shapely.to_wkb(np.array([*shapes.values()], object)), geometry_type="Polygon",
        field_data=[np.array([*shapes], object)], fields=["NAME"], driver=driver, crs="EPSG:3857",
    )  # fmt: skip
    text = f"domain: {{regions: {{file: {name}, name: NAME}}}}\nspacing: 0.3\n"
    domain = case_domain(load_case(written("case.yaml", text)))
    assert sizes(domain) == {"west": 2, "east": 2, "north": 1.75}
    assert domain.polygon.area == 5.75


def test_periodic_sides_of_regions_of_a_file(written):
    cell = {"low": shapely.box(0, 0, 2, 0.5), "high": shapely.box(0, 0.5, 2, 1)}
    written("land.geojson", features(**cell))
    text = """
domain:
  outer: {rectangle: [0, 0, 2, 1], labels: [bottom, right, top, left]}
  regions: {file: land.geojson, name: NAME}
  periodic: [[left, right]]
spacing: 0.2
"""
    mesh = mesh_case(load_case(written("case.yaml", text))).mesh
    require_conforming(mesh)
    left, right = (np.sort(mesh.points[np.abs(mesh.points[:, 0] - x) < 1e-12, 1]) for x in (0, 2))
    np.testing.assert_allclose(left, right, atol=1e-12)
    assert mesh.regions == ("low", "high")


@pytest.fixture(scope="module")
def meshed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("land")
    (folder / "land.geojson").write_text(features(west=WEST, east=EAST, north=NORTH, lake=LAKE))
    (folder / "case.yaml").write_text(f"domain: {LAND}\nspacing: 0.4\n")
    mesh = mesh_case(load_case(folder / "case.yaml")).mesh
    return {1: mesh, 2: mesh.second_order()[0]}


WITHOUT = ("su2", "fort.14", "gr3", "slf", "pos", "nodes.csv", "nodes.npz")
HAVE_REGIONS = [form for form in FORMATS if form not in WITHOUT]


@pytest.mark.parametrize(("form", "order"), [(form, order) for form in HAVE_REGIONS for order in FORMATS[form].orders])
def test_all_formats_hold_regions_of_files(meshed, tmp_path, form, order):
    mesh = meshed[order]
    write_files(mesh, {}, {}, MeshFiles(tmp_path, "land", [form]))
    assert mesh.regions == ("west", "east", "north", "lake")
    assert np.bincount(mesh.triangle_regions).min() > 0
    files = [path for path in tmp_path.rglob("*") if path.is_file() and not path.name.endswith(".report.json")]
    content = b"".join(path.read_bytes() for path in files)
    assert [name for name in mesh.regions if name.encode() not in content] == []


def test_second_order_follows_round_regions_of_a_file(written, tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    drawing = ezdxf.new()
    drawing.modelspace().add_lwpolyline([(0, 0), (2, 0), (2, 2), (0, 2)], close=True, dxfattribs={"layer": "PLATE"})
    drawing.modelspace().add_circle((1, 1), 0.5, dxfattribs={"layer": "CORE"})
    drawing.saveas(tmp_path / "parts.dxf")
    text = "domain: {regions: {file: parts.dxf, name: layer}}\nspacing: 0.25\n"
    mesh, folded = mesh_case(load_case(written("case.yaml", text))).mesh.second_order()
    rim = mesh.facets[mesh.facet_labels == mesh.labels.index("CORE-rim")]
    assert folded == 0
    assert len(rim) > 8
    np.testing.assert_allclose(np.hypot(*(mesh.points[rim] - 1).T), 0.5, rtol=1e-12)


def gap_warnings(written, keys="", spacing=0.5, **shapes):
    written("land.geojson", features(**shapes))
    case = load_case(
        written("case.yaml", f"domain: {{regions: {{file: land.geojson, name: NAME{keys}}}}}\nspacing: {spacing}\n")
    )
    problem = prepare(case)
    return [text for text in problem.warnings if "narrow gap" in text], problem.domain


@pytest.mark.parametrize(("keys", "factor"), [("", 1), (", scale: 2", 2)])
def test_narrow_gaps_that_stay_open_are_told_once_with_the_join_that_closes_them(written, keys, factor):
    shapes = {"west": WEST, "east": shapely.box(1.003, 0, 3, 0.99), "north": NORTH}
    (text,), domain = gap_warnings(written, keys, 0.5 * factor, **shapes)
    assert text.startswith("land.geojson: 1 narrow gap between regions stays open, the widest (0.0")
    join = re.search(r": set join: (\S+) to close what is not meant$", text)[1]
    told, domain = gap_warnings(written, f"{keys}, join: {join}", 0.5 * factor, **shapes)
    assert told == []
    assert (domain.polygon.area, domain.hole_count) == (pytest.approx(5.75 * factor**2, rel=0.01), 1)


@pytest.mark.parametrize(("keys", "wide"), [(", join: 0.001", 2), (", join: 0.025", 1), (", repair: {gap: 0.025}", 1)])
def test_gaps_wider_than_a_join_are_told_with_a_larger_one(written, keys, wide):
    """The gap is closed at the middle, and is 0.02 wide at one end, 0.03 at the other one."""
    upper = shapely.Polygon([(0, 20.02), (50, 20), (100, 20.03), (100, 40), (0, 40)])
    shapes = {"upper": upper, "lower": shapely.box(0, 0, 100, 20)}
    (text,), _ = gap_warnings(written, keys, 5, **shapes)
    assert text.startswith(f"land.geojson: {wide} narrow gap")
    join = re.search(r"the widest \(0\.03\) between 'lower' and 'upper' at .*: set join: (\S+) to close", text)[1]
    told, domain = gap_warnings(written, f", join: {join}", 5, **shapes)
    assert (told, domain.boundary.lengths[~domain.boundary.inner].sum()) == ([], pytest.approx(280, rel=1e-3))


def triple(gap=0.5):
    """Three neighbours that leave a triangle open where they meet, as outlines of labels in a picture do."""
    x = (50 - gap, 50), (50, 50 + gap), (50 + gap, 50)
    return {
        "a": shapely.Polygon([(0, 0), (100, 0), (100, 50), x[2], x[0], (0, 50)]),
        "b": shapely.Polygon([(0, 50), x[0], x[1], (50, 100), (0, 100)]),
        "c": shapely.Polygon([(100, 50), (100, 100), (50, 100), x[1], x[2]]),
    }


@pytest.mark.parametrize("key", ["join: 0.5", "repair: {gap: 0.5}"])
def test_a_gap_where_three_meet_is_told_and_closed(written, key):
    (text,), domain = gap_warnings(written, spacing=10, **triple())
    assert (domain.hole_count, domain.polygon.area) == (1, 9999.75)
    assert re.search(r"the widest \(0\.41\) between 'a' and 'b' at \(50, 50\.2.\): set join: 0\.4\d to close", text)
    told, domain = gap_warnings(written, f", {key}", spacing=10, **triple())
    assert told == []
    assert (domain.hole_count, domain.polygon.area) == (0, 10000)
    assert domain.notes[0].startswith(
        "land.geojson: 1 gap where several neighbours meet closed, the widest (0.41) at (50"
    )
    assert domain.notes[0].endswith(", now a part of 'a'")


def test_a_gap_that_no_join_closes_without_the_loss_of_a_feature_names_smallest(written):
    """A spot outside would fall onto a border as near as the gap is wide."""
    shapes = triple() | {"d": shapely.box(100.3, 20, 110, 40), "spot": shapely.box(10, -0.43, 10.05, -0.4)}
    (text,), _ = gap_warnings(written, spacing=10, **shapes)
    smallest = re.search(r": set smallest: (\S+) to fill those that are holes$", text)[1]
    told, domain = gap_warnings(written, f", smallest: {smallest}", spacing=10, **shapes)
    assert (len(told), domain.hole_count, domain.polygon.area) == (1, 0, pytest.approx(10194))
    assert "1 narrow gap between regions stays open, the widest (0.3) between 'a' and 'd'" in told[0]
    with pytest.raises(GeometryError, match="nothing is left of 'spot' with this join: make it smaller"):
        gap_warnings(written, ", join: 0.5", spacing=10, **shapes)


def test_a_gap_where_three_meet_stays_if_it_is_wider_than_join_or_the_hole_of_one(written):
    assert gap_warnings(written, ", join: 0.3", spacing=10, **triple())[1].hole_count == 1
    shapes = triple() | {"a": triple()["a"].difference(shapely.box(10, 10, 10.2, 10.2))}
    assert gap_warnings(written, ", join: 0.5", spacing=10, **shapes)[1].hole_count == 1
    assert gap_warnings(written, spacing=1, **triple())[0] == []


def test_gaps_that_are_wide_beside_the_spacing_and_corners_between_regions_are_not_told(written):
    wedge = shapely.Polygon([(1, 0), (3, -0.8), (3, -0.4)])
    shapes = {"west": WEST, "east": EAST, "south": wedge, "north": NORTH}
    assert gap_warnings(written, **shapes)[0] == []
    shapes = {"west": WEST, "east": shapely.box(1.003, 0, 3, 1)}
    assert len(gap_warnings(written, spacing=0.2, **shapes)[0]) == 1
    assert gap_warnings(written, spacing=0.012, **shapes)[0] == []


@pytest.mark.parametrize(("keys", "factor"), [("", 1), (", scale: 1000", 1000), (", units: mm", 1e-3)])
def test_short_edges_of_shared_borders_name_a_key_that_works(written, keys, factor):
    y = np.linspace(0, 2, 401)
    border = np.column_stack([1 + 0.02 * np.sin(9 * y) + 1e-3 * np.cos(400 * y), y])
    west = shapely.Polygon([*border, (0, 2), (0, 0)])
    east = shapely.Polygon([*border, (3, 2), (3, 0)])
    written("land.geojson", features(west=west, east=east))
    text = f"domain: {{{{regions: {{{{file: land.geojson, name: NAME{keys}{{}}}}}}}}}}\nspacing: {0.4 * factor}\n"
    before = prepare(load_case(written("case.yaml", text.format(""))))
    (key,) = [re.search(r"\((simplify: \S+) in the file", note)[1] for note in before.warnings if "simplify" in note]
    after = prepare(load_case(written("case.yaml", text.format(f", {key}"))))
    assert after.expected_nodes < before.expected_nodes / 3
    assert not any("simplify" in note for note in after.warnings)
    assert sum(sizes(after.domain).values()) == pytest.approx(6 * factor**2, rel=1e-9)


def test_gaps_around_all_regions_are_told_with_a_join_that_makes_them_one_piece(written):
    boxes = {f"box {i}{j}": shapely.box(i + 2e-3, j + 2e-3, i + 1, j + 1) for i in range(3) for j in range(2)}
    (text,), domain = gap_warnings(written, **boxes)
    assert domain.piece_count == 6
    join = re.search(r"set join: (\S+) to close", text)[1]
    told, domain = gap_warnings(written, f", join: {join}", **boxes)
    assert told == []
    assert (domain.piece_count, domain.hole_count) == (1, 0)


@pytest.mark.parametrize("how", ["", ", smooth: true", ", tolerance: 0.02", ", tolerance: 0.02, smooth: true"])
def test_borders_are_followed_as_curves_that_neighbours_share(written, how):
    y, t = np.linspace(0, 2, 201), np.linspace(0, 2 * np.pi, 121)
    border = np.column_stack([1 + 0.1 * np.sin(3 * y), y])
    lake = np.column_stack([2 + 0.3 * np.cos(t), 1 + 0.3 * np.sin(t)])
    shapes = {
        "west": shapely.Polygon([*border, (0, 2), (0, 0)]),
        "east": shapely.Polygon([*border, (3, 2), (3, 0)], [lake]),
        "isle": shapely.Polygon(np.roll(lake[:-1], 40, axis=0)[::-1]),
        "north": shapely.Polygon([(0, 2), border[-1], (3, 2), (3, 3), (0, 3)]),
    }
    written("land.geojson", features(**shapes))
    text = f"domain: {{regions: {{file: land.geojson, name: NAME, corners: 30{how}}}}}\nspacing: 0.15\n"
    problem = prepare(load_case(written("case.yaml", text)))
    domain = problem.domain
    assert domain.polygon.area == pytest.approx(9, rel=1e-9)
    assert sum(sizes(domain).values()) == pytest.approx(9, rel=1e-9)
    assert len(domain.boundary.corners) == (9 if "tolerance" not in how else 30)  # of 327 vertices
    assert problem.expected_nodes < 700


def test_vertices_next_to_others_of_a_ring_are_left_out_and_told(found):
    """A domain could not have them; drawing by hand and rounding of coordinates leave them."""
    slip = shapely.Polygon([(0, 0), (1, 0), (1, 1), (1 + 2e-7, 1 + 3e-7), (1, 2), (0, 2), (-5, 2 + 1e-8)])
    domain = found(LAND, west=slip, east=shapely.box(1, 0, 3, 1))
    assert sizes(domain)["west"] == pytest.approx(shapely.Polygon([(0, 0), (1, 0), (1, 2), (-5, 2)]).area, abs=1e-5)
    assert [note for note in domain.notes if "next to others of the same ring left out of 'west'" in note]


def test_parts_thinner_than_a_domain_can_have_are_left_out(found):
    sliver = shapely.Polygon([(5, 5), (6, 6), (6, 6 + 1e-7)])
    assert sizes(found(LAND, west=shapely.MultiPolygon([WEST, sliver]), east=EAST)) == {"west": 2, "east": 2}


def test_a_join_closes_what_a_domain_could_not_have(found):
    """However narrow it is: gaps below 1e-6 of the size would be refused."""
    east = shapely.Polygon([(1 + 1e-7, 0), (3, 0), (3, 1), (1 + 1.5e-6, 1)])
    domain = found(LAND.replace("}", ", join: 2e-7}", 1), west=WEST, east=east)
    assert shapely.coverage_is_valid([region.polygon for region in domain.parts.regions])


def test_tiny_overlaps_are_cut_whatever_the_join(found):
    west = shapely.Polygon([(0, 0), (1, 0), (1, 0.5), (1.00002, 0.50001), (1, 0.50002), (1, 2), (0, 2)])
    east = shapely.Polygon([(1, 0), (3, 0), (3, 1), (1, 1), (1, 0.50002), (1, 0.5)])
    domain = found(LAND.replace("}", ", join: 0.01}", 1), west=west, east=east)
    assert sum(sizes(domain).values()) == pytest.approx(domain.polygon.area, rel=1e-9)


def test_holes_that_leave_a_region_are_told_with_what_mends_them(found):
    west = shapely.Polygon(
        WEST.exterior, [[(0.5, 0.5), (0.8, 0.5), (0.8, 0.8)], [(0.6, 0.55), (0.9, 0.55), (0.9, 0.9)]]
    )
    told = re.escape("holes of region 'west' cross its ring or each other at (0.8, 0.55): move them; repair: true in ")
    with pytest.raises(GeometryError, match=told):
        found(LAND, west=west, east=EAST)


def test_what_is_to_be_done_after_a_repair_is_told_too(found):
    bow = shapely.Polygon([(0, 0), (1, 0), (0, 2), (1, 2)])
    with pytest.raises(GeometryError) as error:
        found(LAND, west=bow, east=shapely.box(0.99, 0, 3, 1))
    assert "crosses or touches itself" in str(error.value)
    assert re.search(r"; repair: true in domain.regions.0 mends it, and then: .* set join: ", str(error.value))


ORDERED = LAND.replace("{regions", "{overlaps: later, regions")


def test_later_features_cover_earlier_ones(found):
    domain = found(
        ORDERED, west=shapely.box(0, 0, 2, 2), bar=shapely.box(-1, 0.5, 3, 1), east=shapely.box(1.5, 0, 3, 2)
    )
    areas = {}
    for region in domain.parts.regions:
        areas[region.name] = areas.get(region.name, 0) + region.polygon.area
    assert areas == pytest.approx({"west": 1.5 * 2 - 1.5 * 0.5, "bar": 2.5 * 0.5, "east": 3})


def test_drawn_regions_cover_features_which_keep_their_order_and_their_domain(found):
    lake = "{name: lake, ring: {circle: {center: [1, 1], radius: 0.5}}}"
    text = ORDERED.replace("regions: {", "regions: [{").replace("}}", f"}}, {lake}]}}", 1)
    domain = found(text, west=WEST, east=EAST)
    assert domain.parts.names[1:] == ("west", "east", "lake")
    assert domain.polygon.area == pytest.approx(shapely.union_all([WEST, EAST]).area)
    assert len(domain.polygon.interiors) == 0


def test_slivers_up_to_join_are_closed_where_later_features_cover(found):
    text = ORDERED.replace("}", ", join: 0.01}", 1)
    domain = found(text, west=shapely.box(0, 0, 0.995, 2), east=EAST, top=shapely.box(0.5, 1, 2, 2))
    assert domain.polygon.area == pytest.approx(sum(region.polygon.area for region in domain.parts.regions))
    assert len(domain.polygon.interiors) == 0


def test_a_feature_that_later_ones_cover_is_told(found):
    with pytest.raises(
        GeometryError, match=r"nothing is left of region 'west' at .*: 'east', which comes later, covers"
    ):
        found(ORDERED, west=WEST, east=shapely.box(-1, -1, 3, 3))


@pytest.mark.parametrize("name", ["phases.png", "PHASES.TIF", "phases.npy"])
def test_a_picture_as_regions_leads_to_the_program_that_makes_polygons(name):
    with pytest.raises(
        FileError, match=r'is not read: rasterio.features.shapes makes polygons .* "Images with labels" in'
    ):
        read_regions(Path(name), Selection(), "phase")
    assert "**Images with labels.**" in (Path(__file__).parents[2] / "docs/regions.md").read_text()


def phases():
    """A disc of pixels in a picture of 30 by 20, and parts that reach its frame near a corner."""
    y, x = np.indices((20, 30)) + 0.5
    cells, disc = shapely.box(x - 0.5, y - 0.5, x + 0.5, y + 0.5), np.hypot(x - 15, y - 10) < 6
    beside = [shapely.box(0, 3, 2, 8), shapely.box(3, 0, 8, 2)]
    rest = shapely.coverage_union_all(cells[~disc]) - shapely.union_all(beside)
    return {"disc": shapely.coverage_union_all(cells[disc]), "a": beside[0], "b": beside[1], "rest": rest}


@pytest.mark.parametrize("length", [1, 2, 5, 20])
def test_simplify_keeps_the_frame_and_tells_areas_that_change(found, length):
    shapes = phases()
    domain = found(LAND.replace("NAME}", f"NAME, simplify: {length}}}"), **shapes)
    assert domain.polygon.area == pytest.approx(600, abs=1e-9)
    assert {(0.0, 0.0), (30.0, 0.0), (30.0, 20.0), (0.0, 20.0)} <= set(map(tuple, domain.boundary.corners.tolist()))
    areas = dict.fromkeys(shapes, 0.0)
    for region in domain.parts.regions:
        areas[region.name] += region.polygon.area
    notes = [note for note in domain.notes if "simplify changes the areas of regions: " in note]
    change = areas["disc"] / shapes["disc"].area - 1
    assert len(notes) == (abs(change) >= 0.01)
    if notes:
        assert f"'disc' from {shapes['disc'].area:g} to {areas['disc']:.6g} ({change:+.1%})" in notes[0]
