"""Mesh files with bytes that are wrong, missing or there twice: each is read, or refused as a mistake of the user's."""

import random

import meshio
import numpy as np
import pytest
from squares import holed_square

from bubblemesh.errors import BubblemeshError, FileError
from bubblemesh.meshfiles.read import read_mesh, read_triangles
from bubblemesh.meshfiles.sources.source import Source

DAMAGES = 60  # of each format


def cut(rng, content):
    return content[: rng.randrange(len(content))]


def changed(rng, content):
    found = bytearray(content)
    for _ in range(rng.randint(1, 4)):
        found[rng.randrange(len(found))] = rng.randrange(256)
    return bytes(found)


def with_other_digits(rng, content):
    found = bytearray(content)
    for at in rng.choices([at for at, byte in enumerate(found) if byte in b"0123456789"], k=3):
        found[at] = rng.choice(b"0123456789-.e")
    return bytes(found)


def with_another_count(rng, content):
    at = rng.choice([at for at, byte in enumerate(content) if byte in b"0123456789"])
    return content[:at] + rng.choice([b"1000", b"-1", b"99999999999999999999"]) + content[at + 1 :]


def without_a_line(rng, content):
    lines = content.split(b"\n")
    del lines[rng.randrange(len(lines))]
    return b"\n".join(lines)


def with_a_line_twice(rng, content):
    lines = content.split(b"\n")
    at = rng.randrange(len(lines))
    return b"\n".join([*lines[: at + 1], *lines[at:]])


HOW = cut, changed, with_other_digits, with_another_count, without_a_line, with_a_line_twice


@pytest.mark.parametrize(
    "ending", [".msh", ".vtu", ".vtk", ".xdmf", ".inp", ".su2", ".med", ".mesh", ".dat", ".14", ".gr3"]
)
def test_a_damaged_file_is_read_or_refused(ending, tmp_path):
    path = tmp_path / f"a{ending}"
    holed_square(cells=6).write(path)
    content, refused = path.read_bytes(), 0
    for seed in range(DAMAGES):
        rng = random.Random(seed)
        path.write_bytes(HOW[seed % len(HOW)](rng, content))
        try:
            read_mesh(path)
        except BubblemeshError:
            refused += 1
    assert 0 < refused < DAMAGES


@pytest.mark.parametrize("ending", ["vtu", "vtk"])
def test_a_file_without_points_and_cells_has_no_triangles(tmp_path, ending):
    path = tmp_path / f"empty.{ending}"
    meshio.write(path, meshio.Mesh(np.zeros((0, 3)), []))
    with pytest.raises(FileError, match="holds no triangles"):
        read_triangles(path)


def test_a_set_with_cells_that_are_not_there_is_refused(tmp_path):
    path = tmp_path / "a.inp"
    holed_square().write(path)
    text = path.read_text()
    path.write_text(text.replace("*ELSET, ELSET=EALL", "*ELSET, ELSET=more\n1, 9999\n*ELSET, ELSET=EALL"))
    with pytest.raises(FileError, match="names the element 9999, which is not there: the file is damaged"):
        read_mesh(path)


def test_entities_that_meshio_calls_a_set_of_cells_are_none():
    mesh = meshio.Mesh(
        [[0.0, 0], [1, 0], [0, 1]],
        [("line", [[0, 1]]), ("triangle", [[0, 1, 2]])],
        cell_sets={"gmsh:bounding_entities": [np.array([1, 2]), np.array([-61, 62])], "wall": [[0], []]},
    )
    assert list(Source.of(mesh).cell_sets) == ["wall"]


def test_a_count_beyond_all_memory_is_told(tmp_path, monkeypatch):
    path = tmp_path / "a.vtk"
    holed_square().write(path)

    def read(path):
        raise MemoryError

    monkeypatch.setattr("bubblemesh.meshfiles.read.read_source", read)
    with pytest.raises(FileError, match=r"a\.vtk: needs more memory than there is: it is damaged, or"):
        read_mesh(path)
