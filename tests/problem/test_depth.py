"""Depth of water: rasters as variables, sizes by waves, slope and Courant number, depth at nodes of the files."""

import json
from dataclasses import replace

import numpy as np
import pytest
from commands import command
from scipy.io import netcdf_file

from bubblemesh.api import Mesh
from bubblemesh.case import load_case
from bubblemesh.errors import CaseError
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.meshes.shores import cut_off, dead_ends
from bubblemesh.problem.prepare import prepare
from bubblemesh.run.pipeline import mesh_case

BASIN = {"outer": {"rectangle": [0, 0, 100e3, 50e3], "labels": ["land", "open", "land", "land"]}}
AT = np.array([[20e3, 10e3], [50e3, 25e3], [90e3, 40e3]])
GRAVITY = 9.81


def depth_at(x, y):
    return 10 + x / 1000


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    x, y = np.linspace(-1e3, 101e3, 103), np.linspace(-1e3, 51e3, 53)
    depth = depth_at(x[None], y[:, None]) + 0 * y[:, None]
    np.savez(tmp_path / "bed.npz", x=x, y=y, depth=depth, height=-depth)
    with netcdf_file(tmp_path / "bed.nc", "w") as file:
        for name, values in (("x", x), ("y", y)):
            file.createDimension(name, len(values))
            file.createVariable(name, "f8", (name,))[:] = values
        file.createVariable("depth", "f8", ("y", "x"))[:] = depth
    return tmp_path


def case(spacing, **keys):
    data = {"domain": BASIN, "spacing": spacing, "packing": {"effort": "fast"}}
    return load_case("bay.yaml", text=json.dumps(data | keys))


def spacing_of(**terms):
    file = {"raster": {"file": "bed.nc", "name": "depth"}}
    return prepare(case(file | terms)).spacing(AT)


def test_waves_have_so_many_nodes_in_their_length():
    found = spacing_of(waves={"depth": "depth", "period": 3600, "per_length": 20})
    np.testing.assert_allclose(found, np.sqrt(GRAVITY * depth_at(*AT.T)) * 3600 / 20, rtol=1e-9)


@pytest.mark.parametrize("deep", [10, 12.5])
def test_a_depth_may_be_a_number(deep):
    terms = {"period": 3600, "per_length": 20}
    found = prepare(case({"waves": terms | {"depth": deep}})).spacing(AT)
    np.testing.assert_allclose(found, np.sqrt(GRAVITY * deep) * 3600 / 20, rtol=1e-9)
    for output in ({"depth": deep}, {"depth": {"of": deep}}):
        np.testing.assert_array_equal(prepare(case(10e3, output=output)).task.depth.function(*AT.T), [deep] * 3)


@pytest.mark.parametrize(("value", "told"), [(True, "true"), ([10], "the list [10]"), ([], "the list []")])
def test_another_depth_is_refused_with_its_key(value, told, folder):
    message = f"must be a number or an expression (found {told})"
    keys = {
        "output.depth": {"spacing": 10e3, "output": {"depth": value}},
        "spacing.waves.depth": {"spacing": {"waves": {"depth": value, "period": 3600, "per_length": 20}}},
        "spacing.slope.depth": {"spacing": {"maximum": 1e4, "slope": {"depth": value, "per_slope": 20}}},
        "spacing.courant.depth": {"spacing": {"value": 1e4, "courant": {"depth": value, "dt": 10, "largest": 1}}},
    }
    for key, text in keys.items():
        (folder / "bay.yaml").write_text(json.dumps({"domain": BASIN} | text))
        assert command("check", "bay.yaml") == (2, "", f"error: bay.yaml:1: {key}: {message}\n")


def test_slopes_have_so_many_nodes():
    found = spacing_of(maximum=1e9, slope={"depth": "depth", "per_slope": 20, "filter": 4000})
    np.testing.assert_allclose(found, 2 * np.pi * depth_at(*AT.T) / (20 * 1e-3), rtol=1e-6)
    level = prepare(case({"maximum": 1e4, "slope": {"depth": "0 * x + 5", "per_slope": 20}})).spacing(AT)
    np.testing.assert_array_equal(level, 1e4)


def test_no_spacing_is_so_fine_that_the_courant_number_is_above_its_bound():
    found = spacing_of(value=500, courant={"depth": "depth", "dt": 30, "largest": 0.7})
    np.testing.assert_allclose(found, np.maximum(500, np.sqrt(GRAVITY * depth_at(*AT.T)) * 30 / 0.7))


def test_what_is_shallow_counts_as_the_shallowest():
    keys = {"depth": "-raster.depth", "period": 3600, "per_length": 20}
    np.testing.assert_allclose(spacing_of(waves=keys), np.sqrt(GRAVITY) * 180)
    np.testing.assert_allclose(spacing_of(waves=keys | {"shallowest": 4}), 2 * np.sqrt(GRAVITY) * 180)


@pytest.mark.parametrize("file", ["bed.nc", "bed.npz"])
def test_rasters_are_variables_of_expressions(file):
    terms = {"value": "1000 + 10 * raster.depth", "raster": {"file": file, "name": "depth"}}
    found = prepare(case(terms)).spacing(AT)
    np.testing.assert_allclose(found, 1000 + 10 * depth_at(*AT.T))


def test_a_raster_without_a_name_has_that_of_its_file():
    terms = {"value": "1000 + 10 * raster.bed", "raster": {"file": "bed.nc"}}
    np.testing.assert_allclose(prepare(case(terms)).spacing(AT), 1000 + 10 * depth_at(*AT.T))


def test_a_raster_that_nothing_names_is_a_spacing():
    terms = {"raster": {"file": "bed.nc", "name": "depth", "scale": 100}}
    np.testing.assert_allclose(prepare(case(terms)).spacing(AT), 100 * depth_at(*AT.T))


@pytest.mark.parametrize(
    ("terms", "message"),
    [
        ({"value": "raster.depth"}, r"spacing.value: .*there is no raster 'depth': give one under spacing.raster"),
        (
            {"value": "raster.deep", "raster": {"file": "bed.nc", "name": "depth"}},
            r"there is no raster 'deep': give one under",
        ),
        ({"value": "raster.depth.x", "raster": {"file": "bed.nc", "name": "depth"}}, "a dot between names"),
        ({"waves": {"depth": "depth", "period": 1, "per_length": 1}}, r"spacing.waves.depth: .*no raster 'depth'"),
        (
            {"value": "raster.depth", "raster": 2 * [{"file": "bed.nc", "name": "depth"}]},
            "'depth' is the name of another raster too",
        ),
        (
            {"value": "raster.depth", "raster": {"file": "bed.nc", "name": "depth", "bounds": [0, 0, 1, 1]}},
            "says itself where its pixels are: leave bounds and origin out",
        ),
        ({"value": "raster.other", "raster": {"file": "bed.nc", "name": "other"}}, "has no grid 'other'"),
    ],
)
def test_what_is_no_variable_is_refused(terms, message):
    with pytest.raises(CaseError, match=message):
        prepare(case(terms))


def test_missing_values_are_told():
    with netcdf_file("holes.nc", "w") as file:
        for name, values in (("x", np.linspace(0, 100e3, 11)), ("y", np.linspace(0, 50e3, 6))):
            file.createDimension(name, len(values))
            file.createVariable(name, "f8", (name,))[:] = values
        depth = file.createVariable("depth", "f8", ("y", "x"))
        depth[:] = 5.0
        depth[0, :3] = 1e37
    terms = {"value": "1000 * raster.depth", "raster": {"file": "holes.nc", "name": "depth"}}
    problem = prepare(case(terms))
    (told,) = [text for text in problem.warnings if "missing" in text]
    assert told == "holes.nc: 4.5% of the values around the domain are missing: nearest ones count"
    np.testing.assert_allclose(problem.spacing(AT), 5000)


# Depth at nodes

TIDE = {"depth": "depth", "period": "1 h", "per_length": 20}


@pytest.mark.parametrize("form", ["fort.14", "gr3", "2dm", "slf", "ugrid"])
def test_the_mesh_is_written_with_the_depth(form, folder):
    text = {"domain": BASIN, "spacing": {"value": 10e3, "raster": {"file": "bed.nc", "name": "depth"}}}
    (folder / "bay.yaml").write_text(json.dumps(text | {"output": {"formats": [form], "depth": "depth"}}))
    assert command("run", "bay.yaml", "-o", "out", "-q")[0] == 0
    (path,) = [path for path in (folder / "out").iterdir() if path.suffix in (".14", ".gr3", ".2dm", ".slf", ".nc")]
    mesh = Mesh.read(path)
    np.testing.assert_allclose(mesh.depth, depth_at(*mesh.points.T), rtol=1e-6)


def test_without_a_key_the_depth_is_that_of_the_terms():
    terms = {"raster": {"file": "bed.npz", "name": "height"}, "maximum": 10e3}
    waves = {"depth": "-raster.height", "period": 600, "per_length": 1}
    mesh = mesh_case(case(terms | {"waves": waves})).mesh
    np.testing.assert_allclose(mesh.depth, depth_at(*mesh.points.T))
    assert len(mesh_case(case(10e3)).mesh.depth) == 0
    given = mesh_case(case(10e3, output={"depth": "5 + 0.001 * y", "order": 2})).mesh
    np.testing.assert_allclose(given.depth, 5 + 0.001 * given.points[:, 1])


def cell_areas(mesh):
    corners = mesh.triangles[:, :3]
    return np.bincount(corners.ravel(), np.repeat(signed_areas(mesh.points, corners) / 3, 3), len(mesh.points))


@pytest.mark.parametrize("depth", ["depth", {"of": "depth"}, {"of": "depth", "over": "node"}, {"over": "node"}])
def test_depth_at_nodes_may_be_given_with_keys_or_without(depth):
    terms = {"value": 20e3, "raster": {"file": "bed.nc", "name": "depth"}, "waves": TIDE | {"period": 3600}}
    mesh = mesh_case(case(terms, output={"depth": depth})).mesh
    np.testing.assert_allclose(mesh.depth, depth_at(*mesh.points.T))


def test_depth_over_cells_holds_as_much_water_as_a_raster_that_is_finer(folder):
    x, y = np.arange(-100, 100e3 + 200, 200), np.arange(-100, 50e3 + 200, 200)
    ripples = 20 + 5 * (-1.0) ** np.arange(len(x))[None] + 0 * y[:, None]  # a pixel of 15, a pixel of 25
    ripples[y > 25e3] += 30
    np.savez(folder / "ripples.npz", x=x, y=y, depth=ripples)
    terms = {"value": 5e3, "raster": {"file": "ripples.npz", "name": "depth"}}
    at, over = (
        mesh_case(case(terms, output={"depth": {"of": "depth", "over": over}})).mesh for over in ("node", "cell")
    )
    areas = cell_areas(over)
    assert areas @ over.depth == pytest.approx(35 * 100e3 * 50e3, rel=1e-4)
    south, north = (over.points[:, 1] < 20e3), (over.points[:, 1] > 30e3)
    np.testing.assert_allclose(over.depth[south], 20, atol=0.3)
    np.testing.assert_allclose(over.depth[north], 50, atol=0.3)
    assert np.std(at.depth[south]) > 2


@pytest.mark.parametrize("order", [1, 2])
def test_means_of_linear_depths_are_those_at_the_middles_of_cells(order):
    mesh = mesh_case(case(10e3, output={"depth": {"of": "5 + 0.001 * y", "over": "cell"}, "order": order})).mesh
    corners = mesh.triangles[:, :3]
    n = corners.max() + 1
    areas = cell_areas(mesh)[:n]
    assert areas @ mesh.depth[:n] == pytest.approx(30 * 100e3 * 50e3, rel=1e-12)
    if order == 2:
        ends = corners[:, [1, 2]]
        np.testing.assert_allclose(mesh.depth[mesh.triangles[:, 4]], mesh.depth[ends].mean(axis=1))


def test_the_step_of_a_raster_in_degrees_is_that_on_the_ground(folder):
    pytest.importorskip("pyproj")
    x, y = np.linspace(-7, -4, 301), np.linspace(49, 51, 201)
    np.savez(folder / "sea.npz", x=x, y=y, depth=50 + 10 * (x[None] + 6) + 0 * y[:, None])
    keys = {
        "domain": {"outer": {"rectangle": [-6.5, 49.2, -4.5, 50.8], "label": "open"}},
        "crs": {"from": "EPSG:4326"},
        "spacing": {"value": "20 km", "raster": {"file": "sea.npz", "name": "depth"}},
        "output": {"depth": {"of": "depth", "over": "cell"}},
    }
    problem = prepare(load_case("sea.yaml", text=json.dumps(keys)))
    assert problem.task.depth.over == pytest.approx(0.01 * 111.3e3 * np.cos(np.radians(50)), rel=0.01)


@pytest.mark.parametrize(
    ("depth", "message"),
    [
        ({"over": "pixel"}, "output.depth.over: must be 'node' or 'cell'"),
        ({"of": "deep"}, "output.depth.*: .*deep"),
        ({"at": "cell"}, "output.depth.at: unknown key"),
    ],
)
def test_wrong_keys_of_the_depth_are_refused(depth, message):
    with pytest.raises(CaseError, match=message):
        prepare(case(1e4, output={"depth": depth}))


def test_depth_is_at_given_places(folder):
    pytest.importorskip("pyproj")
    x, y = np.linspace(-7, -4, 31), np.linspace(49, 51, 21)
    np.savez(folder / "sea.npz", x=x, y=y, depth=50 + 10 * (x[None] + 6) + 0 * y[:, None])
    keys = {
        "domain": {"outer": {"rectangle": [-6.5, 49.2, -4.5, 50.8], "label": "open"}},
        "crs": {"from": "EPSG:4326", "to": "EPSG:4326"},
        "spacing": {
            "waves": TIDE | {"per_length": 4},
            "maximum": "20 km",
            "raster": {"file": "sea.npz", "name": "depth"},
        },
    }
    result = mesh_case(load_case("sea.yaml", text=json.dumps(keys)))
    mesh = result.mesh
    np.testing.assert_allclose(mesh.depth, 50 + 10 * (mesh.points[:, 0] + 6), atol=1e-6)
    at = result.mesh.points[result.mesh.triangles].mean(axis=1)
    expected = np.minimum(np.sqrt(GRAVITY * (50 + 10 * (at[:, 0] + 6))) * 3600 / 4, 20e3)
    plane_scale = result.fields["target_spacing"] / expected
    assert np.abs(plane_scale - 1).max() < 2e-3


@pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")
@pytest.mark.parametrize(
    ("terms", "keys"),
    [
        ({"value": 0.2, "waves": {"depth": "-raster.deep", "period": 3600, "per_length": 20}}, {}),
        ({"value": 0.2}, {"output": {"depth": "-raster.deep"}}),
    ],
)
def test_a_raster_with_a_misspelt_name_is_not_taken_as_a_spacing(folder, terms, keys):
    np.savez(folder / "bed.npz", x=np.arange(3.0), y=np.arange(3.0), depth=np.full((3, 3), -5.0))
    terms |= {"raster": {"file": "bed.npz", "name": "depth"}}
    with pytest.raises(CaseError, match=r"depth: .*there is no raster 'deep'"):
        prepare(
            load_case(
                "sea.yaml", text=json.dumps({"domain": {"outer": {"rectangle": [0, 0, 2, 2]}}, "spacing": terms} | keys)
            )
        )


@pytest.mark.parametrize(
    "terms",
    [
        {"waves": TIDE | {"depth": "sea"}, "maximum": "20 km", "raster": {"file": "sea.tif"}},
        {"raster": {"file": "sea.tif", "scale": 500}},
    ],
    ids=["by name", "as a spacing"],
)
@pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")  # of rasterio's own
def test_a_grid_of_another_system_is_refused(folder, terms):
    rasterio, _ = pytest.importorskip("rasterio"), pytest.importorskip("pyproj")
    shape = {"height": 20, "width": 30, "count": 1, "dtype": "float32"}
    for system, west, fits in (("EPSG:4326", -7, True), ("EPSG:4258", -7, False), ("EPSG:32630", 4e5, False)):
        shape["transform"] = rasterio.transform.from_origin(west, 51, 0.1, 0.1)
        with rasterio.open(folder / "sea.tif", "w", driver="GTiff", crs=system, **shape) as file:
            file.write(np.full((20, 30), 40, np.float32), 1)
        keys = {
            "domain": {"outer": {"rectangle": [-6.5, 49.2, -4.5, 50.8]}},
            "crs": {"from": "EPSG:4326"},
            "spacing": terms,
        }
        case_of = load_case("sea.yaml", text=json.dumps(keys))
        if fits:
            assert prepare(case_of).survey.extremes.minimum > 3000
        else:
            with pytest.raises(
                CaseError, match=r"sea.tif: is in another system than crs.from: take it there by gdalwarp"
            ):
                prepare(case_of)


def test_what_is_missing_in_a_grid_is_told_whether_it_is_named_or_not(folder):
    rows = np.full((20, 30), 2e4)
    rows[5, 3:18] = -9999
    head = "ncols 30\nnrows 20\nxllcorner 0\nyllcorner 0\ncellsize 10000\nNODATA_value -9999\n"
    (folder / "bed.asc").write_text(head + "\n".join(" ".join(map(str, row)) for row in rows))
    raster, told = {"file": "bed.asc"}, "bed.asc: 2.5% of the values around the domain are missing: nearest ones count"
    for terms in ({"raster": raster}, {"value": "raster.bed", "raster": raster}):
        keys = {"domain": {"outer": {"rectangle": [0, 0, 3e5, 2e5]}}, "spacing": terms}
        assert told in prepare(load_case("sea.yaml", text=json.dumps(keys))).warnings


def test_the_report_tells_the_time_step_and_what_cannot_flow():
    result = mesh_case(case(5e3, output={"depth": "40 + 0*x", "open": "open"}))
    mesh, told = result.mesh, result.report["water"]
    edges = mesh.points[np.vstack([mesh.triangles[:, [0, 1]], mesh.triangles[:, [1, 2]], mesh.triangles[:, [2, 0]]])]
    shortest = np.hypot(*(edges[:, 1] - edges[:, 0]).T).min()
    assert told["time_step"] == pytest.approx(shortest / np.sqrt(GRAVITY * 40))
    assert list(told["depth"]) == [40, 40]
    assert 6 <= told["most_neighbours"] <= 8
    x, y = mesh.points.T
    closed = (y == 0) | (y == 50e3) | (x == 0)
    assert told["land_triangles"] == closed[mesh.triangles].all(axis=1).sum()
    assert mesh_case(case(10e3, output={"depth": "-1"})).report["water"]["time_step"] is None
    assert "water" not in mesh_case(case(10e3)).report


@pytest.mark.parametrize(("depth", "dry"), [("x/1000 - 90", 0.9), ("x/1000 - 30", 0.3), ("40", 0)])
def test_heights_taken_as_depths_are_told(depth, dry):
    report = mesh_case(case(5e3, domain=BASIN, output={"depth": depth})).report
    assert report["water"]["dry"] == pytest.approx(dry, abs=0.05)
    told = f"the depth is not above 0 at {report['water']['dry']:.0%} of the nodes, which are dry: it counts down"
    assert any(text.startswith(told) for text in report["warnings"]) == (dry > 0.5)


BOW_TIE = Mesh(  # two triangles and a third one that a point joins to them; the first is the sea's
    np.array([[0.0, 0], [1, 0], [1, 1], [0, 1], [2, 1], [2, 2]]),
    np.array([[0, 1, 2], [0, 2, 3], [2, 4, 5]]),
    np.array([[0, 1], [1, 2], [2, 3], [3, 0], [2, 4], [4, 5], [5, 2]]),
    np.array([1, 0, 0, 0, 0, 0, 0]),
    ("land", "open"),
)


def test_dead_ends_and_triangles_cut_off_are_counted():
    np.testing.assert_array_equal(dead_ends(BOW_TIE), [False, True, True])
    np.testing.assert_array_equal(cut_off(BOW_TIE), [False, False, True])
    closed = replace(BOW_TIE, labels=("land", "island"))
    np.testing.assert_array_equal(dead_ends(closed), [True, True, True])
    np.testing.assert_array_equal(cut_off(closed), [False, False, True])
    far = replace(BOW_TIE, facet_labels=np.array([0, 0, 0, 0, 0, 1, 0]))  # the point joins two to the sea
    np.testing.assert_array_equal(cut_off(far), [True, True, False])


SPIT = {"outer": {"polygon": [[0, 0], [9, 0], [9, 1], [3, 1], [3, 9], [0, 9]], "label": "land"}}


def test_dead_ends_are_split_where_asked():
    plain = mesh_case(case(3.0, domain=SPIT, output={"depth": "40 + 0*x"}))
    assert plain.report["water"]["dead_ends"] > 0
    missed = mesh_case(case(3.0, domain=SPIT, require={"dead_ends_max": 0}))
    assert "dead_ends_max is" in str(missed.verdict)
    split = mesh_case(case(3.0, domain=SPIT, overconstrained="split", require={"dead_ends_max": 0, "cut_off_max": 0}))
    assert split.verdict is None
    assert not dead_ends(split.mesh).any()


def test_the_terminal_tells_it(folder):
    text = {"domain": BASIN, "spacing": 10e3, "output": {"for": "schism", "depth": "40"}}
    (folder / "bay.yaml").write_text(json.dumps(text))
    code, _, said = command("run", "bay.yaml", "-o", "out")
    assert code == 0
    assert "depth 40 to 40 m; Courant number 1 at a time step of" in " ".join(said.split())


def test_depths_travel_to_workers(folder):
    text = {
        "domain": BASIN,
        "spacing": {"waves": TIDE | {"period": 3600}, "raster": {"file": "bed.nc", "name": "depth"}},
        "output": {"for": "adcirc"},
        "parts": 2,
    }
    (folder / "bay.yaml").write_text(json.dumps(text))
    meshes = []
    for jobs in ("1", "2"):
        assert command("run", "bay.yaml", "-o", f"out{jobs}", "-q", "--jobs", jobs)[0] == 0
        meshes.append((folder / f"out{jobs}" / "bay.14").read_bytes())
    assert meshes[0] == meshes[1]
