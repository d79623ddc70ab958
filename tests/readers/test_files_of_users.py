"""Files as programs that people use write them, made anew: each gets in, or is told what to do."""

import json
import math

import numpy as np
import pytest
from geometry_files import area, domain, labels_of

from bubblemesh.case import load_case
from bubblemesh.errors import BubblemeshError
from bubblemesh.problem.domain import case_domain
from bubblemesh.problem.regions import largest_areas
from bubblemesh.readers.formats import read_regions
from bubblemesh.readers.lines_and_points import read_points
from bubblemesh.readers.selection import Selection

INKSCAPE = """<?xml version="1.0" encoding="UTF-8" standalone="no"?>
<svg width="210mm" height="297mm" viewBox="0 0 210 297" id="svg5" inkscape:version="1.2"
 xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" xmlns:xlink="http://www.w3.org/1999/xlink"
 xmlns:sodipodi="http://sodipodi.sourceforge.net/DTD/sodipodi-0.dtd" xmlns="http://www.w3.org/2000/svg">
<sodipodi:namedview id="view7" inkscape:document-units="mm"><inkscape:grid id="grid9"/></sodipodi:namedview>
<defs id="defs2"><inkscape:path-effect effect="fillet_chamfer" id="pe1"/></defs>
<g inkscape:label="Layer 1" inkscape:groupmode="layer" id="layer1" transform="translate(0,10)">
<path id="path1" style="fill:none;stroke:#000" d="m 20,30 h 120 v 80 H 20 Z" inkscape:label="plate"/>
<circle style="fill:#f00" id="path2" cx="45" cy="60" r="10" inkscape:label="bore"/>
<use x="0" y="0" xlink:href="#path2" id="use1" transform="translate(35,15)"/></g>
<g inkscape:groupmode="layer" id="layer2" inkscape:label="Dimensions">
<path style="fill:none;stroke:#000" d="M 20,130 H 140" id="p9"/><text x="70" y="136"><tspan>120</tspan></text></g>
</svg>"""
ILLUSTRATOR = """<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd" [
<!ENTITY ns_svg "http://www.w3.org/2000/svg"><!ENTITY ns_xlink "http://www.w3.org/1999/xlink">]>
<svg version="1.1" id="Ebene_1" xmlns="&ns_svg;" xmlns:xlink="&ns_xlink;" x="0px" y="0px" viewBox="0 0 300 300">
<style type="text/css">.st0{clip-path:url(#SVGID_00000047776_);} .st1{fill:#E30613;} .st2{fill-rule:evenodd;}</style>
<g><defs><rect id="SVGID_1_" x="50" y="50" width="200" height="200"/></defs>
<clipPath id="SVGID_00000047776_"><use xlink:href="#SVGID_1_" style="overflow:visible;"/></clipPath>
<g class="st0"><path class="st1" d="M150,0L300,150L150,300L0,150z"/>
<path class="st2" d="M120,100h60v80h-60V100z M140,120v40h20v-40H140z"/></g></g></svg>"""
SYMBOLS = """<svg xmlns="http://www.w3.org/2000/svg" width="4in" height="3in" viewBox="0 0 400 300">
<defs><symbol id="bolt" viewBox="-10 -10 20 20"><polygon points="10,0 0,10 -10,0 0,-10"/></symbol>
<g id="corner"><use href="#bolt" width="20" height="20" x="-10" y="-10"/></g></defs>
<rect id="flange" x="10" y="10" width="380" height="280"/>
<g fill="white"><use href="#corner" x="50" y="50"/><use href="#corner" transform="translate(350 50) rotate(30)"/></g>
<ellipse cx="50%" cy="50%" rx="25%" ry="60" fill="white"/></svg>"""
LAKE = [(13.3 + 0.02 * math.cos(t), 52.5 + 0.01 * math.sin(t), 34.0) for t in np.linspace(0, 2 * np.pi, 61)]
ISLAND = [(13.3 + 0.004 * math.cos(t), 52.5 - 0.002 * math.sin(t), 34.0) for t in np.linspace(0, 2 * np.pi, 31)]
NODES = (
    "# a.node\n8 2 1 1\n0 0 0 1.5 1\n1 4 0 1.5 1\n2 4 3 1.5 2\n3 0 3 1.5 2\n"
    "4 1 1 0 3\n5 2 1 0 3\n6 2 2 0 3\n7 1 2 0 3\n"
)
POLY = (
    "# with a.node\n0 2 1 1\n8 1\n0 0 1 1\n1 1 2 2\n2 2 3 1\n3 3 0 2\n"
    "4 4 5 3\n5 5 6 3\n6 6 7 3\n7 7 4 3\n1\n0 1.5 1.5\n"
)
HALVES = (
    "6 2 0 0\n1 0 0\n2 2 0\n3 2 1\n4 0 1\n5 1 0\n6 1 1\n7 0\n1 1 5\n2 5 2\n3 2 3\n4 3 6\n5 6 4\n6 4 1\n7 5 6\n0\n"
    "2\n1 0.5 0.5 10 0.005\n2 1.5 0.5 20 -1\n"
)


def shoelace(points):
    x, y = np.array(points)[:, :2].T
    return abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2


def lake(crs=None, *more):
    shape = {"type": "MultiPolygon", "coordinates": [[LAKE, ISLAND]]}
    features = [{"type": "Feature", "properties": {"fid": 1, "name": "See"}, "geometry": shape}, *more]
    head = {"crs": {"type": "name", "properties": {"name": crs}}} if crs else {}
    return json.dumps({"type": "FeatureCollection", "name": "seen", **head, "features": features})


def drawing(path, version):
    """A plate with rounded corners, two slots by a block, and what is off, frozen, or a note."""
    ezdxf = pytest.importorskip("ezdxf")
    document = ezdxf.new(version)
    if version != "R12":
        document.header["$INSUNITS"] = 4
    for name in ("CUT", "ENGRAVE", "OLD", "COLD"):
        document.layers.add(name)
    document.layers.get("OLD").off()
    document.layers.get("COLD").freeze()
    space, cut = document.modelspace(), {"layer": "CUT"}
    quarter = math.tan(math.pi / 8)
    outline = [(0, 0, 0), (100, 0, quarter), (110, 10, 0), (110, 60, quarter), (100, 70, 0), (0, 70, 0)]
    plain = version == "R12"
    (space.add_polyline2d if plain else space.add_lwpolyline)(outline, format="xyb", close=True, dxfattribs=cut)
    block = document.blocks.new("SLOT")
    block.add_line((-5, -2), (5, -2))
    block.add_arc((5, 0), 2, 270, 90)
    block.add_line((5, 2), (-5, 2))
    block.add_arc((-5, 0), 2, 90, 270)
    space.add_blockref("SLOT", (30, 20), dxfattribs=cut)
    space.add_blockref("SLOT", (85, 45), dxfattribs={**cut, "rotation": 90})
    space.add_circle((20, 50), 6, dxfattribs={"layer": "OLD"})
    space.add_circle((60, 50), 6, dxfattribs={"layer": "COLD"})
    space.add_line((0, 35), (110, 35), dxfattribs={"layer": "ENGRAVE"})
    space.add_text("M6", dxfattribs={"layer": "ENGRAVE", "insert": (50, 60)})
    if not plain:
        space.add_ellipse((20, 50), (8, 0), 0.5, dxfattribs=cut)
        space.add_spline(fit_points=[(60, 25), (68, 30), (64, 36), (58, 33), (60, 25)], dxfattribs=cut)
    document.saveas(path)
    return path


class TestDrawings:
    def test_inkscape(self, written):
        path = written("bracket.svg", INKSCAPE)
        with pytest.raises(
            BubblemeshError, match=r"set open: skip, which leaves out what forms no ring \(3 rings stay\)"
        ):
            domain(path)
        assert area(path, open="skip") == pytest.approx(9600 - 200 * np.pi, rel=1e-4)
        assert area(path, open="skip", unit="mm") == pytest.approx((9600 - 200 * np.pi) * 1e-6, rel=1e-4)
        assert labels_of(path, open="skip") == [["plate"], ["bore"], ["bore"]]

    def test_illustrator(self, written):
        path = written("logo.svg", ILLUSTRATOR)
        with pytest.raises(BubblemeshError, match="choose by part: largest"):
            domain(path)
        whole = 2 * 150**2 - 4 * 50**2
        assert area(path, part="largest") == pytest.approx(whole - 60 * 80)
        assert area(path, part="all") == pytest.approx(whole - 60 * 80 + 20 * 40)

    def test_symbols(self, written):
        path = written("flange.svg", SYMBOLS)
        assert area(path) == pytest.approx(380 * 280 - 400 - np.pi * 6000, rel=1e-3)
        assert labels_of(path) == [["flange"], ["corner"], ["corner"], ["None"]]

    @pytest.mark.parametrize("version", ["R12", "R2018"])
    def test_autocad(self, tmp_path, version):
        path = drawing(tmp_path / "plate.dxf", version)
        with pytest.raises(BubblemeshError) as error:
            domain(path)
        assert "set open: skip, which leaves out" in str(error.value)
        assert "layers that close by themselves: CUT: choose by layer: CUT" in str(error.value)
        plate = 110 * 70 - (2 - np.pi / 2) * 100 - 2 * (40 + 4 * np.pi)
        found = domain(path, layers=("CUT",))
        assert found.hole_count == (2 if version == "R12" else 4)
        inside = [0] if version == "R12" else [np.pi * 32, 84.9]  # the ellipse, and the spline as ezdxf flattens it
        assert found.polygon.area == pytest.approx(plate - sum(inside), rel=2e-3)
        assert labels_of(path, layers=("CUT",)) == [["CUT"]] * (1 + found.hole_count)


class TestMaps:
    @pytest.mark.parametrize("crs", ["urn:ogc:def:crs:OGC:1.3:CRS84", None])
    def test_qgis(self, written, crs):
        gauge = {"type": "Point", "coordinates": [13.3, 52.49, 33.1]}
        line = {"type": "LineString", "coordinates": [[13.29, 52.49, 1], [13.31, 52.49, 1]]}
        both = {"type": "GeometryCollection", "geometries": [gauge, line]}
        beside = {"type": "Feature", "properties": {"fid": 2, "name": None}, "geometry": both}
        empty = {"type": "Feature", "properties": {"fid": 3, "name": None}, "geometry": None}
        path = written("lake.geojson", lake(crs, beside, empty))
        found = domain(path)
        assert found.polygon.area == pytest.approx(shoelace(LAKE) - shoelace(ISLAND))
        assert any("left out: 1 line, 1 point, 1 empty feature" in note for note in found.notes)
        assert read_points(path, Selection(), None)[0][0].at == (13.3, 52.49)

    def test_openstreetmap(self, written):
        wood = {"type": "Feature", "id": "way/5", "properties": {"@id": "way/5"}, "geometry": {"type": "Polygon"}}
        wood["geometry"]["coordinates"] = [ISLAND[::-1]]
        path = written("osm.geojson", lake(None, wood))
        with pytest.raises(BubblemeshError, match="choose by part: largest, part: all and repair: true for"):
            domain(path)
        assert area(path, part="largest") == pytest.approx(shoelace(LAKE) - shoelace(ISLAND))

    @pytest.mark.parametrize(
        ("content", "told"),
        [
            (
                {"version": 0.6, "elements": [{"type": "way", "id": 1}]},
                "what OpenStreetMap's Overpass writes, no GeoJSON",
            ),
            (
                {"geometryType": "esriGeometryPolygon", "features": [{"attributes": {}}]},
                "what ArcGIS writes, no GeoJSON",
            ),
            ({"version": "5.2", "shapes": []}, "what labelme writes, no GeoJSON"),
        ],
    )
    def test_other_json_is_told_as_such(self, written, content, told):
        with pytest.raises(BubblemeshError, match=told):
            domain(written("a.json", json.dumps(content)))

    @pytest.mark.parametrize(
        ("name", "told"),
        [
            ("site.kml", "convert it by ogr2ogr site.geojson site.kml, or export it from QGIS; the name must end in"),
            ("part.STEP", "export its outline as part.dxf from a drawing program"),
            ("logo.ai", "export it as logo.svg"),
            ("scan.png", "trace its outlines to scan.svg"),
        ],
    )
    def test_formats_that_are_not_read_are_told_what_converts_them(self, written, name, told):
        with pytest.raises(BubblemeshError, match=told):
            domain(written(name, ""))

    def test_shapefile_and_geopackage(self, tmp_path):
        pytest.importorskip("pyogrio")
        import shapely
        from pyogrio.raw import write

        shapes = [shapely.Polygon(LAKE, [ISLAND]), shapely.LineString(LAKE[:9])]
        wkb = [shapely.to_wkb(np.array([shapely.force_2d(one)])) for one in shapes]
        named = {"fields": ["NAME"], "crs": "EPSG:4326"}
        write(
            tmp_path / "a.shp",
            wkb[0],
            [np.array(["Größe"], object)],
            geometry_type="Polygon",
            encoding="UTF-8",
            **named,
        )
        assert labels_of(tmp_path / "a.shp")[0] == ["Größe"]
        for k, (kind, layer) in enumerate([("Polygon", "lakes"), ("LineString", "roads")]):
            data = [np.array(["a"], object)]
            write(tmp_path / "a.gpkg", wkb[k], data, geometry_type=kind, layer=layer, append=k > 0, **named)
        with pytest.raises(BubblemeshError, match=r"has 2 layers \(lakes, roads\): choose one by layer"):
            domain(tmp_path / "a.gpkg")
        assert area(tmp_path / "a.gpkg", layers=("lakes",)) == pytest.approx(area(tmp_path / "a.shp"))

    def test_empty_shapes_of_a_database(self, written):
        shape = "SRID=25833;MULTIPOLYGON Z (((0 0 1, 9 0 1, 9 8 1, 0 8 1, 0 0 1), (2 2 1, 4 2 1, 4 4 1, 2 2 1)))"
        path = written("a.wkt", f"POLYGON EMPTY\n{shape}\nGEOMETRYCOLLECTION EMPTY\nPOINT EMPTY\n")
        assert area(path) == 70
        assert any("left out: 3 empty features" in note for note in domain(path).notes)


class TestMeshers:
    def test_triangle(self, written):
        written("a.node", NODES)
        path = written("a.poly", POLY)
        assert area(path) == 11
        assert labels_of(path) == [["1", "2"], ["3"]]

    @pytest.mark.parametrize(("keys", "limit"), [("", 0.005), (", largest: 0.02", 0.02), (", scale: 10", 0.5)])
    def test_areas_that_triangle_limits_hold_unless_others_are_given(self, written, keys, limit):
        written("a.poly", HALVES)
        text = f"domain: {{regions: {{file: a.poly, name: attribute{keys}}}}}\nspacing: 0.5\n"
        case = load_case(written("case.yaml", text))
        found = case_domain(case)
        limits = largest_areas(case, found)
        assert limits["10"] == pytest.approx(limit)
        assert limits.get("20") == (0.02 if keys == ", largest: 0.02" else None)
        told = "a.poly: largest areas of triangles are those of the file in 1 region (0.005)"
        assert (told in found.notes) == ("largest" not in keys)

    def test_areas_of_regions_in_one_are_the_smallest(self, written):
        path = written("a.poly", HALVES.replace("20 -1", "10 0.002"))
        assert {one.largest for one in read_regions(path, Selection(), "attribute")} == {0.002}

    def test_airfoil_with_remarks(self, written):
        x = (1 - np.cos(np.linspace(0, np.pi, 31))) / 2
        y = 0.6 * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1015 * x**4)
        points = [*zip(x[::-1], y[::-1], strict=True), *zip(x[1:], -y[1:], strict=True)]
        rows = "\n".join(f" {a:.6f} {b: .6f}" for a, b in points)
        path = written("foil.dat", f"# made for a test\n! a remark\nNACA 0012 AIRFOIL\n{rows}\n\n# end\n")
        assert area(path) == pytest.approx(0.0821, rel=1e-3)
