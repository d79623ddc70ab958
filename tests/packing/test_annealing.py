from dataclasses import replace

import numpy as np
import pytest
from lattices import packed_hexagon, uniform
from relaxers import relaxer

from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.annealing import CYCLES, DISORDERED, ONLY, SPACING_STAYS, CyclicAnnealing, Rank, deviations
from bubblemesh.packing.forces import VanDerWaals
from bubblemesh.packing.motion import SemiImplicitEuler
from bubblemesh.packing.net import connect, connect_inside
from bubblemesh.packing.placement.diffusion import ErrorDiffusion
from bubblemesh.packing.relaxation import Connected, Dynamics, Relaxed
from bubblemesh.spacing.spacing import Spacing

SIDE = 7


class Recorder:
    """A relaxation that moves nothing, and keeps what it was given."""

    def __init__(self):
        self.nets, self.steps = [], []

    def __call__(self, net, steps):
        self.nets.append(net)
        self.steps.append(steps)
        return Relaxed(net.bubbles, 0, 0, np.full(steps, float(len(self.nets))), 10)

    @property
    def places(self):
        return [net.bubbles.x for net in self.nets]


def annealed(scheme, domain, spacing, bubbles, seed=0, relax=None, rank=ONLY):
    recorder = relax or Recorder()
    relaxing = relaxer(recorder, domain, spacing)
    _, result = scheme(connect(bubbles, domain), relaxing, np.random.default_rng(seed), rank)
    return result, recorder


def with_vacancy():
    """The perfect hexagon without the bubble in its middle."""
    domain, spacing, bubbles = packed_hexagon(SIDE)
    (middle,) = np.flatnonzero(np.hypot(*bubbles.x.T) < 0.1)
    return domain, spacing, bubbles.select(np.delete(np.arange(len(bubbles)), middle))


def irregular_and_next(net):
    """By loops: the bubbles whose number of neighbours is not six, and their neighbours."""
    near = {i: set() for i in range(len(net.bubbles))}
    for i, j in net.edges.tolist():
        near[i].add(j)
        near[j].add(i)
    irregular = {i for i in near if len(near[i]) != 6}
    return irregular | {j for i in irregular for j in near[i]}


def test_only_irregular_bubbles_and_their_neighbours_are_displaced():
    domain, spacing, bubbles = with_vacancy()
    net = connect(bubbles, domain)
    _, recorder = annealed(CyclicAnnealing(effort="fast"), domain, spacing, bubbles)
    moved = (recorder.places[0] != bubbles.x).any(axis=1)
    expected = {i for i in irregular_and_next(net) if i >= bubbles.boundary_count}
    assert set(np.flatnonzero(moved).tolist()) == expected
    assert 10 < len(expected) < len(bubbles) - bubbles.boundary_count - 20


def test_boundary_never_moves():
    domain, spacing, bubbles = with_vacancy()
    at = bubbles.boundary_count
    result, recorder = annealed(CyclicAnnealing(effort="fast"), domain, spacing, bubbles)
    for x in [*recorder.places, result.bubbles.x]:
        np.testing.assert_array_equal(x[:at], bubbles.x[:at])


@pytest.mark.parametrize("effort", CYCLES)
def test_cycles_follow_the_effort(effort):
    domain, spacing, bubbles = packed_hexagon(3)
    result, recorder = annealed(CyclicAnnealing(effort=effort, shake_steps=5), domain, spacing, bubbles)
    assert len(recorder.nets) == {"fast": 20, "normal": 280, "best": 4000}[effort]
    assert set(recorder.steps) == {5}
    assert result.speeds.tolist() == [float(k) for k in range(1, len(recorder.nets) + 1) for _ in range(5)]
    assert result.evaluations == 10 * len(recorder.nets)


@pytest.mark.parametrize(("full", "cycles"), [(1000, 280), (37, 280), (20, 152), (6, 46), (1, 8)])
def test_large_systems_have_fewer_cycles(full, cycles):
    domain, spacing, bubbles = packed_hexagon(3)
    assert len(bubbles) == 37
    _, recorder = annealed(CyclicAnnealing(fully_shaken=full), domain, spacing, bubbles)
    assert len(recorder.nets) == cycles


@pytest.mark.parametrize(("effort", "cycles"), [("fast", [2, 1, 1]), ("normal", [32, 16, 1]), ("best", [200, 100, 3])])
def test_the_largest_systems_have_the_fewest_cycles_or_less_if_they_are_in_order(effort, cycles):
    scheme = CyclicAnnealing(effort=effort, fully_shaken=60)
    assert [scheme.cycles(100_000, disorder=share * DISORDERED) for share in (1.0, 0.5, 0.0)] == cycles
    assert scheme.cycles(100_000, disorder=0.5) == cycles[0]


def test_few_bubbles_have_more_cycles_if_they_are_the_only_level():
    for effort, few, many in (("fast", 20, 20), ("normal", 280, 160), ("best", 4000, 4000)):
        scheme = CyclicAnnealing(effort=effort, fully_shaken=10_000)
        assert (scheme.cycles(2000), scheme.cycles(10_000)) == (few, many)
    assert [CyclicAnnealing().cycles(bubbles) for bubbles in (20, 2000, 2500, 4000)] == [280, 280, 225, 160]
    assert CyclicAnnealing().cycles(20, Rank(finer=1)) == 200


def test_only_the_first_level_has_fewer_cycles_if_it_is_in_order():
    scheme, later = CyclicAnnealing(effort="best"), Rank(coarser=1, finer=1)
    assert scheme.cycles(100_000, later, disorder=0.0) == scheme.cycles(100_000, later, disorder=1.0)


def test_annealing_sees_the_disorder():
    domain, spacing, bubbles = packed_hexagon(8)
    x = bubbles.x.copy()
    x[bubbles.interior] += np.random.default_rng(0).normal(0, 0.25, x[bubbles.interior].shape)
    for places, cycles in ((bubbles.x, 2), (x, 57)):
        _, recorder = annealed(CyclicAnnealing(fully_shaken=1), domain, spacing, bubbles.moved(places))
        assert len(recorder.nets) == cycles


@pytest.mark.parametrize(("full", "cycles"), [(37, 200), (20, 109), (1, 6)])
def test_coarse_levels_have_twice_as_many_cycles(full, cycles):
    domain, spacing, bubbles = packed_hexagon(3)
    _, recorder = annealed(CyclicAnnealing(fully_shaken=full), domain, spacing, bubbles, rank=Rank(finer=1))
    assert len(recorder.nets) == cycles


@pytest.mark.parametrize(
    ("effort", "cycles"), [("fast", [20, 40, 80, 80, 160, 160]), ("best", [4000, 4000, 3200, 3200, 4000, 4000])]
)
def test_levels_whose_order_is_handed_on_often_have_more_cycles(effort, cycles):
    assert [CyclicAnnealing(effort=effort).cycles(4000, Rank(finer=finer)) for finer in range(6)] == cycles


def test_finest_of_several_levels_has_no_cycles_and_a_large_one_next_to_it_only_the_best_effort():
    for effort in CYCLES:
        assert CyclicAnnealing(effort=effort).cycles(500, Rank(coarser=1)) == 0
    for bubbles in (2000, 2001):
        cycles = [CyclicAnnealing(effort=effort).cycles(bubbles, Rank(coarser=1, finer=1)) for effort in CYCLES]
        assert cycles == ([40, 200, 4000] if bubbles == 2000 else [0, 0, 4000])
    assert CyclicAnnealing().cycles(2001, Rank(finer=1)) == 200  # the coarsest level, which takes over no order


@pytest.mark.parametrize("d", [1.0, 0.01])
def test_displacements_fall_linearly_to_a_half_and_are_less_beside_the_boundary(d):
    domain = Domain.of(rings.rectangle(0, 0, 25 * d, 20 * d))
    start = ErrorDiffusion()(domain, uniform(d), 10_000)
    net = connect(start, domain)
    x = start.x
    nets, moves = [net], []

    def back(net, steps):
        moves.append((net.bubbles.x - x) / d)
        nets.append(net)
        return Relaxed(replace(net.bubbles, x=x), 0, 0, np.zeros(steps), 0)

    annealed(CyclicAnnealing(amplitude=0.05, amplitude_at_boundary=0.5), domain, uniform(d), start, relax=back)
    inside = np.arange(len(x)) >= start.boundary_count
    assert len(moves) == 280
    for number in (0, 60, 140, 220, 279):
        share = 1 - number / 560
        move, near = moves[number], nets[number].dilated(~inside)
        for which, sigma in ((inside & ~near, 0.05), (inside & near, 0.025)):
            some = move[which][(move[which] != 0).any(axis=1)]
            assert np.abs(some).max() <= np.sqrt(6) * sigma * share * (1 + 1e-9)
            assert some.std() == pytest.approx(sigma * share, rel=0.15)


def test_deviations_are_random_and_those_of_cycles_seeds_and_bubbles_are_others():
    bubbles = np.arange(5000)
    some = [deviations(seed, cycle, bubbles) for seed in (0, 1, 2**63 - 1) for cycle in (0, 1, 1599)]
    numbers = np.stack([column for values in some for column in values.T])
    np.testing.assert_allclose(numbers.mean(axis=1), 0, atol=0.06)
    np.testing.assert_allclose(numbers.var(axis=1), 1, atol=0.08)
    assert np.abs(numbers).max() < np.sqrt(6)
    related = np.corrcoef(np.vstack([numbers, np.roll(numbers, 1, axis=1)]))
    assert np.abs(related - np.eye(len(related))).max() < 0.07
    np.testing.assert_array_equal(deviations(1, 1, bubbles[7:9]), some[4][7:9])


def test_spacings_are_looked_up_once_in_some_cycles():
    domain, _, bubbles = with_vacancy()
    asked = []

    def function(x, y):
        asked.append(len(x))
        return np.ones_like(x)

    gentle = CyclicAnnealing(effort="fast", amplitude=0.1)  # no bubble gets lost
    _, recorder = annealed(gentle, domain, Spacing(function, 1.0), bubbles)
    assert asked == [len(net.bubbles) for net in recorder.nets[SPACING_STAYS::SPACING_STAYS]]
    assert len(asked) == 3


def test_a_seed_gives_one_result_and_another_seed_another():
    domain, spacing, bubbles = with_vacancy()
    one, same, other = (
        annealed(CyclicAnnealing(effort="fast"), domain, spacing, bubbles, seed)[0].bubbles.x for seed in (1, 1, 2)
    )
    assert one.tobytes() == same.tobytes()
    assert one.tobytes() != other.tobytes()


def test_bubbles_that_get_lost_are_left_out_from_then_on():
    domain, spacing, bubbles = with_vacancy()
    sizes = []

    def losing(net, steps):
        sizes.append(len(net.bubbles))
        assert net.valence.shape == (len(net.bubbles),)
        assert (net.valence > 0).all()
        rest = net.bubbles.select(np.arange(len(net.bubbles) - 1)) if len(sizes) in (3, 7) else net.bubbles
        return Relaxed(rest, 0, len(net.bubbles) - len(rest), np.zeros(steps), 0)

    result, _ = annealed(CyclicAnnealing(effort="fast", amplitude=0.01), domain, spacing, bubbles, relax=losing)
    n = len(bubbles)
    assert sizes == [n] * 3 + [n - 1] * 4 + [n - 2] * 13
    assert result.lost == 2
    assert len(result.bubbles) == n - 2


def test_bubbles_that_a_relaxation_adds_are_there_from_then_on():
    domain, spacing, bubbles = with_vacancy()
    sizes, added = [], []

    def adding(net, steps):
        sizes.append((len(net.bubbles), len(net.valence)))
        grown = net.bubbles
        if len(sizes) == 3:
            grown = grown.append(np.array([[0.05, 0.02]]), np.ones(1))
            added.append(len(grown) - 1)
        return Relaxed(grown, len(grown) - len(net.bubbles), 0, np.zeros(steps), 0)

    calm = []

    def noted(bubbles):
        calm.append(len(bubbles))
        return np.zeros(len(bubbles), bool)

    result, _ = annealed(
        CyclicAnnealing(effort="fast", amplitude=0.01).sparing(noted), domain, spacing, bubbles, relax=adding
    )
    n = len(bubbles)
    assert sizes == [(n, n)] * 3 + [(n + 1, n + 1)] * 17
    assert calm == [n] + [n + 1] * 4  # looked up at once, as the third cycle gives other bubbles the numbers
    assert result.added == 1


def test_bubbles_displaced_out_of_the_domain_are_gone():
    domain, spacing, bubbles = packed_hexagon(3)
    x = bubbles.x.copy()
    x[-1] = [0, 2.59]  # just inside the upper side, which is at 2.598
    result, _ = annealed(CyclicAnnealing(effort="normal", amplitude=0.4), domain, spacing, replace(bubbles, x=x))
    net = connect_inside(result.bubbles, domain, spacing)
    assert len(net.bubbles) < len(bubbles)


def test_perfect_lattice_far_from_the_boundary_is_left_alone():
    domain, spacing, bubbles = packed_hexagon(SIDE)
    result, _ = annealed(CyclicAnnealing(effort="fast", amplitude=0.05), domain, spacing, bubbles)
    still = (result.bubbles.x == bubbles.x).all(axis=1)
    deep = domain.signed_distance(bubbles.x) > 3 * np.sqrt(3) / 2 + 0.1
    assert deep.sum() > 20
    assert still[deep].all()


def test_annealing_heals_a_disordered_packing():
    domain, spacing = Domain.of(rings.rectangle(0, 0, 16, 16)), uniform(1.0)
    dynamics = Dynamics(VanDerWaals(), SemiImplicitEuler(), lambda steps, _: [1.0] * len(steps))

    def relax(net, steps):
        return Connected()(net, domain, spacing, dynamics, steps)

    def irregular(bubbles):
        net = connect_inside(bubbles, domain, spacing)
        return (net.valence[bubbles.interior] != 6).mean()

    start = relax(connect(ErrorDiffusion()(domain, spacing, 10_000), domain), 150).bubbles
    result, _ = annealed(CyclicAnnealing(), domain, spacing, start, relax=relax)
    still = relax(connect(start, domain), 1200).bubbles
    assert irregular(start) > 0.2
    assert irregular(result.bubbles) < 0.7 * irregular(still)
