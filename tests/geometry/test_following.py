import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from invariants import check_mesh
from numpy.testing import assert_allclose

from bubblemesh.case import load_case
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.curves import Polylines
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.following import Following, _simplified, deviation
from bubblemesh.geometry.paths import Line, Polyline, Spline
from bubblemesh.geometry.rings import ArcTo, LineTo, path, polygon, rectangle
from bubblemesh.run.pipeline import mesh_case

TURN = np.linspace(0, 2 * np.pi, 400, endpoint=False)
CIRCLE = np.column_stack([np.cos(TURN), np.sin(TURN)])


def airfoil(count=60):
    """Points of the NACA 0012 profile with a sharp trailing edge, from there and back."""
    x = (1 - np.cos(np.linspace(0, np.pi, count))) / 2
    y = 0.6 * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)
    return np.vstack([np.column_stack([x, y])[::-1], np.column_stack([x, -y])[1:-1]])


def coast(count=1000, seed=0, roughness=0.02):
    """A disc whose shore is a random walk."""
    steps = np.random.default_rng(seed).normal(size=count)
    walk = np.cumsum(steps) - np.linspace(0, steps.sum(), count)
    turn = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return (1 + roughness * walk / np.sqrt(count) * 3)[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])


def kinds(ring):
    return [type(side.curve) for side in ring.sides]


def meshed(ring_text, spacing, method="multilevel", points=()):
    listed = str(np.asarray(points).tolist())
    text = f"domain: {{outer: {{polygon: {listed}, {ring_text}}}}}\nspacing: {spacing}\n"
    return mesh_case(load_case("ring.yaml", text=text, method=method))


def largest_distance(mesh, points):
    """Of a ring from the boundary edges and of these from the ring, by brute force."""
    edges = shapely.MultiLineString(list(mesh.points[mesh.facets]))
    ring = shapely.LinearRing(points)
    samples = shapely.get_coordinates(shapely.segmentize(edges, 1e-3))
    return max(
        shapely.distance(edges, shapely.points(points)).max(), shapely.distance(ring, shapely.points(samples)).max()
    )


class TestPolylines:
    FAMILY = Polylines([np.array([[0, 0], [3, 0], [3, 4.0]]), CIRCLE * 2])

    def test_places_are_those_of_linear_interpolation_by_arc_length(self):
        assert_allclose(self.FAMILY.lengths[0], 7)
        places = self.FAMILY.points(np.array([0, 0, 0, 0]), np.array([0, 1.5, 3, 5.0]))
        assert_allclose(places, [[0, 0], [1.5, 0], [3, 0], [3, 2]])

    def test_tangents_are_those_of_the_next_segment(self):
        assert_allclose(
            self.FAMILY.tangents(np.zeros(4, int), np.array([0, 2.9, 3, 7])), [[1, 0], [1, 0], [0, 1], [0, 1]]
        )

    def test_stations_are_the_vertices(self):
        curve, s = self.FAMILY.stations()
        assert_allclose(s[curve == 0], [0, 3])
        assert_allclose(self.FAMILY.points(curve, s)[2:], 2 * CIRCLE[:-1])

    def test_the_domain_of_a_trace_is_that_of_its_polygon(self):
        points = coast()
        traced, plain = Domain.of(Following(180)(polygon(points))), Domain.of(polygon(points))
        probes = np.random.default_rng(0).uniform(-1.2, 1.2, (3000, 2))
        assert_allclose(traced.signed_distance(probes), plain.signed_distance(probes), atol=1e-12)
        piece, s, foot, _ = traced.nearest(probes)
        assert_allclose(traced.boundary.points(piece, s), foot, atol=1e-12)


class TestCorners:
    def test_a_round_ring_has_none_and_is_one_closed_curve(self):
        ring = Following(30)(polygon(CIRCLE, label="rim"))
        assert kinds(ring) == [Polyline]
        assert ring.vertices == ()
        assert ring.sides[0].label == "rim"
        assert_allclose(ring.outline, CIRCLE)

    def test_vertices_that_turn_by_more_stay(self):
        ring = Following(30)(polygon(airfoil()))
        assert ring.vertices == ((1, pytest.approx(0, abs=1e-3)),)
        assert kinds(ring) == [Polyline]
        assert len(Following(89)(rectangle(0, 0, 1, 1)).vertices) == 4
        assert len(Following(91)(rectangle(0, 0, 1, 1)).vertices) == 0

    def test_labels_stay_where_they_were(self):
        labels = ["a"] * 100 + ["b"] * 300
        ring = Following(30)(polygon(CIRCLE, labels))
        assert [side.label for side in ring.sides] == ["a", "b"]
        assert_allclose(ring.vertices, CIRCLE[[0, 100]])

    def test_curves_of_the_ring_stay_and_their_ends_are_nodes(self):
        half = [LineTo(tuple(point)) for point in CIRCLE[200:]] + [LineTo((1, 0))]
        ring = Following(30)(path((1, 0), [ArcTo((-1, 0), (0, 0), True), *half]))
        assert [kind.__name__ for kind in kinds(ring)] == ["Arc", "Polyline"]

    def test_a_ring_that_keeps_all_its_vertices_is_the_ring(self):
        ring = rectangle(0, 0, 1, 1)
        assert Following(30)(ring) is ring

    def test_a_spline_passes_all_vertices_and_has_a_corner_where_the_ring_has(self):
        ring = Following(30, smooth=True)(polygon(airfoil()))
        assert kinds(ring) == [Spline]
        domain = Domain.of(ring)
        assert domain.nearest(airfoil()).distance.max() < 1e-5
        ahead, back = domain.boundary.tangents(np.zeros(2, int), np.array([0, domain.boundary.lengths[0]]))
        assert abs(ahead @ back) > 0.9
        assert ahead @ back < 0

    def test_a_closed_spline_is_smooth_all_around(self):
        domain = Domain.of(Following(30, smooth=True)(polygon(CIRCLE[::20])))
        assert domain.polygon.area == pytest.approx(np.pi, rel=2e-4)
        first, last = domain.boundary.tangents(np.zeros(2, int), np.array([0, domain.boundary.lengths[0]]))
        assert_allclose(first, last, atol=1e-6)


class TestTolerance:
    @given(st.integers(0, 10_000), st.floats(1e-4, 0.1))
    @settings(derandomize=True, deadline=None, max_examples=30)
    def test_all_points_are_near_the_chords_of_those_that_stay(self, seed, tolerance):
        points = coast(200, seed)
        points = np.vstack([points, points[:1]])
        kept = _simplified(points, 1, tolerance)
        assert kept[0] == 0
        assert kept[-1] == 200
        chords = shapely.LineString(points[kept])
        assert shapely.distance(chords, shapely.points(points)).max() <= tolerance * (1 + 1e-9)

    @pytest.mark.long
    def test_parts_of_a_spline_are_the_spline(self):
        whole = Domain.of(Following(30, smooth=True)(polygon(airfoil())))
        parts = Domain.of(Following(30, smooth=True, tolerance=2e-3)(polygon(airfoil())))
        assert len(parts.boundary.corners) > 4
        s = np.linspace(0, 1, 50)
        for piece, length in enumerate(parts.boundary.lengths):
            places = parts.boundary.points(np.full(50, piece), s * length)
            assert whole.nearest(places).distance.max() < 1e-7

    @pytest.mark.long
    @pytest.mark.parametrize("method", ["accelerated", "multilevel"])
    @pytest.mark.parametrize(
        ("points", "options", "spacing"),
        [
            (airfoil(), "corners: 30, tolerance: 1e-3", 0.04),
            (airfoil(), "corners: 30, smooth: true, tolerance: 2e-3", 0.04),
            (coast(), "corners: 60, tolerance: 0.02", 0.15),
            (CIRCLE, "corners: 60, tolerance: 0.001", 0.3),
        ],
    )
    def test_no_mesh_departs_by_more(self, points, options, spacing, method):
        result = meshed(options, spacing, method, points)
        found = result.report["deviation"]["largest"]
        assert found <= float(options.split()[-1])
        assert found == pytest.approx(largest_distance(result.mesh, points), rel=0.02)

    def test_a_spline_that_bulges_by_more_is_refused_with_the_place(self):
        spiky = [(0, 0), (1, 0), (1, 1), (0.5, 0.5), (0, 1)]
        with pytest.raises(GeometryError, match=r"spline at .* departs from the polyline by .* raise the tolerance"):
            Following(180, smooth=True, tolerance=1e-3)(polygon(spiky))

    def test_straight_runs_become_single_lines(self):
        points = [(x, 0) for x in range(10)] + [(9, 1), (0, 1)]
        assert kinds(Following(30, tolerance=1e-3)(polygon(points))) == [Polyline, Line, Line, Line]


class TestMeshes:
    def test_nodes_are_spaced_anew_along_a_coast(self):
        points = coast()
        result = meshed("corners: 90", 0.15, points=points)
        check_mesh(result.mesh)
        assert result.report["boundary_nodes"] < 80
        assert result.report["quality"]["min"] > 0.6
        assert result.report["deviation"]["largest"] == pytest.approx(largest_distance(result.mesh, points), rel=0.02)

    def test_without_corners_every_vertex_is_a_node(self):
        points = coast(100)
        result = meshed("label: shore", 0.3, points=points)
        assert {tuple(p) for p in points.tolist()} <= {tuple(p) for p in result.mesh.points.tolist()}
        assert "deviation" not in result.report


def test_deviation_is_largest_at_a_vertex_or_in_between():
    domain = Domain.of(Following(180)(rectangle(0, 0, 2, 2)))
    middles = np.array([[1, 0], [2, 1], [1, 2], [0, 1.0]])
    facets = np.array([[0, 1], [1, 2], [2, 3], [3, 0]])
    found = deviation(domain, middles, facets, np.zeros(4, int))
    assert found.largest == pytest.approx(np.sqrt(0.5))
    assert set(np.round(found.at, 9)) <= {0.0, 2.0}
    assert deviation(Domain.of(rectangle(0, 0, 2, 2)), middles, facets, np.zeros(4, int)) is None
