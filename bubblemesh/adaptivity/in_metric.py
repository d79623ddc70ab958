"""The next mesh of an adaptation in a metric: sizes that depend on the direction."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from bubblemesh.adaptivity.estimate import Estimate
from bubblemesh.adaptivity.metric import best_metric, graded_across_sides, scaled_for
from bubblemesh.adaptivity.next_mesh import NextMesh, held, parts
from bubblemesh.adaptivity.solution import Solution
from bubblemesh.adaptivity.target import MOST_TIMES, Target
from bubblemesh.arrays import Floats, Integers
from bubblemesh.case import Case
from bubblemesh.case.models import IN_METRIC, MULTILEVEL
from bubblemesh.case.spacing import SpacingTerms
from bubblemesh.errors import CaseError, at_key
from bubblemesh.geometry.domain import Domain
from bubblemesh.problem.metric import MetricRequest
from bubblemesh.problem.node_target import out_of_reach
from bubblemesh.problem.prepare import near_target, prepare_for
from bubblemesh.problem.problem import Problem
from bubblemesh.problem.spacing import SpacingRequest
from bubblemesh.problem.task import task_of
from bubblemesh.process.stopwatch import Stopwatch
from bubblemesh.records import record
from bubblemesh.spacing.metric.field import TensorField
from bubblemesh.spacing.spacing import Spacing

GROWTH_IN_METRIC = 0.6  # of the sizes over a length of 1 in a metric, if the case does not say: layers differ more
ATTEMPTS, CLOSE = 4, 0.02  # at a metric that needs so many nodes as are wanted, to that part of them
MISSED = 0.25  # the same that is no such metric
MOST_ASPECT = 1000.0
FEWEST_NODES = 4.0  # nodes, of a solution without any error
FINEST, COARSEST = 1e-6, 0.2  # sizes, of the domain's size, if the case does not say


def next_in_metric(
    case: Case, domain: Domain, solution: Solution, estimate: Estimate, target: Target, stopwatch: Stopwatch
) -> NextMesh:
    """The next mesh, whose metric follows from the solution's second derivatives.

    If a number of nodes that is asked for cannot be had it is an error of the user's.
    """
    if case.method not in (MULTILEVEL, IN_METRIC):
        raise CaseError(f"method: {case.method} packs no metric: leave method out with {target.called('anisotropic')}")
    nodes = _wanted_nodes(case.spacing_terms, solution, estimate, target)
    metrics = _Metrics.of(case.spacing_terms, domain, solution)
    case = case.model_copy(update={"method": IN_METRIC})
    request = _request(case, domain, solution, target, metrics.sizes[1])
    task = replace(task_of(case, domain), adapted=True)

    def prepared(request: SpacingRequest) -> Problem:
        return prepare_for(case, domain, request, task, stopwatch)

    problem, found = metrics.fitted(request, domain, nodes, prepared)
    if problem.expected_nodes > (1 + MISSED) * nodes and request.rules.across is None:
        # What narrow parts take by themselves must not put the number out of reach.
        unfilled = replace(request, rules=replace(request.rules, across=0.0))
        other = metrics.fitted(unfilled, domain, nodes, prepared)
        problem, found = min((problem, found), other, key=lambda pair: pair[0].expected_nodes)
        problem = replace(problem, seconds=stopwatch.seconds)  # of both
    start = {"unchanged": 0.0, "start": "method", "anisotropic": True}
    step = estimate.error * float(np.sqrt(len(solution.points) / nodes))
    return NextMesh(_aimed(problem, found, nodes, target), start, step)


def _wanted_nodes(terms: SpacingTerms, solution: Solution, estimate: Estimate, target: Target) -> float:
    """Number of nodes that the next mesh is to have; the error of the gradient falls with its square root."""
    before = len(solution.points)
    if target.error is None:
        return float(target.nodes or terms.nodes or before)
    return max(before * min((estimate.relative / target.error) ** 2, MOST_TIMES), FEWEST_NODES)


def _request(case: Case, domain: Domain, solution: Solution, target: Target, largest: float) -> SpacingRequest:
    """The request of a case with sizes up to the ``largest``, to which the metric is still to be added."""
    terms, coarse = case.spacing_terms, Spacing(partial(_everywhere, largest))
    request = held(case, domain, lambda scale: coarse, solution)
    courant = "spacing.courant: does not hold for ellipses: give spacing.minimum"
    return replace(
        request,
        nodes=None,
        nodes_key=target.nodes_key(terms),
        nearest=target.instead_of(len(solution.points), terms),
        rules=replace(request.rules, growth=None),
        warnings=(*request.warnings, *([] if terms.courant is None else [courant])),
    )


@record(eq=False)
class _Metrics:
    """Metrics of a solution for all numbers of nodes."""

    mesh: tuple[Floats, Integers]  # of the solution: points (n, 2), triangles (t, 3)
    best: Floats  # (n, 3), what `best_metric` gives
    sizes: tuple[float, float]  # the least and the largest
    growth: float  # over a length of 1

    @classmethod
    def of(cls, terms: SpacingTerms, domain: Domain, solution: Solution) -> "_Metrics":
        """Metrics of a solution within the limits of a case's terms."""
        mesh = solution.points, solution.triangles
        coarsest = terms.maximum or max(COARSEST * domain.size, terms.minimum or 0.0)
        sizes = terms.minimum or min(FINEST * domain.size, coarsest), coarsest
        best = best_metric(*mesh, solution.values / solution.unit, parts(domain, solution))
        return cls(mesh, best, sizes, terms.growth or GROWTH_IN_METRIC)

    def fitted(
        self, request: SpacingRequest, domain: Domain, nodes: float, prepared: Callable[[SpacingRequest], Problem]
    ) -> tuple[Problem, SpacingRequest]:
        """The problem in which about so many nodes are expected, and the request with the metric that leads to it."""
        aim = nodes
        for _ in range(ATTEMPTS):
            tensors = scaled_for(*self.mesh, self.best, aim, self.sizes, MOST_ASPECT)
            tensors = graded_across_sides(domain, *self.mesh, tensors, self.growth)
            metric = MetricRequest(TensorField.of(*self.mesh, tensors), MOST_ASPECT, request.nodes_key)
            request = replace(request, metrics=(metric,))
            problem = prepared(request)
            if abs(problem.expected_nodes / nodes - 1) < CLOSE:
                break
            aim *= nodes / problem.expected_nodes
        return problem, request


def _aimed(problem: Problem, request: SpacingRequest, nodes: float, target: Target) -> Problem:
    """A problem in a metric, with the number of nodes as its target if that is what is asked for.

    A number that cannot be had is an error, but for the default, in place of which the nearest one will do.
    """
    expected = problem.expected_nodes
    missed = abs(expected / nodes - 1) > MISSED
    if target.error is not None and (expected > nodes or not missed):  # the coarsest mesh has less of an error
        return problem
    if missed and request.nearest is None:
        with at_key(*request.nodes_key):
            raise out_of_reach(nodes, expected)
    # What is made is counted too.
    return near_target(problem, request, round(expected if missed else nodes), instead=missed)


def _everywhere(size: float, x: Floats, y: Floats) -> Floats:
    """A constant size at all places."""
    return np.full(np.shape(x), size)
