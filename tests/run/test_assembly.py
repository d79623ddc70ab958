"""A mesh of connected bubbles has the labels of its domain."""

import json

import numpy as np
import pytest

from bubblemesh.case import load_case
from bubblemesh.geometry import rings
from bubblemesh.geometry.arrangement.regions import InnerParts
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.paths import InnerPoint
from bubblemesh.packing.net import connect_inside
from bubblemesh.packing.placement.diffusion import ErrorDiffusion
from bubblemesh.problem.domain import case_domain
from bubblemesh.run.assembly import mesh_of
from bubblemesh.spacing.expression import Expression
from bubblemesh.spacing.spacing import Spacing


def test_labelled_points_are_nodes_however_many_there_are():
    compared = []

    class Name(str):
        __hash__ = str.__hash__

        def __eq__(self, other):
            compared.append(self)
            return super().__eq__(other)

    names = [Name(f"well {k}") for k in range(300)]
    points = tuple(
        InnerPoint((0.1 + 0.8 * (k % 20) / 20, 0.1 + 0.8 * (k // 20) / 15), name) for k, name in enumerate(names)
    )
    domain, spacing = (
        Domain.of(rings.rectangle(0, 0, 1, 1), parts=InnerParts(points=points)),
        Spacing(Expression.parse("0.05")),
    )
    net = connect_inside(ErrorDiffusion()(domain, spacing, 10_000), domain, spacing)
    compared.clear()
    mesh = mesh_of(net, domain)
    assert len(compared) < 10 * len(names)
    assert [mesh.point_labels[k] for k in mesh.node_labels] == names
    np.testing.assert_allclose(mesh.points[mesh.labelled_nodes], [point.at for point in points])


SQUARE = "outer: {rectangle: [0, 0, 4, 4]}\n  region: matrix\n  "
COUNTER_CLOCKWISE = "polygon: [[1, 1], [3, 1], [3, 3], [1, 3]]"
CLOCKWISE = "polygon: [[1, 1], [1, 3], [3, 3], [3, 1]]"


def regions_on_the_left(tmp_path, keys):
    """Regions on the left of the facets with each label, of a domain with these keys beside its outer ring."""
    case = load_case(tmp_path / "case.yaml", text=f"domain:\n  {SQUARE}{keys}\nspacing: 0.6\n")
    domain = case_domain(case)
    spacing = Spacing(Expression.parse("0.6"))
    mesh = mesh_of(connect_inside(ErrorDiffusion()(domain, spacing, 10_000), domain, spacing), domain)
    region = mesh.triangle_regions[mesh.sides[:, 0]]
    assert (mesh.sides[:, 0] >= 0).all()
    return {
        label: {mesh.regions[k] for k in region[mesh.facet_labels == number]}
        for number, label in enumerate(mesh.labels)
        if label != "outer"
    }


class TestFacetsBelongToTheirLeft:
    """The region inside the ring that has the label, however it is drawn; the left of a line."""

    @pytest.mark.parametrize("ring", [COUNTER_CLOCKWISE, CLOCKWISE, "circle: {center: [2, 2], radius: 1}"])
    @pytest.mark.parametrize("moved", ["", ", mirror: x, move: [4, 0]", ", rotate: {by: 30, about: [2, 2]}"])
    def test_rings_in_any_direction(self, tmp_path, ring, moved):
        keys = f"regions: [{{name: B, ring: {{{ring}, label: face}}{moved}}}]"
        assert regions_on_the_left(tmp_path, keys) == {"face": {"B"}}

    @pytest.mark.parametrize("outer", [1, -1])
    @pytest.mark.parametrize("hole", [1, -1])
    def test_holes_of_a_region(self, tmp_path, outer, hole):
        square = [[1, 1], [3, 1], [3, 3], [1, 3], [1, 1]][::outer]
        within = [[1.5, 1.5], [2.5, 1.5], [2.5, 2.5], [1.5, 2.5], [1.5, 1.5]][::hole]
        (tmp_path / "frame.geojson").write_text(json.dumps({"type": "Polygon", "coordinates": [square, within]}))
        keys = f"regions: [{{name: B, ring: {{file: {tmp_path}/frame.geojson, label: face}}}}]"
        assert regions_on_the_left(tmp_path, keys) == {"face": {"B"}}

    @pytest.mark.parametrize("ring", [COUNTER_CLOCKWISE, CLOCKWISE])
    @pytest.mark.parametrize("first", ["A", "A, label: mine"])
    @pytest.mark.parametrize("second", ["", ", label: face"])
    def test_a_side_of_two_regions_belongs_to_the_one_whose_label_it_has(self, tmp_path, ring, first, second):
        beside = ring.replace("[1, ", "[0.2, ").replace("[3, ", "[1, ")  # on the left of the other one
        label = first.partition(", ")[2]
        keys = (
            f"regions:\n  - {{name: A, ring: {{{beside}{', ' if label else ''}{label}}}}}\n"
            f"  - {{name: B, ring: {{{ring}{second}}}}}"
        ).replace("\n", "\n  ")
        found = regions_on_the_left(tmp_path, keys)
        assert found == {"mine" if label else "A-rim": {"A"}, "face" if second else "B-rim": {"B"}}

    @pytest.mark.parametrize(("path", "left"), [("[[1, 1], [1, 3]]", "matrix"), ("[[1, 3], [1, 1]]", "B")])
    def test_lines_as_they_are_drawn(self, tmp_path, path, left):
        keys = f"regions: [{{name: B, ring: {{{CLOCKWISE}, label: face}}}}]\n  lines: [{{path: {path}, label: weld}}]"
        assert regions_on_the_left(tmp_path, keys) == {"face": {"B"}, "weld": {left}}
