"""Mesh files that lead to other files, or unpack to more than there is memory for."""

import base64
import gzip
import os
import sys
import zlib
from concurrent.futures import ThreadPoolExecutor

import h5py
import meshio
import numpy as np
import pytest
from meshio import _files

from bubblemesh.errors import FileError, LimitError
from bubblemesh.meshfiles.fields import read_field
from bubblemesh.meshfiles.sources.other import read_other

POINTS, CELLS = [[0.0, 0], [1, 0], [0, 1]], [("triangle", [[0, 1, 2]])]


def written(path, **options):
    meshio.Mesh(POINTS, CELLS, point_data={"h": np.ones(3)}).write(path, **options)
    return path


@pytest.mark.parametrize("name", ["a.xdmf", "a.med", "a.vtu", "a.inp", "a.h5m"])
def test_whole_files_are_read(tmp_path, name):
    path = written(tmp_path / name)
    if name not in ("a.inp", "a.h5m"):
        assert read_field(path, "h").values.tolist() == [1, 1, 1]


@pytest.mark.parametrize("other", ["../b.h5", "/etc/b.h5"])
def test_data_in_another_folder_are_not_read(tmp_path, other):
    path = written(tmp_path / "a.xdmf")
    path.write_text(path.read_text().replace("a.h5:", f"{other}:"))
    with pytest.raises(FileError, match="its data are in a file in another folder"):
        read_field(path, "h")


def test_a_pipe_beside_is_not_waited_for(tmp_path):
    for path, other in ((written(tmp_path / "a.xdmf"), "a.h5"), (tmp_path / "b.ele", "b.node")):
        path.touch()
        path.write_bytes(path.read_bytes() or b"1 3 0\n")
        (tmp_path / other).unlink(missing_ok=True)
        os.mkfifo(tmp_path / other)
        with pytest.raises(FileError, match="it is no regular file"):
            read_field(path, "h")


def test_raw_files_beside_are_not_read(tmp_path):
    path = written(tmp_path / "a.xdmf", data_format="XML")
    path.write_text(path.read_text().replace('Format="XML"', 'Format="Binary"'))
    with pytest.raises(FileError, match="its data are in the form 'Binary'"):
        read_field(path, "h")


def test_links_of_hdf_are_not_followed(tmp_path):
    (tmp_path / "secret").write_bytes(bytes(24))
    for change in (
        lambda file: file.__setitem__("more", h5py.ExternalLink("b.h5", "/x")),
        lambda file: file.create_dataset("more", (3,), "f8", external=[(str(tmp_path / "secret"), 0, 24)]),
    ):
        path = written(tmp_path / "a.xdmf")
        with h5py.File(tmp_path / "a.h5", "a") as file:
            change(file)
        with pytest.raises(FileError, match="more is in another file"):
            read_field(path, "h")


@pytest.mark.parametrize("start", [b"", b"any text".ljust(2048)])
def test_files_of_unknown_formats_are_checked_by_what_they_begin_with(tmp_path, monkeypatch, start):
    with h5py.File(tmp_path / "a.h5", "w", userblock_size=len(start)) as file:
        file["more"] = h5py.ExternalLink("b.h5", "/x")
    content = bytearray((tmp_path / "a.h5").read_bytes())
    content[: len(start)] = start
    path = tmp_path / "a.new"
    path.write_bytes(content)
    with pytest.raises(FileError, match="more is in another file"):
        read_field(path, "h")
    monkeypatch.setattr("bubblemesh.meshfiles.containment.MOST_UNPACKED", 10_000)
    path.write_bytes(gzip.compress(bytes(100_000)))
    with pytest.raises(LimitError, match="unpacks to more than"):
        read_field(path, "h")


def test_included_files_are_not_read(tmp_path):
    path = written(tmp_path / "a.inp")
    path.write_text(path.read_text() + "*INCLUDE, INPUT=/etc/passwd\n")
    with pytest.raises(FileError, match="it includes another file"):
        read_field(path, "h")


def test_data_that_unpack_to_far_more(tmp_path, monkeypatch):
    path = written(tmp_path / "a.xdmf")
    with h5py.File(tmp_path / "a.h5", "a") as file:
        name = next(iter(file))
        del file[name]
        file.create_dataset(name, (10**6, 10**6), "f8", chunks=True, compression="gzip")
    with pytest.raises(LimitError, match="unpacks to more than the 1,000 MB"):
        read_field(path, "h")
    monkeypatch.setattr("bubblemesh.meshfiles.containment.MOST_UNPACKED", 10_000)
    for compression in ("zlib", "lzma"):
        path = tmp_path / "a.vtu"
        meshio.Mesh(POINTS * 1000, CELLS, point_data={"h": np.ones(3000)}).write(path, compression=compression)
        with pytest.raises(LimitError, match="unpacks to more than"):
            read_field(path, "h")


def test_a_block_that_is_cut_off(tmp_path):
    path = written(tmp_path / "a.vtu", compression="zlib")
    text = path.read_text()
    block = base64.b64encode(zlib.compress(np.ones(3).tobytes())).decode()
    assert block in text
    path.write_text(text.replace(block, block[:12]))
    with pytest.raises(FileError, match="an array ends too early: the file is damaged"):
        read_field(path, "h")


def test_files_are_read_in_several_threads_at_once(tmp_path):
    paths = [written(tmp_path / f"{k}.vtu") for k in range(4)]
    stream = sys.stdout
    with ThreadPoolExecutor(4) as threads:
        fields = list(threads.map(lambda k: read_other(paths[k % 4]).points, range(40)))
    assert len(fields) == 40
    assert sys.stdout is stream
    assert not hasattr(_files, "open")


def test_the_reason_of_meshio_ends_before_the_name_of_the_file(tmp_path):
    path = tmp_path / "a long name of a folder, with so many words" / "that it goes on in a second line" / "a.ply"
    path.parent.mkdir(parents=True)
    path.write_text("nothing\n")
    with pytest.raises(FileError) as caught:
        read_field(path, None)
    assert str(caught.value) == f"{path}: is no mesh that can be read (Expected ply)"


def test_points_without_coordinates(tmp_path):
    (tmp_path / "a.su2").write_text("NDIME= 0\nNELEM= 1\n5 0 1 2\nNPOIN= 3\n0 0\n1 0\n0 1\n")
    with pytest.raises(FileError, match=r"a\.su2: "):
        read_field(tmp_path / "a.su2", None)
