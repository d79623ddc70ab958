import os
import subprocess
import sys

import numpy as np
import pytest
from twins import needs_compiler

from bubblemesh.errors import CaseError, FileError
from bubblemesh.kernels import library as kernels


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
        kernels.Library(str(tmp_path / "_compiled.so"))


@needs_compiler
def test_arrays_that_are_not_contiguous_never_reach_the_library():
    with pytest.raises(ValueError, match="contiguous"):
        kernels.library().call("spread", 0, np.zeros((4, 4))[:, 1])


@needs_compiler
def test_what_was_compiled_can_be_imported():
    from bubblemesh.kernels import _compiled

    assert _compiled.__doc__ == "Compiled kernels."
