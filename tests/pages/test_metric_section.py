"""The section on the metric of a report's page."""

from metrics import FRONT, metric_case

from bubblemesh.pages.metric import metric_section
from bubblemesh.run.pipeline import mesh_case


def test_a_page_tells_the_figures_of_the_metric_and_draws_ellipses():
    result = mesh_case(metric_case({**FRONT, "across": FRONT["across"].replace("0.02", "0.004")}))
    section = str(metric_section(result.mesh, result.fields, result.report["metric"]))
    row = result.report["metric"]
    assert f"{row['edges_within']:.1%} of the edges are between 0.71 and 1.41 long in the metric" in section
    assert f"{row['shortened']['ratio']:.3g} times at" in section
    assert "the metric turns faster than straight edges can. With the shorter ones" in section
    assert section.count("<img") == 1
    assert "where they are longest" in section


def test_a_page_without_metric_has_no_such_section():
    result = mesh_case(metric_case(None, spacing=0.2))
    assert str(metric_section(result.mesh, result.fields, result.report.get("metric"))) == ""
