"""Grids with places: NetCDF, GeoTIFF, .asc and .xyz, the part around a box, missing values, damage."""

import h5py
import numpy as np
import pytest
from scipy.io import netcdf_file

from bubblemesh.errors import BubblemeshError, CaseError, FileError
from bubblemesh.readers.grids import grids
from bubblemesh.readers.grids.grids import filled_from_nearest, read_grid, system_of

pytestmark = pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")  # of rasterio's own
X, Y = np.linspace(-7, 2, 91), np.linspace(49, 57, 81)
BOX = (-3.05, 50.02, -1.96, 51.07)


def heights(x, y):
    return 100 * x + 7 * y


Z = heights(X[None], Y[:, None])


def classic(path, x=X, y=Y, z=Z, kind="f8", **attributes):
    with netcdf_file(path, "w") as file:
        for name, values in (("lon", x), ("lat", y)):
            file.createDimension(name, len(values))
            file.createVariable(name, "f8", (name,))[:] = values
        depth = file.createVariable("depth", kind, ("lat", "lon"))
        depth[:] = z
        for name, value in attributes.items():
            setattr(depth, name, value)


def records(path):
    with netcdf_file(path, "w") as file:
        for name, values in (("time", None), ("y", Y), ("x", X)):
            file.createDimension(name, None if values is None else len(values))
            file.createVariable(name, "f4", (name,))[:] = [0.0, 1.0] if values is None else values
        depth = file.createVariable("depth", "i2", ("time", "y", "x"))
        depth[0], depth[1] = 0 * Z, np.rint(Z - 0.5)
        depth.scale_factor, depth.add_offset = 1.0, 0.5


def version_4(path):
    with h5py.File(path, "w") as file:
        for name, values in (("lon", X), ("lat", Y)):
            file[name] = values
            file[name].make_scale(name)
        file["depth"] = Z.T
        for number, name in enumerate(("lon", "lat")):
            file["depth"].dims[number].attach_scale(file[name])


def ascii_grid(path):
    rows = "\n".join(" ".join(map(repr, row)) for row in Z[::-1].tolist())
    path.write_text(
        f"ncols 91\nnrows 81\nxllcorner {-7 - 0.05}\nyllcenter 49\ncellsize 0.1\nNODATA_value -9999\n{rows}\n"
    )


def triples(path):
    x, y = np.meshgrid(X, Y)
    np.savetxt(path, np.column_stack([x.ravel(), y.ravel(), Z.ravel()])[::-1], fmt="%.12g")


def geotiff(path, z=Z[::-1], **options):
    rasterio = pytest.importorskip("rasterio")
    across = rasterio.transform.from_origin(-7.05, 57.05, 0.1, 0.1)
    shape = {"height": 81, "width": 91, "count": 1, "dtype": "float64", "crs": "EPSG:4326", "transform": across}
    with rasterio.open(path, "w", driver="GTiff", **shape | options) as file:
        file.write(z.reshape(-1, 81, 91))


MAKERS = {"a.nc": classic, "b.nc": records, "c.nc": version_4, "d.asc": ascii_grid, "e.xyz": triples, "f.tif": geotiff}


def right(grid):
    """Whether the values are those of the places, to half a unit."""
    np.testing.assert_allclose(grid.values, heights(grid.x[None], grid.y[:, None]), atol=0.51)


@pytest.mark.parametrize("name", MAKERS)
def test_the_part_around_a_box_is_read(name, tmp_path):
    MAKERS[name](tmp_path / name)
    whole = read_grid(tmp_path / name, None, None)
    assert whole.values.shape == (81, 91)
    right(whole)
    part = read_grid(tmp_path / name, None, BOX)
    right(part)
    assert part.values.size < 400
    assert part.x.min() <= BOX[0] <= BOX[2] <= part.x.max()
    assert part.y.min() <= BOX[1] <= BOX[3] <= part.y.max()
    with pytest.raises(
        CaseError, match="its y coordinates are 49 to 57, those of the domain 70 to 71: they do not meet"
    ):
        read_grid(tmp_path / name, None, (0, 70, 1, 71))


@pytest.mark.parametrize("name", MAKERS)
def test_of_very_many_pixels_some_are_read(name, tmp_path, monkeypatch):
    MAKERS[name](tmp_path / name)
    monkeypatch.setattr(grids, "MOST_PIXELS", 500)
    grid = read_grid(tmp_path / name, None, (-6, 50, 1, 56))
    assert grid.step == 3
    assert 300 < grid.values.size < 900
    right(grid)


@pytest.mark.parametrize(("low", "high"), [(-7, -5), (-3, 1.5), (3, 5)])
def test_longitudes_from_0_to_360_are_turned(low, high, tmp_path):
    x = np.arange(0, 360, 0.5)
    classic(tmp_path / "a.nc", x, Y, heights((x[None] + 180) % 360 - 180, Y[:, None]))
    grid = read_grid(tmp_path / "a.nc", None, (low, 50, high, 51))
    right(grid)
    assert grid.x.min() <= low <= high <= grid.x.max()
    assert (np.diff(grid.x) > 0).all()


def test_longitudes_from_0_to_360_are_thinned_as_others(tmp_path, monkeypatch):
    monkeypatch.setattr(grids, "MOST_PIXELS", 500)
    x = np.arange(0, 360, 0.1)
    classic(tmp_path / "a.nc", x, Y, heights((x[None] + 180) % 360 - 180, Y[:, None]))
    grid = read_grid(tmp_path / "a.nc", None, (-6, 50, -1, 56))
    assert grid.step == 3
    assert grid.values.size < 900
    right(grid)


def test_rows_from_north_to_south_are_read(tmp_path):
    classic(tmp_path / "a.nc", X, Y[::-1], Z[::-1])
    right(read_grid(tmp_path / "a.nc", None, BOX))


def test_packed_values_are_unpacked_and_missing_ones_are_told(tmp_path):
    packed = np.rint(Z * 2).astype("i2")
    packed[:, 45:] = -32768
    classic(tmp_path / "a.nc", z=packed, kind="i2", scale_factor=0.5, _FillValue=np.int16(-32768))
    grid = read_grid(tmp_path / "a.nc", "depth", BOX)
    assert np.isnan(grid.values[:, grid.x > -2.45]).all()
    values, share = filled_from_nearest(grid.values)
    assert 0.3 < share < 0.7
    east = np.flatnonzero(grid.x < -2.55).max()
    np.testing.assert_array_equal(values[:, -1], grid.values[:, east])
    with pytest.raises(CaseError, match="has no values around the domain"):
        filled_from_nearest(np.full((3, 3), np.nan))


def test_values_of_geotiff_have_their_scale_and_offset(tmp_path):
    rasterio = pytest.importorskip("rasterio")
    z = np.round((Z[::-1] + 100) / 0.5)
    z[:, :30] = -9999
    geotiff(tmp_path / "a.tif", z, nodata=-9999)
    with rasterio.open(tmp_path / "a.tif", "r+") as file:
        file.scales, file.offsets = (0.5,), (-100.0,)
    grid = read_grid(tmp_path / "a.tif", None, None)
    assert np.isnan(grid.values[:, :30]).all()
    right(grid._replace(x=grid.x[30:], values=grid.values[:, 30:]))


def test_ascii_grids_have_no_value_at_9999_below_zero_unless_they_say_else(tmp_path):
    for said, missing in (("", 1), ("NODATA_value 7\n", 0)):
        (tmp_path / "a.asc").write_text(f"ncols 2\nnrows 1\ncellsize 1\n{said}-9999 5\n")
        assert np.isnan(read_grid(tmp_path / "a.asc", None, None).values).sum() == missing


def test_cells_of_ascii_grids_may_be_no_squares(tmp_path):
    (tmp_path / "a.asc").write_text("ncols 2\nnrows 2\nxllcorner 1\nyllcorner 0\ndx 2\ndy 0.5\n1 2\n3 4\n")
    grid = read_grid(tmp_path / "a.asc", None, None)
    np.testing.assert_array_equal([grid.x, np.sort(grid.y)], [[2, 4], [0.25, 0.75]])


def test_grids_of_gmt_are_netcdf(tmp_path):
    classic(tmp_path / "a.grd")
    right(read_grid(tmp_path / "a.grd", None, BOX))


def test_missing_values_of_geotiff_are_none(tmp_path):
    z = Z[::-1].copy()
    z[:, :30] = -9999
    geotiff(tmp_path / "a.tif", z, nodata=-9999, compress="deflate", tiled=True, blockxsize=16, blockysize=16)
    grid = read_grid(tmp_path / "a.tif", None, None)
    assert np.isnan(grid.values).mean() == pytest.approx(30 / 91)
    assert "WGS 84" in system_of(tmp_path / "a.tif")


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.asc", "hello", "does not begin with ncols, nrows and cellsize"),
        ("a.asc", "ncols 2\nnrows 2\ncellsize 1\n1 2 3\n", "has 3 values where 2 rows of 2 are told"),
        ("a.asc", "ncols 2\nnrows 1\ncellsize 1\n1 x\n", "has words where numbers are to be"),
        ("a.asc", "ncols two\n", "has 'two' where a number is to be"),
        ("a.xyz", "".join(f"{k} {k * k} 1\n" for k in range(9)), "is no grid: its points are not in rows and columns"),
        ("a.nc", "hello", "is no NetCDF file"),
        ("a.tif", "hello", "is no TIFF"),
    ],
)
def test_what_is_no_grid_is_told(name, content, message, tmp_path):
    if name.endswith("tif"):
        pytest.importorskip("rasterio")
    (tmp_path / name).write_text(content)
    with pytest.raises(BubblemeshError, match=message):
        read_grid(tmp_path / name, None, None)


def test_one_of_several_grids_is_named(tmp_path):
    classic(tmp_path / "a.nc")
    with pytest.raises(CaseError, match="has no grid 'height'"):
        read_grid(tmp_path / "a.nc", "height", None)
    with h5py.File(tmp_path / "b.nc", "w") as file:
        file["depth"] = Z
    with pytest.raises(CaseError, match="depth has no coordinates for its dimension"):
        read_grid(tmp_path / "b.nc", None, None)


def test_one_of_several_bands_of_a_geotiff_is_named(tmp_path):
    rasterio = pytest.importorskip("rasterio")
    geotiff(tmp_path / "a.tif", np.stack([Z[::-1] - 1000, Z[::-1], Z[::-1]]), count=3)
    with pytest.raises(CaseError, match=r"has 3 grids \(band_1, band_2, band_3\): choose one by name"):
        read_grid(tmp_path / "a.tif", None, BOX)
    with rasterio.open(tmp_path / "a.tif", "r+") as file:
        file.descriptions = ("error", "depth", None)
        file.scales, file.offsets = (1.0, 0.5, 1.0), (0.0, 3.0, 0.0)
    with pytest.raises(CaseError, match=r"has no grid 'deep': .*depth"):
        read_grid(tmp_path / "a.tif", "deep", BOX)
    for name in ("depth", "band_2"):
        grid = read_grid(tmp_path / "a.tif", name, BOX)
        right(grid._replace(values=(grid.values - 3) / 0.5))
        assert grid.name == name


def test_a_mask_is_no_band_to_choose(tmp_path):
    rasterio = pytest.importorskip("rasterio")
    geotiff(tmp_path / "a.tif", np.stack([Z[::-1], 0 * Z + 255]), count=2, alpha="yes", photometric="MINISBLACK")
    right(read_grid(tmp_path / "a.tif", None, BOX))
    with rasterio.open(tmp_path / "a.tif") as file:
        assert file.colorinterp[1].name == "alpha"


def test_complex_values_of_a_geotiff_are_refused(tmp_path):
    geotiff(tmp_path / "a.tif", Z[::-1] + 1j, dtype="complex64")
    with pytest.raises(CaseError, match=r"a does not hold real numbers \(found complex64\)"):
        read_grid(tmp_path / "a.tif", None, BOX)


@pytest.mark.parametrize("value", ["nan", "inf", "-inf", "0", "-2", "2.5"])
@pytest.mark.parametrize("key", ["ncols", "nrows", "cellsize", "xllcorner"])
def test_a_header_of_an_ascii_grid_that_means_nothing_is_told(key, value, tmp_path):
    head = {"ncols": "2", "nrows": "2", "xllcorner": "0", "cellsize": "1", key: value}
    lines = "\n".join(f"{name} {number}" for name, number in head.items())
    (tmp_path / "a.asc").write_text(f"{lines}\n1 2\n3 4\n")
    if key in {"nrows", "ncols"} or value in {"nan", "inf", "-inf"} or (key == "cellsize" and value != "2.5"):
        with pytest.raises(FileError, match=rf"{key}: must be .* \(found {value}\)"):
            read_grid(tmp_path / "a.asc", None, None)
    else:
        assert read_grid(tmp_path / "a.asc", None, None).values.shape == (2, 2)


@pytest.mark.parametrize("name", MAKERS)
def test_damage_is_told(name, tmp_path):
    MAKERS[name](tmp_path / name)
    whole, random = (tmp_path / name).read_bytes(), np.random.default_rng(0)
    refused = 0
    for count in range(100):
        content = bytearray(whole)
        for place in random.integers(500 if count % 2 else len(whole), size=1 + count % 3).tolist():
            content[place] = int(random.integers(256))
        (tmp_path / name).write_bytes(content[: int(random.integers(len(whole)))] if count % 5 == 0 else content)
        try:
            read_grid(tmp_path / name, None, BOX)
        except (FileError, CaseError):
            refused += 1
    assert refused > 20
