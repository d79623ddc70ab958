"""The table of formats, and groups of cells."""

import dataclasses
import re
import subprocess
import sys

import numpy as np
import pytest
from invariants import check_mesh
from sandwiches import ODD, names_of, sandwich
from squares import holed_square

from bubblemesh.errors import CaseError
from bubblemesh.meshes.conformity import require_conforming
from bubblemesh.meshfiles.formats import FORMATS, FORMATS_FOR, Beside, Format, FormatName, Solver
from bubblemesh.meshfiles.groups import facet_ids, group_names, node_ids, plain_words, region_ids
from bubblemesh.meshfiles.mesh_files import MeshFiles
from bubblemesh.meshfiles.writing import write_file, write_files
from bubblemesh.run.destination import Destination


def test_every_format_and_solver_of_the_case_file_is_in_the_tables():
    assert tuple(FORMATS) == FormatName.__args__
    assert tuple(FORMATS_FOR) == Solver.__args__
    assert {form for forms in FORMATS_FOR.values() for form in forms} <= set(FORMATS)
    assert FORMATS_FOR["fenicsx"] == ("msh", "xdmf")


def test_the_table_of_formats_loads_no_writer():
    code = "import sys; import bubblemesh.meshfiles.formats; print(*sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"numpy", "meshio", "h5py"} & set(run.stdout.split())
    assert not [name for name in run.stdout.split() if name.startswith("bubblemesh.meshfiles.write")]


def test_a_simple_mesh_has_one_region_and_no_points():
    mesh = holed_square()
    assert mesh.regions == ("domain",)
    assert mesh.order == 1
    assert len(mesh.labelled_nodes) == 0
    np.testing.assert_array_equal(mesh.triangle_regions, np.zeros(len(mesh.triangles)))
    np.testing.assert_array_equal(mesh.facet_middles, mesh.points[mesh.facets].mean(axis=1))


def test_a_mesh_with_regions_lines_and_points_is_sound(mesh):
    check_mesh(mesh)
    require_conforming(mesh)


def test_ids_of_labels_regions_and_points_never_collide():
    mesh = sandwich()
    assert group_names(mesh) == {
        **{"bottom": (1, 1), "right": (2, 1), "top": (3, 1), "left": (4, 1), "hole": (5, 1), "interface": (6, 1)},
        **{"steel": (7, 2), "glass fibre": (8, 2), "corner": (9, 0), "probe": (10, 0)},
    }
    assert set(facet_ids(mesh)) == {1, 2, 3, 4, 5, 6}
    assert set(region_ids(mesh)) == {7, 8}
    assert node_ids(mesh).tolist() == [9, 10]


def test_one_name_for_several_things_becomes_several_names():
    mesh = dataclasses.replace(sandwich(regions=("top", "top_region")), point_labels=("top", "hole"))
    labels, regions, points = names_of(mesh)
    assert labels[2] == "top"
    assert regions == ["top_region_region", "top_region"]
    assert points == ["top_point", "hole_point"]


def test_a_name_for_two_labels_is_refused():
    with pytest.raises(CaseError, match="the name 'a' is there twice"):
        group_names(holed_square(labels=("a", "b", "c", "a", "e")))


def test_sides_are_the_triangles_left_of_the_facets(mesh):
    for (triangle, side), (a, b) in zip(mesh.sides, mesh.facets, strict=True):
        corners = mesh.triangles[triangle].tolist()
        assert (corners[side], corners[(side + 1) % 3]) == (a, b)
    assert mesh.outer.tolist() == (mesh.facet_labels < 5).tolist()


def test_plain_words_are_words_and_differ():
    words = plain_words(dataclasses.replace(sandwich(ODD), point_labels=("Steel", "STEEL_9")), reserved=("ON",))
    assert all(re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]*", word) for word in words.values())
    assert len({word.upper() for word in words.values()} - {"ON"}) == len(words)
    assert words["äußere Wand"] == "au_ere_Wand"
    assert words["steel"] == "steel"


@pytest.mark.parametrize("form", FORMATS)
def test_without_points_the_sidecar_is_there_for_ids_only(tmp_path, form):
    files = write_files(holed_square(), {}, {}, MeshFiles(tmp_path, "plate", [form]))["files"]
    assert ("plate.labels.json" in files) == (
        form in {"vtu", "vtk", "pvtu", "xdmf", "mesh", "dat", "sfepy", "2dm", "pos"}
    )


def test_a_format_holds_what_its_row_says_and_has_beside_it_what_a_mesh_needs(tmp_path, monkeypatch):
    row = Format(
        (".new",), "write.fem.write_medit", "groups.as_they_are", beside=Beside(".more", "write.fem.medit_metric")
    )
    monkeypatch.setitem(FORMATS, "new", row)
    mesh = sandwich()  # with labelled points
    files = write_files(mesh, {}, {}, MeshFiles(tmp_path, "plate", ["new"]))["files"]
    assert files == ["plate.new", "plate.labels.json", "plate.report.json"]
    mesh = dataclasses.replace(mesh, metric=np.tile([4.0, 0, 4], (len(mesh.points), 1)))
    assert mesh.write(tmp_path / "b.NEW", sidecars=False) == ["b.NEW", "b.more"]
    assert b"SolAtVertices" in (tmp_path / "b.more").read_bytes()
    place = Destination(tmp_path, "plate", ["new"])
    assert place.names == ["plate.new", "plate.labels.json", "plate.more", "plate.report.json"]


def test_the_format_of_an_ending_is_the_first_that_has_it(tmp_path):
    mesh = holed_square()
    for name, start in (("a.msh", b"$MeshFormat\n2.2 1 8"), ("a.inp", b"*HEADING"), ("b.nodes.csv", b"x,y,boundary")):
        assert write_file(mesh, {}, {}, tmp_path / name)["files"][0] == name
        assert (tmp_path / name).read_bytes().startswith(start)
