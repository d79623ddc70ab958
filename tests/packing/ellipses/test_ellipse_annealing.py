from dataclasses import replace

import numpy as np
import pytest
from ellipse_packings import METHOD, front, settled_ellipses
from sweeps import sweep
from twins import needs_compiler

from bubblemesh.kernels.ellipse_annealing import Relaxing


@pytest.fixture(scope="module")
def settled():
    return settled_ellipses()


@needs_compiler
@pytest.mark.parametrize(("seed", "steps"), sweep([(0, 1), (1, 1), (1, 8), (0, 8), (2, 1), (2, 8)], quick=2))
def test_both_engines_anneal_alike(seed, steps, settled, monkeypatch):
    scheme = replace(METHOD.annealing, effort="fast", shake_steps=steps)
    relaxing = Relaxing(settled.net.bubbles.boundary_count, steps, 0.5, 1.0)

    def found():
        return list(scheme(settled, front(), METHOD.relaxation, relaxing, np.random.default_rng(seed)))

    compiled = found()
    monkeypatch.setattr("bubblemesh.packing.ellipses.annealing.library", lambda: None)
    for loops in ("flips", "motion"):
        monkeypatch.setattr(f"bubblemesh.kernels.ellipse_{loops}.library", lambda: None)
    for (one, cycles), (other, same) in zip(compiled, found(), strict=True):
        assert cycles == same
        for part in ("x", "d"):
            np.testing.assert_array_equal(getattr(one.net.bubbles, part), getattr(other.net.bubbles, part))
        np.testing.assert_array_equal(one.net.triangles, other.net.triangles)
        np.testing.assert_array_equal(one.net.edges, other.net.edges)
    assert sum(cycles for _, cycles in compiled) == 40
    assert (compiled[0][0].net.triangles != compiled[1][0].net.triangles).any()
