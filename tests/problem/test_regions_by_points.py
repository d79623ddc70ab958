"""Regions that are given by points inside: what lines, rings and the outline enclose around these."""

import json
import math

import numpy as np
import pytest
import shapely
from commands import within
from invariants import check_area, check_arrays, check_edges
from partitions import MOONS, check_pieces, domain_of, mesh_of

import bubblemesh
from bubblemesh.case import load_case
from bubblemesh.errors import CaseError, GeometryError
from bubblemesh.meshfiles.read import read_mesh
from bubblemesh.problem.domain import case_domain
from bubblemesh.problem.prepare import prepare

BOX = "  outer: {rectangle: [0, 0, 4, 2], labels: [bottom, right, top, left]}\n"


def section(lines="", regions="", more=BOX):
    """Text of a domain with some lines and regions, by default in a box of 4 by 2."""
    return f"domain:\n{more}  lines: [{lines}]\n  regions: [{regions}]\n"


def regions_of(text):
    """Names, areas of the polygonal copies, and numbers of holes of the regions, in their order."""
    found = domain_of(text).parts.regions
    return [(one.name, round(one.polygon.area, 3), len(one.area.holes)) for one in found]


def areas_of_triangles(mesh):
    a, b, c = np.moveaxis(mesh.points[mesh.triangles[:, :3]], 1, 0)
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    return (ux * vy - uy * vx) / 2


def areas_in(mesh):
    """Area of each region by its name, as meshed."""
    return dict(zip(mesh.regions, np.bincount(mesh.triangle_regions, areas_of_triangles(mesh)).tolist(), strict=True))


def labels_around(mesh, region):
    """Labels of the edges that have a region on one of their sides only."""
    of = mesh.regions.index(region)
    sides = np.sort(mesh.triangles[mesh.triangle_regions == of][:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges, times = np.unique(sides, axis=0, return_counts=True)
    label = dict(zip(map(tuple, np.sort(mesh.facets, axis=1).tolist()), mesh.facet_labels.tolist(), strict=True))
    return {mesh.labels[label[tuple(edge)]] for edge in edges[times == 1].tolist()}


def check(mesh):
    """The invariants of a mesh with lines in it."""
    for one in (check_arrays, check_edges, check_area):
        one(mesh)


# A section with two horizons, the lower one offset at a fault, and a lens; the upper part is given by two points.
SECTION = section(
    "{path: [[0, 1.5], [4, 1.3]], label: upper}, {path: [[0, 0.5], [2.2, 0.6]], label: lower}, "
    "{path: [[1.8, 0.9], [4, 1]], label: lower}, {path: [[2.4, 0], [1.6, 2]], label: fault}",
    "{name: till, at: [[1, 1.8], [3, 1.8]]}, {name: lens, ring: {circle: {center: [3.2, 0.5], radius: 0.2}}, "
    "spacing: 0.15}, {name: sand, at: [1, 0.2], spacing: 0.2}, {name: clay, at: [3, 0.2]}",
)


def section_areas():
    """Its areas by shapely, which splits straight lines on its own."""
    lines = [[(0, 1.5), (4, 1.3)], [(0, 0.5), (2.2, 0.6)], [(1.8, 0.9), (4, 1)], [(2.4, 0), (1.6, 2)]]
    whole = shapely.union_all([shapely.box(0, 0, 4, 2).exterior, *map(shapely.LineString, lines)])
    faces = shapely.get_parts(shapely.polygonize([whole]))
    upper, upper_too, sand, clay = (
        next(face.area for face in faces if face.contains(shapely.Point(at)))
        for at in ((1, 1.8), (3, 1.8), (1, 0.2), (3, 0.2))
    )
    lens = 0.04 * math.pi
    found = {"till": upper + upper_too, "lens": lens, "sand": sand, "clay": clay - lens}
    return found | {"domain": 8 - sum(found.values())}


def test_horizons_and_a_fault_make_regions_with_exact_areas_and_the_labels_of_the_lines():
    mesh = mesh_of(SECTION + "spacing: 0.3\n")
    check(mesh)
    expected = section_areas()
    found = areas_in(mesh)
    assert list(found) == ["domain", "till", "lens", "sand", "clay"], "in the order of the case"
    for name in ("till", "sand"):
        assert found[name] == pytest.approx(expected[name], rel=1e-12)
    assert found == pytest.approx(expected, abs=0.02)  # chords of the circle
    assert labels_around(mesh, "sand") == {"bottom", "fault", "lower", "left"}
    assert labels_around(mesh, "clay") == {"bottom", "right", "fault", "lower", "lens-rim"}
    assert not any("sand-rim" in label for label in mesh.labels)


RING = "[1, 1], [1, 0.5], [2, 0.5], [2, 1], [1, 1]"
INNER, INNERMOST = "{rectangle: [1, 0.5, 2, 1.5]}", "{rectangle: [1.2, 0.8, 1.7, 1.2]}"
ARCS = ", ".join(f"{{arc: {{to: [{x}, 1], center: [1.5, 1], turn: left}}}}" for x in (2, 1))
WAVE = "{spline: {through: [[1, 1.4], [2, 1], [3, 0.6], [4, 1]]}}"
HOLE = BOX + "  holes: [{rectangle: [0.5, 0.5, 1, 1.5]}]\n"
TWO_BOXES = "  outer: [{rectangle: [0, 0, 4, 2]}, {rectangle: [5, 0, 6, 1]}]\n"
FACES = {
    "lines that cross": (
        section("{path: [[2, 0], [2, 2]]}, {path: [[0, 1], [4, 1]]}", "{name: a, at: [[1, 0.5], [3, 1.5]]}"),
        [("a", 2, 0), ("a", 2, 0)],
    ),
    "a face around a face": (
        section(f"{{path: [{RING}]}}", "{name: a, at: [3, 1]}, {name: b, at: [1.5, 0.8]}"),
        [("a", 7.5, 1), ("b", 0.5, 0)],
    ),
    "an island at the end of a line": (
        section(f"{{path: [[0, 1], {RING}]}}", "{name: a, at: [3, 1]}"),
        [("a", 7.5, 1)],
    ),
    "an island that touches a side": (
        section("{path: [[0, 1], [1, 0.5], [1, 1.5], [0, 1]]}", "{name: a, at: [3, 1]}, {name: b, at: [0.5, 1]}"),
        [("a", 7.5, 1), ("b", 0.5, 0)],
    ),
    "regions within each other": (
        section("", f"{{name: a, at: [3, 1]}}, {{name: c, ring: {INNER}}}, {{name: d, ring: {INNERMOST}}}"),
        [("a", 7, 1), ("c", 1, 0), ("d", 0.2, 0)],
    ),
    "a line across a region": (
        section("{path: [[1.5, 0], [1.5, 2]]}", f"{{name: half, at: [1.2, 1]}}, {{name: c, ring: {INNER}}}"),
        [("half", 0.5, 0), ("c", 1, 0)],
    ),
    "a hole": (section("{path: [[2, 0], [2, 2]]}", "{name: a, at: [0.2, 1]}", HOLE), [("a", 3.5, 1)]),
    "separate pieces": (section("", "{name: b, at: [5.5, 0.5]}", TWO_BOXES), [("b", 1, 0)]),
    "arcs that touch lines": (
        section(
            f"{{path: [[0, 0.5], [4, 0.5]]}}, {{path: [[0, 1.5], [4, 1.5]]}}, {{path: [[1, 1], {ARCS}]}}",
            "{name: a, at: [0.5, 1]}, {name: b, at: [1.5, 1]}",
        ),
        [("a", round(1.5 - math.pi / 8, 3), 0), ("b", round(math.pi / 4, 3), 0)],
    ),
    "splines that cross a line": (
        section(
            f"{{path: [[0, 1], {WAVE}]}}, {{path: [[0, 0.6], [4, 1.4]]}}",
            "{name: a, at: [1, 0.2]}, {name: b, at: [3, 1.8]}, {name: c, at: [1, 1.1]}, {name: d, at: [3, 0.9]}",
        ),
        [("a", 3.067, 0), ("b", 3.067, 0), ("c", 0.933, 0), ("d", 0.933, 0)],
    ),
}


@pytest.mark.parametrize(("text", "expected"), FACES.values(), ids=FACES)
def test_faces_are_what_lines_and_rings_enclose(text, expected):
    assert regions_of(text) == expected
    check_pieces(domain_of(text))


def test_a_point_between_a_curve_and_its_chord_is_on_its_side_of_the_curve():
    bore = BOX + "  holes: [{circle: {center: [1, 1], radius: 0.5}}]\n"
    (ring,) = domain_of(section(more=bore)).boundary.chords().start[4:][None]
    first, second = ring[1:3]
    (x, y), out = (first + second) / 2, (first + second) / 2 - 1
    out *= 0.5 / np.hypot(*out) - 1
    between, beyond = ([float(x + share * out[0]), float(y + share * out[1])] for share in (0.6, 1.4))
    with pytest.raises(GeometryError, match="lies outside the domain or in a hole"):
        domain_of(section("", f"{{name: a, at: {between}}}", bore))
    assert regions_of(section("", f"{{name: a, at: {beyond}}}", bore)) == [("a", 7.215, 1)]


def test_a_point_of_copies_outside_is_left_out():
    lines = "{path: [[1, 0], [1, 2]], repeat: {grid: [3, 1], step: [1, 0]}}"
    points = "{name: a, at: [0.5, 1], repeat: {grid: [5, 1], step: [1, 0], outside: skip, name: 'a-{i}'}}"
    assert regions_of(section(lines, points)) == [(f"a-{k}", 2, 0) for k in range(4)]
    assert "1 point of regions left out, outside of the domain" in domain_of(section(lines, points)).notes


TWO = "{name: a, at: [1, 1]}, {name: b, at: [3, 1]}"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (section("", "{name: a, at: [5, 1]}"), "point of region 'a' at (5, 1) lies outside the domain or in a hole"),
        (section("{path: [[2, 0], [2, 2]], label: h}", "{name: a, at: [2, 1]}"), "'a' at (2, 1) lies on 'h': move it"),
        (section("", "{name: a, at: [0, 1]}"), "'a' at (0, 1) lies on 'left': move it"),
        (section("", TWO), "no line separates the points of regions 'a' at (1, 1) and 'b' at (3, 1): draw a line"),
        (
            section("{path: [[2, 0], [2, 1.98]], label: h}", TWO),
            "'b' at (3, 1): the line 'h' ends at (2, 1.98), 0.02 from 'top' (join: 0.022 closes that)",
        ),
        (
            section("{path: [[2, 0], [2, 1]], label: h}, {path: [[2, 2], [2, 1.02]], label: g, scale: 1.001}", TWO),
            "the line 'h' ends at (2, 1), 0.021 from 'g' (join: 0.023 closes that); the line 'g' ends at (2.002, 1.021",
        ),
        (
            section(f"{{path: [{RING[:-6]}[1.01, 1]], label: h}}", "{name: a, at: [1.5, 0.7]}, {name: b, at: [3, 1]}"),
            "the line 'h' ends at (1, 1), 0.01 from its other end",
        ),
        (
            section("", f"{{name: a, at: [1.5, 1]}}, {{name: c, ring: {INNER}}}"),
            "are the same: remove one of them",
        ),
    ],
)
def test_points_that_name_no_face_of_their_own_are_refused(text, message):
    with pytest.raises(GeometryError) as caught:
        domain_of(text)
    assert message in str(caught.value)
    assert caught.value.about[:2] == ("domain", "regions")


@pytest.mark.parametrize("regions", [TWO, "{name: a, at: [5, 1]}", "{name: a, at: [0, 1]}"])
def test_points_that_no_repair_puts_right_have_the_domain_made_once(regions, monkeypatch):
    made, read = [], bubblemesh.problem.domain._domain
    monkeypatch.setattr(bubblemesh.problem.domain, "_domain", lambda *given: made.append(given) or read(*given))
    with pytest.raises(GeometryError):
        domain_of(section("", regions))
    assert len(made) == 1


def test_a_gap_that_is_hardly_meant_is_told_and_join_closes_it():
    line = "{path: [[2, 0], [2, 1.999]], label: h"
    problem = prepare(load_case("gap.yaml", text=section(line + "}", "{name: a, at: [1, 1]}") + "spacing: 0.2\n"))
    assert problem.domain.parts.regions[0].polygon.area == 8
    (note,) = problem.warnings
    assert note == (
        "the line 'h' ends at (2, 1.999), 0.001 from 'top', where the spacing is 0.2: join: 0.001 closes the gap"
    )
    assert regions_of(section(line + ", join: 0.001}", "{name: a, at: [1, 1]}")) == [("a", 4, 0)]


SHORT = "{path: [[0.2, 1], [3.9, 1]], label: bed}"  # as between borings, which are not at the sides
LEFT = "nothing is left of region 'rock' beside the regions that points name: "


@pytest.mark.parametrize(
    ("lines", "points", "told"),
    [
        (
            SHORT,
            "[1, 1.5]",
            f"{LEFT}the line 'bed' ends at (3.9, 1), 0.1 from 'right' (join: 0.12 closes that); the line 'bed' ends at "
            "(0.2, 1), 0.2 from 'left' (join: 0.22 closes that); if that is meant, leave region out",
        ),
        ("", "[1, 1.5]", f"{LEFT}draw the lines that part it from the others; if that is meant, leave region out"),
        (SHORT.replace("label", "join: 0.22, label"), "[1, 1.5]", None),
        (SHORT.replace("label", "join: 0.22, label"), "[[1, 1.5], [1, 0.5]]", f"{LEFT}draw the lines"),
    ],
)
def test_a_named_region_of_which_nothing_is_left_is_told_with_the_gaps(lines, points, told):
    text = section(lines, f"{{name: soil, at: {points}}}")
    assert not any("nothing is left" in note for note in domain_of(text).notes), "it has no name in the case"
    found = [note for note in domain_of(text + "  region: rock\n").notes if "nothing is left" in note]
    assert len(found) == (told is not None)
    assert told is None or found[0].startswith(told)


PILE = section(
    "{path: [[0, 1.2], [4, 1.4]], label: base}, {path: [[0.5, 2], [0.5, 0.5]], label: pile}",
    "{name: fill, at: [3, 1.8]}",
)


def test_parts_that_no_point_names_are_counted_with_places_and_areas():
    rest = domain_of(PILE).parts.rest_parts
    assert rest.number == 2
    assert [part.area for part in rest.parts] == pytest.approx([5.2, 0.39375])
    below, left = rest.parts
    assert 0.5 > left.at[0] > 0
    assert left.at[1] > 1.25
    assert below.at[1] < 1.3
    fields = ", ".join(f"{{path: [[{x}, 0], [{x}, 2]]}}" for x in (0.5, 1.2, 2, 2.9, 3.1))
    rest = domain_of(section(fields, "{name: a, at: [0.2, 1]}")).parts.rest_parts
    assert rest.number == 5
    assert [part.area for part in rest.parts] == pytest.approx([1.8, 1.8, 1.6, 0.4]), "the largest ones, the smallest"


def test_holes_and_rings_of_regions_are_no_parts_that_need_a_point():
    hole = BOX + "  holes: [{circle: {center: [1, 1], radius: 0.5}}]\n"
    lens = "{name: lens, ring: {circle: {center: [3, 0.5], radius: 0.3}}}"
    domain = domain_of(section("{path: [[0, 1.6], [4, 1.6]]}", f"{{name: top, at: [1, 1.8]}}, {lens}", hole))
    (rest,) = domain.parts.rest_parts.parts
    assert rest.area == pytest.approx(6.4 - math.pi * (0.25 + 0.09), abs=0.002)
    areas = domain.region_areas
    assert areas == pytest.approx({"domain": rest.area, "top": 1.6, "lens": 0.09 * math.pi}, abs=0.001)
    assert sum(areas.values()) == pytest.approx(domain.polygon.area, rel=1e-12)


@pytest.mark.parametrize(("text", "expected"), FACES.values(), ids=FACES)
def test_areas_of_regions_are_those_of_what_is_in_them(text, expected):
    domain = domain_of(text)
    assert sum(domain.region_areas.values()) == pytest.approx(domain.polygon.area, rel=1e-12)
    rest = domain.parts.rest_parts
    assert sum(part.area for part in rest.parts) == pytest.approx(domain.region_areas.get("domain", 0.0), abs=1e-9)


def test_check_and_run_list_the_parts_that_no_point_names(tmp_path):
    (tmp_path / "case.yaml").write_text(PILE + "  region: rock\nspacing: 0.3\n")
    told = "rest rock has 2 parts that no point names: 5.2 at (2, 0.6), 0.3938 at"
    checked, ran = (
        " ".join((done.stdout + done.stderr).decode().split())
        for done in (within(name, "case.yaml", folder=tmp_path) for name in ("check", "run"))
    )
    assert "regions rock 5.59375, fill 2.40625" in checked
    assert told in checked
    assert told in ran
    (report,) = tmp_path.glob("**/*.report.json")
    rest = json.loads(report.read_text())["rest"]
    assert (rest["region"], rest["number"]) == ("rock", 2)
    assert [part["area"] for part in rest["parts"]] == pytest.approx([5.2, 0.39375])


@pytest.mark.parametrize(
    ("regions", "message"),
    [
        ("{name: a}", "domain.regions.0: must be a mapping with exactly one of the keys ring, at, file"),
        (f"{{name: a, at: [1, 1], ring: {INNER}}}", "must be a mapping with exactly one of the keys ring, at, file"),
        ("{name: a, at: []}", "domain.regions.0.at: must have at least one entry"),
        ("{name: a, at: [1]}", "domain.regions.0.at: must be a point [x, y]"),
        ("{name: a, at: [[1, 1], [2]]}", "domain.regions.0.at.1: must be a point [x, y]"),
        ("{name: domain, at: [1, 1]}", "domain.regions.0.name: 'domain' is the name at domain.region too"),
    ],
)
def test_keys_of_points_are_checked(regions, message):
    with pytest.raises(CaseError) as caught:
        load_case("parts.yaml", text=section("", regions) + "spacing: 1\n")
    assert message in str(caught.value)


def test_faces_between_periodic_sides_are_periodic_too():
    mesh = mesh_of(
        section("{path: [[0.5, 0.5], [2.5, 0.5]], label: bed}", "{name: low, at: [1, 0.2]}", MOONS)
        + "  periodic: [[left, right]]\nspacing: {value: 0.15, regions: {low: 0.1}}\n"
    )
    check(mesh)
    assert areas_in(mesh)["low"] + areas_in(mesh)["domain"] == pytest.approx(2, abs=1e-9)
    assert labels_around(mesh, "low") == {"bottom", "right", "bed", "left"}


BED = section(f"{{path: [[0, 1], {WAVE}], label: bed}}", "{name: low, at: [1, 0.2]}, {name: high, at: [1, 1.8]}")


def test_a_spline_between_faces_carries_layers_on_the_side_of_one_of_them():
    mesh = mesh_of(BED + "spacing: 0.3\nlayers: [{on: bed, region: low, first: 0.03, count: 2}]\n")
    check(mesh)
    thin = areas_of_triangles(mesh) < 0.3 * 0.045
    assert thin.sum() > 20
    assert {mesh.regions[k] for k in mesh.triangle_regions[thin]} == {"low"}
    assert areas_in(mesh)["low"] == pytest.approx(4, abs=0.01)


def test_parts_of_a_packing_keep_the_faces():
    mesh = mesh_of(BED + "spacing: 0.12\nparts: 2\n")
    check(mesh)
    found = areas_in(mesh)
    assert list(found) == ["low", "high"], "nothing is left of the domain"
    assert sum(found.values()) == pytest.approx(8, rel=1e-12)
    assert found["low"] == pytest.approx(4, abs=0.01)
    assert labels_around(mesh, "low") == {"bottom", "right", "bed", "left"}


@pytest.mark.parametrize("ending", ["msh", "med"])
def test_files_hold_the_faces_as_other_regions(tmp_path, ending):
    mesh = mesh_of(BED + "spacing: 0.5\n")
    mesh.write(tmp_path / f"mesh.{ending}")
    read = read_mesh(tmp_path / f"mesh.{ending}").mesh
    assert areas_in(read) == pytest.approx(areas_in(mesh))
    assert set(read.regions) == {"low", "high"}


def test_places_on_the_earth_are_points_too(tmp_path):
    pytest.importorskip("pyproj")
    text = """
crs: {from: EPSG:4326, to: EPSG:32632}
domain:
  outer: {rectangle: [9, 50, 9.02, 50.01]}
  lines: [{path: [[9.01, 50], [9.01, 50.01]], label: middle}]
  regions: [{name: west, at: [9.005, 50.005]}, {name: east, at: [9.015, 50.005]}]
spacing: 200
"""
    mesh = mesh_of(text)
    assert labels_around(mesh, "west") == {"outer", "middle"}
    west, east = (areas_in(mesh)[name] for name in ("west", "east"))
    assert west == pytest.approx(east, rel=1e-3)
    with pytest.raises(GeometryError, match=r"region 'west' at \(9.5, 50.005\) lies outside"):
        mesh_of(text.replace("9.005", "9.5"))


def test_shapely_points_name_regions_of_programs():
    cracks = shapely.MultiLineString([[(0, 1), (4, 1)], [(2, 0), (2, 2)]])
    low = shapely.MultiPoint([(1, 0.5), (3, 0.5)])
    core = shapely.box(0.5, 1.2, 1, 1.8)
    mesh = bubblemesh.mesh(
        shapely.box(0, 0, 4, 2),
        0.3,
        lines={"crack": cracks},
        regions={"low": low, "core": core, "left": shapely.Point(1.5, 1.5)},
    )
    check(mesh)
    assert areas_in(mesh) == pytest.approx({"domain": 2, "low": 4, "core": 0.3, "left": 1.7})
    assert list(mesh.regions) == ["domain", "low", "core", "left"]
    assert labels_around(mesh, "left") == {"outer", "crack", "core-rim"}


@pytest.mark.parametrize(
    ("point", "message"),
    [
        (shapely.Point(5, 1), "regions['a']: the point of region 'a' at (5, 1) lies outside the domain"),
        (shapely.Point(), "regions['a']: the point is empty"),
        (shapely.Point(2, 1), "lies on 'crack': move it"),
    ],
)
def test_points_of_programs_are_checked(point, message):
    with pytest.raises(GeometryError) as caught:
        bubblemesh.mesh(shapely.box(0, 0, 4, 2), 0.3, lines={"crack": [(2, 0), (2, 2)]}, regions={"a": point})
    assert message in str(caught.value)


def test_two_points_of_programs_in_one_face_are_told_the_gap():
    with pytest.raises(GeometryError, match=r"the line 'crack' ends at \(2, 1.9\), 0.1 from 'outer'$"):
        bubblemesh.mesh(
            shapely.box(0, 0, 4, 2),
            0.3,
            lines={"crack": [(2, 0), (2, 1.9)]},
            regions={"a": shapely.Point(1, 1), "b": shapely.Point(3, 1)},
        )


@pytest.fixture
def domain_with(tmp_path):
    def make(regions, more=BOX, **files):
        for name, content in files.items():
            (tmp_path / name.replace("_", ".")).write_text(content)
        lines = "{path: [[2, 0], [2, 2]]}, {path: [[0, 1], [4, 1]]}"
        (tmp_path / "case.yaml").write_text(section(lines, "", more).replace("[]", f"{regions}") + "spacing: 1\n")
        return case_domain(load_case(tmp_path / "case.yaml"))

    return make


UNITS = "unit,x,y\nclay,1,0.5\nsand,1,1.5\nsand,3,1.5\n"
COLLECTION = {
    "type": "FeatureCollection",
    "features": [
        {"type": "Feature", "properties": {"unit": unit}, "geometry": {"type": kind, "coordinates": places}}
        for unit, kind, places in (("clay", "Point", [1, 0.5]), ("sand", "MultiPoint", [[1, 1.5], [3, 1.5]]))
    ],
}


@pytest.mark.parametrize(("name", "content"), [("a_csv", UNITS), ("a_geojson", json.dumps(COLLECTION))])
def test_points_of_a_file_name_the_regions_around_them(domain_with, name, content):
    found = domain_with(f"{{file: {name.replace('_', '.')}, name: unit}}", **{name: content})
    assert [(one.name, one.polygon.area) for one in found.parts.regions] == [("clay", 2), ("sand", 2), ("sand", 2)]
    mirrored = domain_with(f"[{{file: {name.replace('_', '.')}, name: unit, mirror: y, move: [0, 2]}}]")
    assert [one.area.outer.outline[:, 1].mean() for one in mirrored.parts.regions] == [1.5, 0.5, 0.5]


@pytest.mark.parametrize(
    ("regions", "more", "message"),
    [
        ("{file: a.csv, name: unit, join: 0.1}", BOX, "join is for areas, and a.csv has points alone: leave it out"),
        ("{file: a.csv, name: unti}", BOX, "unknown property 'unti'; did you mean 'unit'?"),
        ("[{name: clay, at: [3, 0.5]}, {file: a.csv, name: unit}]", BOX, "'clay' is the name of another region too"),
        ("{file: a.csv, name: unit}", "", "points name regions in a domain that outer or file gives: add that"),
    ],
)
def test_files_of_points_are_checked(domain_with, regions, more, message):
    with pytest.raises(CaseError) as caught:
        domain_with(regions, more, a_csv=UNITS)
    assert message in str(caught.value)


# Splines across an ellipse: computed from the sides of a face alone, crossings with curves would differ by 1e-7.
SPLINES = [
    [[-0.2, 0.628], [0.9, 0.395], [2, 1.298], [3.1, 1.438], [4.2, 1.068]],
    [[-0.2, 1.028], [0.9, 0.583], [2, 0.66], [3.1, 1.071], [4.2, 1.488]],
    [[-0.2, 1.321], [0.9, 1.605], [2, 1.631], [3.1, 0.524], [4.2, 1.283]],
]


def test_faces_between_curves_that_cross_at_many_places_fit_each_other():
    lines = ", ".join(f"{{path: [{first}, {{spline: {{through: {others}}}}}]}}" for first, *others in SPLINES)
    lines += ", {path: [[0.677, 1.109], [0.703, 1.013], [1.368, 1.925]]}"
    ellipse = "  outer: {ellipse: {center: [2, 1], radii: [2, 1], angle: 5}}\n"
    chords = domain_of(section(lines, "", ellipse)).boundary.chords()
    net = shapely.union_all(shapely.linestrings(np.stack([chords.start, chords.end], axis=1)))
    faces = shapely.get_parts(shapely.polygonize([net]))
    faces = faces[shapely.area(faces) > 0.01]
    places = shapely.get_coordinates(shapely.point_on_surface(faces)).tolist()
    domain = domain_of(section(lines, ", ".join(f"{{name: r{k}, at: {at}}}" for k, at in enumerate(places)), ellipse))
    check_pieces(domain)
    assert len(faces) >= 8
    for region, face in zip(domain.parts.regions, faces, strict=True):
        assert region.polygon.area == pytest.approx(face.area, rel=1e-3)
