"""From a case to a problem: the domain, the spacing request and the method, bound and checked."""

from bubblemesh.case import Case
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.configure import options
from bubblemesh.problem.check import check_spacing
from bubblemesh.problem.domain import case_domain
from bubblemesh.problem.node_target import fit_node_target
from bubblemesh.problem.problem import Problem, Task
from bubblemesh.problem.spacing import SpacingRequest, case_spacing
from bubblemesh.resources import timed


def prepare(case: Case) -> Problem:
    """Check geometry and spacing of a case, and bind its method.

    Raises
    ------
    GeometryError, CaseError, LimitError
        With the place and what to do.
    """
    seconds: dict[str, float] = {}
    with timed(seconds, "geometry"):
        domain = case_domain(case)
    return prepare_in(domain, case_spacing(case, domain), task_of(case), seconds)


def prepare_in(
    domain: Domain, request: SpacingRequest, task: Task, seconds: dict[str, float], asked: str = "spacing.nodes"
) -> Problem:
    """Make a problem of a domain and a spacing request; ``asked`` is what messages call its number of nodes."""
    if request.nodes is None:
        return check_spacing(domain, request, task, seconds)
    return fit_node_target(domain, request, request.nodes, task, seconds, asked)


def task_of(case: Case) -> Task:
    """Task of a case: its method, limits and requirements."""
    method = case.configured_method
    parameters = case.model_dump(mode="json", exclude={"packing", "schedule"}, exclude_none=True) | options(method)
    limits, requirements = case.limits, case.require.model_dump(exclude_none=True)
    return Task(
        name=str(case.name),
        method_name=case.method,
        method=method,
        max_nodes=limits.max_nodes,
        time_limit=limits.seconds,
        parameters=parameters,
        order=case.output.order,
        requirements=requirements,
    )
