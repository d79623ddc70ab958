"""Meshes in a metric as Python programs have them: their measures, files and pictures."""

import json
from dataclasses import replace

import meshio
import numpy as np
import pytest
import shapely
from commands import command
from metrics import FRONT

import bubblemesh
from bubblemesh import load_case, mesh_case
from bubblemesh.errors import BubblemeshError
from bubblemesh.meshes.metric import ENTRIES
from bubblemesh.meshes.quality import radius_ratios

CASE = {"domain": {"outer": {"rectangle": [0, 0, 1, 1]}}, "spacing": 0.06, "packing": {"effort": "fast"}}


def loaded(folder, metric=FRONT):
    (folder / "m.yaml").write_text(json.dumps(CASE | {"metric": metric}))
    return load_case(folder / "m.yaml")


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    return mesh_case(loaded(tmp_path_factory.mktemp("case")))


@pytest.mark.parametrize("metric", [FRONT, None])
def test_a_mesh_writes_what_the_command_writes(tmp_path, metric):
    mesh, ends = mesh_case(loaded(tmp_path, metric)).mesh, ("vtu", "mesh", "pos", "msh")
    formats = [word for end in ends for word in ("--format", end)]
    code, _, told = command("run", tmp_path / "m.yaml", "-q", "-o", tmp_path / "there", *formats)
    assert code == 0, told
    for end in ends:
        files = mesh.write(tmp_path / end / f"m.{end}")
        assert files == [f"m.{end}"] + (["m.sol"] if end == "mesh" and metric else [])
        assert sorted(files) == sorted(path.name for path in (tmp_path / end).iterdir())
        for name in files:
            assert (tmp_path / end / name).read_bytes() == (tmp_path / "there" / name).read_bytes()


def test_the_quality_is_that_in_the_metric(result):
    found, told = result.mesh.quality(), result.report["quality"]
    assert (found.mean, found.p01, found.min) == pytest.approx((told["mean"], told["p01"], told["min"]), rel=1e-12)
    assert found.angle_min == pytest.approx(told["angle_min"])
    assert found.mean > 1.02 * radius_ratios(result.mesh.points, result.mesh.triangles).mean()
    second = result.mesh.second_order()[0]
    assert second.quality() == found


def test_pictures_show_the_metric(result):
    _, scale = result.mesh.plot(ellipses=True).axes
    assert scale.get_ylabel().startswith("radius ratio in the metric")
    _, scale = result.mesh.plot(color="spacing").axes
    assert scale.get_ylabel().startswith("edge length / spacing")


def test_a_mesh_at_other_places_has_neither_metric_nor_data(result):
    moved = result.mesh.mapped(lambda points: 2 * points)
    assert (len(moved.metric), dict(moved.fields)) == (0, {})
    assert moved.quality().mean == pytest.approx(radius_ratios(result.mesh.points, result.mesh.triangles).mean())


def test_data_of_the_mesh_is_that_of_the_result(result):
    assert set(result.mesh.fields) == {"quality", "target_spacing", *ENTRIES} == set(result.fields)
    for name, values in result.fields.items():
        np.testing.assert_array_equal(result.mesh.fields[name], values)
    assert bubblemesh.mesh([(0, 0), (1, 0), (0, 1)], 0.3).fields.keys() == {"quality", "target_spacing"}


def test_a_mesh_of_a_file_keeps_the_metric_of_its_triangles(result, tmp_path):
    result.mesh.write(tmp_path / "a.vtu")
    read = bubblemesh.Mesh.read(tmp_path / "a.vtu")
    assert read.quality().mean == pytest.approx(result.mesh.quality().mean)
    code, text, told = command("partition", tmp_path / "a.vtu", 2, "-o", tmp_path / "b.vtu", "--json", "-q")
    assert code == 0, told
    assert json.loads(text)["quality"]["mean"] == pytest.approx(read.quality().mean)
    again = bubblemesh.Mesh.read(tmp_path / "b.vtu")
    np.testing.assert_allclose(again.fields["metric_11"], result.fields["metric_11"])


def test_a_metric_without_a_case_file_gives_the_same_mesh(result):
    mesh = bubblemesh.mesh([(0, 0), (1, 0), (1, 1), (0, 1)], 0.06, metric=FRONT, effort="fast")
    np.testing.assert_array_equal(mesh.points, result.mesh.points)
    np.testing.assert_array_equal(mesh.fields["metric_12"], result.fields["metric_12"])


def test_several_metrics_and_rasters_of_the_spacing_are_taken(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    np.savez("m.npz", x=np.array([0.0, 1.0]), y=np.array([0.0, 1.0]), m11=np.full((2, 2), 0.05**-2.0))
    spacing = {"value": 0.1, "raster": {"file": "m.npz", "name": "m11"}}
    metrics = [{"m11": "raster.m11", "m22": np.float64(100)}, {"angle": 0, "across": np.float64(0.04)}]
    mesh = bubblemesh.mesh(shapely.box(0, 0, 1, 1), spacing, metric=metrics, nodes=600, effort="fast")
    assert len(mesh.points) == pytest.approx(600, rel=0.02)
    np.testing.assert_allclose(mesh.fields["metric_22"] / mesh.fields["metric_11"], (5 / 4) ** 2, rtol=1e-6)


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        ({"metric": {"angle": 0.5}}, r"^mesh\(\): metric\.across: "),
        ({"metric": 3}, r"^mesh\(\): metric: "),
        ({"metric": [{"m11": -1, "m22": 1}]}, r"^mesh\(\): metric.m11: is -1 at \("),
        ({"metric": {"m11": "raster.a", "m22": 1}}, r"^mesh\(\): metric\.m11: .*there is no raster 'a'"),
        ({"metric": {"like": "boundary", "label": "wall", "across": 0.1}}, r"^mesh\(\): metric\.label: .*'wall'"),
        ({"metric": FRONT, "method": "bpm"}, r"^mesh\(\): method: bpm packs no metric"),
        ({"metric": FRONT, "angle_min": 20}, r"^mesh\(\): angle_min: does not go with a metric"),
        ({"metric": {"file": "missing.vtu"}}, r"^mesh\(\): metric: .*missing\.vtu"),
    ],
)
def test_a_metric_that_is_none_is_told_with_its_key(arguments, match):
    with pytest.raises(BubblemeshError, match=match):
        bubblemesh.mesh(shapely.box(0, 0, 1, 1), 0.1, **arguments)


def test_the_quality_in_a_file_is_that_of_points_where_they_are(result, tmp_path):
    moved = replace(result.mesh, points=result.mesh.points * [1.0, 1.5])
    moved.write(tmp_path / "moved.vtu")
    written = meshio.read(tmp_path / "moved.vtu").cell_data["quality"][0]
    assert written.mean() < result.fields["quality"].mean() - 0.02
