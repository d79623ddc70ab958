"""The methods: a table whose rows are methods and whose columns are schemes."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from bubblemesh.packing.annealing import CyclicAnnealing, NoAnnealing
from bubblemesh.packing.circles import CircleMethod
from bubblemesh.packing.ellipses.annealing import EllipseAnnealing, EllipseRelaxation, NoEllipseAnnealing
from bubblemesh.packing.ellipses.mending import EllipseMending, NoEllipseMending
from bubblemesh.packing.ellipses.packing import EllipseMethod
from bubblemesh.packing.ellipses.population import EllipseDefects
from bubblemesh.packing.ellipses.smoothing import EllipseSmoothing, NoEllipseSmoothing
from bubblemesh.packing.forces import VanDerWaals
from bubblemesh.packing.levels import Doubling, SingleLevel
from bubblemesh.packing.mending import Mending, NoMending
from bubblemesh.packing.method import Method
from bubblemesh.packing.motion import ClassicalRungeKutta, SecondOrderEuler, SemiImplicitEuler
from bubblemesh.packing.placement import Perturbation
from bubblemesh.packing.placement.diffusion import ErrorDiffusion
from bubblemesh.packing.placement.lattice import HexagonalLattice
from bubblemesh.packing.placement.subdivision import HierarchicalSubdivision
from bubblemesh.packing.population import Defects, Thresholds
from bubblemesh.packing.relaxation import Connected, Nearby
from bubblemesh.packing.smoothing import NoSmoothing, Smoothing
from bubblemesh.packing.termination import FixedRounds, SelfAdaptive, Settled
from bubblemesh.packing.viscosity import Constant, NoOddBubbles, OddBubbles, SawTooth

FNPBS = CircleMethod(
    levels=SingleLevel(),
    placement=HierarchicalSubdivision(w1=1.0, w2=1.0),
    perturbation=Perturbation(),
    relaxation=Nearby(),
    force=VanDerWaals(),
    motion=SecondOrderEuler(),
    population=Thresholds(delete_order="random"),
    annealing=NoAnnealing(),
    smoothing=NoSmoothing(),
    mending=NoMending(),
    viscosity=SawTooth(),
    odd=NoOddBubbles(),
    termination=FixedRounds(),
)

# What a case with a metric is packed by: the multilevel method for ellipses, on one level.
ELLIPSES = EllipseMethod(
    levels=SingleLevel(),
    placement=ErrorDiffusion(),
    perturbation=Perturbation(),
    relaxation=EllipseRelaxation(),
    motion=SemiImplicitEuler(),
    population=EllipseDefects(delete_shorter=0.72, insert_longer=1.5, insert_longer_at_crowd=1.3),
    annealing=EllipseAnnealing(amplitude=0.18, amplitude_at_boundary=0.5, shake_steps=8),
    smoothing=EllipseSmoothing(passes=6, shape_steps=4, spacing_weight=5.0),
    mending=EllipseMending(mend_attempts=32, mend_worse=1.15),
    viscosity=Constant(c=1.0),
    odd=NoOddBubbles(),
    termination=Settled(),
)

METHODS: dict[str, Method] = {
    "bpm": replace(
        FNPBS,
        motion=ClassicalRungeKutta(),
        population=Thresholds(delete_order="worst"),
        viscosity=Constant(),
    ),
    "fnpbs": FNPBS,
    "accelerated": replace(
        FNPBS,
        placement=HierarchicalSubdivision(w1=1.0, w2=0.6),
        population=Thresholds(delete_order="placed"),
        odd=OddBubbles(),
        termination=SelfAdaptive(),
    ),
    "multilevel": CircleMethod(
        levels=Doubling(),
        placement=HexagonalLattice(),
        perturbation=Perturbation(),
        relaxation=Connected(),
        force=VanDerWaals(),
        motion=SemiImplicitEuler(),
        population=Defects(),
        annealing=CyclicAnnealing(),
        smoothing=Smoothing(spacing_weight=8.0),
        mending=Mending(),
        viscosity=Constant(c=1.0),
        odd=NoOddBubbles(),
        termination=Settled(),
    ),
    "ellipses": ELLIPSES,
}


class Column(NamedTuple):
    """A column of the table as a case knows it: where its parameters stand, which key names the scheme, and how."""

    section: str
    key: str | None
    circles: Mapping[str, type[Any]]
    ellipses: Mapping[str, type[Any]]

    def schemes(self, method: Method) -> Mapping[str, type[Any]]:
        """The schemes that a method may have, by their names in a case; none if it has no such column."""
        return self.ellipses if method.in_metric else self.circles


PLACEMENTS = {"subdivision": HierarchicalSubdivision, "diffusion": ErrorDiffusion, "lattice": HexagonalLattice}
PERTURBATIONS = {"normal": Perturbation}
MOTIONS = {"euler": SecondOrderEuler, "runge-kutta": ClassicalRungeKutta, "semi-implicit": SemiImplicitEuler}
TERMINATIONS = {"fixed": FixedRounds, "self-adaptive": SelfAdaptive, "settled": Settled}

COLUMNS = {
    "levels": Column("packing", "levels", {"single": SingleLevel, "doubling": Doubling}, {"single": SingleLevel}),
    "placement": Column("packing", "placement", PLACEMENTS, PLACEMENTS),
    "perturbation": Column("packing", None, PERTURBATIONS, PERTURBATIONS),
    "relaxation": Column(
        "packing", "relaxation", {"nearby": Nearby, "connected": Connected}, {"connected": EllipseRelaxation}
    ),
    "force": Column("packing", None, {"van-der-waals": VanDerWaals}, {}),
    "motion": Column("packing", "motion", MOTIONS, {"semi-implicit": SemiImplicitEuler}),
    "population": Column(
        "packing", "population", {"thresholds": Thresholds, "defects": Defects}, {"defects": EllipseDefects}
    ),
    "annealing": Column(
        "packing",
        "shaking",
        {"none": NoAnnealing, "irregular": CyclicAnnealing},
        {"none": NoEllipseAnnealing, "irregular": EllipseAnnealing},
    ),
    "smoothing": Column(
        "packing",
        "polish",
        {"none": NoSmoothing, "shape": Smoothing},
        {"none": NoEllipseSmoothing, "shape": EllipseSmoothing},
    ),
    "mending": Column(
        "packing",
        "mending",
        {"none": NoMending, "patches": Mending},
        {"none": NoEllipseMending, "patches": EllipseMending},
    ),
    "viscosity": Column("schedule", "viscosity", {"constant": Constant, "saw-tooth": SawTooth}, {"constant": Constant}),
    "odd": Column("schedule", "odd", {"none": NoOddBubbles, "touched": OddBubbles}, {"none": NoOddBubbles}),
    "termination": Column("schedule", "termination", TERMINATIONS, TERMINATIONS),
}
