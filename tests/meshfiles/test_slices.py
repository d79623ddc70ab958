"""Meshes in slices: their files are those of the same mesh as a whole, with the slices as its partition."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from xml.etree import ElementTree as ET

import h5py
import numpy as np
import pytest
from format_names import IN_SLICES

from bubblemesh.case import load_case
from bubblemesh.meshes.division import GEOMETRY
from bubblemesh.meshes.partition import Partition
from bubblemesh.meshfiles.formats import FORMATS
from bubblemesh.meshfiles.groups import group_names, region_ids
from bubblemesh.meshfiles.mesh_files import MeshFiles
from bubblemesh.meshfiles.read import read_mesh
from bubblemesh.meshfiles.writing import write_files
from bubblemesh.parts.store import InFolder, Keeping
from bubblemesh.process import watchdog
from bubblemesh.process.limits import within
from bubblemesh.run.packing import RunOptions
from bubblemesh.run.pipeline import run_case

PLATE = """
domain:
  outer: {rectangle: [0, 0, 4, 3], labels: [bottom, right, top, left]}
  holes:
    - {circle: {center: [2, 1.4], radius: 0.3}, label: bore}
  region: matrix
  regions:
    - {name: bar, ring: {rectangle: [0, 2.6, 4, 2.8]}}
    - {name: corner, ring: {rectangle: [3.5, 0.2, 3.8, 0.5]}}
    - {name: stud, ring: {polygon: [[0.4, 1], [0.47, 1], [0.435, 1.06]]}}
  lines:
    - {path: [[0.4, 0.3], [3.2, 0.7]], label: crack}
  points:
    - {at: [3.5, 1.5], label: well}
    - {at: [1, 2], label: probe}
  periodic: [[left, right]]
spacing: 0.07
parts: 5
packing: {effort: fast}
output: {ids: {bar: 3, bore: 3, stud: 71, probe: 5}}
"""
AREAS = """
domain:
  outer:
    - {rectangle: [0, 0, 2, 2]}
    - {rectangle: [3, 0, 5, 2]}
spacing: 0.08
parts: 3
packing: {effort: fast}
"""
DISC = """
domain: {outer: {circle: {center: [0, 0], radius: 1}}}
spacing: 0.04
parts: 3
packing: {effort: fast}
"""
CASES = {"plate": PLATE, "areas": AREAS, "disc": DISC}
WITHOUT_PARTITION = ("xdmf", "nodes.npz", "nodes.csv")


def sliced_of(text, folder):
    """The mesh of a case in slices, which are kept in a folder."""
    case = load_case("parts.yaml", text=text)
    kept = Keeping(lambda name: InFolder(folder), in_slices=True)
    return run_case(case, RunOptions(keeping=kept)).mesh


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


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Meshes of the cases by their names, each made once."""
    known = {}

    def mesh(name):
        if name not in known:
            known[name] = sliced_of(CASES[name], tmp_path_factory.mktemp(name))
        return known[name]

    return mesh


@pytest.fixture(params=CASES)
def both(made, request, tmp_path):
    """Folders with the files of a mesh in slices, and of the same mesh as a whole, in the format of the test."""
    form, sliced = request.function.form, made(request.param)
    mesh, fields = joined(sliced)
    if form in WITHOUT_PARTITION:
        mesh = replace(mesh, partition=None)
    folders = tmp_path / "sliced", tmp_path / "whole"
    files = [
        write_files(each, data, {}, MeshFiles(folder, "mesh", [form]))["files"]
        for each, data, folder in zip((sliced, mesh), ({}, fields), folders, strict=True)
    ]
    assert files[0] == files[1]
    assert {*files[0]} == {path.name for path in folders[0].iterdir()}
    return folders


def written_by(form):
    """Mark a test of what a format's writers do."""

    def marked(test):
        test.form = form
        return test

    return marked


def test_the_cases_have_what_tells_writers_apart(made):
    plate, disc, areas = made("plate"), made("disc"), made("areas")
    mesh, _ = joined(plate)
    holders = [np.unique(mesh.partition.owner[mesh.triangle_regions == k]) for k in range(len(mesh.regions))]
    assert [len(parts) for parts in holders] == [5, 2, 1, 1]
    known = np.concatenate([mesh.facets.ravel(), mesh.partition.interfaces[:, 2]])
    assert set(mesh.triangles[mesh.triangle_regions == 3].ravel()) <= set(known.tolist())  # no nodes of its own
    assert len(mesh.periodic)
    assert len(mesh.labelled_nodes) == 2
    assert np.diff(mesh.partition.node_parts.starts).max() == 3
    assert plate.sizes[:, 0].min() == 0
    assert disc.sizes[:, 0].min() > 100
    assert {(0, 2), (1, 2)} - {tuple(pair) for pair in joined(areas)[0].partition.interfaces[:, :2].tolist()}
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


@pytest.mark.solver
def test_gmsh_knows_the_parts(made, gmsh, tmp_path):
    sliced = made("plate")
    mesh, _ = joined(sliced)
    write_files(sliced, {}, {}, MeshFiles(tmp_path, "mesh", ["msh4"]))
    gmsh.open(str(tmp_path / "mesh.msh"))
    assert gmsh.model.getNumberOfPartitions() == len(sliced.sizes)
    assert {gmsh.model.getPhysicalName(*g): g[::-1] for g in gmsh.model.getPhysicalGroups()} == group_names(mesh)
    tags, points, _ = gmsh.model.mesh.getNodes()
    np.testing.assert_array_equal(points.reshape(-1, 3)[np.argsort(tags), :2], mesh.points)
    first = len(mesh.labelled_nodes) + len(mesh.facets) + 1
    owner, group = np.full((2, len(mesh.triangles)), -1)
    for dimension, tag in gmsh.model.getEntities(2):
        if gmsh.model.getType(dimension, tag) == "Ghost surface":
            (part,) = gmsh.model.getPartitions(dimension, tag)
            ghosts, _ = gmsh.model.mesh.getGhostElements(dimension, tag)
            assert sorted(ghosts - first) == mesh.partition.halo(part - 1).tolist()
        elif len(parts := gmsh.model.getPartitions(dimension, tag)):
            _, (elements,), (nodes,) = gmsh.model.mesh.getElements(dimension, tag)
            owner[elements - first] = parts[0] - 1
            group[elements - first] = gmsh.model.getPhysicalGroupsForEntity(dimension, tag)[0]
            np.testing.assert_array_equal(nodes.reshape(-1, 3) - 1, mesh.triangles[elements - first])
    np.testing.assert_array_equal(owner, mesh.partition.owner)
    np.testing.assert_array_equal(group, region_ids(mesh))


@pytest.mark.solver
def test_processes_of_vtk_read_their_pieces(made, tmp_path):
    vtk = pytest.importorskip("vtk")
    from vtk.util.numpy_support import vtk_to_numpy

    sliced = made("plate")
    mesh, _ = joined(sliced)
    write_files(sliced, {}, {}, MeshFiles(tmp_path, "mesh", ["pvtu"]))
    for part in range(len(sliced.sizes)):
        reader = vtk.vtkXMLPUnstructuredGridReader()
        reader.SetFileName(str(tmp_path / "mesh.pvtu"))
        reader.UpdateInformation()
        reader.UpdatePiece(part, len(sliced.sizes), 1)
        grid = reader.GetOutput()
        numbers = vtk_to_numpy(grid.GetCellData().GetArray("GlobalElementId"))
        own = numbers[vtk_to_numpy(grid.GetCellGhostArray()) == 0]
        assert sorted(own) == np.flatnonzero(mesh.partition.owner == part).tolist()
        assert set(mesh.partition.halo(part)) <= set(numbers)


@pytest.mark.parametrize("form", ["pvtu", "msh4", "xdmf"])
def test_what_is_written_in_slices_is_read_as_a_whole(made, form, tmp_path):
    sliced = made("plate")
    mesh, _ = joined(sliced)
    path = tmp_path / write_files(sliced, {}, {}, MeshFiles(tmp_path, "mesh", [form]))["files"][0]
    read = read_mesh(path).mesh
    assert (len(read.points), len(read.triangles)) == (sliced.nodes, sliced.triangles)
    assert set(read.regions) == set(mesh.regions)


def test_a_time_limit_does_not_stop_the_hdf5_library_half_way(made, tmp_path, monkeypatch):
    for name in ("GRACE", "GRACE_SHARE"):
        monkeypatch.setattr(watchdog, name, 0.0)
    sliced = made("disc")

    def slowly(part):
        end = perf_counter() + 0.1
        while perf_counter() < end:
            pass
        return sliced.read(part)

    slow, path = replace(sliced, read=slowly), tmp_path / "disc.xdmf"
    within(lambda: FORMATS["xdmf"].write_slices(slow, path), 0.05, None, perf_counter())
    assert len(read_mesh(path).mesh.triangles) == sliced.triangles


FULL_DISK = """
import resource, sys
from dataclasses import replace
from pathlib import Path
sys.path[:0] = sys.argv[1], str(Path(sys.argv[1]).parent)
import h5py, meshio
import numpy as np
from format_names import IN_SLICES
from squares import fields_of, holed_square
from bubblemesh.errors import FileError
from bubblemesh.meshes.slices import Slice, SlicedMesh
from bubblemesh.meshfiles.mesh_files import MeshFiles
from bubblemesh.meshfiles.writing import write_files

def read(number):
    mine = halves[number]
    data = {name: values[mine] for name, values in fields.items()}
    return Slice(np.zeros((0, 2)), mesh.triangles[mine], mesh.triangle_regions[mine], data)

mesh, folder = holed_square(60), Path(sys.argv[2])
fields, halves = fields_of(mesh), np.array_split(np.arange(len(mesh.triangles)), 2)
sizes = np.array([(0, len(half)) for half in halves])
frame = replace(mesh, triangles=mesh.triangles[:0], triangle_regions=[])
sliced = SlicedMesh(frame, mesh.outer, sizes, tuple(fields), read)
for limit in (500, 2_000, 60_000, 150_000):
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
    for form in IN_SLICES:
        try:
            write_files(sliced, {}, {}, MeshFiles(folder, "plate", [form]))
        except FileError as error:
            print(form, limit, error)
            assert not [*folder.iterdir()]
        else:
            for path in folder.iterdir():
                path.unlink()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no limit on the size of files")
def test_a_disk_that_fills_up_while_slices_are_written(tmp_path):
    command = [sys.executable, "-B", "-W", "error", "-c", FULL_DISK, str(Path(__file__).parent), str(tmp_path)]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr) == (0, "")
    told = [line.split(" ", 2) for line in run.stdout.splitlines()]
    assert {message for *_, message in told} == {f"cannot write {tmp_path}: File too large"}
    assert {form for form, limit, _ in told if limit == "500"} == {*IN_SLICES}
    assert {limit for form, limit, _ in told if form == "xdmf"} == {"500", "2000", "60000", "150000"}


LIMITED_RUN = """
import resource, sys
from bubblemesh.cli import app
from bubblemesh.run import destination

write = destination.write_files
def limited(*arguments, **options):
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, resource.RLIM_INFINITY))
    return write(*arguments, **options)

destination.write_files = limited
app()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no limit on the size of files")
def test_a_run_whose_slices_do_not_fit_on_the_disk_ends_with_an_error_and_no_file(tmp_path):
    (tmp_path / "case.yaml").write_text("name: disc" + DISC.replace("0.04", "0.08"), encoding="utf-8")
    options = ["--format", "xdmf", "--jobs", "1", "-o", str(tmp_path / "out")]
    command = [sys.executable, "-B", "-c", LIMITED_RUN, "run", str(tmp_path / "case.yaml"), *options]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (run.returncode, run.stdout) == (5, ""), run.stderr
    assert run.stderr.endswith(f"cannot write {tmp_path / 'out'}: File too large\n")
    assert not (tmp_path / "out").exists()
