"""The cases on the page on geometry are cases."""

import re

import pytest
from paths import ROOT

from bubblemesh.case import load_case
from bubblemesh.problem.domain import case_domain

PAGE = (ROOT / "docs/geometry.md").read_text()
HOLES = {"mended": 0, "moved": 33, "site": 0, "named": 1, "overlaid": 4}  # in the order of the page
DRAWN = [block for block in re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL) if "spacing:" in block]


@pytest.mark.parametrize(("block", "holes"), [*zip(DRAWN, HOLES.values(), strict=True)], ids=HOLES)
def test_what_is_drawn_on_the_page_is_a_domain(block, holes):
    domain = case_domain(load_case("page.yaml", text=block))
    assert domain.piece_count == 1
    assert domain.hole_count == holes
