"""docs/spacing.md keeps its promises, and what it shows makes good meshes."""

import re

import numpy as np
import pytest
from invariants import check_area, check_arrays, check_edges, check_facets_do_not_cross, check_labels
from paths import ROOT

from benchmarks.growth import BEGIN, END, limited
from bubblemesh.case import load_case
from bubblemesh.case.spacing import SpacingTerms
from bubblemesh.run.pipeline import mesh_case

DOCS = ROOT / "docs"
PAGE = (DOCS / "spacing.md").read_text()
CASES = re.findall(r"```yaml\n(.*?)```", PAGE.partition("\n## Fields\n")[0], flags=re.DOTALL)
GALLERY = DOCS.parent / "configs" / "gallery" / "tunnels.yaml"


def meshed(text):
    return mesh_case(load_case("page.yaml", text=text))


def check(mesh):
    """All that holds where corners of interfaces and embedded lines come before other nodes of the boundary, too."""
    for invariant in (check_arrays, check_edges, check_facets_do_not_cross, check_area, check_labels):
        invariant(mesh)


@pytest.mark.long
@pytest.mark.parametrize("text", [*CASES, GALLERY.read_text()], ids=lambda text: text.splitlines()[0][:30])
def test_cases_make_good_meshes_with_the_requested_spacing(text):
    result = meshed(text)
    check(result.mesh)
    report = result.report
    if "angle_min" in text:  # a blade with a sharp corner, where regions and sizes jump
        assert report["refinement"]["least_angle"] >= 25
        return
    assert report["warnings"] == []
    assert report["quality"]["min"] > 0.7
    assert report["quality"]["mean"] > 0.965
    assert report["spacing"]["mean"] == pytest.approx(1, abs=0.03)
    assert report["spacing"]["std"] < 0.095


def test_every_key_of_the_mapping_is_explained_and_shown():
    shown = "".join(re.findall(r"```yaml\n(.*?)```", PAGE, flags=re.DOTALL))
    for key in SpacingTerms.model_fields:
        assert f"`{key}:" in PAGE, key
        assert re.search(rf"\b{key}:", shown), key


def test_links_and_pictures_lead_to_files():
    for target in re.findall(r"\]\(([^)#]+)\)", PAGE):
        assert (DOCS / target).exists(), target


def test_the_page_has_the_table_of_its_benchmark():
    table = PAGE.partition(BEGIN)[2].partition(END)[0]
    assert len(table.strip().splitlines()) > 10


@pytest.mark.long
@pytest.mark.parametrize(("name", "growth"), [("example-2", 0.1), ("example-3", 0.1), ("dense", 0.2)])
def test_a_limit_of_growth_costs_neither_quality_nor_fit(name, growth):
    plain, slow = ([mesh_case(limited(name, g, seed)).report for seed in range(9)] for g in (None, growth))
    assert all(report["rules"]["ratio"] > 1.1 for report in slow)
    least = [np.median([report["quality"]["min"] for report in reports]) for reports in (plain, slow)]
    spread = [np.median([report["spacing"]["std"] for report in reports]) for reports in (plain, slow)]
    # The seeds differ by as much.
    assert least[1] > least[0] - 0.01
    assert spread[1] < spread[0] + 0.008
