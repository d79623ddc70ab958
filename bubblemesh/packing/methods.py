"""The methods: a table whose rows are methods and whose columns are schemes."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.annealing import Annealing, NoAnnealing
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.forces import VanDerWaals
from bubblemesh.packing.levels import Doubling, Levels, SingleLevel
from bubblemesh.packing.mending import Mending, NoMending
from bubblemesh.packing.motion import ClassicalRungeKutta, Motion, SecondOrderEuler, SemiImplicitEuler
from bubblemesh.packing.placement import Perturbation, Placement
from bubblemesh.packing.placement.diffusion import ErrorDiffusion
from bubblemesh.packing.placement.lattice import HexagonalLattice
from bubblemesh.packing.placement.subdivision import HierarchicalSubdivision
from bubblemesh.packing.population import Defects, Population, Thresholds
from bubblemesh.packing.relaxation import Connected, Nearby, Relaxation
from bubblemesh.packing.smoothing import NoSmoothing, Smoothing
from bubblemesh.packing.termination import FixedRounds, SelfAdaptive, Settled, Termination
from bubblemesh.packing.viscosity import Constant, NoOddBubbles, OddBubbles, SawTooth, Viscosity
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing


@record
class Method:
    """A packing method: one scheme, with its parameters, for each task."""

    levels: Levels
    placement: Placement
    perturbation: Perturbation
    relaxation: Relaxation
    force: VanDerWaals
    motion: Motion
    population: Population
    annealing: NoAnnealing | Annealing
    smoothing: NoSmoothing | Smoothing
    mending: NoMending | Mending
    viscosity: Viscosity
    odd: NoOddBubbles | OddBubbles
    termination: Termination

    def started(
        self, domain: Domain, spacing: Spacing, expected_nodes: float, max_nodes: int
    ) -> tuple[tuple[Spacing, ...], Bubbles]:
        """The spacings of the levels, the coarsest first, and the bubbles of that one before any motion.

        LimitError if there would be many more than ``max_nodes`` of them.
        """
        placement = self.placement.fitted(domain, spacing, expected_nodes)
        levels = (spacing,) if placement.in_order else self.levels(domain, spacing, expected_nodes)
        if len(levels) > 1:
            placement = self.placement.fitted(domain, levels[0], halvings=len(levels) - 1)
        return levels, placement(domain, levels[0], max_nodes)


FNPBS = Method(
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

METHODS = {
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
    "multilevel": Method(
        levels=Doubling(),
        placement=HexagonalLattice(),
        perturbation=Perturbation(),
        relaxation=Connected(),
        force=VanDerWaals(),
        motion=SemiImplicitEuler(),
        population=Defects(),
        annealing=Annealing(),
        smoothing=Smoothing(),
        mending=Mending(),
        viscosity=Constant(c=1.0),
        odd=NoOddBubbles(),
        termination=Settled(),
    ),
}
# What a case with a metric is packed by: the multilevel method for ellipses, on one level.
METHODS["ellipses"] = replace(
    METHODS["multilevel"],
    levels=SingleLevel(),
    placement=ErrorDiffusion(),
    annealing=Annealing(amplitude_at_boundary=0.5),
    population=Defects(delete_shorter=0.72, insert_longer=1.5, insert_longer_at_crowd=1.3),
    smoothing=Smoothing(passes=6, shape_steps=4, spacing_weight=5.0),
    mending=Mending(mend_attempts=32, mend_worse=1.15),
)


class Column(NamedTuple):
    """A column of the table as a case knows it: where its parameters stand, which key names the scheme, and how."""

    section: str
    key: str | None
    schemes: Mapping[str, type[Any]]


COLUMNS = {
    "levels": Column("packing", "levels", {"single": SingleLevel, "doubling": Doubling}),
    "placement": Column(
        "packing",
        "placement",
        {"subdivision": HierarchicalSubdivision, "diffusion": ErrorDiffusion, "lattice": HexagonalLattice},
    ),
    "perturbation": Column("packing", None, {"normal": Perturbation}),
    "relaxation": Column("packing", "relaxation", {"nearby": Nearby, "connected": Connected}),
    "force": Column("packing", None, {"van-der-waals": VanDerWaals}),
    "motion": Column(
        "packing",
        "motion",
        {"euler": SecondOrderEuler, "runge-kutta": ClassicalRungeKutta, "semi-implicit": SemiImplicitEuler},
    ),
    "population": Column("packing", "population", {"thresholds": Thresholds, "defects": Defects}),
    "annealing": Column("packing", "shaking", {"none": NoAnnealing, "irregular": Annealing}),
    "smoothing": Column("packing", "polish", {"none": NoSmoothing, "shape": Smoothing}),
    "mending": Column("packing", "mending", {"none": NoMending, "patches": Mending}),
    "viscosity": Column("schedule", "viscosity", {"constant": Constant, "saw-tooth": SawTooth}),
    "odd": Column("schedule", "odd", {"none": NoOddBubbles, "touched": OddBubbles}),
    "termination": Column(
        "schedule", "termination", {"fixed": FixedRounds, "self-adaptive": SelfAdaptive, "settled": Settled}
    ),
}
