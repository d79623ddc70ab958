"""The cases on the page on geometry are cases."""

import re

import pytest
from paths import ROOT

from bubblemesh.case import load_case
from bubblemesh.problem.domain import case_domain

PAGE = (ROOT / "docs/geometry.md").read_text()
DRAWN = [block for block in re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL) if "spacing:" in block]


@pytest.mark.parametrize("block", DRAWN, ids=["moved", "overlaid", "mended"])
def test_what_is_drawn_on_the_page_is_a_domain(block):
    domain = case_domain(load_case("page.yaml", text=block))
    assert domain.piece_count == 1
    assert domain.hole_count == (33 if "coil" in block else 0 if "repair" in block else 4)
