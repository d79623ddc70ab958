import numpy as np
import pytest
from partitions import domain_of

from bubblemesh.geometry import narrow_parts, rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.narrow_parts import FacingWalls

U_SHAPE = Domain.of(rings.polygon([(0, 0), (3, 0), (3, 3), (2.6, 3), (2.6, 0.5), (0.4, 0.5), (0.4, 3), (0, 3)]))


def everywhere(domain, reach, per_piece=200):
    """All gaps that many probes along the boundary find."""
    boundary = domain.boundary
    count = len(boundary.lengths)
    piece = np.repeat(np.arange(count), per_piece)
    s = np.tile((np.arange(per_piece) + 0.5) / per_piece, count) * boundary.lengths[piece]
    reach = np.full(len(piece), float(reach))
    return FacingWalls(domain).facing(piece, s, reach, reach)


def found(domain, reach):
    """Their places and widths."""
    gaps = everywhere(domain, reach)
    return gaps.places, gaps.widths


@pytest.mark.parametrize(("reach", "seen"), [(0.29, False), (0.31, True), (1.5, True)])
def test_strip_is_as_wide_as_its_short_side(reach, seen):
    places, widths = found(Domain.of(rings.rectangle(0, 0, 4, 0.3)), reach)
    assert len(places) == len(widths) == 400 * seen
    np.testing.assert_allclose(widths, 0.3, rtol=1e-12)
    if seen:
        assert set(places[:, 1].round(12).tolist()) == {0.0, 0.3}
        for y in (0.0, 0.3):
            x = np.sort(places[np.abs(places[:, 1] - y) < 1e-9, 0])
            np.testing.assert_allclose(x, (np.arange(200) + 0.5) / 50)


def test_a_long_reach_looks_along_the_strip_too():
    _, widths = found(Domain.of(rings.rectangle(0, 0, 4, 0.3)), 4.1)
    assert set(widths.round(9).tolist()) == {0.3, 4.0}
    assert (widths > 1).sum() == 400


@pytest.mark.parametrize("scale", [2.0**-40, 2.0**40])
def test_gaps_do_not_depend_on_the_unit_of_length(scale):
    _, widths = found(Domain.of(rings.rectangle(0, 0, 4 * scale, 0.3 * scale)), scale)
    np.testing.assert_allclose(widths, 0.3 * scale, rtol=1e-9)


@pytest.mark.parametrize(("reach", "seen"), [(0.2, False), (0.3, True)])
def test_annulus_has_one_width_on_both_sides(reach, seen):
    places, widths = found(Domain.of(rings.circle((1, 2), 2), [rings.circle((1, 2), 1.75)]), reach)
    assert (len(widths) > 0) is seen
    np.testing.assert_allclose(widths, 0.25, atol=1e-3)
    if seen:
        radius = np.hypot(*(places - [1, 2]).T)
        assert (np.abs(radius - 2) < 1e-9).sum() >= 200
        assert (np.abs(radius - 1.75) < 1e-9).sum() >= 200


def test_eccentric_annulus_is_narrowest_where_the_circles_are_nearest():
    places, widths = found(Domain.of(rings.circle((0, 0), 2), [rings.circle((0.5, 0), 1.2)]), 0.5)
    assert widths.min() == pytest.approx(0.3, abs=1e-3)
    assert places[widths.argmin()] == pytest.approx([2 if places[widths.argmin(), 0] > 1.8 else 1.7, 0], abs=0.05)
    # From a point of the outer circle the other one is this far, and not much farther along the ray.
    outer = np.abs(np.hypot(*places.T) - 2) < 1e-9
    expected = np.hypot(*(places[outer] - [0.5, 0]).T) - 1.2
    assert (widths[outer] > expected - 1e-3).all()
    assert (widths[outer] < 1.04 * expected).all()
    assert (places[:, 0] > 0.5).all()


def test_gaps_are_inside_the_domain_and_not_between_its_arms():
    places, widths = found(U_SHAPE, 1.0)
    assert set(widths.round(9).tolist()) == {0.4, 0.5}
    arms = np.abs(widths - 0.4) < 1e-9
    assert (places[arms, 1] > 0.4).all()
    assert set(places[arms, 0].round(9).tolist()) == {0.0, 0.4, 2.6, 3.0}
    assert set(places[~arms, 1].round(9).tolist()) == {0.0, 0.5}


def test_wall_between_a_hole_and_the_outer_ring():
    domain = Domain.of(rings.rectangle(0, 0, 4, 4), [rings.rectangle(1, 0.2, 2, 3)])
    places, widths = found(domain, 0.5)
    np.testing.assert_allclose(widths, 0.2, rtol=1e-9)
    assert set(places[:, 1].round(9).tolist()) == {0.0, 0.2}
    assert places[:, 0].min() > 0.99
    assert places[:, 0].max() < 2.01


def test_thin_ellipse_is_narrow_across():
    places, widths = found(Domain.of(rings.ellipse((0, 0), (2, 0.1))), 0.3)
    assert widths.max() == pytest.approx(0.2, abs=2e-3)
    assert places[:, 0].max() == pytest.approx(-places[:, 0].min(), abs=0.05)  # where the curve begins is no other end
    x, y = places.T
    near_tips = np.abs(x) > 1.9
    np.testing.assert_allclose(widths[near_tips], 2 * np.abs(y[near_tips]), rtol=0.2)
    middle = np.abs(places[:, 0]) < 0.1
    assert middle.sum() > 5
    np.testing.assert_allclose(widths[middle], 0.2, atol=2e-3)


@pytest.mark.parametrize(("reach", "seen"), [(0.1, False), (1.9, False), (2.1, True), (5.0, True)])
def test_circle_is_as_wide_as_its_diameter(reach, seen):
    _, widths = found(Domain.of(rings.circle((0, 0), 1)), reach)
    assert len(widths) == 200 * seen
    np.testing.assert_allclose(widths, 2, rtol=1e-4)


BENDS = {
    "square": (Domain.of(rings.rectangle(0, 0, 1, 1)), 0.99),
    "sharp angle": (Domain.of(rings.polygon([(0, 0), (5, 0), (5, 1)])), 0.9),
    "reentrant angle": (Domain.of(rings.polygon([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)])), 0.9),
    "lens": (
        Domain.of(
            rings.path(
                (-1, 0),
                [rings.ArcTo((1, 0), (0, 2), True), rings.ArcTo((-1, 0), (0, -2), True)],
            )
        ),
        0.4,
    ),
    "rounded corner": (
        Domain.of(
            rings.path(
                (0, 0),
                [
                    rings.LineTo((3, 0)),
                    rings.LineTo((3, 2.5)),
                    rings.ArcTo((2.5, 3), (2.5, 2.5), True),
                    rings.LineTo((0, 3)),
                ],
            )
        ),
        2.4,
    ),
    "waves": (
        Domain.of(
            rings.path(
                (0, 0),
                [
                    rings.LineTo((6, 0)),
                    rings.LineTo((6, 3)),
                    rings.SplineTo([(5, 3.3), (4, 2.9), (3, 3.3), (2, 2.9), (1, 3.3), (0, 3)]),
                ],
            )
        ),
        1.0,
    ),
}


@pytest.mark.parametrize(("domain", "reach"), BENDS.values(), ids=BENDS)
def test_corners_and_bends_are_no_gaps(domain, reach):
    _, widths = found(domain, reach)
    assert len(widths) == 0


def test_places_have_reaches_of_their_own():
    domain = Domain.of(rings.rectangle(0, 0, 4, 0.3))
    piece, s = np.array([0, 0, 0]), np.array([1.0, 2.0, 3.0])
    gaps = FacingWalls(domain).facing(piece, s, np.array([0.2, 0.5, 0.4]), np.zeros(3))
    assert gaps.number.tolist() == [1, 2]
    np.testing.assert_allclose(gaps.places, [[2, 0], [3, 0]])
    np.testing.assert_allclose(gaps.feet, [[2, 0.3], [3, 0.3]])
    np.testing.assert_allclose(gaps.widths, 0.3)
    assert not gaps.inner.any()


def test_no_places_have_no_gaps():
    gaps = FacingWalls(U_SHAPE).facing(np.zeros(0, np.int64), np.zeros(0), np.zeros(0), np.zeros(0))
    assert gaps.places.shape == gaps.feet.shape == (0, 2)
    assert gaps.widths.shape == (0,)


INSIDE = (
    "domain: {outer: {rectangle: [0, 0, 4, 1]}, lines: [{path: [[0, 0.4], [4, 0.4]]}, {path: [[3, 0.5], [1, 0.5]]}]}"
)


def test_lines_inside_have_gaps_on_both_sides():
    gaps = everywhere(domain_of(INSIDE), 0.45)
    np.testing.assert_allclose(np.abs(gaps.feet - gaps.places).sum(axis=1), gaps.widths, atol=1e-12)
    ways = {tuple(np.sort([a, b]).round(9).tolist()) for a, b in zip(gaps.places[:, 1], gaps.feet[:, 1], strict=True)}
    assert ways == {(0.0, 0.4), (0.4, 0.5)}
    assert gaps.inner.all()


def test_a_ring_behind_hides_what_is_beyond():
    """Through a hole, or across what is outside, there is no gap."""
    plate = Domain.of(rings.rectangle(0, 0, 4, 2), [rings.rectangle(1, 0.5, 3, 0.6)])
    gaps = everywhere(plate, 1.95)
    assert gaps.widths.min() == pytest.approx(0.5)
    below = (gaps.places[:, 1] == 0) & (gaps.places[:, 0] > 1) & (gaps.places[:, 0] < 3)
    np.testing.assert_allclose(gaps.feet[below, 1], 0.5)


def test_widths_are_those_between_curves_not_their_chords():
    annulus = Domain.of(rings.circle((0, 0), 1), [rings.circle((0, 0), 1 - 1e-3)])
    np.testing.assert_allclose(everywhere(annulus, 0.01).widths, 1e-3, rtol=1e-3)


LENS = [rings.ArcTo((1, 0), (0, 20), True), rings.ArcTo((-1, 0), (0, -20), True)]


@pytest.mark.parametrize("room", [0.1, 0.4])
def test_two_lines_that_join_at_both_ends_are_a_gap_in_between(room):
    domain = Domain.of(rings.path((-1, 0), LENS))
    piece, s = np.zeros(200, np.int64), (np.arange(200) + 0.5) / 200 * domain.boundary.lengths[0]
    gaps = FacingWalls(domain).facing(piece, s, np.full(200, 0.6), np.full(200, room))
    assert gaps.places[:, 0].min() == pytest.approx(room - 1, abs=0.01)
    assert gaps.places[:, 0].max() == pytest.approx(1 - room, abs=0.01)
    np.testing.assert_allclose(gaps.widths, 2 * np.abs(gaps.places[:, 1]), rtol=0.01)


def comb(teeth, height=1.0, width=2.0):
    """A comb, with as many slits between its teeth, nearly as deep as these are high."""
    x = np.linspace(0, width, 4 * teeth + 1)
    y = np.tile([height, height, 0.1, 0.1], teeth + 1)[: len(x)]
    return Domain.of(rings.polygon([*zip(x.tolist(), y.tolist(), strict=True), (width, 0), (0, 0)]))


@pytest.mark.parametrize("reach", [0.001, 0.02, 3.0])
def test_gaps_are_the_same_however_the_walls_are_looked_for(reach, monkeypatch):
    domain = comb(300)
    quick = everywhere(domain, reach, per_piece=5)
    monkeypatch.setattr(narrow_parts, "MANY_CHORDS", np.inf)  # by the chords as they are
    whole = everywhere(domain, reach, per_piece=5)
    monkeypatch.setattr(narrow_parts, "DOUBLINGS", 0)  # by rays of their whole length
    long = everywhere(domain, reach, per_piece=5)
    for gaps in (quick, whole):
        assert all(np.array_equal(mine, other) for mine, other in zip(gaps, long, strict=True))
    assert (len(long.number) > 0) == (reach > 0.002)


def test_points_are_inside_whichever_axis_is_looked_along():
    domain = comb(300)
    turned = Domain.of(rings.polygon(np.fliplr(domain.boundary.corners).tolist()))
    assert domain._mirrored is not None
    assert turned._mirrored is None
    points = np.vstack([np.random.default_rng(0).uniform(-0.1, 2.1, (5000, 2)), domain.boundary.corners])
    assert np.array_equal(domain.contains(points), turned.contains(np.fliplr(points)))


@pytest.mark.parametrize(
    ("domain", "width"),
    [
        ("{outer: {rectangle: [0, 0, 3, 2]}}", 2.0),
        ("{outer: {rectangle: [0, 0, 3, 2]}, lines: [{path: [[1, 1], [2, 1.25]]}]}", 0.75),
        ("{outer: {rectangle: [0, 0, 3, 2]}, points: [{at: [0.5, 1], label: gauge}]}", 0.5),
        ("{outer: {rectangle: [0, 0, 3, 2]}, holes: [{circle: {center: [1, 1], radius: 0.1}}]}", 0.0),
    ],
)
def test_no_gap_is_below_the_least_width_which_is_not_known_beside_curves(domain, width):
    walls = FacingWalls(domain_of(f"domain: {domain}"))
    assert walls.least_width == pytest.approx(width)
    piece, length = np.arange(len(walls.domain.boundary.kind)), walls.domain.boundary.lengths
    ends = np.full(len(piece), 10.0)
    assert (walls.facing(piece, length / 2, ends, ends / 1e3).widths >= width * (1 - 1e-9)).all()
