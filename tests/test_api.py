"""The programming interface, and the page that shows it."""

import dataclasses
import math
import os
import pickle
import re
import subprocess
import sys
from types import SimpleNamespace

import meshio
import numpy as np
import pytest
import shapely
import skfem
from invariants import check_mesh
from paths import ROOT
from scipy.interpolate import RegularGridInterpolator
from skfem.io.meshio import from_meshio

import bubblemesh
from bubblemesh.errors import CaseError, FileError, GeometryError, LimitError
from bubblemesh.geometry import rings
from bubblemesh.geometry.arrangement.regions import InnerParts, Region
from bubblemesh.geometry.paths import Area
from bubblemesh.spacing.expression import Expression
from bubblemesh.spacing.terms.field import MeshField

PAGE = ROOT / "docs" / "api.md"
with np.errstate(invalid="ignore"):
    BROKEN = shapely.Polygon([(0, 0), (1, math.nan), (1, 1)])
PLATE = shapely.box(0, 0, 2, 1).difference(shapely.box(0.5, 0.25, 1, 0.75))
DISC = bubblemesh.Domain.of(rings.circle((0, 0), 1, "rim"), [rings.circle((0.3, 0), 0.3, "bore")])


@pytest.fixture(scope="module")
def disc():
    return bubblemesh.mesh(DISC, 0.2)


# The page


@pytest.mark.long
def test_the_blocks_of_the_page_run_one_after_the_other(tmp_path):
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(), flags=re.DOTALL)
    assert len(blocks) >= 8
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", "\n".join(blocks)], cwd=tmp_path, capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr
    assert run.stderr == ""
    assert "<Mesh: " in run.stdout
    assert "spacing: is -1 at (0, 0): it has to be positive" in run.stdout
    assert {path.name for path in tmp_path.iterdir()} == {
        *("disc.msh", "disc.report.json", "disc.nodes.npz", "disc.vtu", "disc.png", "square.yaml", "slanted.yaml"),
        *("disc.pvtu", "disc_0.vtu", "disc_1.vtu", "disc_2.vtu", "disc_3.vtu", "own.msh"),
    }


def test_all_public_names_are_there_and_loaded_when_used():
    for name in bubblemesh.__all__:
        assert getattr(bubblemesh, name) is not None
        assert name in dir(bubblemesh)
    with pytest.raises(AttributeError, match="nothing"):
        _ = bubblemesh.nothing
    code = "import bubblemesh; print(bubblemesh.errors.CaseError.exit_code, 'errors' in dir(bubblemesh))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout == "2 True\n"
    code = "import bubblemesh, sys; print(sorted({'numpy', 'shapely', 'pydantic'} & set(sys.modules)))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout == "[]\n"


def test_a_result_is_shown_in_a_line():
    text = "domain: {outer: {rectangle: [0, 0, 1, 1]}}\nspacing: 0.2\n"
    result = bubblemesh.mesh_case(bubblemesh.load_case("-", text=text))
    assert repr(result) == f"<Result: {result.mesh!r}, mean quality {result.report['quality']['mean']:.3f}>"


def test_the_interface_does_not_wait_for_libraries_that_few_calls_need():
    unused = {"scipy", "meshio", "rich", "numpy.ma", "bubblemesh.problem.metric", "bubblemesh.meshfiles.read"}
    code = f"import bubblemesh.api, sys; print(sorted({unused} & set(sys.modules)))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout == "[]\n"


# Geometry


def test_a_polygon_keeps_its_holes_vertices_and_labels():
    mesh = bubblemesh.mesh(PLATE, 0.2, labels=["outside", "window"])
    check_mesh(mesh)
    assert mesh.labels == ("outside", "window")
    corners = {tuple(point) for point in shapely.get_coordinates(PLATE).tolist()}
    assert corners <= {tuple(point) for point in mesh.points.tolist()}
    x, y = mesh.points[mesh.triangles].mean(axis=1).T
    assert not ((abs(x - 0.75) < 0.25) & (abs(y - 0.5) < 0.25)).any()


def test_labels_without_names_are_those_of_the_case_file():
    assert bubblemesh.mesh(PLATE, 0.3).labels == ("outer", "hole-1")


@pytest.mark.long
def test_a_polygon_may_turn_either_way_and_have_heights():
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    flat = bubblemesh.mesh(shapely.Polygon(square), 0.3)
    raised = bubblemesh.mesh(shapely.Polygon([(x, y, 7) for x, y in square]), 0.3)
    check_mesh(bubblemesh.mesh(shapely.Polygon(square[::-1]), 0.3))
    np.testing.assert_array_equal(flat.points, raised.points)


def test_a_domain_keeps_its_curves(disc):
    check_mesh(disc)
    rim, bore = (disc.points[disc.facets[disc.facet_labels == k, 0]] for k in (0, 1))
    np.testing.assert_allclose(np.hypot(*rim.T), 1, rtol=1e-14)
    np.testing.assert_allclose(np.hypot(*(bore - [0.3, 0]).T), 0.3, rtol=1e-14)


@pytest.mark.parametrize(
    ("geometry", "error", "text"),
    [
        (shapely.MultiPolygon([shapely.box(0, 0, 1, 1), shapely.box(1, 0, 3, 1)]), GeometryError, "share an edge"),
        (shapely.Polygon(), GeometryError, "empty"),
        (shapely.Polygon([(0, 0), (1, 1), (1, 0), (0, 1)]), GeometryError, r"\(0.5, 0.5\)"),
        (BROKEN, CaseError, "no number"),
        (shapely.MultiPolygon(), GeometryError, "empty"),
        (shapely.Point(0, 0), CaseError, "found Point"),
        ("plate", CaseError, r"geometry: must be a shapely.Polygon, .* or the points \(n, 2\) of a ring \(found str\)"),
        ([(0, 0, 0), (1, 0, 0), (0, 1, 0)], CaseError, r"found the shape \(3, 3\)"),
        ([(0, 0), (1, 0), (0,)], CaseError, "rows of unequal length"),
        (np.array([(0, 0), (1, 0), (0, 1)], object), CaseError, r"found an array of object: astype\(float\)"),
        ([(0, 0), (1, 0), (0, math.inf)], CaseError, "geometry: point 2 has a coordinate that is no number"),
        (
            np.ma.array([[0, 0], [4, 0], [9999, 3]], mask=[[0, 0], [0, 0], [1, 0]]),
            *(CaseError, "geometry: point 2 has a coordinate that is no number"),
        ),
    ],
)
def test_what_is_no_domain(geometry, error, text):
    with pytest.raises(error, match=text):
        bubblemesh.mesh(geometry, 0.1)


@pytest.mark.long
def test_a_collection_of_one_polygon_is_that_polygon():
    one, same = (bubblemesh.mesh(shape, 0.3) for shape in (PLATE, shapely.MultiPolygon([PLATE])))
    np.testing.assert_array_equal(one.points, same.points)


@pytest.mark.long
@pytest.mark.parametrize("method", ["multilevel", "accelerated", "bpm", "fnpbs"])
def test_several_polygons_are_pieces_of_one_mesh(method):
    island = shapely.box(0.6, 0.4, 0.9, 0.6)
    shape = shapely.MultiPolygon([PLATE, island, shapely.box(2.5, 0, 3, 1)])
    mesh = bubblemesh.mesh(shape, 0.15, method=method, labels=["plate", "island", "strip", "window"])
    check_mesh(mesh)
    assert mesh.labels == ("plate", "island", "strip", "window")
    edges = {tuple(sorted(pair)) for t in mesh.triangles.tolist() for pair in zip(t, t[1:] + t[:1], strict=True)}
    assert len(mesh.points) - len(edges) + len(mesh.triangles) == 3 - 1
    areas = np.linalg.det(np.diff(mesh.points[mesh.triangles], axis=1)) / 2
    assert areas.sum() == pytest.approx(shape.area, rel=1e-12)


SQUARE = np.array([(0, 0), (2, 0), (2, 1), (0, 1)])
TURN = np.linspace(0, 2 * np.pi, 64, endpoint=False)
CIRCLE = np.column_stack([0.5 + 0.2 * np.cos(TURN), 0.5 + 0.2 * np.sin(TURN)])


def test_rings_may_be_arrays():
    window = [(0.5, 0.25), (1, 0.25), (1, 0.75), (0.5, 0.75)]
    by_arrays = bubblemesh.mesh(SQUARE, 0.3, holes=[window])
    check_mesh(by_arrays)
    assert by_arrays.labels == ("outer", "hole-1")
    by_polygon = bubblemesh.mesh(shapely.Polygon(SQUARE, [window]), 0.3)
    np.testing.assert_array_equal(by_arrays.points, by_polygon.points)


@pytest.mark.parametrize(
    ("holes", "error", "text"),
    [
        (
            [[(0.2, 0.2), (0.4, 0.4), (0.4, 0.2), (0.2, 0.4)]],
            GeometryError,
            r"^mesh\(\): holes\[0\]: .* itself at \(0.3, 0.3",
        ),
        ([CIRCLE, CIRCLE + np.array([9, 0])], GeometryError, r"^mesh\(\): holes\[1\]: hole 2 at .* lies outside"),
        ([CIRCLE, CIRCLE[:2]], GeometryError, r"^mesh\(\): holes\[1\]: .* fewer than three"),
        ([CIRCLE, [(0, 0, 0)]], CaseError, r"^mesh\(\): holes\[1\]: must be the points \(n, 2\) of a ring"),
        (3, CaseError, r"^mesh\(\): holes: must be a list of rings.* \(found int\)"),
    ],
)
def test_an_error_names_the_ring_as_it_was_given(holes, error, text):
    with pytest.raises(error, match=text):
        bubblemesh.mesh(SQUARE, 0.3, holes=holes)


def test_an_error_names_the_ring_of_a_polygon():
    crossed = shapely.Polygon([(0, 0), (2, 0), (2, 1), (0, 1)], [[(0.2, 0.2), (0.4, 0.4), (0.4, 0.2), (0.2, 0.4)]])
    with pytest.raises(GeometryError, match=r"^mesh\(\): geometry\.interiors\[0\]: hole 1 crosses or touches itself"):
        bubblemesh.mesh(crossed, 0.3)
    with pytest.raises(GeometryError, match=r"^mesh\(\): geometry\.geoms\[1\]\.interiors\[0\]: "):
        bubblemesh.mesh(shapely.MultiPolygon([shapely.box(5, 5, 6, 6), crossed]), 0.3)
    with pytest.raises(CaseError, match=r"holes: a shapely\.Polygon has holes of its own"):
        bubblemesh.mesh(PLATE, 0.3, holes=[CIRCLE])
    with pytest.raises(CaseError, match="corners: a Domain has corners of its own"):
        bubblemesh.mesh(DISC, 0.3, corners=30)


@pytest.mark.long
def test_vertices_that_take_many_nodes_warn_and_corners_makes_a_curve_of_them():
    with pytest.warns(bubblemesh.MeshWarning, match=r"1\.7\d times .* 64 boundary edges .*corners=30") as told:
        forced = bubblemesh.mesh(SQUARE, 0.1, holes=[CIRCLE])
    assert told[0].filename == __file__
    smooth = bubblemesh.mesh(SQUARE, 0.1, holes=[CIRCLE], corners=30, smooth=True)
    check_mesh(smooth)
    assert len(forced.points) > 1.6 * len(smooth.points)
    bore = smooth.points[smooth.facets[smooth.facet_labels == 1, 0]]
    np.testing.assert_allclose(np.hypot(*(bore - 0.5).T), 0.2, rtol=1e-5)
    corners = {tuple(point) for point in SQUARE.tolist()}
    assert corners <= {tuple(point) for point in smooth.points.tolist()}


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"smooth": True}, "smooth: needs corners"),
        ({"tolerance": 0.1}, "tolerance: needs corners"),
        ({"corners": 200}, "corners: must be an angle from 0 to 180"),
        ({"corners": "x"}, "corners: must be an angle"),
        ({"corners": 30, "tolerance": 0}, "tolerance: must be a length greater than 0"),
        ({"effort": "fats"}, r"^mesh\(\): effort: input should be 'fast', 'normal' or 'best'"),
        ({"effort": "best", "method": "bpm"}, r"^mesh\(\): effort: the method 'bpm' does not use this key"),
        ({"seed": 1.5}, r"^mesh\(\): seed: "),
        ({"method": 3}, r"^mesh\(\): method: must be the name of one \(found 3\)"),
        ({"method": ["bpm"]}, r"^mesh\(\): method: must be the name of one"),
        ({"labels": {"a"}}, r"^mesh\(\): labels: must be a list of names"),
        ({"seed": 1, "packing": {"seed": 2}}, r"^mesh\(\): seed: is given twice"),
        ({"packing": 3}, r"packing: must be a mapping such as \{'seed': 3\} \(found int\)"),
        ({"schedule": 4}, r"^mesh\(\): schedule: must be a mapping such as \{'rounds': 3\} \(found int\)"),
        ({"packing": {1: 1}}, r"packing: must have names as its keys \(found 1\)"),
        ({"schedule": {None: 1}}, r"schedule: must have names as its keys \(found None\)"),
        ({"layers": 3}, r"^mesh\(\): layers: "),
        ({"layers": np.ones(2)}, r"^mesh\(\): layers\.0: "),
        ({"metric": np.ones(2)}, r"^mesh\(\): metric\.0: "),
        ({"metric": {}}, r"^mesh\(\): metric: must be a mapping with exactly one of the keys"),
        ({"metric": []}, r"^mesh\(\): metric: must have at least one entry"),
        ({"metric": {"m11": 9, "m22": 9}, "method": "multilevel"}, r"^mesh\(\): method: multilevel packs no metric"),
        ({"max_nodes": 0}, "max_nodes: must be a whole number greater than 0"),
        ({"angle_min": "x"}, "angle_min: must be from 0 to 30"),
        ({"largest": "x"}, "largest: must be an area"),
        ({"largest": math.inf}, "largest: must be an area"),
        ({"corners": 30, "smooth": "yes"}, "smooth: must be true or false"),
        ({"progress": 3}, "progress: must be a function"),
    ],
)
def test_an_argument_that_is_none(arguments, text):
    with pytest.raises(CaseError, match=text):
        bubblemesh.mesh(PLATE, 0.3, **arguments)


def test_a_number_of_nodes_is_given_once():
    with pytest.raises(CaseError, match=r"^mesh\(\): nodes: is given twice, also as spacing\['nodes'\]: drop one"):
        bubblemesh.mesh(PLATE, {"value": 0.3, "nodes": 60}, nodes=50)


def test_numbers_and_arrays_may_be_those_of_numpy():
    def made(number, array, real):
        return bubblemesh.mesh(
            PLATE,
            {"value": real(0.3), "near": {"point": array([0.5, 0.5]), "size": real(0.1), "growth": real(0.25)}},
            layers=[{"on": "outer", "first": real(0.01), "count": number(4)}],
            seed=number(3),
            packing={"effort": "fast"},
            max_nodes=number(10_000),
        )

    plain, numpys = made(int, list, float), made(np.int64, np.array, np.float64)
    assert plain.points.tobytes() == numpys.points.tobytes()
    assert plain.triangles.tobytes() == numpys.triangles.tobytes()


def test_an_error_of_a_picture_travels_between_processes(disc):
    with pytest.raises(CaseError) as told:
        disc.plot(color="zz")
    again = pickle.loads(pickle.dumps(told.value))
    assert (type(again), str(again), again.option) == (type(told.value), str(told.value), "color")


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"limits": "x"}, "limits: give two numbers"),
        ({"limits": 3}, "limits: give two numbers"),
        ({"limits": (0, "1")}, "limits: give two numbers"),
        ({"limits": (1, 0)}, "limits: give two numbers"),
        ({"view": (0, 0, 1)}, "view: give numbers x0 y0 x1 y1"),
        ({"view": (0, 1, 1, 1)}, "view: give numbers x0 y0 x1 y1"),
        ({"width": "x"}, "width: is 'x': it has to be between"),
        ({"dpi": 1}, "dpi: is 1: it has to be between"),
    ],
)
def test_options_of_pictures_have_to_be_numbers(options, told, disc):
    with pytest.raises(CaseError, match=told):
        disc.plot(**options)


def test_the_warning_of_short_edges_names_the_argument():
    with pytest.warns(bubblemesh.MeshWarning, match=r"\(corners=30 takes short edges for curves\)$"):
        bubblemesh.mesh(shapely.Point(0, 0).buffer(1), 0.3, effort="fast")


def test_a_mesh_without_triangles_has_no_quality_and_no_picture(tmp_path):
    empty = bubblemesh.Mesh([], [], [], [], [])
    for take in (empty.quality, empty.plot, lambda: empty.plot(tmp_path / "a.png")):
        with pytest.raises(CaseError, match=r"^triangles: the mesh has none"):
            take()
    assert "<img" not in empty._repr_html_()


def test_limits_of_a_picture_may_be_an_array(disc):
    assert disc.plot(limits=np.array([0.5, 1.0]), view=[-1, -1, 1, 1]).axes


@pytest.mark.parametrize("count", [True, 2.0, "2"])
def test_a_number_of_parts_is_a_whole_one(count, disc):
    with pytest.raises(CaseError, match=r"the number of parts must be a whole one"):
        disc.partitioned(count)


def test_what_is_no_solution_is_told():
    with pytest.raises(CaseError, match=r"solution: must be a Solution.*found NoneType"):
        bubblemesh.adapt(bubblemesh.load_case(ROOT / "configs/quickstart.yaml"), None)


def test_the_limit_on_nodes_has_the_name_of_the_argument():
    with pytest.raises(LimitError, match=r"^mesh\(\): max_nodes: the spacing needs about .* limit of 1000"):
        bubblemesh.mesh(PLATE, 0.001, max_nodes=1000)


def test_seed_and_effort_are_those_of_packing_and_progress_goes_up_to_one():
    shares = []
    short = bubblemesh.mesh(PLATE, 0.3, seed=3, effort="fast", progress=shares.append)
    long = bubblemesh.mesh(PLATE, 0.3, packing={"seed": 3, "effort": "fast"})
    np.testing.assert_array_equal(short.points, long.points)
    assert not np.array_equal(short.points, bubblemesh.mesh(PLATE, 0.3).points)
    assert shares == sorted(shares)
    assert (shares[-1], len(shares) <= 101) == (1, True)


def test_a_mapping_gives_names_in_place_of_the_usual_ones():
    assert bubblemesh.mesh(PLATE, 0.3, labels={"hole-1": "bore"}).labels == ("outer", "bore")
    with pytest.raises(CaseError, match=r"labels: there is no ring 'hole': did you mean 'hole-1'\?"):
        bubblemesh.mesh(PLATE, 0.3, labels={"hole": "bore"})
    with pytest.raises(CaseError, match=r"labels: 3 is no name"):
        bubblemesh.mesh(PLATE, 0.3, labels={"hole-1": 3})


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: rings.circle((0, 0), -1), r"circle: radius: must be a number greater than 0 \(found -1\)"),
        (lambda: rings.circle((0, 0), math.nan), "circle: radius"),
        (lambda: rings.circle((0, math.inf), 1), "circle: center"),
        (lambda: rings.circle(0, 1), r"circle: center: must be two numbers \(found 0\)"),
        (lambda: rings.ellipse((0, 0), (1, 0)), "ellipse: radii: must be a number greater than 0"),
        (lambda: rings.ellipse((0, 0), (1, 1), "x"), "ellipse: angle"),
        (lambda: rings.polygon([(0, 0), (1, 0), (math.nan, 1)]), "ring: point 2 has a coordinate that is no number"),
        (lambda: rings.path((0, 0), [rings.ArcTo((2, 0), (math.nan, 0), True)]), "center of an arc: point 0"),
        (lambda: rings.path((0, 0), [rings.SplineTo([(1, math.inf), (2, 0)])]), "spline: point 1"),
        (lambda: rings.rectangle(0, 0, 1, 1, labels=["a", "b"]), "labels: must be one per side: 2 labels for 4 sides"),
        (lambda: rings.polygon([(0, 0), (1, 0), (0, 1)], labels=list("abcd")), "4 labels for 3 sides"),
        (lambda: bubblemesh.Domain.of(rings.circle((0, 0), 1), rings.circle((0, 0), 0.3)), "holes: must be a list"),
        (lambda: bubblemesh.Domain.of(rings.circle((0, 0), 1, label=3)), "Domain.of: label: 3 is no name"),
        (lambda: bubblemesh.Domain.of(rings.circle((0, 0), 1, label='a"b')), "Domain.of: label: .* is no name"),
    ],
)
def test_what_is_no_ring_or_no_name_is_refused_before_the_work(make, text):
    with pytest.raises(CaseError, match=text):
        make()


@pytest.mark.parametrize("labels", ["ab", ["a", 1], ["a", 'b"'], ["a", ""], ["a", "b" * 128]])
def test_labels_have_to_be_names(labels):
    with pytest.raises(CaseError, match=r"labels: .*(is no name|must be a list)"):
        bubblemesh.mesh(PLATE, 0.3, labels=labels)


def test_labels_have_to_fit():
    with pytest.raises(CaseError, match="1 label for 2 rings"):
        bubblemesh.mesh(PLATE, 0.3, labels=["a"])
    with pytest.raises(CaseError, match=r"2 labels for 1 ring$"):
        bubblemesh.mesh(shapely.box(0, 0, 1, 1), 0.3, labels=["a", "b"])
    with pytest.raises(CaseError, match="labels of its own"):
        bubblemesh.mesh(DISC, 0.3, labels=["a", "b"])


# Spacing


@pytest.mark.long
@pytest.mark.parametrize(
    "spacing",
    [
        "0.2",
        np.float64(0.2),
        np.array(0.2),
        np.vectorize(lambda x, y: 0.2 if x < 9 else 0.1),
        lambda x, y: 0.2,
        lambda x, y: 0.2 + 0 * x,
        lambda x, y: np.full(x.shape, 0.2),
    ],
)
def test_all_forms_of_a_constant_give_the_same_mesh(spacing, disc):
    mesh = bubblemesh.mesh(DISC, spacing)
    np.testing.assert_array_equal(mesh.points, disc.points)
    np.testing.assert_array_equal(mesh.triangles, disc.triangles)


def test_an_expression_and_the_same_function_give_the_same_mesh():
    by_text = bubblemesh.mesh(PLATE, "0.05 + 0.1*x")
    by_function = bubblemesh.mesh(PLATE, lambda x, y: 0.05 + 0.1 * x)
    np.testing.assert_array_equal(by_text.points, by_function.points)
    lengths = np.hypot(*(by_text.points[by_text.triangles[:, 1]] - by_text.points[by_text.triangles[:, 0]]).T)
    x = by_text.points[by_text.triangles[:, :2], 0].mean(axis=1)
    assert np.corrcoef(lengths, x)[0, 1] > 0.8


@pytest.mark.long
@pytest.mark.parametrize(
    "spacing", ["0.1 + 0.2*distance('bore')", {"near": {"label": "bore", "size": 0.1}}, {"labels": {"bore": 0.1}}]
)
def test_a_spacing_may_grow_with_the_distance_from_a_label(spacing):
    mesh = bubblemesh.mesh(DISC, spacing)
    check_mesh(mesh)
    ends = mesh.points[mesh.triangles[:, :2]]
    middle, lengths = ends.mean(axis=1), np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    target = 0.1 + 0.2 * np.abs(np.hypot(middle[:, 0] - 0.3, middle[:, 1]) - 0.3)
    assert (lengths / target).mean() == pytest.approx(1, abs=0.03)
    assert (lengths / target).std() < 0.1


@pytest.mark.parametrize(
    ("spacing", "text"),
    [
        ("distance('bor')", "spacing: column 1: unknown label 'bor'; known: outer, hole-1, at"),
        ({"labels": {"bor": 1}}, "spacing.labels.bor: unknown label 'bor'"),
        ({"value": "distance('bor')"}, "spacing.value: column 1: unknown label 'bor'"),
        ({"value": 1, "regions": {"rest": 1}}, "spacing.regions.rest: unknown region 'rest'; known: domain"),
        (0, "is 0 at"),
        (-1.0, "is -1 at"),
        (math.nan, "nan"),
        (lambda x, y: x - 1, r"is -1 at \(0, 0\)"),
        (lambda x, y: np.ma.array(np.full(len(x), 0.1), mask=x > 0.9), r"nan at \(2, 0\)"),
        (lambda x, y: 0.1 + 0j * x, "complex128"),
        (lambda x, y: [0.1, 0.2], r"shape \(2,\)"),
        (lambda x, y: np.full((len(x), 1), 0.1), "shape"),
        (lambda x, y: math.sqrt(x) + 1, "NumPy's functions"),
        (
            lambda x, y: 0.1 if x < 1 else 0.2,
            r"fails for arrays of coordinates \(The truth value .* np\.where in place of if",
        ),
        (lambda point: 0.1, "spacing: the function has to take x and y, two arrays .too many positional arguments"),
        (lambda x, y: 0.1 / math.sqrt(x[0]), r"the function fails at \(0, 0\) \(ZeroDivisionError: "),
        (math.inf, "is inf: it has to be positive and finite"),
        (np.array([0.1, 0.2]), "must be a number"),
        (lambda x, y: None, "type object"),
        ("0.1 + z", "spacing: column 7: unknown name 'z'"),
        (None, "must be a number"),
        (True, "must be a number"),
    ],
)
def test_a_spacing_that_is_none(spacing, text):
    with pytest.raises(CaseError, match=text):
        bubblemesh.mesh(PLATE, spacing)


def test_an_error_of_the_function_itself_is_the_cause():
    def broken(x, y):
        raise RuntimeError("no data")

    with pytest.raises(CaseError, match=r"the function fails at \(.*\) \(RuntimeError: no data\): ") as told:
        bubblemesh.mesh(PLATE, broken)
    assert isinstance(told.value.__cause__, RuntimeError)


def test_a_function_that_has_no_value_around_the_domain_is_told_where():
    table = RegularGridInterpolator((np.linspace(0, 2, 5), np.linspace(0, 1, 5)), np.full((5, 5), 0.3))
    with pytest.raises(
        CaseError, match=r"fails at \(-.e-09, .* out of bounds .* outside of the domain, where .* NaN will"
    ):
        bubblemesh.mesh(PLATE, lambda x, y: table((x, y)))
    table.bounds_error = False  # then it gives NaN there
    assert len(bubblemesh.mesh(PLATE, lambda x, y: table((x, y))).points) > 20


def test_an_error_of_the_package_within_a_function_names_the_argument():
    def broken(x, y):
        return bubblemesh.Mesh.read("no.msh")

    for spacing, argument in ((broken, "spacing"), ({"function": broken}, "spacing.function")):
        with pytest.raises(FileError, match=re.escape(f"mesh(): {argument}: no.msh: ")):
            bubblemesh.mesh(PLATE, spacing)


def test_functions_are_terms_beside_others():
    field = MeshField.of([[0, 0], [2, 0], [2, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]], [0.1, 0.4, 0.4, 0.1])
    alone = bubblemesh.mesh(PLATE, lambda x, y: 0.1 + 0.15 * x)
    for function, away in ((lambda x, y: 0.1 + 0.15 * x, 0), (field, 1e-3)):  # one is rounded and continued otherwise
        same = bubblemesh.mesh(PLATE, {"function": function})
        np.testing.assert_allclose(same.points, alone.points, rtol=0, atol=away)
    same = bubblemesh.mesh(PLATE, {"value": Expression.parse("0.1 + 0.15*x")})  # is no function of a program
    np.testing.assert_allclose(same.points, alone.points, rtol=0, atol=1e-3)
    held = bubblemesh.mesh(PLATE, {"function": [field, lambda x, y: 1 + x], "maximum": 0.2, "growth": 0.05})
    x = held.points[held.triangles].mean(axis=1)[:, 0]
    assert held.fields["target_spacing"].max() < 0.2
    np.testing.assert_allclose(held.fields["target_spacing"], 0.1 + 0.05 * x, rtol=0.1)  # around the hole it is farther


@pytest.mark.parametrize(
    ("spacing", "text"),
    [
        ({"function": 3}, r"spacing.function: must be a function of arrays x and y \(found 3\)"),
        ({"function": [max, "x"]}, "spacing.function.1: must be a function of arrays x and y"),
        ({"value": math.hypot}, "spacing.value: is a function, or data like one: give it as 'function'"),
        ({"function": lambda x, y: x - 1}, r"spacing.function: is -1 at \(0, "),
        ({"function": [np.hypot, lambda x, y: "a"]}, "spacing.function.1: the function gives values of type <U1"),
    ],
)
def test_functions_among_terms_that_are_none(spacing, text):
    with pytest.raises(CaseError, match=text):
        bubblemesh.mesh(PLATE, spacing)


# Options


def test_options_are_those_of_a_case_file():
    assert len(bubblemesh.mesh(PLATE, 0.2, method="accelerated").points) > 20
    with pytest.raises(CaseError, match=r"packing\.sed"):
        bubblemesh.mesh(PLATE, 0.2, packing={"sed": 1})
    with pytest.raises(CaseError, match="method"):
        bubblemesh.mesh(PLATE, 0.2, method="magic")
    with pytest.raises(LimitError):
        bubblemesh.mesh(PLATE, 0.001, max_nodes=1000)


def test_a_case_gives_the_same_mesh_as_the_function(tmp_path, disc):
    (tmp_path / "disc.yaml").write_text(
        """
domain:
  outer: {circle: {center: [0, 0], radius: 1}, label: rim}
  holes: [{circle: {center: [0.3, 0], radius: 0.3}, label: bore}]
spacing: 0.2
"""
    )
    rounds = []
    result = bubblemesh.mesh_case(bubblemesh.load_case(tmp_path / "disc.yaml"), rounds.append)
    assert isinstance(result, bubblemesh.Result)
    assert isinstance(result.mesh, bubblemesh.Mesh)
    assert len(rounds) == len(result.report["rounds"])
    np.testing.assert_array_equal(result.mesh.points, disc.points)
    assert result.report["case"] == "disc"


def test_a_case_is_loaded_first():
    with pytest.raises(CaseError, match=r"found str\): load_case reads one"):
        bubblemesh.mesh_case("disc.yaml")


SOLUTION = bubblemesh.Solution.of([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]], [0, 1, 2])
FLAT = bubblemesh.Mesh([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]], [[0, 1], [1, 2], [2, 0]], [0, 0, 0], ["rim"])


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: bubblemesh.adapt(None, SOLUTION), r"case: must be a Case \(found NoneType\): load_case"),
        (lambda: bubblemesh.load_case("-", text=b"domain: 1"), r"text: must be a text \(found bytes\)"),
        (lambda: bubblemesh.load_case("-", text="", overrides={"spacing": 0.1}), r"overrides: .* list of .*found dict"),
        (lambda: bubblemesh.load_case("-", text="", overrides=3), r"overrides: must be a list of texts.*found int"),
        (lambda: bubblemesh.load_case("-", text="", overrides=[3]), r"overrides: must be texts, .*found 3"),
        (
            lambda: bubblemesh.load_case("-", text="", overrides=["a"]),
            r"^overrides: a: no '=' .*: write 'key.key=value'",
        ),
        (lambda: bubblemesh.load_case({"spacing": 1}), r"^path: must be a text or a Path \(found dict\)"),
        (lambda: bubblemesh.Mesh.read(None), r"^path: must be a text or a Path \(found NoneType\)"),
        (lambda: FLAT.write(b"x.msh"), r"^path: must be a text or a Path \(found bytes\)"),
        (lambda: FLAT.plot(3), r"^path: must be a text or a Path \(found int\)"),
        (lambda: FLAT.plot(ax=3), r"^ax: must be axes of a matplotlib figure \(found int\)"),
        (lambda: bubblemesh.Domain.of(PLATE), r"Domain.of: takes rings.*found Polygon"),
        (lambda: bubblemesh.Domain.of(rings.circle((0, 0), 1), [PLATE]), r"Domain.of: takes rings.*found Polygon"),
    ],
)
def test_arguments_of_another_kind_are_refused(call, text):
    with pytest.raises(CaseError, match=text):
        call()


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("kind", ["f2", "f4", "i4"])
def test_points_may_be_of_any_kind_of_number(kind):
    ring = np.array([(0, 0), (1, 0), (1, 1)], kind)
    np.testing.assert_array_equal(bubblemesh.mesh(ring, 0.3).points, bubblemesh.mesh(ring.tolist(), 0.3).points)


# What a mesh does


def test_meshes_are_the_same_only_as_objects(disc):
    other = dataclasses.replace(disc)
    assert disc != other
    assert len({disc, other, disc}) == 2


def test_repr_is_short(disc):
    assert repr(disc) == f"<Mesh: {len(disc.points)} nodes, {len(disc.triangles)} triangles, labels rim, bore>"


def test_quality(disc):
    quality = disc.quality()
    assert 0.9 < quality.mean <= 1
    assert disc.second_order()[0].quality() == quality


def test_to_meshio_has_cell_sets_that_scikit_fem_knows(disc):
    data = disc.to_meshio()
    np.testing.assert_array_equal(data.points, disc.points)
    for k, name in enumerate(disc.labels):
        np.testing.assert_array_equal(data.cell_sets_dict[name]["line"], np.flatnonzero(disc.facet_labels == k))
    np.testing.assert_array_equal(data.cell_sets_dict["domain"]["triangle"], np.arange(len(disc.triangles)))
    read = from_meshio(data)
    assert set(read.boundaries) == {"rim", "bore"}
    for name in read.boundaries:
        assert set(read.boundaries[name]) <= set(read.boundary_facets())


@pytest.mark.parametrize("name", ["disc.msh", "disc.vtu", "disc.inp", "disc.mesh"])
def test_write(disc, tmp_path, name):
    assert disc.write(tmp_path / name) == [name]
    assert [path.name for path in tmp_path.iterdir()] == [name]
    files = disc.write(tmp_path / name, sidecars=True)
    assert files[0] == name
    assert "disc.report.json" in files
    assert sorted(files) == sorted(path.name for path in tmp_path.iterdir())
    read = meshio.read(tmp_path / name, file_format="gmsh" if name.endswith("msh") else None)
    # A number of an input file has 20 characters at most.
    np.testing.assert_allclose(read.points[:, :2], disc.points, rtol=1e-13 if name == "disc.inp" else 0)


@pytest.mark.parametrize("name", ["disc.msh", "disc.su2", "disc.mesh", "disc.vtu"])
def test_a_mesh_is_read_again(disc, tmp_path, name):
    disc.write(tmp_path / name, sidecars=True)
    read = bubblemesh.Mesh.read(tmp_path / name)
    check_mesh(read)
    np.testing.assert_array_equal(read.points, disc.points)
    np.testing.assert_array_equal(read.triangles, disc.triangles)
    assert read.labels == (("boundary",) if name == "disc.vtu" else disc.labels)
    assert read.regions == ("domain",)
    assert len(read.facets) == len(disc.facets)


def test_what_a_file_has_and_a_mesh_has_not_is_told(disc, tmp_path):
    square = [("triangle", [(0, 2, 1)]), ("tetra", [(1, 2, 3, 4)])]
    points = [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0)]
    meshio.Mesh(np.pad(points, ((0, 0), (0, 1))), square).write(tmp_path / "a.vtk")
    with pytest.warns(
        bubblemesh.MeshWarning, match=r"a\.vtk: cells that are no triangles or quadrilaterals are left out: tetra"
    ):
        read = bubblemesh.Mesh.read(tmp_path / "a.vtk")
    assert read.triangles.tolist() == [[1, 2, 0]]  # counter-clockwise
    disc.second_order()[0].write(tmp_path / "b.vtu")
    with pytest.warns(bubblemesh.MeshWarning, match="cells of higher order: their corners are read"):
        assert bubblemesh.Mesh.read(tmp_path / "b.vtu").order == 1
    with pytest.raises(FileError, match=r"missing\.msh"):
        bubblemesh.Mesh.read(tmp_path / "missing.msh")


# Other libraries


@pytest.mark.parametrize("order", [1, 2])
def test_scikit_fem_gets_all_labels_and_regions(order):
    half = rings.polygon([(0, 0), (0.5, 0), (0.5, 1), (0, 1)])
    parts = InnerParts(regions=(Region(Area(half), "west", "wall"),))
    domain = bubblemesh.Domain.of(rings.rectangle(0, 0, 1, 1, label="rim"), parts=parts)
    mesh = bubblemesh.mesh(domain, 0.2)
    found = (mesh if order == 1 else mesh.second_order()[0]).to_skfem()
    assert isinstance(found, skfem.MeshTri1 if order == 1 else skfem.MeshTri2)
    assert {name: len(facets) for name, facets in found.boundaries.items()} == {
        name: int((mesh.facet_labels == k).sum()) for k, name in enumerate(mesh.labels)
    }
    assert set(found.boundaries["rim"]) == set(found.boundary_facets())
    for name, cells in found.subdomains.items():
        area = skfem.Functional(lambda w: 1 + 0 * w.x[0]).assemble(
            skfem.Basis(found, skfem.ElementTriP1(), elements=cells)
        )
        assert area == pytest.approx(0.5), name


@pytest.mark.parametrize(
    ("name", "command"),
    [
        ("pyvista", "pip install pyvista"),
        ("skfem", "pip install scikit-fem"),
        ("dolfinx", "conda install -c conda-forge"),
    ],
)
def test_a_missing_library_is_named_with_what_installs_it(disc, name, command, monkeypatch):
    monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(FileError, match=f"{name} is needed and not installed: {command}"):
        getattr(disc, f"to_{name}")()


@pytest.mark.parametrize("order", [1, 2])
def test_pyvista_gets_triangles_then_edges(disc, order, monkeypatch):
    grids = []

    class Grid:
        def __init__(self, *arrays):
            grids.append(arrays)
            self.cell_data, self.field_data = {}, {}

    monkeypatch.setitem(sys.modules, "pyvista", SimpleNamespace(UnstructuredGrid=Grid))
    mesh = disc if order == 1 else disc.second_order()[0]
    grid = mesh.to_pyvista()
    ((cells, kinds, points),) = grids
    t, f = len(mesh.triangles), len(mesh.facets)
    assert points.shape == (len(mesh.points), 3)
    assert kinds.tolist() == [5 if order == 1 else 22] * t + [3 if order == 1 else 21] * f
    width = mesh.triangles.shape[1]
    np.testing.assert_array_equal(cells[: (width + 1) * t].reshape(t, -1)[:, 1:], mesh.triangles)
    assert set(cells[: (width + 1) * t].reshape(t, -1)[:, 0]) == {width}
    assert grid.field_data["groups"] == ["rim", "bore", "domain"]
    assert grid.cell_data["group"].tolist() == [3] * t + (1 + mesh.facet_labels).tolist()
    assert np.isnan(grid.cell_data["quality"]).sum() == f


def test_points_have_three_columns_where_they_are_wanted(disc, tmp_path):
    data = disc.to_meshio(columns=3)
    assert data.points.shape == (len(disc.points), 3)
    data.write(tmp_path / "a.vtu")  # without a warning of meshio
    with pytest.raises(CaseError, match="columns: must be 2 or 3"):
        disc.to_meshio(columns=4)


@pytest.mark.long
def test_mypy_finds_the_types_of_the_package(tmp_path):
    (tmp_path / "good.py").write_text(
        "import numpy as np\nimport bubblemesh\n"
        "mesh = bubblemesh.mesh(np.zeros((3, 2)), 0.1, labels={'outer': 'rim'}, corners=30, seed=2)\n"
        "count: int = len(mesh.points)\nlabel: str = mesh.labels[0]\n"
        "other: bubblemesh.Mesh = bubblemesh.Mesh.read('a.msh')\n"
    )
    (tmp_path / "bad.py").write_text("import bubblemesh\nnumber: int = bubblemesh.Mesh.read('a.msh')\n")
    run = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "good.py", "bad.py"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
    )
    assert run.stdout.splitlines()[0].startswith("bad.py:2: error: Incompatible types in assignment"), run.stdout
    assert "Found 1 error in 1 file" in run.stdout


def test_write_an_unknown_format(disc, tmp_path):
    with pytest.raises(CaseError, match="unknown ending"):
        disc.write(tmp_path / "disc.stl")
    with pytest.raises(CaseError, match="order 2"):
        disc.second_order()[0].write(tmp_path / "disc.su2")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("order", [1, 2])
def test_plot(disc, tmp_path, order):
    mesh = disc if order == 1 else disc.second_order()[0]
    figure = mesh.plot(tmp_path / "disc.png", color="none", title="disc")
    assert (tmp_path / "disc.png").read_bytes().startswith(b"\x89PNG")
    assert len(figure.axes) == 1
    assert mesh.plot().axes[0].get_title() == ""
    with pytest.raises(CaseError, match="unknown quantity 'red'; known: quality, size, spacing"):
        mesh.plot(color="red")


def colours(figure):
    return figure.axes[0].collections[0].get_array()


@pytest.mark.parametrize("order", [1, 2])
def test_plot_takes_data_of_triangles_and_of_nodes(disc, order):
    mesh = disc if order == 1 else disc.second_order()[0]
    x = mesh.points[:, 0]
    of_nodes = colours(mesh.plot(color="u", fields={"u": x}))
    of_triangles = colours(mesh.plot(color="u", fields={"u": x[mesh.triangles[:, :3]].mean(axis=1).tolist()}))
    np.testing.assert_allclose(of_nodes, of_triangles)
    figure = mesh.plot(color="u", fields={"u": x}, limits=np.array([0, 1.0]), view=np.array([0, 0, 1, 1]))
    assert figure.axes[0].collections[0].get_clim() == (0, 1)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"foo": 1}, "plot: there is no option 'foo': allowed: color"),
        ({"colour": "size"}, "plot: there is no option 'colour': did you mean 'color'"),
        ({"fields": {"u": list}}, r"fields: u: must be an array of numbers \(found <class 'list'>\)"),
        ({"fields": {"u": 3}}, "fields: u: must be an array of numbers"),
        (
            {"fields": {"u": [1, 2]}},
            r"fields: u: must have values of the \d+ triangles or of the \d+ nodes \(found 2\)",
        ),
        ({"fields": [1]}, r"fields: must be a mapping of names to arrays \(found list\)"),
    ],
)
def test_plot_refuses_what_it_cannot_show(disc, tmp_path, options, text):
    with pytest.raises(CaseError, match=text):
        disc.plot(tmp_path / "a.png", **options)
    assert list(tmp_path.iterdir()) == []


# Second order on true curves


def area(mesh):
    """Area of second-order triangles, by the exact integral of the Jacobian of their map."""
    read = skfem.MeshTri2(mesh.points.T, mesh.triangles.T)
    basis = skfem.Basis(read, skfem.ElementTriP1(), intorder=4)
    return skfem.Functional(lambda w: 1 + 0 * w.x[0]).assemble(basis)


@pytest.mark.long
def test_edge_nodes_lie_on_the_curves_and_the_area_converges_with_fourth_order():
    exact, errors, sizes = math.pi * (1 - 0.3**2), [], [0.3, 0.15, 0.075]
    for size in sizes:
        mesh = bubblemesh.mesh(DISC, size)
        curved, straight = mesh.second_order()
        assert straight == 0
        for k, (center, radius) in enumerate((((0, 0), 1), ((0.3, 0), 0.3))):
            middle = curved.points[curved.facets[curved.facet_labels == k, 2]]
            np.testing.assert_allclose(np.hypot(*(middle - center).T), radius, rtol=1e-13)
        errors.append(abs(area(curved) / exact - 1))
    order = np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert 3.5 < order < 4.6
    assert errors[-1] < 1e-5


@pytest.mark.long
def test_edge_nodes_are_halfway_along_every_kind_of_piece():
    half = rings.path(
        (1, 0),
        [
            rings.ArcTo((-1, 0), (0, 0), True, "arc"),
            rings.SplineTo([(-0.5, -0.4), (0.2, -0.1), (0.6, -0.5), (1, 0)], "spline"),
        ],
    )
    domain = bubblemesh.Domain.of(half, [rings.ellipse((0, 0.45), (0.5, 0.2), 20, "ellipse")])
    mesh = bubblemesh.mesh(domain, 0.12)
    nearest = domain.nearest(mesh.facet_middles)
    np.testing.assert_allclose(nearest.distance, 0, atol=1e-8)
    a, b = mesh.points[mesh.facets[:, 0]], mesh.points[mesh.facets[:, 1]]
    first, second = (np.hypot(*(mesh.facet_middles - end).T) for end in (a, b))
    np.testing.assert_allclose(first, second, rtol=0.02)
    assert (first + second < 1.1 * np.hypot(*(b - a).T)).all()


def test_a_spacing_function_may_change_its_arguments():
    def spacing(x, y):
        x -= 0.5
        y -= 0.5
        return 0.05 + 0.1 * np.hypot(x, y)

    square = shapely.box(0, 0, 1, 1)
    one = bubblemesh.mesh(square, spacing)
    other = bubblemesh.mesh(square, lambda x, y: 0.05 + 0.1 * np.hypot(x - 0.5, y - 0.5))
    np.testing.assert_array_equal(one.points, other.points)


def test_a_mesh_of_second_order_is_one_already():
    mesh = bubblemesh.mesh(shapely.box(0, 0, 1, 1), 0.3).second_order()[0]
    again, straight = mesh.second_order()
    assert again is mesh
    assert straight == 0
