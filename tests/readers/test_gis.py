"""Rings and domains from shapefiles and GeoPackages."""

import numpy as np
import pytest
from geometry_files import WKT, area, domain, labels_of

from bubblemesh.errors import CaseError


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
