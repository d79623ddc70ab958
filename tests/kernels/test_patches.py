import numpy as np
import pytest
from lattices import packed_hexagon
from twins import needs_compiler

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
