"""Meshes of other tools that are not conforming, and what is told of them."""

import json

import meshio
import numpy as np
import pytest
from typer.testing import CliRunner

from bubblemesh import Mesh, load_case, mesh_case
from bubblemesh.cli import app
from bubblemesh.meshes.mesh import MeshWarning
from bubblemesh.meshfiles.faults import faults

SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
HALVES = [(0, 1, 2), (0, 2, 3)]
EPSILON = float(np.finfo(float).eps)
APART = "the mesh is not connected there"
TURNED = "1 triangle turns the other way than the rest, the first at ({}, {}): the mesh may lie upon itself there"


def moved(points, by, times=1.0):
    return [(x * times + by[0], y * times + by[1]) for x, y in points]


def second(triangles):
    return [tuple(node + 4 for node in triangle) for triangle in triangles]


@pytest.mark.parametrize(
    ("points", "triangles", "told"),
    [
        (SQUARE, [(0, 1, 2), (0, 3, 2)], [TURNED.format(0.333333, 0.666667)]),  # the second one is clockwise
        (SQUARE, [(2, 1, 0), (0, 3, 2)], []),  # all are
        (
            SQUARE,
            [*HALVES, (1, 0, 0), (1, 1, 1)],
            ["2 triangles have the same node twice, the first at (0.333333, 0): no area is in it"],
        ),
        ([*SQUARE, *moved(SQUARE, (2, 0))], [*HALVES, *second(HALVES)], []),  # two pieces that do not touch
        (
            [*SQUARE, *moved(SQUARE, (1, 0))],
            [*HALVES, *second(HALVES)],
            [f"2 nodes are in places of others, the first at (1, 0): {APART}"],
        ),
        (
            [*SQUARE, *moved(SQUARE, (1 + 1e-3, 0))],  # a gap
            [*HALVES, *second(HALVES)],
            [],
        ),
        (
            [*SQUARE, (1, 0.5), (2, 0), (2, 1)],
            [*HALVES, (1, 5, 4), (4, 5, 6), (4, 6, 2)],
            [f"1 node hangs in a side, the first at (1, 0.5): {APART}"],
        ),
        (
            [*SQUARE, *moved(SQUARE, (1, 0.5))],
            [*HALVES, *second(HALVES)],
            [f"2 nodes hang in sides, the first at (1, 1): {APART}"],
        ),
        (
            SQUARE,
            [*HALVES, (1, 2, 0)],
            ["1 triangle is there twice, the first at (0.666667, 0.333333): figures count all"],
        ),
        (
            [*SQUARE, (0.2, 0.9)],
            [*HALVES, (0, 2, 4)],
            ["1 edge has more than two triangles, the first at (0.5, 0.5)", "the mesh lies upon itself, as at ("],
        ),
        (
            [*SQUARE, *moved(SQUARE, (0.7, 0.6))],
            [*HALVES, *second(HALVES)],
            ["the mesh lies upon itself, as at (1, 0.6)"],
        ),
        (  # within one triangle
            [*SQUARE, *moved(SQUARE, (0.6, 0.1), 0.2)],
            [*HALVES, *second(HALVES)],
            ["the mesh lies upon itself, as at (0.7001, 0.1002)"],
        ),
        (  # a fan of triangles that turns around its middle twice: no node is in two places
            [(0, 0), *((r * np.cos(a), r * np.sin(a)) for r, a in zip(range(3, 11), np.arange(8) * 1.5, strict=True))],
            [(0, k, k + 1) for k in range(1, 8)],
            ["the mesh lies upon itself, as at ("],
        ),
    ],
)
def test_each_fault_is_told_with_its_place(points, triangles, told):
    found = faults(np.array(points, float), np.array(triangles), EPSILON)
    assert len(found) == len(told)
    for text, begin in zip(found, told, strict=True):
        assert text.startswith(begin)


def test_a_hanging_node_may_be_off_by_rounding_of_its_file():
    points = np.array([*SQUARE, (1, 1 / 3), (2, 0), (2, 1)]) @ [[0.8, 0.6], [-0.6, 0.8]] + 1000
    triangles = np.array([*HALVES, (1, 5, 4), (4, 5, 6), (4, 6, 2)])
    single = points.astype(np.float32)
    assert len(faults(single.astype(float), triangles, float(np.finfo(np.float32).eps))) == 1


@pytest.mark.parametrize(
    "more", ["", "layers: [{on: bottom, first: .01, count: 3, cells: quads}]", "output: {order: 2}"]
)
def test_own_meshes_have_no_faults(more):
    text = f"""
    domain:
      outer: {{rectangle: [0, 0, 2, 1], labels: [bottom, right, top, left]}}
      holes: [{{circle: {{center: [1, .5], radius: .2}}}}]
    spacing: 0.15
    {more}
    """
    mesh = mesh_case(load_case("a.yaml", text=text)).mesh
    assert faults(mesh.points, mesh.triangles[:, :3], EPSILON) == []


def test_the_command_and_the_reader_warn(tmp_path):
    path = tmp_path / "apart.vtu"
    triangles = [*HALVES, *second(HALVES)]
    meshio.Mesh(np.pad([*SQUARE, *moved(SQUARE, (1, 0))], ((0, 0), (0, 1))), [("triangle", triangles)]).write(path)
    note = f"{path}: 2 nodes are in places of others, the first at (1, 0): {APART}"
    done = CliRunner().invoke(app, ["quality", str(path), "--json"])
    assert json.loads(done.stdout)["warnings"] == [note]
    assert f"warning: {note}" in done.stderr
    assert f"warning: {note}" in CliRunner().invoke(app, ["quality", str(path), str(path)]).stderr
    with pytest.warns(MeshWarning, match="nodes are in places of others"):
        Mesh.read(path)


@pytest.mark.parametrize(
    ("triangles", "told"),
    [
        ([(0, 1, 2), (0, 3, 2)], "1 triangle turns the other way"),
        ([*HALVES, (0, 0, 1)], "1 triangle has the same node"),
    ],
)
def test_all_that_reads_a_mesh_tells_the_same(triangles, told, tmp_path):
    path = tmp_path / "turned.vtu"
    meshio.Mesh(np.pad(SQUARE, ((0, 0), (0, 1))), [("triangle", triangles)]).write(path)
    out = str(tmp_path / "out.msh")
    for command in (["quality"], ["convert", out], ["partition", "2", "-o", out]):
        done = CliRunner().invoke(app, [command[0], str(path), *command[1:]])
        assert f"warning: {path}: {told}" in done.stderr
    with pytest.warns(MeshWarning, match=told):
        Mesh.read(path)


KINDS = {
    "triangle6": [(0, 0), (1, 0), (0, 1), (0.5, 0), (0.5, 0.5), (0, 0.5)],
    "quad8": [*SQUARE, (0.5, 0), (1, 0.5), (0.5, 1), (0, 0.5)],
    "quad9": [*SQUARE, (0.5, 0), (1, 0.5), (0.5, 1), (0, 0.5), (0.5, 0.5)],
}
BACKWARD = {"triangle6": [0, 2, 1, 5, 4, 3], "quad8": [0, 3, 2, 1, 7, 6, 5, 4], "quad9": [0, 3, 2, 1, 7, 6, 5, 4, 8]}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("backward", [False, True])
@pytest.mark.parametrize(("up", "folds"), [(0.2, False), (0.9, True)])
def test_curved_cells_that_fold_are_told(kind, backward, up, folds, tmp_path):
    points = np.pad(np.array(KINDS[kind]), ((0, 0), (0, 1)))
    points[len(BACKWARD[kind]) // 2 if kind == "triangle6" else 4, 1] = up  # the node on the first side
    cell = np.arange(len(points))
    cell = cell[BACKWARD[kind]] if backward else cell
    path = tmp_path / "curved.vtu"
    meshio.Mesh(points, [(kind, [cell])]).write(path)
    said = CliRunner().invoke(app, ["quality", str(path)]).stderr
    assert "has cells of higher order: their corners are read" in said
    assert ("1 curved cell folds over" in said) == folds


def test_a_picture_is_of_corners_and_says_so(tmp_path):
    path = tmp_path / "curved.vtu"
    meshio.Mesh(np.pad(np.array(KINDS["triangle6"]), ((0, 0), (0, 1))), [("triangle6", [range(6)])]).write(path)
    said = CliRunner().invoke(app, ["plot", str(path), "-o", str(tmp_path / "a.png")]).stderr
    assert "has cells of higher order: their corners are read" in said
