"""Advice in messages on files: the key with the value that they name works."""

import re

import pytest
from geometry_files import domain

from bubblemesh.errors import GeometryError

GAPS = "LINESTRING (0 0, 4 0)\nLINESTRING (4 0.01, 4 3)\nLINESTRING (3.98 3, 0 3)\nLINESTRING (0 3, 0 0)"
BESIDE = "LINESTRING (1 1, 2 1)\nLINESTRING (0 0, 4 0, 4 3, 0 3, 0 0)\nLINESTRING (1 2, 2 2, 2 2.5, 1 2)"


def message(path, **keys):
    with pytest.raises(GeometryError) as error:
        domain(path, **keys)
    return str(error.value)


def test_gaps_name_the_join_that_closes_all_of_them(written):
    path = written("a.wkt", GAPS)
    text = message(path)
    assert "the widest gap to a next one is 0.02, at (4, 3), the nearest 0.01" in text
    join = float(re.search(r"set join: (\S+), which closes all gaps", text)[1])
    assert 0.02 < join < 0.025
    assert domain(path, join=join).polygon.area == pytest.approx(12, rel=0.01)


@pytest.mark.parametrize("text", ["LINESTRING (0 0, 4 0, 4 3)", GAPS.replace("0 3, 0 0", "0 3, 0 1")])
def test_what_is_missing_is_no_gap_to_join(written, text):
    assert "draw what is missing" in message(written("a.wkt", text))
    assert "join" not in message(written("a.wkt", text))


def test_features_that_close_by_themselves_are_named_the_widest_first(written):
    path = written("a.wkt", BESIDE)
    text = message(path)
    assert re.search(r"what closes by itself: feature 1 .*, feature 2 .*: choose by feature: 1$", text)
    assert domain(path, feature=1).polygon.area == 12


def test_of_chosen_features_no_number_is_named(written):
    assert "closes by itself" not in message(written("a.wkt", BESIDE), feature=0)
