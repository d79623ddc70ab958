"""The spacing checked in its domain, and made finer where its rules and the boundary ask for it."""

from bubblemesh.errors import CaseError
from bubblemesh.geometry.domain import Domain
from bubblemesh.problem import warnings
from bubblemesh.problem.problem import Problem, Task
from bubblemesh.problem.spacing import Wanted
from bubblemesh.resources import timed
from bubblemesh.spacing.rules.periodic import limited_across_sides, limited_for_packing_across_sides
from bubblemesh.spacing.rules.sources import coarse_curves, short_pieces
from bubblemesh.spacing.survey import ideal_nodes, surveyed

ESTIMATE = 0.05  # relative tolerance of an estimate that only limits and announces the number of nodes


def check_spacing(
    domain: Domain, asked: Wanted, task: Task, seconds: dict[str, float], scale: float | None = None
) -> Problem:
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
