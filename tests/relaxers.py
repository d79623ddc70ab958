"""Relaxation by a function of tests, for annealing."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from lattices import DAMPED

from bubblemesh.packing.relaxation import Relaxer


@dataclass
class Uncompiled:
    """Relaxation by a function of a net and steps, which kernels do not know."""

    relax: Callable
    refresh: ClassVar[int] = 0

    def __call__(self, net, domain, spacing, dynamics, steps):
        return self.relax(net, steps)


def relaxer(relax, domain, spacing):
    """Relaxation on a level by a function of a net and steps."""
    return Relaxer(Uncompiled(relax), domain, spacing, DAMPED)
