"""One curve given in several ways is one piece between any two of its corners."""

from collections import Counter

import numpy as np
import pytest
from partitions import check_pieces, domain_of

from bubblemesh.errors import BubblemeshError

UNIT = "outer: {rectangle: [0, 0, 1, 1], label: wall}"
DISC = "circle: {center: [0.5, 0.5], radius: 0.3}"
ELLIPSE = "ellipse: {center: [0.5, 0.5], radii: [0.3, 0.3], angle: 20}"
ROUND = 0.6 * np.pi


def on_circle(angle):
    return [float(0.5 + 0.3 * np.cos(angle)), float(0.5 + 0.3 * np.sin(angle))]


def arcs(angles, turn="left"):
    """Path along the same circle through its points at ``angles``."""
    parts = [f"{{arc: {{to: {on_circle(a)}, center: [0.5, 0.5], turn: {turn}}}}}" for a in angles[1:]]
    return f"path: [{on_circle(angles[0])}, {', '.join(parts)}]"


def parted(count, start, turn="left", total=2 * np.pi):
    """Angles of ``count`` arcs that make up ``total``."""
    return start + (1 if turn == "left" else -1) * total * np.arange(count + 1) / count


def lengths(domain):
    """Total length of the pieces with each label but the wall's."""
    check_pieces(domain)
    b, result = domain.boundary, Counter()
    for k in range(len(b.kind)):
        result[b.labels[b.label[k]]] += float(b.lengths[k])
    result.pop("wall", None)
    return {name: pytest.approx(length, abs=1e-8) for name, length in result.items()}


@pytest.mark.long
@pytest.mark.parametrize("turn", ["left", "right"])
@pytest.mark.parametrize("count", [2, 3, 7])
@pytest.mark.parametrize("start", [0.0, 0.4, 3.0])
@pytest.mark.parametrize("shape", [DISC, ELLIPSE])
def test_a_circle_and_arcs_along_it(shape, start, count, turn):
    wire = arcs(parted(count, start, turn), turn)
    domain = domain_of(f"domain: {{{UNIT}, regions: [{{name: a, ring: {{{shape}}}}}], lines: [{{{wire}, label: w}}]}}")
    assert lengths(domain) == {"w": ROUND}
    assert domain.boundary.inner.sum() == count


def test_arcs_that_follow_a_part_of_a_circle():
    wire = arcs(parted(3, 0.2, total=2.0))
    domain = domain_of(f"domain: {{{UNIT}, regions: [{{name: a, ring: {{{DISC}}}}}], lines: [{{{wire}, label: w}}]}}")
    assert lengths(domain) == {"w": 0.6, "a-rim": ROUND - 0.6}
    assert domain.boundary.inner.sum() == 4


def test_arcs_that_are_parted_at_other_places():
    one, other = arcs(parted(5, 0.1)), arcs(parted(3, 1.7, "right"), "right")
    domain = domain_of(f"domain: {{{UNIT}, regions: [{{name: a, ring: {{{one}}}}}], lines: [{{{other}, label: w}}]}}")
    assert lengths(domain) == {"w": ROUND}
    assert domain.boundary.inner.sum() == 8


@pytest.mark.parametrize("start", [0, 3, 19])
def test_straight_lines_that_follow_a_part_of_a_polyline(start):
    ring = [on_circle(angle) for angle in 2 * np.pi * np.arange(20) / 20]
    middle = np.mean([ring[start], ring[start - 1]], axis=0).tolist()
    wire = [middle, ring[start], ring[(start + 1) % 20]]
    domain = domain_of(f"domain: {{outer: {{polygon: {ring}, corners: 30}}, lines: [{{path: {wire}, label: w}}]}}")
    assert lengths(domain)["w"] == 1.5 * 0.6 * np.sin(np.pi / 20)


@pytest.mark.parametrize("hole", [DISC, arcs(parted(2, 0.0)), arcs(parted(3, 1.0))])
def test_a_region_beside_half_of_a_hole_has_the_hole_s_pieces(hole):
    half = (
        "path: [[0.8, 0.5], [0.9, 0.5], {arc: {to: [0.1, 0.5], center: [0.5, 0.5], turn: left}}, [0.2, 0.5], "
        "{arc: {to: [0.8, 0.5], center: [0.5, 0.5], turn: right}}]"
    )
    domain = domain_of(f"domain: {{{UNIT}, holes: [{{{hole}, label: h}}], regions: [{{name: a, ring: {{{half}}}}}]}}")
    assert lengths(domain) == {"h": ROUND, "a-rim": 0.2 + 0.4 * np.pi}


@pytest.mark.parametrize("outer", [DISC, arcs(parted(4, 0.3))])
@pytest.mark.parametrize("ring", [DISC, arcs(parted(2, 1.0)), ELLIPSE])
def test_a_region_that_is_the_whole_domain_adds_no_piece(outer, ring):
    domain = domain_of(f"domain: {{outer: {{{outer}, label: rim}}, regions: [{{name: a, ring: {{{ring}}}}}]}}")
    assert lengths(domain) == {"rim": ROUND}
    assert set(domain.boundary.left.tolist()) == {1}


THROUGH = [[0.2, 0.2], [0.5, 0.3], [0.8, 0.2]]


@pytest.mark.parametrize("back", [False, True])
def test_a_spline_that_two_regions_share(back):
    first, *rest = THROUGH[::-1] if back else THROUGH
    above = f"path: [[0.2, 0.2], {{spline: {{through: {THROUGH[1:]}}}}}, [0.8, 0.8], [0.2, 0.8]]"
    below = f"path: [{first}, {{spline: {{through: {rest}}}}}, [0.5, 0.05]]"
    alone = domain_of(f"domain: {{{UNIT}, regions: [{{name: a, ring: {{{above}}}}}]}}")
    both = domain_of(f"domain: {{{UNIT}, regions: [{{name: a, ring: {{{above}}}}}, {{name: b, ring: {{{below}}}}}]}}")
    assert lengths(both) == lengths(alone) | {"b-rim": 2 * np.hypot(0.3, 0.15)}
    assert both.boundary.inner.sum() == 6


def test_a_domain_without_any_corner_may_have_regions():
    domain = domain_of(
        f"domain: {{outer: {{{DISC}, label: rim}}, "
        "regions: [{name: a, ring: {circle: {center: [0.5, 0.5], radius: 0.1}}}]}"
    )
    assert lengths(domain) == {"rim": ROUND, "a-rim": 0.2 * np.pi}
    assert len(domain.boundary.corners) == 0


STEPS = [(9, 5), (5, 5), (5, 4), (4, 4), (4, 3), (0, 3)]


def stairs(steps):
    """Two regions with no corners, one on each side of steps: one of the given ones, the other one of STEPS."""
    one, other = [[0, 0], [9, 0], *map(list, STEPS)], [*map(list, steps[::-1]), [9, 8], [0, 8]]
    rings = [f"{{polygon: {ring}, corners: 91}}" for ring in (one, other)]
    regions = ", ".join(f"{{name: {name}, ring: {ring}}}" for name, ring in zip("ab", rings, strict=True))
    return domain_of(f"domain: {{outer: {{rectangle: [-1, -1, 10, 9]}}, regions: [{regions}]}}")


def test_regions_share_borders_with_kinks_that_are_no_corners():
    """As those of pixels: polylines that two rings follow, one in each direction."""
    domain = stairs(STEPS)
    check_pieces(domain)
    b = domain.boundary
    assert b.lengths[b.inner].sum() == pytest.approx(9 + 5 + 3 + 11 + 9 + 3 + 5, abs=1e-8)
    assert set(map(tuple, STEPS[1:-1])).isdisjoint(map(tuple, b.corners.tolist()))


def test_polylines_that_are_nearly_the_same_are_refused():
    with pytest.raises(BubblemeshError, match="next to"):
        stairs([(x, y + 1e-6 * (x == 5)) for x, y in STEPS])
