"""Kernels in their two forms."""

import pytest

from bubblemesh.kernels.library import COMPILED, engine

needs_compiler = pytest.mark.skipif(engine() != COMPILED, reason="no kernels are compiled here")
