"""What a run reports: figures of the start, of each round and of the mesh."""

from dataclasses import dataclass
from typing import Any

from bubblemesh.arrays import Floats, Integers
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.quality import radius_ratios
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.rounds import Round
from bubblemesh.problem.problem import Problem
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.survey import Extremes


@dataclass(frozen=True)
class RoundRow:
    """Figures of a round; ``mean_speed`` is that of the last step, ``seconds`` the time the round took."""

    round: int
    iterations: int
    nodes_before: int
    nodes_after: int
    deleted: int
    inserted: int
    mean_speed: float
    quality_mean: float
    quality_min: float
    force_evaluations: int
    seconds: float


def round_row(done: Round, seconds: float) -> RoundRow:
    """The figures of a finished round."""
    q = radius_ratios(done.bubbles.x, done.triangles)
    return RoundRow(
        round=done.number,
        iterations=done.iterations,
        nodes_before=done.before,
        nodes_after=len(done.bubbles),
        deleted=done.deleted,
        inserted=done.inserted,
        mean_speed=float(done.speeds[-1]) if done.iterations else 0.0,
        quality_mean=float(q.mean()),
        quality_min=float(q.min()),
        force_evaluations=done.evaluations,
        seconds=seconds,
    )


def initial_row(start: Bubbles, triangles: Integers) -> dict[str, Any]:
    """The figures of the initial placement."""
    q = radius_ratios(start.x, triangles)
    return {
        "nodes": len(start),
        "boundary_nodes": start.boundary_count,
        "triangles": len(triangles),
        "quality_mean": float(q.mean()),
        "quality_min": float(q.min()),
    }


def triangle_fields(mesh: Mesh, wanted: Spacing) -> dict[str, Floats]:
    """Data (t,) of the triangles: quality, and the wanted spacing at their centroids."""
    return {
        "quality": radius_ratios(mesh.points, mesh.triangles),
        "target_spacing": wanted.between(mesh.points[mesh.triangles]),
    }


def rules_figures(problem: Problem) -> dict[str, Any]:
    """How much the rules of the wanted spacing and its periodic sides changed it, if they did."""
    return {
        key: {"share": changed.share, "ratio": changed.ratio, "ratio_at": changed.ratio_at}
        for key, changed in problem.changes.items()
    }


def budget_figures(problem: Problem) -> dict[str, Any]:
    """The scale of the spacing that was found for a wanted number of nodes, if there is one."""
    budget = problem.budget
    return {} if budget is None else {"budget": {"nodes": budget.nodes, "scale": budget.scale}}


def estimate(problem: Problem) -> dict[str, Any]:
    """What a case asks for, before any packing."""
    domain, survey = problem.domain, problem.survey
    return {
        "case": problem.task.name,
        "method": problem.task.method_name,
        "parameters": problem.task.parameters,
        "bounds": domain.bounds,
        "area": domain.polygon.area,
        "holes": domain.hole_count,
        "labels": domain.boundary.labels,
        "spacing": {name: getattr(survey, name) for name in Extremes._fields},
        **({"packed_spacing": problem.packed._asdict()} if problem.refined else {}),
        **rules_figures(problem),
        **budget_figures(problem),
        "ideal_nodes": survey.ideal_nodes,
        "expected_nodes": problem.expected_nodes,
        "warnings": problem.warnings,
    }
