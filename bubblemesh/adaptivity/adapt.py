"""From a case and a solution on its mesh to the next mesh: sizes by the estimated error, the present nodes as start."""

from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import shapely

from bubblemesh.adaptivity.estimate import Estimate, estimated, true_error
from bubblemesh.adaptivity.metric import best_metric, graded_across_sides, scaled_for
from bubblemesh.adaptivity.sizes import (
    FINER,
    equivalent_sizes,
    predicted_error,
    sizes_for_error,
    sizes_for_nodes,
    smooth_sizes,
)
from bubblemesh.adaptivity.solution import Solution, require_coverage
from bubblemesh.arrays import Floats, Integers, complement, is_real, is_whole
from bubblemesh.case import Case
from bubblemesh.case.models import IN_METRIC, MULTILEVEL
from bubblemesh.case.spacing import SpacingTerms
from bubblemesh.errors import CaseError, Key, at_key, coarsened_by, prefixed
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.edges import rim_nodes
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.packing.placement.warm_start import PreviousNodes
from bubblemesh.problem.domain import case_domain
from bubblemesh.problem.metric import MetricRequest
from bubblemesh.problem.node_target import out_of_reach
from bubblemesh.problem.prepare import near_target, prepare_for
from bubblemesh.problem.problem import Problem
from bubblemesh.problem.scale import SpacingAtScale, bounded
from bubblemesh.problem.spacing import NODES, SpacingRequest, held_request
from bubblemesh.problem.task import task_of
from bubblemesh.process.stopwatch import Stopwatch
from bubblemesh.records import record
from bubblemesh.run.packing import OnRound, OnShare, RunOptions
from bubblemesh.run.pipeline import Result, mesh_problem
from bubblemesh.spacing.expression import Expression
from bubblemesh.spacing.metric.field import TensorField
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.terms.field import MeshField

DEFAULT_GROWTH = 0.3  # of the sizes per length, if the case does not say
GROWTH_IN_METRIC = 0.6  # the same over a length of 1 in a metric: layers ask for sizes that differ more
FEWEST_KEPT = 0.2  # part of the present nodes below which the method's own start is the better one
ATTEMPTS, CLOSE = 4, 0.02  # at a metric that needs so many nodes as are wanted, to that part of them
MISSED = 0.25  # the same that is no such metric
MOST_ASPECT = 1000.0
MOST_TIMES = 16.0  # the nodes of the mesh before
FEWEST_NODES = 4.0  # nodes, of a solution without any error
FINEST, COARSEST = 1e-6, 0.2  # sizes, of the domain's size, if the case does not say
SAME = 0.1  # relative change of sizes that is not made: estimates of single triangles are no more exact
AIM = 0.99  # of a wanted error: meshes have up to about that much more than is expected of their sizes
REACHED = 1.02  # times a wanted error: if more is expected it is told
TINY = float(np.finfo(float).tiny)


@record
class Target:
    """Goal of an adaptation: a relative error, or a number of nodes; without both, as many nodes as there are."""

    error: float | None = None
    nodes: int | None = None
    anisotropic: bool = False  # whether sizes depend on the direction
    mark: str = ""  # before the names of arguments in messages: those of the command line have -- there

    def __post_init__(self) -> None:
        error, nodes = self.called("error"), self.called("nodes")
        if self.error is not None and self.nodes is not None:
            raise CaseError(f"{error} and {nodes} exclude each other: give one of them")
        if self.error is not None and not (is_real(self.error) and 0 < self.error < 1):
            raise CaseError(f"{error}: must be a share of the gradient's norm, between 0 and 1 (found {self.error!r})")
        if self.nodes is not None and not is_whole(self.nodes, 3):
            raise CaseError(f"{nodes}: must be a whole number of at least 3 (found {self.nodes!r})")
        if not isinstance(self.anisotropic, bool | np.bool_):
            raise CaseError(f"{self.called('anisotropic')}: must be true or false (found {self.anisotropic!r})")

    def called(self, argument: str) -> str:
        """Name of an argument in messages."""
        return f"{self.mark}{argument}"

    def instead_of(self, before: int, terms: SpacingTerms) -> Callable[[int], str] | None:
        """Warning of a number of nodes in place of those before; None if it or the case's terms say how far to go."""
        said = self.error is not None or self.nodes is not None or terms.nodes is not None
        return None if said else partial(_other_number, before, self.called("nodes"))

    @property
    def figures(self) -> dict[str, float | None]:
        """The goal as reports hold it."""
        return {"error": self.error, "nodes": self.nodes, "anisotropic": bool(self.anisotropic)}


def adapted(
    case: Case,
    solution: Solution,
    target: Target,
    exact: str | None = None,
    on_round: OnRound = lambda row: None,
    on_share: OnShare = lambda share: None,
) -> Result:
    """Mesh a case's domain anew, as its solution asks for, which is on a mesh of this domain.

    The sizes follow from the estimated error; of the case's spacing the limits and rules hold, as `held_request` says.
    The exact solution, an expression in x and y, is to compare the estimate with. A mistake of the user's is a
    BubblemeshError. The limits of the case on time and memory are those of the caller.
    """
    with nullcontext() if target.error is None else coarsened_by(f"ask for a larger {target.called('error')}"):
        return _adapted(case, solution, target, exact, on_round, on_share)


def _adapted(
    case: Case, solution: Solution, target: Target, exact: str | None, on_round: OnRound, on_share: OnShare
) -> Result:
    """Estimate the error, make the problem whose sizes follow from it, and mesh that; the report has the figures."""
    if case.metric is not None:
        with at_key("metric"):
            raise CaseError(f"remove `metric` from the case: {target.called('anisotropic')} computes its own")
    stopwatch = Stopwatch()
    with stopwatch.stage("geometry"):
        domain = case_domain(case)
        if domain.plane is not None and domain.plane.target is not None:
            raise CaseError(
                "crs.to: the solution has to be on a mesh in the plane: run the case with crs.to: auto, solve on that "
                "mesh, and adapt with crs.to: auto"
            )
    with stopwatch.stage("estimate"):
        require_coverage(domain, solution.points, solution.triangles)
        values = solution.values / solution.unit
        estimate = estimated(solution.points, solution.triangles, values, _parts(domain, solution))
        with prefixed(target.called("exact")):
            figures = _figures(solution, estimate, exact)
    if target.anisotropic:
        problem, start, step = _next_in_metric(case, domain, solution, estimate, target, stopwatch)
        expected = estimate.error * float(np.sqrt(len(solution.points) / problem.expected_nodes))
    else:
        problem, start, step = _next_problem(case, domain, solution, estimate, target, stopwatch)
        expected = _expected(solution, estimate, problem.spacing)
    if target.error is not None and expected > REACHED * target.error * estimate.solution:
        share = _share_at_minimum(solution, problem, case.spacing_terms.minimum)
        errors = target.error, expected / estimate.solution, step / estimate.solution
        told = _missed_error(*errors, share, anisotropic=bool(target.anisotropic))
        problem = replace(problem, warnings=(*problem.warnings, told))
    adaptation = figures | {
        "wanted": target.figures,
        "expected_error": solution.unit * expected,
        "expected_relative_error": expected / max(estimate.solution, TINY),
        **start,
    }
    return mesh_problem(problem, RunOptions(on_round, on_share), adaptation)


def _next_problem(
    case: Case, domain: Domain, solution: Solution, estimate: Estimate, target: Target, stopwatch: Stopwatch
) -> tuple[Problem, dict[str, Any], float]:
    """The next mesh as a problem, how it starts, and the error that one step without the case's limits leads to."""
    mesh, terms = (solution.points, solution.triangles), case.spacing_terms
    sizes = equivalent_sizes(*mesh)
    if target.error is not None:
        nodes = None
        target_sizes = sizes_for_error(estimate, sizes, target.error * estimate.solution)
    else:
        nodes = target.nodes or terms.nodes or len(solution.points)
        target_sizes = sizes_for_nodes(estimate, sizes, nodes)
    field, now = MeshField.of_triangles(*mesh, target_sizes), smooth_sizes(*mesh)
    same = np.abs(np.log(field.values / now)) < np.log(1 + SAME)
    field = replace(field, values=np.where(same, now, field.values))
    if target.error is not None:
        # What stays must not keep the error above the wanted one.
        scale = AIM * target.error * estimate.solution / max(_expected(solution, estimate, Spacing(field)), TINY)
        field = replace(field, values=float(np.clip(scale, 1 / (1 + SAME), 1)) * field.values)
    step = _expected(solution, estimate, Spacing(field))
    at = bounded(terms, (Spacing(field),), field.spots)
    request = _held(case, domain, at, solution)
    rules = replace(request.rules, growth=terms.growth or DEFAULT_GROWTH)
    request = replace(request, rules=rules, nodes=nodes, nodes_key=_key(target, terms))
    request = replace(request, nearest=target.instead_of(len(solution.points), terms))
    task = replace(task_of(case, domain), adapted=True)
    inner = complement(len(solution.points), rim_nodes(solution.triangles))
    present = PreviousNodes(solution.points[inner], now[inner])
    share = present.share_of_own_size(domain, at(None))
    if share >= FEWEST_KEPT:
        task = replace(task, previous=present)
    start = {"unchanged": share, "start": "present nodes" if share >= FEWEST_KEPT else "method"}
    return prepare_for(case, domain, request, task, stopwatch), start, step


def _expected(solution: Solution, estimate: Estimate, spacing: Spacing) -> float:
    """Estimated error on a mesh with a spacing."""
    mesh = solution.points, solution.triangles
    return predicted_error(estimate, equivalent_sizes(*mesh), spacing.between(*mesh))


def _share_at_minimum(solution: Solution, problem: Problem, minimum: float | None) -> float:
    """Share of the next mesh's nodes where its spacing is the smallest one that the case allows."""
    if minimum is None:
        return 0.0
    d = problem.spacing.between(solution.points, solution.triangles)
    nodes = np.abs(signed_areas(solution.points, solution.triangles)) / d**2
    return float(nodes[d < (1 + SAME) * minimum].sum() / nodes.sum())


def _missed_error(wanted: float, expected: float, step: float, share: float, *, anisotropic: bool) -> str:
    """Warning of a relative error that is above the wanted one on the next mesh, with what is in the way.

    That is one step, with the error ``step`` if nothing else holds, or the case's limits: ``spacing.minimum``, which
    holds at a ``share`` of the nodes, or others.
    """
    far, limited = step > REACHED * wanted, expected > REACHED * step
    most = f"{MOST_TIMES:g} times as many nodes" if anisotropic else f"sizes of 1/{1 / FINER:g}"
    holding = f"spacing.minimum holds at {share:.1%} of the nodes" if share else "limits of the case hold"
    causes = {f"one step gives {most} at most": far, holding: limited or not far}
    cures = {"adapt again to the new solution": far, "lower it" if share else "lower them": limited or not far}
    in_the_way, cure = (
        word.join(text for text, holds in row.items() if holds) for word, row in ((", and ", causes), (", or ", cures))
    )
    return f"an error of {wanted:g} is asked for, and {expected:.3g} is expected: {in_the_way}: {cure}"


def _next_in_metric(
    case: Case, domain: Domain, solution: Solution, estimate: Estimate, target: Target, stopwatch: Stopwatch
) -> tuple[Problem, dict[str, Any], float]:
    """The next mesh as a problem whose metric follows from the solution's second derivatives.

    What else comes out is that of `_next_problem`.

    The error of the gradient falls with the square root of the number of nodes: so many lead to a wanted one. If a
    number that is asked for cannot be had it is an error of the user's.
    """
    if case.method not in (MULTILEVEL, IN_METRIC):
        raise CaseError(f"method: {case.method} packs no metric: leave method out with {target.called('anisotropic')}")
    terms, points = case.spacing_terms, solution.points
    mesh = points, solution.triangles
    nodes, notes = float(target.nodes or terms.nodes or len(points)), list[str]()
    if target.error is not None:
        nodes = max(len(points) * min((estimate.relative / target.error) ** 2, MOST_TIMES), FEWEST_NODES)
    if terms.courant is not None:
        notes.append("spacing.courant: does not hold for ellipses: give spacing.minimum")
    coarsest = terms.maximum or max(COARSEST * domain.size, terms.minimum or 0.0)
    sizes = terms.minimum or min(FINEST * domain.size, coarsest), coarsest
    best = best_metric(*mesh, solution.values / solution.unit, _parts(domain, solution))
    case = case.model_copy(update={"method": IN_METRIC})
    coarse = Spacing(partial(_everywhere, sizes[1]))
    task = replace(task_of(case, domain), adapted=True)
    held = _held(case, domain, lambda scale: coarse, solution)
    held = replace(held, nodes=None, rules=replace(held.rules, growth=None), warnings=(*held.warnings, *notes))
    held = replace(held, nodes_key=_key(target, terms), nearest=target.instead_of(len(points), terms))
    growth = terms.growth or GROWTH_IN_METRIC

    def scaled(held: SpacingRequest) -> tuple[Problem, SpacingRequest]:
        """The problem with about so many nodes, and its request."""
        aim = nodes
        for _ in range(ATTEMPTS):
            tensors = scaled_for(*mesh, best, aim, sizes, MOST_ASPECT)
            tensors = graded_across_sides(domain, *mesh, tensors, growth)
            metrics = (MetricRequest(TensorField.of(*mesh, tensors), MOST_ASPECT, held.nodes_key),)
            request = replace(held, metrics=metrics)
            problem = prepare_for(case, domain, request, task, stopwatch)
            if abs(problem.expected_nodes / nodes - 1) < CLOSE:
                break
            aim *= nodes / problem.expected_nodes
        return problem, request

    problem, request = scaled(held)
    if problem.expected_nodes > (1 + MISSED) * nodes and held.rules.across is None:
        # What narrow parts take by themselves must not put the number out of reach.
        other = scaled(replace(held, rules=replace(held.rules, across=0.0)))
        problem, request = min((problem, request), other, key=lambda found: found[0].expected_nodes)
        problem = replace(problem, seconds=stopwatch.seconds)  # of both
    start = {"unchanged": 0.0, "start": "method", "anisotropic": True}
    step = estimate.error * float(np.sqrt(len(points) / nodes))
    return _aimed(problem, request, nodes, target), start, step


def _held(case: Case, domain: Domain, at: SpacingAtScale, solution: Solution) -> SpacingRequest:
    """The request of `held_request`, with a warning of a solution that says nothing."""
    request = held_request(case, domain, at)
    if not solution.constant:
        return request
    note = (
        f"{solution.name} is the same at all nodes, so that nothing is known of its error: see whether it is the field "
        "that was meant, and whether the solver has found a solution"
    )
    return replace(request, warnings=(*request.warnings, note))


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


def _other_number(before: int, argument: str, found: int) -> str:
    """Warning of about as many nodes as are found, in place of those before; the ``argument`` asks for a number."""
    same = f"as many nodes as the mesh of the solution has, {before}, are"
    if found < before:
        return f"{same} more than the limits of the case allow: the new mesh gets about {found}"
    return (
        f"{same} too few: the boundary and the other keys of the spacing take about {found}, and leave next to none "
        f"for the solution: ask for more by {argument}"
    )


def _key(target: Target, terms: SpacingTerms) -> Key:
    """Argument that says how many nodes the mesh gets, or the key of the case that does so without any."""
    if target.error is None and target.nodes is None and terms.nodes is not None:
        return NODES
    return Key([target.called("nodes" if target.error is None else "error")])


def _everywhere(size: float, x: Floats, y: Floats) -> Floats:
    """A constant size at all places."""
    return np.full(np.shape(x), size)


def _parts(domain: Domain, solution: Solution) -> Integers | None:
    """Number of the region that each triangle (t,) lies in, if there are several."""
    polygons = sorted((region.polygon for region in domain.parts.regions), key=shapely.area, reverse=True)
    if not polygons:
        return None
    middles = shapely.points(solution.points[solution.triangles].mean(axis=1))
    region, triangle = shapely.STRtree(middles).query(polygons, predicate="contains")
    part = np.zeros(len(middles), np.int64)
    np.maximum.at(part, triangle, region + 1)  # of nested regions the innermost, which comes last
    return part


def _figures(solution: Solution, estimate: Estimate, exact: str | None) -> dict[str, Any]:
    """Figures of the solution's error for the report; the estimate is in terms of the solution's unit."""
    unit = solution.unit
    figures = {
        "field": solution.name,
        "components": solution.values.shape[1],
        "nodes_before": len(solution.points),
        "triangles_before": len(solution.triangles),
        "error": unit * estimate.error,
        "relative_error": estimate.relative,
    }
    if exact is None:
        return figures
    if solution.values.shape[1] > 1:
        raise CaseError(f"must be one expression, but {solution.name} has several components: leave it out")
    if not isinstance(exact, str):
        raise CaseError(f"must be an expression in x and y (found {exact!r})")
    known = Expression.parse(exact)
    values = solution.values[:, 0] / unit
    error = true_error(solution.points, solution.triangles, values, lambda x, y: known(x, y) / unit)
    return figures | {"true_error": unit * error, "effectivity": estimate.error / error if error > 0 else None}
