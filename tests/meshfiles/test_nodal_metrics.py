"""Metrics at the nodes of mesh files, for their triangles, and of triangles, for their nodes."""

import json
from dataclasses import replace

import meshio
import numpy as np
import pytest
from commands import command
from matplotlib.collections import EllipseCollection
from metrics import FRONT, matrices, metric_case, random_tensors
from scipy.linalg import expm

from bubblemesh import load_case, mesh_case
from bubblemesh.errors import CaseError
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.metric import at_centroids, node_tensors
from bubblemesh.meshes.tensors import axes
from bubblemesh.meshfiles.metric import read_metric, with_metric
from bubblemesh.meshfiles.read import read_mesh
from bubblemesh.pictures.colouring import MeshData
from bubblemesh.pictures.plots import mesh_figure
from bubblemesh.pictures.styles import PlotOptions
from bubblemesh.problem.prepare import prepare

TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Files of one mesh in a metric: with tensors of its triangles, and with tensors at its nodes."""
    folder = tmp_path_factory.mktemp("files")
    mesh = mesh_case(metric_case(FRONT, packing={"effort": "fast"})).mesh
    for name in ("a.vtu", "a.mesh"):
        mesh.write(folder / name)
    space = np.pad(mesh.points, ((0, 0), (0, 1)))
    data = {"metric": mesh.metric, "u": mesh.points[:, 0]}
    meshio.write(folder / "nodal.vtu", meshio.Mesh(space, [("triangle", mesh.triangles)], point_data=data))
    replace(mesh, fields={}).write(folder / "plain.vtu")
    return folder


def logarithm(tensors):
    values, vectors = np.linalg.eigh(matrices(tensors))
    return (vectors * np.log(values)[:, None]) @ np.moveaxis(vectors, 1, 2)


def test_tensors_are_carried_over_by_the_mean_of_their_logarithms():
    tensors = random_tensors(np.random.default_rng(0), 4, 5)
    expected = expm(logarithm(tensors)[TRIANGLES[1]].mean(axis=0))
    np.testing.assert_allclose(matrices(at_centroids(TRIANGLES, tensors))[1], expected)
    found = matrices(node_tensors(TRIANGLES, tensors[:2], 4))
    np.testing.assert_allclose(found[0], expm(logarithm(tensors[:2]).mean(axis=0)))
    np.testing.assert_allclose(found[[1, 3]], matrices(tensors[:2]))


@pytest.mark.parametrize("name", ["a.mesh", "nodal.vtu"])
def test_quality_in_a_metric_at_the_nodes_is_nearly_that_of_the_triangles(folder, name):
    figures = []
    for file in ("a.vtu", name):
        code, out, told = command("quality", "--metric", folder / file, "--json")
        assert code == 0, told
        figures.append(json.loads(out))
    of_triangles, of_nodes = figures
    assert of_nodes["quality"]["mean"] == pytest.approx(of_triangles["quality"]["mean"], abs=2e-3)
    assert of_nodes["spacing"]["mean"] == pytest.approx(of_triangles["spacing"]["mean"], abs=2e-3)
    assert of_nodes["metric"]["aspect"] == pytest.approx(of_triangles["metric"]["aspect"], rel=0.1)


def test_the_share_of_edges_of_a_good_length_is_told_as_a_run_tells_it(folder):
    result = mesh_case(metric_case({**FRONT, "across": FRONT["across"].replace("0.02 +", "0.004 +")}))
    result.mesh.write(folder / "narrow.vtu")
    code, out, _ = command("quality", "--metric", folder / "narrow.vtu", "--json")
    assert code == 0
    found = json.loads(out)["metric"]
    assert 0.9 < result.report.metric.edges_within < 0.999
    assert found["edges_within"] == pytest.approx(result.report.metric.edges_within, abs=0.015)
    _, out, _ = command("quality", "--metric", folder / "narrow.vtu")
    assert f"times as long as wide, {found['edges_within']:.1%} of the edges in [0.71, 1.41]" in " ".join(out.split())


def test_ellipses_of_a_metric_at_the_nodes_are_drawn(folder, tmp_path):
    code, _, told = command("plot", "--ellipses", folder / "a.mesh", "-o", tmp_path / "a.svg")
    assert code == 0, told
    assert "radius ratio in the metric" in (tmp_path / "a.svg").read_text()
    code, _, told = command("plot", "--ellipses", folder / "plain.vtu", "-o", tmp_path / "b.svg")
    assert code == 2
    assert "plain.vtu: holds no metric: its triangles need the data metric_11" in " ".join(told.split())


@pytest.mark.parametrize("name", ["a.vtu", "a.mesh"])
def test_pictures_have_the_ellipses_that_a_file_gives_the_next_mesh(folder, name):
    read = with_metric(read_mesh(folder / name))
    figure = mesh_figure(read.mesh, PlotOptions(ellipses=True), MeshData(read.cell_data, read.point_data))
    (drawn,) = (part for part in figure.axes[0].collections if isinstance(part, EllipseCollection))
    expected = axes(read_metric(folder / name, None, "field").values)
    np.testing.assert_allclose(drawn._heights * 2, expected.across)
    np.testing.assert_allclose(drawn._widths * 2, expected.along)


@pytest.mark.parametrize("name", ["a.vtu", "a.mesh"])
def test_a_mesh_that_is_read_keeps_its_metric(folder, tmp_path, name):
    given = Mesh.read(folder / "a.vtu")
    found = Mesh.read(folder / name)
    assert found.quality().mean == pytest.approx(given.quality().mean, abs=2e-3)
    assert found.write(tmp_path / "b.mesh") == ["b.mesh", "b.sol"]
    found.write(tmp_path / "b.pos")
    for file in ("b.mesh", "b.pos"):
        again = Mesh.read(tmp_path / file)
        order = np.lexsort(found.points.T), np.lexsort(again.points.T)  # nodes of a view have no numbers
        np.testing.assert_allclose(again.metric[order[1]], found.metric[order[0]], rtol=1e-9)
    np.testing.assert_allclose(
        np.log(Mesh.read(folder / "a.mesh").metric[:, [0, 2]] / found.metric[:, [0, 2]]), 0, atol=0.5
    )


def test_three_numbers_are_no_metric_in_formats_that_do_not_say_so(folder, tmp_path):
    assert Mesh.read(folder / "nodal.vtu").metric.shape == (0, 3)
    (tmp_path / "a.mesh").write_bytes((folder / "a.mesh").read_bytes())
    sol = (folder / "a.sol").read_text()
    (tmp_path / "a.sol").write_text(sol.replace("\n1 3\n", "\n1 3\n-"))  # a stress
    found = Mesh.read(tmp_path / "a.mesh")
    assert (found.metric.shape, found.fields) == ((0, 3), {})


def test_a_partition_keeps_the_metric_beside_a_mesh(folder, tmp_path):
    code, _, told = command("partition", folder / "a.mesh", "2", "-o", tmp_path / "b.mesh", "-q")
    assert code == 0, told
    assert (tmp_path / "b.sol").read_text() == (folder / "a.sol").read_text()


def test_of_several_that_may_be_the_metric_one_is_named(folder, tmp_path):
    read = meshio.read(folder / "nodal.vtu")
    two = {**read.point_data, "more": 4 * read.point_data["metric"]}
    meshio.write(tmp_path / "two.vtu", meshio.Mesh(read.points, read.cells, point_data=two))
    code, _, told = command("quality", "--metric", tmp_path / "two.vtu")
    assert code == 2
    assert "several that may be one at its nodes (metric, more): choose one by --field" in " ".join(told.split())
    figures = {}
    for name in ("metric", "more"):
        code, out, told = command("quality", "--metric", "--field", name, tmp_path / "two.vtu", "--json")
        assert code == 0, told
        figures[name] = json.loads(out)["spacing"]["mean"]
    assert figures["more"] == pytest.approx(2 * figures["metric"])
    code, _, told = command("plot", "--ellipses", "--field", "more", tmp_path / "two.vtu", "-o", tmp_path / "a.svg")
    assert code == 0, told


@pytest.mark.parametrize(
    ("words", "match"),
    [
        (["quality", "--field", "u"], "--field: it names a metric: use it with --metric"),
        (["plot", "--field", "u"], "--field: it names a metric: use it with --ellipses"),
        (["quality", "--metric", "--field", "w"], "has no data 'w' at its nodes: it has metric, u"),
        (["quality", "--metric", "--field", "u"], "u: has 1 component: a metric has three"),
    ],
)
def test_a_name_that_is_of_no_use_is_refused(folder, words, match):
    code, _, told = command(*words, folder / "nodal.vtu")
    assert code == 2
    assert match in " ".join(told.split())


def test_what_is_no_metric_at_the_nodes_is_told(folder, tmp_path):
    read = read_mesh(folder / "nodal.vtu")
    two = read._replace(point_data={**read.point_data, "more": read.point_data["metric"]})
    with pytest.raises(CaseError, match=r"has several that may be one at its nodes \(metric, more\)"):
        with_metric(two)
    with pytest.raises(CaseError, match=r"^metric: is not positive definite and finite at \("):
        with_metric(read._replace(point_data={"metric": -read.point_data["metric"]}))
    (tmp_path / "a.mesh").write_bytes((folder / "a.mesh").read_bytes())
    code, _, told = command("quality", "--metric", tmp_path / "a.mesh")
    assert code == 2
    assert "in the .sol beside it" in " ".join(told.split())


def test_a_case_reads_the_metric_of_the_triangles_of_a_run(folder):
    found = read_metric(folder / "a.vtu", None, "name")
    requested = prepare(metric_case(FRONT)).spacing.at(found.points)
    inside = (np.abs(found.points - 0.5) < 0.45).all(axis=1)
    apart = np.abs(logarithm(found.values[inside]) - logarithm(requested[inside]))
    assert apart.mean() < 0.05
    (folder / "again.yaml").write_text(
        "domain: {outer: {rectangle: [0, 0, 1, 1]}}\nspacing: 0.06\nmetric: {file: a.vtu}\n"
    )
    result = mesh_case(load_case(folder / "again.yaml"))
    assert len(result.mesh.points) == pytest.approx(len(found.points), rel=0.05)
    with pytest.raises(CaseError, match="has no data at its nodes"):
        read_metric(folder / "plain.vtu", None, "name")
