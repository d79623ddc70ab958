"""From a case to a problem: the domain, the spacing request and the method, bound and checked."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from bubblemesh.arrays import Floats
from bubblemesh.case import Case
from bubblemesh.case.models import IN_METRIC
from bubblemesh.errors import CaseError, LimitError
from bubblemesh.geometry.domain import Domain
from bubblemesh.problem import warnings
from bubblemesh.problem.checked import CheckedProblem
from bubblemesh.problem.compatibility import require_possible, require_triangles_for_parts
from bubblemesh.problem.crs import given_bounds, require_one_unit, sizes_in_metres
from bubblemesh.problem.domain import case_domain
from bubblemesh.problem.files import unit_of_files
from bubblemesh.problem.fitting import Fitted, RequestedSpacing, fitted_to_boundary, requested_spacing
from bubblemesh.problem.node_target import CLOSE, CountTrial, Scales, ScaleSearch, fit_node_target
from bubblemesh.problem.problem import Problem, Task
from bubblemesh.problem.slivers import open_gaps
from bubblemesh.problem.spacing import SpacingRequest, case_spacing
from bubblemesh.problem.task import task_of
from bubblemesh.process.stopwatch import Stopwatch
from bubblemesh.spacing.rules.grading import LimitedSpacing
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.survey import ESTIMATE, Survey, ideal_nodes

if TYPE_CHECKING:
    from bubblemesh.layers.rest import Rest
    from bubblemesh.problem.metric import MetricRequest
    from bubblemesh.problem.metric_spacing import InMetric


class _Packable(NamedTuple):
    """What a packing takes of a domain and its spacing, as far as it is found."""

    spacing: Spacing  # that is asked for
    survey: Survey  # of it
    packing: Spacing  # that the packing goes by
    nodes: float  # the ideal number of the packing
    rest: "Rest | None" = None  # of the domain beside boundary layers, if there are any

    @classmethod
    def of(cls, requested: RequestedSpacing, fitted: Fitted) -> "_Packable":
        """What is found for circles in all of the domain."""
        filled = fitted.filled
        return cls(requested.spacing, requested.survey, filled.spacing.spacing, filled.expected_nodes)


def prepare(case: Case) -> Problem:
    """Check geometry and spacing of a case, and bind its method; errors have the place and what to do."""
    stopwatch = Stopwatch()
    with stopwatch.stage("geometry"):
        domain = case_domain(case)
    with stopwatch.stage("spacing"):
        request = case_spacing(case, domain)
    with sizes_in_metres(case, given_bounds(domain)):
        return prepare_for(case, domain, request, task_of(case, domain), stopwatch)


def prepare_for(case: Case, domain: Domain, request: SpacingRequest, task: Task, stopwatch: Stopwatch) -> Problem:
    """Make a problem of a case's domain and a spacing request, and check all that both have to fit; as `prepare_in`."""
    if request.nodes is None:  # else the spacing is not known yet
        gap_notes = open_gaps(case, domain, _before_rules(request, None))
        request = replace(request, warnings=(*request.warnings, *gap_notes))
    problem = prepare_in(domain, request, replace(task, depth=request.depth), stopwatch)
    if case.crs is None:
        require_one_unit(case.domain, domain, problem.survey.extremes.minimum)
    if request.nodes is None:
        too_large = warnings.larger_than_the_domain(problem.extremes_before, domain.size, unit_of_files(case.domain))
        problem = replace(problem, warnings=(*too_large, *problem.warnings))
    require_triangles_for_parts(problem)
    return problem


def prepare_in(domain: Domain, request: SpacingRequest, task: Task, stopwatch: Stopwatch) -> Problem:
    """Make a problem of a domain and a spacing request."""
    nodes = request.nodes
    if nodes is None:
        return check_spacing(domain, request, task, stopwatch).told(stopwatch)
    known: tuple[CountTrial, ...] = ()
    if request.rules.across is None:
        with suppress(CaseError, LimitError), stopwatch.stage("spacing"):
            problem = fit_node_target(_search(domain, request, nodes, task, stopwatch.seconds))
            if abs(problem.expected_nodes - nodes) <= CLOSE * nodes:
                return problem
            known = () if problem.node_target is None else problem.node_target.trials
        # What narrow parts take by themselves must not put the number out of reach.
        request = replace(request, rules=replace(request.rules, across=0.0))
    return fit_node_target(_search(domain, request, nodes, task, stopwatch.seconds), known)


def near_target(problem: Problem, request: SpacingRequest, nodes: int, *, instead: bool) -> Problem:
    """A problem of a spacing request in which about so many nodes are expected, with their number as its target.

    If that is the nearest one, ``instead`` of what was asked for, there is a warning.
    """
    search = _search(problem.domain, request, nodes, problem.task, problem.seconds)
    return (search.instead(nodes) if instead else search).of(problem, 1.0)


def _search(
    domain: Domain, request: SpacingRequest, nodes: int, task: Task, seconds: Mapping[str, float]
) -> ScaleSearch:
    check = partial(check_spacing, domain, request)
    scales = Scales.of(domain, partial(_before_rules, request))
    return ScaleSearch(nodes, scales, check, task, seconds, request.nodes_key, request.nearest)


def _before_rules(request: SpacingRequest, scale: float | None) -> Spacing:
    """The spacing that is asked for at a scale, or at its own, below the metrics if there are any."""
    spacing = request.at(scale)
    if not request.metrics:
        return spacing
    # Imported here since few cases have a metric.
    from bubblemesh.problem.metric_spacing import metric_below

    return metric_below(_scaled(request.metrics, scale), spacing)


def _scaled(metrics: "Sequence[MetricRequest]", scale: float | None) -> "Sequence[MetricRequest]":
    """Metrics at a scale, or at their own if there is none."""
    return metrics if scale is None else [metric.scaled(scale) for metric in metrics]


def check_spacing(
    domain: Domain, request: SpacingRequest, task: Task, stopwatch: Stopwatch, scale: float | None = None
) -> CheckedProblem:
    """Check the spacing, at some scale, in the domain, and make it finer where its rules and the boundary ask for it.

    What comes out has no warnings yet. A spacing that does not fit is a CaseError or a LimitError, with the place and
    what to do.
    """
    require_possible(domain, request, task)
    # 1. The spacing that is asked for, and the one that the packing goes by: finer where the boundary needs it.
    with stopwatch.stage("spacing"):
        requested = requested_spacing(domain, request, scale, task.max_nodes, _hidden(domain, task))
        metric = _metric(domain, requested, request, task, scale)
        spacing = requested.spacing if metric is None else metric.requested
        fitted = fitted_to_boundary(domain, requested, spacing, request.rules, task.max_nodes)
    found = _Packable.of(requested, fitted)
    # 2. In a metric both depend on the direction.
    if metric is not None:
        with stopwatch.stage("metric"):
            found = _in_metric(found, domain, metric, task.max_nodes)
    # 3. Boundary layers leave the rest of the domain to the packing.
    if task.ladders:
        # Imported here since few meshes have layers.
        from bubblemesh.layers.pipeline import HighLayerError
        from bubblemesh.problem.layers import left_out

        try:
            with stopwatch.stage("layers"):
                found = _beside_layers(found, domain, requested, fitted.filled.spacing, metric, task)
        except HighLayerError as error:
            if not task.adapted:
                raise
            ladders, lacking = left_out(error, domain, task.ladders)
            request = replace(request, warnings=(*request.warnings, lacking))
            fewer = check_spacing(domain, request, replace(task, ladders=ladders), stopwatch, scale)
            # With a larger scale, for a number of nodes, they may all have room.
            return replace(fewer, problem=replace(fewer.problem, task=task))
    problem = Problem(
        task=task,
        domain=domain,
        spacing=found.spacing,
        packing_spacing=found.packing,
        survey=found.survey,
        expected_nodes=found.nodes + (0 if found.rest is None else found.rest.own_nodes),
        before_rules=requested.before_rules,
        extremes_before=requested.extremes_before if metric is None else found.survey.extremes,
        rules=request.rules,
        after_rules=requested.after_rules,
        after_periodic=requested.after_periodic,
        warnings=(),
        seconds=stopwatch.seconds,
        rest=found.rest,
    )
    return CheckedProblem(problem, request, scale, requested, fitted, metric)


def _hidden(domain: Domain, task: Task) -> Floats | None:
    """Length (p,) up to which edges of each piece of the boundary are hidden below layers, if there are any."""
    if not task.ladders:
        return None
    # Imported here since few cases have layers.
    from bubblemesh.problem.layers import hidden_below

    return hidden_below(domain, task.ladders)


def _metric(
    domain: Domain, requested: RequestedSpacing, request: SpacingRequest, task: Task, scale: float | None
) -> "InMetric | None":
    """The metrics of a request at some scale in a domain, if there are any or the method is for them."""
    if not request.metrics and task.method_name != IN_METRIC:
        return None
    # Imported here since few cases have a metric.
    from bubblemesh.problem.metric_spacing import spacing_in_metrics

    return spacing_in_metrics(
        domain, _scaled(request.metrics, scale), requested.spacing, task.max_nodes, requested.survey.cover
    )


def _in_metric(found: _Packable, domain: Domain, metric: "InMetric", max_nodes: int) -> _Packable:
    """What is found, in a metric."""
    packing = metric.packing(domain, found.packing, max_nodes)
    nodes = ideal_nodes(domain, packing, max_nodes, ESTIMATE, found.survey.cover)
    return _Packable(metric.requested, metric.survey, packing, nodes)


def _beside_layers(
    found: _Packable,
    domain: Domain,
    requested: RequestedSpacing,
    fitted: LimitedSpacing,
    metric: "InMetric | None",
    task: Task,
) -> _Packable:
    """What is found, beside boundary layers; without them the spacing is ``fitted`` to the boundary."""
    # Imported here since few meshes have layers.
    from bubblemesh.problem.layers import with_layers

    rest, packing, short = with_layers(
        domain, task, found.spacing, found.packing, requested.after_periodic, fitted.ground
    )
    if metric is not None:
        packing = metric.packing(rest.domain, fitted.spacing, task.max_nodes, (packing, short))
    return found._replace(
        packing=packing,
        nodes=ideal_nodes(rest.domain, packing, task.max_nodes, ESTIMATE),
        rest=rest,
    )
