"""The section on the metric of a report's page."""

import numpy as np
import pytest
from metrics import FRONT, metric_case
from scipy.spatial import Delaunay

from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.metric import ENTRIES
from bubblemesh.meshes.tensors import of_axes
from bubblemesh.pages import metric as page
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


def section_and_view(along, monkeypatch):
    """The section of a unit square with ellipses .01 wide and ``along(x, y)`` long, and the box that it shows."""
    x, y = np.meshgrid(np.linspace(0, 1, 22), np.linspace(0, 1, 22))
    nodes, none, views = np.column_stack([x.ravel(), y.ravel()]), np.zeros((0, 2), int), []
    mesh = Mesh(nodes, Delaunay(nodes).simplices.astype(int), none, none[:, 0], ())
    monkeypatch.setattr(page, "small_png", lambda mesh, options, data: views.append(options.view) or b"")
    x, y = nodes[mesh.triangles].mean(axis=1).T
    tensors = of_axes(np.full(len(x), 0.01), along(x, y), np.tile([0.8, 0.6], (len(x), 1)))
    row = {"aspect": 3, "edges_within": 1, "shortened": None}
    return str(metric_section(mesh, dict(zip(ENTRIES, tensors.T, strict=True)), row)), views[0]


def test_ellipses_that_are_the_same_everywhere_are_shown_in_the_middle(monkeypatch):
    section, view = section_and_view(lambda x, y: 0 * x + 0.05, monkeypatch)
    assert "as they are everywhere" in section
    assert "longest" not in section
    np.testing.assert_allclose(view, [0.3, 0.4, 0.7, 0.6], atol=0.05)


@pytest.mark.parametrize(
    ("along", "expected"),
    [(lambda x, y: 0.05 + 0.01 * (x + y), [0.44, 0.72, 1, 1]), (lambda x, y: 1 + x + y, [-0.5, 0, 1.5, 1])],
)
def test_the_picture_of_the_longest_ellipses_has_little_beside_the_domain(along, expected, monkeypatch):
    section, view = section_and_view(along, monkeypatch)
    assert "where they are longest" in section
    np.testing.assert_allclose(view, expected, atol=0.02)
