import numpy as np
import pytest
from lattices import packed_hexagon
from twins import needs_compiler

from bubblemesh.kernels.disorder import disorder_marked
from bubblemesh.kernels.library import library
from bubblemesh.packing.annealing import disorder_marked_in_numpy
from bubblemesh.packing.net import connect

pytestmark = needs_compiler


def marked(net, inside, beside):
    return disorder_marked(library(), len(net.bubbles), net.edges, net.bubbles.boundary_count, inside, beside)


@pytest.mark.parametrize("share", [0.0, 0.02, 0.3])
def test_both_engines_mark_the_same_disorder(share):
    domain, _, bubbles = packed_hexagon(9)
    for seed in range(10):
        gone = np.random.default_rng(seed).random(len(bubbles)) < share
        gone[: bubbles.boundary_count] = False
        net = connect(bubbles.select(np.flatnonzero(~gone)), domain)
        values = marked(net, 0.3, 0.1)
        assert values.tobytes() == disorder_marked_in_numpy(net, 0.3, 0.1).tobytes()
        assert {0.1, 0.3} >= set(values[values != 0].tolist())
        assert not values[: net.bubbles.boundary_count].any()


def test_too_little_memory_is_an_error_and_no_crash():
    with pytest.raises(MemoryError):
        library().call("mark_disorder", 1 << 57, 0, np.zeros(0, np.int64), 0, 1.0, 1.0, np.zeros(0))
