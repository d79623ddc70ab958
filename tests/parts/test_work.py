"""The work on one part: deadlines that travel to other processes."""

import pickle

import pytest

from bubblemesh.packing.progress import TimeUp
from bubblemesh.parts.work import Deadline

HERE, THERE = 1000.0, 5.0  # what the clocks of two processes say that nobody sets


@pytest.fixture
def clocks(monkeypatch):
    """Clocks of a process: one that nobody sets, and that of the day."""
    now = {"monotonic": HERE, "time": 1e9}
    for name in now:
        monkeypatch.setattr(f"bubblemesh.parts.work.{name}", lambda name=name: now[name])
    return now


@pytest.mark.parametrize("step", [-3600.0, 3600.0])
def test_a_deadline_does_not_go_with_a_clock_that_is_set(clocks, step):
    deadline = Deadline.within(10.0)
    clocks["time"] += step
    assert deadline.left == 10
    clocks["monotonic"] += 10
    with pytest.raises(TimeUp):
        deadline.watch(0.5)


@pytest.mark.parametrize(("waited", "left"), [(0.0, 10.0), (4.0, 6.0), (40.0, -30.0), (-3600.0, 10.0)])
def test_in_another_process_a_deadline_has_the_seconds_left_less_those_on_the_way(clocks, waited, left):
    sent = pickle.dumps(Deadline.within(10.0))
    clocks.update({"monotonic": THERE, "time": clocks["time"] + waited})
    assert pickle.loads(sent).left == left
