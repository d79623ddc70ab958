"""Places in messages have the digits that a domain's size needs; warnings that repeat are one."""

import numpy as np
import pytest

import bubblemesh
from bubblemesh.case import load_case
from bubblemesh.errors import CaseError
from bubblemesh.geometry import rings
from bubblemesh.messages import once_each, place, tell_places_by, tell_places_of, two_places

SQUARE = np.array([(0.0, 0), (1, 0), (1, 1), (0, 1)])


@pytest.mark.parametrize(
    ("point", "size", "text"),
    [
        ((0.5, -1), 1.0, "(0.5, -1)"),
        ((0.1 + 0.2, -0.0), 1.0, "(0.3, 0)"),
        ((0.3564241234, -0.576405912), 2.0, "(0.356424, -0.576406)"),
        ((500123.456, 4649776.22471), 5e5, "(500123.5, 4649776.2)"),
        ((1.5e-7, 2.00001e-7), 1e-6, "(1.5e-07, 2.00001e-07)"),
        ((123456789.0, 0), 1e10, "(123460000, 0)"),
        ((3e20, -2e20), 1e20, "(3e+20, -2e+20)"),
        ((float("nan"), float("inf")), 1.0, "(nan, inf)"),
    ],
)
def test_a_place_has_no_needless_digits(point, size, text):
    assert place(point, size) == text


@pytest.mark.parametrize("size", [1e-12, 3e-5, 0.02, 1.0, 9.99, 4.2e4, 7e8])
@pytest.mark.parametrize("offset", [0.0, 1.0, 57.3, 1e4])
def test_places_a_millionth_of_the_size_apart_differ(size, offset):
    x = size * (offset + np.linspace(0.1, 0.9, 50))
    assert all(place((a, 0), size) != place((a + 1.01e-6 * size, 0), size) for a in x.tolist())


CASE = "name: large\nspacing: 4e5\ndomain: {outer: {rectangle: [0, 0, 1e6, 1e6]}}\npacking: {effort: fast}\n"
ON_EARTH = """
name: earth
crs: {from: EPSG:4326}
domain: {outer: {polygon: [[3, 52], [3.1, 52], [3.1, 52.1], [3, 52.1]]}}
spacing: 4 km
packing: {effort: fast}
"""
CALLS = {
    "a domain": lambda: bubblemesh.Domain.of(rings.rectangle(0, 0, 1e6, 1e6)),
    "a mesh": lambda: bubblemesh.mesh([(0, 0), (1e6, 0), (1e6, 1e6)], 5e5, effort="fast"),
    "a case": lambda: bubblemesh.mesh_case(load_case("large.yaml", text=CASE)),
    "a case on the earth": lambda: bubblemesh.mesh_case(load_case("earth.yaml", text=ON_EARTH)),
    "a solution": lambda: bubblemesh.adapt(load_case("large.yaml", text=CASE), SOLUTION, nodes=20),
}
SOLUTION = bubblemesh.Solution.of(1e6 * SQUARE[:, :2], [(0, 1, 2), (0, 2, 3)], SQUARE[:, 0])


@pytest.mark.parametrize("call", CALLS)
def test_messages_after_a_call_have_nothing_of_its_domain(call):
    if "earth" in call:
        pytest.importorskip("pyproj")
    CALLS[call]()
    with pytest.raises(CaseError, match=r"not a number at node 1 \(counted from 0\), at \(0\.3, 0\.1\)"):
        bubblemesh.Solution.of([(0, 0), (0.3, 0.1), (1, 1)], [(0, 1, 2)], [1, np.nan, 2])


def test_without_a_size_a_place_is_told_by_its_own_numbers():
    tell_places_of(None)
    assert place((500123.456789, 4649776.22471)) == "(500123.457, 4649776.225)"
    assert place((0, 0)) == "(0, 0)"


@pytest.mark.parametrize(
    ("first", "second", "texts"),
    [
        ((0.5, 1), (0.5, 2), ("(0.5, 1)", "(0.5, 2)")),
        ((0.5, 0.5), (0.5, 0.50000001), ("(0.5, 0.5)", "(0.5, 0.50000001)")),
        ((0.2, 1e-7), (0.2, 0), ("(0.2, 0.0000001)", "(0.2, 0)")),
        ((0.1, 1), (0.1, 1 + 2**-52), ("(0.1, 1)", "(0.1, 1.0000000000000002)")),
        ((0.123456789, 0), (0.123456789, 0), ("(0.123457, 0)", "(0.123457, 0)")),
    ],
)
def test_two_places_have_the_digits_that_tell_them_apart(first, second, texts):
    tell_places_of(1.0)
    assert two_places(first, second) == texts


def test_two_places_on_the_earth_have_the_digits_that_tell_them_apart():
    tell_places_by(lambda point: (point[0] / 1e5, point[1] / 1e5))
    assert two_places((1234567, 0), (1234567.1, 0)) == ("(12.34567, 0)", "(12.345671, 0)")


def test_warnings_that_differ_in_numbers_only_are_one_with_a_count():
    told = ["a.svg: duplicate point (1, 2) merged", "b", "a.svg: duplicate point (-3.5e-7, 2.5) merged", "b", "c 1"]
    assert once_each(told) == (
        "a.svg: duplicate point (1, 2) merged (and 1 more like it)",
        "b (and 1 more like it)",
        "c 1",
    )


def test_of_warnings_on_gaps_the_widest_is_told():
    told = [f"a.dxf: {count} gaps joined, the widest ({gap}) at (1, {gap})" for count, gap in ((4, 1e-4), (2, 0.002))]
    assert once_each([told[0], "b", told[1]]) == (f"{told[1]} (and 1 more like it)", "b")


@pytest.mark.parametrize("label", ["the widest (x)", "the widest (1e)", "the widest gap (nan)"])
def test_names_that_look_like_gaps_are_none(label):
    assert once_each([f"line '{label}' 1", f"line '{label}' 2"]) == (f"line '{label}' 1 (and 1 more like it)",)


def test_names_of_warnings_that_are_one_are_listed():
    told = [f"'hole-{number}' has {number} sides, and 'inlet' is {number} long" for number in (1, 2, 2, 3)]
    assert once_each(told) == (f"{told[0]} (and 3 more like it: 'hole-2', 'hole-3')",)
    assert once_each(["the ring's 1 and its hole's 2", "the ring's 3 and its hole's 4"]) == (
        "the ring's 1 and its hole's 2 (and 1 more like it)",
    )
