"""A case made ready for packing: geometry and spacing checked, the method bound."""

from dataclasses import dataclass
from typing import Any

from bubblemesh import compromises
from bubblemesh.case import Case
from bubblemesh.case.rings import rings_of
from bubblemesh.errors import CaseError, GeometryError
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.regions import Parts, Region
from bubblemesh.packing.methods import Method
from bubblemesh.packing.options import configured, options
from bubblemesh.resources import timed
from bubblemesh.spacing.grading import GROWTH, Graded, graded
from bubblemesh.spacing.refinement import coarse_curves, short_pieces
from bubblemesh.spacing.rules import Rules
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.survey import Survey, ideal_nodes, surveyed
from bubblemesh.wanted import rules_of, wanted_of

__all__ = ["Problem", "Task", "posed", "prepared"]

NO_RULES = Rules()
ESTIMATE = 0.05  # relative tolerance of an estimate that only limits and announces the number of nodes


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
    ruled : Graded
        How the rules of the wanted spacing changed it.
    warnings : tuple of str
    seconds : dict
        Time taken, by stage.
    """

    task: Task
    domain: Domain
    wanted: Spacing
    spacing: Spacing
    survey: Survey
    expected_nodes: float
    ruled: Graded
    warnings: tuple[str, ...]
    seconds: dict[str, float]

    @property
    def method(self) -> Method:
        """The packing method."""
        return self.task.method

    @property
    def refined(self) -> bool:
        """Whether the packing goes by a finer spacing than the wanted one somewhere."""
        return self.spacing is not self.wanted


def prepared(case: Case) -> Problem:
    """Check geometry and spacing of a case, and bind its method.

    Raises
    ------
    GeometryError, CaseError, LimitError
        With the place and what to do.
    """
    seconds: dict[str, float] = {}
    with timed(seconds, "geometry"):
        domain = Domain.of(*case.domain.rings(), _parts(case))
    wanted, rules = wanted_of(case, domain), rules_of(case)
    method = configured(case.method, case.packing, case.schedule)
    parameters = case.model_dump(mode="json", exclude={"packing", "schedule"}, exclude_none=True) | options(method)
    task = Task(str(case.name), case.method, method, case.limits.max_nodes, case.limits.seconds, parameters)
    return posed(domain, wanted, task, seconds, rules)


def posed(domain: Domain, wanted: Spacing, task: Task, seconds: dict[str, float], rules: Rules = NO_RULES) -> Problem:
    """Check the spacing in the domain, and make it finer where its rules and the boundary ask for it.

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
        survey = surveyed(domain, wanted, max_nodes)
        ruled = rules(domain, wanted.floored(survey.minimum / 2))
        wanted = ruled.spacing
        if ruled.ratio > 1:
            survey = surveyed(domain, wanted, max_nodes)
        short, coarse = short_pieces(domain, wanted), coarse_curves(domain, wanted)
        grading = graded(domain, wanted, GROWTH, short.joined(coarse))
        spacing = grading.spacing
        expected = survey.ideal_nodes
        if spacing is not wanted:
            expected = ideal_nodes(domain, spacing, max_nodes, ESTIMATE)
        warnings = (
            *domain.notes,
            *compromises.sharp_angles(domain),
            *compromises.refined_boundary(short, coarse),
            *compromises.slowed_growth(grading),
            *compromises.narrow_walls(domain, spacing),
            *compromises.narrow_strips(domain, spacing),
        )
    return Problem(task, domain, wanted, spacing, survey, expected, ruled, warnings, seconds)


def _parts(case: Case) -> Parts:
    """Regions and what is embedded; errors tell which one it is.

    Raises
    ------
    GeometryError, CaseError, FileError
    """
    regions = []
    for model in case.domain.regions:
        try:
            rim = f"{model.name}-rim"  # also where a file calls the ring as the case calls the region
            regions += [Region(ring.renamed(model.name, rim), model.name, label=rim) for ring in rings_of(model.ring)]
        except GeometryError as error:
            raise GeometryError(f"region {model.name!r}: {error}") from None
    strands = []
    for number, line in enumerate(case.domain.lines, start=1):
        try:
            strands.append(line.strand(default=f"line-{number}"))
        except GeometryError as error:
            raise GeometryError(f"line {number}: {error}") from None
    points = [(point.at, point.label or f"point-{number}") for number, point in enumerate(case.domain.points, start=1)]
    return Parts(tuple(regions), case.domain.region, tuple(strands), tuple(points), case.domain.periodic)
