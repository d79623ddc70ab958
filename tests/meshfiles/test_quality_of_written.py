"""`bubblemesh quality` reads every mesh that `bubblemesh run` writes, of either order."""

import json

import numpy as np
import pytest
from commands import command
from sandwiches import sandwich, written
from solver_files import vtu
from squares import fields_of

from bubblemesh.meshfiles.formats import FORMATS
from bubblemesh.meshfiles.writing import write_stream

NODES_ONLY = ("nodes.csv", "nodes.npz")
FORMS = [(form, order) for form, known in FORMATS.items() for order in known.orders if form not in NODES_ONLY]


def made(order):
    mesh = sandwich()
    return mesh if order == 1 else mesh.second_order()[0]


@pytest.mark.parametrize(("form", "order"), FORMS)
def test_all_formats_and_orders(form, order, tmp_path):
    path = written(made(order), tmp_path, form)
    code, text, said = command("quality", path, "--json")
    curved = f"warning: {path}: has cells of higher order: their corners are read\n"
    assert (code, said) == (0, curved if order == 2 else "")
    figures = json.loads(text)
    assert (figures["nodes"], figures["triangles"]) == (96, 144)
    assert figures["area"] == pytest.approx(8, rel=1e-12)


@pytest.mark.parametrize("form", NODES_ONLY)
def test_nodes_alone_have_no_quality(form, tmp_path):
    code, _, said = command("quality", written(made(1), tmp_path, form))
    assert code == 5
    assert "holds nodes without triangles" in said


@pytest.mark.parametrize("form", [name for name in FORMATS if name not in NODES_ONLY])
def test_what_goes_to_the_standard_output(form, tmp_path):
    mesh = made(1)
    ending = ".vtu" if form == "pvtu" else FORMATS[form].files[0]  # the whole grid in place of the list of its pieces
    path = tmp_path / f"piped{ending}"
    with path.open("wb") as stream:
        write_stream(mesh, fields_of(mesh), form, stream)
    code, text, said = command("quality", path, "--json")
    assert (code, said, json.loads(text)["triangles"]) == (0, "", 144)


def test_nodes_that_each_cell_has_for_itself_count_once(tmp_path):
    mesh = made(1)
    points = mesh.points[mesh.triangles].reshape(-1, 2)
    path = vtu(tmp_path / "a.vtu", points, np.arange(len(points)).reshape(-1, 3), {})
    code, text, _ = command("quality", path, "--json")
    assert (code, json.loads(text)["nodes"]) == (0, 96)
