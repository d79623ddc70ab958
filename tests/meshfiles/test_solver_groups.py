"""Regions, holes, inner lines and points with names that are no plain words: every solver finds all cells of each."""

import json
import re

import numpy as np
import pytest
import skfem
from solver_programs import SYSTEM, mfem_python, openfoam, program, python_with, run
from solvers_page import blocks

from bubblemesh.case import load_case
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.meshfiles.formats import FORMATS_FOR
from bubblemesh.meshfiles.groups import facet_ids, group_names, plain_words, region_ids
from bubblemesh.meshfiles.mesh_files import MeshFiles
from bubblemesh.meshfiles.writing import write_files
from bubblemesh.run.pipeline import mesh_case

CASE = """
domain:
  outer: {rectangle: [0, 0, 2, 1], labels: [unten rechts, right, Öl, left]}
  holes: [{circle: {center: [0.5, 0.5], radius: 0.2}, label: bore}]
  region: matrix
  regions:
    - {name: fibre one, ring: {circle: {center: [1.4, 0.5], radius: 0.2}}}
    - {name: 日本, ring: {rectangle: [1.8, 0, 2.5, 1]}}
  lines:
    - {path: [[0.9, 0.2], [1.0, 0.8]], label: crack tip}
    - {path: [[0.1, 0.1], [0, 0.4]], label: wire}
  points: [{at: [0.2, 0.2], label: well}, {at: [0, 0.4], label: on wall}]
spacing: 0.12
"""
INNER = {"crack tip", "wire", "fibre one-rim", "日本-rim"}


@pytest.fixture(scope="module")
def straight():
    return mesh_case(load_case("parts.yaml", text=CASE)).mesh


@pytest.fixture(scope="module")
def curved(straight):
    mesh, folded = straight.second_order()
    assert folded == 0
    return mesh


def given(mesh, folder, solver):
    """Write what a solver is to get as NAME parts."""
    write_files(mesh, {}, {}, MeshFiles(folder, "parts", FORMATS_FOR[solver]))


def counts(mesh):
    """Number of triangles of each region and of edges of each label, by id."""
    return {
        int(k): int(n)
        for ids in (facet_ids(mesh), region_ids(mesh))
        for k, n in zip(*np.unique(ids, return_counts=True), strict=True)
    }


def sizes(mesh):
    """Areas of the regions and lengths of the labels, by id."""
    length = np.hypot(*(mesh.points[mesh.facets[:, 1]] - mesh.points[mesh.facets[:, 0]]).T)
    area = signed_areas(mesh.points, mesh.triangles)
    found = np.bincount(facet_ids(mesh), length, 20) + np.bincount(region_ids(mesh), area, 20)
    return {group.id: found[group.id] for group in group_names(mesh).values() if group.dimension > 0}


def table(printed):
    """The numbers that a solver's script prints as JSON in its last line."""
    return {int(key): value for key, value in json.loads(printed.splitlines()[-1]).items()}


COUNT = """
import json
import numpy as np

found = [np.unique(tags, return_counts=True) for tags in ({labels}, {regions})]
print(json.dumps({{int(k): int(n) for ids, numbers in found for k, n in zip(ids, numbers)}}))
"""


def test_the_case_has_every_kind_of_group(straight):
    assert len(group_names(straight)) == 14
    assert {
        label
        for label in straight.labels
        if not straight.outer[straight.facet_labels == straight.labels.index(label)].any()
    } == INNER


def test_scikit_fem_finds_all_groups(straight, tmp_path):
    given(straight, tmp_path, "scikit-fem")
    read = skfem.MeshTri.load(tmp_path / "parts.msh")
    names = {group.id: name for name, group in group_names(straight).items()}
    found = {name: len(cells) for name, cells in {**read.boundaries, **read.subdomains}.items()}
    assert found == {names[k]: n for k, n in counts(straight).items() if names[k] not in INNER}


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("block", [0, 1], ids=["xdmf", "msh"])
def test_fenicsx_finds_all_groups(straight, curved, tmp_path, order, block):
    python = python_with("dolfinx", "mpi4py", *(["gmsh"] if block else []))
    if python is None:
        pytest.skip("dolfinx is not installed, so that its reading of the files is not tested")
    mesh = (straight, curved)[order - 1]
    given(mesh, tmp_path / "out", "fenicsx")
    code = blocks("FEniCSx", "python")[block].replace("disc", "parts").partition("ids =")[0]
    printed = run([python, "-c", code + COUNT.format(labels="labels.values", regions="regions.values")], tmp_path)
    assert table(printed) == counts(mesh)


@pytest.mark.long
@pytest.mark.parametrize("order", [1, 2])
def test_mfem_finds_all_groups(straight, curved, tmp_path, order):
    python = mfem_python()
    mesh = (straight, curved)[order - 1]
    given(mesh, tmp_path, "mfem")
    code = """
import mfem.ser as mfem
mesh = mfem.Mesh("parts.msh")
labels = [mesh.GetBdrAttribute(k) for k in range(mesh.GetNBE())]
regions = [mesh.GetAttribute(k) for k in range(mesh.GetNE())]
names = set(mesh.attribute_sets.GetAttributeSetNames()) | set(mesh.bdr_attribute_sets.GetAttributeSetNames())
print(json.dumps(sorted(names)))
"""
    printed = run([python, "-c", "import json\n" + code + COUNT.format(labels="labels", regions="regions")], tmp_path)
    assert table(printed) == counts(mesh)
    names, points = json.loads(printed.splitlines()[-2]), set(mesh.point_labels)
    assert set(names) - points == set(group_names(mesh)) - points


def test_freefem_measures_all_groups(straight, tmp_path):
    freefem = program("FreeFem++-nw", "FreeFem++")
    given(straight, tmp_path, "freefem")
    code = 'mesh Th = readmesh("parts.mesh");\ncout.precision(12);\n'
    for group in group_names(straight).values():
        if group.dimension > 0:
            code += f'cout << "size {group.id} " << int{group.dimension}d(Th, {group.id})(1.) << endl;\n'
    code += (
        'for (int i = 0; i < Th.nv; i++) if (Th(i).label > 12) cout << "node " << i << " " << Th(i).label << endl;\n'
    )
    (tmp_path / "parts.edp").write_text(code)
    printed = run([freefem, "-nw", "-v", "0", "parts.edp"], tmp_path)
    found = {int(number): float(size) for number, size in re.findall(r"^size (\d+) (\S+)", printed, flags=re.M)}
    assert found == pytest.approx(sizes(straight))
    nodes = [(int(node), int(number)) for node, number in re.findall(r"^node (\d+) (\d+)", printed, flags=re.M)]
    assert sorted(nodes) == sorted(zip(straight.labelled_nodes.tolist(), (13, 14), strict=True))


@pytest.mark.parametrize(("order", "tolerance"), [(1, 1e-5), (2, 2e-3)])
def test_calculix_knows_all_sets(straight, curved, tmp_path, order, tolerance):
    ccx = program("ccx")
    mesh = (straight, curved)[order - 1]
    given(mesh, tmp_path, "calculix")
    words = plain_words(mesh)
    deck = "*INCLUDE, INPUT=parts.inp\n"
    for k, region in enumerate(mesh.regions):
        deck += f"*MATERIAL, NAME=M{k}\n*ELASTIC\n{1000.0 * (k + 1)}, 0.3\n"
        deck += f"*SOLID SECTION, ELSET={words[region]}, MATERIAL=M{k}\n1.\n"
    deck += (
        f"*BOUNDARY\nleft, 1, 2\n{words['on wall']}, 1, 2\n*STEP\n*STATIC\n*DSLOAD\nbore, P, 1.\n*CLOAD\nwell, 1, 1.\n"
    )
    for region in mesh.regions:
        deck += f"*EL PRINT, ELSET={words[region]}, TOTALS=ONLY\nEVOL\n"
    for label in (*mesh.labels, *mesh.point_labels):
        deck += f"*NODE PRINT, NSET={words[label]}\nU\n"
    (tmp_path / "deck.inp").write_text(deck + "*END STEP\n")
    assert "*ERROR" not in run([ccx, "deck"], tmp_path)
    printed = (tmp_path / "deck.dat").read_text()
    volumes = {name: float(value) for name, value in re.findall(r"total volume for set (\S+).*?\n\n +(\S+)", printed)}
    exact = {"matrix": 1.8 - 0.08 * np.pi, "fibre one": 0.04 * np.pi, "日本": 0.2}
    area = dict(zip(group_names(mesh).values(), group_names(mesh), strict=True))
    expected = (
        exact if order == 2 else {name: sizes(mesh)[group.id] for group, name in area.items() if group.dimension == 2}
    )
    assert volumes == pytest.approx({words[name].upper(): size for name, size in expected.items()}, rel=tolerance)
    rows = {
        name: len(re.findall(r"^ +\d+ ", part, flags=re.M))
        for name, part in re.findall(r"for set (\S+) and time.*?\n\n((?: +\d+ .*\n)+)", printed)
    }
    nodes = {label: len(np.unique(mesh.facets[mesh.facet_labels == k])) for k, label in enumerate(mesh.labels)}
    nodes |= dict.fromkeys(mesh.point_labels, 1)
    assert rows == {words[label].upper(): count for label, count in nodes.items()}


def test_openfoam_has_patches_zones_of_cells_and_zones_of_faces(straight, tmp_path):
    program("gmshToFoam")
    given(straight, tmp_path / "out", "openfoam")
    (lines,) = blocks("OpenFOAM", "sh")
    empty = {"createPatchDict": "pointSync false; patches ();\n"}
    lines = lines.replace("disc", "parts").replace("checkMesh", "createPatch -overwrite\ncheckMesh")
    printed = openfoam(tmp_path, lines, SYSTEM | empty)
    assert "Mesh OK." in printed
    words, number = plain_words(straight, reserved=("FRONT", "BACK"), dimensions=(1, 2)), counts(straight)
    expected = {words[name]: number[group.id] for name, group in group_names(straight).items() if group.dimension > 0}
    inner = {words[name] for name in INNER}
    patches = dict(
        re.findall(
            r"^ +(\S+)\n +{[^}]*?nFaces +(\d+);", (tmp_path / "constant/polyMesh/boundary").read_text(), flags=re.M
        )
    )
    sides = {"front": len(straight.triangles), "back": len(straight.triangles)}
    labels = {words[name] for name in straight.labels}
    assert {name: int(count) for name, count in patches.items()} == sides | {
        name: expected[name] for name in labels - inner
    }
    regions = labels ^ set(expected)
    table = dict(re.findall(r"^ +(\S+) +(\d+) +\d+ +\S+ +\(", printed, flags=re.M))
    assert {name: int(table[name]) for name in regions} == {name: expected[name] for name in regions}
    zones = dict(re.findall(r"^ +(\S+) +(\d+) +\d+ +ok", printed.partition("faceZone topology")[2], flags=re.M))
    assert {name: int(count) for name, count in zones.items()} == {name: expected[name] for name in inner}
