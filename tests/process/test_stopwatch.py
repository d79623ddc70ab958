"""The stages of a run are measured, each without those within it."""

from contextlib import suppress

from bubblemesh.case import load_case
from bubblemesh.problem.prepare import prepare
from bubblemesh.process.stopwatch import Stopwatch

CASE = """
domain: {outer: {rectangle: [0, 0, 2, 1], label: wall}}
spacing: 0.2
layers: [{on: wall, first: 0.02, count: 3}]
metric: {angle: 0, across: 0.1}
"""


def test_a_stage_within_another_one_counts_by_itself_and_what_was_before_stays(monkeypatch):
    clock = [0.0]
    monkeypatch.setattr("bubblemesh.process.stopwatch.perf_counter", lambda: clock[0])
    stopwatch = Stopwatch({"reading": 5.0})
    with stopwatch.stage("spacing"):
        clock[0] += 1
        with stopwatch.stage("layers"):
            clock[0] += 2
        before = stopwatch.seconds
        clock[0] += 4
    with suppress(ValueError), stopwatch.stage("layers"):
        clock[0] += 8
        raise ValueError
    assert before == {"reading": 5.0, "layers": 2.0}
    assert stopwatch.seconds == {"reading": 5.0, "spacing": 5.0, "layers": 10.0}


def test_a_problem_has_the_time_of_all_stages_that_made_it():
    problem = prepare(load_case("plate.yaml", text=CASE))
    assert problem.seconds.keys() == {"geometry", "spacing", "metric", "layers"}
    assert min(problem.seconds.values()) > 0
