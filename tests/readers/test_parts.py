"""Files with several separate areas, and the parts of them that a case takes."""

import numpy as np
import pytest
from geometry_files import WKT, area, domain

from bubblemesh.case import load_case
from bubblemesh.errors import CaseError, GeometryError
from bubblemesh.meshes.conformity import require_conforming
from bubblemesh.problem.domain import case_domain
from bubblemesh.run.pipeline import mesh_case

LAKE = "MULTIPOLYGON (((0 0, 9 0, 9 9, 0 9, 0 0), (1 1, 8 1, 8 8, 1 8, 1 1)), ((3 3, 6 3, 6 6, 3 6, 3 3)))"
NESTED = "0 0\n9 0\n9 9\n0 9\n\n1 1\n8 1\n8 8\n1 8\n\n3 3\n6 3\n6 6\n3 6\n\n4 4\n5 4\n5 5\n4 5\n"
APART = "10 0\n11 0\n11 1\n10 1\n\n0 0\n4 0\n4 4\n0 4\n\n20 0\n22 0\n22 2\n20 2\n"


@pytest.mark.parametrize(
    ("part", "pieces", "size"), [("largest", 1, 16), ("all", 3, 21), (0, 1, 16), (1, 1, 4), (2, 1, 1)]
)
def test_a_part_is_the_largest_one_all_or_one_by_number(written, part, pieces, size):
    found = domain(written("a.csv", APART), part=part)
    assert (found.piece_count, found.polygon.area) == (pieces, size)


def test_parts_are_labelled_from_the_largest_on(written):
    assert domain(written("a.csv", APART), part="all").boundary.labels == ("outer", "outer-2", "outer-3")


@pytest.mark.parametrize(("name", "text", "size"), [("a.wkt", LAKE, 32 + 9), ("a.csv", NESTED, 32 + 8)])
def test_what_lies_in_a_hole_is_an_area(written, name, text, size):
    path = written(name, text)
    assert area(path, part="all") == size
    assert area(path, part="largest") == 32
    assert area(path, part=1) == size - 32
    with pytest.raises(GeometryError, match=rf"2 separate areas .*; parts are 0: area 32 .* 1: area {size - 32} at"):
        area(path)


def test_an_area_that_fills_a_hole_of_another_one_is_no_hole(written):
    ring = "POLYGON ((0 0, 9 0, 9 9, 0 9, 0 0), (1 1, 8 1, 8 8, 1 8, 1 1))"
    path = written("a.wkt", f"{ring}\nPOLYGON ((1 1, 8 1, 8 8, 1 8, 1 1))")
    assert area(path, part="largest") == 49
    with pytest.raises(GeometryError, match=r"share an edge at .*give them as regions"):
        domain(path, part="all")


def test_an_area_within_another_one_is_a_hole_whose_own_hole_is_an_area(written):
    path = written(
        "a.wkt", "POLYGON ((0 0, 9 0, 9 9, 0 9, 0 0))\nPOLYGON ((1 1, 8 1, 8 8, 1 8, 1 1), (3 3, 6 3, 6 6, 3 3))"
    )
    assert area(path, part="all") == 32 + 4.5


@pytest.mark.parametrize("part", [3, 99])
def test_a_part_that_is_not_there(written, part):
    with pytest.raises(
        CaseError, match=rf"no part {part}: give a number from 0 to 2; parts are 0: area 16 at \(0, 0\)"
    ):
        area(written("a.csv", APART), part=part)


def test_no_more_than_twenty_parts_are_listed(written):
    squares = "\n\n".join(f"{3 * k} 0\n{3 * k + 1} 0\n{3 * k + 1} 1" for k in range(50))
    with pytest.raises(GeometryError, match=r"50 separate areas .*; 19: .*; and 30 smaller ones$"):
        area(written("a.csv", squares))


def test_hole_points_of_a_file_with_several_areas(written):
    corners = [(0, 0), (9, 0), (9, 9), (0, 9), (1, 1), (8, 1), (8, 8), (1, 8), (3, 3), (6, 3), (6, 6), (3, 6)]
    vertices = "".join(f"{k} {x} {y}\n" for k, (x, y) in enumerate(corners))
    segments = "".join(f"{k} {k} {k + 1 if k % 4 < 3 else k - 3}\n" for k in range(12))
    text = f"12 2 0 0\n{vertices}12 0\n{segments}1\n0 {{}}\n"
    assert area(written("a.poly", text.format("2 2")), part="all") == 32 + 9
    # Without a hole point the middle ring is a line within the area.
    assert area(written("a.poly", text.format("4 4"))) == 81 - 9


class TestCases:
    """In a case file."""

    def found(self, written, text):
        return case_domain(load_case(written("case.yaml", f"domain: {text}\nspacing: 0.5\n")))

    @pytest.fixture(autouse=True)
    def _file(self, written):
        written("a.csv", APART)
        written("lake.wkt", LAKE)

    @pytest.mark.parametrize(
        ("text", "pieces", "size"),
        [
            ("{file: a.csv, part: largest}", 1, 16),
            ("{file: a.csv, part: all, scale: 2}", 3, 84),
            ("{outer: {file: a.csv, part: 1}}", 1, 4),
            ("{outer: {file: a.csv, part: all}}", 3, 21),
            ("{outer: {rectangle: [-1, -1, 30, 9]}, holes: [{file: a.csv, part: largest}]}", 1, 294),
            ("{outer: {rectangle: [-1, -1, 30, 9]}, holes: [{file: a.csv}]}", 1, 289),
            ("{outer: [{rectangle: [0, 0, 1, 1]}, {rectangle: [2, 0, 3, 1]}]}", 2, 2),
            ("{outer: [{rectangle: [0, 0, 1, 1]}]}", 1, 1),
            (
                "{outer: [{rectangle: [3, 3, 6, 6]}, {rectangle: [0, 0, 9, 9]}], holes: [{rectangle: [1, 1, 8, 8]}]}",
                2,
                32 + 9,
            ),
        ],
    )
    def test_areas_of_a_domain(self, written, text, pieces, size):
        found = self.found(written, text)
        assert (found.piece_count, found.polygon.area) == (pieces, size)

    def test_labels_count_the_pieces(self, written):
        found = self.found(written, "{file: lake.wkt, part: all, label: shore, hole_label: lake}")
        assert found.boundary.labels == ("shore", "lake")
        found = self.found(
            written, "{outer: [{rectangle: [0, 0, 1, 1], label: a}, {circle: {center: [3, 0], radius: 1}}]}"
        )
        assert found.boundary.labels == ("a", "outer-2")

    def test_a_region_takes_a_part_and_may_have_holes(self, written):
        text = "{{outer: {{rectangle: [-1, -1, 10, 10]}}, regions: [{{name: r, ring: {{file: lake.wkt{}}}}}]}}"
        both, island = (self.found(written, text.format(part)) for part in ("", ", part: 1"))
        assert [region.polygon.area for region in both.parts.regions] == [32, 9]
        assert [region.polygon.area for region in island.parts.regions] == [9]

    @pytest.mark.parametrize(
        ("text", "kind", "message"),
        [
            ("{outer: []}", CaseError, "domain.outer: must have at least one entry"),
            (
                "{outer: [{rectangle: [0, 0, 1, 1]}, {circel: 1}]}",
                CaseError,
                r"domain.outer.1: must be a mapping .*'circle'",
            ),
            ("{file: a.csv, part: biggest}", CaseError, "domain.part: must be largest, all, or a number"),
            ("{file: a.csv, part: -1}", CaseError, "domain.part: must be largest, all, or a number"),
            ("{file: a.csv, part: true}", CaseError, "domain.part: must be largest, all, or a number"),
            (
                "{outer: [{rectangle: [0, 0, 2, 1]}, {rectangle: [1, 0, 3, 1]}]}",
                GeometryError,
                "outer ring 1 and outer ring 2 overlap at",
            ),
            (
                "{outer: [{rectangle: [0, 0, 1, 1]}, {rectangle: [2, 0, 3, 1]}], holes: [{rectangle: [5, 0, 6, 1]}]}",
                GeometryError,
                r"the hole at \(5, 0\) lies in none of the areas",
            ),
        ],
    )
    def test_what_cannot_be_read_so(self, written, text, kind, message):
        with pytest.raises(kind, match=message):
            self.found(written, text)

    @pytest.mark.long
    @pytest.mark.parametrize("method", ["multilevel", "accelerated"])
    def test_islands_and_regions_that_cross_pieces_are_meshed(self, written, method):
        text = f"""
domain:
  file: lake.wkt
  part: all
  regions: [{{name: north, ring: {{rectangle: [-1, 4.5, 10, 10]}}}}]
  lines: [{{path: [[-1, 2], [10, 2]], label: cable}}]
  points: [{{at: [5, 4]}}]
method: {method}
spacing: 0.5
"""
        mesh = mesh_case(load_case(written("case.yaml", text))).mesh
        require_conforming(mesh)
        assert mesh.regions == ("domain", "north")
        assert set(mesh.labels) == {"outer", "outer-2", "hole-1", "cable", "north-rim"}
        areas = np.abs(np.linalg.det(np.diff(mesh.points[mesh.triangles], axis=1))) / 2
        assert areas[mesh.triangle_regions == 0].sum() == pytest.approx(20.5, rel=1e-12)
        assert areas[mesh.triangle_regions == 1].sum() == pytest.approx(20.5, rel=1e-12)

    @pytest.mark.long
    def test_pieces_of_second_order(self, written):
        text = "domain: {file: lake.wkt, part: all}\nspacing: 0.7\noutput: {order: 2}\n"
        mesh = mesh_case(load_case(written("case.yaml", text))).mesh
        edges = {tuple(sorted((t[i], t[(i + 1) % 3]))) for t in mesh.triangles.tolist() for i in range(3)}
        assert len(mesh.points) == len({i for t in mesh.triangles.tolist() for i in t[:3]}) + len(edges)

    def test_a_file_without_parts_stays_as_it_is(self, written):
        written("plate.wkt", WKT)
        assert self.found(written, "{file: plate.wkt, part: all}").boundary.labels == ("outer", "hole-1")
