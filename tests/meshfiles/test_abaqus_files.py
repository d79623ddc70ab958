"""Decks of Abaqus and CalculiX as other programs write them: sets within sets, ranges, surfaces, several parts."""

import pytest

from bubblemesh.errors import FileError
from bubblemesh.meshfiles.read import read_mesh
from bubblemesh.meshfiles.whole_mesh import whole_mesh

# Two rows of a rectangle of 2 by 2: squares below, triangles above. Written as Abaqus/CAE does.
DECK = """\
*Heading
** Job name: plate
*Part, name=Plate
*Node
  1, 0., 0.
  2, 1., 0.
  3, 2., 0.
  4, 0., 1.
  5, 1., 1.
  6, 2., 1.
  7, 0., 2.
  8, 1., 2.
  9, 2.,
*Element, type=CPS4R
11, 1, 2, 5, 4
12, 2, 3, 6, 5
*Element, type=cps3
21, 4, 5, 7
22, 5, 8, 7
23, 5, 6, 8
24, 6, 9, 8
*Elset, elset=lower, generate
 11, 12, 1
*Elset, elset=Upper, generate
 21, 24
*Elset, elset=corner
 11
*Elset, elset=left half
 corner, 21, 22
*Elset, elset=_floor_S1, internal
 LOWER
*Elset, elset=_wall_S4, internal
 11,
*Elset, elset=_wall_S3, internal
 21
*End Part
*Surface, type=ELEMENT, name=floor
_floor_S1, S1
*Surface, type=ELEMENT, name="the wall"
_wall_S4, S4
_wall_S3, S3
*Surface, type=NODE, name=nodes
Set-1, 1.
*Nset, nset=nodes
 1, 2
*Solid Section, elset=elsewhere, material=steel
*Step, name=Step-1
*End Step
"""


@pytest.fixture
def deck(tmp_path):
    def write(*changes):
        text = DECK.replace("  9, 2.,\n", "  9, 2., 2.\n")
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        (tmp_path / "plate.inp").write_text(text)
        return tmp_path / "plate.inp"

    return write


def sides(mesh, label):
    """Middles of the edges with a label."""
    chosen = mesh.facets[mesh.facet_labels == mesh.labels.index(label)]
    return sorted(map(tuple, mesh.points[chosen].mean(axis=1).tolist()))


def test_surfaces_are_labels_and_sets_of_elements_regions(deck):
    read = read_mesh(deck())
    mesh = read.mesh
    assert (len(mesh.points), len(mesh.triangles), len(mesh.quads)) == (9, 8, 2)
    assert set(mesh.labels) == {"floor", "the wall"}
    assert sides(mesh, "floor") == [(0.5, 0), (1.5, 0)]
    assert sides(mesh, "the wall") == [(0, 0.5), (0, 1.5)]
    assert read.node_sets == ("nodes",)
    # Internal sets are those of surfaces; a cell in several sets belongs to the smallest.
    middles = mesh.points[mesh.triangles].mean(axis=1)
    of = {tuple(middle): mesh.regions[k] for middle, k in zip(middles.round(2), mesh.triangle_regions, strict=True)}
    assert {of[point] for point in of if point[1] < 1 and point[0] > 1} == {"lower"}
    assert {of[point] for point in of if point[1] < 1 and point[0] < 1} == {"corner"}
    assert {of[point] for point in of if point[1] > 1 and point[0] > 1} == {"Upper"}
    assert "left half" in {of[point] for point in of if point[1] > 1}


def test_a_coordinate_that_is_left_out_is_zero(deck):
    mesh = read_mesh(
        deck(("  9, 2., 2.\n", "  9, 2.,\n"), ("24, 6, 9, 8\n", ""), ("12, 2, 3, 6, 5\n", "12, 2, 9, 6, 5\n"))
    ).mesh
    assert mesh.points.tolist() == [[0, 0], [1, 0], [0, 1], [1, 1], [2, 1], [0, 2], [1, 2], [2, 0]]


@pytest.mark.parametrize(
    ("last", "notes"),
    [
        ("*End Step", ()),
        ("24, 6, 9, 8", ()),  # what is missing then, sets and surfaces, cannot be known
        ("22, 5, 8, 7", ("1 node is in no element: is the file cut off?",)),
        ("11, 1, 2, 5, 4", ("5 nodes are in no element: is the file cut off?",)),
        ("*Elset, elset=_wall_S4, internal", ("ends with *ELSET and none of its lines: is the file cut off?",)),
        ("*Elset, elset=_wall_S4, internal\n 11,", ("ends with a comma, as if a line followed: is the file cut off?",)),
    ],
)
@pytest.mark.parametrize("end", ["", "\n", "\r\n\r\n"])
def test_signs_of_a_deck_that_was_cut_off_are_told(last, notes, end, deck):
    path = deck()
    text = path.read_text()
    path.write_bytes((text[: text.index(last) + len(last)] + end).encode())
    assert read_mesh(path).notes == notes
    assert whole_mesh(path)[1][: len(notes)] == notes


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("*End Part", "*Node\n 1, 9., 9."), "has the node 1 twice: of several parts with numbers of their own write"),
        (("*End Part", "*Element, type=CPS3\n 11, 1, 2, 4"), "has the element 11 twice"),
        (("_floor_S1, S1", "99, S1"), "names the element 99, which is not there"),
        (("22, 5, 8, 7", "22, 5, 8, 77"), "names the node 77, which is not there"),
        (("22, 5, 8, 7", "22, 5, 8"), "an element of the type CPS3 has more or fewer than 3 nodes"),
        (("22, 5, 8, 7", "22, 5, 8, x"), "its elements are no whole numbers"),
        (("8, 1., 2.", "8, 1., y"), "its coordinates are no numbers"),
        (("type=cps3", "type=CPS5"), "has elements of the type CPS5, which is not known here"),
        (("11, 12, 1", "first, last"), "its ranges of a set are no whole numbers"),
    ],
)
def test_what_is_damaged_is_told(change, message, deck):
    with pytest.raises(FileError, match=message):
        read_mesh(deck(change))


def test_a_range_far_beyond_the_elements_takes_no_time(deck):
    mesh = read_mesh(deck(("11, 12, 1", "11, 999999999999, 1"))).mesh
    assert "lower" in mesh.regions or "Upper" in mesh.regions


def test_faces_of_solids_are_no_edges(deck):
    brick = "*Element, type=C3D4\n 31, 1, 2, 5, 9\n*Surface, name=face\n 31, S1\n*End Part"
    read = read_mesh(deck(("*End Part", brick)))
    assert "face" not in read.mesh.labels
    assert read.left_out == ("tetra",)


# As Gmsh writes a square with groups: the bottom, and of its two halves both together and the upper one.
BY_GMSH = """\
*Heading
 square
*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
******* E L E M E N T S *************
*ELEMENT, type=T3D2, ELSET=Line1
1, 1, 2
*ELEMENT, type=T3D2, ELSET=Line2
2, 2, 3
*ELEMENT, type=T3D2, ELSET=Line3
3, 3, 4
*ELEMENT, type=CPS3, ELSET=Surface1
4, 1, 2, 3
5, 1, 3, 4
*ELSET,ELSET=rim_with_blank
1, 2, 
*ELSET,ELSET=plate
4, 
5, 
"""


@pytest.fixture
def of_gmsh(tmp_path):
    def write(text):
        (tmp_path / "a.inp").write_text(text)
        return tmp_path / "a.inp"

    return write


def test_groups_of_gmsh_come_before_entities_and_the_last_comma_is_no_sign_of_a_cut(of_gmsh):
    read = read_mesh(of_gmsh(BY_GMSH))
    assert (read.mesh.labels, read.mesh.regions, read.notes) == (("rim_with_blank", "Line3"), ("plate",), ())
    assert sides(read.mesh, "rim_with_blank") == [(0.5, 0), (1, 0.5)]
    read = read_mesh(of_gmsh(BY_GMSH.replace("plate", "SURFACE1")))  # a group with the name of an entity
    assert (read.mesh.regions, read.notes) == (("Surface1",), ())
    entities = read_mesh(of_gmsh(BY_GMSH[: BY_GMSH.index("*ELSET")]))  # without groups
    assert (set(entities.mesh.labels), entities.mesh.regions) == ({"Line1", "Line2", "Line3"}, ("Surface1",))


@pytest.mark.parametrize(
    ("end", "notes"),
    [
        ("4, ", ["ends with a comma, as if a line followed: is the file cut off?"]),
        ("4, \n", []),
        ("4", []),
        ("plate\n", ["ends with *ELSET and none of its lines: is the file cut off?"]),
    ],
)
def test_a_deck_of_gmsh_that_is_cut_off_in_a_group_is_told(end, notes, of_gmsh):
    first, last = BY_GMSH.split("plate\n")
    text = f"{first}plate\n{last}"
    torn = ["of the 2 elements of Surface1 1 are in no group: is the file cut off?"] if end.startswith("4") else []
    assert list(read_mesh(of_gmsh(text[: text.index(end, len(first)) + len(end)])).notes) == notes + torn


def test_a_comma_at_the_end_of_another_section_of_gmsh_is_told(of_gmsh):
    cut = BY_GMSH[: BY_GMSH.index("4, 1, 2, 3") + len("4, 1, 2, 3")]
    assert read_mesh(of_gmsh(f"{cut},\n")).notes[0] == "ends with a comma, as if a line followed: is the file cut off?"


def test_groups_of_several_entities_are_those_of_the_same_mesh_as_msh(gmsh, tmp_path):
    gmsh.clear()
    gmsh.model.add("plate")
    whole, part = (
        gmsh.model.occ.addRectangle(*corner, 0, *size) for corner, size in (((0, 0), (2, 1)), ((1, 0), (1, 1)))
    )
    gmsh.model.occ.fragment([(2, whole)], [(2, part)])
    gmsh.model.occ.synchronize()
    surfaces = gmsh.model.getEntities(2)
    gmsh.model.addPhysicalGroup(2, [tag for _, tag in surfaces], name="plate")
    gmsh.model.addPhysicalGroup(1, [tag for _, tag in gmsh.model.getBoundary(surfaces, oriented=False)], name="rim")
    gmsh.model.mesh.generate(2)
    found = []
    for ending in ("inp", "msh"):
        gmsh.write(str(tmp_path / f"a.{ending}"))
        read = read_mesh(tmp_path / f"a.{ending}")
        found.append((read.mesh.labels, read.mesh.regions, len(read.mesh.facets), read.notes))
    assert found[0] == found[1]
    assert found[0][:2] == (("rim",), ("plate",))
