"""Later regions cover earlier ones: exact areas, labels of common sides, what is left of all of them."""

import itertools
import json
import math

import numpy as np
import pytest
import shapely
from sweeps import sweep

from bubblemesh.case import load_case
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.arrangement.covering import covered
from bubblemesh.geometry.arrangement.regions import Region
from bubblemesh.geometry.paths import Arc, Area
from bubblemesh.geometry.rings import circle
from bubblemesh.meshes.conformity import require_conforming
from bubblemesh.problem.domain import case_domain
from bubblemesh.run.pipeline import mesh_case

A = {"name": "a", "ring": {"circle": {"center": [2, 2], "radius": 1}}}
B = {"name": "b", "ring": {"circle": {"center": [3, 2], "radius": 1}}}
BAR = {"name": "bar", "ring": {"rectangle": [2.4, 1.8, 5, 2.2], "label": "rod"}}
LENS = 2 * math.pi / 3 - math.sqrt(3) / 2  # of two unit circles through each other's centers


def case(*regions, **domain):
    keys = {"outer": {"rectangle": [0, 0, 6, 4]}, "overlaps": "later", "regions": list(regions)}
    return load_case("a.yaml", text=json.dumps({"name": "a", "domain": keys | domain, "spacing": 0.3}))


def exact_area(areas):
    """Area of rings of arcs and lines, by Green's formula."""
    total = 0.0
    for side in (side for area in areas for ring in area.rings for side in ring.sides):
        assert isinstance(side.curve, Arc)
        (x, y), r, a, turn = side.curve
        b = a + turn
        total += r * (x * (math.sin(b) - math.sin(a)) - y * (math.cos(b) - math.cos(a)) + r * turn) / 2
    return total


def test_arcs_stay_exact():
    a, b = (Region(Area(circle((x, 2), 1)), name, f"{name}-rim", x) for name, x in (("a", 2), ("b", 3)))
    later, earlier = covered([a, b], [])
    assert exact_area([later.area]) == pytest.approx(math.pi, rel=1e-12)
    assert exact_area([earlier.area]) == pytest.approx(math.pi - LENS, rel=1e-12)


def test_what_two_circles_have_in_common_is_the_later_ones():
    mesh = mesh_case(case(A, B)).mesh
    domain = case_domain(case(A, B))
    areas = {region.name: region.polygon.area for region in domain.parts.regions}
    assert areas == pytest.approx({"a": math.pi - LENS, "b": math.pi}, rel=1e-3)
    assert {label for label in domain.labels} >= {"a-rim", "b-rim"}
    lengths = np.bincount(
        mesh.facet_labels, np.hypot(*(mesh.points[mesh.facets[:, 1]] - mesh.points[mesh.facets[:, 0]]).T)
    )
    assert lengths[mesh.labels.index("b-rim")] == pytest.approx(2 * math.pi, rel=0.02)
    assert lengths[mesh.labels.index("a-rim")] == pytest.approx(2 * math.pi * 2 / 3, rel=0.02)


@pytest.mark.parametrize("order", list(itertools.permutations([A, B, BAR])))
def test_every_order_of_three(order):
    shapes = {
        "a": shapely.Point(2, 2).buffer(1, quad_segs=500),
        "b": shapely.Point(3, 2).buffer(1, quad_segs=500),
        "bar": shapely.box(2.4, 1.8, 5, 2.2),
    }
    domain = case_domain(case(*order))
    found = {name: 0.0 for name in shapes}
    for region in domain.parts.regions:
        found[region.name] += region.polygon.area
    names = [one["name"] for one in order]
    left = {
        name: shapely.difference(shapes[name], shapely.union_all([shapes[n] for n in names[k + 1 :]])).area
        for k, name in enumerate(names)
    }
    assert found == pytest.approx(left, rel=1e-3)
    assert [region.name for region in domain.parts.regions] == sorted(
        (region.name for region in domain.parts.regions), key=names.index
    )
    require_conforming(mesh_case(case(*order)).mesh)


@pytest.mark.parametrize("seed", range(6))
def test_random_rectangles(seed):
    """The last one around a place counts, by brute force."""
    random = np.random.default_rng(seed)
    low = random.uniform(0, 4, (6, 2)) * [1.2, 0.8]
    boxes = np.round(np.hstack([low, low + random.uniform(0.5, 2, (6, 2))]), 3)
    regions = [{"name": f"r{k}", "ring": {"rectangle": box}} for k, box in enumerate(boxes.tolist())]
    try:
        mesh = mesh_case(case(*regions, outer={"rectangle": [-1, -1, 8, 6]})).mesh
    except GeometryError as error:
        assert "which comes later, covers it" in str(error)  # noqa: PT017
        return
    x, y = mesh.points[mesh.triangles].mean(axis=1).T
    last = np.full(len(x), -1)
    for k, (x0, y0, x1, y1) in enumerate(boxes.tolist()):
        last[(x0 < x) & (x < x1) & (y0 < y) & (y < y1)] = k
    names = np.array(mesh.regions)[mesh.triangle_regions]
    assert names.tolist() == [f"r{k}" if k >= 0 else "domain" for k in last.tolist()]


def test_what_later_regions_cover_is_told_with_its_key():
    with pytest.raises(
        GeometryError, match=r"nothing is left of region 'bar' at .*: 'b', which comes later, covers"
    ) as error:
        case_domain(
            case(BAR | {"ring": {"rectangle": [2.9, 1.9, 3.1, 2.1]}}, A, B | {"ring": {"rectangle": [0, 0, 6, 4]}})
        )
    assert error.value.about == ("domain", "regions", 0)


def test_without_the_key_they_are_refused_with_its_name():
    with pytest.raises(GeometryError, match=r"regions 'a' and 'b' overlap at .*, or set overlaps: later in domain"):
        case_domain(case(A, B, overlaps="refused"))


def test_regions_that_do_not_overlap_stay_as_they_are():
    apart = A, B | {"ring": {"rectangle": [4, 3, 5, 3.5]}}
    one, other = (mesh_case(case(*apart, overlaps=overlaps)).mesh for overlaps in ("later", "refused"))
    assert one.points.tobytes() == other.points.tobytes()


def test_a_part_cut_off_and_a_region_beyond_the_domain():
    strip = {"name": "strip", "ring": {"rectangle": [-1, 1.9, 7, 2.1]}}
    domain = case_domain(case(A, strip))
    assert sorted(region.name for region in domain.parts.regions) == ["a", "a", "strip"]


def test_a_part_of_a_region_may_be_covered_if_others_are_left(tmp_path):
    (tmp_path / "a.wkt").write_text("MULTIPOLYGON (((0 0, 1 0, 1 1, 0 1, 0 0)), ((4 3, 5 3, 5 3.5, 4 3.5, 4 3)))")
    two = {"name": "two", "ring": {"file": str(tmp_path / "a.wkt")}}
    domain = case_domain(case(two, BAR | {"ring": {"rectangle": [3.9, 2.9, 5.1, 3.6]}}))
    assert sorted(region.name for region in domain.parts.regions) == ["bar", "two"]


def areas(domain):
    found = {}
    for region in domain.parts.regions:
        found[region.name] = found.get(region.name, 0) + region.polygon.area
    return found


OUT = {"name": "out", "ring": {"rectangle": [-2, 1, 3, 2]}}
WALL = {"name": "wall", "ring": {"rectangle": [-1, 0, 1, 4]}}


def test_a_part_outside_of_the_domain_is_left_out():
    assert areas(case_domain(case(OUT, WALL))) == {"out": 2, "wall": 8}


def test_a_part_in_a_hole_is_left_out():
    hole = {"rectangle": [2.9, 0.5, 5.5, 3]}
    bars = (BAR | {"ring": {"rectangle": [1, 1, 5, 2]}}, BAR | {"name": "top", "ring": {"rectangle": [2.5, 0, 3, 4]}})
    assert areas(case_domain(case(*bars, holes=[hole]))) == {"bar": 1.5, "top": 2}


def test_a_region_of_which_only_parts_outside_are_left_is_told():
    with pytest.raises(
        GeometryError, match=r"'out' at .* lies outside the domain, but for what later ones cover of it"
    ):
        case_domain(case(OUT, WALL | {"ring": {"rectangle": [0, 0, 4, 4]}}))


@pytest.mark.parametrize("more", [(), (A, B)])
def test_the_label_of_a_common_side_is_the_later_ones_whatever_else_overlaps(more):
    squares = [{"name": f"s{k}", "ring": {"rectangle": [4 + k, 3, 5 + k, 4]}} for k in range(2)]
    domain = case_domain(case(*squares, *more))
    lengths = dict(zip(domain.labels, np.bincount(domain.boundary.label, domain.boundary.lengths), strict=False))
    assert (lengths["s0-rim"], lengths["s1-rim"]) == (2, 2)


@pytest.mark.parametrize("turn", [0.01, 0.02, 0.03])
def test_an_overlap_that_chords_do_not_see(turn):
    """A side that is 1e-5 within a circle, halfway along a chord."""
    c, s = math.cos(turn), math.sin(turn)
    ends = [[2 + (1 - 1e-5) * c - s * t, 2 + (1 - 1e-5) * s + c * t] for t in (-1, 1)]
    wedge = {"name": "wedge", "ring": {"polygon": [*ends, [4.5, 2]]}}
    require_conforming(mesh_case(case(A, wedge)).mesh)


@pytest.mark.parametrize("far", [1e3, 1e6])
def test_a_region_that_is_far_larger_than_the_domain(far):
    """Tolerances are those of the domain: half of the circle is left."""
    domain = case_domain(case(A, WALL | {"ring": {"rectangle": [-far, 2, far, far]}}))
    assert areas(domain)["a"] == pytest.approx(math.pi / 2, rel=1e-3)


def test_digits_that_are_enough_for_the_domain_are_enough():
    square, wedge = {"rectangle": [0, 0, 1, 1]}, {"polygon": [[0.5, 0.5], [1.00000002, 1], [2, 0.5]]}
    regions = [{"name": "square", "ring": square}, {"name": "wedge", "ring": wedge}]
    assert areas(case_domain(case(*regions, outer={"rectangle": [0, 0, 1000, 1000]}))) == pytest.approx(
        {"square": 0.875, "wedge": 0.375}, rel=1e-6
    )


def test_repairs_of_what_is_covered_are_told():
    bow = {"name": "bow", "ring": {"polygon": [[1, 1], [3, 1], [1, 3], [3, 3]], "repair": True}}
    domain = case_domain(case(bow, WALL | {"ring": {"rectangle": [2.5, 0.5, 3.5, 3.5]}}))
    assert [change.what for change in domain.changes] == ["ring that crosses or touches itself"]


KINDS = ("circle", "rectangle", "ellipse", "spline")


def shape(random):
    x, y = (random.uniform(0.5, 5.5, 2) * [1, 0.7]).round(4).tolist()
    r = round(random.uniform(0.3, 1.3), 4)
    match random.choice(KINDS):
        case "circle":
            return {"circle": {"center": [x, y], "radius": r}}
        case "rectangle":
            return {"rectangle": [x - r, y - r / 2, x + r, y + r / 2]}
        case "ellipse":
            return {"ellipse": {"center": [x, y], "radii": [r, 0.6 * r], "angle": float(random.uniform(0, 180))}}
    angle, radius = np.linspace(0, 2 * np.pi, 7, endpoint=False), r * random.uniform(0.6, 1.2, 7)
    first, *others = np.column_stack([x + radius * np.cos(angle), y + radius * np.sin(angle)]).round(4).tolist()
    return {"path": [first, {"spline": {"through": [*others, first]}}]}


@pytest.mark.parametrize("seed", sweep(range(50), quick=4))
def test_random_shapes(seed):
    """Areas as those of polygonal copies; common sides have the label of the later region."""
    random = np.random.default_rng(seed)
    regions = [{"name": f"r{k}", "ring": shape(random)} for k in range(random.integers(3, 7))]
    box = shapely.box(0, 0, 6, 4)
    copies = [case_domain(case(one, outer={"rectangle": [-9, -9, 9, 9]})).parts.regions[0].polygon for one in regions]
    left = [shapely.difference(one, shapely.union_all(copies[k:])) & box for k, one in enumerate(copies, start=1)]
    names = [one["name"] for one in regions]
    if min(map(shapely.area, left)) < 1e-9:
        with pytest.raises(GeometryError, match=r"which comes later, covers it|for what later ones cover of it"):
            case_domain(case(*regions))
        return
    domain = case_domain(case(*regions))
    assert list(domain.parts.names) == ["domain", *names]
    for name, part in zip(names, left, strict=True):
        found = sum((one.polygon & box).area for one in domain.parts.regions if one.name == name)
        assert found == pytest.approx(part.area, abs=2e-3)
    mesh = mesh_case(case(*regions)).mesh
    require_conforming(mesh)
    sides = {}
    for region, corners in zip(mesh.triangle_regions.tolist(), mesh.triangles.tolist(), strict=True):
        for edge in itertools.combinations(sorted(corners), 2):
            sides.setdefault(edge, set()).add(region)
    for edge, label in zip(np.sort(mesh.facets).tolist(), mesh.facet_labels.tolist(), strict=True):
        beside = sides[tuple(edge)]
        if len(beside) == 2:
            assert mesh.labels[label] == f"{mesh.regions[max(beside)]}-rim"
