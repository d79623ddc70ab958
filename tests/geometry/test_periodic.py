import numpy as np
import pytest
from partitions import MOONS, check_net, domain_of, packed

import bubblemesh
from bubblemesh.case import load_case
from bubblemesh.errors import BubblemeshError, CaseError, GeometryError
from bubblemesh.geometry.periodic import counterparts
from bubblemesh.problem.prepare import prepare

SQUARE = "domain:\n  outer: {rectangle: [0, 0, 2, 1], labels: [bottom, right, top, left]}\n"
WAVES = """
domain:
  outer:
    path:
      - [0, 0]
      - {to: [2, 0], label: bottom}
      - {spline: {through: [[2.2, 0.3], [1.9, 0.7], [2, 1]]}, label: right}
      - {to: [0, 1], label: top}
      - {spline: {through: [[-0.1, 0.7], [0.2, 0.3], [0, 0]]}, label: left}
"""
DISCS = """  regions:
    - {name: a, ring: {circle: {center: [1, 0.5], radius: 0.3}}}
    - {name: b, ring: {circle: {center: [0, 0.5], radius: 0.2}}}
    - {name: c, ring: {circle: {center: [2, 0.5], radius: 0.2}}}
"""


def on_side(domain, net, label):
    """Nodes (k, 2) on the sides of a label."""
    b = domain.boundary
    mine = [b.labels[k] == label for k in b.label[net.facet_piece]]
    return net.bubbles.x[np.unique(net.facets[mine])]


def check_match(domain, net, pairs):
    """Fail unless the nodes of each pair of sides are the same but for a shift."""
    for first, second, shift in pairs:
        here, there = on_side(domain, net, first) + shift, on_side(domain, net, second)
        assert len(here) == len(there)
        gaps = np.hypot(*(here[:, None] - there[None]).transpose(2, 0, 1))
        assert gaps.min(axis=0).max() < 1e-14 * 8
        assert gaps.min(axis=1).max() < 1e-14 * 8


LEFT_RIGHT, BOTTOM_TOP = ("left", "right", (2, 0)), ("bottom", "top", (0, 1))


@pytest.mark.long
@pytest.mark.parametrize("spacing", ["0.1", "'0.05 + 0.05*x'"])
@pytest.mark.parametrize(
    ("text", "pairs"),
    [
        pytest.param(SQUARE, [LEFT_RIGHT], id="straight"),
        pytest.param(SQUARE, [LEFT_RIGHT, BOTTOM_TOP], id="two directions"),
        pytest.param(SQUARE + DISCS, [LEFT_RIGHT, BOTTOM_TOP], id="regions on the sides"),
        pytest.param("domain:" + MOONS, [LEFT_RIGHT, BOTTOM_TOP], id="arcs"),
        pytest.param(WAVES, [LEFT_RIGHT, BOTTOM_TOP], id="splines"),
        pytest.param(
            SQUARE + "  lines:\n    - {path: [[0.4, 0.5], [2, 0.7]]}\n    - {path: [[0, 0.7], [0.2, 0.6]]}\n",
            [LEFT_RIGHT],
            id="lines end at the sides",
        ),
        pytest.param(
            "domain:" + MOONS + "  holes:\n    - {circle: {center: [0.82, 0.5], radius: 0.3}}\n",
            [LEFT_RIGHT],
            id="narrow beside one",
        ),
    ],
)
def test_nodes_of_periodic_sides_match(text, pairs, spacing):
    sides = ", ".join(f"[{first}, {second}]" for first, second, _ in pairs)
    domain, net = packed(f"{text}  periodic: [{sides}]\nspacing: {spacing}\n")
    check_match(domain, net, pairs)
    check_net(domain, net)


@pytest.mark.long
def test_the_finer_side_decides():
    domain, net = packed(SQUARE + "  periodic: [[left, right]]\nspacing: '0.05 + 0.05*x'\n")
    assert len(on_side(domain, net, "right")) == 21


@pytest.mark.parametrize(
    ("text", "pairs", "message"),
    [
        (SQUARE, "[left, rigth]", "there is no side 'rigth': did you mean 'right'"),
        (SQUARE, "[left, left]", "the side 'left' is named twice"),
        (SQUARE, "[left, right], [right, top]", "the side 'right' is named twice"),
        (SQUARE, "[left, bottom]", r"'left' and 'bottom': what is at \(0, 0\.5\) has no counterpart"),
        (
            SQUARE + "  lines: [{path: [[0, 0.3], [0.5, 0.3]]}]\n",
            "[left, right]",
            r"'left' and 'right': what is at \(0, 0\.3\) has no counterpart at \(2, 0\.3\)",
        ),
        (
            WAVES.replace("-0.1, 0.7", "-0.1, 0.72"),
            "[left, right]",
            r"'left' and 'right': what is at \(.*\) has no counterpart at \(.*\)",
        ),
        (
            SQUARE.replace("[0, 0, 2, 1]", "[0, 0, 2, 1]")
            + DISCS.replace("[2, 0.5], radius: 0.2", "[2, 0.5], radius: 0.21"),
            "[left, right]",
            "no counterpart",
        ),
        (
            "domain:\n  outer: {polygon: [[0, 0], [2, 0], [2, 1], [0, 2]], labels: [bottom, right, top, left]}\n",
            "[left, right]",
            "no counterpart",
        ),
        (
            SQUARE + "  holes:\n    - {circle: {center: [1, 0.5], radius: 0.1}, label: bore}\n",
            "[bore, left]",
            "there is no side 'bore'",
        ),
    ],
)
def test_sides_that_do_not_match_are_named(text, pairs, message):
    with pytest.raises(GeometryError, match=message):
        domain_of(f"{text}  periodic: [{pairs}]")


SECTOR = """
parameters: {a: pi/6, r: 0.15}
domain:
  outer:
    path:
      - [1, 0]
      - {to: [2, 0], label: right}
      - {arc: {to: [2*cos(a), 2*sin(a)], center: [0, 0], turn: left}, label: yoke}
      - {to: [cos(a), sin(a)], label: left}
      - {arc: {to: [1, 0], center: [0, 0], turn: right}, label: shaft}
"""
COILS = """  regions:
    - {name: coil, ring: {circle: {center: [1.5, 0], radius: 0.15}}}
    - {name: next, ring: {circle: {center: [1.5*cos(a), 1.5*sin(a)], radius: r}}}
"""
NOT_RIGHT = "both sides need the same shape and the same vertices, moved or turned"


@pytest.mark.parametrize("pair", ["[right, left]", "[left, right]"])
def test_a_side_may_be_the_other_one_turned(pair):
    domain = domain_of(f"{SECTOR}{COILS}  periodic: [{pair}]")
    boundary, (here, there) = domain.boundary, domain.periodic.T
    assert len(here) == 3
    turn = np.pi / 6 if pair == "[right, left]" else -np.pi / 6
    np.testing.assert_allclose(domain.turn[here], turn, atol=1e-15)
    np.testing.assert_allclose(domain.turn[there], -turn, atol=1e-15)
    radius = [np.hypot(*boundary.points(side, boundary.lengths[side] / 2).T) for side in (here, there)]
    np.testing.assert_allclose(*radius, atol=1e-12)
    others = np.delete(domain.turn, domain.periodic.ravel())
    assert len(others) > 3
    assert not others.any()


def test_sides_that_are_shifted_are_not_turned():
    assert not domain_of(WAVES + "  periodic: [[left, right], [bottom, top]]\n").turn.any()
    slanted = SQUARE.replace("rectangle: [0, 0, 2, 1]", "polygon: [[0, 0], [2, 0.3], [2.4, 1.1], [0.4, 0.8]]")
    assert not domain_of(slanted + "  periodic: [[left, right], [bottom, top]]\n").turn.any()


NOTCHED = """
parameters: {c: cos(pi/6), s: sin(pi/6)}
domain:
  outer:
    path:
      - [1, 0]
      - {to: [1.4, 0], label: right}
      - [1.4, 0.1]
      - [1.6, 0.1]
      - {to: [1.6, 0], label: notch}
      - {to: [2, 0], label: right}
      - {to: [2*c, 2*s], label: yoke}
      - {to: [1.6*c, 1.6*s], label: left}
      - [1.6*c + 0.1*s, 1.6*s - 0.1*c]
      - [1.4*c + 0.1*s, 1.4*s - 0.1*c]
      - {to: [1.4*c, 1.4*s], label: notch}
      - {to: [c, s], label: left}
      - {to: [1, 0], label: shaft}
  periodic: [[right, left]]
"""


def test_sides_of_several_lines_are_turned_as_one():
    domain = domain_of(NOTCHED)
    assert len(domain.periodic) == 2
    np.testing.assert_allclose(domain.turn[domain.periodic], [[np.pi / 6, -np.pi / 6]] * 2, atol=1e-15)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (SECTOR + COILS.replace("radius: r", "radius: 0.16"), r"what is at \(1\.35, 0\) .* at \(1\.16913\d, 0\.675\)"),
        (
            SECTOR.replace("{to: [2, 0], label", "{spline: {through: [[1.5, 0.1], [2, 0]]}, label").replace(
                "{to: [cos(a), sin(a)], label",
                "{spline: {through: [[1.5*cos(a)+0.1*sin(a), 1.5*sin(a)-0.1*cos(a)], [cos(a), sin(a)]]}, label",
            ),
            "no counterpart",
        ),
    ],
    ids=["another vertex", "mirrored"],
)
def test_sides_that_do_not_match_when_turned_are_told(text, message):
    with pytest.raises(GeometryError, match=rf"'right' and 'left': .*{message}") as caught:
        domain_of(text + "  periodic: [[right, left]]")
    assert str(caught.value).endswith(NOT_RIGHT)


def test_the_published_methods_have_no_periodic_sides():
    text = SQUARE + "  periodic: [[left, right]]\nspacing: 0.1\n"
    with pytest.raises(CaseError, match=r"domain\.periodic"):
        prepare(load_case("square.yaml", text=text, method="accelerated"))


def test_counterparts_are_as_far_across_the_domain_as_the_sides():
    domain = domain_of(WAVES + "  periodic: [[left, right], [bottom, top]]\n")
    piece = np.repeat(np.arange(4), 3)
    s = np.tile([0.0, 0.3, 0.7], 4)
    places, other, at = counterparts(domain.boundary, domain.periodic, piece, s)
    assert sorted(places) == list(range(12))
    shift = domain.boundary.points(other, at) - domain.boundary.points(piece[places], s[places])
    np.testing.assert_allclose(np.abs(shift), np.where(places[:, None] // 3 % 2 == 0, (0, 1), (2, 0)), atol=1e-12)


ROUNDED = """
domain:
  outer:
    path:
      - [10, 0]
      - {to: [90, 0], label: right}
      - {arc: {to: [63.6396, 63.6396], center: [0, 0], turn: left}, label: yoke}
      - {to: [7.0711, 7.0711], label: left}
      - {to: [10, 0], label: shaft}
"""
PAIR = "  periodic: [[right, left]]\n"


def test_sides_of_few_digits_tell_by_how_much_they_differ_and_what_makes_them_match():
    told = r"they differ by up to \S+, and 1e-09 of the size of the domain is allowed, \S+: periodic_tolerance: \S+ in"
    with pytest.raises(GeometryError, match=told) as caught:
        domain_of(ROUNDED + PAIR)
    advised = str(caught.value).split("periodic_tolerance: ")[1].split()[0]
    assert len(domain_of(f"{ROUNDED}{PAIR}  periodic_tolerance: {advised}").periodic) == 1


BENT = """
domain:
  outer:
    path:
      - [0, 0]
      - {to: [2, 0], label: bottom}
      - {spline: {through: [[2.20001, 0.3], [1.9, 0.70001], [2, 1.00001]]}, label: right}
      - {to: [0, 1], label: top}
      - {spline: {through: [[-0.1, 0.7], [0.2, 0.3], [0, 0]]}, label: left}
"""
LAYERED = """
domain:
  outer:
    path:
      - [0, 0]
      - {to: [2, 0], label: bottom}
      - {to: [2, 0.40001], label: right}
      - {to: [2.00001, 1], label: right}
      - {to: [0, 1], label: top}
      - {to: [0, 0.4], label: left}
      - {to: [0, 0], label: left}
  regions: [{name: low, ring: {polygon: [[0, 0], [2, 0], [2, 0.40001], [0, 0.4]]}}]
"""
WEDGE = """
domain:
  outer:
    path:
      - [0, 0]
      - {to: [90, 0], label: right}
      - {to: [63.6396, 63.6396], label: yoke}
      - {to: [0, 0], label: left}
"""
TO_THE_RIGHT = "  periodic: [[left, right]]\n"
BOTH_WAYS = "  periodic: [[left, right], [bottom, top]]\n"
CELL = """
domain:
  outer: {polygon: [[0, 0], [1, 0], [1.00001, 1], [0, 0.99999]], labels: [bottom, right, top, left]}
"""


@pytest.mark.parametrize(
    ("text", "farthest"),
    [
        pytest.param(ROUNDED + PAIR, 1e-4, id="turned"),
        pytest.param(WEDGE + PAIR, 1e-4, id="wedge"),
        pytest.param(BENT + TO_THE_RIGHT, 2e-5, id="splines"),
        pytest.param(LAYERED + TO_THE_RIGHT, 2e-5, id="a region meets the sides"),
        pytest.param(CELL + BOTH_WAYS, 2e-5, id="two directions"),
    ],
)
def test_within_the_tolerance_the_second_side_becomes_the_first_one_moved(text, farthest):
    with pytest.raises(GeometryError, match="periodic_tolerance"):
        _ = domain_of(text).periodic
    domain = domain_of(f"{text}  periodic_tolerance: 1e-3\n")
    b, (motion, *_) = domain.boundary, domain.motions
    for here, there in domain.periodic[: (b.label == b.labels.index(domain.parts.periodic[0][0])).sum()]:
        pieces, share = np.array([[here] * 5, [there] * 5]), np.linspace(0, 1, 5)
        first, second = (
            b.points(piece, s * b.lengths[piece]) for piece, s in zip(pieces, (share, 1 - share), strict=True)
        )
        assert np.abs(motion.points(first) - second).max() < 1e-13 * domain.size
    (note,) = (note for note in domain.notes if "moved onto counterparts" in note)
    assert float(note.split("by up to ")[1].split()[0]) <= farthest


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (ROUNDED + PAIR + "  periodic_tolerance: 40", "40 is too much for the side 'right', of which one piece"),
        (ROUNDED + PAIR + "  periodic_tolerance: 1e-6", r"moved or turned$"),
        (ROUNDED.replace("7.0711, 7.0711", "7.0711, 7.3") + PAIR, r"moved or turned$"),
    ],
)
def test_a_tolerance_that_does_harm_or_is_not_enough_is_refused(text, message):
    with pytest.raises(GeometryError, match=message):
        _ = domain_of(text).periodic


NEARLY_SQUARE = [(0, 0), (1, 0), (1, 1.00001), (0, 1)]
NAMED = {"left": [(0, 0), (0, 1)], "right": [(1, 0), (1, 1.00001)]}


def test_programs_have_periodic_sides_and_their_tolerance():
    mesh = bubblemesh.mesh(
        [(0, 0), (1, 0), (1, 1), (0, 1)], 0.5, lines={"a": NAMED["left"], "b": [(1, 0), (1, 1)]}, periodic=[("a", "b")]
    )
    assert mesh.periodic_sides[0].motion[:, 2].tolist() == [1, 0]
    options = {"lines": NAMED, "periodic": [("left", "right")]}
    with pytest.raises(GeometryError, match="periodic_tolerance: "):
        bubblemesh.mesh(NEARLY_SQUARE, 0.5, **options)
    with pytest.warns(bubblemesh.MeshWarning, match="moved onto counterparts"):
        assert len(bubblemesh.mesh(NEARLY_SQUARE, 0.5, **options, periodic_tolerance=1e-3).periodic_sides) == 1


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"periodic": ["ab"]}, "periodic: must be pairs of labels"),
        ({"periodic": [("a", "b", "c")]}, "periodic: must be pairs of labels"),
        ({"periodic_tolerance": -1}, "periodic_tolerance: must be a length"),
    ],
)
def test_wrong_arguments_of_programs_are_named(options, message):
    with pytest.raises(CaseError, match=message):
        bubblemesh.mesh(NEARLY_SQUARE, 0.5, **options)


@pytest.mark.parametrize(
    ("periodic", "method", "told"),
    [
        (("a", "a"), "multilevel", "periodic: the side 'a' is named twice: each side has one counterpart"),
        (("a", "b"), "bpm", "periodic: bubbles would slide along the sides: use relaxation: connected, or multilevel"),
    ],
)
def test_a_call_names_its_argument_once(periodic, method, told):
    lines = {"a": [(0, 0), (0, 1)], "b": [(1, 0), (1, 1)]}
    with pytest.raises(BubblemeshError) as caught:
        bubblemesh.mesh([(0, 0), (1, 0), (1, 1), (0, 1)], 0.5, lines=lines, periodic=[periodic], method=method)
    assert str(caught.value) == f"mesh(): {told}"
