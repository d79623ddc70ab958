from dataclasses import replace

import numpy as np
import pytest
from lattices import packed_hexagon, uniform
from twins import needs_compiler, run_by

from bubblemesh.case import load_case
from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.library import COMPILED, NUMPY
from bubblemesh.packing.annealing import ONLY, CyclicAnnealing, SparingAnnealing
from bubblemesh.packing.forces import VanDerWaals
from bubblemesh.packing.motion import SemiImplicitEuler
from bubblemesh.packing.net import connect, connect_inside
from bubblemesh.packing.placement import Perturbation
from bubblemesh.packing.placement.diffusion import ErrorDiffusion
from bubblemesh.packing.relaxation import Connected, Dynamics, Relaxer
from bubblemesh.run.pipeline import mesh_case
from bubblemesh.spacing.spacing import Spacing

pytestmark = needs_compiler

PLATE = Domain.of(rings.rectangle(0, 0, 12, 9), [rings.circle((5, 5), 2)])
PLATE_CASE = """
name: plate
domain: {outer: {rectangle: [0, 0, 3, 2]}}
spacing: 0.3
packing: {effort: fast}
"""
GRADED = Spacing(lambda x, y: 0.3 + 0.1 * x, 0.3)


def annealed(engine, scheme, net, domain, spacing, seed=0, force=None):
    """Relaxation by annealing, of either engine, and the bubbles of each cycle that was counted."""
    counted = []
    dynamics = Dynamics(
        force or VanDerWaals(),
        SemiImplicitEuler(),
        lambda some, touched: [0.5 + 0.1 * step for step in some],
        lambda some, bubbles: counted.append(bubbles),
    )

    relaxer = Relaxer(Connected(), domain, spacing, dynamics)
    with run_by(engine):
        last, relaxed = scheme(net, relaxer, np.random.default_rng(seed), ONLY)
    assert last.bubbles is relaxed.bubbles
    return relaxed, counted


def assert_same(one, other):
    assert one.bubbles.x.tobytes() == other.bubbles.x.tobytes()
    assert one.bubbles.d.tobytes() == other.bubbles.d.tobytes()
    assert one.speeds.tobytes() == other.speeds.tobytes()
    assert (one.evaluations, one.lost, one.added) == (other.evaluations, other.lost, other.added)


def net_of(domain, spacing, again=False):
    start = ErrorDiffusion()(domain, spacing, 10_000)
    net = connect_inside(Perturbation(jitter=0.1)(start, spacing, np.random.default_rng(5)), domain, spacing)
    return connect_inside(net.bubbles, domain, spacing, net) if again else net


@pytest.mark.parametrize("known", [False, True])
@pytest.mark.parametrize("spacing", [uniform(0.7), GRADED], ids=["uniform", "graded"])
@pytest.mark.parametrize("seed", range(3))
def test_both_engines_go_through_the_same_cycles(spacing, known, seed):
    net = net_of(PLATE, spacing, known)
    assert (net.legal is not None) == known
    for scheme in (
        CyclicAnnealing(effort="fast"),
        CyclicAnnealing(effort="fast", shake_steps=3, amplitude_at_boundary=1.0),
    ):
        one, counted = annealed(COMPILED, scheme, net, PLATE, spacing, seed)
        other, as_often = annealed(NUMPY, scheme, net, PLATE, spacing, seed)
        assert_same(one, other)
        assert sum(counted) == sum(as_often)
        assert not np.array_equal(one.bubbles.x, net.bubbles.x)


def test_plain_forces_are_the_same_too():
    net, force = net_of(PLATE, GRADED), VanDerWaals(k0=0.5, force="plain")
    one, other = (annealed(which, CyclicAnnealing(), net, PLATE, GRADED, force=force)[0] for which in (COMPILED, NUMPY))
    assert_same(one, other)


def test_calm_bubbles_are_spared_by_both():
    net = net_of(PLATE, GRADED, again=True)
    scheme = SparingAnnealing(effort="fast", calm=lambda bubbles: bubbles.x[:, 0] < 6)
    one, other = (annealed(which, scheme, net, PLATE, GRADED)[0] for which in (COMPILED, NUMPY))
    everywhere, _ = annealed(COMPILED, CyclicAnnealing(effort="fast"), net, PLATE, GRADED)
    assert_same(one, other)
    far = net.bubbles.x[:, 0] < 1.5
    moves = [np.hypot(*(relaxed.bubbles.x - net.bubbles.x)[far].T).mean() for relaxed in (one, everywhere)]
    assert moves[0] < 0.9 * moves[1]


def test_displacements_that_flips_cannot_follow_are_connected_anew(monkeypatch):
    """Displacements of half a spacing invert triangles, and throw bubbles out of the domain."""
    domain, spacing, bubbles = packed_hexagon(5)
    x = bubbles.x.copy()
    x[bubbles.interior] += np.random.default_rng(1).normal(0, 0.2, x[bubbles.interior].shape)
    net = connect(replace(bubbles, x=x), domain).spaced_by(spacing)
    counted = []
    scheme = CyclicAnnealing(amplitude=0.5, amplitude_at_boundary=1.0)
    anew = Connected.__call__

    def counting(self, net, *rest):
        counted.append(len(net.bubbles))
        return anew(self, net, *rest)

    monkeypatch.setattr(Connected, "__call__", counting)
    one, _ = annealed(COMPILED, scheme, net, domain, spacing)
    by_hand = len(counted)
    other, _ = annealed(NUMPY, scheme, net, domain, spacing)
    assert_same(one, other)
    assert 0 < by_hand < len(counted) - by_hand == scheme.cycles(len(bubbles))
    assert counted[-1] < len(bubbles)


def test_bubbles_whose_order_rounding_decides_are_connected_exactly():
    """Squares of bubbles: where nothing is displaced, no flip is sure."""
    domain, spacing = Domain.of(rings.rectangle(0, 0, 6, 6)), uniform(1.0)
    start = ErrorDiffusion()(domain, spacing, 10_000)
    shell = start.select(np.arange(start.boundary_count))
    inside = np.stack(np.meshgrid(*2 * [np.arange(1.0, 6.0)]), axis=-1).reshape(-1, 2)
    net = connect_inside(shell.append(inside, np.ones(len(inside))), domain, spacing)
    scheme = SparingAnnealing(effort="fast", calm=lambda bubbles: np.ones(len(bubbles), bool))
    one, other = (annealed(which, scheme, net, domain, spacing)[0] for which in (COMPILED, NUMPY))
    assert_same(one, other)


def test_bubbles_outside_the_triangles_go():
    """Between a chord and its arc there is room for a bubble that no triangle holds."""
    disc, spacing = Domain.of(rings.circle((0, 0), 2)), uniform(0.5)
    start = connect(ErrorDiffusion()(disc, spacing, 10_000), disc).bubbles
    ends = start.x[:2]
    outside = 0.5 * ends.sum(axis=0) / np.hypot(*(0.5 * ends.sum(axis=0))) * 1.999
    net = connect(start.append(outside[None], np.array([0.5])), disc)
    assert (net.valence == 0).sum() == 1
    for seed in range(3):
        one, other = (
            annealed(which, CyclicAnnealing(effort="fast"), net, disc, spacing, seed)[0] for which in (COMPILED, NUMPY)
        )
        assert_same(one, other)
        assert len(one.bubbles) <= len(net.bubbles)


@pytest.mark.parametrize(
    "changes", [["packing.shake_steps=25"], ["packing.motion=runge-kutta"], ["packing.relaxation=nearby"]], ids=str
)
def test_schemes_that_the_kernel_does_not_know_are_gone_through_by_hand(changes):
    case = load_case("plate.yaml", text=PLATE_CASE, overrides=changes)
    one = mesh_case(case).mesh
    with run_by(NUMPY):
        other = mesh_case(case).mesh
    assert one.points.tobytes() == other.points.tobytes()
    assert one.triangles.tobytes() == other.triangles.tobytes()
