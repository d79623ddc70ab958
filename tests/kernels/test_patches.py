import numpy as np
import pytest
from lattices import packed_hexagon
from twins import needs_compiler

from bubblemesh.kernels.patches import least_around, least_around_in_numpy
from bubblemesh.packing.mending import disjoint_patches, disjoint_patches_in_numpy
from bubblemesh.packing.net import connect

pytestmark = needs_compiler


@pytest.mark.parametrize("seed", range(20))
def test_both_engines_find_the_same_patches(seed):
    random = np.random.default_rng(seed)
    domain, _, bubbles = packed_hexagon(12)
    gone = random.random(len(bubbles)) < 0.1
    gone[: bubbles.boundary_count] = False
    net = connect(bubbles.select(np.flatnonzero(~gone)), domain)
    middle = np.flatnonzero(random.random(len(net.bubbles)) < 0.02)
    _, part = net.part(net.within(middle, 3))
    for one in (net, part):
        bad = random.permutation(len(one.triangles))[: int(random.integers(0, 40))]
        found, plain = disjoint_patches(one, bad), disjoint_patches_in_numpy(one, bad)
        assert found.number == plain.number >= min(len(bad), 1)
        np.testing.assert_array_equal(found.displaced, plain.displaced)
        np.testing.assert_array_equal(found.moving, plain.moving)


@pytest.mark.parametrize("seed", range(3))
def test_both_engines_find_the_same_least_values_around(seed):
    random = np.random.default_rng(seed)
    _, _, bubbles = packed_hexagon(12)
    edges, values = random.integers(0, len(bubbles), (40, 2)), random.integers(0, 1000, len(bubbles))
    for rings in (0, 1, 4):
        found, plain = least_around(edges, values, rings), least_around_in_numpy(edges, values, rings)
        np.testing.assert_array_equal(found, plain)
    assert (found <= values).all()
    assert (found < values).any()
