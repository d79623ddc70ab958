"""The methods: a table whose rows are methods and whose columns are schemes."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from bubblemesh.packing.forces import VanDerWaals
from bubblemesh.packing.motion import ClassicalRungeKutta, RungeKutta, SecondOrderEuler
from bubblemesh.packing.perturbation import Perturbation
from bubblemesh.packing.placement import HierarchicalSubdivision
from bubblemesh.packing.population import Thresholds
from bubblemesh.packing.termination import FixedRounds, SelfAdaptive
from bubblemesh.packing.viscosity import Constant, OddBubbles, SawTooth, Viscosity

__all__ = ["METHODS", "SCHEMES", "Method"]


@dataclass(frozen=True)
class Method:
    """A packing method: one scheme, with its parameters, for each task."""

    placement: HierarchicalSubdivision
    perturbation: Perturbation
    force: VanDerWaals
    motion: RungeKutta
    viscosity: Viscosity
    odd: OddBubbles | None
    population: Thresholds
    termination: FixedRounds


FNPBS = Method(
    placement=HierarchicalSubdivision(w1=1.0, w2=1.0),
    perturbation=Perturbation(),
    force=VanDerWaals(),
    motion=SecondOrderEuler(),
    viscosity=SawTooth(),
    odd=None,
    population=Thresholds(delete_order="random"),
    termination=FixedRounds(),
)

METHODS = {
    "bpm": replace(
        FNPBS,
        motion=ClassicalRungeKutta(),
        viscosity=Constant(),
        population=Thresholds(delete_order="worst"),
    ),
    "fnpbs": FNPBS,
    "accelerated": replace(
        FNPBS,
        placement=HierarchicalSubdivision(w1=1.0, w2=0.6),
        odd=OddBubbles(),
        population=Thresholds(delete_order="placed"),
        termination=SelfAdaptive(),
    ),
}

# What a case may name in place of the method's own scheme for a task.
SCHEMES: Mapping[str, Mapping[str, type[Any] | None]] = {
    "motion": {"euler": SecondOrderEuler, "runge-kutta": ClassicalRungeKutta},
    "viscosity": {"constant": Constant, "saw-tooth": SawTooth},
    "odd": {"none": None, "touched": OddBubbles},
    "termination": {"fixed": FixedRounds, "self-adaptive": SelfAdaptive},
}
