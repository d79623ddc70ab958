"""A case made ready for packing: geometry and spacing checked, the method bound."""

from dataclasses import dataclass
from typing import Any

from bubblemesh import compromises
from bubblemesh.case import Case
from bubblemesh.case.rings import Ring as RingModel
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.rings import Ring
from bubblemesh.geometry.validity import ring_name
from bubblemesh.packing.methods import Method
from bubblemesh.packing.options import configured, options
from bubblemesh.resources import timed
from bubblemesh.spacing.expression import Expression
from bubblemesh.spacing.jumps import jumps
from bubblemesh.spacing.refinement import coarse_curves, short_pieces
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.survey import Survey, ideal_nodes, surveyed

__all__ = ["Problem", "Task", "posed", "prepared"]

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
    parameters : dict
        All parameters, defaults included, as reports tell them.
    """

    name: str
    method_name: str
    method: Method
    max_nodes: int
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
        outer, *holes = (_ring(model, k) for k, model in enumerate([case.domain.outer, *case.domain.holes]))
        domain = Domain.of(outer, holes)
    wanted = Spacing(Expression.parse(str(case.spacing), case.parameters))
    method = configured(case.method, case.packing, case.schedule)
    parameters = case.model_dump(mode="json", exclude={"packing", "schedule"}, exclude_none=True) | options(method)
    task = Task(str(case.name), case.method, method, case.limits.max_nodes, parameters)
    return posed(domain, wanted, task, seconds)


def posed(domain: Domain, wanted: Spacing, task: Task, seconds: dict[str, float]) -> Problem:
    """Check the spacing in the domain, and make it finer where the boundary asks for it.

    Raises
    ------
    CaseError, LimitError
        With the place and what to do.
    """
    max_nodes = task.max_nodes
    with timed(seconds, "spacing"):
        survey = surveyed(domain, wanted, max_nodes)
        wanted = wanted.floored(survey.minimum / 2)
        short, coarse = short_pieces(domain, wanted), coarse_curves(domain, wanted)
        steps = jumps(domain, wanted)
        spacing = short.joined(coarse).joined(steps).limited(wanted)
        expected = survey.ideal_nodes
        if spacing is not wanted:
            expected = ideal_nodes(domain, spacing, max_nodes, ESTIMATE)
        warnings = (
            *domain.notes,
            *compromises.sharp_angles(domain),
            *compromises.refined_boundary(short, coarse),
            *compromises.graded_jumps(steps),
            *compromises.narrow_walls(domain, spacing),
        )
    return Problem(task, domain, wanted, spacing, survey, expected, warnings, seconds)


def _ring(model: RingModel, number: int) -> Ring:
    """The ring of a case; its errors tell which one it is."""
    try:
        return model.ring()
    except GeometryError as error:
        raise GeometryError(f"{ring_name(number)}: {error}") from None
