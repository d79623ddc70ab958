from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest
from lattices import packed_hexagon, uniform

from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.relaxing import pair_force
from bubblemesh.packing import relaxation
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.forces import VanDerWaals
from bubblemesh.packing.motion import ClassicalRungeKutta, SecondOrderEuler, SemiImplicitEuler
from bubblemesh.packing.net import connect
from bubblemesh.packing.placement.diffusion import ErrorDiffusion, boundary_bubbles
from bubblemesh.packing.relaxation import MOST_MOVE, Connected, Dynamics, Nearby, Relaxed
from bubblemesh.spacing.spacing import Spacing

SIDE = 5
BOTH = pytest.mark.parametrize("relax", [Nearby(), Connected(), Connected(refresh=7)], ids=["near", "net", "net7"])


def constant(steps, touched):
    return [1.4] * len(steps)


@dataclass(frozen=True)
class Drift:
    """Moves one bubble by the same way in every step, and no other."""

    bubble: int
    way: tuple[float, float]
    evaluations: ClassVar[int] = 1

    def __call__(self, x, v, c, force):
        v = np.zeros_like(x)
        v[self.bubble] = self.way
        return x + v, v


def relaxed(relax, domain, spacing, bubbles, steps, motion=None, viscosities=constant):
    motion = motion or SecondOrderEuler()
    return relax(connect(bubbles, domain), domain, spacing, Dynamics(VanDerWaals(), motion, viscosities), steps)


def disturbed(bubbles, amplitude=0.1):
    x = bubbles.x.copy()
    inside = x[bubbles.interior]
    x[bubbles.interior] += np.random.default_rng(0).uniform(-amplitude, amplitude, inside.shape)
    return replace(bubbles, x=x)


@BOTH
def test_perfect_packing_does_not_move(relax):
    domain, spacing, bubbles = packed_hexagon(SIDE)
    result = relaxed(relax, domain, spacing, bubbles, 50)
    np.testing.assert_allclose(result.bubbles.x, bubbles.x, atol=1e-9)
    assert (result.added, result.lost) == (0, 0)
    assert result.speeds.max() < 1e-9


@BOTH
@pytest.mark.parametrize("motion", [SecondOrderEuler(), SemiImplicitEuler()])
def test_disturbed_packing_returns_to_the_perfect_one(relax, motion):
    domain, spacing, bubbles = packed_hexagon(SIDE)
    start = disturbed(bubbles)
    assert np.abs(start.x - bubbles.x).max() > 0.09
    result = relaxed(relax, domain, spacing, start, 500, motion)
    np.testing.assert_allclose(result.bubbles.x, bubbles.x, atol=2e-3)
    assert result.speeds[-1] < 0.01 * result.speeds.max()


@BOTH
@pytest.mark.parametrize("motion", [ClassicalRungeKutta(), SemiImplicitEuler()])
def test_evaluations_are_bubbles_times_steps_times_stages(relax, motion):
    domain, spacing, bubbles = packed_hexagon(SIDE)
    result = relaxed(relax, domain, spacing, disturbed(bubbles), 30, motion)
    assert result.evaluations == len(bubbles) * 30 * motion.evaluations
    assert result.speeds.shape == (30,)


@BOTH
def test_viscosity_is_asked_for_in_every_step_with_the_touched_bubbles(relax):
    domain, spacing, bubbles = packed_hexagon(SIDE)
    bubbles = replace(bubbles, touched=np.arange(len(bubbles)) % 3 == 0)
    asked = []

    def viscosities(steps, touched):
        asked.extend(steps)
        np.testing.assert_array_equal(touched, bubbles.touched)
        return [1.0] * len(steps)

    relaxed(relax, domain, spacing, bubbles, 25, viscosities=viscosities)
    assert asked == list(range(25))


@BOTH
def test_bubbles_that_are_given_stay_as_they_are(relax):
    domain, spacing, bubbles = packed_hexagon(SIDE)
    start = disturbed(bubbles)
    before = start.x.copy()
    relaxed(relax, domain, spacing, start, 25)
    np.testing.assert_array_equal(start.x, before)


@BOTH
def test_no_bubble_goes_farther_than_half_its_spacing_in_a_step(relax):
    domain, spacing, bubbles = packed_hexagon(SIDE)
    middle = int(np.hypot(*bubbles.x.T).argmin())
    result = relaxed(relax, domain, spacing, bubbles, 3, Drift(middle, (100.0, 0.0)))
    np.testing.assert_allclose(result.bubbles.x[middle], [3 * MOST_MOVE, 0], atol=1e-9)
    np.testing.assert_allclose(result.speeds, 100 * MOST_MOVE / 100 / len(bubbles))


def test_connected_boundary_bubbles_stay_where_they_are():
    domain = Domain.of(rings.circle((0, 0), 2), [rings.rectangle(-0.5, -0.5, 0.5, 0.5)])
    spacing = Spacing(lambda x, y: 0.2 + 0.1 * np.hypot(x, y), floor=0.1)
    start = ErrorDiffusion()(domain, spacing, 10_000)
    result = relaxed(Connected(), domain, spacing, start, 60)
    at = start.boundary_count
    assert result.bubbles.boundary_count == at
    np.testing.assert_array_equal(result.bubbles.x[:at], start.x[:at])
    np.testing.assert_array_equal(result.bubbles.s, start.s)
    assert np.abs(result.bubbles.x[at:] - start.x[at:]).max() > 0.05


def test_nearby_boundary_bubbles_slide_and_corners_stay():
    domain, spacing, bubbles = packed_hexagon(SIDE)
    s = bubbles.s + 0.2 * (np.arange(len(bubbles.s)) % 2)
    x = bubbles.x.copy()
    x[bubbles.sliding] = domain.boundary.points(bubbles.piece, s)
    result = relaxed(Nearby(), domain, spacing, replace(bubbles, x=x, s=s), 300)
    np.testing.assert_array_equal(result.bubbles.x[:6], bubbles.x[:6])
    on_curve = domain.boundary.points(bubbles.piece, result.bubbles.s)
    np.testing.assert_array_equal(result.bubbles.x[bubbles.sliding], on_curve)
    np.testing.assert_allclose(result.bubbles.s, bubbles.s, atol=1e-2)


def test_connected_step_is_that_of_the_forces_along_the_edges():
    domain, spacing, bubbles = packed_hexagon(SIDE)
    start = disturbed(bubbles, 0.25)
    net = connect(start, domain)
    expected = start.x.copy()
    for i, j in net.edges.tolist():
        delta = start.x[i] - start.x[j]
        distance = np.hypot(*delta)
        force = pair_force(np.array([distance]))[0] * delta / distance
        expected[i] += 0.3**2 / (1 + 2.0 * 0.3) * force
        expected[j] -= 0.3**2 / (1 + 2.0 * 0.3) * force
    expected[: start.boundary_count] = start.x[: start.boundary_count]
    dynamics = Dynamics(VanDerWaals(), SemiImplicitEuler(dt=0.3), lambda steps, touched: [2.0] * len(steps))
    found = Connected()(net, domain, spacing, dynamics, 1)
    np.testing.assert_allclose(found.bubbles.x, expected, atol=1e-13)


def test_connected_bubbles_outside_are_lost_when_the_triangulation_is_renewed():
    domain, spacing, bubbles = packed_hexagon(SIDE)
    near_the_wall = bubbles.boundary_count + int(bubbles.x[bubbles.interior][:, 1].argmax())
    assert bubbles.x[near_the_wall, 1] == pytest.approx((SIDE - 1) * np.sqrt(3) / 2)
    motion = Drift(near_the_wall, (0.0, 0.4))
    result = relaxed(Connected(refresh=5), domain, spacing, bubbles, 5, motion)
    assert (len(result.bubbles), result.lost, result.evaluations) == (len(bubbles), 0, 5 * len(bubbles))
    at_rest = replace(motion, way=(0.0, 0.0))
    outside = replace(result.bubbles, x=result.bubbles.x)
    result = relaxed(Connected(refresh=5), domain, spacing, outside, 7, at_rest)
    assert (len(result.bubbles), result.added, result.lost) == (len(bubbles) - 1, 0, 1)
    assert result.evaluations == 5 * len(bubbles) + 2 * (len(bubbles) - 1)
    np.testing.assert_array_equal(result.bubbles.x, np.delete(bubbles.x, near_the_wall, axis=0))


@pytest.mark.parametrize(("refresh", "steps", "times"), [(20, 20, 0), (20, 21, 1), (6, 20, 3), (1, 4, 3), (50, 0, 0)])
def test_connected_bubbles_are_triangulated_anew_between_the_steps(refresh, steps, times, monkeypatch):
    domain, spacing, bubbles = packed_hexagon(SIDE)
    called = []

    def spied(*arguments):
        called.append(arguments)
        return connect_inside(*arguments)

    connect_inside = relaxation.connect_inside
    monkeypatch.setattr(relaxation, "connect_inside", spied)
    result = relaxed(Connected(refresh=refresh), domain, spacing, bubbles, steps)
    assert len(called) == times
    assert result.speeds.shape == (steps,)


def test_connected_bubbles_go_by_the_spacing_where_they_are(monkeypatch):
    domain = Domain.of(rings.rectangle(0, 0, 4, 2))
    spacing = Spacing(lambda x, y: 0.15 + 0.1 * x)
    start = ErrorDiffusion()(domain, spacing, 10_000)
    seen = []

    class Spied(relaxation.Neighbours):
        @classmethod
        def along(cls, edges, x, d):
            seen.append(np.abs(d / spacing(x) - 1).max())
            return super().along(edges, x, d)

    monkeypatch.setattr(relaxation, "Neighbours", Spied)
    relaxed(Connected(refresh=10), domain, spacing, start, 50)
    assert len(seen) == 5
    assert max(seen) < 1e-12


def test_connected_bubbles_do_not_act_through_a_wall_and_those_near_by_do():
    wall = rings.rectangle(-0.05, -2.5, 0.05, 2.5)
    domain, spacing = Domain.of(rings.rectangle(-3, -3, 3, 3), [wall]), uniform(1.0)
    shell = boundary_bubbles(domain, spacing)
    pair = np.array([[-0.6, 0.0], [0.6, 0.0]])
    none = np.zeros(0, np.int64)
    bubbles = shell.append(pair, np.ones(2), none, np.zeros(0))
    alone = shell.append(pair[:1], np.ones(1), none, np.zeros(0))
    for relax, independent in ((Connected(), True), (Nearby(), False)):
        both, one = (relaxed(relax, domain, spacing, start, 1).bubbles for start in (bubbles, alone))
        at = one.boundary_count
        assert np.allclose(both.x[at], one.x[at], atol=1e-12) == independent


def test_nearby_bubbles_are_put_back_inside():
    domain, spacing, bubbles = packed_hexagon(SIDE)
    near_the_wall = bubbles.boundary_count + int(bubbles.x[bubbles.interior][:, 1].argmax())
    result = relaxed(Nearby(), domain, spacing, bubbles, 4, Drift(near_the_wall, (0.0, 0.4)))
    assert (domain.signed_distance(result.bubbles.x[result.bubbles.interior]) > 0).all()
    assert len(result.bubbles) + result.lost == len(bubbles) + result.added


def test_relaxations_one_after_the_other_are_one():
    few, more = (
        Bubbles(np.zeros((n, 2)), np.ones(n), np.zeros(0, int), np.zeros(0), 0, np.zeros(n, bool)) for n in (2, 3)
    )
    first, second = Relaxed(few, 1, 2, np.array([3.0]), 4), Relaxed(more, 10, 20, np.array([30.0, 31.0]), 40)
    both = first.followed_by(second)
    assert both.bubbles is more
    assert (both.added, both.lost, both.speeds.tolist(), both.evaluations) == (11, 22, [3.0, 30.0, 31.0], 44)
    none = Relaxed.none(few)
    assert none.bubbles is few
    assert (none.added, none.lost, none.speeds.shape, none.evaluations) == (0, 0, (0,), 0)
    assert none.followed_by(second).speeds.tolist() == [30.0, 31.0]
