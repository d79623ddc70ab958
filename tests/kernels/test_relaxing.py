import numpy as np
import pytest
from twins import needs_compiler, run_by

from bubblemesh.kernels.library import NUMPY
from bubblemesh.kernels.relaxing import forces_in_numpy
from bubblemesh.packing import relaxation
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.forces import VanDerWaals
from bubblemesh.packing.motion import SemiImplicitEuler
from bubblemesh.packing.neighbours import Neighbours

pytestmark = needs_compiler


def bubbles(seed, count=400, on_boundary=30):
    random = np.random.default_rng(seed)
    x, d = random.random((count, 2)), random.uniform(0.02, 0.08, count)
    nowhere = np.zeros(0, np.int64), np.zeros(0)
    return Bubbles(x, d, *nowhere, on_boundary, np.zeros(count, bool))


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("strength", [1.0, 60.0])  # the latter makes bubbles fly, but for the bound of a step
def test_both_engines_move_bubbles_to_the_same_places_to_the_last_bit(seed, strength):
    start = bubbles(seed)
    acting = VanDerWaals(k0=strength).among(Neighbours.of(start.x, start.d, 1.9))
    viscosities = np.linspace(0.5, 4, 12).tolist()
    compiled = relaxation._moved(start, acting, SemiImplicitEuler(), viscosities)
    with run_by(NUMPY):
        plain = relaxation._moved(start, acting, SemiImplicitEuler(), viscosities)
    for found, expected in zip(compiled, plain, strict=True):
        assert found.tobytes() == expected.tobytes()
    x, speeds = compiled
    np.testing.assert_array_equal(x[:30], start.x[:30])
    assert np.median(np.hypot(*(x - start.x)[30:].T)) > 1e-3
    assert (speeds > 0).all()


@pytest.mark.parametrize("seed", range(4))
def test_both_engines_have_the_same_forces_to_the_last_bit(seed):
    start = bubbles(seed)
    acting = VanDerWaals().among(Neighbours.of(start.x, start.d, 1.9))
    moved = start.x + np.random.default_rng(seed).normal(0, 0.02, start.x.shape)
    moved[7] = moved[5]  # without a direction to part in
    compiled = acting(moved)
    plain = forces_in_numpy(moved, acting.pull)
    assert compiled.tobytes() == plain.tobytes()
    assert np.abs(plain).max() > 1e-3
