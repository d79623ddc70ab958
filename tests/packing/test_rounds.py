from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from examples import EXAMPLES
from invariants import check_mesh
from lattices import hexagon, packed_hexagon, uniform
from twins import needs_compiler

from bubblemesh.case import load_case
from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.triangulation import linked
from bubblemesh.packing import net as nets
from bubblemesh.packing.annealing import NoAnnealing
from bubblemesh.packing.mending import NoMending
from bubblemesh.packing.methods import METHODS
from bubblemesh.packing.neighbours import Neighbours
from bubblemesh.packing.net import connect
from bubblemesh.packing.progress import Progress
from bubblemesh.packing.relaxation import Relaxed
from bubblemesh.packing.rounds import rounds
from bubblemesh.packing.setting import Setting
from bubblemesh.packing.termination import FixedRounds
from bubblemesh.problem.prepare import prepare
from bubblemesh.run.pipeline import mesh_case
from bubblemesh.spacing.spacing import Spacing

ACCELERATED = METHODS["accelerated"]


def run_of(seed=0, **schedule):
    overrides = [f"schedule.{key}={value}" for key, value in schedule.items()]
    problem = prepare(load_case("example.yaml", text=EXAMPLES["2"], seed=seed, overrides=overrides))
    start = problem.method.placement(problem.domain, problem.packing_spacing, 10_000)
    return start, list(rounds(start, problem.domain, [problem.packing_spacing], problem.method)), problem.method


@pytest.fixture(scope="module")
def run():
    return run_of()


def test_perfect_packing_hardly_moves():
    domain, spacing, bubbles = packed_hexagon(5)
    at_rest = replace(ACCELERATED.perturbation, jitter=0.0)
    method = replace(ACCELERATED, perturbation=at_rest, termination=FixedRounds(rounds=2, iterations=100))
    for done in rounds(bubbles, domain, [spacing], method):
        assert (done.deleted, done.inserted) == (0, 0)
        np.testing.assert_allclose(done.bubbles.x, bubbles.x, atol=1e-9)


def test_bubbles_that_neither_come_nor_go_stay_connected_as_they_are():
    domain, spacing, bubbles = packed_hexagon(5)
    setting = Setting(domain, np.random.default_rng(0), Progress([], lambda share: None))
    packing = METHODS["multilevel"].packing(bubbles, spacing, setting)
    before = packing.net
    assert packing.control() == 0
    assert packing.net.triangles is before.triangles
    np.testing.assert_array_equal(packing.net.start, before.bubbles.x)


@needs_compiler
def test_annealed_bubbles_are_not_triangulated_anew_however_far_they_have_gone(monkeypatch):
    sizes = []

    def noted(points, *others):
        sizes.append(len(points))
        return linked(points, *others)

    monkeypatch.setattr(nets, "linked", noted)
    spacing = Spacing(lambda x, y: 0.4 * np.abs(np.hypot(x, y) - 2) + 0.3, 0.3)
    domain, method = Domain.of(rings.rectangle(-3, -3, 3, 3)), METHODS["multilevel"]
    method = replace(method, perturbation=replace(method.perturbation, seed=1), mending=NoMending())
    start = method.placement(domain, spacing, 10_000)
    *_, last = rounds(start, domain, [spacing], method)
    assert sizes == [len(start)]
    np.testing.assert_array_equal(last.net.triangles, connect(last.bubbles, domain).triangles)


def test_disturbed_packing_returns_to_the_perfect_one():
    domain, spacing, bubbles = packed_hexagon(5)
    disturbing = replace(ACCELERATED.perturbation, jitter=0.1)
    assert np.abs(disturbing(bubbles, spacing, disturbing.generator()).x - bubbles.x).max() > 0.1
    method = replace(ACCELERATED, perturbation=disturbing, termination=FixedRounds(rounds=2, iterations=250))
    *_, last = rounds(bubbles, domain, [spacing], method)
    np.testing.assert_allclose(last.bubbles.x, bubbles.x, atol=1e-3)


@pytest.mark.long
def test_counts_of_each_round_add_up(run):
    start, done, _ = run
    assert done[0].before == len(start)
    for one in done:
        assert one.before - one.deleted + one.inserted == len(one.bubbles)
        assert one.deleted >= 0
        assert one.inserted >= 0
    for one, following in pairwise(done):
        assert following.before == len(one.bubbles)
        assert following.number == one.number + 1


def test_bubbles_that_keep_chords_apart_count_as_inserted():
    domain = Domain.of(rings.circle((0, 0), 1), [rings.circle((0, 0), 0.995)])
    spacing = Spacing(lambda x, y: 0.5 + 0.2 * (x + 1))
    method = replace(ACCELERATED, termination=FixedRounds(rounds=3, iterations=40))
    start = method.placement(domain, spacing, 10_000)
    done = list(rounds(start, domain, [spacing], method))
    assert done[0].before == len(start)
    for one in done:
        assert one.before - one.deleted + one.inserted == len(one.bubbles)
        assert one.deleted >= 0
    assert sum(one.inserted for one in done) > 0


def test_only_the_last_round_has_a_reason_to_stop(run):
    _, done, _ = run
    assert [one.stop_reason is None for one in done] == [True] * (len(done) - 1) + [False]


def test_last_round_finishes_with_a_relaxation(run):
    _, done, method = run
    steps = method.termination.iterations
    assert [len(one.speeds) for one in done[:-1]] == [steps] * (len(done) - 1)
    assert len(done[-1].speeds) >= 2 * steps
    assert len(done[-1].speeds) % steps == 0


@pytest.mark.parametrize(("lost", "relaxations"), [([0, 0], 2), ([0, 1, 0], 3), ([0, 2, 1, 0], 4), ([0] + [1] * 9, 5)])
def test_last_relaxation_is_repeated_while_bubbles_are_lost(lost, relaxations):
    domain, spacing, bubbles = packed_hexagon(4)
    calls = iter(lost)

    def relaxation(net, domain, spacing, dynamics, steps):
        return Relaxed(net.bubbles, 0, next(calls), np.zeros(steps), 7)

    method = replace(ACCELERATED, relaxation=relaxation, termination=FixedRounds(rounds=1, iterations=10))
    (done,) = rounds(bubbles, domain, [spacing], method)
    assert len(done.speeds) == 10 * relaxations
    assert done.evaluations == 7 * relaxations


@dataclass
class Recorded:
    """A scheme that notes when it is called."""

    name: str
    scheme: Any
    order: list[str]

    def __call__(self, *arguments):
        self.order.append(self.name)
        return self.scheme(*arguments)

    def of_worst(self, *arguments):
        self.order.append(f"{self.name} of the worst")
        return self.scheme.of_worst(*arguments)

    def __getattr__(self, name):
        return getattr(self.scheme, name)


def test_smoothing_takes_turns_with_population_control_and_mending_ends():
    domain, spacing, bubbles = packed_hexagon(4)
    order, method = [], replace(METHODS["multilevel"], annealing=NoAnnealing())
    parts = ("population", "smoothing", "mending")
    method = replace(method, **{part: Recorded(part, getattr(method, part), order) for part in parts})
    *_, last = rounds(bubbles, domain, [spacing], method)
    passes = ["smoothing", "population", "smoothing", "population", "smoothing"]
    assert order[-8:] == [*passes, "smoothing of the worst", "mending", "smoothing of the worst"]
    assert set(order[:-8]) == {"population"}
    assert last.stop_reason is not None


def test_every_level_but_the_last_of_several_is_annealed_once():
    domain, spacing, bubbles = packed_hexagon(4)
    for levels, annealed in ([spacing], 1), ([spacing, uniform(0.5)], 1), ([spacing, uniform(0.5), uniform(0.25)], 2):
        order = []
        method = METHODS["multilevel"]
        annealing = Recorded("annealing", replace(method.annealing, effort="fast"), order)
        done = list(rounds(bubbles, domain, levels, replace(method, annealing=annealing)))
        assert len(order) == annealed
        assert len(done[-1].bubbles) == len(hexagon(4 * 2 ** (len(levels) - 1)))


def test_force_evaluations_are_bubbles_times_steps_times_stages(run):
    _, done, method = run
    steps, stages = method.termination.iterations, method.motion.evaluations
    assert [one.evaluations for one in done[:-1]] == [one.before * steps * stages for one in done[:-1]]
    last = done[-1]
    both = (last.before + len(last.bubbles)) * steps * stages
    assert last.evaluations == pytest.approx(both * len(last.speeds) / (2 * steps), rel=0.02)


def test_bubbles_come_to_rest(run):
    _, done, _ = run
    assert done[-1].speeds[-1] < 0.01 * done[0].speeds.max()


def test_spacing_is_that_of_the_places(run):
    _, done, _ = run
    last = done[-1].bubbles
    np.testing.assert_allclose(last.d, np.hypot(*last.x.T) / 8, rtol=1e-12)


def test_rounds_are_capped():
    _, done, _ = run_of(rounds=2, iterations=20, tolerance=0.0)
    assert len(done) == 2
    assert done[-1].stop_reason == "all 2 rounds done"
    assert len(done[-1].speeds) >= 40


def test_same_seed_gives_the_same_bytes_and_another_seed_another_mesh():
    meshes = []
    for seed in (3, 3, 4):
        case = load_case("example.yaml", text=EXAMPLES["2"], seed=seed, overrides=["schedule.iterations=100"])
        meshes.append(mesh_case(case).mesh)
        check_mesh(meshes[-1])
    one, same, other = meshes
    for name in ("points", "triangles", "facets", "facet_labels"):
        assert getattr(one, name).tobytes() == getattr(same, name).tobytes()
    assert one.points.tobytes() != other.points.tobytes()


def test_neighbours_go_by_the_spacing_where_the_bubbles_are(monkeypatch):
    listed = []

    class Spied(Neighbours):
        @classmethod
        def of(cls, x, d, reach):
            listed.append(np.abs(d / (np.hypot(*x.T) / 8) - 1).max())
            return Neighbours.of(x, d, reach)

    monkeypatch.setattr("bubblemesh.packing.relaxation.Neighbours", Spied)
    run_of(rounds=2, iterations=40)
    assert len(listed) >= 8
    assert max(listed[1:]) < 1e-12  # the first start is displaced by less than a hundredth of the spacing
