"""The schemes of a method that a packing in a metric goes by."""

from collections.abc import Mapping
from typing import Any, NamedTuple, Self

from bubblemesh.errors import CaseError, Key, about
from bubblemesh.packing.annealing import Annealing, NoAnnealing
from bubblemesh.packing.levels import SingleLevel
from bubblemesh.packing.mending import Mending, NoMending
from bubblemesh.packing.methods import COLUMNS, METHODS, Method
from bubblemesh.packing.motion import SemiImplicitEuler
from bubblemesh.packing.population import Defects
from bubblemesh.packing.relaxation import Connected
from bubblemesh.packing.smoothing import NoSmoothing, Smoothing
from bubblemesh.packing.termination import Termination
from bubblemesh.packing.viscosity import Constant, NoOddBubbles

# Columns of the table of methods in which only one scheme has a form in a metric.
POSSIBLE: Mapping[str, type[Any]] = {
    "levels": SingleLevel,
    "relaxation": Connected,
    "motion": SemiImplicitEuler,
    "population": Defects,
    "viscosity": Constant,
    "odd": NoOddBubbles,
}
# Parameters that have no effect there: the force and the steps along edges are those of its kernels.
UNUSED = {"force": ("k0", "force"), "relaxation": ("refresh",), "smoothing": ("shape_step",)}


class Schemes(NamedTuple):
    """Schemes that have a form in a metric, with their parameters."""

    motion: SemiImplicitEuler
    viscosity: Constant
    population: Defects
    annealing: Annealing | NoAnnealing
    smoothing: Smoothing | NoSmoothing
    mending: Mending | NoMending
    termination: Termination

    @classmethod
    def of(cls, method: Method) -> Self:
        """Schemes of a method; CaseError if one has no form in a metric, or a parameter no effect."""
        _require_possible(method)
        motion, viscosity, population = method.motion, method.viscosity, method.population
        assert isinstance(motion, SemiImplicitEuler)
        assert isinstance(viscosity, Constant)
        assert isinstance(population, Defects)
        rest = method.annealing, method.smoothing, method.mending, method.termination
        return cls(motion, viscosity, population, *rest)


def _require_possible(method: Method) -> None:
    for name, kind in POSSIBLE.items():
        section, key, schemes = COLUMNS[name]
        if not isinstance(getattr(method, name), kind):
            only = next(each for each, scheme in schemes.items() if scheme is kind)
            with about(Key([section])):
                raise CaseError(f"{section}.{key}: in a metric only {only} is possible: leave it out")
    for name, keys in UNUSED.items():
        given, row = vars(getattr(method, name)), vars(getattr(METHODS["ellipses"], name))
        for key in keys:
            if given.get(key, row[key]) != row[key]:
                section = COLUMNS[name].section
                with about(Key([section])):
                    raise CaseError(f"{section}.{key}: it has no effect in a metric: leave it out")
