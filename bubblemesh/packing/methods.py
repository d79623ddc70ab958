"""The methods: a table whose rows are methods and whose columns are schemes."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from bubblemesh.packing.annealing import Annealing
from bubblemesh.packing.forces import VanDerWaals
from bubblemesh.packing.levels import Doubling, Levels, SingleLevel
from bubblemesh.packing.mending import Mending
from bubblemesh.packing.motion import ClassicalRungeKutta, Motion, SecondOrderEuler, SemiImplicitEuler
from bubblemesh.packing.placement.diffusion import ErrorDiffusion
from bubblemesh.packing.placement.perturbation import Perturbation
from bubblemesh.packing.placement.subdivision import HierarchicalSubdivision, Placement
from bubblemesh.packing.population.defects import Defects
from bubblemesh.packing.population.thresholds import Population, Thresholds
from bubblemesh.packing.relaxation import Connected, Nearby, Relaxation
from bubblemesh.packing.smoothing import Smoothing
from bubblemesh.packing.termination import FixedRounds, SelfAdaptive, Settled
from bubblemesh.packing.viscosity import Constant, OddBubbles, SawTooth, Viscosity


@dataclass(frozen=True)
class Method:
    """A packing method: one scheme, with its parameters, for each task."""

    levels: Levels
    placement: Placement
    perturbation: Perturbation
    relaxation: Relaxation
    force: VanDerWaals
    motion: Motion
    viscosity: Viscosity
    odd: OddBubbles | None
    population: Population
    termination: FixedRounds
    shaking: Annealing | None
    polish: Smoothing | None
    mending: Mending | None


FNPBS = Method(
    levels=SingleLevel(),
    placement=HierarchicalSubdivision(w1=1.0, w2=1.0),
    perturbation=Perturbation(),
    relaxation=Nearby(),
    force=VanDerWaals(),
    motion=SecondOrderEuler(),
    viscosity=SawTooth(),
    odd=None,
    population=Thresholds(delete_order="random"),
    termination=FixedRounds(),
    shaking=None,
    polish=None,
    mending=None,
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
    "multilevel": Method(
        levels=Doubling(),
        placement=ErrorDiffusion(),
        perturbation=Perturbation(),
        relaxation=Connected(),
        force=VanDerWaals(),
        motion=SemiImplicitEuler(),
        viscosity=Constant(c=1.0),
        odd=None,
        population=Defects(),
        termination=Settled(),
        shaking=Annealing(),
        polish=Smoothing(),
        mending=Mending(),
    ),
}

# What a case may name in place of the method's own scheme for a task.
SCHEMES: Mapping[str, Mapping[str, type[Any] | None]] = {
    "levels": {"single": SingleLevel, "doubling": Doubling},
    "placement": {"subdivision": HierarchicalSubdivision, "diffusion": ErrorDiffusion},
    "relaxation": {"nearby": Nearby, "connected": Connected},
    "motion": {"euler": SecondOrderEuler, "runge-kutta": ClassicalRungeKutta, "semi-implicit": SemiImplicitEuler},
    "population": {"thresholds": Thresholds, "defects": Defects},
    "shaking": {"none": None, "irregular": Annealing},
    "polish": {"none": None, "shape": Smoothing},
    "mending": {"none": None, "patches": Mending},
    "viscosity": {"constant": Constant, "saw-tooth": SawTooth},
    "odd": {"none": None, "touched": OddBubbles},
    "termination": {"fixed": FixedRounds, "self-adaptive": SelfAdaptive, "settled": Settled},
}
