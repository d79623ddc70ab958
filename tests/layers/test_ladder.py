"""Heights of layers from any two of a first height, a count and a thickness."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bubblemesh.layers.ladder import Ladder, count_of, first_of, growth_of

GROWTHS = st.floats(1.0, 2.0)


def test_heights_grow_geometrically_and_tops_are_their_sums():
    ladder = Ladder(("wall",), first=0.1, growth=2.0, count=4)
    assert ladder.heights == pytest.approx([0.1, 0.2, 0.4, 0.8])
    assert ladder.tops == pytest.approx([0, 0.1, 0.3, 0.7, 1.5])


def test_the_thickness_below_a_spacing_leaves_out_higher_layers():
    ladder = Ladder(("wall",), first=0.1, growth=2.0, count=4)
    assert ladder.thickness_below(np.array([0.05, 0.1, 0.3, 0.4, 9])) == pytest.approx([0, 0.1, 0.3, 0.7, 1.5])


def test_above_a_layer_that_is_too_high_lower_ones_do_not_count():
    ladder = Ladder(("wall",), 1.0, 0.9, 3)
    assert ladder.thickness_below(np.array([0.95, 1.0])) == pytest.approx([0, 2.71])


@given(st.floats(1e-6, 1e3), GROWTHS, st.integers(1, 60))
def test_the_first_height_of_a_thickness_gives_it_back(thickness, growth, count):
    ladder = Ladder(("wall",), first_of(count, thickness, growth), growth, count)
    assert ladder.tops[-1] == pytest.approx(thickness, rel=1e-9)


@given(st.floats(1e-6, 1.0), GROWTHS, st.integers(1, 40))
def test_a_count_and_a_growth_that_give_a_thickness_are_found_again(first, growth, count):
    thickness = Ladder(("wall",), first, growth, count).tops[-1]
    assert count_of(first, thickness, growth) == count
    if count > 1:
        assert growth_of(first, count, thickness) == pytest.approx(growth, rel=1e-6)
