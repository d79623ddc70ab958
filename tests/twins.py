"""Kernels in their two forms."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from bubblemesh.kernels.library import CHOICE, COMPILED, engine, library

needs_compiler = pytest.mark.skipif(engine() != COMPILED, reason="no kernels are compiled here")


@contextmanager
def run_by(name: str) -> Iterator[None]:
    """Run all kernels by one engine, compiled or numpy, also in processes that begin meanwhile."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(CHOICE, name)
        library.cache_clear()
        try:
            yield
        finally:
            library.cache_clear()
