"""Metrics of rasters, by names in expressions and by files with all entries."""

import json

import numpy as np
import pytest

from bubblemesh import load_case, mesh_case
from bubblemesh.errors import BubblemeshError
from bubblemesh.problem.prepare import prepare

X, Y = np.linspace(0, 1, 21), np.linspace(0, 1, 11)
ACROSS = 0.05 + 0.1 * X
M11, M22 = np.tile(ACROSS**-2, (11, 1)), np.full((11, 21), 0.2**-2.0)


def case_with(tmp_path, metric, spacing=0.2, **keys):
    path = tmp_path / "case.yaml"
    data = {"domain": {"outer": {"rectangle": [0, 0, 1, 1]}}, "spacing": spacing, "metric": metric} | keys
    path.write_text(json.dumps(data))
    return load_case(path)


def save(path, **arrays):
    np.savez(path, **({"x": X, "y": Y, "m11": M11, "m12": 0 * M11, "m22": M22} | arrays))


def require_wide_to_the_right(case):
    across, along, direction = prepare(case).spacing.axes(np.array([[0.1, 0.5], [0.95, 0.2]]))
    np.testing.assert_allclose(across, [0.06, 0.145], rtol=0.02)
    np.testing.assert_allclose(along, 0.2, rtol=1e-9)
    np.testing.assert_allclose(np.abs(direction), [[0, 1], [0, 1]], atol=1e-9)


def test_rasters_are_variables_of_a_metric(tmp_path):
    save(tmp_path / "m.npz")
    spacing = {"value": 0.2, "raster": [{"file": "m.npz", "name": name} for name in ("m11", "m22")]}
    require_wide_to_the_right(case_with(tmp_path, {"m11": "raster.m11", "m22": "raster.m22"}, spacing))
    sizes = {"value": 0.2, "raster": {"file": "m.npz", "name": "m11"}}
    require_wide_to_the_right(case_with(tmp_path, {"angle": "pi/2", "across": "raster.m11**-0.5"}, sizes))


def test_a_raster_that_is_not_there_is_told_with_the_key(tmp_path):
    with pytest.raises(BubblemeshError, match=r"metric\.m11: .*there is no raster 'a'"):
        prepare(case_with(tmp_path, {"m11": "raster.a", "m22": 100}))


def test_a_file_of_arrays_has_all_entries(tmp_path):
    save(tmp_path / "m.npz")
    case = case_with(tmp_path, {"file": "m.npz"})
    require_wide_to_the_right(case)
    assert mesh_case(case).report.quality["mean"] > 0.9


@pytest.mark.parametrize("missing", [None, "m11", "m12"])
def test_a_netcdf_file_has_all_entries_and_what_one_misses_all_miss(tmp_path, missing):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "m.nc", "w") as file:
        for name, values in {"x": X, "y": Y, "m11": M11, "m12": 0 * M11, "m22": M22}.items():
            file[name] = values
        for name in ("m11", "m12", "m22") if missing else ():
            file[name][3] = np.nan if name == missing else -1
        for name in ("x", "y"):
            file[name].make_scale(name)
        for name in ("m11", "m12", "m22"):
            file[name].dims[0].attach_scale(file["y"])
            file[name].dims[1].attach_scale(file["x"])
    case = case_with(tmp_path, {"file": "m.nc"})
    require_wide_to_the_right(case)
    assert any("9.1% of the values" in text for text in prepare(case).warnings) is bool(missing)


@pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")  # of rasterio's own
def test_bands_of_a_geotiff_are_read_by_their_names(tmp_path):
    rasterio = pytest.importorskip("rasterio")
    shape = {"width": 21, "height": 11, "count": 3, "dtype": "float64"}
    place = rasterio.transform.from_bounds(-0.025, -0.05, 1.025, 1.05, 21, 11)
    with rasterio.open(tmp_path / "m.tif", "w", driver="GTiff", transform=place, **shape) as file:
        for band, (name, values) in enumerate({"m22": M22, "m11": M11, "m12": 0 * M11}.items(), 1):
            file.write(values, band)
            file.set_band_description(band, name)
    require_wide_to_the_right(case_with(tmp_path, {"file": "m.tif"}))


def test_a_file_of_one_grid_is_no_metric(tmp_path):
    head = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 0.5\n"
    (tmp_path / "m.asc").write_text(head + "1 2\n3 4\n")
    with pytest.raises(BubblemeshError, match=r"metric: .*m\.asc: has one grid, and a metric takes three: write m11"):
        prepare(case_with(tmp_path, {"file": "m.asc"}))


@pytest.mark.parametrize(
    ("arrays", "keys", "match"),
    [
        ({"m11": np.where(X == 0.5, np.nan, M11)}, {}, r"metric: .*m\.npz: m11: is nan .*\(0\.5, 0\)"),
        ({"m22": -M22}, {}, r"metric: .*m\.npz: is not positive definite and finite at \(0, 0\)"),
        ({"m12": 1e5 + 0 * M11}, {}, r"metric: .*m\.npz: is not positive"),
        ({"m12": np.zeros((3, 3))}, {}, r"metric: .*m\.npz: m12: x: must be real numbers of shape \(3,\)"),
        ({}, {"name": "m11"}, r"metric: name: .*leave name out"),
    ],
)
def test_rasters_that_are_no_metric_are_refused_with_the_place(tmp_path, arrays, keys, match):
    save(tmp_path / "m.npz", **arrays)
    with pytest.raises(BubblemeshError, match=match):
        prepare(case_with(tmp_path, {"file": "m.npz", **keys}))


def test_arrays_without_places_have_bounds(tmp_path):
    np.savez(tmp_path / "m.npz", m11=M11, m12=0 * M11, m22=M22)
    with pytest.raises(BubblemeshError, match=r"metric: .*m\.npz: m11: ?has no arrays x and y with it: give bounds"):
        prepare(case_with(tmp_path, {"file": "m.npz"}))
    require_wide_to_the_right(case_with(tmp_path, {"file": "m.npz", "bounds": [-0.025, -0.05, 1.025, 1.05]}))


@pytest.mark.parametrize("bounds", [[5, 5, 6, 6], [0, -2, 1, -1]])
def test_a_raster_beside_the_domain_is_refused(tmp_path, bounds):
    np.savez(tmp_path / "m.npz", m11=M11, m12=0 * M11, m22=M22)
    with pytest.raises(BubblemeshError, match=r"metric: .*m\.npz: its grid, from \(.*\) to \(.*\), lies beside the"):
        prepare(case_with(tmp_path, {"file": "m.npz", "bounds": bounds}))


def test_bounds_are_for_arrays_only(tmp_path):
    (tmp_path / "m.vtu").write_text("")
    with pytest.raises(BubblemeshError, match=r"metric: bounds: .*m\.vtu is no file of arrays"):
        prepare(case_with(tmp_path, {"file": "m.vtu", "bounds": [0, 0, 1, 1]}))


def test_an_array_that_lacks_is_told(tmp_path):
    np.savez(tmp_path / "m.npz", x=X, y=Y, m11=M11)
    with pytest.raises(BubblemeshError, match=r"metric: .*m\.npz: has no array 'm12'"):
        prepare(case_with(tmp_path, {"file": "m.npz"}))


def test_numbers_that_are_not_there_in_a_raster_of_an_expression_are_told_with_the_place(tmp_path):
    save(tmp_path / "m.npz", m11=np.where(X > 0.7, np.nan, M11))
    spacing = {"value": 0.2, "raster": {"file": "m.npz", "name": "m11"}}
    with pytest.raises(
        BubblemeshError, match=r"spacing\.raster: .*m\.npz: m11: is nan in row 0, column 14 .*\(0\.7, 0\)"
    ):
        prepare(case_with(tmp_path, {"m11": "raster.m11", "m22": 100}, spacing))


@pytest.mark.parametrize(("width", "told"), [(0.5, "50%"), (1.0, None)])
def test_a_grid_that_leaves_out_a_part_of_the_domain_is_told(tmp_path, width, told):
    np.savez(tmp_path / "m.npz", m11=M11, m12=0 * M11, m22=M22)
    problem = prepare(case_with(tmp_path, {"file": "m.npz", "bounds": [0, 0, width, 1]}))
    found = [text for text in problem.warnings if "leaves out" in text]
    share = f"its grid leaves out about {told} of the domain: there the tensors at its nearest places count"
    assert [text.partition("m.npz: ")[2] for text in found] == ([] if told is None else [share])
