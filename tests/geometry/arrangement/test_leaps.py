"""Notes on embedded lines with vertices far outside of the domain, and none on lines that leave it as usual."""

import numpy as np
import pytest
from partitions import domain_of

WAVES = [[float(x), float(5 + np.sin(x))] for x in np.linspace(1, 400, 4000)]  # a river of a file that goes on


def notes_of(path, more=""):
    """Notes on one line in a square of 10 by 10 with a valley in its upper side."""
    ground = "  outer: {polygon: [[0, 0], [10, 0], [10, 10], [8, 10], [5, 4], [2, 10], [0, 10]]}\n"
    return domain_of(f"domain:\n{ground}  lines: [{{path: {path}, label: river{more}}}]\n").notes


@pytest.mark.parametrize(
    ("path", "told"),
    [
        (
            "[[1, 2], [3, 2], [3, -400], [4, 2]]",
            "99.256% of its length, as far as (3, -400), where the line comes",
        ),
        (
            "[[1, 2], [3, -9999], [4, -9999], [5, 2]]",
            "99.980% of its length, as far as (3, -9999), where the line",
        ),
        ("[[5, 2], [5000, 2]]", "99.900% of its length, as far as (5000, 2), where it ends: is a coordinate wrong?"),
        ("[[-5000, 2], [5, 2], [6, 3]]", "99.872% of its length, as far as (-5000, 2), where it ends"),
    ],
)
def test_a_wrong_digit_is_told_with_the_place_and_the_share_that_is_left_out(path, told):
    (note,) = notes_of(path)
    assert note.startswith("the line 'river' is outside of the domain with ")
    assert told in note


@pytest.mark.parametrize(
    "path",
    [
        "[[0, 6], [10, 6]]",  # across the valley
        "[[5, 2], [10.5, 2]]",  # just outside
        "[[5, 2], [80, 2]]",  # drawn to some length
        "[[-5000, 2], [5000, 2]]",  # from side to side
        "[[-1, 2], [5000, 2]]",
        "[[2, -5], [2, 5], [30, 5], [30, -5], [2, -5]]",  # a ring of something larger
        "[[5, 2], [40, 2], [40, -40], [8, -40], [8, 2]]",  # a way around
        WAVES,
        [*WAVES, *([x, y - 1] for x, y in WAVES[:0:-1])],
    ],
)
def test_lines_that_go_on_outside_are_not_told(path):
    assert notes_of(path) == ()
