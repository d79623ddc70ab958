import dataclasses
import errno
import io
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np
import pytest
from format_names import ALL
from squares import fields_of, holed_square

from bubblemesh.errors import CaseError, FileError
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.groups import facet_ids, group_names, region_ids
from bubblemesh.meshfiles.mesh_files import MeshFiles
from bubblemesh.meshfiles.text import json_ready, json_text
from bubblemesh.meshfiles.transaction import transaction
from bubblemesh.meshfiles.writing import write_file, write_files, write_stream

ALL_FILES = [
    *("plate.msh", "plate.vtu", "plate.vtk", "plate.xdmf", "plate.h5", "plate_facets.xdmf", "plate_facets.h5"),
    *("plate.pvtu", "plate_0.vtu"),
    *(
        "plate.mesh",
        "plate.pos",
        "plate.inp",
        "plate.su2",
        "plate.med",
        "plate.dat",
        "plate.nodes.csv",
        "plate.nodes.npz",
    ),
    *("plate.gr3", "plate.2dm", "plate.slf", "plate.cli"),
    *("plate.labels.json", "plate.report.json"),
]


@pytest.fixture(scope="module")
def mesh():
    return holed_square()


@pytest.fixture(scope="module")
def fields(mesh):
    return fields_of(mesh)


def meshes(folder):
    """Contents of all files but the report, which holds times."""
    return {name: data for name, data in contents(folder).items() if not name.endswith(".report.json")}


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


# Groups


def test_ids_start_at_one_and_never_collide(mesh):
    assert set(facet_ids(mesh)) == {1, 2, 3, 4, 5}
    assert set(region_ids(mesh)) == {6}
    assert group_names(mesh) == {
        **{"bottom": (1, 1), "right": (2, 1), "top": (3, 1), "left": (4, 1), "hole": (5, 1)},
        "domain": (6, 2),
    }


def test_a_label_named_like_the_region_keeps_its_name():
    groups = group_names(holed_square(labels=("domain", "a", "b", "c", "domain_region")))
    assert groups["domain"] == (1, 1)
    assert groups["domain_region"] == (5, 1)
    assert groups["domain_region_region"] == (6, 2)


def test_many_names_are_each_looked_up_a_few_times():
    looked = []

    class Name(str):
        def __hash__(self):
            looked.append(self)
            return super().__hash__()

    names = tuple(Name(f"point {k}") for k in range(500))
    mesh = dataclasses.replace(
        holed_square(), labelled_nodes=np.zeros(500, int), node_labels=np.arange(500), point_labels=names
    )
    assert len(group_names(mesh)) == 500 + len(mesh.labels) + len(mesh.regions)
    assert len(looked) < 10 * 500


@pytest.mark.parametrize("label", ['say "hi"', "back\\slash", "two\nlines", "bell\a"])
@pytest.mark.parametrize("ending", ["msh", "xdmf"])
def test_a_label_that_no_file_can_hold_is_refused(tmp_path, label, ending):
    bad = holed_square(labels=("a", "b", "c", "d", label))
    with pytest.raises(CaseError, match="label"):
        write_files(bad, fields_of(bad), {}, MeshFiles(tmp_path / "new", "plate", [ending]))
    assert list(tmp_path.iterdir()) == []


# The set of files of a run


def test_all_files_of_a_run_appear_and_the_report_lists_them(mesh, fields, tmp_path, capfd):
    folder = tmp_path / "deep" / "down"
    files = write_files(mesh, fields, {"nodes": np.int64(7), "files": []}, MeshFiles(folder, "plate", ALL))["files"]
    assert files == ALL_FILES
    assert sorted(contents(folder)) == sorted(files)
    report = json.loads((folder / "plate.report.json").read_text())
    assert report["nodes"] == 7
    assert report["files"] == files
    assert report["seconds"]["total"] == report["seconds"]["writing"] > 0
    assert capfd.readouterr() == ("", "")


def test_line_ends_are_the_same_on_every_system(mesh, fields, tmp_path, monkeypatch):
    def only_with_a_line_end(path, text, *more, newline=None, **options):
        assert newline == "\n", path

    monkeypatch.setattr(Path, "write_text", only_with_a_line_end)
    write_files(mesh, fields, {}, MeshFiles(tmp_path, "plate", ["msh"]), {".rounds.csv": "a\n"}, lambda report: "<p>\n")
    assert (tmp_path / "plate.rounds.csv").read_bytes() == b"a\n"


def test_the_same_mesh_gives_the_same_bytes(mesh, fields, tmp_path):
    for folder in ("a", "b"):
        write_files(mesh, fields, {}, MeshFiles(tmp_path / folder, "plate", ALL))
    assert meshes(tmp_path / "a") == meshes(tmp_path / "b")


def test_the_callers_report_and_fields_stay_as_they_are(mesh, fields, tmp_path):
    report, before = {"a": 1}, {name: values.copy() for name, values in fields.items()}
    write_files(mesh, fields, report, MeshFiles(tmp_path, "plate", ALL))
    assert report == {"a": 1}
    assert list(before) == list(fields)
    for name in before:
        np.testing.assert_array_equal(before[name], fields[name])


def test_a_dot_in_the_name_is_part_of_it(mesh, fields, tmp_path):
    files = write_files(mesh, fields, {}, MeshFiles(tmp_path, "plate.v2", ["xdmf"]))["files"]
    assert files == [
        "plate.v2.xdmf",
        "plate.v2.h5",
        "plate.v2_facets.xdmf",
        "plate.v2_facets.h5",
        "plate.v2.labels.json",
        "plate.v2.report.json",
    ]
    assert sorted(contents(tmp_path)) == sorted(files)


@pytest.mark.parametrize("ending", ALL)
def test_one_file_by_its_ending(mesh, fields, tmp_path, ending):
    files = write_file(mesh, fields, {"a": 1}, tmp_path / "new" / f"one.{ending}")["files"]
    assert files[0] == f"one.{ending}"
    assert files[-1] == "one.report.json"
    assert sorted(contents(tmp_path / "new")) == sorted(files)


def test_write_file_and_write_files_agree(mesh, fields, tmp_path):
    write_file(mesh, fields, {}, tmp_path / "a" / "plate.msh")
    write_files(mesh, fields, {}, MeshFiles(tmp_path / "b", "plate", ["msh"]))
    assert meshes(tmp_path / "a") == meshes(tmp_path / "b")


@pytest.mark.parametrize("name", ["mesh.stl", "mesh", "mesh.STL", "msh", ".msh", "mesh."])
def test_an_unknown_ending_names_the_known_ones(mesh, fields, tmp_path, name):
    with pytest.raises(CaseError, match=r"\.msh, \.vtu, \.vtk, \.xdmf"):
        write_file(mesh, fields, {}, tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_endings_may_be_in_capital_letters(mesh, fields, tmp_path):
    assert mesh.write(tmp_path / "A.MSH") == ["A.MSH"]
    np.testing.assert_array_equal(Mesh.read(tmp_path / "A.MSH").triangles, mesh.triangles)
    assert mesh.write(tmp_path / "a.XDMF") == ["a.XDMF", "a.h5", "a_facets.xdmf", "a_facets.h5"]
    np.testing.assert_array_equal(Mesh.read(tmp_path / "a.XDMF").triangles, mesh.triangles)
    assert write_file(mesh, fields, {}, tmp_path / "b.Nodes.CSV")["files"][0] == "b.Nodes.CSV"
    names = {path.name for path in tmp_path.iterdir()}
    assert {"A.MSH", "a.XDMF", "b.Nodes.CSV"} <= names
    assert not {"A.msh", "a.xdmf", "b.nodes.csv"} & names
    mesh.plot(tmp_path / "d.PNG")
    assert (tmp_path / "d.PNG").read_bytes().startswith(b"\x89PNG")


def test_an_unknown_format_names_the_known_ones(mesh, fields, tmp_path):
    with pytest.raises(CaseError, match="msh, vtu, vtk, xdmf"):
        write_files(mesh, fields, {}, MeshFiles(tmp_path, "plate", ["msh", "stl"]))
    with pytest.raises(CaseError, match="msh, vtu, vtk, xdmf"):
        write_stream(mesh, fields, "stl", io.BytesIO())
    assert list(tmp_path.iterdir()) == []


def test_the_same_output_twice_is_refused(mesh, fields, tmp_path):
    with pytest.raises(FileError, match=r"plate\.vtu.*more than one") as caught:
        write_files(mesh, fields, {}, MeshFiles(tmp_path, "plate", ["vtu", "msh", "vtu"]))
    assert caught.value.exit_code == 5
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["", ".", "..", "a/b", "../a", "/etc/a", "a\\b", "a\0b", "a\nb"])
def test_a_name_with_a_path_in_it_is_refused(mesh, fields, tmp_path, name):
    with pytest.raises(CaseError, match="name"):
        write_files(mesh, fields, {}, MeshFiles(tmp_path / "new", name, ["msh"]))
    assert list(tmp_path.iterdir()) == []


def test_a_name_may_have_as_many_bytes_as_its_longest_ending_leaves(mesh, fields, tmp_path):
    name = "é" * 121  # and 12 bytes of .report.json
    write_files(mesh, fields, {}, MeshFiles(tmp_path, name, ["vtu"]))
    (written,) = mesh.write(tmp_path / f"{name}éééé.msh")
    assert len(Mesh.read(tmp_path / written).triangles) == len(mesh.triangles)  # though no file of labels can be there
    with pytest.raises(CaseError, match=r"is too long a name: with \.report\.json it has 256 bytes"):
        write_files(mesh, fields, {}, MeshFiles(tmp_path, f"{name}aa", ["msh"]))
    with pytest.raises(CaseError, match=r"with \.msh it has 256 bytes"):
        mesh.write(tmp_path / f"{'é' * 126}.msh")


def test_a_colon_is_refused_for_xdmf_only(mesh, fields, tmp_path):
    write_files(mesh, fields, {}, MeshFiles(tmp_path / "a", "t=1:5", ["msh"]))
    with pytest.raises(CaseError, match="colon"):
        write_files(mesh, fields, {}, MeshFiles(tmp_path / "b", "t=1:5", ["xdmf"]))


# All or nothing


class WriterError(Exception):
    pass


def stage(folder, names, failure=None):
    """Write new files to the folder in one transaction that fails at its end if told so."""
    with transaction(folder) as staging:
        for name in names:
            (staging / name).write_text("new")
        if failure is not None:
            raise failure


@pytest.mark.parametrize("failure", [WriterError, KeyboardInterrupt, SystemExit])
def test_a_failure_midway_leaves_the_old_files(mesh, fields, tmp_path, monkeypatch, failure):
    for file in ALL_FILES:
        (tmp_path / file).write_text("old")
    before = contents(tmp_path)

    def fail(mesh, fields, path):
        path.write_text("half")
        raise failure

    monkeypatch.setattr("bubblemesh.meshfiles.write.viewers.write_vtk", fail)
    with pytest.raises(failure):
        write_files(mesh, fields, {}, MeshFiles(tmp_path, "plate", ["msh", "vtu", "vtk"]))
    assert contents(tmp_path) == before


def test_a_failure_removes_the_folders_it_made(tmp_path):
    with pytest.raises(WriterError):
        stage(tmp_path / "a" / "b", ["half"], WriterError())
    assert list(tmp_path.iterdir()) == []


def test_nothing_is_in_place_before_the_end(tmp_path):
    (tmp_path / "old").write_text("old")
    with transaction(tmp_path) as staging:
        (staging / "old").write_text("new")
        (staging / "other").write_text("new")
        assert staging.parent == tmp_path
        assert (tmp_path / "old").read_text() == "old"
        assert not (tmp_path / "other").exists()
    assert contents(tmp_path) == {"old": b"new", "other": b"new"}


def refuse_links(*args, **kwargs):
    raise OSError(errno.EPERM, "Operation not permitted")


@pytest.mark.parametrize("links", [True, False])
@pytest.mark.parametrize("failure", [OSError(errno.EIO, "Input/output error"), KeyboardInterrupt()])
@pytest.mark.parametrize("moved", [False, True])
def test_a_failure_while_moving_puts_the_old_files_back(tmp_path, monkeypatch, links, failure, moved):
    (tmp_path / "a").write_text("old a")
    (tmp_path / "c").write_text("old c")
    (tmp_path / "d").symlink_to("a")
    before = contents(tmp_path)
    replace = Path.replace

    def broken(self, target):
        """Fail at the new file d, before or after the move."""
        fails = target == tmp_path / "d" and self.parent.parent == tmp_path
        if moved or not fails:
            replace(self, target)
        if fails:
            raise failure

    monkeypatch.setattr(Path, "replace", broken)
    if not links:
        monkeypatch.setattr(os, "link", refuse_links)
    expected = FileError if isinstance(failure, OSError) else KeyboardInterrupt
    with pytest.raises(expected):
        stage(tmp_path, "abcde")
    assert contents(tmp_path) == before
    assert (tmp_path / "d").is_symlink()


def test_without_hard_links_files_are_replaced_all_the_same(tmp_path, monkeypatch):
    (tmp_path / "a").write_text("old")
    monkeypatch.setattr(os, "link", refuse_links)
    stage(tmp_path, "a")
    assert contents(tmp_path) == {"a": b"new"}


def test_a_parent_that_is_a_file(mesh, fields, tmp_path):
    (tmp_path / "file").write_text("old")
    for folder in (tmp_path / "file", tmp_path / "file" / "sub"):
        with pytest.raises(FileError, match=r"file.*(not a folder|Not a directory)"):
            write_files(mesh, fields, {}, MeshFiles(folder, "plate", ["msh"]))
    assert contents(tmp_path) == {"file": b"old"}


def test_a_target_that_is_a_folder(mesh, fields, tmp_path):
    (tmp_path / "plate.report.json").mkdir()
    (tmp_path / "plate.msh").write_text("old")
    with pytest.raises(FileError, match=r"plate\.report\.json"):
        write_files(mesh, fields, {}, MeshFiles(tmp_path, "plate", ["msh"]))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["plate.msh", "plate.report.json"]
    assert (tmp_path / "plate.msh").read_text() == "old"


def test_a_device_is_not_replaced_by_a_file(mesh, fields, tmp_path):
    os.mkfifo(tmp_path / "plate.msh")
    with pytest.raises(FileError, match=r"plate\.msh"):
        write_file(mesh, fields, {}, tmp_path / "plate.msh")
    assert (tmp_path / "plate.msh").is_fifo()


def test_a_folder_that_cannot_be_written_is_named(mesh, fields, tmp_path, monkeypatch):
    def refuse(self, *args, **kwargs):
        raise PermissionError(errno.EACCES, "Permission denied", str(self))

    monkeypatch.setattr(Path, "mkdir", refuse)
    with pytest.raises(FileError, match=r"new: Permission denied"):
        write_files(mesh, fields, {}, MeshFiles(tmp_path / "new", "plate", ["msh"]))


def test_a_folder_without_room_for_staging_is_named(mesh, fields, tmp_path, monkeypatch):
    def refuse(path, *args, **kwargs):
        raise OSError(errno.EROFS, "Read-only file system", str(path))

    monkeypatch.setattr(os, "mkdir", refuse)
    with pytest.raises(FileError) as caught:
        write_files(mesh, fields, {}, MeshFiles(tmp_path, "plate", ["msh"]))
    assert str(caught.value) == f"cannot write {tmp_path}: Read-only file system"


def test_the_message_names_the_file_and_not_the_staging_directory(tmp_path):
    with pytest.raises(FileError) as caught, transaction(tmp_path) as staging:
        raise OSError(errno.ENOSPC, "No space left on device", str(staging / "plate.msh"))
    assert str(caught.value) == f"cannot write {tmp_path / 'plate.msh'}: No space left on device"


FULL_DISK = """
import resource, sys
from pathlib import Path
from typing import NamedTuple
sys.path[:0] = sys.argv[1], str(Path(sys.argv[1]).parent)
from format_names import ALL
from squares import fields_of, holed_square
from bubblemesh.errors import FileError
from bubblemesh.meshfiles.mesh_files import MeshFiles
from bubblemesh.meshfiles.writing import write_files
import h5py, meshio

mesh, folder = holed_square(60), Path(sys.argv[2])
fields = fields_of(mesh)
resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))
for ending in ALL:
    try:
        write_files(mesh, fields, {}, MeshFiles(folder, "plate", [ending]))
    except FileError as error:
        print(error)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no limit on the size of files")
def test_a_disk_that_fills_up(tmp_path):
    for file in ALL_FILES:
        (tmp_path / file).write_text("old")
    before = contents(tmp_path)
    command = [sys.executable, "-B", "-W", "error", "-c", FULL_DISK, str(Path(__file__).parent), str(tmp_path)]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    assert run.stderr == ""
    messages = run.stdout.splitlines()
    assert len(messages) == len(ALL)
    for message in messages:
        assert message.startswith(f"cannot write {tmp_path}")
        assert message.endswith(("File too large", "(is the disk full?)"))
    assert contents(tmp_path) == before


def test_the_order_of_the_data_does_not_depend_on_who_else_looks_at_it(mesh, fields, tmp_path, monkeypatch):
    write_file(mesh, fields, {}, tmp_path / "free.xdmf")
    create, held = h5py.Group.create_dataset, []

    def hold(*arguments, **options):
        held.append(create(*arguments, **options))
        return held[-1]

    monkeypatch.setattr(h5py.Group, "create_dataset", hold)
    write_file(mesh, fields, {}, tmp_path / "held.xdmf")
    assert held
    for end in (".h5", "_facets.h5"):
        assert (tmp_path / f"held{end}").read_bytes() == (tmp_path / f"free{end}").read_bytes()


# Streams


@pytest.mark.parametrize("ending", [name for name in ALL if name not in ("xdmf", "pvtu")])
def test_a_stream_gets_the_bytes_of_the_file(mesh, fields, tmp_path, ending, capfd):
    stream = io.BytesIO()
    write_stream(mesh, fields, ending, stream)
    write_file(mesh, fields, {}, tmp_path / f"one.{ending}")
    assert stream.getvalue() == (tmp_path / f"one.{ending}").read_bytes()
    assert capfd.readouterr() == ("", "")


def test_a_stream_is_flushed(mesh, fields, tmp_path):
    with (tmp_path / "piped").open("wb", buffering=10**7) as stream:
        write_stream(mesh, fields, "msh", stream)
        assert (tmp_path / "piped").stat().st_size > 1000


def test_a_broken_pipe_is_the_callers_business(mesh, fields):
    reading, writing = os.pipe()
    os.close(reading)
    with pytest.raises(BrokenPipeError), open(writing, "wb", buffering=0) as stream:  # noqa: PTH123
        write_stream(mesh, fields, "vtu", stream)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="the system has no /dev/full")
def test_a_full_disk_behind_the_stream(mesh, fields):
    with Path("/dev/full").open("wb", buffering=0) as stream, pytest.raises(FileError, match="No space left"):
        write_stream(mesh, fields, "vtu", stream)


# Report


@dataclasses.dataclass(frozen=True)
class Record:
    a: float
    b: tuple


class Named(NamedTuple):
    at: tuple
    size: float


def test_the_report_is_plain_json():
    report = {
        "z": np.float64(0.1),
        "a": [np.int32(2), np.bool_(True), None, "ü"],
        "nan": float("nan"),
        "inf": np.array([1.0, -np.inf]),
        "record": Record(np.float32(0.5), (1, Path("x"))),
        "named": [Named((1, 2), 0.5)],
        3: np.array(4),
        "third": 1 / 3,
    }
    text = json_text(report)
    assert text.endswith("}\n")
    assert text.startswith('{\n  "z": 0.1,\n  "a": [\n    2,\n    true,\n    null,\n    "ü"\n  ],\n')
    read = json.loads(text)
    assert list(read) == ["z", "a", "nan", "inf", "record", "named", "3", "third"]
    assert read["nan"] is None
    assert read["inf"] == [1.0, None]
    assert read["record"] == {"a": 0.5, "b": [1, "x"]}
    assert read["named"] == [{"at": [1, 2], "size": 0.5}]
    assert read["3"] == 4
    assert read["third"] == 1 / 3


def test_plain_values_have_plain_types():
    assert type(json_ready(np.float64(1))) is float
    assert type(json_ready(np.int64(1))) is int
    assert type(json_ready(np.bool_(True))) is bool
    assert type(json_ready(np.str_("a"))) in {str, np.str_}


@pytest.mark.parametrize("value", [{1, 2}, object(), 1j, np.complex128(1j), Record])
def test_what_json_has_no_form_for_is_an_error(value):
    with pytest.raises(TypeError, match="report"):
        json_ready(value)


# Cost of the import


def test_importing_the_package_imports_no_heavy_library():
    code = (
        "import sys; from bubblemesh.meshfiles import formats, read, writing\n"
        "print(sorted({'meshio', 'h5py', 'matplotlib', 'rich'} & set(sys.modules)))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout == "[]\n"
