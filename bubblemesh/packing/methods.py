"""The methods: a table whose rows are methods and whose columns are schemes."""

from dataclasses import dataclass

from bubblemesh.packing.forces import VanDerWaals
from bubblemesh.packing.motion import RungeKutta, SecondOrderEuler
from bubblemesh.packing.perturbation import Perturbation
from bubblemesh.packing.placement import HierarchicalSubdivision
from bubblemesh.packing.population import Thresholds
from bubblemesh.packing.termination import FixedRounds, SelfAdaptive
from bubblemesh.packing.viscosity import OddBubbles, SawTooth

__all__ = ["METHODS", "Method"]


@dataclass(frozen=True)
class Method:
    """A packing method: one scheme, with its parameters, for each task."""

    placement: HierarchicalSubdivision
    perturbation: Perturbation
    force: VanDerWaals
    motion: RungeKutta
    viscosity: SawTooth
    odd: OddBubbles | None
    population: Thresholds
    termination: FixedRounds


METHODS = {
    "accelerated": Method(
        placement=HierarchicalSubdivision(w1=1.0, w2=0.6),
        perturbation=Perturbation(),
        force=VanDerWaals(),
        motion=SecondOrderEuler(),
        viscosity=SawTooth(),
        odd=OddBubbles(),
        population=Thresholds(),
        termination=SelfAdaptive(),
    ),
}
