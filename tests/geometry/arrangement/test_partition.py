from collections import Counter

import numpy as np
import pytest
import shapely
from partitions import check_pieces, domain_of
from sweeps import sweep

from bubblemesh.errors import CaseError, GeometryError

UNIT = "domain:\n  outer: {rectangle: [0, 0, 1, 1], labels: [bottom, right, top, left]}\n"
HALVES = (
    UNIT
    + """  regions:
    - {name: west, ring: {rectangle: [0, 0, 0.5, 1]}}
    - {name: east, ring: {rectangle: [0.5, 0, 1, 1]}}
"""
)


def unit(regions=(), lines=(), points=(), holes=()):
    """A unit square with regions, lines, points and holes in YAML's flow style."""
    lists = {"regions": regions, "lines": lines, "points": points, "holes": holes}
    return UNIT + "".join(
        f"  {key}:\n" + "".join(f"    - {one}\n" for one in ones) for key, ones in lists.items() if ones
    )


def inner_lengths(domain):
    """Total length of the inner pieces by label."""
    b, result = domain.boundary, Counter()
    for k in np.flatnonzero(b.inner):
        result[b.labels[b.label[k]].removesuffix("-rim")] += round(float(b.lengths[k]), 9)
    return {name: pytest.approx(length, abs=1e-8) for name, length in result.items()}


def has_corner(domain, x, y):
    return bool((np.hypot(*(domain.boundary.corners - [x, y]).T) < 1e-9).any())


def test_a_common_side_is_one_piece_with_the_label_of_the_first_region():
    domain = domain_of(HALVES)
    check_pieces(domain)
    assert inner_lengths(domain) == {"west": 1.0}
    assert len(domain.boundary.kind) == 7
    assert set(np.array(domain.boundary.labels)[domain.boundary.label].tolist()) == {
        *("bottom", "right", "top", "left", "west-rim")
    }


def test_nothing_embedded_leaves_the_boundary_as_it_is():
    b = domain_of(UNIT).boundary
    assert not b.inner.any()
    assert len(b.corners) == len(b.kind) == 4


@pytest.mark.long
@pytest.mark.parametrize(
    ("regions", "others", "inner"),
    [
        pytest.param(
            ["{name: a, ring: {rectangle: [0, 0, 0.5, 0.5]}}", "{name: b, ring: {rectangle: [0.5, 0.2, 1, 0.9]}}"],
            {},
            {"a": 1.0, "b": 1.4},
            id="T-junction",
        ),
        pytest.param(["{name: a, ring: {rectangle: [-1, 0.25, 2, 0.75]}}"], {}, {"a": 2.0}, id="clipped"),
        pytest.param(["{name: a, ring: {rectangle: [0, 0, 1, 1]}}"], {}, {}, id="all"),
        pytest.param(
            ["{name: a, ring: {circle: {center: [0, 0.5], radius: 0.25}}}"], {}, {"a": np.pi / 4}, id="half a disc"
        ),
        pytest.param(
            [
                "{name: a, ring: {rectangle: [0.1, 0.1, 0.9, 0.9]}}",
                "{name: b, ring: {rectangle: [0.2, 0.2, 0.8, 0.8]}}",
                "{name: c, ring: {circle: {center: [0.5, 0.5], radius: 0.2}}}",
            ],
            {},
            {"a": 3.2, "b": 2.4, "c": 0.4 * np.pi},
            id="nested",
        ),
        pytest.param(
            ["{name: a, ring: {rectangle: [0.2, 0.2, 0.8, 0.8]}}"],
            {"holes": ["{rectangle: [0.4, 0.4, 0.6, 0.6]}"]},
            {"a": 2.4},
            id="hole inside",
        ),
        pytest.param(
            ["{name: a, ring: {rectangle: [0, 0, 0.5, 1]}}"],
            {"holes": ["{circle: {center: [0.5, 0.5], radius: 0.2}}"]},
            {"a": 0.6},
            id="hole on the interface",
        ),
        pytest.param(
            [
                "{name: a, ring: {circle: {center: [0.3, 0.5], radius: 0.2}}}",
                "{name: b, ring: {circle: {center: [0.6, 0.5], radius: 0.1}}}",
                "{name: c, ring: {circle: {center: [0.3, 0.4], radius: 0.1}}}",
                "{name: d, ring: {circle: {center: [0.85, 0.5], radius: 0.15}}}",
            ],
            {},
            {"a": 0.4 * np.pi, "b": 0.2 * np.pi, "c": 0.2 * np.pi, "d": 0.3 * np.pi},
            id="touching circles",
        ),
        pytest.param(
            [
                "{name: a, ring: {circle: {center: [0.5, 0.5], radius: 0.3}}}",
                "{name: b, ring: {path: [[0.5, 0.2], {arc: {to: [0.5, 0.8], center: [0.5, 0.5], turn: left}}]}}",
            ],
            {},
            {"a": 0.6 * np.pi, "b": 0.6},
            id="half of a circle on the circle",
        ),
        pytest.param(
            [
                "{name: a, ring: {rectangle: [0.1, 0.1, 0.30000000000000004, 0.9]}}",
                "{name: b, ring: {rectangle: [0.3, 0.1, 0.6, 0.9]}}",
            ],
            {},
            {"a": 2.0, "b": 1.4},
            id="rounded coordinates",
        ),
    ],
)
def test_regions(regions, others, inner):
    domain = domain_of(unit(regions, **others))
    check_pieces(domain)
    assert inner_lengths(domain) == inner


LINES = [
    pytest.param(["{path: [[0.2, 0.2], [0.8, 0.8]]}", "{path: [[0.2, 0.8], [0.8, 0.2]]}"], (), 4, id="crossing"),
    pytest.param(["{path: [[0, 0.5], [0.3, 0.5]]}"], (), 1, id="from the boundary"),
    pytest.param(["{path: [[-1, 0.5], [0.3, 0.5]]}"], (), 1, id="from outside"),
    pytest.param(["{path: [[0.2, 0.5], [0.7, 0.5]]}"], ("west", "east"), 4, id="across an interface"),
    pytest.param(["{path: [[0.5, 0.2], [0.5, 0.6]]}"], ("west", "east"), 3, id="along an interface"),
    pytest.param(["{path: [[0.2, 0.2], [0.4, 0.2], [0.3, 0.4], [0.2, 0.2]]}"], (), 3, id="closed"),
    pytest.param(["{path: [[0.2, 0.2], [0.6, 0.2], [0.4, 0.2]]}"], (), 2, id="back on itself"),
    pytest.param(["{path: [[0.2, 0.2], [0.6, 0.2], [0.4, 0.4], [0.4, 0.1]]}"], (), 5, id="across itself"),
    pytest.param(["{path: [[0.2, 0.2], {spline: {through: [[0.8, 0.5], [0.2, 0.8], [0.4, 0.1]]}}]}"], (), 3, id="loop"),
    pytest.param(
        ["{path: [[0.1, 0.5], {arc: {to: [0.9, 0.5], center: [0.5, 0.5], turn: left}}], label: w}"] * 1, (), 1, id="arc"
    ),
]


@pytest.mark.long
@pytest.mark.parametrize(("lines", "halves", "pieces"), LINES)
def test_lines(lines, halves, pieces):
    names = {"west": [0, 0, 0.5, 1], "east": [0.5, 0, 1, 1]}
    domain = domain_of(unit([f"{{name: {name}, ring: {{rectangle: {names[name]}}}}}" for name in halves], lines))
    check_pieces(domain)
    assert domain.boundary.inner.sum() == pieces


def test_a_line_along_an_interface_keeps_its_own_label_and_one_along_the_boundary_the_ring_s():
    domain = domain_of(HALVES + "  lines:\n    - {path: [[0.5, 0.25], [0.5, 2]], label: weld}\n")
    assert inner_lengths(domain) == {"weld": 0.75, "west": 0.25}
    domain = domain_of(unit(lines=["{path: [[0.5, 0.5], [0.5, 0], [0.8, 0]], label: wire}"]))
    assert inner_lengths(domain) == {"wire": 0.5}
    b = domain.boundary
    assert {b.labels[k] for k in b.label[~b.inner]} == {"bottom", "right", "top", "left"}


@pytest.mark.parametrize("at", [(0.5, 0.3), (0.5, 0), (0, 0), (0.25, 0.25), (0.7, 0.4)])
def test_embedded_points_are_corners(at):
    text = HALVES + "  lines:\n    - {path: [[0.6, 0.2], [0.8, 0.6]]}\n  points:\n"
    domain = domain_of(text + f"    - {{at: [{at[0]}, {at[1]}], label: well}}\n")
    check_pieces(domain)
    assert has_corner(domain, *at)


def test_many_points_are_looked_for_in_the_domain_at_once(monkeypatch):
    calls, looked = [], shapely.contains_xy
    points = [f"{{at: [{0.1 + 0.002 * k}, 0.3]}}" for k in range(300)]
    monkeypatch.setattr(shapely, "contains_xy", lambda *given: calls.append(given) or looked(*given))
    domain = domain_of(unit(points=points))
    assert len(domain.boundary.corners) == 304
    assert len(calls) < len(points)


def test_a_point_on_a_curve_is_a_corner_of_it():
    x, y = 0.5 + 0.3 * np.cos(1), 0.5 + 0.3 * np.sin(1)
    text = unit(["{name: a, ring: {circle: {center: [0.5, 0.5], radius: 0.3}}}"], points=[f"{{at: [{x}, {y}]}}"])
    domain = domain_of(text)
    check_pieces(domain)
    assert has_corner(domain, x, y)
    assert domain.boundary.inner.sum() == 1


def test_an_interface_has_a_label_of_its_own_beside_the_name_of_its_region():
    domain = domain_of(unit(["{name: a, ring: {circle: {center: [0.5, 0.5], radius: 0.3}}}"]))
    assert domain.boundary.labels == ("bottom", "right", "top", "left", "a-rim")


def test_the_label_of_a_ring_may_be_the_name_of_its_region():
    ring = "{circle: {center: [0.5, 0.5], radius: 0.3}, label: a}"
    domain = domain_of(unit([f"{{name: a, ring: {ring}}}"]))
    assert inner_lengths(domain) == {"a": 0.6 * np.pi}
    assert "a" in domain.labels
    assert domain.notes == ("the region 'a' is called 'a_region' in mesh files, since a label has its name",)


def test_a_region_that_surrounds_a_hole_with_the_same_circle_has_no_inner_piece_there():
    ring = "circle: {center: [0.5, 0.5], radius: 0.2}"
    domain = domain_of(unit(["{name: a, ring: {circle: {center: [0.5, 0.5], radius: 0.4}}}"], holes=[f"{{{ring}}}"]))
    check_pieces(domain)
    with pytest.raises(GeometryError, match=r"region 'a' at .* lies outside the domain"):
        domain_of(unit([f"{{name: a, ring: {{{ring}}}}}"], holes=[f"{{{ring}}}"]))


@pytest.mark.parametrize("radius", sweep([1000, 0.4, 3], quick=1))
def test_a_layer_much_thinner_than_chords_of_its_circles_are_long_lies_between_them(radius):
    layers = [BEHIND.format(name, x, f"({radius} + {x})") for name, x in [("a", 0.4), ("b", 0.4001), ("c", 0.4005)]]
    b = domain_of(unit(layers)).boundary
    inner = np.flatnonzero(b.inner)
    beside = {b.labels[b.label[k]]: (int(b.left[k]), int(b.right[k])) for k in inner}
    assert beside == {"a-rim": (1, 2), "b-rim": (2, 3), "c-rim": (3, 0)}


@pytest.mark.long
@pytest.mark.parametrize("seed", range(6))
def test_cells_of_a_voronoi_diagram_fill_the_domain(seed):
    points = np.random.default_rng(seed).random((12, 2))
    cells = shapely.voronoi_polygons(shapely.MultiPoint(points), extend_to=shapely.box(-1, -1, 2, 2)).geoms
    rings = [cell.exterior.coords[:-1] for cell in cells if cell.intersects(shapely.box(0, 0, 1, 1))]
    domain = domain_of(
        unit([f"{{name: r{k}, ring: {{polygon: {[list(p) for p in ring]}}}}}" for k, ring in enumerate(rings)])
    )
    check_pieces(domain, aside=1e-7)
    assert 0 not in domain.boundary.left


A, B = "{name: a, ring: {rectangle: [0, 0, 0.5, 1]}}", "{{name: b, ring: {{rectangle: [{}, 0, 1, 1]}}}}"
# A circle whose rim crosses the square nearly straight, at some x in the middle.
BEHIND = "{{name: {0}, ring: {{circle: {{center: [{1} - {2}, 0.5], radius: {2}}}}}}}"
MISTAKES = [
    ([A, B.format(0.4)], {}, r"regions 'a' and 'b' overlap at \(0\.4, 0\.5\)"),
    ([A, B.format(0.49999)], {}, r"regions 'a' and 'b' overlap at \(0\.49999, 0\.5\)"),
    ([A, A.replace("a,", "c,")], {}, r"regions 'a' and 'c' at .* are the same"),
    (
        [BEHIND.format("a", 0.5, 1000), "{name: b, ring: {rectangle: [0.4, 0.3, 0.8, 0.7]}}"],
        {},
        r"regions 'a' and 'b' overlap at \(0\.5, 0\.5\)",
    ),
    ([BEHIND.format("a", 0.5, 1000), BEHIND.format("b", 0.5001, 300)], {}, r"regions 'a' and 'b' overlap at"),
    (["{name: a, ring: {rectangle: [2, 2, 3, 3]}}"], {}, r"region 'a' at \(.*\) lies outside the domain"),
    (
        ["{name: a, ring: {rectangle: [0.45, 0.45, 0.5, 0.5]}}"],
        {"holes": ["{rectangle: [0.4, 0.4, 0.6, 0.6]}"]},
        r"region 'a' at \(.*\) lies outside the domain",
    ),
    (["{name: bow, ring: {polygon: [[0, 0], [1, 1], [1, 0], [0, 1]]}}"], {}, r"'bow' crosses .* at \(0\.5, 0\.5\)"),
    ([A, B.format(0.5000001)], {}, r"at \(0\.5, 0\) and \(0\.5000001, 0\) are 1e-07 apart"),
    (
        [A],
        {"lines": ["{path: [[0.5000001, 0.5], [0.8, 0.5]]}"]},
        r"vertex at \(0\.5000001, 0\.5\) is 1e-07 away from the line at \(0\.5, 0\.5\)",
    ),
    (
        [],
        {"lines": ["{path: [[0.2, 0.2], [0.5, 0.5]]}", "{path: [[0.5000001, 0.5], [0.8, 0.4]]}"]},
        "next to each other",
    ),
    (
        ["{name: a, ring: {circle: {center: [0.3, 0.5], radius: 0.2}}}"],
        {"lines": ["{path: [[0.1, 0.7000001], [0.6, 0.7000001]]}"]},
        r"two curves pass each other at \(0\.3, 0\.7\)",
    ),
    (
        [
            A,
            A.replace("a,", "c,").replace("0, 0, 0.5", "0, 0, 0.2"),
            A.replace("a,", "d,").replace("0, 0, 0.5", "0.2, 0, 0.5"),
        ],
        {},
        r"nothing is left of region 'a' at .* beside the regions within it",
    ),
    (["{name: a, ring: {rectangle: [0.2, 0.5, 0.8, 0.5000000001]}}"], {}, r"'a' at .* is thinner than 1e-09 of the"),
    ([], {"points": ["{at: [2, 0.5], label: well}"]}, r"the point 'well' at \(2, 0\.5\) lies outside the domain"),
    (
        [],
        {"points": ["{at: [0.5, 0.5]}", "{at: [0.2, 0.5]}", "{at: [0.5, 0.5000000000001], label: well}"]},
        r"the points 'point-1' and 'well' are both at \(0\.5, 0\.5\)",
    ),
    (
        [],
        {"points": ["{at: [0.5, 0.5]}"], "holes": ["{circle: {center: [0.5, 0.5], radius: 0.1}}"]},
        r"the point 'point-1' at \(0\.5, 0\.5\) lies outside the domain",
    ),
    (
        [],
        {"lines": ["{path: [[2, 2], [3, 3]], label: far}"]},
        r"the line 'far' at \(2\.5, 2\.5\) lies outside the domain",
    ),
    (
        [],
        {"lines": ["{path: [[0, 0], [1, 0]]}"]},
        r"the line 'line-1' at \(0\.5, 0\) lies on the boundary of the domain, 'bottom': give it a label",
    ),
    ([], {"lines": ["{path: [[0.5, 0.5], [0.5, 0.5]]}"]}, r"line 1: the line at \(0\.5, 0\.5\) has no length"),
]


@pytest.mark.parametrize(("regions", "others", "message"), MISTAKES)
def test_mistakes_are_named_with_their_place(regions, others, message):
    with pytest.raises(GeometryError, match=message):
        domain_of(unit(regions, **others))


@pytest.mark.parametrize(
    "text",
    [
        unit([A, A]),
        unit([A]).replace("name: a", "name: domain"),
        "domain: {outer: {rectangle: [0, 0, 1, 1]}, region: a, regions: [" + A + "]}",
    ],
)
def test_every_region_has_a_name_of_its_own(text):
    with pytest.raises(
        CaseError, match=r"parts\.yaml:\d: domain\.regions\.\d\.name: '(a|domain)' is the name at domain\.region"
    ):
        domain_of(text)
