"""Rings and domains from shapefiles and GeoPackages."""

import socket
import sqlite3
from contextlib import closing

import numpy as np
import pytest
import shapely
from geometry_files import WKT, area, domain, labels_of

from bubblemesh.errors import CaseError
from bubblemesh.readers import read_regions
from bubblemesh.readers.selection import Selection


class TestGeographicFiles:
    """Shapefiles and GeoPackages."""

    @pytest.fixture
    def saved(self, tmp_path):
        pyogrio = pytest.importorskip("pyogrio")

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
        with pytest.raises(CaseError, match=r"has 2 layers \(land, lake\): choose one by layer"):
            domain(path)
        with pytest.raises(CaseError, match="no layer 'lakes': did you mean 'lake'"):
            domain(path, layers=("lakes",))

    def test_degrees_are_noted(self, saved):
        assert "coordinates are degrees and are taken" in domain(saved("a.gpkg", WKT, crs="EPSG:4326")).notes[0]

    def test_what_is_no_such_file_is_refused(self, written):
        pytest.importorskip("pyogrio")
        with pytest.raises(CaseError, match=r"a\.gpkg: not a valid GeoPackage: it does not begin as one: write"):
            domain(written("a.gpkg", "hello"))
        with pytest.raises(CaseError, match=r"a\.shp: not a valid shapefile: it does not begin as one: write"):
            domain(written("a.shp", "hello"))

    @pytest.mark.parametrize("size", [50, 110, -8])
    @pytest.mark.parametrize("ending", [".shp", ".shx"])
    def test_a_part_that_is_cut_off_is_refused(self, saved, ending, size):
        path = saved("a.shp", WKT, "POLYGON ((10 10, 12 10, 12 12, 10 10))")
        part = path.with_suffix(ending)
        part.write_bytes(part.read_bytes()[:size])
        with pytest.raises(CaseError, match=rf"not a valid shapefile: its \{ending} is cut off, at .*: write it anew"):
            domain(path, feature=0)

    def test_a_part_of_another_shapefile_is_refused(self, saved):
        path = saved("a.shp", WKT, "POLYGON ((10 10, 12 10, 12 12, 10 10))")
        path.with_suffix(".shx").write_bytes(saved("b.shp", WKT).with_suffix(".shx").read_bytes())
        with pytest.raises(CaseError, match=r"not a valid shapefile: its \.shx is that of another \.shp: write"):
            domain(path)

    def test_a_shapefile_goes_by_its_name(self, saved):
        path = saved("a.shp", WKT)
        assert area(path, layers=("a",)) == pytest.approx(15)
        with pytest.raises(CaseError, match="no layer 'b'"):
            domain(path, layers=("b",))
        path.with_suffix(".dbf").unlink()
        assert area(path) == pytest.approx(15)
        with pytest.raises(CaseError, match=r"there is no \.dbf beside it, which holds the properties of its features"):
            read_regions(path, Selection(), "unit")
        assert len(read_regions(path, Selection(), "fid")) == 1
        path.with_suffix(".shx").unlink()
        with pytest.raises(CaseError, match=r"not a valid shapefile: there is no \.shx beside it"):
            domain(path)


@pytest.fixture
def server():
    """Address of a server, and the requests that it got."""
    with socket.create_server(("127.0.0.1", 0)) as listening:
        listening.settimeout(0.2)
        yield listening


VRT = """<OGRVRTDataSource><OGRVRTLayer name="a"><SrcDataSource>{}</SrcDataSource>
<GeometryType>wkbPolygon</GeometryType>
<GeometryField encoding="WKT" field="WKT"/></OGRVRTLayer></OGRVRTDataSource>"""


@pytest.mark.parametrize("name", ["a.gpkg", "a.shp"])
@pytest.mark.parametrize("other", ["secret.csv", "/vsicurl/http://127.0.0.1:{}/a.csv", "WFS:http://127.0.0.1:{}"])
def test_links_to_other_files_and_to_the_network_are_not_followed(written, server, name, other):
    pytest.importorskip("pyogrio")
    secret = written("secret.csv", "WKT,password\nsesame,1\n")
    other = other.replace("secret.csv", str(secret)).format(server.getsockname()[1])
    with pytest.raises(CaseError, match="it does not begin as one") as caught:
        domain(written(name, VRT.format(other)))
    assert "sesame" not in str(caught.value)
    with pytest.raises(TimeoutError):
        server.accept()


class TestDatabases:
    """What a GeoPackage can hold beside tables."""

    @pytest.fixture
    def package(self, tmp_path):
        pyogrio = pytest.importorskip("pyogrio")
        shape = np.array([shapely.to_wkb(shapely.from_wkt(WKT))], dtype=object)
        path = tmp_path / "a.gpkg"
        pyogrio.raw.write(
            path, geometry=shape, field_data=[], fields=[], geometry_type="Polygon", driver="GPKG", crs="EPSG:3857"
        )

        def changed(*statements):
            with closing(sqlite3.connect(path)) as database:
                database.create_function("ST_IsEmpty", 1, lambda shape: 0)
                database.executescript("; ".join(statements))
            return path

        return changed

    LISTED = (
        "INSERT INTO gpkg_contents SELECT 'v', data_type, 'v', '', last_change, min_x, min_y, max_x, max_y, srs_id"
        " FROM gpkg_contents",
        "INSERT INTO gpkg_geometry_columns SELECT 'v', column_name, geometry_type_name, srs_id, z, m"
        " FROM gpkg_geometry_columns",
    )

    def test_views_are_left_out(self, package):
        endless = (
            "CREATE VIEW v AS WITH RECURSIVE c(k) AS (SELECT 1 UNION ALL SELECT k + 1 FROM c)"
            " SELECT k AS fid, geom FROM c, a WHERE k < 0"
        )
        path = package(endless, *self.LISTED)
        assert area(path) == pytest.approx(15)
        with pytest.raises(CaseError, match="no layer 'v'"):
            domain(path, layers=("v",))

    def test_virtual_tables_are_refused(self, package):
        path = package(
            "PRAGMA writable_schema = ON",
            "INSERT INTO sqlite_master VALUES ('table', 'v', 'v', 0, 'CREATE VIRTUAL TABLE v USING VirtualOGR(s)')",
        )
        with pytest.raises(CaseError, match=r"table 'v' cannot be read \(no such module: VirtualOGR\): save the layer"):
            domain(path)

    def test_computed_columns_are_refused(self, package):
        path = package("ALTER TABLE a ADD COLUMN long AS (hex(zeroblob(400000000)))")
        with pytest.raises(CaseError, match="its table 'a' has columns that are computed: save the layer"):
            domain(path)

    def test_a_log_of_changes_is_part_of_the_file(self, package):
        path = package("PRAGMA journal_mode = WAL")
        assert area(path) == pytest.approx(15)
        path.with_name("a.gpkg-wal").write_bytes(b"1")
        with pytest.raises(CaseError, match="another program has not yet written all into it"):
            domain(path)

    @pytest.mark.parametrize("cut", [100, 5000, 90_000])
    def test_damaged_files(self, package, cut):
        path = package()
        path.write_bytes(path.read_bytes()[:cut])
        with pytest.raises(CaseError, match="not a valid GeoPackage: "):
            domain(path)

    def test_a_schema_that_is_no_text(self, package):
        path = package()
        before = path.read_bytes()
        path.write_bytes(before.replace(b'" = NEW."', b'"\xff\xff\xff\xffEW."'))
        assert path.read_bytes() != before
        with pytest.raises(CaseError, match="not a valid GeoPackage: "):
            domain(path)
