"""Later regions cover earlier ones: exact areas, labels of common sides, what is left of all of them."""

import itertools
import json
import math

import numpy as np
import pytest
import shapely

from bubblemesh.case import load_case
from bubblemesh.errors import GeometryError
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
