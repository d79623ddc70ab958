"""A start from the nodes of a present mesh."""

import numpy as np
import pytest
from relaxers import relaxer
from scipy.spatial import KDTree

import bubblemesh
from bubblemesh.adaptivity.sizes import smooth_sizes
from bubblemesh.errors import LimitError
from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.quality import radius_ratios
from bubblemesh.packing.annealing import ONLY, NoAnnealing
from bubblemesh.packing.methods import METHODS
from bubblemesh.packing.net import connect, connect_inside
from bubblemesh.packing.placement.warm_start import PreviousNodes, WarmStart
from bubblemesh.packing.relaxation import Relaxed
from bubblemesh.packing.rounds import rounds
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.survey import ideal_nodes

ENOUGH = 10**6
SIZE = 0.05
PLATE = Domain.of(rings.rectangle(0, 0, 2, 1), [rings.circle((1, 0.5), 0.2)])


@pytest.fixture(scope="module")
def present():
    mesh = bubblemesh.mesh(PLATE, SIZE)
    inner = np.setdiff1d(np.arange(len(mesh.points)), mesh.facets)
    return PreviousNodes(mesh.points[inner], smooth_sizes(mesh.points, mesh.triangles)[inner])


def uniform(d):
    return Spacing(lambda x, y: np.full(x.shape, d))


def spot(d, least):
    return Spacing(lambda x, y: np.minimum(d, least + 0.3 * np.hypot(x - 0.4, y - 0.4)))


def packed(method, spacing):
    levels = method.levels(PLATE, spacing, 0)
    start = method.placement(PLATE, levels[0], ENOUGH)
    *_, last = rounds(start, PLATE, levels, method, lambda share: None)
    return start, last


def share_near(points, others, distance):
    return float((KDTree(others).query(points)[0] <= distance).mean())


def test_all_nodes_are_the_start_where_the_spacing_is_their_size(present):
    start = WarmStart(present)(PLATE, uniform(SIZE), ENOUGH)
    kept = share_near(present.points, start.x, 0)
    assert kept > 0.97
    assert len(start) - start.boundary_count == pytest.approx(kept * len(present.points), rel=0.02)


@pytest.mark.parametrize("factor", [0.3, 0.6, 0.9, 1.12, 1.5, 2.2])
def test_the_start_has_the_right_number_of_bubbles(present, factor):
    spacing = uniform(factor * SIZE)
    start = WarmStart(present)(PLATE, spacing, ENOUGH)
    assert len(start) == pytest.approx(ideal_nodes(PLATE, spacing, ENOUGH, 1e-2), rel=0.04 if factor < 2 else 0.08)


@pytest.mark.parametrize("factor", [1.2, 1.7])
def test_a_coarser_start_has_present_nodes_only(present, factor):
    start = WarmStart(present)(PLATE, uniform(factor * SIZE), ENOUGH)
    assert share_near(start.x[start.interior], present.points, 0) == 1


def test_a_finer_start_has_all_present_nodes_away_from_the_boundary(present):
    start = WarmStart(present)(PLATE, uniform(0.6 * SIZE), ENOUGH)
    assert share_near(present.points, start.x, 0) > 0.97


@pytest.mark.long
@pytest.mark.parametrize("name", ["multilevel", "accelerated"])
def test_nodes_stay_where_the_spacing_has_not_changed(present, name):
    _, last = packed(METHODS[name].warm_started(present), spot(SIZE, 0.01))
    away = np.hypot(*(present.points - [0.4, 0.4]).T) > 0.25
    assert share_near(present.points[away], last.bubbles.x, 0.25 * SIZE) > (0.9 if name == "multilevel" else 0.6)
    assert len(last.bubbles) == pytest.approx(ideal_nodes(PLATE, spot(SIZE, 0.01), ENOUGH, 1e-2), rel=0.05)
    assert radius_ratios(last.bubbles.x, last.net.triangles).min() > (0.7 if name == "multilevel" else 0.3)


def test_annealing_spares_what_has_not_changed(present):
    annealing = METHODS["multilevel"].warm_started(present).annealing
    bubbles = WarmStart(present)(PLATE, spot(SIZE, 0.01), ENOUGH)
    net = connect_inside(bubbles, PLATE, spot(SIZE, 0.01))
    seen = []

    def relax(net, steps):
        seen.append(net.bubbles.x)
        return Relaxed.none(net.bubbles)

    annealing(net, relaxer(relax, PLATE, spot(SIZE, 0.01)), np.random.default_rng(0), ONLY)
    moved = np.hypot(*(seen[0] - net.bubbles.x).T) > 0
    ratio = present.at(net.bubbles.x) / net.bubbles.d
    assert moved.sum() > 20
    assert not moved[np.abs(ratio - 1) < 0.04].any()


def test_a_method_without_annealing_stays_without(present):
    assert METHODS["bpm"].warm_started(present).annealing == NoAnnealing()


def test_the_share_that_stays(present):
    assert present.share_of_own_size(PLATE, uniform(SIZE)) > 0.9
    assert present.share_of_own_size(PLATE, uniform(1.2 * SIZE)) == 0
    half = Spacing(lambda x, y: np.where(x < 1, SIZE, 2 * SIZE))
    left = present.share_of_own_size(PLATE, uniform(SIZE)) / 2
    assert present.share_of_own_size(PLATE, half) == pytest.approx(left, abs=0.05)


def test_no_nodes_at_all_are_a_start_too():
    nothing = PreviousNodes(np.zeros((0, 2)), np.zeros(0))
    start = WarmStart(nothing)(PLATE, uniform(SIZE), ENOUGH)
    assert len(connect(start, PLATE).triangles) > 100
    assert nothing.share_of_own_size(PLATE, uniform(SIZE)) == 0


def test_too_many_bubbles_are_an_error(present):
    with pytest.raises(LimitError):
        WarmStart(present)(PLATE, uniform(SIZE / 4), 100)
