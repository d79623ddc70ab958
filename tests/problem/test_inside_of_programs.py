"""Regions, lines and points that Python programs embed: exact areas and lengths, names, errors about the argument."""

import numpy as np
import pytest
import shapely
from invariants import check_area, check_arrays, check_edges

import bubblemesh
from bubblemesh.errors import CaseError, GeometryError
from bubblemesh.geometry import rings

BAR = shapely.box(-2, -1, 2, 1)
CORE, LOW, ACROSS = (shapely.box(*sides) for sides in ((-0.25, -0.1, 0.25, 0.1), (-2, -1, 2, -0.1), (0, 0, 1, 0.2)))
DISC = shapely.Point(0, 0).buffer(0.5)


def check_embedded(mesh):
    """The invariants of a mesh, whose nodes on lines inside come before others, too."""
    for check in (check_arrays, check_edges, check_area):
        check(mesh)


def areas(mesh):
    a, b, c = np.moveaxis(mesh.points[mesh.triangles[:, :3]], 1, 0)
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    return dict(zip(mesh.regions, np.bincount(mesh.triangle_regions, (ux * vy - uy * vx) / 2).tolist(), strict=True))


def length(mesh, label):
    a, b = np.moveaxis(mesh.points[mesh.facets[mesh.facet_labels == mesh.labels.index(label)]], 1, 0)
    return np.hypot(*(b - a).T).sum()


def test_regions_lines_and_points_have_their_names():
    crack = shapely.LineString([(0.5, 0.3), (0.8, 0.7), (1.1, 0.7)])
    mesh = bubblemesh.mesh(
        BAR, 0.25, regions={"core": CORE, "low": LOW}, lines={"crack": crack}, points={"probe": (0, 0.5)}
    )
    check_embedded(mesh)
    assert areas(mesh) == pytest.approx({"domain": 4.3, "core": 0.1, "low": 3.6})
    assert length(mesh, "crack") == pytest.approx(0.8)
    assert length(mesh, "core-rim") == pytest.approx(1.4)
    assert np.hypot(*(mesh.points - (0, 0.5)).T).min() == 0
    assert set(mesh.labels) == {"outer", "core-rim", "low-rim", "crack"}


def test_arrays_and_parts_of_one_shape_will_do():
    squares = shapely.MultiPolygon([shapely.box(x, 0, x + 0.5, 0.5) for x in (-1.5, 0.5)])
    ways = shapely.MultiLineString([[(-1, -0.5), (0, -0.5)], [(0.5, -0.5), (1, -0.5)]])
    mesh = bubblemesh.mesh(
        np.array(BAR.exterior.coords[:-1]),
        0.3,
        regions={"square": squares, "tip": [(1.5, -0.5), (2, -0.5), (2, 0.5)]},
        lines={"ways": ways},
        points={"two": [(-1.5, -0.7), (1.5, -0.7)]},
    )
    check_embedded(mesh)
    assert areas(mesh) == pytest.approx({"domain": 7.25, "square": 0.5, "tip": 0.25})
    assert length(mesh, "ways") == pytest.approx(1.5)


def test_neighbours_are_followed_as_one_curve():
    ring = shapely.Point(0, 0).buffer(0.8).difference(DISC)
    mesh = bubblemesh.mesh(BAR, 0.2, regions={"core": DISC, "shell": ring}, corners=30)
    check_embedded(mesh)
    assert (mesh.facet_labels == mesh.labels.index("core-rim")).sum() == pytest.approx(np.pi / 0.2, abs=2)
    assert areas(mesh)["core"] == pytest.approx(DISC.area, rel=0.03)


@pytest.mark.parametrize(
    ("rule", "way"),
    [({}, 1), ({"smooth": True}, -1), ({"tolerance": 0.05}, -1), ({"smooth": True, "tolerance": 0.05}, 1)],
)
def test_lines_and_regions_share_curves_with_the_rings_that_they_run_along(rule, way):
    rim = list(DISC.exterior.coords)
    mesh = bubblemesh.mesh(
        DISC,
        0.15,
        regions={"quarter": DISC.intersection(shapely.box(0, 0, 1, 1))},
        lines={"inlet": rim[20:30][::way], "outlet": [*rim[35:45], (0, 0)][::way]},
        corners=30,
        **rule,
        effort="fast",
    )
    check_embedded(mesh)
    assert length(mesh, "inlet") == pytest.approx(9 / 64 * np.pi, rel=5e-3)
    assert areas(mesh)["quarter"] == pytest.approx(np.pi / 16, rel=0.03)
    assert len(mesh.facets[mesh.facet_labels == mesh.labels.index("inlet")]) < 9  # not each vertex is a node


@pytest.mark.parametrize(
    ("arguments", "error", "match"),
    [
        ({"regions": [DISC]}, CaseError, "regions: must be a mapping of names to shapes .found list"),
        ({"regions": {"domain": DISC}}, CaseError, "regions: 'domain' is the name of what regions leave"),
        ({"regions": {"": DISC}}, CaseError, "regions: '' is no name"),
        ({"regions": {1000 * "a": DISC}}, CaseError, f"regions: '{56 * 'a'}... is no name: use short texts"),
        ({"regions": {"a": 3}}, CaseError, r"regions\['a'\]: must be a shapely.Polygon.*found the shape \(\)"),
        ({"regions": {"a": shapely.Polygon()}}, GeometryError, r"regions\['a'\]: the polygon is empty"),
        (
            {"regions": {"a": DISC, "b": ACROSS}},
            GeometryError,
            r"regions\['b'\].*'a' and 'b' overlap at .* by the difference of their shapes, or set overlaps='later', ",
        ),
        ({"lines": {"l": DISC}}, CaseError, r"lines\['l'\]: must be a shapely.LineString.*found Polygon"),
        ({"lines": {"l": shapely.LineString()}}, GeometryError, r"lines\['l'\]: the line is empty"),
        ({"lines": {"l": np.empty((0, 2))}}, GeometryError, r"lines\['l'\]: the line is empty"),
        ({"points": {"p": shapely.MultiPoint()}}, GeometryError, r"points\['p'\]: the point is empty"),
        ({"points": {"p": np.empty((0, 2))}}, GeometryError, r"points\['p'\]: the point is empty"),
        ({"lines": {"l": [(0, 0)]}}, GeometryError, r"lines\['l'\]: the line at \(0, 0\) has no length"),
        ({"lines": {"l": [(0, np.nan), (1, 0)]}}, CaseError, r"lines\['l'\]"),
        ({"points": {"p": 3}}, CaseError, r"points\['p'\]: must be a point \(x, y\)"),
        (
            {"points": {"p": (9, 9)}},
            GeometryError,
            r"points\['p'\]: the point 'p' at \(9, 9\) lies outside the domain: move or remove it$",
        ),
        ({"points": {"p": [(9, 9), (8, 9)]}}, GeometryError, r"2 points lie outside .*: move or remove them$"),
        (
            {"lines": {"l": shapely.GeometryCollection([DISC])}},
            CaseError,
            r"lines\['l'\]: must be .*found GeometryCollection: take the lines among its geoms alone",
        ),
        ({"regions": {"a": [DISC, CORE]}}, CaseError, "found several shapes: shapely.union_all makes one of them"),
        ({"lines": {"l": np.array([1j, 2, 3])}}, CaseError, r"found an array of complex128: column_stack\(\[z.real, z"),
        ({"points": {"p": np.array([["1", "2"]])}}, CaseError, r"found an array of <U1: astype\(float\) makes numbers"),
        ({"layers": {"on": "outer"}}, CaseError, "layers: must be a list of mappings, one for each layer"),
    ],
)
def test_errors_name_the_argument(arguments, error, match):
    with pytest.raises(error, match=match):
        bubblemesh.mesh(BAR, 0.3, **arguments)


def test_a_domain_has_its_own():
    with pytest.raises(CaseError, match="regions: a Domain has regions of its own"):
        bubblemesh.mesh(bubblemesh.Domain.of(rings.rectangle(0, 0, 1, 1)), 0.3, regions={"a": DISC})


def test_later_regions_cover_earlier_ones():
    over = {"low": LOW, "across": shapely.box(-1, -0.5, 1, 0.5)}
    mesh = bubblemesh.mesh(BAR, 0.25, regions=over, overlaps="later")
    check_embedded(mesh)
    assert areas(mesh) == pytest.approx({"domain": 8 - 3.6 - 2 * 0.6, "low": 3.6 - 2 * 0.4, "across": 2})
    assert length(mesh, "across-rim") == pytest.approx(6)


def test_later_regions_cover_earlier_ones_as_curves():
    discs = {"one": DISC, "two": shapely.affinity.translate(DISC, 0.5)}
    mesh = bubblemesh.mesh(BAR, 0.1, regions=discs, overlaps="later", corners=30)
    lens = 2 * np.pi / 3 - np.sqrt(3) / 2
    assert areas(mesh)["one"] == pytest.approx(0.25 * (np.pi - lens), rel=0.03)
    assert length(mesh, "two-rim") == pytest.approx(np.pi, rel=0.01)


def test_overlaps_are_refused_or_later():
    with pytest.raises(CaseError, match="overlaps: must be 'refused' or 'later' "):
        bubblemesh.mesh(BAR, 0.25, overlaps="first")
