"""Ids of one's own: what a case asks for, what is refused, and which numbers get into files and come back."""

import json
import warnings
from dataclasses import replace

import meshio
import pytest
from squares import holed_square

from bubblemesh.case import load_case
from bubblemesh.errors import CaseError
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.formats import format_named
from bubblemesh.meshfiles.groups import facet_ids, group_names, node_ids, plain_words, region_ids
from bubblemesh.meshfiles.mesh_files import MeshFiles
from bubblemesh.meshfiles.writing import write_files
from bubblemesh.problem.prepare import prepare
from bubblemesh.run.pipeline import mesh_case

CASE = """
domain:
  outer: {rectangle: [0, 0, 2, 1], labels: [bottom, outlet, top, inlet]}
  region: air
  regions:
    - {name: copper, ring: {circle: {center: [0.5, 0.5], radius: 0.2}}}
    - {name: top, ring: {rectangle: [1.2, 0.5, 1.8, 1]}}
  points: [{at: [1, 0.3], label: well}]
  periodic: [[inlet, outlet]]
spacing: 0.3
"""
OWN = {"inlet": 7, "copper": 3, "top_region": 7, "well": 2**31 - 1}
# By name, the id and the dimension of all groups: others keep their numbers, but for 3 and 7, which are taken.
GROUPS = {
    **{"bottom": (1, 1), "outlet": (2, 1), "top": (11, 1), "inlet": (7, 1), "copper-rim": (5, 1), "top-rim": (6, 1)},
    **{"air": (12, 2), "copper": (3, 2), "top_region": (7, 2), "well": (2**31 - 1, 0)},
}
FORMATS = ["msh", "msh-ascii", "msh4", "mesh", "vtu", "xdmf", "ugrid", "2dm", "sfepy", "dealii", "ngsolve", "med"]


def case_with(ids):
    return load_case("a.yaml", text=f"{CASE}output: {{ids: {json.dumps(ids)}}}\n")


@pytest.fixture(scope="module")
def mesh():
    return mesh_case(case_with(OWN)).mesh


def test_groups_have_their_ids_and_the_others_their_numbers_or_free_ones(mesh):
    assert {name: tuple(group) for name, group in group_names(mesh).items()} == GROUPS
    assert list(group_names(mesh)) == list(GROUPS)
    assert set(facet_ids(mesh)[mesh.facet_labels == 3]) == {7}
    assert set(region_ids(mesh)[mesh.triangle_regions == 1]) == {3}
    assert node_ids(mesh).tolist() == [2**31 - 1]


def test_without_ids_of_ones_own_groups_have_their_numbers():
    groups = group_names(mesh_case(load_case("a.yaml", text=CASE)).mesh).values()
    assert [group.id for group in groups] == list(range(1, 11))


@pytest.mark.parametrize(
    ("ids", "message"),
    [
        ({"inlet": 0}, "output.ids.inlet: must be greater than 0 (found 0)"),
        ({"inlet": -3}, "output.ids.inlet: must be greater than 0 (found -3)"),
        ({"inlet": 7.5}, "output.ids.inlet: must be a whole number (found 7.5)"),
        ({"inlet": "seven"}, "output.ids.inlet: must be a whole number (found the text 'seven')"),
        ({"inlet": 2**31}, "output.ids.inlet: must be at most 2147483647 (found 2147483648)"),
        ({"inlett": 7}, "output.ids: unknown label, region or point 'inlett'; did you mean 'inlet'?"),
        ({"inlet": 7, "outlet": 7}, "output.ids: 'inlet' and 'outlet' have the same id 7: labels need different ones"),
        ({"air": 4, "copper": 4}, "output.ids: 'air' and 'copper' have the same id 4: regions need different ones"),
        ([7], "output.ids: must be a mapping"),
    ],
)
def test_ids_that_cannot_be_are_refused_before_the_work(ids, message):
    with pytest.raises(CaseError) as error:
        prepare(case_with(ids))
    assert message in str(error.value)


def test_a_label_and_a_region_may_have_the_same_id():
    ids = {"inlet": 3, "copper": 3, "well": 3}
    assert prepare(case_with(ids)).task.ids == ids


@pytest.mark.parametrize(
    ("ids", "message"),
    [
        ({"hole": 0}, "ids: hole: must be a whole number from 1 to 2147483647 (found 0)"),
        ({"hole": True}, "found True"),
        ({"hole": 1.0}, "found 1.0"),
        ({7: 7}, "ids: must be a list of texts"),
        ([("hole", 7)], "ids: must be a mapping of names to ids"),
    ],
)
def test_a_mesh_is_checked_for_its_ids(ids, message):
    with pytest.raises(CaseError) as error:
        replace(holed_square(), ids=ids)
    assert message in str(error.value)


def test_two_labels_of_a_mesh_with_one_id_are_not_written(tmp_path):
    mesh = replace(holed_square(), ids={"hole": 7, "top": 7, "not there": 7})
    with pytest.raises(CaseError, match="'hole' and 'top' have the same id 7"):
        mesh.write(tmp_path / "a.msh")


@pytest.fixture(scope="module")
def folder(mesh, tmp_path_factory):
    """Files of the mesh in many formats, with the ids beside them."""
    folder = tmp_path_factory.mktemp("ids")
    for form in FORMATS:
        write_files(mesh, {}, {}, MeshFiles(folder / form, "a", [form]))
    return folder


def mesh_file(folder, form):
    return folder / form / f"a{format_named(form).files[0]}"


@pytest.mark.parametrize("form", [form for form in FORMATS if form != "sfepy"])
def test_ids_are_read_back(form, folder):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # on what a format has no place for
        read = Mesh.read(mesh_file(folder, form))
    groups = {name: tuple(group) for name, group in group_names(read).items() if name != "boundary"}
    assert groups.items() <= GROUPS.items()
    assert {"air", "copper", "top_region"} <= groups.keys()


def test_a_file_with_the_numbers_from_1_on_has_no_ids_of_its_own(tmp_path):
    mesh = holed_square()
    mesh.write(tmp_path / "a.msh")
    assert Mesh.read(tmp_path / "a.msh").ids == {}


def test_ids_of_a_file_stay_when_it_is_written_in_another_format(folder, tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        Mesh.read(mesh_file(folder, "ngsolve")).write(tmp_path / "b.msh")
    groups = meshio.read(tmp_path / "b.msh").field_data
    assert [tuple(groups[name]) for name in ("inlet", "copper")] == [(7, 1), (3, 2)]


def ids_in(mesh, key, kind):
    blocks = zip(mesh.cells, mesh.cell_data[key], strict=True)
    return {number for block, data in blocks if block.type == kind for number in data}


PHYSICAL = "gmsh:physical"


@pytest.mark.parametrize(("form", "key"), [("msh", PHYSICAL), ("mesh", "medit:ref"), ("dealii", PHYSICAL)])
def test_other_readers_find_the_ids(form, key, folder):
    read = meshio.read(mesh_file(folder, form))
    inner = set() if form == "dealii" else {5, 6}
    assert ids_in(read, key, "line") == {1, 2, 7, 11} | inner
    assert ids_in(read, key, "triangle") == {12, 3, 7}


@pytest.mark.parametrize(("form", "key"), [("vtu", "material"), ("xdmf", "material"), ("sfepy", "mat_id")])
def test_formats_of_triangles_alone_have_the_ids_of_regions(form, key, folder):
    assert ids_in(meshio.read(mesh_file(folder, form)), key, "triangle") == {12, 3, 7}


def test_node_strings_of_sms_have_the_ids_of_labels(folder):
    text = mesh_file(folder, "2dm").read_text().splitlines()
    last = [int(line.split()[-1]) for line in text if line.startswith("NS") and int(line.split()[-2]) < 0]
    assert set(last) == {1, 2, 5, 6, 7, 11}


def test_the_points_of_gmsh_at_ends_of_periodic_sides_have_an_id_that_is_free(folder):
    read = meshio.read(mesh_file(folder, "msh"))
    assert tuple(read.field_data["periodic-ends"]) == (13, 0)
    assert read.field_data["well"][0] == 2**31 - 1


def test_formats_that_know_groups_by_names_need_no_ids(mesh, tmp_path):
    write_files(mesh, {}, {}, MeshFiles(tmp_path, "a", ["openfoam"]))
    groups = meshio.read(tmp_path / "a.msh").field_data
    numbers = [int(number) for number, _ in groups.values()]
    assert len(groups) == len(set(numbers)) == 11
    assert {*plain_words(mesh, dimensions=(1, 2)).values()} <= groups.keys()


def test_cell_sets_of_meshio_tell_labels_and_regions_with_the_same_id_apart(mesh):
    sets = mesh.to_meshio().cell_sets
    inlet, top = ([0 if cells is None else len(cells) for cells in sets[name]] for name in ("inlet", "top_region"))
    assert sum(inlet) == (mesh.facet_labels == mesh.labels.index("inlet")).sum()
    assert sum(top) == (mesh.triangle_regions == mesh.regions.index("top")).sum()
