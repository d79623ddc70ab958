import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from twins import needs_compiler

from bubblemesh.errors import CaseError, FileError
from bubblemesh.kernels import library as kernels
from bubblemesh.kernels.shapes import Descent

TRIANGLES = np.array([[0, 1, 2]])
HUGE = 1 << 57  # numbers of nodes beyond all memory


@pytest.fixture(autouse=True)
def anew():
    kernels.library.cache_clear()
    yield
    kernels.library.cache_clear()


def told(choice, *arguments):
    environment = os.environ | {kernels.CHOICE: choice}
    command = [sys.executable, "-m", "bubblemesh", *arguments]
    return subprocess.run(command, env=environment, capture_output=True, text=True)


def test_numpy_can_be_chosen(monkeypatch):
    monkeypatch.setenv(kernels.CHOICE, "numpy")
    assert kernels.library() is None
    assert kernels.engine() == "numpy"


def test_another_choice_is_an_error_of_the_command_too(monkeypatch):
    monkeypatch.setenv(kernels.CHOICE, "fortran")
    with pytest.raises(CaseError, match="BUBBLEMESH_ENGINE=fortran: there is no such engine: use compiled or numpy"):
        kernels.library()
    result = told("fortran", "--version")
    assert (result.returncode, result.stdout) == (2, "")
    assert "use compiled or numpy" in result.stderr


def test_compiled_kernels_that_are_missing_are_told(monkeypatch):
    monkeypatch.setattr(kernels, "find_spec", lambda name: None)
    assert kernels.engine() == "numpy"
    kernels.library.cache_clear()
    monkeypatch.setenv(kernels.CHOICE, "compiled")
    with pytest.raises(FileError, match="no kernels are compiled here"):
        kernels.library()


@needs_compiler
def test_a_library_of_another_version_is_refused(monkeypatch):
    monkeypatch.setattr(kernels, "VERSION", 0)
    with pytest.raises(FileError, match="of another version of bubblemesh: install bubblemesh anew"):
        kernels.library()


def test_a_library_that_is_broken_is_told(tmp_path):
    (tmp_path / "_compiled.so").write_bytes(b"\x7fELF")
    with pytest.raises(FileError, match=r"_compiled\.so cannot be loaded \(.*\): install bubblemesh anew"):
        kernels.loaded(str(tmp_path / "_compiled.so"))


def test_the_signatures_are_those_of_the_sources():
    letters = {"int64_t": "i", "double": "d"}
    arrays = {"int64_t*": "I", "double*": "D", "char*": "B", "int32_t*": "H", "uint32_t*": "U"}
    sources = Path(kernels.__file__).parent / "source"
    found = {}
    for source in sources.glob("*.c"):
        for name, given in re.findall(r"^KERNEL int64_t (\w+)\(([^)]*)\)", source.read_text(), re.MULTILINE):
            pairs = [
                re.fullmatch(r"(?:const )?(\w+ \*?)(\w+)", " ".join(one.split())).groups() for one in given.split(",")
            ]
            letter = {parameter: (letters | arrays)[kind.replace(" ", "")] for kind, parameter in pairs}
            found[name] = " ".join(f"{parameter}:{letter[parameter]}" for _, parameter in pairs)
    assert found == kernels.SIGNATURES


@needs_compiler
@pytest.mark.parametrize(
    ("arguments", "error", "match"),
    [
        ({"x": np.zeros((6, 2))[::2]}, ValueError, "contiguous"),
        ({"x": np.zeros((3, 2), np.float32)}, TypeError, r"float64 here \(found float32\)"),
        ({"triangles": TRIANGLES.astype(np.int32)}, TypeError, r"int64 here \(found int32\)"),
        ({"t": 1.5}, TypeError, "int"),
        ({"n": 1}, TypeError, r"shape_measures takes t, x, triangles, eta \(found t, x, triangles, eta, n\)"),
    ],
)
def test_what_a_function_does_not_take_never_reaches_it(arguments, error, match):
    right = {"t": 1, "x": np.zeros((3, 2)), "triangles": TRIANGLES, "eta": np.zeros(1)}
    with pytest.raises(error, match=match):
        kernels.call("shape_measures", **right | arguments)


@needs_compiler
@pytest.mark.parametrize(
    ("name", "sizes"),
    [
        ("anneal", {"n": HUGE, "t": HUGE, "steps": 1, "cycles": 1}),
        ("metric_flips", {"n": HUGE, "t": HUGE}),
        ("guarded_move", {"n": HUGE, "t": HUGE}),
        ("metric_relax", {"n": HUGE}),
        ("pair_forces", {"n": HUGE}),
        ("pairs_within", {"n": HUGE}),
        ("refine_triangles", {"n": HUGE}),
        ("relax", {"n": HUGE}),
    ],
)
def test_too_little_memory_is_an_error_and_no_crash(name, sizes):
    kinds = dict(word.split(":") for word in kernels.SIGNATURES[name].split())
    arguments = {
        parameter: {"i": 0, "d": 1.0}[letter] if letter in kernels.NUMBERS else np.zeros(1, kernels.ARRAYS[letter])
        for parameter, letter in kinds.items()
    }
    with pytest.raises(MemoryError):
        kernels.call(name, **arguments | sizes)


@needs_compiler
def test_whole_numbers_are_numbers_too():
    x, weights = np.random.default_rng(0).uniform(size=(3, 2)), (2, 2.0)
    edges, of_three, none = np.array([[0, 1], [0, 2], [1, 2]]), np.ones(3), np.zeros((0, 2))
    counts = np.ones(len(TRIANGLES))
    moved = [
        Descent(TRIANGLES, counts, edges, of_three, of_three, of_three, 0, 0, weight, 0.5, 0.01).moved(x, none, 3)
        for weight in weights
    ]
    np.testing.assert_array_equal(*moved)
    assert (moved[0] != x).any()


@needs_compiler
def test_what_was_compiled_can_be_imported():
    from bubblemesh.kernels import _compiled

    assert _compiled.__doc__ == "Compiled kernels."
