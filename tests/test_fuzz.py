"""Domains that have broken meshers: each must get a conforming mesh, whatever its quality."""

import json
import math

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from invariants import check_mesh
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextPath

from bubblemesh.case import load_case
from bubblemesh.problem.prepare import prepare
from bubblemesh.run.pipeline import mesh_case

pytestmark = pytest.mark.long

QUICK = {
    "accelerated": {"schedule": {"rounds": 2, "iterations": 60}},
    "multilevel": {"packing": {"effort": "fast"}},
}
UNIT = {"rectangle": [0, 0, 1, 1]}


@pytest.fixture(scope="module", params=QUICK)
def method(request):
    return request.param


def meshed(domain, spacing, method):
    case = {"domain": domain, "spacing": spacing, "method": method} | QUICK[method]
    result = mesh_case(load_case("fuzz.yaml", text=json.dumps(case)))
    check_mesh(result.mesh)
    return result


def polygon(points):
    return {"polygon": [[float(x), float(y)] for x, y in points]}


def circle(x, y, radius):
    return {"circle": {"center": [x, y], "radius": radius}}


def domain_of(area):
    rings = [polygon(ring.coords[:-1]) for ring in (area.exterior, *area.interiors)]
    return {"outer": rings[0], "holes": rings[1:]}


def parts_of(area):
    return [part for part in getattr(area, "geoms", [area]) if part.geom_type == "Polygon" and part.area > 1e-6]


def size_of(area):
    x0, y0, x1, y1 = area.bounds
    return max(x1 - x0, y1 - y0)


def glyph(character, font):
    outlines = TextPath((0, 0), character, size=100, prop=FontProperties(family=font)).to_polygons()
    area = shapely.Polygon()
    for outline in outlines:
        area = area.symmetric_difference(shapely.Polygon(outline).buffer(0))
    return shapely.remove_repeated_points(area)


@pytest.mark.parametrize("font", ["DejaVu Sans", "DejaVu Serif"])
@pytest.mark.parametrize("character", ["8", "g", "&", "@"])
def test_glyphs(character, font, method):
    parts = parts_of(glyph(character, font))
    assert parts
    for part in parts:
        area = meshed(domain_of(part), size_of(part) / 8, method).report["area"]
        assert area == pytest.approx(part.area, rel=1e-12)


@given(
    radii=st.lists(st.floats(0.2, 1.0), min_size=3, max_size=20),
    parts=st.sampled_from([0.5, 3.0, 10.0]),
)
@settings(derandomize=True, deadline=None, max_examples=10)
def test_star_shaped_rings(radii, parts, method):
    angle = 2 * np.pi * np.arange(len(radii)) / len(radii)
    ring = np.column_stack([radii * np.cos(angle), radii * np.sin(angle)])
    result = meshed({"outer": polygon(ring)}, 1 / parts, method)
    assert result.report["area"] == pytest.approx(shapely.Polygon(ring).area, rel=1e-12)


@given(boxes=st.lists(st.tuples(*[st.integers(0, 8)] * 2, *[st.integers(1, 6)] * 2), min_size=2, max_size=7))
@settings(derandomize=True, deadline=None, max_examples=10)
def test_unions_of_boxes(boxes, method):
    union = shapely.union_all([shapely.box(x, y, x + width, y + height) for x, y, width, height in boxes])
    parts = parts_of(union)
    assume(len(parts) <= 2)
    for part in parts:
        assert meshed(domain_of(part), 1.5, method).report["area"] == pytest.approx(part.area, rel=1e-12)


@pytest.mark.parametrize("width", [0.1, 1e-3, 1e-6])
def test_comb_with_thin_slits(width, method):
    comb = shapely.box(0, 0, 3, 1) - shapely.union_all(
        [shapely.box(x - width / 2, 0.2, x + width / 2, 2) for x in (1, 2)]
    )
    assert meshed(domain_of(comb), 0.3, method).report["area"] == pytest.approx(comb.area, rel=1e-12)


def test_spiral(method):
    turn = np.linspace(0, 5 * np.pi, 50)
    inner, outer = (
        np.column_stack([r * np.cos(turn), r * np.sin(turn)]) for r in (0.3 + 0.05 * turn, 0.4 + 0.05 * turn)
    )
    ring = np.vstack([inner, outer[::-1]])
    area = meshed({"outer": polygon(ring)}, 0.1, method).report["area"]
    assert area == pytest.approx(shapely.Polygon(ring).area, rel=1e-12)


def test_gear(method):
    number = np.arange(80)
    radius, angle = np.where(number % 4 < 2, 1, 0.9), number * np.pi / 40
    ring = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    area = meshed({"outer": polygon(ring)}, 0.2, method).report["area"]
    assert area == pytest.approx(shapely.Polygon(ring).area, rel=1e-12)


def test_tiny_holes(method):
    holes = [circle(x / 4 + 1 / 8, y / 4 + 1 / 8, 0.002) for x in range(4) for y in range(4)]
    result = meshed({"outer": UNIT, "holes": holes}, 0.2, method)
    assert np.unique(result.mesh.facet_labels).size == 17


CURVED = {
    "thin annulus": ({"outer": circle(0, 0, 1), "holes": [circle(0, 0, 0.97)]}, 0.5),
    "thinner annulus": ({"outer": circle(0, 0, 1), "holes": [circle(0, 0, 0.995)]}, 0.5),
    "eccentric annulus": ({"outer": circle(0, 0, 1), "holes": [circle(0.029, 0, 0.97)]}, 0.2),
    "hole beside a curve": ({"outer": circle(0, 0, 1), "holes": [circle(0.9, 0.43, 0.001)]}, 0.5),
    "circle smaller than the spacing": ({"outer": circle(0, 0, 1)}, 10),
    "thin ellipse": ({"outer": {"ellipse": {"center": [0, 0], "radii": [1, 0.02], "angle": 30}}}, 0.05),
    "thin lens": (
        {
            "outer": {
                "path": [
                    [-1, 0],
                    {"arc": {"to": [1, 0], "center": [0, 50], "turn": "left"}},
                    {"arc": {"to": [-1, 0], "center": [0, -50], "turn": "left"}},
                ]
            }
        },
        10,
    ),
    "spline": (
        {"outer": {"path": [[0, 0], {"spline": {"through": [[0.5, 0.3], [0.6, 0.3], [1, 0]]}}, [1, 1], [0, 1]]}},
        0.1,
    ),
    "crescent": (
        {
            "outer": {
                "path": [
                    [0, 0],
                    {"arc": {"to": [0, 2], "center": [0, 1], "turn": "left"}},
                    [0.8 * math.sin(2), 0.8 - 0.8 * math.cos(2)],
                    {"arc": {"to": [0, 0], "center": [0, 0.8], "turn": "right"}},
                ]
            }
        },
        0.2,
    ),
    "touching circles": ({"outer": circle(0, 0, 1), "holes": [circle(0.5, 0, 0.5)]}, 0.2),
    "pinch node": ({"outer": UNIT, "holes": [polygon([(0.5, 0), (0.7, 0.3), (0.5, 0.5), (0.3, 0.3)])]}, 0.1),
    "holes in a pinch node": (
        {
            "outer": UNIT,
            "holes": [
                polygon([(0.5, 0.2), (0.7, 0.3), (0.5, 0.5), (0.3, 0.3)]),
                polygon([(0.5, 0.5), (0.7, 0.7), (0.5, 0.8), (0.3, 0.7)]),
            ],
        },
        0.1,
    ),
}


@pytest.mark.parametrize("name", CURVED)
def test_curves_and_contacts(name, method):
    """Each ring is there, and its nodes are on it."""
    keys, spacing = CURVED[name]
    mesh = meshed(keys, spacing, method).mesh
    assert np.unique(mesh.facet_labels).size == 1 + len(keys.get("holes", []))
    domain = prepare(load_case("fuzz.yaml", text=json.dumps({"domain": keys, "spacing": spacing}))).domain
    assert domain.signed_distance(mesh.points[np.unique(mesh.facets)]) == pytest.approx(0, abs=1e-6)


STRAIGHT = {
    "edges shorter than the spacing": (
        [(math.cos(2 * math.pi * k / 200), math.sin(2 * math.pi * k / 200)) for k in range(200)],
        0.3,
    ),
    "one short edge": ([(0, 0), (0.5, 0), (0.5 + 1e-5, 1e-6), (1, 0), (1, 1), (0, 1)], 0.2),
    "needle": ([(0, 0), (0.5, 0.5), (0, 1e-3), (-0.5, 0.5)], 0.1),
    "thin strip": ([(0, 0), (1, 0), (1, 1e-3), (0, 1e-3)], 0.1),
    "sharp angle": ([(0, 0), (1, 0.001), (1, 0)], 0.1),
    "spacing larger than the domain": ([(0, 0), (1, 0), (0, 1)], 100),
}


@pytest.mark.parametrize("name", STRAIGHT)
def test_awkward_polygons(name, method):
    points, spacing = STRAIGHT[name]
    result = meshed({"outer": polygon(points)}, spacing, method)
    assert set(points) <= {tuple(point) for point in result.mesh.points.tolist()}


@pytest.mark.parametrize(
    "spacing",
    [
        "0.0005 + 0.3*hypot(x - 0.5, y - 0.5)",
        "0.02 + 0.35*abs(x - 0.3)",
        "where(x < 0.5, 0.15, 0.03)",
        "0.06 + 0.04*sin(20*x)*cos(15*y)",
    ],
)
def test_steep_spacings(spacing, method):
    report = meshed({"outer": UNIT}, spacing, method).report
    assert report["area"] == pytest.approx(1, rel=1e-12)
    assert report["spacing"]["mean"] == pytest.approx(1, abs=0.1)


@pytest.mark.parametrize("scale", [1e15, 1e-12])
def test_mesh_does_not_depend_on_the_unit_of_length(scale, method):
    def domain(unit):
        return {"outer": {"rectangle": [0, 0, unit, unit]}, "holes": [circle(unit / 2, unit / 2, unit / 5)]}

    one, other = (meshed(domain(unit), unit / 10, method).mesh for unit in (1.0, scale))
    np.testing.assert_array_equal(one.triangles, other.triangles)
    np.testing.assert_allclose(other.points / scale, one.points, atol=1e-6)


@pytest.mark.parametrize("offset", [1e6, 1e9])
def test_domain_far_from_the_origin(offset, method):
    domain = {"outer": {"rectangle": [offset, -offset, offset + 1, 1 - offset]}}
    mesh = meshed(domain, 0.2, method).mesh
    assert np.ptp(mesh.points, axis=0).tolist() == [1, 1]
    assert mesh.points.min(axis=0).tolist() == [offset, -offset]
