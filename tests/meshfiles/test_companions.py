"""Files that mesh files lead to travel with them."""

import sys
from contextlib import suppress

import meshio
import numpy as np
import pytest
from commands import command
from squares import holed_square

from bubblemesh.errors import CaseError, FileError
from bubblemesh.files import local_copies, local_copy
from bubblemesh.meshfiles.read import read_mesh
from bubblemesh.meshfiles.sources.table import BY_MESHIO, FORMATS, SELF_CONTAINED, SourceFormat, files_beside

POINTS, CELLS = [[0.0, 0], [1, 0], [0, 1]], [("triangle", [[0, 1, 2]])]


def pvtu(folder):
    holed_square().partitioned(2).write(folder / "a.pvtu")
    return folder / "a.pvtu", {"a_0.vtu", "a_1.vtu"}


def pvd(folder):
    (folder / "below").mkdir()
    pvtu(folder / "below")
    collection = (
        '<Collection><DataSet timestep="0" file="old.vtu"/><DataSet timestep="1" file="below/a.pvtu"/></Collection>'
    )
    (folder / "a.pvd").write_text(f'<VTKFile type="Collection">{collection}</VTKFile>')
    return folder / "a.pvd", {"a.pvtu", "a_0.vtu", "a_1.vtu"}


def xdmf(folder):
    meshio.Mesh(POINTS, CELLS).write(folder / "a.xdmf")
    (folder / "a.h5").rename(folder / "other.h5")
    (folder / "a.xdmf").write_text((folder / "a.xdmf").read_text().replace("a.h5:", "other.h5:"))
    return folder / "a.xdmf", {"other.h5"}


def pair(folder):
    (folder / "a.node").write_text("3 2 0 0\n0 0 0\n1 1 0\n2 0 1\n")
    (folder / "a.ele").write_text("1 3 0\n0 0 1 2\n")
    return folder / "a.ele", {"a.node"}


def dolfin(folder):
    (folder / "a[1].xml").write_text(
        '<dolfin><mesh celltype="triangle" dim="2"><vertices size="3"><vertex index="0" x="0" y="0"/><vertex index="1" '
        'x="1" y="0"/><vertex index="2" x="0" y="1"/></vertices><cells size="1"><triangle index="0" v0="0" v1="1" '
        'v2="2"/></cells></mesh></dolfin>'
    )
    (folder / "a[1]_marks.xml").write_text("<dolfin/>")
    return folder / "a[1].xml", {"a[1]_marks.xml"}


@pytest.mark.parametrize("made", [pvtu, pvd, xdmf, pair, dolfin])
def test_copies_of_all_files_are_as_good_as_these(made, tmp_path):
    path, names = made(tmp_path)
    others = files_beside(path)
    assert {other.name for other in others} == names
    mesh = read_mesh(path).mesh
    contents = {str(each): each.read_bytes() for each in [path, *others]}
    with local_copies(contents):
        assert local_copy(path) != path
        for each in [path, *others]:
            each.unlink()
        np.testing.assert_array_equal(read_mesh(path).mesh.points, mesh.points)


def test_untrusted_cases_read_formats_that_are_said_to_be_self_contained():
    assert not SourceFormat("new.read_new").self_contained
    assert not any(FORMATS[ending].beside or FORMATS[ending].reader == BY_MESHIO for ending in SELF_CONTAINED)


@pytest.fixture(scope="module")
def opened_files():
    """Names of all files that are opened, as long as there are tests that look at them."""
    names, over = [], []
    sys.addaudithook(lambda event, args: over or event != "open" or names.append(str(args[0])))
    yield names
    over.append(True)


@pytest.mark.parametrize("ending", SELF_CONTAINED)
def test_formats_that_are_self_contained_open_no_other_file(ending, tmp_path, opened_files):
    path = tmp_path / f"a{ending}"
    try:
        holed_square().write(path, sidecars=False)
    except CaseError:  # a format that is not written
        path.write_text("a")
    opened_files.clear()
    with suppress(FileError):
        read_mesh(path)
    assert {name for name in opened_files if name.startswith(str(tmp_path))} == {str(path)}


@pytest.mark.parametrize("content", [b"", b"<VTKFile>", b"\0", b"<VTKFile><Collection/></VTKFile>"])
@pytest.mark.parametrize("ending", [".pvd", ".pvtu", ".xdmf"])
def test_a_damaged_list_leads_nowhere(content, ending, tmp_path):
    path = tmp_path / f"a{ending}"
    path.write_bytes(content)
    assert files_beside(path) == []
    assert files_beside(tmp_path / f"{'x' * 300}.node") == []


@pytest.mark.usefixtures("workers_in_threads")
def test_a_batch_reads_all_parts_of_a_field(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    plate = "domain: {outer: {rectangle: [0, 0, 4, 2]}}\n"
    (tmp_path / "b.yaml").write_text(f"{plate}spacing: 0.5\n")
    (tmp_path / "f.yaml").write_text(f"{plate}spacing: {{field: {{file: p/b.pvtu, name: target_spacing}}}}\n")
    assert command("run", "b.yaml", "-o", "p/", "--format", "pvtu", "--partition", "2", "-q")[0] == 0
    assert command("run", "f.yaml", "-o", "one/", "-q")[0] == 0
    words = "batch", "f.yaml", "-o", "all", "--jobs", "1", "-q", "--resume"
    assert command(*words)[0] == 0
    assert (tmp_path / "all/f.msh").read_bytes() == (tmp_path / "one/f.msh").read_bytes()
    part = tmp_path / "p/b_1.vtu"
    part.write_bytes(part.read_bytes() + b"\n")
    before = (tmp_path / "all/f.report.json").stat().st_mtime_ns
    assert command(*words)[0] == 0
    assert (tmp_path / "all/f.report.json").stat().st_mtime_ns > before  # it has been meshed again
