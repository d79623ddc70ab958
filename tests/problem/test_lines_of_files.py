"""Embedded lines that are joined, simplified, or followed as curves."""

import json
import re

import numpy as np
import pytest

from bubblemesh.case import load_case
from bubblemesh.errors import CaseError, GeometryError
from bubblemesh.problem.prepare import prepare
from bubblemesh.run.pipeline import mesh_case

X = np.linspace(10, 90, 401)
RIVER = np.column_stack([X, 50 + 5 * np.sin(X / 8)]).tolist()
MET = RIVER[150]  # the vertex that a tributary nearly meets


@pytest.fixture
def problem_of(tmp_path):
    def make(lines, **named):
        for name, paths in named.items():
            shapes = [{"type": "LineString", "coordinates": path} for path in paths]
            features = [{"type": "Feature", "properties": {}, "geometry": shape} for shape in shapes]
            (tmp_path / f"{name}.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": features}))
        text = f"domain: {{outer: {{rectangle: [0, 0, 100, 100]}}, lines: [{lines}]}}\nspacing: 5\n"
        (tmp_path / "case.yaml").write_text(text)
        return prepare(load_case(tmp_path / "case.yaml"))

    return make


def ends_of(problem):
    """Corners of the boundary, and how many pieces end in each of them."""
    boundary = problem.domain.boundary
    ends = np.concatenate([boundary.start, boundary.end])
    return dict(zip(map(tuple, boundary.corners.tolist()), np.bincount(ends).tolist(), strict=True))


class TestJoin:
    """`join` moves ends of lines to what they nearly meet."""

    def test_an_end_meets_the_nearest_vertex_of_another_line(self, problem_of):
        tributary = [[40, 90], [MET[0] + 0.003, MET[1] + 0.02]]
        problem = problem_of("{file: a.geojson, join: 0.1}", a=[RIVER, tributary])
        assert ends_of(problem)[tuple(MET)] == 3
        assert "1 end of lines joined, the widest gap (0.0202) at (40.003, 45.22537863)" in problem.warnings

    @pytest.mark.parametrize("miss", [0.04, -0.04])
    def test_an_end_before_or_beyond_a_side_comes_to_lie_on_it(self, problem_of, miss):
        problem = problem_of("{path: [[10, 50], [90, 50]]}, {path: [[30, 90], [30, %g]], join: 0.1}" % (50 + miss))
        ends = ends_of(problem)
        assert ends[30.0, 50.0] == 3
        assert len(ends) == 4 + 4

    def test_ends_meet_the_boundary_and_borders_of_holes_of_another_entry(self, tmp_path):
        text = """
domain:
  outer: {rectangle: [0, 0, 10, 10]}
  holes: [{circle: {center: [5, 5], radius: 1}}]
  lines: [{path: [[0.02, 5], [3.98, 5.001]], join: 0.05}]
spacing: 1
"""
        (tmp_path / "case.yaml").write_text(text)
        domain = prepare(load_case(tmp_path / "case.yaml")).domain
        inner = domain.boundary.inner
        assert domain.boundary.lengths[inner].sum() == pytest.approx(4, abs=1e-5)
        assert domain.distances(domain.boundary.corners[domain.boundary.end[inner]]) == pytest.approx(0, abs=1e-12)
        assert np.bincount(domain.boundary.start)[domain.boundary.start[inner]].tolist() == [2]

    def test_ends_that_are_near_each_other_meet_in_the_first_of_them(self, problem_of):
        spokes = [[[20, 20], [50, 50]], [[80, 20], [50.01, 50]], [[50, 90], [50, 50.02]]]
        ends = ends_of(problem_of("{file: a.geojson, join: 0.1}", a=spokes))
        assert ends[50.0, 50.0] == 3
        assert len(ends) == 4 + 4

    def test_an_end_moves_by_no_more_than_the_length_in_a_chain(self, problem_of):
        problem = problem_of(
            "{path: [[10, 50], [90, 50]]}, {path: [[50, 50.9], [60, 90]], join: 1}, "
            "{path: [[49.6, 51.7], [30, 90]], join: 1}"
        )
        first, second, third = problem.domain.parts.lines
        assert (second.vertices[0], second.vertices[0] in first.vertices) == ((50, 50), True)
        assert 0.5 < np.hypot(*np.subtract(third.vertices[0], (49.6, 51.7))) < 1
        assert third.vertices[0] in second.vertices

    def test_ends_of_a_network_move_by_no_more_than_the_length(self, tmp_path, problem_of):
        rng = np.random.default_rng(3)
        middles, angles = rng.uniform(20, 80, (80, 2)), rng.uniform(0, np.pi, 80)
        along = np.column_stack([np.cos(angles), np.sin(angles)]) * rng.uniform(6, 14, (80, 1))
        rows = np.stack([middles - along, middles + along], axis=1)
        lines = problem_of("{file: a.geojson, join: 2}", a=rows.tolist()).domain.parts.lines
        moves = [
            np.subtract(line.vertices[end], row[end]) for line, row in zip(lines, rows, strict=True) for end in (0, -1)
        ]
        lengths = np.hypot(*np.array(moves).T)
        assert (lengths > 0).sum() > 20
        assert lengths.max() < 2 + 1e-9

    def test_an_end_goes_no_farther_than_the_length_of_its_own_line(self, problem_of):
        lines = "{path: [[10, 10], [50, 50]], join: %g}, {path: [[50.5, 50], [90, 10]], join: %g}"
        for far in ((1, 0.1), (0.1, 1)):
            one, other = problem_of(lines % far).domain.parts.lines
            assert one.vertices[-1] == other.vertices[0] == ((50, 50) if far[1] == 1 else (50.5, 50))

    def test_vertices_beside_the_place_are_left_out(self, problem_of):
        tail = [[30, 90], [30, 50.03], [30.01, 49.98], [30, 49.96]]
        problem = problem_of("{path: [[10, 50], [90, 50]]}, {file: a.geojson, join: 0.1}", a=[tail])
        assert problem.domain.parts.lines[1].vertices == ((30, 90), (30, 50))

    def test_an_arc_is_turned_about_its_other_end(self, problem_of):
        arc = "{path: [[30, 29.98], {arc: {to: [50, 49.98], center: [50, 29.98], turn: right}}], join: 0.1}"
        problem = problem_of("{path: [[10, 50], [90, 50]]}, " + arc)
        assert ends_of(problem)[50.0, 50.0] == 3

    def test_lengths_are_those_of_the_file(self, problem_of):
        lines = [[[10, 50], [90, 50]], [[30, 90], [30, 50.04]]]
        scaled = [[[100 * x, 100 * y] for x, y in line] for line in lines]
        text = "{file: a.geojson, scale: 0.01, join: %g}"
        assert 30 in [round(x) for (x, y), count in ends_of(problem_of(text % 10, a=scaled)).items() if count == 3]
        assert 3 not in ends_of(problem_of(text % 1, a=scaled)).values()

    def test_a_line_shorter_than_the_length_is_refused(self, problem_of):
        with pytest.raises(GeometryError, match=r"join is too much for the line 'line-1' .*: make it smaller"):
            problem_of("{file: a.geojson, join: 10}", a=[[[30, 30], [35, 30]], [[30, 60], [60, 60]]])

    def test_lines_that_meet_already_stay(self, problem_of):
        lines = [[[10, 50], [90, 50]], [[30, 90], [30, 50]], [[70, 50], [70, 0]]]
        plain, asked = (problem_of(f"{{file: a.geojson{keys}}}", a=lines) for keys in ("", ", join: 0.1"))
        assert ends_of(asked) == ends_of(plain)
        assert asked.warnings == plain.warnings == ()


class TestLinesOnOthers:
    """Lines all of which lies on others, without `join` or by it."""

    @pytest.mark.parametrize(("keys", "name"), [("", "line-{}"), (", label: frac", "frac")])
    @pytest.mark.parametrize(("y", "after"), [([50, 50], ""), ([50.08, 50.09], " after join")])
    def test_rows_of_a_file_count_once(self, problem_of, keys, name, y, after):
        problem = problem_of(
            f"{{file: a.geojson, join: 0.1{keys}}}", a=[[[10, 50], [90, 50]], [*zip([30, 40], y, strict=True)]]
        )
        boundary = problem.domain.boundary
        assert boundary.lengths[boundary.inner].sum() == pytest.approx(80)
        one, other = (f"{name.format(k)!r} (a.geojson: feature {k - 1})" for k in (1, 2))
        told = f"1 line left out, of which all lies on others, the first, {other} at (35, 50), on the line {one}{after}"
        assert told in problem.warnings

    def test_rows_that_cover_a_part_of_each_other_share_it(self, problem_of):
        problem = problem_of("{file: a.geojson, label: frac}", a=[[[10, 50], [60, 50]], [[40, 50], [90, 50]]])
        boundary = problem.domain.boundary
        assert boundary.lengths[boundary.inner].sum() == pytest.approx(80)
        assert problem.warnings == ()

    @pytest.mark.parametrize(
        ("path", "where"),
        [
            ("[[30, 50], [40, 50]]", "at (35, 50) lies on the line 'a': move or remove it, or give both one label"),
            ("[[30, 50.08], [40, 50.09]]", "on the line 'a' after join: make join smaller, or remove the line"),
            ("[[-9, 10], [-9, 20]]", "lies outside the domain: move or remove it, or leave it out by outside: skip"),
            ("[[80, 50], [120, 50]]", "lies outside the domain and on the line 'a': move or remove it"),
        ],
    )
    def test_a_line_whose_label_would_be_lost_is_refused_with_the_cause(self, problem_of, path, where):
        with pytest.raises(GeometryError, match=rf"the line 'b' .*{re.escape(where)}"):
            problem_of(f"{{path: [[10, 50], [100, 50]], label: a}}, {{path: {path}, label: b, join: 0.1}}")


class TestFollowing:
    """`corners`, `smooth` and `tolerance` of lines of files."""

    @pytest.mark.parametrize("keys", ["corners: 30", "corners: 30, smooth: true", "corners: 30, tolerance: 0.5"])
    def test_a_line_of_many_vertices_needs_few_nodes(self, problem_of, keys):
        many, few = (problem_of(f"{{file: a.geojson, {key}}}", a=[RIVER]) for key in ("join: 0.01", keys))
        assert few.expected_nodes < 1.2 * few.survey.ideal_nodes < many.expected_nodes / 4
        assert problem_length(few) == pytest.approx(problem_length(many), rel=1e-3)

    def test_where_lines_meet_there_is_a_node(self, problem_of):
        problem = problem_of("{file: a.geojson, corners: 30}", a=[RIVER, [[40, 90], MET]])
        assert ends_of(problem)[tuple(MET)] == 3
        assert len(ends_of(problem)) == 4 + 4

    def test_nodes_lie_on_the_line(self, tmp_path, problem_of):
        problem_of("{file: a.geojson, corners: 30}", a=[RIVER])
        mesh = mesh_case(load_case(tmp_path / "case.yaml")).mesh
        river = np.unique(mesh.facets[mesh.facet_labels == mesh.labels.index("line-1")])
        y = np.interp(mesh.points[river, 0], *np.array(RIVER).T)
        assert np.abs(mesh.points[river, 1] - y).max() < 1e-9
        assert len(river) == pytest.approx(problem_length_of(RIVER) / 5, abs=3)

    def test_smooth_needs_corners(self, problem_of):
        with pytest.raises(CaseError, match="needs corners"):
            problem_of("{file: a.geojson, smooth: true}", a=[RIVER])


def problem_length(problem):
    boundary = problem.domain.boundary
    return boundary.lengths[boundary.inner].sum()


def problem_length_of(points):
    return np.hypot(*np.diff(points, axis=0).T).sum()


class TestSimplify:
    """`simplify` of lines of files."""

    def test_vertices_are_left_out_but_those_where_lines_meet(self, problem_of):
        problem = problem_of("{file: a.geojson, simplify: 0.2}", a=[RIVER, [[40, 90], MET]])
        left = np.array([point for line in problem.domain.parts.lines[:1] for point in line.vertices])
        assert 10 < len(left) < 60
        assert tuple(MET) in map(tuple, left.tolist())
        y = np.interp(np.array(RIVER)[:, 0], *left.T)
        assert np.abs(y - np.array(RIVER)[:, 1]).max() < 0.3
        assert f"{401 - len(left):,} of 403 vertices of lines left out (simplify)" in problem.warnings

    def test_lines_side_by_side_do_not_cross(self, problem_of):
        banks = [RIVER, [[x, y + 0.05] for x, y in RIVER]]
        problem = problem_of("{file: a.geojson, simplify: 0.2}", a=banks)
        assert set(ends_of(problem).values()) == {1, 2}

    def test_lines_do_not_cross_the_boundary(self, tmp_path):
        (tmp_path / "a.csv").write_text("x,y\n" + "\n".join(f"{x},{y}" for x, y in RIVER))
        below = [[0, 0], [100, 0], *([x, y + 0.05] for x, y in reversed(RIVER))]
        text = f"domain: {{outer: {{polygon: {below}}}, lines: [{{file: a.csv, simplify: 0.2}}]}}\nspacing: 5\n"
        (tmp_path / "case.yaml").write_text(text)
        domain = prepare(load_case(tmp_path / "case.yaml")).domain
        assert domain.boundary.lengths[domain.boundary.inner].sum() == pytest.approx(problem_length_of(RIVER), rel=2e-3)


def test_the_warning_of_many_vertices_names_keys_that_lines_take(problem_of):
    (warning,) = problem_of("{file: a.geojson}", a=[RIVER]).warnings
    assert "for 400 edges of lines shorter than the spacing" in warning
    assert "(corners: 30 beside the file of the lines takes short edges for curves, simplify leaves out" in warning


def test_the_warning_of_short_cracks_names_no_key_that_does_not_help(problem_of):
    cracks = [[[x, 20], [x, 20.3]] for x in np.arange(10, 60, 1.7).tolist()]
    (warning,) = problem_of("{file: a.geojson}", a=cracks).warnings
    assert "30 edges of lines shorter than the spacing" in warning
    assert "corners" not in warning
