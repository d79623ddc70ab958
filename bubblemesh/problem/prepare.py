"""From a case to a problem: the domain, the spacing request and the method, bound and checked."""

from dataclasses import replace

from bubblemesh.case import Case
from bubblemesh.errors import CaseError, Key, about
from bubblemesh.geometry.domain import Domain
from bubblemesh.limits import enter, timed
from bubblemesh.packing.configure import options
from bubblemesh.problem import warnings
from bubblemesh.problem.domain import case_domain
from bubblemesh.problem.node_target import Scales, ScaleSearch, fit_node_target
from bubblemesh.problem.problem import Problem, Task
from bubblemesh.problem.spacing import SpacingRequest, case_spacing
from bubblemesh.spacing.rules.rules import limited_across_sides, limited_for_packing_across_sides
from bubblemesh.spacing.rules.sources import coarse_curves, short_pieces
from bubblemesh.spacing.survey import ideal_nodes, surveyed

NODES = Key(["spacing", "nodes"])
ESTIMATE = 0.05  # relative tolerance of an estimate that only limits and announces the number of nodes


def prepare(case: Case) -> Problem:
    """Check geometry and spacing of a case, and bind its method; errors have the place and what to do."""
    seconds: dict[str, float] = {}
    with timed(seconds, "geometry"):
        domain = case_domain(case)
    enter("spacing")
    return prepare_in(domain, case_spacing(case, domain), task_of(case), seconds)


def prepare_in(
    domain: Domain, request: SpacingRequest, task: Task, seconds: dict[str, float], key: Key = NODES
) -> Problem:
    """Make a problem of a domain and a spacing request; ``key`` is that of its number of nodes."""

    def check(limited: Task, scale: float | None = None) -> Problem:
        return check_spacing(domain, request, limited, seconds, scale)

    if request.nodes is None:
        return check(task)
    scales = Scales.of(domain, request.at)
    return fit_node_target(ScaleSearch(request.nodes, scales, check, task, seconds, key))


def check_spacing(
    domain: Domain, request: SpacingRequest, task: Task, seconds: dict[str, float], scale: float | None = None
) -> Problem:
    """Check the spacing, at some scale, in the domain, and make it finer where its rules and the boundary ask for it.

    A spacing that does not fit is a CaseError or a LimitError, with the place and what to do.
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


def task_of(case: Case) -> Task:
    """Task of a case: its method, limits and requirements."""
    method = case.configured_method
    parameters = case.model_dump(mode="json", exclude={"packing", "schedule"}, exclude_none=True) | options(method)
    return Task(
        name=str(case.name),
        method_name=case.method,
        method=method,
        max_nodes=case.limits.max_nodes,
        time_limit=case.limits.seconds,
        parameters=parameters,
        order=case.output.order,
        requirements=case.require.model_dump(exclude_none=True),
    )
