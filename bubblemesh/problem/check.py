"""The spacing checked in its domain, and made finer where its rules and the boundary ask for it."""

from dataclasses import replace

from bubblemesh.errors import CaseError, Key, about
from bubblemesh.geometry.domain import Domain
from bubblemesh.problem import warnings
from bubblemesh.problem.problem import Problem, Task
from bubblemesh.problem.spacing import SpacingRequest
from bubblemesh.resources import timed
from bubblemesh.spacing.rules.rules import limited_across_sides, limited_for_packing_across_sides
from bubblemesh.spacing.rules.sources import coarse_curves, short_pieces
from bubblemesh.spacing.survey import ideal_nodes, surveyed

ESTIMATE = 0.05  # relative tolerance of an estimate that only limits and announces the number of nodes


def check_spacing(
    domain: Domain, request: SpacingRequest, task: Task, seconds: dict[str, float], scale: float | None = None
) -> Problem:
    """Check the spacing, at some scale, in the domain, and make it finer where its rules and the boundary ask for it.

    Raises
    ------
    CaseError, LimitError
        With the place and what to do.
    """
    max_nodes = task.max_nodes
    with about(Key(["domain", "periodic"])):
        if len(domain.periodic) and not task.method.relaxation.boundary_stays:
            raise CaseError(
                "domain.periodic: bubbles would slide along the sides: use relaxation: connected, or multilevel"
            )
    with timed(seconds, "spacing"):
        spacing, rules = request.at(scale), request.rules
        survey = surveyed(domain, spacing, max_nodes)
        after_rules = rules(domain, replace(spacing, floor=survey.extremes.minimum / 2), max_nodes)
        after_periodic = limited_across_sides(domain, after_rules)
        spacing = after_periodic.spacing
        if max(after_rules.ratio, after_periodic.ratio) > 1:
            survey = surveyed(domain, spacing, max_nodes)
        short, coarse = short_pieces(domain, spacing), coarse_curves(domain, spacing)
        for_packing = limited_for_packing_across_sides(domain, after_periodic, short.joined(coarse))
        expected = survey.ideal_nodes
        if for_packing.spacing is not spacing:
            expected = ideal_nodes(domain, for_packing.spacing, max_nodes, ESTIMATE)
        told = (
            *domain.notes,
            *request.warnings,
            *warnings.sharp_angles(domain),
            *warnings.refined_boundary(short, coarse),
            *warnings.limited_growth(for_packing, rules.growth, scale),
            *warnings.narrow_parts(domain, for_packing.spacing),
        )
    return Problem(
        task, domain, spacing, for_packing.spacing, survey, expected, after_rules, after_periodic, told, seconds
    )
