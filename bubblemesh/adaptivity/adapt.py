"""From a case and a solution on its mesh to the next mesh: sizes by the estimated error, the present nodes as start."""

from contextlib import nullcontext
from dataclasses import replace
from typing import Any

import numpy as np

from bubblemesh.adaptivity.estimate import Estimate, estimated, true_error
from bubblemesh.adaptivity.in_metric import next_in_metric
from bubblemesh.adaptivity.next_mesh import NextMesh, held, parts
from bubblemesh.adaptivity.sizes import (
    equivalent_sizes,
    predicted_error,
    sizes_for_error,
    sizes_for_nodes,
    smooth_sizes,
)
from bubblemesh.adaptivity.solution import Solution, require_coverage
from bubblemesh.adaptivity.target import REACHED, Target, missed_error
from bubblemesh.arrays import TINY, complement
from bubblemesh.case import Case
from bubblemesh.errors import CaseError, at_key, coarsened_by, prefixed
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.edges import rim_nodes
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.packing.placement.warm_start import PreviousNodes
from bubblemesh.problem.domain import case_domain
from bubblemesh.problem.prepare import prepare_for
from bubblemesh.problem.problem import Problem
from bubblemesh.problem.scale import bounded
from bubblemesh.problem.task import task_of
from bubblemesh.process.stopwatch import Stopwatch
from bubblemesh.run.packing import OnRound, OnShare, RunOptions
from bubblemesh.run.pipeline import Result, mesh_problem
from bubblemesh.spacing.expression import Expression
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.terms.field import MeshField

DEFAULT_GROWTH = 0.3  # of the sizes per length, if the case does not say
FEWEST_KEPT = 0.2  # part of the present nodes below which the method's own start is the better one
SAME = 0.1  # relative change of sizes that is not made: estimates of single triangles are no more exact
AIM = 0.99  # of a wanted error: meshes have up to about that much more than is expected of their sizes


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
        estimate = estimated(solution.points, solution.triangles, values, parts(domain, solution))
        with prefixed(target.called("exact")):
            figures = _figures(solution, estimate, exact)
    if target.anisotropic:
        following = next_in_metric(case, domain, solution, estimate, target, stopwatch)
        expected = estimate.error * float(np.sqrt(len(solution.points) / following.problem.expected_nodes))
    else:
        following = _next_in_circles(case, domain, solution, estimate, target, stopwatch)
        expected = _expected(solution, estimate, following.problem.spacing)
    problem = following.problem
    if target.error is not None and expected > REACHED * target.error * estimate.solution:
        share = _share_at_minimum(solution, problem, case.spacing_terms.minimum)
        errors = target.error, expected / estimate.solution, following.step / estimate.solution
        told = missed_error(*errors, share, anisotropic=bool(target.anisotropic))
        problem = replace(problem, warnings=(*problem.warnings, told))
    adaptation = figures | {
        "wanted": target.figures,
        "expected_error": solution.unit * expected,
        "expected_relative_error": expected / max(estimate.solution, TINY),
        **following.start,
    }
    return mesh_problem(problem, RunOptions(on_round, on_share), adaptation)


def _next_in_circles(
    case: Case, domain: Domain, solution: Solution, estimate: Estimate, target: Target, stopwatch: Stopwatch
) -> NextMesh:
    """The next mesh, whose sizes are the same in all directions."""
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
    request = held(case, domain, at, solution)
    rules = replace(request.rules, growth=terms.growth or DEFAULT_GROWTH)
    request = replace(request, rules=rules, nodes=nodes, nodes_key=target.nodes_key(terms))
    request = replace(request, nearest=target.instead_of(len(solution.points), terms))
    task = replace(task_of(case, domain), adapted=True)
    inner = complement(len(solution.points), rim_nodes(solution.triangles))
    present = PreviousNodes(solution.points[inner], now[inner])
    share = present.share_of_own_size(domain, at(None))
    if share >= FEWEST_KEPT:
        task = replace(task, previous=present)
    start = {"unchanged": share, "start": "present nodes" if share >= FEWEST_KEPT else "method"}
    return NextMesh(prepare_for(case, domain, request, task, stopwatch), start, step)


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
