from dataclasses import replace

import numpy as np
import pytest
from ellipse_packings import METHOD, front, settled_ellipses
from sweeps import sweep
from twins import needs_compiler, run_by

from bubblemesh.kernels.ellipse_annealing import Relaxing
from bubblemesh.kernels.library import NUMPY


@pytest.fixture(scope="module")
def settled():
    return settled_ellipses()


@needs_compiler
@pytest.mark.parametrize(("seed", "steps"), sweep([(0, 1), (1, 1), (1, 8), (0, 8), (2, 1), (2, 8)], quick=2))
def test_both_engines_anneal_alike(seed, steps, settled):
    scheme = replace(METHOD.annealing, effort="fast", shake_steps=steps)
    relaxing = Relaxing(settled.net.bubbles.boundary_count, steps, 0.5, 1.0)

    def found():
        return list(scheme(settled, front(), METHOD.relaxation, relaxing, np.random.default_rng(seed)))

    compiled = found()
    with run_by(NUMPY):
        plain = found()
    for (one, cycles), (other, same) in zip(compiled, plain, strict=True):
        assert cycles == same
        for part in ("x", "d"):
            np.testing.assert_array_equal(getattr(one.net.bubbles, part), getattr(other.net.bubbles, part))
        np.testing.assert_array_equal(one.net.triangles, other.net.triangles)
        np.testing.assert_array_equal(one.net.edges, other.net.edges)
    assert sum(cycles for _, cycles in compiled) == 40
    assert (compiled[0][0].net.triangles != compiled[1][0].net.triangles).any()
