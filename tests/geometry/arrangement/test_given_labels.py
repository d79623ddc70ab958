"""Which label an edge has where sides and lines run along each other, and what is told of the others."""

import json

import numpy as np
import pytest

from bubblemesh.case import load_case
from bubblemesh.errors import GeometryError
from bubblemesh.problem.domain import case_domain

PLATE = "outer: {rectangle: [0, 0, 4, 2]}"
FREE = "outer: {rectangle: [0, 0, 4, 2], label: free}"


@pytest.fixture
def domain_of(tmp_path):
    def make(keys):
        return case_domain(load_case(tmp_path / "case.yaml", text=f"domain:\n  {keys}\nspacing: 1\n"))

    return make


def lengths(domain):
    """Length of the edges with each label."""
    sums = np.bincount(domain.boundary.label, domain.boundary.lengths, len(domain.boundary.labels))
    return {name: pytest.approx(length) for name, length in zip(domain.boundary.labels, sums, strict=True) if length}


def test_a_given_label_counts_before_made_up_ones_of_rings(domain_of):
    domain = domain_of(
        f"""{PLATE}
  holes: [{{rectangle: [2, 0.5, 3, 1.5]}}]
  regions:
    - {{name: A, ring: {{rectangle: [1, 0.5, 2, 1.5], labels: [bottom, heater, top, left]}}}}
    - {{name: B, ring: {{rectangle: [3.5, 0.5, 4, 1], label: cooler}}}}"""
    )
    of_a = dict.fromkeys(("bottom", "heater", "top", "left"), 1)
    assert lengths(domain) == {"outer": 11.5, "hole-1": 3, "cooler": 2} | of_a
    assert domain.notes == ()


def test_made_up_labels_do_not_count_before_others(domain_of):
    regions = "regions: [{name: A, ring: {rectangle: [0, 0, 2, 2]}}, {name: B, ring: {rectangle: [2, 0, 4, 2]}}]"
    assert lengths(domain_of(f"{PLATE}\n  {regions}")) == {"outer": 12, "A-rim": 2}


def test_a_given_label_of_the_second_region_counts_before_a_made_up_one_of_the_first(domain_of):
    regions = """regions:
    - {name: A, ring: {rectangle: [0, 0.5, 2, 1.5]}}
    - {name: B, ring: {rectangle: [2, 0.5, 3, 1.5], labels: [b, r, t, contact]}}"""
    domain = domain_of(f"{PLATE}\n  {regions}")
    boundary = domain.boundary
    (contact,) = np.flatnonzero(boundary.label == boundary.labels.index("contact"))
    # It belongs to B, on the right of the side as A has it.
    assert boundary.tangents(np.array([contact]), np.zeros(1))[0].tolist() == [0, 1]
    assert boundary.turned[contact]
    assert domain.notes == ()


def test_given_labels_that_are_on_no_edge_are_told(domain_of):
    domain = domain_of(
        f"""{FREE}
  regions:
    - {{name: fluid, ring: {{rectangle: [0, 0, 4, 0.5], labels: [floor, outlet, wall, inlet]}}}}
    - {{name: A, ring: {{rectangle: [1, 1, 2, 1.5], labels: [a, contact-a, a, a]}}}}
    - {{name: B, ring: {{rectangle: [2, 1, 3, 1.5], labels: [b, weld-b, b, contact-b]}}}}
    - {{name: C, ring: {{rectangle: [3.5, 1, 5, 1.5], labels: [c, beyond, c, c]}}}}
  lines: [{{path: [[3, 1], [3, 1.5]], label: weld}}]"""
    )
    along = "the label {!r} is on no edge: its side at {} runs along {!r} and has the label {!r} alone"
    assert set(domain.notes) == {
        along.format("floor", "(2, 0)", "free", "free"),
        along.format("outlet", "(4, 0.25)", "free", "free"),
        along.format("inlet", "(0, 0.25)", "free", "free"),
        along.format("weld-b", "(3, 1.25)", "weld", "weld"),
        along.format("contact-b", "(2, 1.25)", "contact-a", "contact-a"),
        "the label 'beyond' is on no edge: its side at (5, 1.25) is outside the domain",
    }


def test_names_of_neighbours_in_a_file_leave_the_boundary_its_label(tmp_path, domain_of):
    squares = [[[x, 0], [x + 2, 0], [x + 2, 2], [x, 2], [x, 0]] for x in (0, 2)]
    features = [
        {"type": "Feature", "properties": {"id": k, "name": word}, "geometry": {"type": "Polygon", "coordinates": [s]}}
        for k, word, s in zip("ab", ("East", "West"), squares, strict=True)
    ]
    (tmp_path / "two.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    file = f"regions: {{file: {tmp_path}/two.geojson, name: id"
    domain = domain_of(f"{file}}}")
    assert (lengths(domain), domain.notes) == ({"outer": 12, "East": 2}, ())
    assert lengths(domain_of(f"{PLATE}\n  {file}, label: border}}")) == {"border": 14}


class TestLinesOnTheBoundary:
    """Lines that lie on the outer ring or a hole label this part of it."""

    def test_parts_and_whole_sides(self, domain_of):
        domain = domain_of(
            f"""{FREE}
  holes: [{{rectangle: [1, 0.5, 2, 1.5], label: bore}}]
  lines:
    - {{path: [[4, 1], [4, 0.5]], label: load}}
    - {{path: [[0, 0], [0, 2]], label: fixed}}
    - {{path: [[1, 1], [1, 0.5], [2, 0.5]], label: pin}}"""
        )
        assert lengths(domain) == {"free": 9.5, "load": 0.5, "fixed": 2, "bore": 2.5, "pin": 1.5}
        assert {(4, 0.5), (4, 1), (1, 1)} <= set(map(tuple, domain.boundary.corners.tolist()))
        assert not domain.boundary.inner.any()
        assert domain.notes == ()

    def test_arcs_also_if_lines_outside_are_left_out(self, domain_of):
        domain = domain_of(
            """outer: {circle: {center: [0, 0], radius: 1}}
  holes: [{circle: {center: [0, 0], radius: 0.5}}]
  lines:
    - {path: [[0, 1], {arc: {to: [1, 0], center: [0, 0], turn: right}}], label: load, outside: skip}
    - {path: [[0.5, 0], {arc: {to: [0.5, 0], center: [0, 0], turn: left}}], label: bore}"""
        )
        assert lengths(domain) == {"outer": 1.5 * np.pi, "load": np.pi / 2, "bore": np.pi}

    def test_what_goes_on_outside_is_left_out(self, domain_of):
        domain = domain_of(f"{FREE}\n  lines: [{{path: [[4, 1], [4, 3]], label: load}}]")
        assert lengths(domain) == {"free": 11, "load": 1}

    def test_a_label_that_has_no_edge_then_is_told(self, domain_of):
        domain = domain_of(
            """outer: {rectangle: [0, 0, 4, 2], labels: [bottom, right, top, left]}
  lines: [{path: [[4, 0], [4, 2]], label: load}]"""
        )
        assert lengths(domain) == {"bottom": 4, "load": 2, "top": 4, "left": 2}
        told = "the label 'right' is on no edge: its side at (4, 1) runs along 'load' and has the label 'load' alone"
        assert domain.notes == (told,)

    def test_a_line_with_a_part_inside_gives_way_as_a_region_does(self, domain_of):
        line = "lines: [{path: [[2, 0], [3, 0], [3, 1]], label: crack}]"
        domain = domain_of(f"{FREE}\n  {line}")
        assert lengths(domain) == {"free": 12, "crack": 1}
        assert domain.notes == (
            "the line 'crack' runs along 'free' at (2.5, 0): that part of it has the label 'free' alone",
        )
        assert lengths(domain_of(f"{PLATE}\n  {line}")) == {"outer": 11, "crack": 2}

    def test_without_a_label_it_is_refused(self, domain_of):
        told = r"the line 'line-1' at \(4, 0.75\) lies on the boundary of the domain, 'free': give it a label"
        with pytest.raises(GeometryError, match=told):
            domain_of(f"{FREE}\n  lines: [{{path: [[4, 0.5], [4, 1]]}}]")

    def test_of_two_in_one_place_with_different_labels_the_second_is_refused(self, domain_of):
        two = "lines: [{{path: [[4, 0.5], [4, 1]], label: load}}, {{path: [[4, 0.5], [4, 1]], label: {}}}]"
        assert lengths(domain_of(f"{FREE}\n  {two.format('load')}")) == {"free": 11.5, "load": 0.5}
        with pytest.raises(
            GeometryError, match=r"the line 'pin' at .* lies on the boundary of the domain, 'load': move"
        ):
            domain_of(f"{FREE}\n  {two.format('pin')}")
