"""The schemes of a method that a packing in a metric goes by."""

from typing import NamedTuple, Self

from bubblemesh.errors import CaseError
from bubblemesh.packing.annealing import Annealing, NoAnnealing
from bubblemesh.packing.levels import SingleLevel
from bubblemesh.packing.mending import Mending, NoMending
from bubblemesh.packing.methods import Method
from bubblemesh.packing.motion import SemiImplicitEuler
from bubblemesh.packing.population import Defects
from bubblemesh.packing.smoothing import NoSmoothing, Smoothing
from bubblemesh.packing.termination import Termination
from bubblemesh.packing.viscosity import Viscosity


class Schemes(NamedTuple):
    """Schemes that have a form in a metric, with their parameters."""

    motion: SemiImplicitEuler
    viscosity: Viscosity
    population: Defects
    annealing: Annealing | NoAnnealing
    smoothing: Smoothing | NoSmoothing
    mending: Mending | NoMending
    termination: Termination

    @classmethod
    def of(cls, method: Method) -> Self:
        """Schemes of a method; CaseError if one has no form in a metric."""
        motion, population = method.motion, method.population
        if not isinstance(motion, SemiImplicitEuler):
            raise CaseError("packing.motion: in a metric only semi-implicit is possible: leave it out")
        if not isinstance(population, Defects):
            raise CaseError("packing.population: in a metric only defects is possible: leave it out")
        if not isinstance(method.levels, SingleLevel):
            raise CaseError("packing.levels: in a metric only single is possible: leave it out")
        return cls(
            motion,
            method.viscosity,
            population,
            method.annealing,
            method.smoothing,
            method.mending,
            method.termination,
        )
