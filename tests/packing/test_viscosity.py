import numpy as np
import pytest

from bubblemesh.packing.viscosity import OddBubbles, SawTooth


def test_saw_tooth_starts_at_c0_and_rises_by_step_and_by_round():
    c = SawTooth(c0=1.0, c_in=0.01, c_out=0.2)
    assert c(0, 0) == 1.0
    assert c(100, 0) == pytest.approx(2.0)
    assert c(0, 3) == pytest.approx(1.6)
    assert c(100, 3) == pytest.approx(2.6)


def test_saw_tooth_falls_at_the_start_of_each_round():
    c = SawTooth()
    ends, starts = [c(249, k) for k in range(9)], [c(0, k + 1) for k in range(9)]
    assert all(start < end for start, end in zip(starts, ends, strict=True))
    assert starts == sorted(starts)


def test_explicit_damping_stays_stable_in_the_longest_schedule():
    assert SawTooth()(249, 9) * 0.2 < 2


def test_odd_bubbles_take_their_own_viscosity():
    c = OddBubbles(c_odd=0.5)(3.0, np.array([False, True, False]))
    assert c.tolist() == [[3.0], [0.5], [3.0]]


def test_viscosity_stays_one_number_without_odd_bubbles():
    assert OddBubbles()(3.0, np.zeros(4, bool)) == 3.0


@pytest.mark.parametrize(("before", "after", "active"), [(100, 95, True), (100, 105, True), (100, 94, False)])
def test_odd_bubbles_begin_when_the_population_settles(before, after, active):
    assert OddBubbles(odd_start=0.05).active(before, after) is active


def test_odd_bubbles_can_wait_for_no_change_at_all():
    scheme = OddBubbles(odd_start=0.0)
    assert scheme.active(700, 700)
    assert not scheme.active(700, 701)
