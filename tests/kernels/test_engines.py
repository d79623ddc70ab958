"""The choice between compiled kernels and their twins, which is made in one place for the whole package."""

import re

import numpy as np
import pytest
from sources import MODULES, PACKAGE
from twins import needs_compiler, run_by

from bubblemesh.case import load_case
from bubblemesh.kernels.library import COMPILED, NUMPY, engine, or_none, or_numpy
from bubblemesh.run.pipeline import mesh_case

PLATE = """
name: plate
domain: {outer: {rectangle: [0, 0, 3, 2]}, holes: [{circle: {center: [1, 1], radius: 0.4}}]}
spacing: 0.25 + 0.05*x
packing: {effort: fast}
"""
LONG = """
name: long
domain: {outer: {rectangle: [0, 0, 2, 1]}}
spacing: 0.4
metric: {angle: 0.2 + x, across: 0.15}
packing: {effort: fast}
"""


def plain(name, times=1):
    return "numpy", name * times


@or_numpy(plain)
def either(name, times=1):
    """Engine and name."""
    return "compiled", name * times


@or_none
def only_compiled(name):
    return "compiled", name


@pytest.mark.usefixtures("each_engine")
def test_a_kernel_or_its_twin_gets_all_arguments():
    assert either("a") == (engine(), "a")
    assert either("a", times=2) == (engine(), "aa")
    assert (either.__name__, either.__doc__) == ("either", "Engine and name.")


@needs_compiler
def test_what_has_no_twin_gives_nothing_in_numpy():
    assert only_compiled("a") == ("compiled", "a")
    with run_by(NUMPY):
        assert only_compiled("a") is None
    assert only_compiled("a") == ("compiled", "a")


@needs_compiler
@pytest.mark.parametrize("text", [PLATE, LONG], ids=["circles", "ellipses"])
def test_both_engines_make_the_same_mesh(text):
    """In NumPy no function in C is called at all: there is no library to call it of."""
    meshes = []
    for name in (COMPILED, NUMPY):
        with run_by(name):
            meshes.append(mesh_case(load_case("case.yaml", text=text)).mesh)
    one, other = meshes
    assert len(one.points) > 50
    np.testing.assert_array_equal(one.points, other.points)
    np.testing.assert_array_equal(one.triangles, other.triangles)


def test_no_other_module_asks_which_engine_runs():
    for path in MODULES:
        if path == PACKAGE / "kernels/library.py":
            continue
        own = {"Argument", "call", "or_none"} if path.parent == PACKAGE / "kernels" else {"engine"}
        found = re.findall(r"from bubblemesh.kernels.library import (.+)", path.read_text())
        assert {name for line in found for name in line.split(", ")} <= own | {"or_numpy"}, path
        assert "from bubblemesh.kernels import library" not in path.read_text(), path
