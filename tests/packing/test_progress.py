from dataclasses import replace

import numpy as np
import pytest
from invariants import check_mesh

from bubblemesh.case import load_case
from bubblemesh.packing.circles import SMOOTHING
from bubblemesh.packing.mending import NoMending
from bubblemesh.packing.methods import METHODS
from bubblemesh.packing.progress import TimeUp
from bubblemesh.packing.rounds import rounds
from bubblemesh.packing.smoothing import NoSmoothing
from bubblemesh.problem.prepare import prepare
from bubblemesh.process import watchdog
from bubblemesh.run.pipeline import mesh_case

CASE = """
domain:
  outer: {rectangle: [0, 0, 4, 2]}
  holes: [{circle: {center: [1, 1], radius: 0.4}}]
spacing: 0.06
"""
METHOD = "method: {}\nschedule: {{rounds: 3, iterations: 20}}\n"


def problem_of(text):
    return prepare(load_case("plate.yaml", text=text))


def packed(problem, watch):
    levels = problem.method.levels(problem.domain, problem.packing_spacing, problem.expected_nodes)
    start = problem.method.placement(problem.domain, levels[0], 10**6)
    return levels, [*rounds(start, problem.domain, levels, problem.method, watch)]


class Stopwatch:
    """Ends the packing at a share of it."""

    def __init__(self, share=np.inf):
        self.share = share
        self.told = []

    def __call__(self, share):
        self.told.append(share)
        if share >= self.share:
            raise TimeUp("enough")


@pytest.mark.long
@pytest.mark.parametrize("method", ["bpm", "fnpbs", "accelerated"])
def test_published_methods_tell_their_progress(method):
    watch = Stopwatch()
    packed(problem_of(CASE + METHOD.format(method)), watch)
    assert watch.told == sorted(watch.told)
    assert 0 <= watch.told[0] < 0.01
    assert 0.4 < watch.told[-2] <= watch.told[-1] == 1
    assert len(watch.told) > 60


def test_multilevel_tells_its_progress_evenly():
    watch = Stopwatch()
    levels, _ = packed(problem_of(CASE), watch)
    assert len(levels) > 1
    assert watch.told == sorted(watch.told)
    assert 0.5 < watch.told[-2] <= watch.told[-1] == 1
    assert np.diff(watch.told[:-1]).max() < 0.3


def test_stages_begin_with_the_coarsest_level_and_finish_once():
    stages = METHODS["multilevel"].stages(3, 200)
    assert [(stage.rank.coarser, stage.annealing, stage.finishing) for stage in stages] == [
        (0, False, False),
        (0, True, False),
        (1, False, False),
        (1, True, False),
        (2, False, True),
    ]
    assert all(stage.work > 0 for stage in stages)
    (alone,) = METHODS["fnpbs"].stages(1, 200)
    assert (alone.annealing, alone.finishing) == (False, True)


def test_without_smoothing_no_work_is_expected_for_it():
    method = METHODS["multilevel"]
    assert replace(method, smoothing=NoSmoothing()).finishing_work(200) == 0
    assert replace(method, mending=NoMending()).finishing_work(200) == SMOOTHING * method.smoothing.passes * 200


def test_single_level_is_annealed_and_finished():
    assert [(s.annealing, s.finishing) for s in METHODS["multilevel"].stages(1, 200)] == [
        (False, False),
        (True, True),
    ]


@pytest.mark.long
@pytest.mark.parametrize("share", [0.0, 0.05, 0.3, 0.6])
def test_packing_that_is_cut_short_has_the_requested_spacing(share):
    problem = problem_of(CASE)
    _, done = packed(problem, Stopwatch(share))
    assert done[-1].stop_reason == "enough"
    assert [one.late for one in done] == [False] * (len(done) - 1) + [True]
    assert [one.number for one in done] == [*range(1, len(done) + 1)]
    assert done[-1].before + done[-1].inserted - done[-1].deleted == len(done[-1].bubbles)
    if len(done) > 1:
        assert done[-1].before == len(done[-2].bubbles)
    assert 0.8 < len(done[-1].bubbles) / problem.expected_nodes < 1.1
    np.testing.assert_allclose(done[-1].bubbles.d, 0.06)


@pytest.mark.long
def test_later_end_gives_better_triangles(monkeypatch):
    for grace in ("GRACE", "SHORT_GRACE"):  # that all is over in time is not what is tested here
        monkeypatch.setattr(watchdog, grace, 60.0)
    text = CASE.replace("0.06", "0.03")
    seconds = [1e-9, 1e9]
    results = [mesh_case(load_case("plate.yaml", text=f"{text}limits: {{seconds: {limit}}}\n")) for limit in seconds]
    for result in results:
        check_mesh(result.mesh)
    cut, whole = (result.report for result in results)
    assert (cut["finished"], whole["finished"]) == (False, True)
    assert cut["stop_reason"] == "the time limit of 1e-09 s"
    assert any("time limit" in warning for warning in cut["warnings"])
    assert not any("time limit" in warning for warning in whole["warnings"])
    assert cut["quality"]["mean"] < whole["quality"]["mean"]


def test_end_in_the_smoothing_keeps_the_passes_before():
    problem = problem_of(CASE)
    watch = Stopwatch()
    packed(problem, watch)
    *_, last, whole = watch.told
    assert whole == 1
    _, late = packed(problem, Stopwatch(last))
    _, early = packed(problem, Stopwatch(0.0))
    assert late[-1].net.valence is not None

    def irregular(done):
        net = done[-1].net
        return np.mean(net.valence[net.bubbles.interior] != 6)

    assert irregular(late) < irregular(early)
