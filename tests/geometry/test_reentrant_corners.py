import re

import numpy as np
import pytest
import shapely
from partitions import domain_of

from bubblemesh.geometry.narrow_parts import FacingWalls, reentrant_corners
from bubblemesh.problem.warnings import narrow_parts, sharp_angles
from bubblemesh.spacing.spacing import Spacing

UNIT = "domain: {outer: {rectangle: [0, 0, 1, 1]}, "


def uniform(d):
    return Spacing(lambda x, y: np.full(x.shape, float(d)))


def lines(*points):
    return f"lines: [{', '.join(f'{{path: {[list(p) for p in line]}}}' for line in points)}]}}"


def disc(name, x, y, radius):
    return f"{{name: {name}, ring: {{circle: {{center: [{x}, {y}], radius: {radius}}}}}}}"


def width_and_place(warning):
    number = r"(-?[\d.e-]+)"
    width, *place = re.search(rf"a strip of {number} at \({number}, {number}\)", warning).groups()
    return float(width), [float(value) for value in place]


HORIZONTAL = [(0.2, 0.5), (0.8, 0.5)]
NARROW = {
    "line along a wall": (lines([(0.2, 0.03), (0.8, 0.03)]), 0.03, None),
    "line that ends before a wall": (lines([(0.5, 0.03), (0.5, 0.5)]), 0.03, (0.5, 0.03)),
    "lines side by side": (lines(HORIZONTAL, [(0.3, 0.53), (0.7, 0.53)]), 0.03, None),
    "line that ends before a line": (lines(HORIZONTAL, [(0.5, 0.53), (0.5, 0.9)]), 0.03, (0.5, 0.53)),
    "regions with a gap": (
        "regions: [{name: a, ring: {rectangle: [0, 0, 1, 0.5]}}, {name: b, ring: {rectangle: [0, 0.53, 1, 1]}}]}",
        0.03,
        None,
    ),
    "round regions": (f"regions: [{disc('a', 0.3, 0.5, 0.19)}, {disc('b', 0.7, 0.5, 0.19)}]}}", 0.02, (0.5, 0.5)),
    "round region beside a wall": (f"regions: [{disc('a', 0.5, 0.22, 0.2)}]}}", 0.02, (0.5, 0.02)),
    "round region beside a hole": (
        f"holes: [{{circle: {{center: [0.3, 0.5], radius: 0.19}}}}], regions: [{disc('b', 0.7, 0.5, 0.19)}]}}",
        0.02,
        (0.51, 0.5),
    ),
    "ring around a region": (f"regions: [{disc('a', 0.5, 0.5, 0.3)}, {disc('b', 0.5, 0.5, 0.27)}]}}", 0.03, None),
    "points": ("points: [{at: [0.5, 0.5]}, {at: [0.5, 0.53]}]}", 0.03, None),
    "point beside a wall": ("points: [{at: [0.97, 0.4]}]}", 0.03, (0.97, 0.4)),
    "point beside a line": ("points: [{at: [0.5, 0.53]}], " + lines(HORIZONTAL), 0.03, (0.5, 0.53)),
}


@pytest.mark.long
@pytest.mark.parametrize(("text", "width", "place"), NARROW.values(), ids=NARROW)
def test_what_leaves_a_narrow_strip_is_told_with_its_width_and_place(text, width, place):
    domain = domain_of(UNIT + text)
    (warning,) = narrow_parts(FacingWalls(domain), uniform(0.1), None, None)
    assert warning.startswith("what is inside the domain leaves a strip of 0.0")
    found, at = width_and_place(warning)
    assert found == pytest.approx(width, rel=0.05)
    assert "narrower than the spacing there (0.1)" in warning
    if place is not None:
        assert np.hypot(*np.subtract(at, place)) < 0.035
    assert narrow_parts(FacingWalls(domain), uniform(0.95 * width), None, None) == []


WIDE = {
    "nothing inside": "}",
    "crossing lines": lines(HORIZONTAL, [(0.5, 0.2), (0.5, 0.9)]),
    "line from the wall": lines([(0.5, 0), (0.5, 0.5)]),
    "zigzag": lines([(0.1 + 0.1 * k, 0.5 + 0.04 * (k % 2)) for k in range(9)]),
    "T of regions": "regions: [{name: a, ring: {rectangle: [0, 0, 1, 0.5]}}, "
    "{name: b, ring: {rectangle: [0, 0.5, 0.5, 1]}}]}",
    "touching discs": f"regions: [{disc('a', 0.3, 0.5, 0.2)}, {disc('b', 0.7, 0.5, 0.2)}]}}",
    "point on a line": "points: [{at: [0.5, 0.5]}], " + lines(HORIZONTAL),
    "point at a vertex": "points: [{at: [0, 0]}, {at: [0.5, 0]}]}",
    "small disc": f"regions: [{disc('a', 0.5, 0.5, 0.06)}]}}",
}


@pytest.mark.long
@pytest.mark.parametrize("text", WIDE.values(), ids=WIDE)
def test_no_false_alarm(text):
    assert narrow_parts(FacingWalls(domain_of(UNIT + text)), uniform(0.1), None, None) == []


@pytest.mark.long
@pytest.mark.parametrize("seed", range(20))
def test_the_width_is_the_least_distance_of_all(seed):
    """By every pair: two segments that do not cross are nearest to each other at an end of one of them."""
    rng = np.random.default_rng(seed)
    made = [shapely.box(0, 0, 1, 1).exterior]
    while len(made) < 6:
        segment = shapely.LineString(0.02 + 0.96 * rng.random((2, 2)))
        if not shapely.crosses(segment, made).any():
            made.append(segment)
    points = rng.random((2, 2))
    text = f"points: [{', '.join(f'{{at: {p}}}' for p in points.tolist())}], "
    domain = domain_of(UNIT + text + lines(*(one.coords for one in made[1:])))
    made += [shapely.Point(p) for p in points]
    least = min(shapely.distance(a, b) for k, a in enumerate(made) for b in made[:k])
    (warning,) = narrow_parts(FacingWalls(domain), uniform(2 * least), None, None)
    assert width_and_place(warning)[0] == pytest.approx(least, rel=1e-2)


@pytest.mark.long
def test_tips_are_ends_and_sharp_bends_and_points():
    text = (
        "points: [{at: [0.5, 0.9]}, {at: [1, 0.5]}], "
        "holes: [{polygon: [[0.7, 0.7], [0.8, 0.7], [0.9, 0.8], [0.8, 0.8]]}], "
        + lines([(0.5, 0), (0.5, 0.5)], [(0.1, 0.1), (0.2, 0.2), (0.3, 0.2), (0.1, 0.3)])
    )
    domain = domain_of(UNIT + text)
    found = reentrant_corners(domain)
    assert sorted(map(tuple, domain.boundary.corners[found.corner].tolist())) == [
        (0.1, 0.1),
        (0.1, 0.3),
        (0.3, 0.2),
        (0.5, 0.5),
        (0.5, 0.9),
        (0.7, 0.7),
        (0.9, 0.8),
    ]


@pytest.mark.long
@pytest.mark.parametrize("turn", range(0, 360, 30))
@pytest.mark.parametrize("degrees", [1, 3, 4.9, 5.1, 30])
def test_sharp_angles_between_lines_are_told_whatever_their_directions(degrees, turn):
    a, b = np.radians([turn, turn + degrees])
    ends = [(0.5 + 0.4 * np.cos(t), 0.5 + 0.4 * np.sin(t)) for t in (a, b)]
    for one, other in ((0, 1), (1, 0)):
        at = (0.5, 0.5)
        domain = domain_of(UNIT + lines([at, tuple(map(float, ends[one]))], [tuple(map(float, ends[other])), at]))
        warnings = sharp_angles(domain)
        assert len(warnings) == (degrees < 5)
        assert all(f"the angle at (0.5, 0.5) is {degrees:.2g} degrees" in warning for warning in warnings)


def test_of_many_sharp_angles_the_worst_are_told():
    teeth = [(0.01 * k, 0.1 if k % 2 else 0.9) for k in range(1, 20)]
    (warning,) = sharp_angles(domain_of(UNIT + lines(teeth)))
    assert warning.startswith("17 angles of the domain are below 5 degrees, the sharpest are ")
    assert warning.count(" degrees at ") == 5


@pytest.mark.long
def test_the_nearest_thing_ahead_of_a_tip_is_found():
    text = "holes: [{rectangle: [0.4, 0.6, 0.6, 0.61]}], " + lines([(0.5, 0.2), (0.5, 0.5)])
    domain = domain_of(UNIT + text)
    walls, found = FacingWalls(domain), reentrant_corners(domain)
    gaps = walls.facing_corners(found, np.full(len(found.corner), 0.25))
    places, feet = (map(tuple, ends.tolist()) for ends in (gaps.places, gaps.feet))
    seen = dict(zip(places, zip(feet, gaps.widths, gaps.inner, strict=True), strict=True))
    assert seen[0.5, 0.5] == ((0.5, 0.6), pytest.approx(0.1), True)
    assert seen[0.5, 0.2] == ((0.5, 0), pytest.approx(0.2), True)
    # The other side of the hole is near as well, but not within the domain.
    assert seen[0.4, 0.6] == ((0.5, 0.5), pytest.approx(0.1 * np.sqrt(2)), True)
    assert (0.4, 0.61) not in seen


@pytest.mark.long
def test_tips_do_not_see_the_lines_that_they_belong_to():
    """However short the pieces of a line are: what follows it is behind its end."""
    angle = np.linspace(0, np.pi / 2, 60)
    arc = [(0.2 + 0.5 * float(np.sin(a)), 0.2 + 0.5 * float(1 - np.cos(a))) for a in angle]
    domain = domain_of(UNIT + lines(arc))
    found = reentrant_corners(domain)
    assert len(found.corner) == 2
    assert len(FacingWalls(domain).facing_corners(found, np.full(2, 0.19)).widths) == 0
