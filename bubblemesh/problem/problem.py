"""A case made ready for packing: geometry and spacing checked, the method bound."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from bubblemesh.case import Case
from bubblemesh.errors import CaseError, LimitError
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.configure import configured, options
from bubblemesh.packing.methods import Method
from bubblemesh.problem import warnings
from bubblemesh.problem.domain import case_domain
from bubblemesh.problem.node_target import Scales, next_aim, scaled_to
from bubblemesh.problem.spacing import Wanted, wanted_of
from bubblemesh.resources import timed
from bubblemesh.spacing.rules.grading import LimitedSpacing
from bubblemesh.spacing.rules.periodic import limited_across_sides, limited_for_packing_across_sides
from bubblemesh.spacing.rules.sources import coarse_curves, short_pieces
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.survey import Extremes, Survey, extremes, ideal_nodes, surveyed

ESTIMATE = 0.05  # relative tolerance of an estimate that only limits and announces the number of nodes
FLATTEST = 0.5  # slope of the nodes that are found over those that are expected, in logarithms
FEW = 100_000  # nodes that the search for a scale may count, whatever is wanted
TIMES_TOO_MANY = 4  # the wanted nodes: more need no counting


@dataclass(frozen=True)
class Task:
    """How to mesh.

    Attributes
    ----------
    name : str
        Name of the case.
    method_name : str
    method : Method
    max_nodes : int
        Largest number of nodes that the mesh may need.
    time_limit : float or None
        Seconds after which the packing ends as it is.
    parameters : dict
        All parameters, defaults included, as reports tell them.
    """

    name: str
    method_name: str
    method: Method
    max_nodes: int
    time_limit: float | None
    parameters: dict[str, Any]


@dataclass(frozen=True)
class Problem:
    """Geometry and spacing checked and ready for packing.

    Attributes
    ----------
    task : Task
    domain : Domain
    wanted, spacing : Spacing
        What the case asks for, and what the packing goes by: finer where the boundary is.
    survey : Survey
        Extremes of the wanted spacing and the ideal number of nodes.
    expected_nodes : float
        The same number for the spacing that the packing goes by.
    ruled, tied : LimitedSpacing
        How the rules of the wanted spacing changed it, and then the counterparts of periodic sides, if they did.
    warnings : tuple of str
    seconds : dict
        Time taken, by stage.
    budget : Budget or None
        The scale of the spacing, if it was found for a number of nodes.
    """

    task: Task
    domain: Domain
    wanted: Spacing
    spacing: Spacing
    survey: Survey
    expected_nodes: float
    ruled: LimitedSpacing
    tied: LimitedSpacing
    warnings: tuple[str, ...]
    seconds: dict[str, float]
    budget: "Budget | None" = None

    @property
    def method(self) -> Method:
        """The packing method."""
        return self.task.method

    @property
    def refined(self) -> bool:
        """Whether the packing goes by a finer spacing than the wanted one somewhere."""
        return self.spacing is not self.wanted

    @property
    def changes(self) -> dict[str, LimitedSpacing]:
        """What made the wanted spacing finer than its terms, as reports name it."""
        found = {"rules": self.ruled, "periodic": self.tied}
        if self.tied is self.ruled:
            del found["periodic"]
        return {name: changed for name, changed in found.items() if changed.ratio > 1}

    @cached_property
    def packed(self) -> Extremes:
        """Extremes of the spacing that the packing goes by."""
        survey = self.survey
        if not self.refined:
            return Extremes(survey.minimum, survey.minimum_at, survey.maximum, survey.maximum_at)
        return extremes(self.domain, self.spacing)


@dataclass(frozen=True)
class Budget:
    """A number of nodes that is to be met.

    Attributes
    ----------
    nodes : int
    scale : float
        Factor of the spacing at which about so many are expected.
    corrected : callable
        The problem anew, after meshes for which numbers of nodes were expected and found: with a better scale, or the
        same if it is the last one.
    """

    nodes: int
    scale: float
    corrected: Callable[[Sequence[tuple[float, int]]], Problem]


def prepared(case: Case) -> Problem:
    """Check geometry and spacing of a case, and bind its method.

    Raises
    ------
    GeometryError, CaseError, LimitError
        With the place and what to do.
    """
    seconds: dict[str, float] = {}
    with timed(seconds, "geometry"):
        domain = case_domain(case)
    return posed_for(domain, wanted_of(case, domain), task_of(case), seconds)


def posed_for(
    domain: Domain, wanted: Wanted, task: Task, seconds: dict[str, float], asked: str = "spacing.nodes"
) -> Problem:
    """Pose the problem for what is asked of the spacing; ``asked`` is what messages call its number of nodes."""
    if wanted.nodes is None:
        return posed(domain, wanted, task, seconds)
    return budgeted(domain, wanted, wanted.nodes, task, seconds, asked)


def task_of(case: Case) -> Task:
    """How to mesh a case."""
    method = configured(case.method, case.packing, case.schedule)
    parameters = case.model_dump(mode="json", exclude={"packing", "schedule"}, exclude_none=True) | options(method)
    return Task(str(case.name), case.method, method, case.limits.max_nodes, case.limits.seconds, parameters)


def budgeted(domain: Domain, wanted: Wanted, nodes: int, task: Task, seconds: dict[str, float], asked: str) -> Problem:
    """Pose the problem with the scale of the spacing at which so many nodes are expected.

    Raises
    ------
    CaseError, LimitError
        If no scale does; else as `posed`.
    """
    if nodes > task.max_nodes:
        raise LimitError(
            f"limits.max_nodes: {asked} asks for {nodes}, more than the limit of {task.max_nodes}: ask for "
            "fewer or raise the limit"
        )
    scales, spent = Scales.of(domain, wanted.at), replace(task, max_nodes=max(FEW, TIMES_TOO_MANY * nodes))
    problems: dict[float, Problem] = {}

    def count(scale: float) -> float:
        try:
            problems[scale] = posed(domain, wanted, spent, seconds, scale)
        except LimitError:
            return np.inf
        return problems[scale].expected_nodes

    def at(expected: float, start: float | None = None) -> Problem:
        """The problem in which so many are expected; from a rough number to start from, as nearly as can be."""
        time = dict(seconds)
        with timed(time, "spacing"):
            scale = scaled_to(expected, scales, count, start, asked if start is None else None)
        problem = replace(problems[scale], task=task, seconds=time)
        rough = scales.rough(np.log(scale))

        def corrected(found: Sequence[tuple[float, int]]) -> Problem:
            trials = [(np.log(expected), np.log(meshed)) for expected, meshed in found]
            aim = next_aim(trials, np.log(nodes), FLATTEST)
            return at(np.exp(aim), np.exp(rough + aim - np.log(problem.expected_nodes)))

        return replace(problem, budget=Budget(nodes, scale, corrected))

    return at(nodes)


def posed(domain: Domain, asked: Wanted, task: Task, seconds: dict[str, float], scale: float | None = None) -> Problem:
    """Check the spacing, at some scale, in the domain, and make it finer where its rules and the boundary ask for it.

    Raises
    ------
    CaseError, LimitError
        With the place and what to do.
    """
    max_nodes = task.max_nodes
    if len(domain.periodic) and not task.method.relaxation.boundary_stays:
        raise CaseError(
            "domain.periodic: bubbles would slide along the sides: use relaxation: connected, or multilevel"
        )
    with timed(seconds, "spacing"):
        wanted, rules = asked.at(scale), asked.rules
        survey = surveyed(domain, wanted, max_nodes)
        ruled = rules(domain, wanted.floored(survey.minimum / 2), max_nodes)
        tied = limited_across_sides(domain, ruled)
        wanted = tied.spacing
        if max(ruled.ratio, tied.ratio) > 1:
            survey = surveyed(domain, wanted, max_nodes)
        short, coarse = short_pieces(domain, wanted), coarse_curves(domain, wanted)
        grading = limited_for_packing_across_sides(domain, tied, short.joined(coarse))
        spacing = grading.spacing
        expected = survey.ideal_nodes
        if spacing is not wanted:
            expected = ideal_nodes(domain, spacing, max_nodes, ESTIMATE)
        told = (
            *domain.notes,
            *asked.warnings,
            *warnings.sharp_angles(domain),
            *warnings.refined_boundary(short, coarse),
            *warnings.limited_growth(grading, rules.growth, scale),
            *warnings.narrow_parts(domain, spacing),
        )
    return Problem(task, domain, wanted, spacing, survey, expected, ruled, tied, told, seconds)
