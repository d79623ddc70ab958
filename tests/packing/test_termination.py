import pytest

from bubblemesh.packing.termination import FixedRounds, SelfAdaptive, Settled

SETTLED, UNSETTLED = (1000, 995), (1000, 994)


def test_fixed_rounds_go_on_to_their_number():
    rounds = FixedRounds(rounds=3)
    assert rounds([SETTLED]) is None
    assert rounds([SETTLED] * 2) is None
    assert rounds([SETTLED] * 3) == "all 3 rounds done"


@pytest.mark.parametrize(
    ("counts", "stops"),
    [
        ([SETTLED], False),
        ([SETTLED, SETTLED], True),
        ([SETTLED, UNSETTLED], False),
        ([UNSETTLED, SETTLED], False),
        ([SETTLED, UNSETTLED, SETTLED], False),
        ([UNSETTLED, SETTLED, SETTLED], True),
        ([(1000, 1005), (1005, 1000)], True),
        ([(1000, 1006), (1006, 1006)], False),
    ],
)
def test_self_adaptive_stops_after_two_settled_rounds(counts, stops):
    reason = SelfAdaptive()(counts)
    assert (reason is not None) is stops
    if stops:
        assert reason == "population changed by at most 0.5% in two rounds"


def test_self_adaptive_keeps_the_cap_of_rounds():
    assert SelfAdaptive(rounds=4)([UNSETTLED] * 3) is None
    assert SelfAdaptive(rounds=4)([UNSETTLED] * 4) == "all 4 rounds done"


def test_tolerance_is_part_of_the_reason():
    assert SelfAdaptive(tolerance=0.02)([(100, 98), (98, 97)]) == "population changed by at most 2.0% in two rounds"


@pytest.mark.parametrize(
    ("counts", "stops"),
    [
        ([SETTLED], True),
        ([UNSETTLED], False),
        ([UNSETTLED, SETTLED], True),
        ([SETTLED, UNSETTLED], False),
        ([(1000, 1005)], True),
        ([(1000, 1006)], False),
    ],
)
def test_settled_stops_after_one_round_that_hardly_changed_the_population(counts, stops):
    reason = Settled()(counts)
    assert (reason is not None) is stops
    if stops:
        assert reason == "population changed by at most 0.5% in a round"


def test_settled_keeps_the_cap_of_rounds():
    assert Settled(rounds=4)([UNSETTLED] * 3) is None
    assert Settled(rounds=4)([UNSETTLED] * 4) == "all 4 rounds of the last level done"


def test_opening_round_of_settled_has_steps_of_its_own():
    scheme = Settled(iterations=12, opening_iterations=70)
    assert (scheme.steps(opening=True), scheme.steps(opening=False)) == (70, 12)
    for other in (FixedRounds(iterations=9), SelfAdaptive(iterations=9)):
        assert (other.steps(opening=True), other.steps(opening=False)) == (9, 9)


def test_expected_steps_are_those_of_all_rounds_and_the_last_relaxation():
    assert FixedRounds(rounds=4, iterations=9).expected_steps(opening=True) == 45
    scheme = Settled(iterations=12, opening_iterations=70)
    assert (scheme.expected_steps(opening=True), scheme.expected_steps(opening=False)) == (82, 24)
