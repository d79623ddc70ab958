"""Meshes in slices: their files are those of the same mesh as a whole, with the slices as its partition."""

import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree as ET

import h5py
import meshio
import numpy as np
import pytest

from bubblemesh.case import load_case
from bubblemesh.errors import FileError
from bubblemesh.meshes.division import GEOMETRY
from bubblemesh.meshes.partition import Partition
from bubblemesh.meshes.sliced import SlicedMesh
from bubblemesh.meshfiles.formats import FORMATS
from bubblemesh.meshfiles.read import read_mesh
from bubblemesh.meshfiles.writing import write_files
from bubblemesh.parts.store import InFolder
from bubblemesh.parts.work import alone
from bubblemesh.run.pipeline import mesh_case_in_slices

PLATE = """
domain:
  outer: {rectangle: [0, 0, 4, 3], labels: [bottom, right, top, left]}
  holes:
    - {circle: {center: [2, 1.4], radius: 0.3}, label: bore}
  region: matrix
  regions:
    - {name: bar, ring: {rectangle: [0, 2.6, 4, 2.8]}}
    - {name: corner, ring: {rectangle: [3.5, 0.2, 3.8, 0.5]}}
  lines:
    - {path: [[0.4, 0.3], [3.2, 0.7]], label: crack}
  points:
    - {at: [3.5, 1.5], label: well}
    - {at: [1, 2], label: probe}
  periodic: [[left, right]]
spacing: 0.055
parts: 4
"""
AREAS = """
domain:
  outer:
    - {rectangle: [0, 0, 2, 2]}
    - {rectangle: [3, 0, 5, 2]}
spacing: 0.06
parts: 2
"""
FLAT = """
domain: {outer: {circle: {center: [0, 0], radius: 1}}}
spacing: 0.03
parts: 3
"""
CASES = {"plate": PLATE, "areas": AREAS, "disc": FLAT}
IN_SLICES = [name for name, form in FORMATS.items() if form.slices is not None]


def sliced_of(text, folder):
    """The mesh of a case in slices, which are kept in a folder."""
    case = load_case("parts.yaml", text=text)
    return mesh_case_in_slices(case, lambda scale: InFolder(folder), lambda row: None, lambda share: None, alone).mesh


def joined(sliced):
    """The same mesh as a whole with the slices as its partition, and its fields."""
    parts = list(sliced.slices())
    triangles, regions = (np.concatenate([part[k] for part in parts]) for k in (1, 2))
    owner = np.repeat(np.arange(len(parts)), [len(part.triangles) for part in parts])
    mesh = replace(
        sliced.frame,
        points=np.concatenate([sliced.frame.points, *(part.points for part in parts)]),
        triangles=triangles,
        triangle_regions=regions,
        partition=Partition(triangles, owner, len(parts), GEOMETRY),
    )
    return mesh, {name: np.concatenate([part.fields[name] for part in parts]) for name in sliced.fields}


@pytest.fixture(scope="module", params=CASES)
def sliced(request, tmp_path_factory):
    return sliced_of(CASES[request.param], tmp_path_factory.mktemp("parts"))


@pytest.fixture
def both(sliced, request, tmp_path):
    """Folders with the files of the mesh in slices, and of the same mesh as a whole."""
    form, mesh, fields = request.param, *joined(sliced)
    if form in ("xdmf", "nodes.npz", "nodes.csv"):
        mesh = replace(mesh, partition=None)
    folders = tmp_path / "sliced", tmp_path / "whole"
    files = [
        write_files(each, data, {}, folder, "mesh", [form])["files"]
        for each, data, folder in zip((sliced, mesh), ({}, fields), folders, strict=True)
    ]
    assert files[0] == files[1] == [name for name in files[0] if (folders[0] / name).is_file()]
    return folders


def written_by(form):
    return pytest.mark.parametrize("both", [form], indirect=True)


def test_the_cases_have_what_tells_writers_apart():
    with tempfile.TemporaryDirectory() as folder:
        plate = sliced_of(PLATE, Path(folder))
        mesh, _ = joined(plate)
        holders = [np.unique(mesh.partition.owner[mesh.triangle_regions == k]) for k in range(len(mesh.regions))]
        assert [len(parts) for parts in holders] == [4, 2, 1]
        assert len(mesh.periodic)
        assert len(mesh.labelled_nodes) == 2
        assert (plate.sizes[:, 0] > 100).all()
        _, part, _, starts = mesh.partition.node_parts
        assert np.diff(starts).max() == 3
        np.testing.assert_array_equal(mesh.outer, plate.outer)


@written_by("msh4")
def test_msh4_is_the_same_to_the_byte(both):
    sliced, whole = ((folder / "mesh.msh").read_bytes() for folder in both)
    assert sliced == whole


@written_by("nodes.csv")
def test_the_table_of_nodes_is_the_same_to_the_byte(both):
    sliced, whole = ((folder / "mesh.nodes.csv").read_bytes() for folder in both)
    assert sliced == whole


@written_by("nodes.npz")
def test_the_arrays_of_nodes_are_the_same(both):
    sliced, whole = (np.load(folder / "mesh.nodes.npz") for folder in both)
    assert sliced.files == whole.files
    for name in whole.files:
        assert sliced[name].dtype == whole[name].dtype
        np.testing.assert_array_equal(sliced[name], whole[name])


@written_by("pvtu")
def test_pieces_of_vtk_are_the_same_to_the_byte(both):
    names = sorted(path.name for path in both[1].glob("*.*vtu"))
    assert len(names) > 2
    for name in names:
        assert (both[0] / name).read_bytes() == (both[1] / name).read_bytes(), name


@written_by("xdmf")
def test_data_sets_of_xdmf_are_the_same(both):
    for name in ("mesh", "mesh_facets"):
        sliced, whole = (list(ET.parse(folder / f"{name}.xdmf").iter()) for folder in both)
        assert [(each.tag, each.attrib, each.text) for each in sliced] == [
            (each.tag, each.attrib, each.text) for each in whole
        ]
        with h5py.File(both[0] / f"{name}.h5") as mine, h5py.File(both[1] / f"{name}.h5") as theirs:
            assert list(mine) == list(theirs)
            for key in theirs:
                assert mine[key].dtype == theirs[key].dtype
                np.testing.assert_array_equal(mine[key], theirs[key])
