"""The multilevel method from case to mesh."""

import os
import subprocess
import sys
from itertools import pairwise

import numpy as np
import pytest
from examples import BARE
from invariants import check_mesh
from sweeps import sweep

from bubblemesh.case import load_case
from bubblemesh.meshes.quality import radius_ratios
from bubblemesh.packing.annealing import NoAnnealing
from bubblemesh.packing.mending import NoMending
from bubblemesh.packing.methods import METHODS
from bubblemesh.packing.rounds import rounds
from bubblemesh.packing.smoothing import NoSmoothing
from bubblemesh.problem.prepare import prepare
from bubblemesh.run.pipeline import mesh_case

# Least mean, least worst quality, and largest share of irregular inner nodes.
FLOORS = {
    "1": (0.99, 0.8, 0.1),
    "2": (0.985, 0.8, 0.2),
    "3": (0.98, 0.8, 0.2),
    "4": (0.984, 0.75, 0.25),
    "dense": (0.965, 0.75, 0.3),
}
FINE = """
domain: {outer: {rectangle: [-1, -1, 1, 1]}, holes: [{circle: {center: [0.1, 0], radius: 0.4}}]}
spacing: 0.03 + 0.005*(x + 1)
"""


def meshed(text, seed=0, *overrides):
    result = mesh_case(load_case("case.yaml", text=text, seed=seed, overrides=list(overrides)))
    check_mesh(result.mesh)
    return result


def run_of(text, seed=0):
    """Placed bubbles, spacings of the levels and rounds."""
    problem = prepare(load_case("case.yaml", text=text, seed=seed))
    method = problem.method
    levels = method.levels(problem.domain, problem.packing_spacing, problem.expected_nodes)
    start = method.placement(problem.domain, levels[0], 100_000)
    return problem, start, levels, list(rounds(start, problem.domain, levels, method))


@pytest.fixture(scope="module")
def fine():
    return run_of(FINE)


@pytest.mark.long
@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("example", BARE)
def test_examples_reach_their_quality(example, seed):
    report = meshed(BARE[example], seed).report
    mean, least, irregular = FLOORS[example]
    quality = report["quality"]
    assert quality["mean"] > mean
    assert quality["min"] > least
    assert quality["irregular_fraction"] < irregular
    assert 0.96 <= report["nodes"] / report["ideal_nodes"] <= 1.05
    assert report["spacing"]["mean"] == pytest.approx(1, abs=0.03)
    assert report["spacing"]["std"] < 0.1
    assert report["warnings"] == []
    assert report["method"] == "multilevel"


def test_fine_case_with_levels_is_better_than_a_coarse_one(fine):
    problem, start, levels, done = fine
    last = done[-1]
    assert len(levels) == 3
    assert len(start) < 0.1 * len(last.bubbles)
    q = radius_ratios(last.bubbles.x, last.net.triangles)
    assert q.mean() > 0.993
    assert q.min() > 0.75
    assert len(last.bubbles) == pytest.approx(problem.expected_nodes, rel=0.03)


def test_rounds_of_all_levels_are_numbered_and_their_counts_add_up(fine):
    _, start, levels, done = fine
    assert [one.number for one in done] == list(range(1, len(done) + 1))
    assert done[0].before == len(start)
    for one in done:
        assert one.before - one.deleted + one.inserted == len(one.bubbles)
        assert one.deleted >= 0
        assert one.inserted >= 0
        assert len(one.speeds) > 0
    growths = [following.before / len(one.bubbles) for one, following in pairwise(done)]
    assert sum(growth > 2 for growth in growths) == len(levels) - 1
    assert all(growth == 1 or 2.5 < growth < 5 for growth in growths)


def test_only_the_last_round_has_a_reason_to_stop(fine):
    _, _, _, done = fine
    assert [one.stop_reason is None for one in done] == [True] * (len(done) - 1) + [False]


def test_opening_round_has_the_most_steps_but_for_the_annealing(fine):
    problem, _, _, done = fine
    method = problem.method
    annealed = [one for one in done if len(one.speeds) >= 20 * method.annealing.shake_steps]
    assert len(done[0].speeds) == method.termination.opening_iterations
    assert len(annealed) >= 1
    assert all(len(one.speeds) == method.termination.iterations for one in done[1:] if one not in annealed)


def test_bubbles_of_the_last_round_have_the_requested_spacing_and_are_all_connected(fine):
    problem, _, _, done = fine
    net = done[-1].net
    np.testing.assert_allclose(net.bubbles.d, problem.packing_spacing(net.bubbles.x), rtol=1e-12)
    assert (net.valence > 0).all()
    distance = problem.domain.signed_distance(net.bubbles.x)
    assert (distance[net.bubbles.interior] > 0).all()
    assert np.abs(distance[: net.bubbles.boundary_count]).max() < 1e-12


@pytest.mark.parametrize("example", sweep(["2", "4"], quick=1))
def test_same_seed_gives_the_same_bytes_and_another_seed_another_mesh(example):
    one, same, other = (meshed(BARE[example], seed).mesh for seed in (3, 3, 4))
    for name in ("points", "triangles", "facets", "facet_labels"):
        assert getattr(one, name).tobytes() == getattr(same, name).tobytes()
    assert one.points.tobytes() != other.points.tobytes()


@pytest.mark.long
@pytest.mark.parametrize("example", ["1", "3"])
def test_more_effort_gives_better_meshes(example):
    means = {
        effort: np.mean(
            [meshed(BARE[example], seed, f"packing.effort={effort}").report["quality"]["mean"] for seed in (0, 1)]
        )
        for effort in ("fast", "best")
    }
    assert means["best"] > means["fast"]


@pytest.mark.long
@pytest.mark.parametrize("left_out", ["shaking", "polish", "mending", "levels"])
def test_each_part_can_be_left_out_and_is_worth_having(left_out):
    name = {"levels": "single"}.get(left_out, "none")
    text, measure = (BARE["4"], "min") if left_out == "mending" else (FINE, "mean")
    whole, less = (meshed(text, 0, *changes).report for changes in ((), (f"packing.{left_out}={name}",)))
    assert whole["quality"][measure] > less["quality"][measure]
    assert less["nodes"] == pytest.approx(whole["nodes"], rel=0.02)


@pytest.mark.long
@pytest.mark.parametrize(
    "override",
    [
        "packing.placement=subdivision",
        "packing.population=thresholds",
        "packing.relaxation=nearby",
        "packing.motion=euler",
        "schedule.viscosity=saw-tooth",
        "schedule.termination=fixed",
    ],
)
def test_schemes_of_the_published_methods_fit_in(override):
    report = meshed(BARE["2"], 0, override, "packing.effort=fast").report
    assert report["quality"]["mean"] > 0.95


@pytest.mark.long
@pytest.mark.parametrize("name", ["bpm", "accelerated"])
@pytest.mark.parametrize(
    "override",
    [
        "placement=diffusion",
        "levels=doubling",
        "relaxation=connected",
        "population=defects",
        "shaking=irregular",
        "polish=shape",
        "mending=patches",
        "motion=semi-implicit",
    ],
)
def test_schemes_fit_into_the_published_methods(name, override):
    text = f"{BARE['2']}method: {name}\nschedule: {{iterations: 20, rounds: 2}}\n"
    more = ["packing.effort=fast"] if override.startswith("shaking") else []
    report = meshed(text, 0, f"packing.{override}", *more).report
    key, _, scheme = override.partition("=")
    assert report["parameters"]["packing"][key] == scheme
    assert len(report["rounds"]) > 0
    assert report["quality"]["mean"] > 0.8


def test_the_table_has_the_method_with_all_its_schemes():
    idle = (NoAnnealing(), NoSmoothing(), NoMending())
    multilevel, accelerated = (
        (row.annealing, row.smoothing, row.mending) for row in (METHODS["multilevel"], METHODS["accelerated"])
    )
    assert not set(map(type, multilevel)) & set(map(type, idle))
    assert accelerated == idle


@pytest.mark.long
def test_processes_with_other_threads_and_hashes_write_the_same_bytes(tmp_path):
    (tmp_path / "case.yaml").write_text(BARE["4"])
    folders = []
    for number, (threads, hashes) in enumerate([("1", "0"), ("2", "12345")]):
        folder = tmp_path / f"out-{number}"
        variables = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), threads)
        command = [sys.executable, "-m", "bubblemesh", "run", "case.yaml", "-q", "-o", str(folder)]
        command += ["--format", "msh", "--format", "vtu", "--format", "xdmf"]
        environment = {**os.environ, **variables, "PYTHONHASHSEED": hashes}
        subprocess.run(command, cwd=tmp_path, env=environment, check=True, timeout=120)
        folders.append(folder)
    for ending in ("msh", "vtu", "xdmf"):
        one, other = ((folder / f"case.{ending}").read_bytes() for folder in folders)
        assert one == other
        assert len(one) > 500
