"""The model of benchmarks/tides: rest, volume, waves, and the files that are drawn for it."""

import numpy as np
import pytest

from benchmarks.tides.__main__ import CASES
from benchmarks.tides.archipelago import draw
from benchmarks.tides.model import GRAVITY, Grid, State, advanced
from bubblemesh import load_case, mesh_case
from bubblemesh.problem.prepare import prepare

LENGTH, DEPTH = 40e3, 20.0


CHANNEL = """
domain:
  outer: {rectangle: [0, 0, 40000, 10000], labels: [land, land, land, open]}
  holes: [{circle: {center: [30000, 5000], radius: 500}, label: island}]
spacing: 800
"""


@pytest.fixture(scope="module")
def channel():
    """Mesh of a channel that is open in the west, with an island."""
    return mesh_case(load_case("channel.yaml", text=CHANNEL)).mesh


def grid_of(made, uneven=0.0):
    x, y = made.points.T
    return Grid.of(made, DEPTH + uneven * np.sin(x / 3000) * np.cos(y / 2000), "open")


def test_volumes_fill_the_mesh_and_edges_close_around_them(channel):
    grid = grid_of(channel)
    assert grid.areas.sum() == pytest.approx(LENGTH**2 / 4 - np.pi * 500**2, rel=1e-3)
    assert grid.lengths[grid.outer].sum() == pytest.approx(2.5 * LENGTH + 2 * np.pi * 500, rel=1e-2)
    assert grid.lengths[grid.opened].sum() == pytest.approx(LENGTH / 4)
    assert np.allclose(grid.normals[grid.opened], (-1, 0))
    around = np.zeros((len(grid.areas), 2))
    np.add.at(around, grid.left, grid.normals * grid.lengths[:, None])
    np.subtract.at(around, grid.right[~grid.outer], (grid.normals * grid.lengths[:, None])[~grid.outer])
    assert np.abs(around).max() < 1e-9


@pytest.mark.parametrize("tide", [None, 0.0])
def test_water_at_rest_stays_so_over_an_uneven_bed(channel, tide):
    grid = grid_of(channel, uneven=10)
    state, came = advanced(grid, grid.at_rest(), 10.0, tide)
    assert came == 0
    assert not state.level.any()
    assert not state.discharge.any()


def test_the_volume_is_what_came_in(channel):
    grid = grid_of(channel, uneven=10)
    state, came = grid.at_rest(), 0.0
    for count in range(100):
        state, more = advanced(grid, state, 8.0, np.sin(count / 30))
        came += more
    assert came > 1e7
    assert grid.volume(state) == pytest.approx(came, rel=1e-12)
    assert grid.courant(state, 8.0) < 1
    full = grid.volume(state)
    for _ in range(100):
        state, more = advanced(grid, state, 8.0, None)
        assert more == 0
    assert grid.volume(state) == pytest.approx(full, rel=1e-12)


def test_a_long_wave_runs_as_fast_as_it_should(channel):
    grid = grid_of(channel)
    wave = 0.01 * np.cos(np.pi * grid.middles[:, 0] / LENGTH)
    state, step = State(wave, np.zeros((len(wave), 2))), 10.0
    half = LENGTH / np.sqrt(GRAVITY * DEPTH)  # after half of its period the wave stands the other way up
    for _ in range(round(half / step)):
        state, _ = advanced(grid, state, step, None)
    share = -(state.level @ (wave * grid.areas)) / (wave @ (wave * grid.areas))
    assert 0.75 < share < 1


@pytest.mark.long
def test_the_cases_are_drawn_and_can_be_checked(tmp_path):
    for seed, text in CASES.values():
        draw(tmp_path, seed, islands=10, points=400)
        (tmp_path / "tide.yaml").write_text(text)
        problem = prepare(load_case(tmp_path / "tide.yaml"))
        assert "open" in problem.domain.labels
