"""The mapping under ``spacing`` in a case file: what it takes, and what it says of mistakes."""

import pytest

from bubblemesh.case import load_case
from bubblemesh.errors import CaseError

HEAD = "domain:\n  outer: {rectangle: [0, 0, 1, 1]}\n"


def loaded(spacing, more=""):
    return load_case("plate.yaml", text=f"{HEAD}spacing: {spacing}\n{more}")


@pytest.mark.parametrize(
    ("spacing", "message"),
    [
        ("{value: 0.1, growht: 0.2}", "plate.yaml:3: spacing.growht: unknown key; did you mean 'growth'?"),
        ("{growth: 0.2}", "plate.yaml:3: spacing: must have a value or a maximum"),
    ],
)
def test_mistakes_are_named_with_their_place(spacing, message):
    with pytest.raises(CaseError) as caught:
        loaded(spacing)
    assert message in str(caught.value)
