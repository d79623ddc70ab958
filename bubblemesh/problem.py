"""A case made ready for packing: geometry and spacing checked, the method bound."""

from dataclasses import dataclass

from bubblemesh import compromises
from bubblemesh.case import Case
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.methods import Method
from bubblemesh.packing.options import configured
from bubblemesh.resources import timed
from bubblemesh.spacing.expression import Expression
from bubblemesh.spacing.refinement import coarse_curves, short_pieces
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.survey import Survey, ideal_nodes, surveyed

__all__ = ["Problem", "prepared"]

ESTIMATE = 0.05  # relative tolerance of an estimate that only limits and announces the number of nodes


@dataclass(frozen=True)
class Problem:
    """A case made ready for packing.

    Attributes
    ----------
    case : Case
    domain : Domain
    wanted, spacing : Spacing
        What the case asks for, and what the packing goes by: finer where the boundary is.
    survey : Survey
        Extremes of the wanted spacing and the ideal number of nodes.
    expected_nodes : float
        The same number for the spacing that the packing goes by.
    method : Method
    warnings : tuple of str
    seconds : dict
        Time taken, by stage.
    """

    case: Case
    domain: Domain
    wanted: Spacing
    spacing: Spacing
    survey: Survey
    expected_nodes: float
    method: Method
    warnings: tuple[str, ...]
    seconds: dict[str, float]

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
        domain = Domain.of(*case.domain.rings())
    with timed(seconds, "spacing"):
        wanted = Spacing(Expression.parse(str(case.spacing), case.parameters))
        survey = surveyed(domain, wanted, case.limits.max_nodes)
        wanted = wanted.floored(survey.minimum / 2)
        short, coarse = short_pieces(domain, wanted), coarse_curves(domain, wanted)
        spacing = short.joined(coarse).limited(wanted)
        expected = survey.ideal_nodes
        if spacing is not wanted:
            expected = ideal_nodes(domain, spacing, case.limits.max_nodes, ESTIMATE)
        warnings = (
            *domain.notes,
            *compromises.sharp_angles(domain),
            *compromises.refined_boundary(short, coarse),
            *compromises.narrow_walls(domain, spacing),
        )
    method = configured(case.method, case.packing, case.schedule)
    return Problem(case, domain, wanted, spacing, survey, expected, method, warnings, seconds)
