import re

import numpy as np
import pytest

import bubblemesh.geometry.domain
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.paths import Area
from bubblemesh.geometry.rings import ArcTo, LineTo, SplineTo, circle, ellipse, path, polygon, rectangle
from bubblemesh.messages import ring_name

SQUARE = rectangle(-1, -1, 1, 1)
DISC = circle((0, 0), 1)
PACMAN = path((1, 0), [ArcTo((0, 1), (0, 0), True), LineTo((0.2, 0.2))])

FAULTS = {
    "bow tie": (polygon([(0, 0), (1, 1), (1, 0), (0, 1)]), [], "the outer ring crosses", (0.5, 0.5)),
    "crossing spline": (
        path((0, 0), [SplineTo([(2, 1), (2, -1), (0, 1)])]),
        [],
        "the outer ring crosses or touches itself",
        None,
    ),
    "figure of eight": (
        path((0, 0), [ArcTo((0, 0), (1, 0), True), ArcTo((0, 0), (-1, 0), True)]),
        [],
        "the outer ring crosses or touches itself",
        (0, 0),
    ),
    "crossing hole": (
        SQUARE,
        [polygon([(0, 0), (0.5, 0.5), (0.5, 0), (0, 0.5)])],
        "hole 1 crosses or touches itself",
        (0.25, 0.25),
    ),
    "spike along a side": (
        polygon([(0, 0), (2, 0), (3, 0), (2, 0), (2, 1), (0, 1)]),
        [],
        "the outer ring crosses or touches itself",
        (3, 0),
    ),
    "oblique spike": (
        polygon([(0, 0), (2, 0), (2, 1), (3, 2), (2, 1), (0, 1)]),
        [],
        "the outer ring crosses or touches itself",
        (3, 2),
    ),
    "points on a line": (polygon([(0, 0), (1, 1), (2, 2)]), [], "the outer ring at .* encloses no area", (0, 0)),
    "flat hole": (
        SQUARE,
        [circle((0.5, 0), 0.1), polygon([(0.1, 0), (0.2, 0), (0.3, 0)])],
        "hole 2 at .* encloses no area",
        (0.1, 0),
    ),
    "hole outside": (SQUARE, [circle((3, 0), 0.5)], "hole 1 at .* lies outside the outer ring", (3.5, 0)),
    "second hole outside": (SQUARE, [circle((0, 0), 0.5), circle((3, 0), 0.5)], "hole 2 at .* lies outside", (3.5, 0)),
    "hole across the outer ring": (
        SQUARE,
        [rectangle(0.5, -0.25, 1.5, 0.25)],
        "hole 1 crosses the outer ring at",
        (1, -0.25),
    ),
    "hole around the outer ring": (SQUARE, [circle((0, 0), 3)], "hole 1 at .* encloses the outer ring", (3, 0)),
    "hole shares an edge": (
        SQUARE,
        [rectangle(-0.5, -1, 0.5, 0)],
        "hole 1 shares an edge with the outer ring",
        (-0.5, -1),
    ),
    "hole is the outer polygon": (SQUARE, [SQUARE], "hole 1 shares an edge with the outer ring", (-1, -1)),
    "hole is the outer circle": (DISC, [DISC], "hole 1 (crosses|shares an edge with) the outer ring", None),
    "hole shares an arc": (DISC, [PACMAN], "hole 1 (crosses|shares an edge with) the outer ring", None),
    "hole shares an arc with a corner": (PACMAN, [DISC], "hole 1 .* the outer ring", None),
    "holes overlap": (
        SQUARE,
        [rectangle(-0.5, -0.5, 0.1, 0), rectangle(0, -0.4, 0.5, -0.1)],
        "hole 1 and hole 2 overlap at .*join them",
        (0.1, -0.4),
    ),
    "round holes overlap": (
        SQUARE,
        [circle((0.8, 0.8), 0.1), circle((-0.2, 0), 0.3), circle((0.2, 0), 0.3)],
        "hole 2 and hole 3 overlap at .*join them",
        None,
    ),
    "equal holes": (SQUARE, [circle((0, 0), 0.3)] * 2, "hole . (and hole 2 overlap|lies inside hole .)", None),
    "nested holes": (SQUARE, [circle((0, 0), 0.5), circle((0, 0), 0.25)], "hole 2 lies inside hole 1", (0.25, 0)),
    "nested the other way": (
        SQUARE,
        [circle((0, 0), 0.25), circle((0, 0), 0.5)],
        "hole 1 lies inside hole 2 at .*remove one",
        None,
    ),
    "holes share an edge": (
        SQUARE,
        [rectangle(-0.5, -0.5, 0, 0), rectangle(0, -0.5, 0.5, 0)],
        "hole 1 and hole 2 share an edge at .*join them",
        (0, 0),
    ),
    "domain cut by a hole": (
        SQUARE,
        [polygon([(0, -1), (0.2, -0.5), (0, 1)])],
        "cut the domain in two at .* give each part an outer ring",
        (0, 1),
    ),
    "domain cut by a chain of holes": (
        SQUARE,
        [circle((-0.5, 0), 0.5), circle((0.5, 0), 0.5)],
        "cut the domain in two",
        None,
    ),
    "inscribed circle": (
        polygon([(2, 0), (0, 2), (-2, 0), (0, -2)]),
        [circle((0, 0), np.sqrt(2))],
        "in two|crosses the outer ring",
        None,
    ),
}


def coordinates(message):
    number = r"(-?\d[\d.e+-]*)"
    return [(float(x), float(y)) for x, y in re.findall(rf"\({number}, {number}\)", message)]


@pytest.mark.parametrize(("outer", "holes", "message", "place"), FAULTS.values(), ids=FAULTS)
def test_faulty_rings_are_refused_with_name_and_place(outer, holes, message, place):
    with pytest.raises(GeometryError, match=message) as caught:
        Domain.of(outer, holes)
    (found,) = coordinates(str(caught.value))
    if place is not None:
        assert found == pytest.approx(place, abs=1e-6)
    assert ": " in str(caught.value)  # what to do follows


@pytest.mark.parametrize("scale", [1e15, 1e-12])
@pytest.mark.parametrize("fault", ["bow tie", "points on a line", "hole outside", "hole shares an edge"])
def test_faults_are_found_at_any_scale(fault, scale):
    outer, holes, message, place = FAULTS[fault]

    def scaled(ring):
        if not ring.vertices:
            (arc,) = (side.curve for side in ring.sides)
            return circle(np.multiply(arc.center, scale), arc.radius * scale)
        return polygon(np.multiply(ring.vertices, scale))

    with pytest.raises(GeometryError, match=message) as caught:
        Domain.of(scaled(outer), [scaled(hole) for hole in holes])
    assert coordinates(str(caught.value))[0] == pytest.approx(np.multiply(place, scale), rel=1e-5, abs=1e-6 * scale)


@pytest.mark.parametrize("width", [1e-3, 1e-6, 1e-9])
def test_thin_domains_are_no_lines(width):
    assert Domain.of(rectangle(0, 0, 1, width)).polygon.area == pytest.approx(width)


@pytest.mark.parametrize("aspect", [10, 100, 1000])
def test_flat_ellipses_do_not_cross_themselves(aspect):
    domain = Domain.of(ellipse((1, 2), (1, 1 / aspect), 20))
    assert domain.polygon.area == pytest.approx(np.pi / aspect, rel=1e-2)


def test_rings_are_called_as_the_case_counts_them():
    assert [ring_name(k) for k in range(3)] == ["the outer ring", "hole 1", "hole 2"]


@pytest.mark.parametrize(
    ("step", "text"),
    [
        (0, "hole 2 lies inside hole 1"),
        (0.02, "hole 1 and hole 2 overlap"),
        (0.3, "hole 1 and hole 2 overlap"),
    ],
)
def test_circles_that_overlap_are_refused_without_a_look_for_where_they_touch(step, text, monkeypatch):
    """Such a look takes a quarter of a second for each two of them that are nearly the same."""
    monkeypatch.setattr(bubblemesh.geometry.domain, "split_at_contacts", lambda boundary: pytest.fail("looked for"))
    with pytest.raises(GeometryError, match=text):
        Domain.of(rectangle(0, 0, 9, 9), [circle((1 + step * k, 1), 0.2) for k in range(20)])


def test_holes_of_areas_in_each_other_may_lie_in_each_other():
    """An island in a hole has a hole of its own."""
    island = Area(circle((0, 0), 2), (circle((0, 0), 1),))
    domain = Domain.of_areas([Area(circle((0, 0), 4), (circle((0, 0), 3),)), island])
    assert (domain.piece_count, domain.hole_count) == (2, 2)
