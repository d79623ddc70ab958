import re
import subprocess
import sys

import meshio
import numpy as np
import pytest
import shapely
import yaml
from paths import ROOT
from PIL import Image

import bubblemesh
from bubblemesh.case import load_case
from bubblemesh.case.data_terms import DataTerms
from bubblemesh.errors import CaseError, FileError
from bubblemesh.geometry import rings
from bubblemesh.geometry.arrangement.regions import InnerParts, Region
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.paths import Area
from bubblemesh.problem.data_terms import FUNCTIONS
from bubblemesh.problem.prepare import prepare
from bubblemesh.run.pipeline import mesh_case

PAGE = (ROOT / "docs/spacing.md").read_text().partition("\n## Fields\n")[2].partition("\n## ")[0]
BLOCKS = re.findall(r"```(python|yaml)\n(.*?)```", PAGE, flags=re.DOTALL)
PLATE = """
domain:
  outer: {rectangle: [0, 0, 1, 1]}
  holes: [{circle: {center: [0.6, 0.5], radius: 0.2}}]
"""


def posed(folder, spacing, **options):
    return prepare(load_case(folder / "case.yaml", text=f"{PLATE}\nspacing: {spacing}", **options))


def values(folder, spacing, *points):
    return posed(folder, spacing).spacing(np.array(points, float))


def square_mesh(path, **data):
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    meshio.Mesh(points, [("triangle", [[0, 1, 2], [0, 2, 3]])], **data).write(path)


class TestTerms:
    def test_mesh(self, tmp_path):
        square_mesh(tmp_path / "a.vtu", point_data={"h": [0.1, 0.2, 0.3, 0.4]}, cell_data={"c": [[0.1, 0.2]]})
        found = values(tmp_path, "{field: {file: a.vtu, name: h, scale: 0.5}}", [0, 0], [0.5, 0], [0.25, 0.75])
        np.testing.assert_allclose(found, [0.05, 0.075, 0.15])
        found = values(tmp_path, "{field: {file: a.vtu, name: c}}", [1, 0], [0, 1])
        np.testing.assert_allclose(found, [0.1, 0.2])

    def test_array(self, tmp_path):
        np.save(tmp_path / "a.npy", [[0.1, 0.2], [0.3, 0.4]])
        corners = [0, 0], [1, 0], [0, 1], [1, 1]
        found = values(tmp_path, "{raster: {file: a.npy, bounds: [0, 0, 1, 1], scale: 2}}", *corners)
        np.testing.assert_allclose(found, [0.2, 0.4, 0.6, 0.8])
        found = values(tmp_path, "{raster: {file: a.npy, bounds: [0, 0, 1, 1], origin: upper}}", *corners)
        np.testing.assert_allclose(found, [0.3, 0.4, 0.1, 0.2])
        np.savez(tmp_path / "a.npz", x=[0, 1], y=[1, 0], d=[[0.1, 0.2], [0.3, 0.4]], other=[[9]])
        np.testing.assert_allclose(values(tmp_path, "{raster: {file: a.npz, name: d}}", *corners), [0.3, 0.4, 0.1, 0.2])

    def test_bounds_count_before_coordinates_in_the_file(self, tmp_path):
        np.savez(tmp_path / "a.npz", x=[0, 7], y=[0, 7], d=[[0.1, 0.2], [0.1, 0.2]])
        found = values(tmp_path, "{raster: {file: a.npz, bounds: [0, 0, 1, 1]}}", [0.5, 0])
        np.testing.assert_allclose(found, 0.15)

    def test_picture(self, tmp_path):
        Image.fromarray(np.array([[0, 255], [255, 51]], np.uint8)).save(tmp_path / "a.png")
        found = values(
            tmp_path,
            "{image: {file: a.png, bounds: [0, 0, 1, 1], finest: 0.1, coarsest: 0.6}}",
            [0, 1],
            [1, 1],
            [0, 0],
            [1, 0],
        )
        np.testing.assert_allclose(found, [0.1, 0.6, 0.6, 0.2])

    @pytest.mark.parametrize("given", ["file: a.csv", "points: [[0, 0, 0.1], [1, 0, 0.2], [0, 1, 0.3], [1, 1, 0.4]]"])
    def test_scattered_points(self, given, tmp_path):
        (tmp_path / "a.csv").write_text("x, y, d\n0, 0, 0.1\n1, 0, 0.2\n0, 1, 0.3\n1, 1, 0.4\n")
        found = values(tmp_path, f"{{scattered: {{{given}, scale: 10}}}}", [0, 0], [0.5, 0], [0.5, 0.5], [0, 0.9])
        np.testing.assert_allclose(found, [1, 1.5, 2.5, 2.8])

    def test_the_smallest_of_several_counts(self, tmp_path):
        np.save(tmp_path / "a.npy", [[0.1, 0.3]])
        np.save(tmp_path / "b.npy", [[0.4, 0.2]])
        rasters = ", ".join(f"{{file: {name}.npy, bounds: [0, 0, 1, 1]}}" for name in "ab")
        points = [0.1, 0.1], [0.9, 0.1]
        np.testing.assert_allclose(values(tmp_path, f"{{raster: [{rasters}]}}", *points), [0.1, 0.2])
        np.testing.assert_allclose(values(tmp_path, f"{{raster: [{rasters}], value: 0.15}}", *points), [0.1, 0.15])

    def test_files_are_relative_to_the_case_that_names_them(self, tmp_path):
        (tmp_path / "below").mkdir()
        np.save(tmp_path / "a.npy", [[0.1]])
        np.save(tmp_path / "below/a.npy", [[0.2]])
        raster = "raster: {file: a.npy, bounds: [0, 0, 1, 1]}"
        (tmp_path / "base.yaml").write_text(f"{PLATE}\nspacing: {{{raster}}}")
        path = tmp_path / "below/case.yaml"
        for text, expected in [("base: ../base.yaml", 0.1), (f"base: ../base.yaml\nspacing: {{{raster}}}", 0.2)]:
            spacing = prepare(load_case(path, text=text)).spacing
            assert spacing(np.array([[0.1, 0.1]])) == pytest.approx(expected)

    def test_the_report_tells_what_was_given(self, tmp_path):
        np.save(tmp_path / "a.npy", [[0.3]])
        points = [[0, 0, 1], [1, 0, 1], [0, 1, 1]]
        spacing = f"{{raster: {{file: a.npy, bounds: [0, 0, 1, 1]}}, scattered: {{points: {points}}}}}"
        given = posed(tmp_path, spacing).task.parameters["spacing"]
        assert given["raster"]["file"] == str(tmp_path / "a.npy")
        assert given["scattered"]["points"] == points


KEYS = [
    ("{fields: 3}", "spacing.fields: unknown key; did you mean 'field'?"),
    ("{field: {}}", "spacing.field.file: is missing"),
    ("{field: []}", "spacing.field: must have at least one entry"),
    (
        "{field: previous.vtu}",
        "spacing.field: must be a mapping of keys to values (found the text 'previous.vtu'; write {file: ...})",
    ),
    ("{field: {file: a, nam: h}}", "spacing.field.nam: unknown key; did you mean 'name'?"),
    ("{field: [{file: a}, {file: a, nam: h}]}", "spacing.field.1.nam: unknown key; did you mean 'name'?"),
    ("{field: {file: a, scale: 0}}", "spacing.field.scale: must be greater than 0 (found 0)"),
    ("{field: {file: ''}}", "spacing.field.file: must not be empty"),
    ("{raster: {file: a, bounds: [0, 0, 1]}}", "spacing.raster.bounds: must be the numbers [x0, y0, x1, y1]"),
    ("{raster: {file: a, bounds: [0, 1, 1, 1]}}", "spacing.raster.bounds: must be [x0, y0, x1, y1] with x0 below x1"),
    ("{raster: {file: a, origin: top}}", "spacing.raster.origin: must be 'lower' or 'upper' (found the text 'top')"),
    ("{image: {file: a, bounds: [0, 0, 1, 1], finest: 1}}", "spacing.image.coarsest: is missing"),
    ("{image: {file: a, bounds: [0, 0, 1, 1], finest: 2, coarsest: 1}}", "spacing.image: finest must not be above"),
    ("{scattered: {}}", "spacing.scattered: must have one of the keys file and points"),
    ("{scattered: {file: a, points: [[0, 0, 1]]}}", "spacing.scattered: must have one of the keys file and points"),
    ("{scattered: {points: []}}", "spacing.scattered.points: must have at least one entry"),
    ("{scattered: {points: [[0, 0, 1], [0, 0]]}}", "spacing.scattered.points.1: must be a point with its spacing"),
    ("{scattered: {points: [[0, 0, -1]]}}", "spacing.scattered.points.0.2: must be greater than 0 (found -1)"),
]


@pytest.mark.parametrize(("spacing", "message"), KEYS, ids=[spacing for spacing, _ in KEYS])
def test_what_is_wrong_in_the_case_file_is_named_with_line_and_key(spacing, message, tmp_path):
    with pytest.raises(CaseError, match=r"case.yaml:6: " + re.escape(message)):
        posed(tmp_path, spacing)


FILES = [
    ("{field: {file: none.vtu}}", FileError, r"spacing.field: \S+/none.vtu: the file cannot be read: No such file"),
    ("{field: [{file: a.vtu, name: h}, {file: b.vtu}]}", FileError, r"spacing.field.1: \S+b.vtu: holds no triangles"),
    ("{field: {file: a.vtu, name: k}}", CaseError, r"spacing.field: \S+a.vtu: has no data 'k': it has h, bad, worse"),
    ("{field: {file: a.vtu, name: bad}}", CaseError, r"spacing.field: \S+a.vtu: bad: is -1 at node 2 .*\(1, 1\): a sp"),
    ("{field: {file: a.vtu, name: worse}}", CaseError, r"spacing.field: \S+a.vtu: worse: is 0 in the triangle around"),
    ("{raster: {file: none.npy}}", FileError, r"spacing.raster: \S+none.npy: the file cannot be read: No such file"),
    ("{raster: {file: a.npy}}", CaseError, r"spacing.raster: \S+a.npy: a: has no arrays x and y with it: give bounds"),
    ("{raster: {file: a.npz, origin: upper}}", CaseError, r"spacing.raster: \S+a.npz: d: has an array y with it"),
    ("{raster: {file: a.npz}}", CaseError, r"spacing.raster: \S+a.npz: d: is nan in row 1, column 0 .*\(0, 1\): a sp"),
    ("{image: {file: none.png, bounds: [0, 0, 1, 1], finest: 1, coarsest: 2}}", FileError, r"spacing.image: \S+none"),
    ("{scattered: {file: none.csv}}", FileError, r"spacing.scattered: \S+none.csv: the file cannot be read: No such"),
    ("{scattered: {file: a.csv}}", CaseError, r"spacing.scattered: \S+a.csv: line 2: must have 3 numbers, x, y, d"),
    ("{scattered: {points: [[0, 0, 1], [1, 1, 1]]}}", CaseError, "spacing.scattered: the points lie on a line"),
]


@pytest.mark.parametrize(("spacing", "error", "message"), FILES, ids=[message[:30] for _, _, message in FILES])
def test_what_is_wrong_in_a_file_is_named_with_key_file_and_place(spacing, error, message, tmp_path):
    data = {"h": np.ones(4), "bad": np.array([1, 1, -1, 1])}
    square_mesh(tmp_path / "a.vtu", point_data=data, cell_data={"worse": [[1, 0]]})
    meshio.Mesh([[0, 0, 0], [1, 0, 0]], [("line", [[0, 1]])]).write(tmp_path / "b.vtu")
    np.save(tmp_path / "a.npy", [[1.0]])
    np.savez(tmp_path / "a.npz", d=[[1], [np.nan]], x=[0], y=[0, 1])
    (tmp_path / "a.csv").write_text("0, 0, 1\n1, 1\n")
    with pytest.raises(error, match=message):
        posed(tmp_path, spacing)


@pytest.mark.long
@pytest.mark.parametrize(
    ("spacing", "away"),
    [
        ("{field: {file: a.vtu}}", False),
        ("{field: {file: far.vtu}}", True),
        ("{value: 0.2, field: [{file: a.vtu}, {file: far.vtu}]}", True),
        ("{raster: {file: a.npy, bounds: [0.9, 0, 3, 1]}}", False),
        ("{raster: {file: a.npy, bounds: [1.1, 0, 3, 1]}}", True),
        ("{raster: {file: one.npy, bounds: [-9, 0, 2, 1]}}", False),
        ("{scattered: {points: [[0, -2, 0.1], [1, -2, 0.1], [0, -1, 0.1]]}, nodes: 200}", True),
    ],
)
def test_data_beside_the_domain_is_told(spacing, away, tmp_path):
    square_mesh(tmp_path / "a.vtu", point_data={"h": [0.1] * 4})
    meshio.Mesh([[10, 0, 0], [11, 0, 0], [11, 1, 0]], [("triangle", [[0, 1, 2]])], {"h": [0.1] * 3}).write(
        tmp_path / "far.vtu"
    )
    np.save(tmp_path / "a.npy", [[0.1, 0.1], [0.1, 0.1]])
    np.save(tmp_path / "one.npy", [[0.1]])
    warnings = [warning for warning in posed(tmp_path, spacing).warnings if "they do not meet" in warning]
    assert len(warnings) == away
    if "far.vtu}}" in spacing:
        assert warnings[0].startswith("spacing.field: the data is in [10, 11] x [0, 1], the domain in [0, 1] x [0, 1]")


AWAY = "spacing.raster: the data is in [2, 3] x [0, 1], the domain in [0, 1] x [0, 1]: they do not meet"
BEYOND = "spacing.raster: 54% of the domain is beyond the data, which is in [-1, 0.4] x [0, 1]: nearest values count"


@pytest.mark.parametrize(
    ("bounds", "told"), [("[2, 0, 3, 1]", AWAY), ("[-1, 0, 0.4, 1]", BEYOND), ("[0.005, 0, 1, 1]", None)]
)
@pytest.mark.parametrize("value", ["", "value: 0.1 + 0*raster.z, "])
def test_the_part_of_the_domain_beyond_a_raster_is_told(bounds, told, value, tmp_path):
    np.save(tmp_path / "z.npy", [[0.1, 0.1], [0.1, 0.1]])
    found = posed(tmp_path, f"{{{value}raster: {{file: z.npy, name: z, bounds: {bounds}}}}}").warnings
    warnings = [warning for warning in found if warning.startswith("spacing.raster")]
    assert len(warnings) == (told is not None)
    assert all(told in warning for warning in warnings), warnings


def test_a_raster_that_an_expression_names_has_numbers(tmp_path):
    np.save(tmp_path / "z.npy", [[-0.1, np.nan, -0.1], [-0.1, np.inf, -0.1]])
    message = (
        r"spacing.raster: .*z: is nan in row 0, column 1 \(from 0\), \(0.5, 0.25\), and 1 more value is as bad: it has"
    )
    with pytest.raises(CaseError, match=message):
        posed(tmp_path, "{value: 0.1 - raster.z, raster: {file: z.npy, name: z, bounds: [0, 0, 1, 1]}}")


@pytest.mark.long
@pytest.mark.parametrize("at", ["nodes", "cells"])
def test_a_mesh_made_by_the_spacing_of_the_one_before_is_like_it(at, tmp_path):
    first = mesh_case(load_case(tmp_path / "case.yaml", text=f"{PLATE}\nspacing: '0.02 + 0.06*hypot(x, y)'"))
    mesh = first.mesh
    points = np.column_stack([mesh.points, np.zeros(len(mesh.points))])
    h = 0.02 + 0.06 * np.hypot(*mesh.points.T)
    data = {"point_data": {"h": h}} if at == "nodes" else {"cell_data": {"h": [first.fields["target_spacing"]]}}
    meshio.Mesh(points, [("triangle", mesh.triangles)], **data).write(tmp_path / "previous.vtu")
    again = mesh_case(load_case(tmp_path / "case.yaml", text=f"{PLATE}\nspacing: {{field: {{file: previous.vtu}}}}"))
    assert again.report["ideal_nodes"] == pytest.approx(first.report["ideal_nodes"], rel=0.01)
    assert again.report["nodes"] == pytest.approx(first.report["nodes"], rel=0.02)
    assert again.report["spacing"]["std"] == pytest.approx(first.report["spacing"]["std"], abs=0.01)
    assert again.report["spacing"]["mean"] == pytest.approx(first.report["spacing"]["mean"], abs=0.01)
    assert again.report["warnings"] == first.report["warnings"]


class TestFromPython:
    @pytest.mark.long
    def test_a_mapping_is_that_of_a_case_file_with_files_in_the_working_directory(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        np.save("a.npy", [[0.2, 0.08]])
        spacing = {"raster": {"file": "a.npy", "bounds": [0, 0, 1, 1]}, "growth": 0.1, "maximum": 0.15}
        square = shapely.Polygon([(0, 0), (1, 0), (1, 1), (0, 1)])
        found = bubblemesh.mesh(square, spacing)
        text = f"domain: {{outer: {{rectangle: [0, 0, 1, 1]}}}}\nspacing: {spacing}"
        expected = mesh_case(load_case("case.yaml", text=text)).mesh
        np.testing.assert_array_equal(found.points, expected.points)
        assert len(found.points) > len(bubblemesh.mesh(square, spacing | {"growth": 9.0}).points)

    @pytest.mark.parametrize(("spacing", "message"), KEYS, ids=[spacing for spacing, _ in KEYS])
    def test_what_is_wrong_is_named_with_the_key(self, spacing, message):
        with pytest.raises(CaseError, match="^" + re.escape(f"mesh(): {message}")):
            bubblemesh.mesh(shapely.box(0, 0, 1, 1), yaml.safe_load(spacing))

    def test_expressions_in_a_mapping_are_checked(self):
        with pytest.raises(CaseError, match=r"^mesh\(\): spacing.value: column 1: unknown name 'z'"):
            bubblemesh.mesh(shapely.box(0, 0, 1, 1), {"value": "z"})

    def test_files_that_are_missing_are_named(self):
        with pytest.raises(
            FileError, match=r"^mesh\(\): spacing.field: none.vtu: the file cannot be read: No such file"
        ):
            bubblemesh.mesh(shapely.box(0, 0, 1, 1), {"field": {"file": "none.vtu"}})

    def test_regions_of_a_domain_do_not_matter(self):
        parts = InnerParts((Region(Area(rings.rectangle(0, 0, 1, 1)), "west", "rim"),), "east")
        domain = Domain.of(rings.rectangle(0, 0, 2, 1), [], parts)
        assert set(bubblemesh.mesh(domain, {"value": 0.2, "growth": 0.2}).regions) == {"west", "east"}


def test_the_page_shows_every_kind_of_term():
    shown = "".join(text for language, text in BLOCKS if language == "yaml")
    assert all(f"{key}:" in shown for key in DataTerms.model_fields)


def test_every_kind_of_term_has_a_function():
    keys = [*DataTerms.model_fields, "function"]  # the last one of programs only
    assert [f"{key.title()}Term" for key in keys] == [model.__name__ for model in FUNCTIONS]


def test_only_two_modules_know_the_kinds_of_terms():
    """A new one is a model with its key, a function of the place, and a row that binds the two."""
    known = "|".join(model.__name__ for model in FUNCTIONS)
    naming = [path for path in (ROOT / "bubblemesh").rglob("*.py") if re.search(rf"\b({known})\b", path.read_text())]
    assert sorted(str(path.relative_to(ROOT / "bubblemesh")) for path in naming) == [
        "case/data_terms.py",
        "problem/data_terms.py",
    ]
    keys = "|".join(DataTerms.model_fields)
    quoted = rf"[\"']({keys})[\"']|(?<!spacing\.)terms\.({keys})\b"
    for room in ("batch", "case", "problem", "run"):
        for path in (ROOT / "bubblemesh" / room).rglob("*.py"):
            assert not re.search(quoted, path.read_text()) or path.name == "data_terms.py", path


@pytest.mark.long
def test_what_the_page_shows_works_from_top_to_bottom(tmp_path):
    program = "\n".join(text for language, text in BLOCKS if language == "python")
    subprocess.run([sys.executable, "-c", program], cwd=tmp_path, check=True, timeout=60)
    cases = [text for language, text in BLOCKS if language == "yaml"]
    assert cases
    for text in cases:
        result = mesh_case(load_case(tmp_path / "case.yaml", text=text, overrides=["packing.effort=fast"]))
        assert result.report["nodes"] > 100
        assert result.report["warnings"] == []
        assert result.report["quality"]["min"] > 0.3
        assert 0.9 < result.report["spacing"]["mean"] < 1.1


@pytest.mark.parametrize(("size", "told"), [(1000, True), (15, False), (1, False)])
def test_a_field_in_another_unit_is_told(tmp_path, size, told):
    points = [[-size / 2, -size / 3, 0], [size, 0, 0], [size, size, 0], [-size / 3, size, 0]]
    meshio.Mesh(points, [("triangle", [[0, 1, 2], [0, 2, 3]])], {"h": [0.1] * 4}).write(tmp_path / "a.vtu")
    warnings = posed(tmp_path, "{field: {file: a.vtu, name: h}}").warnings
    assert any(text.endswith(": are its units those of the domain?") for text in warnings) == told


def test_a_large_field_with_nodes_in_the_domain_is_not_told(tmp_path):
    points = [[-500, -500, 0], [500, -500, 0], [0, 500, 0], [0.5, 0.5, 0]]
    cells = [[0, 1, 3], [1, 2, 3], [2, 0, 3]]
    meshio.Mesh(points, [("triangle", cells)], {"h": [0.1] * 4}).write(tmp_path / "a.vtu")
    assert not any("units" in text for text in posed(tmp_path, "{field: {file: a.vtu, name: h}}").warnings)
