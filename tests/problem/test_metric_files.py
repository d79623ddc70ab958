"""Metrics in files: tensors at the nodes of a mesh."""

import meshio
import numpy as np
import pytest
from commands import refused
from squares import holed_square

from bubblemesh import Mesh, load_case, mesh_case
from bubblemesh.errors import BubblemeshError
from bubblemesh.problem.files import named_files
from bubblemesh.problem.prepare import prepare

CASE = """
name: a
domain: {{outer: {{rectangle: [0.4, -3.1, 3.3, -0.2]}}}}
spacing: 0.4
metric: {{file: {name}{more}}}
"""


@pytest.fixture
def mesh():
    return holed_square()


def tensors(points):
    """Ellipses of 0.1 by 0.4, along x on the left and along y on the right."""
    left = points[:, 0] < 1.8
    m11, m22 = np.where(left, 1 / 0.16, 100.0), np.where(left, 100.0, 1 / 0.16)
    return np.column_stack([m11, 0 * m11, m22])


def write_vtu(mesh, path, **data):
    space = np.column_stack([mesh.points, 0 * mesh.points[:, 0]])
    meshio.write(path, meshio.Mesh(space, [("triangle", mesh.triangles)], point_data=data))


def write_medit(mesh, path, values):
    lines = ["MeshVersionFormatted 2", "Dimension 2", "Vertices", str(len(mesh.points))]
    lines += [f"{x!r} {y!r} 0" for x, y in mesh.points.tolist()]
    lines += ["Triangles", str(len(mesh.triangles))]
    lines += [f"{a + 1} {b + 1} {c + 1} 1" for a, b, c in mesh.triangles.tolist()]
    path.write_text("\n".join([*lines, "End", ""]))
    rows = [" ".join(map(repr, row)) for row in values.tolist()]
    head = ["MeshVersionFormatted 2", "Dimension 2", "SolAtVertices", str(len(values)), "1 3"]
    path.with_suffix(".sol").write_text("\n".join([*head, *rows, "End", ""]))


def case_with(tmp_path, name, more="", **options):
    path = tmp_path / "case.yaml"
    path.write_text(CASE.format(name=name, more=more))
    return load_case(path, **options)


def require_turned(case):
    problem = prepare(case)
    across, along, direction = problem.spacing.axes(np.array([[0.6, -2.9], [3.1, -2.9]]))
    np.testing.assert_allclose(across, 0.1, rtol=1e-6)
    np.testing.assert_allclose(along, 0.4, rtol=1e-6)
    np.testing.assert_allclose(np.abs(direction), [[1, 0], [0, 1]], atol=1e-6)


@pytest.mark.parametrize("columns", [[0, 1, 2], [0, 1, 1, 2], [0, 1, 3, 1, 2, 3, 3, 3, 3]])
def test_tensors_are_read_by_their_entries_or_as_matrices(tmp_path, mesh, columns):
    values = np.column_stack([tensors(mesh.points), np.zeros(len(mesh.points))])[:, columns]
    write_vtu(mesh, tmp_path / "m.vtu", metric=values, other=mesh.points[:, 0])
    require_turned(case_with(tmp_path, "m.vtu", ", name: metric"))


def test_entries_may_be_data_of_their_own(tmp_path, mesh):
    m11, m12, m22 = tensors(mesh.points).T
    write_vtu(mesh, tmp_path / "m.vtu", m11=m11, u=m11, m12=m12, m22=m22)
    require_turned(case_with(tmp_path, "m.vtu"))


def test_the_only_data_with_as_many_numbers_as_a_tensor_is_the_metric(tmp_path, mesh):
    write_vtu(mesh, tmp_path / "m.vtu", u=mesh.points[:, 0], m=tensors(mesh.points), v=mesh.points)
    require_turned(case_with(tmp_path, "m.vtu"))


def test_tensors_of_gmsh_are_read(tmp_path, mesh):
    m11, m12, m22 = tensors(mesh.points).T
    values = np.column_stack([m11, m12, 0 * m11, m12, m22, 0 * m11, 0 * m11, 0 * m11, 1 + 0 * m11])
    space = np.column_stack([mesh.points, 0 * m11])
    cells = [("triangle", mesh.triangles.astype(np.int64))]
    meshio.write(tmp_path / "m.msh", meshio.Mesh(space, cells, point_data={"metric": values}), file_format="gmsh22")
    require_turned(case_with(tmp_path, "m.msh"))


def test_a_sol_file_beside_its_mesh_is_read(tmp_path, mesh):
    write_medit(mesh, tmp_path / "m.mesh", tensors(mesh.points))
    case = case_with(tmp_path, "m.mesh")
    assert {path.name for path in named_files(case)} == {"m.mesh", "m.sol"}
    require_turned(case)
    report = mesh_case(case).report
    assert report.metric.aspect == pytest.approx(4, rel=0.05)
    assert report.quality["mean"] > 0.8


def test_an_untrusted_case_reads_a_metric_in_its_own_folder(tmp_path, mesh):
    write_vtu(mesh, tmp_path / "m.vtu", metric=tensors(mesh.points))
    require_turned(case_with(tmp_path, "m.vtu", untrusted=True))


def test_an_untrusted_case_reads_no_metric_elsewhere(tmp_path, mesh):
    folder = tmp_path / "inner"
    folder.mkdir()
    write_vtu(mesh, tmp_path / "m.vtu", metric=tensors(mesh.points))
    with pytest.raises(BubblemeshError, match="inner"):
        prepare(case_with(folder, "../m.vtu", untrusted=True))


def test_what_is_no_metric_is_told_with_the_key_and_the_file(tmp_path, mesh):
    write_vtu(mesh, tmp_path / "u.vtu", u=mesh.points[:, 0])
    with pytest.raises(BubblemeshError, match=r"metric: .*u\.vtu: u: ?has 1 component: .* spacing, by its key field$"):
        prepare(case_with(tmp_path, "u.vtu"))
    bad = tensors(mesh.points)
    bad[5, 0] = -1
    write_vtu(mesh, tmp_path / "bad.vtu", m=bad)
    with pytest.raises(BubblemeshError, match=r"metric: .*bad\.vtu: m: ?is not positive definite and finite at \("):
        prepare(case_with(tmp_path, "bad.vtu"))
    turned = tensors(mesh.points)[:, [0, 1, 1, 2]] + [0, 0, 1, 0]
    write_vtu(mesh, tmp_path / "turned.vtu", m=turned)
    with pytest.raises(
        BubblemeshError, match=r"turned\.vtu: m: ?is not symmetric at \(.*m12 and m21 have to be the same"
    ):
        prepare(case_with(tmp_path, "turned.vtu"))
    with pytest.raises(BubblemeshError, match=r"missing\.vtu"):
        prepare(case_with(tmp_path, "missing.vtu"))
    write_medit(mesh, tmp_path / "alone.mesh", tensors(mesh.points))
    (tmp_path / "alone.sol").unlink()
    with pytest.raises(BubblemeshError, match=r"alone\.mesh: has no data at its nodes: it has to be in a \.sol file"):
        prepare(case_with(tmp_path, "alone.mesh"))
    write_vtu(mesh, tmp_path / "two.vtu", m=tensors(mesh.points), other=tensors(mesh.points))
    with pytest.raises(BubblemeshError, match="choose one by name"):
        prepare(case_with(tmp_path, "two.vtu"))


def test_a_mesh_that_lies_beside_the_domain_is_told(tmp_path, mesh):
    aside = meshio.Mesh(
        np.column_stack([mesh.points + np.array([50, 0]), 0 * mesh.points[:, 0]]),
        [("triangle", mesh.triangles)],
        point_data={"m": tensors(mesh.points)},
    )
    meshio.write(tmp_path / "m.vtu", aside)
    with pytest.raises(
        BubblemeshError, match=r"metric: .*m\.vtu: its mesh, from \(.*\) to \(.*\), lies beside the domain"
    ):
        prepare(case_with(tmp_path, "m.vtu"))


def test_a_mesh_that_leaves_out_a_part_of_the_domain_is_told(tmp_path, mesh):
    # The square of side 3 without its middle ninth, of which the domain takes 2.9 by 2.9.
    write_vtu(mesh, tmp_path / "m.vtu", metric=tensors(mesh.points))
    told = f"m.vtu: its mesh leaves out about {1 / 2.9**2:.0%} of the domain: there the tensors at its nearest places"
    assert [text for text in prepare(case_with(tmp_path, "m.vtu")).warnings if told in text]
    whole = Mesh([[-10, -10], [20, -10], [-10, 20]], [[0, 1, 2]], [[0, 1], [1, 2], [2, 0]], [0, 0, 0], ["rim"])
    write_vtu(whole, tmp_path / "m.vtu", metric=tensors(whole.points))
    assert not [text for text in prepare(case_with(tmp_path, "m.vtu")).warnings if "leaves out" in text]


@pytest.mark.parametrize("sides", [["bottom"], ["bottom", "left"]])
def test_walls_that_end_at_others_are_as_straight_as_elsewhere(sides):
    """Edges are looked at that reach beyond the domain, where the nearest place of a wall is its end."""
    square = "domain: {outer: {rectangle: [0, 0, 1, 1], labels: [bottom, right, top, left]}}\nspacing: 0.1\n"
    metric = f"metric: {{like: boundary, label: {sides}, across: 0.001, growth: 0.2}}\n"
    found = prepare(load_case("a.yaml", text=square + metric)).packing_spacing
    ends = np.array([[x, 0.0] for x in (0.97, 0.99, 0.999, 1.0)])
    np.testing.assert_allclose(found.shares(ends), 1)


SQUARE = "domain: {outer: {rectangle: [0, 0, 1, 1], labels: [b, r, t, l]}}\nspacing: 0.1\n"


@pytest.mark.parametrize(("sides", "told"), [("[l, r]", True), ("[b, t]", False)])
def test_a_metric_that_differs_between_periodic_sides_is_told(sides, told):
    text = SQUARE.replace("}}", "}, periodic: [PAIR]}").replace("PAIR", sides)
    size = "(0.02 + 0.2*x)**-2"
    found = prepare(load_case("a.yaml", text=f"{text}metric: {{m11: {size}, m22: {size}}}\n")).warnings
    assert any("differ 5 times between periodic sides, at (0, " in warning for warning in found) == told


@pytest.mark.parametrize(
    "metric",
    [
        "angle: pi/2*x, across: 0.02",  # of the same area, in another direction
        'm11: "1/(0.02 + 0.08*x)**2", m22: "1/(0.1 - 0.08*x)**2"',
        "angle: 0, across: 0.02 + 0.08*x",  # of which the area differs by less
    ],
)
def test_a_metric_that_differs_in_one_direction_between_periodic_sides_is_told(metric):
    text = SQUARE.replace("}}", "}, periodic: [[l, r]]}")
    (told,) = prepare(load_case("a.yaml", text=f"{text}metric: {{{metric}}}\n")).warnings
    assert "its sizes in one direction differ 5 times between periodic sides" in told


@pytest.mark.parametrize(
    "metric", ["across: 0.01, angle: 1/(x-x)", "m11: 100/abs(x-0.5), m22: 100", "m11: 1/(x-0.5), m22: 100"]
)
def test_a_metric_that_is_no_number_is_told_without_more_ado(recwarn, metric):
    case = load_case("a.yaml", text=f"{SQUARE}metric: {{{metric}}}\n")
    with pytest.raises(BubblemeshError, match=r"metric\.(angle|m11): is (inf|nan|-?\d.*) at \("):
        prepare(case)
    assert not recwarn.list


@pytest.mark.parametrize(
    ("keys", "fault"),
    [
        ("metric: {like: boundary, label: wing, across: 0.01}", "metric.label: unknown label 'wing'"),
        ("metric: {m11: 1 - 2*x, m22: 1}", "metric.m11: is -1 at (1, 0)"),
        ("metric: [{m11: 1, m22: 1}, {file: none.vtu}]", "metric.1: none.vtu: "),
        ("layers: [{on: wing, first: 0.01, count: 2}]", "layers.0.on: there is no side or line 'wing'"),
    ],
)
def test_faults_that_the_domain_shows_are_told_with_their_line(tmp_path, monkeypatch, keys, fault):
    monkeypatch.chdir(tmp_path)
    told = refused(tmp_path, f"{SQUARE}{keys}\n", 5 if "file" in keys else 2)
    assert told.startswith(f"error: case.yaml:3: {fault}")


@pytest.mark.parametrize(
    ("inner", "label", "height"),
    [
        ("lines: [{path: [[0.2, 0.5], [0.8, 0.5]], label: crack}]", "crack", 0.5),
        ("regions: [{ring: {rectangle: [0.3, 0.3, 0.7, 0.7], label: rim}, name: core}]", "rim", 0.3),
    ],
)
def test_ellipses_lie_along_both_sides_of_lines_and_interfaces(inner, label, height):
    domain = f"domain: {{outer: {{rectangle: [0, 0, 1, 1]}}, {inner}}}\nspacing: 0.1\n"
    metric = f"metric: {{like: boundary, label: {label}, across: 0.01, growth: 0.5, along: 0.05}}\n"
    places = np.array([[0.5, height + 0.02 * k] for k in (-1, 0, 1)])
    found = prepare(load_case("a.yaml", text=domain + metric)).spacing.axes(places)
    np.testing.assert_allclose(found.across, [0.02, 0.01, 0.02])
    np.testing.assert_allclose(found.along, 0.05)
    np.testing.assert_allclose(np.abs(found.direction), [[1, 0]] * 3, atol=1e-12)
    with pytest.raises(BubblemeshError, match=r"metric\.label: is missing"):
        load_case("a.yaml", text=domain + metric.replace(f"label: {label}, ", ""))


@pytest.mark.parametrize(("across", "told"), [("0.5 + x", True), ("0.1", False), ("0.02 + x", False)])
def test_a_metric_that_is_nowhere_finer_than_the_spacing_is_told(across, told):
    """It may be in another unit than the domain."""
    warnings = prepare(load_case("a.yaml", text=f"{SQUARE}metric: {{angle: 0, across: {across}}}\n")).warnings
    start = "metric: its least size is 0.5 where the spacing is 0.1, at (0, "
    assert any(text.startswith(start) for text in warnings) == told
    assert any("without any effect" in text for text in warnings) == told
