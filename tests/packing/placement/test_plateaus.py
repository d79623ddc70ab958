import numpy as np
import pytest
from lattices import uniform

from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.placement.plateaus import plateaus
from bubblemesh.spacing.spacing import Spacing

STRIP = Domain.of(rings.rectangle(0, 0, 2, 1))


def found(function, expected_nodes=0.0):
    return plateaus(STRIP, Spacing(function, 0.001), expected_nodes)


def test_an_even_spacing_is_one_plateau():
    (plateau,) = plateaus(STRIP, uniform(0.02), 0.0)
    assert (plateau.d, plateau.share) == (0.02, pytest.approx(1))
    assert plateau.bubbles == pytest.approx(2 / (0.02**2 * np.sqrt(3) / 2), rel=0.02)


def test_plateaus_have_their_shares_of_the_bubbles_the_most_frequent_first():
    fine, coarse = found(lambda x, y: np.clip(0.02 + 0.2 * (x - 1), 0.02, 0.04))
    bubbles = {0.02: 1 / 0.02**2, 0.04: 0.9 / 0.04**2}
    slope = 1 / 0.2 * (1 / 0.02 - 1 / 0.04)  # the integral of dx / d^2
    total = sum(bubbles.values()) + slope
    for plateau in (fine, coarse):
        assert plateau.share == pytest.approx(bubbles[plateau.d] / total, abs=0.02)
    assert (fine.d, coarse.d) == (0.02, 0.04)


@pytest.mark.parametrize("slope", [1e-2, 3e-3, 1e-1])
def test_a_gentle_slope_is_no_plateau(slope):
    assert found(lambda x, y: 0.02 + slope * x) == ()


def test_a_tenth_of_the_bubbles_is_the_least_that_counts():
    def shares(edge):  # of two even spacings with nothing between
        return {plateau.d: plateau.share for plateau in found(lambda x, y: np.where(x > edge, 0.04, 0.02))}

    assert shares(1.0) == {0.02: pytest.approx(0.8, abs=0.03), 0.04: pytest.approx(0.2, abs=0.03)}
    assert set(shares(1.7)) == {0.02}  # of 4 * 1.7 + 0.3 bubbles 0.3 are coarse


def test_plateaus_are_seen_in_larger_cells_if_very_many_nodes_are_expected():
    asked = []

    def function(x, y):
        asked.append(len(x))
        return np.full_like(x, 0.002)

    (plateau,) = found(function, expected_nodes=4e6)
    few = sum(asked)
    asked.clear()
    assert found(function) == (plateau,)
    assert few < sum(asked) / 3


def test_a_domain_thinner_than_the_cells_has_none():
    assert plateaus(Domain.of(rings.rectangle(0, 0, 2, 0.001)), uniform(0.05), 0.0) == ()
