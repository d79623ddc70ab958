"""Metrics of places on the earth: sizes in metres on the ground, directions from the east on."""

import json
import re
from contextvars import copy_context

import numpy as np
import pytest

from bubblemesh import load_case, mesh_case
from bubblemesh.errors import CaseError
from bubblemesh.problem.prepare import prepare

pytest.importorskip("pyproj")

PLACES = np.array([[-4, 60.5], [0.0, 62], [4, 63.5]])
EAST = np.array([1e-3, 0.0])  # degrees


def case_with(metric, **keys):
    outer = {"polygon": [[-5, 60], [5, 60], [5, 64], [-5, 64]], "label": "coast"}
    case = {"crs": {"from": "EPSG:4326"}, "domain": {"outer": outer}, "spacing": 40_000, "metric": metric}
    return load_case("a.yaml", text=json.dumps(case | {"packing": {"effort": "fast"}} | keys))


def prepared(case):
    """The problem of a case; messages after it have no places of the earth."""
    return copy_context().run(prepare, case)


def meshed(case):
    """The result of a case, the same way."""
    return copy_context().run(mesh_case, case)


def test_sizes_are_metres_on_the_ground_and_angles_from_the_east():
    problem = prepared(case_with({"angle": 0, "across": 8000}))
    plane = problem.domain.plane
    x, scale = plane.to(PLACES), plane.scale(*plane.to(PLACES).T)
    across, along, direction = problem.spacing.axes(x)
    np.testing.assert_allclose(across, 8000 * scale, rtol=1e-9)
    np.testing.assert_allclose(along, 40_000 * scale, rtol=1e-9)
    assert scale.max() > 1.0001
    east = plane.to(PLACES + EAST) - plane.to(PLACES - EAST)
    np.testing.assert_allclose(direction, east / np.hypot(*east.T)[:, None], atol=1e-6)
    assert abs(direction[0, 1]) > 0.05  # the plane is turned there


COARSE = {"angle": 0, "across": 20_000}


@pytest.fixture(scope="module")
def in_plane():
    """The result of a case, with coordinates of the plane."""
    return meshed(case_with(COARSE))


@pytest.fixture(scope="module")
def in_degrees():
    """The same one with longitudes and latitudes."""
    return meshed(case_with(COARSE, crs={"from": "EPSG:4326", "to": "EPSG:4326"}))


def test_a_mesh_in_the_plane_is_no_metric_in_degrees(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    metric = {"angle": 0, "along": 40_000, "across": "16000 + 1000*(x + 5)"}
    result = meshed(case_with(metric))
    result.mesh.write("one.mesh", sidecars=True)
    assert (tmp_path / "one.sol").exists()
    result.mesh.write("one.vtu")
    field = {"field": {"file": "one.vtu", "name": "quality"}}
    for case in (case_with({"file": "one.mesh"}), case_with(metric, spacing=field)):
        with pytest.raises(CaseError, match="no longitudes and latitudes: files have the coordinates of crs"):
            prepared(case)


def test_tensors_are_written_in_the_plane_only(in_plane, in_degrees):
    names = {"metric_11", "metric_12", "metric_22"}
    assert names <= in_plane.fields.keys()
    assert not names & in_degrees.fields.keys()
    assert in_degrees.mesh.geographic


def test_entries_of_a_tensor_are_those_to_the_east_and_the_north():
    one = prepared(case_with({"angle": 0, "across": 8000})).spacing
    other = prepared(case_with({"m11": 40_000.0**-2, "m22": 8000.0**-2}, spacing=1e6)).spacing
    x = prepared(case_with({"angle": 0, "across": 8000})).domain.plane.to(PLACES)
    np.testing.assert_allclose(one.at(x), other.at(x), rtol=1e-6, atol=1e-14)


def test_expressions_name_longitudes_and_latitudes_and_walls_are_in_the_plane():
    problem = prepared(case_with({"angle": 0, "across": "8000 + 4000*(y - 60)"}))
    plane = problem.domain.plane
    x = plane.to(PLACES)
    np.testing.assert_allclose(
        problem.spacing.axes(x).across / plane.scale(*x.T), 8000 + 4000 * (PLACES[:, 1] - 60), rtol=1e-6
    )
    result = meshed(case_with({"like": "boundary", "label": "coast", "across": 10_000, "growth": 0.3}))
    assert result.report.quality["mean"] > 0.9


def test_a_metric_is_not_written_in_other_coordinates_than_those_of_the_plane(in_plane, in_degrees):
    assert len(in_degrees.mesh.metric) == 0
    assert len(in_plane.mesh.metric) > 0


def save_arrays(path, shift=0.0, **bad):
    """Rasters around the domain, or ``shift`` degrees beside it, with another value at (-1, 61) where one is given."""
    x, y = np.linspace(-6, 6, 13) + shift, np.linspace(59, 65, 7)
    arrays = {"m11": np.full((7, 13), 1e-8), "m12": np.zeros((7, 13)), "m22": np.full((7, 13), 1e-8)}
    for name, value in bad.items():
        arrays[name][2, 5] = value
    np.savez(path, x=x, y=y, **arrays)


BAD = "at (-1, 61)"
BESIDE = "from (13.5, 58.5) to (26.5, 65.5), lies beside the domain, which is from (-5, 60) to (5, 64)"


@pytest.mark.parametrize(
    ("arrays", "keys", "told"),
    [
        ({"m12": 1.0}, {}, BAD),
        ({"m22": -1.0}, {"spacing": {"raster": {"file": "m.npz", "name": "m22"}}}, BAD.removeprefix("at ")),
        ({"shift": 20.0}, {}, BESIDE),
    ],
)
def test_messages_on_data_have_its_own_coordinates(tmp_path, monkeypatch, arrays, keys, told):
    monkeypatch.chdir(tmp_path)
    save_arrays("m.npz", **arrays)
    with pytest.raises(CaseError, match=re.escape(told)):
        prepared(case_with({"file": "m.npz"}, **keys))


def test_messages_on_data_of_meshes_have_its_own_coordinates(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "m.mesh").write_text(
        "MeshVersionFormatted 2\nDimension 2\nVertices 3\n-30 50 0\n30 50 0\n-1 90 0\nTriangles 1\n1 2 3 1\nEnd\n"
    )
    (tmp_path / "m.sol").write_text(
        "MeshVersionFormatted 2\nDimension 2\nSolAtVertices 3\n1 3\n1e-8 0 1e-8\n1e-8 0 1e-8\n1e-8 0 -1\nEnd\n"
    )
    with pytest.raises(CaseError, match=re.escape("at (-1, 90)")):
        prepared(case_with({"file": "m.mesh"}))
