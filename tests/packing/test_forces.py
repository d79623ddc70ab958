import numpy as np
import pytest
from lattices import hexagonal

from bubblemesh.kernels.relaxing import CUTOFF, pair_force
from bubblemesh.packing.forces import VanDerWaals
from bubblemesh.packing.neighbours import Neighbours


def scattered(seed, n=60):
    rng = np.random.default_rng(seed)
    return rng.random((n, 2)), rng.uniform(0.1, 0.3, n)


def looped_forces(x, d, k0, scaled):
    """Equation (2.1) of the paper, pair by pair."""
    forces = np.zeros_like(x)
    for i in range(len(x)):
        for j in range(len(x)):
            distance, contact = np.hypot(*(x[i] - x[j])), (d[i] + d[j]) / 2
            ratio = distance / contact
            if i != j and ratio < 1.5:
                size = k0 * (5 / 4 * ratio**3 - 19 / 8 * ratio**2 + 9 / 8)
                forces[i] += size * (d[i] if scaled else 1) * (x[i] - x[j]) / distance
    return forces


def test_pair_force_has_the_values_of_the_paper():
    assert pair_force(np.array([0.0, 1.0, 1.5, 2.0])).tolist() == [9 / 8, 0, 0, 0]


def test_pair_force_falls_by_one_at_contact():
    h = 1e-6
    low, high = pair_force(np.array([1 - h, 1 + h]))
    assert (high - low) / (2 * h) == pytest.approx(-1, abs=1e-9)


def test_pair_force_repels_below_contact_and_attracts_above():
    ratio = np.linspace(0, 1.6, 161)
    force = pair_force(ratio)
    assert (force[ratio < 0.999] > 0).all()
    assert (force[(ratio > 1.001) & (ratio < 1.499)] < 0).all()
    assert (force[ratio > 1.501] == 0).all()


def test_pair_force_is_continuous_at_the_cutoff():
    assert pair_force(np.array([CUTOFF * (1 - 1e-12)]))[0] == pytest.approx(0, abs=1e-11)


@pytest.mark.parametrize("force", ["scaled", "plain"])
@pytest.mark.parametrize("reach", [1.5, 1.9])
def test_forces_are_those_of_the_double_loop(force, reach):
    x, d = scattered(1)
    found = VanDerWaals(k0=2.5, force=force).among(Neighbours.of(x, d, reach))(x)
    np.testing.assert_allclose(found, looped_forces(x, d, 2.5, force == "scaled"), atol=1e-13)


def test_forces_follow_the_positions_while_the_neighbours_stay():
    x, d = scattered(2)
    moved = x + 0.01 * np.random.default_rng(3).standard_normal(x.shape)
    found = VanDerWaals().among(Neighbours.of(x, d, 2.5))(moved)
    np.testing.assert_allclose(found, looped_forces(moved, d, 1.0, True), atol=1e-13)


def test_action_is_reaction_for_the_plain_force():
    x, d = scattered(4)
    force = VanDerWaals(force="plain").among(Neighbours.of(x, d, 1.9))(x)
    np.testing.assert_allclose(force.sum(axis=0), 0, atol=1e-12)
    torque = x[:, 0] * force[:, 1] - x[:, 1] * force[:, 0]
    assert torque.sum() == pytest.approx(0, abs=1e-12)


def test_scaled_force_is_the_plain_one_times_the_spacing():
    x, d = scattered(5)
    near = Neighbours.of(x, d, 1.9)
    plain, scaled = (VanDerWaals(force=kind).among(near)(x) for kind in ("plain", "scaled"))
    np.testing.assert_allclose(scaled, d[:, None] * plain, atol=1e-14)


def test_scaled_force_is_a_length():
    x, d = scattered(6)
    unit, large = (VanDerWaals().among(Neighbours.of(scale * x, scale * d, 1.9))(scale * x) for scale in (1.0, 1024.0))
    np.testing.assert_allclose(large, 1024 * unit, rtol=1e-9, atol=1e-9)


def test_perfect_lattice_has_no_force_inside():
    x = hexagonal(9, 9, d=0.1)
    force = VanDerWaals(force="plain").among(Neighbours.of(x, np.full(81, 0.1), 1.9))(x)
    np.testing.assert_allclose(force.reshape(9, 9, 2)[1:-1, 1:-1], 0, atol=1e-12)


def test_coinciding_bubbles_do_not_move_each_other():
    x = np.zeros((2, 2))
    assert (VanDerWaals().among(Neighbours.of(x, np.ones(2), 1.9))(x) == 0).all()
