"""Periodic sides in meshes and their files: which nodes match, and how readers learn of it."""

import dataclasses
import json
from itertools import product

import meshio
import numpy as np
import pytest
from partitions import mesh_of
from sweeps import sweep

from bubblemesh.errors import BubblemeshError, FileError
from bubblemesh.meshes.conformity import require_conforming
from bubblemesh.meshfiles.formats import FORMATS
from bubblemesh.meshfiles.mesh_files import MeshFiles
from bubblemesh.meshfiles.whole_mesh import whole_mesh
from bubblemesh.meshfiles.writing import write_files

CELL = """
domain:
  outer: {rectangle: [0, 0, 2, 1], labels: [bottom, right, top, left]}
  holes: [{circle: {center: [1, 0.5], radius: 0.2}, label: bore}]
  periodic: [[right, left], [bottom, top]]
  regions:
    - {name: west, ring: {circle: {center: [0, 0.5], radius: 0.2}}}
    - {name: east, ring: {circle: {center: [2, 0.5], radius: 0.2}}}
spacing: 0.15
"""
SHIFTS = {("left", "right"): (2, 0), ("bottom", "top"): (0, 1)}
# Followed as they are named, the pairs lead from the corners 0, 2 and 4 round in a circle.
HEXAGON = """
domain:
  outer:
    polygon: [[1, 0], [0.5, 0.9], [-0.5, 0.9], [-1, 0], [-0.5, -0.9], [0.5, -0.9]]
    labels: [s0, s1, s2, s3, s4, s5]
  periodic: [[s0, s3], [s4, s1], [s2, s5]]
spacing: 0.3
"""


@pytest.fixture(scope="module", params=[1, 2])
def cell(request):
    mesh = mesh_of(CELL)
    return mesh if request.param == 1 else mesh.second_order()[0]


@pytest.fixture(scope="module")
def hexagon():
    return mesh_of(HEXAGON)


def side(mesh, label):
    """Nodes of a side."""
    return set(mesh.facets[mesh.facet_labels == mesh.labels.index(label)].ravel().tolist())


@pytest.mark.long
def test_sides_match_node_by_node(cell):
    found = {(cell.labels[sides.first], cell.labels[sides.second]): sides for sides in cell.periodic_sides}
    assert set(found) == set(SHIFTS)
    for (first, second), shift in SHIFTS.items():
        sides = found[first, second]
        np.testing.assert_allclose(sides.shift, shift, atol=1e-12)
        here, there = sides.nodes.T
        assert (set(here.tolist()), set(there.tolist())) == (side(cell, first), side(cell, second))
        assert len(here) == len(side(cell, first))
        np.testing.assert_allclose(cell.points[here] + shift, cell.points[there], atol=1e-12)


def test_a_mesh_without_periodic_sides_has_none():
    assert mesh_of(CELL.replace("  periodic: [[right, left], [bottom, top]]\n", "")).periodic_sides == ()


def test_chains_of_counterparts_end(hexagon):
    last = {b: a for sides in hexagon.periodic_sides for a, b in sides.nodes.tolist()}
    for node in last:
        steps = 0
        while node in last:
            node, steps = last[node], steps + 1
            assert steps < 3
    assert {tuple(sorted((s.first, s.second))) for s in hexagon.periodic_sides} == {(0, 3), (1, 4), (2, 5)}


def test_a_side_that_does_not_match_is_an_error_of_the_program():
    mesh = mesh_of(CELL)
    require_conforming(mesh)
    with pytest.raises(BubblemeshError, match="a node of a periodic side has no counterpart at"):
        require_conforming(dataclasses.replace(mesh, periodic=mesh.periodic[::-1] * [1, 0] + mesh.periodic * [0, 1]))


@pytest.mark.parametrize("form", ["msh", "msh-ascii"])
def test_gmsh_reads_the_pairs(gmsh, cell, tmp_path, form):
    write_files(cell, {}, {}, MeshFiles(tmp_path, "cell", [form]))
    gmsh.option.setNumber("Mesh.IgnorePeriodicity", 0)
    try:
        gmsh.open(str(tmp_path / "cell.msh"))
    finally:
        gmsh.option.setNumber("Mesh.IgnorePeriodicity", 1)
    found = {}
    for _, entity in gmsh.model.getEntities(1):
        original, nodes, originals, affine = gmsh.model.mesh.getPeriodicNodes(1, entity, includeHighOrderNodes=True)
        if original != entity:
            found[original - 1, entity - 1] = set(zip(originals - 1, nodes - 1, strict=True)), affine
    assert len(found) == 2
    for sides in cell.periodic_sides:
        nodes, affine = found[sides.first, sides.second]
        assert nodes == {tuple(pair) for pair in sides.nodes.tolist()}
        moved = np.eye(4)
        moved[:2, 3] = sides.shift
        np.testing.assert_allclose(affine, moved.ravel(), atol=1e-15)


SECTOR = """
domain:
  outer:
    path:
      - [INNER, 0]
      - {to: [2, 0], label: right}
      - {arc: {to: [2*cos(pi/3), 2*sin(pi/3)], center: [0, 0], turn: left}, label: yoke}
      - {to: [INNER*cos(pi/3), INNER*sin(pi/3)], label: left}
      SHAFT
  periodic: [[right, left]]
spacing: 0.3
"""
RING = SECTOR.replace("INNER", "1").replace("SHAFT", "- {arc: {to: [1, 0], center: [0, 0], turn: right}, label: shaft}")
WEDGE = SECTOR.replace("INNER", "0").replace("SHAFT", "")
QUARTER = """
domain: {outer: {rectangle: [0, 0, 1, 1], labels: [b, r, t, l]}, periodic: [[b, l], [t, r]]}
spacing: 0.3
"""


def open_in_place(gmsh, mesh, folder, form):
    """Write a mesh and let Gmsh open it, without periodicity and then with it: its nodes stay where they are."""
    write_files(mesh, {}, {}, MeshFiles(folder, "cell", [form]))
    for ignored in (1, 0):
        gmsh.option.setNumber("Mesh.IgnorePeriodicity", ignored)
        try:
            gmsh.open(str(folder / "cell.msh"))
        finally:
            gmsh.option.setNumber("Mesh.IgnorePeriodicity", 1)
        numbers, places, _ = gmsh.model.mesh.getNodes()
        np.testing.assert_allclose(places.reshape(-1, 3)[np.argsort(numbers), :2], mesh.points, atol=1e-14)


TURNED = {"ring": RING, "with its tip": WEDGE, "two pairs": QUARTER}
FORMS = "msh", "msh-ascii", "msh4"


@pytest.mark.parametrize(("name", "form", "order"), sweep(product(TURNED, FORMS, [1, 2]), quick=10))
def test_gmsh_reads_how_sides_are_turned(gmsh, tmp_path, name, form, order):
    text = TURNED[name]
    mesh = mesh_of(text) if order == 1 else mesh_of(text).second_order()[0]
    open_in_place(gmsh, mesh, tmp_path, form)
    for sides in mesh.periodic_sides:
        found = gmsh.model.mesh.getPeriodicNodes(1, sides.second + 1, includeHighOrderNodes=True)
        original, nodes, originals, affine = found
        assert original == sides.first + 1
        assert set(zip(originals - 1, nodes - 1, strict=True)) == {tuple(pair) for pair in sides.nodes.tolist()}
        turn = np.radians(-60 if text != QUARTER else sides.angle)
        matrix = np.reshape(affine, (4, 4))
        rotation = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
        np.testing.assert_allclose(matrix[:2, :2], rotation, atol=1e-12)
        here, there = mesh.points[sides.nodes.T]
        np.testing.assert_allclose(here @ matrix[:2, :2].T + matrix[:2, 3], there, atol=1e-12)
        np.testing.assert_array_equal(matrix[2:], np.eye(4)[2:])


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("text", [RING, WEDGE, QUARTER], ids=["ring", "with its tip", "two pairs"])
def test_turned_sides_are_read_back(tmp_path, text, form):
    mesh = mesh_of(text)
    write_files(mesh, {}, {}, MeshFiles(tmp_path, "cell", [form]))
    found, notes = whole_mesh(tmp_path / "cell.msh")
    assert notes == ()
    require_conforming(found)
    before, after = (
        {(each.labels[sides.first], each.labels[sides.second]): sides.motion for sides in each.periodic_sides}
        for each in (mesh, found)
    )
    assert before.keys() == after.keys()
    for names, motion in before.items():
        np.testing.assert_allclose(after[names], motion, atol=1e-12)


def test_files_of_few_digits_tell_turned_sides(tmp_path):
    mesh = mesh_of(RING)
    rounded = dataclasses.replace(mesh, points=np.round(mesh.points, 6))
    write_files(rounded, {}, {}, MeshFiles(tmp_path, "cell", ["msh-ascii"]))
    (sides,) = whole_mesh(tmp_path / "cell.msh")[0].periodic_sides
    assert sides.angle == pytest.approx(-60, abs=1e-4)


def test_the_sidecar_has_angle_and_center_of_turned_sides(tmp_path):
    write_files(mesh_of(RING), {}, {}, MeshFiles(tmp_path, "cell", ["su2"]))
    sidecar = json.loads((tmp_path / "cell.labels.json").read_text())
    found = {name: entry["periodic"] for name, entry in sidecar.items() if "periodic" in entry}
    for name, other, angle in (("right", "left", 60), ("left", "right", -60)):
        assert found[name] == {"with": other, "angle": pytest.approx(angle), "center": pytest.approx([0, 0], abs=1e-12)}


PAIRED = """
domain:
  outer: {rectangle: [0, 0, 1, 1], labels: [bottom, right, top, left]}
  periodic: [[left, right]PAIRS]
  POINTS
spacing: 0.2
"""
OTHERS = {"one pair": "", "two pairs": ", [bottom, top]"}
LABELLED = "points: [{at: [0, 0], label: origin}, {at: [0.5, 0.5], label: middle}]"


@pytest.mark.parametrize(
    ("form", "others", "labelled", "order"), sweep(product(FORMS, OTHERS, [False, True], [1, 2]), quick=13)
)
def test_gmsh_leaves_nodes_where_they_are(gmsh, tmp_path, form, others, labelled, order):
    mesh = mesh_of(PAIRED.replace("PAIRS", OTHERS[others]).replace("POINTS", LABELLED if labelled else ""))
    mesh = mesh if order == 1 else mesh.second_order()[0]
    open_in_place(gmsh, mesh, tmp_path, form)
    names = {gmsh.model.getPhysicalName(*group) for group in gmsh.model.getPhysicalGroups()}
    assert names - {"periodic-ends"} == {*mesh.labels, *mesh.regions, *mesh.point_labels}


def pairs_of(mesh):
    """Sides, pairs of nodes, and shift of each pair of periodic sides."""
    return [
        (sides.first, sides.second, sides.nodes.tolist(), pytest.approx(sides.shift, abs=1e-15))
        for sides in mesh.periodic_sides
    ]


def pairs_for_meshio(periodic):
    """The same from what meshio has, which names the copy first."""
    assert {dimension for dimension, *_ in periodic} == {1}
    return [
        (original - 1, copy - 1, nodes[:, ::-1].tolist(), np.reshape(affine, (4, 4))[:2, 3])
        for _, (copy, original), affine, nodes in periodic
    ]


@pytest.mark.parametrize("form", ["msh", "msh-ascii"])
def test_meshio_reads_the_pairs(cell, tmp_path, form):
    write_files(cell, {}, {}, MeshFiles(tmp_path, "cell", [form]))
    mesh = meshio.read(tmp_path / "cell.msh", file_format="gmsh")
    assert pairs_for_meshio(mesh.gmsh_periodic) == pairs_of(cell)


def test_meshio_is_handed_the_pairs(cell):
    assert pairs_for_meshio(cell.to_meshio().gmsh_periodic) == pairs_of(cell)


def test_node_arrays_have_the_pairs(tmp_path):
    mesh = mesh_of(CELL)
    write_files(mesh, {}, {}, MeshFiles(tmp_path, "cell", ["nodes.npz"]))
    nodes = np.load(tmp_path / "cell.nodes.npz")
    pairs = {tuple(pair) for pair in nodes["periodic"].tolist()}
    assert pairs == {tuple(pair) for sides in mesh.periodic_sides for pair in sides.nodes.tolist()}


@pytest.mark.long
@pytest.mark.parametrize("form", FORMATS)
def test_the_sidecar_tells_the_counterparts_where_a_format_does_not(tmp_path, form):
    write_files(mesh_of(CELL), {}, {}, MeshFiles(tmp_path, "cell", [form]))
    assert (tmp_path / "cell.labels.json").exists() == (form not in {"msh", "msh-ascii", "msh4", "nodes.npz"})
    if (tmp_path / "cell.labels.json").exists():
        sidecar = json.loads((tmp_path / "cell.labels.json").read_text())
        found = {name: entry["periodic"] for name, entry in sidecar.items() if "periodic" in entry}
        assert {name: entry["with"] for name, entry in found.items()} == {
            **{"left": "right", "right": "left", "bottom": "top", "top": "bottom"}
        }
        for (first, second), shift in SHIFTS.items():
            np.testing.assert_allclose(found[first]["shift"], shift, atol=1e-12)
            np.testing.assert_allclose(found[second]["shift"], np.multiply(shift, -1), atol=1e-12)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("parts", [None, 2])
def test_points_and_periodic_sides_are_read_back(tmp_path, form, order, parts):
    mesh = mesh_of(PAIRED.replace("PAIRS", OTHERS["two pairs"]).replace("POINTS", LABELLED))
    mesh = mesh if parts is None else mesh.partitioned(parts)
    write_files(mesh if order == 1 else mesh.second_order()[0], {}, {}, MeshFiles(tmp_path, "cell", [form]))
    found, notes = whole_mesh(tmp_path / "cell.msh")
    assert len(notes) == order - 1  # corners are read
    assert found.point_labels == ("origin", "middle")
    assert found.points[found.labelled_nodes].tolist() == [[0, 0], [0.5, 0.5]]
    require_conforming(found)
    assert [matching(found, sides) for sides in found.periodic_sides] == [
        matching(mesh, sides) for sides in mesh.periodic_sides
    ]


def matching(mesh, sides):
    """The labels of two sides, and the places of the nodes on the first one and on the second."""
    places = mesh.points[sides.nodes].reshape(-1, 4)
    return mesh.labels[sides.first], mesh.labels[sides.second], sorted(map(tuple, places.tolist()))


def test_periodic_sides_whose_nodes_match_the_wrong_way_round_are_told(tmp_path):
    mesh = mesh_of(PAIRED.replace("PAIRS", "").replace("POINTS", ""))
    (name, *_) = write_files(mesh, {}, {}, MeshFiles(tmp_path, "cell", ["msh-ascii"]))["files"]
    text = (tmp_path / name).read_text()
    head, pairs = text.split("$Periodic\n")
    rows = [row.split() for row in pairs.splitlines()[4:-1]]
    turned = [f"{b} {a}" for (b, _), (_, a) in zip(rows, rows[::-1], strict=True)]
    (tmp_path / name).write_text("\n".join([f"{head}$Periodic", *pairs.splitlines()[:4], *turned, "$EndPeriodic\n"]))
    found, notes = whole_mesh(tmp_path / name)
    assert found.periodic_sides == ()
    assert notes == (
        "1 of its 1 pairs of periodic sides are left out: they are no boundaries that are shifted or turned",
    )


@pytest.mark.parametrize(("row", "missing"), [("0 1", 0), ("1 9999", 9999)])
def test_a_match_of_a_node_that_is_not_there_is_damage(tmp_path, row, missing):
    mesh = mesh_of(PAIRED.replace("PAIRS", "").replace("POINTS", ""))
    (name, *_) = write_files(mesh, {}, {}, MeshFiles(tmp_path, "cell", ["msh-ascii"]))["files"]
    lines = (tmp_path / name).read_text().splitlines()
    lines[-2] = row
    (tmp_path / name).write_text("\n".join([*lines, ""]))
    with pytest.raises(FileError, match=f"names the node {missing}, which is not there"):
        whole_mesh(tmp_path / name)


@pytest.mark.parametrize("binary", [0, 1])
@pytest.mark.parametrize("version", [2.2, 4.1])
def test_what_gmsh_writes_is_read(gmsh, tmp_path, version, binary):
    gmsh.clear()
    gmsh.model.occ.addRectangle(0, 0, 0, 2, 1)
    gmsh.model.occ.synchronize()
    gmsh.model.mesh.setPeriodic(1, [2], [4], [1, 0, 0, 2, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])
    for dimension, entity, name in ((0, 1, "origin"), (1, 4, "left"), (1, 2, "right"), (2, 1, "domain")):
        gmsh.model.addPhysicalGroup(dimension, [entity], name=name)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.3)
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", binary)
    gmsh.model.mesh.generate(2)
    gmsh.write(str(tmp_path / "a.msh"))
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.option.setNumber("Mesh.Binary", 0)
    gmsh.clear()
    mesh, notes = whole_mesh(tmp_path / "a.msh")
    assert notes == ()
    assert mesh.points[mesh.labelled_nodes].tolist() == [[0, 0]]
    (sides,) = mesh.periodic_sides
    assert (mesh.labels[sides.first], mesh.labels[sides.second], sides.shift.tolist()) == ("left", "right", [2, 0])
    assert len(sides.nodes) == np.count_nonzero(mesh.points[:, 0] == 0)


@pytest.mark.parametrize("version", [2.2, 4.1])
def test_turned_sides_that_gmsh_writes_are_read(gmsh, tmp_path, version):
    gmsh.clear()
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    places = [(0, 0), (2, 0), (1.2, 1.6)]
    points = [gmsh.model.geo.addPoint(x, y, 0, 0.3) for x, y in places]
    lines = [gmsh.model.geo.addLine(points[k], points[(k + 1) % 3]) for k in range(3)]
    gmsh.model.geo.addPlaneSurface([gmsh.model.geo.addCurveLoop(lines)])
    gmsh.model.geo.synchronize()
    matrix = np.eye(4)
    matrix[:2, :2] = turn
    gmsh.model.mesh.setPeriodic(1, [lines[2]], [lines[0]], matrix.ravel().tolist())
    for dimension, entity, name in ((1, lines[0], "right"), (1, lines[2], "left"), (2, 1, "domain")):
        gmsh.model.addPhysicalGroup(dimension, [entity], name=name)
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.model.mesh.generate(2)
    gmsh.write(str(tmp_path / "a.msh"))
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.clear()
    (sides,) = whole_mesh(tmp_path / "a.msh")[0].periodic_sides
    assert abs(sides.angle) == pytest.approx(np.degrees(np.arctan2(0.8, 0.6)))
    np.testing.assert_allclose(sides.center, [0, 0], atol=1e-9)
    assert (sides.nodes[:, 0] == sides.nodes[:, 1]).sum() == 1


def test_groups_of_nodes_that_are_not_read_are_told(tmp_path):
    mesh = mesh_of(PAIRED.replace("PAIRS", "").replace("POINTS", LABELLED))
    write_files(mesh, {}, {}, MeshFiles(tmp_path, "cell", ["med", "inp"]))
    assert whole_mesh(tmp_path / "cell.med")[1] == ("sets of nodes are left out: middle, origin",)
    assert whole_mesh(tmp_path / "cell.inp")[1] == ("sets of nodes are left out: middle, origin",)
