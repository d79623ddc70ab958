"""From a case to a mesh: the whole story on one screen."""

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np

from bubblemesh import __version__
from bubblemesh.arrays import Floats
from bubblemesh.case import Case
from bubblemesh.errors import CaseError
from bubblemesh.geometry.deviation import deviation
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.periodic import matching_edges
from bubblemesh.meshes.conformity import area_error, require_conforming
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.quality import mesh_figures
from bubblemesh.meshes.triangulation import regions, sorted_triangles
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.net import Net, connect
from bubblemesh.packing.rounds import Round, rounds
from bubblemesh.problem import warnings
from bubblemesh.problem.problem import Problem, prepared
from bubblemesh.resources import peak_memory_mb, timed
from bubblemesh.run.report import RoundRow, initial_row, round_row, rules_figures, triangle_fields
from bubblemesh.run.time_limit import Clock
from bubblemesh.spacing.grid.table import tabulated

MOST_MESHES = 8  # until one has the wanted number of nodes


@dataclass(frozen=True)
class Result:
    """A mesh, data (t,) for its triangles, the report, and the mean speeds (iterations,) in each round."""

    mesh: Mesh
    fields: dict[str, Floats]
    report: dict[str, Any]
    speeds: tuple[Floats, ...]


OnRound = Callable[[RoundRow], None]
OnShare = Callable[[float], None]


def mesh_case(case: Case, on_round: OnRound = lambda row: None, on_share: OnShare = lambda share: None) -> Result:
    """Mesh a case.

    ``on_round`` is told of each round as it ends, ``on_share`` again and again what share of the packing is done.

    Raises
    ------
    BubblemeshError
        One of its subclasses for a mistake of the user's, with the place and what to do.
    """
    if not isinstance(case, Case):
        raise CaseError(f"case: must be a Case (found {type(case).__name__}): load_case reads one from a file")
    return meshed(prepared(case), on_round, on_share)


def meshed(problem: Problem, on_round: OnRound = lambda row: None, on_share: OnShare = lambda share: None) -> Result:
    """Mesh a problem; else as `mesh_case`."""
    budget, done = problem.budget, dict[float, Result]()
    if budget is None:
        return _meshed(problem, on_round, on_share, sum(problem.seconds.values()))
    nodes, begun = budget.nodes, perf_counter() - sum(problem.seconds.values())
    counts = []
    while budget is not None and budget.scale not in done and len(done) < MOST_MESHES:
        done[budget.scale] = result = _meshed(problem, on_round, on_share, perf_counter() - begun)
        counts.append((problem.expected_nodes, len(result.mesh.points)))
        if not (warnings.missed_node_target(nodes, len(result.mesh.points)) and result.report["finished"]):
            break
        problem = budget.corrected(counts)
        budget = problem.budget
    return _closest(nodes, done, perf_counter() - begun)


def _closest(nodes: int, done: dict[float, Result], seconds: float) -> Result:
    """The mesh, of those by scale, nearest to the wanted number of nodes; its report tells of all that were made."""

    def rank(scale: float) -> tuple[bool, int]:
        return not done[scale].report["finished"], abs(len(done[scale].mesh.points) - nodes)

    scale = min(done, key=rank)
    best = done[scale]
    own = best.report["seconds"]
    report = {
        **best.report,
        "budget": {
            "nodes": nodes,
            "scale": scale,
            "attempts": [{"scale": each, "nodes": len(result.mesh.points)} for each, result in done.items()],
        },
        "seconds": {**own, "other_attempts": seconds - own["total"], "total": seconds},
        "warnings": [*best.report["warnings"], *warnings.missed_node_target(nodes, len(best.mesh.points))],
    }
    return replace(best, report=report)


def _meshed(problem: Problem, on_round: OnRound, on_share: OnShare, passed: float) -> Result:
    """Mesh a problem once, as it is, when so many seconds have passed."""
    task = problem.task
    domain, method, seconds = problem.domain, problem.method, dict(problem.seconds)
    ideal_nodes, clock = problem.survey.ideal_nodes, Clock(task.time_limit, passed, on_share)
    with timed(seconds, "placement"):
        spacing = tabulated(domain, problem.spacing)
        levels = method.levels(domain, spacing, problem.expected_nodes)
        start = method.placement(domain, levels[0], task.max_nodes)
        initial = initial_row(start, connect(start, domain).triangles)
    with timed(seconds, "packing"):
        last, rows, speeds = _packed(rounds(start, domain, levels, method, clock), on_round)
    with timed(seconds, "quality"):
        mesh = mesh_of(last.net, domain)
        require_conforming(mesh)
        departure = deviation(domain, mesh.points, *domain.boundary.edges(last.bubbles.piece, last.bubbles.s))
        figures = mesh_figures(mesh.points, mesh.triangles, problem.wanted.between)
    report = {
        "case": task.name,
        "method": task.method_name,
        "version": __version__,
        "seed": method.perturbation.seed,
        "parameters": task.parameters,
        "initial": initial,
        "rounds": [asdict(row) for row in rows],
        "stop_reason": last.stop_reason,
        "finished": not clock.over,
        **rules_figures(problem),
        "ideal_nodes": ideal_nodes,
        "force_evaluations": sum(row.force_evaluations for row in rows),
        **figures,
        "area_error": area_error(mesh),
        **({} if departure is None else {"deviation": departure._asdict()}),
        "seconds": seconds | {"total": sum(seconds.values())},
        "peak_memory_mb": peak_memory_mb(),
        "warnings": [
            *problem.warnings,
            *clock.warnings,
            *warnings.poor_result(figures, None if problem.refined else ideal_nodes),
        ],
    }
    return Result(mesh, triangle_fields(mesh, problem.wanted), report, speeds)


def _packed(
    steps: Iterable[Round], on_round: Callable[[RoundRow], None]
) -> tuple[Round, list[RoundRow], tuple[Floats, ...]]:
    """Run the rounds; the last of them, and the figures and mean speeds of all."""
    rows, speeds = [], []
    begun = perf_counter()
    for done in steps:
        rows.append(round_row(done, perf_counter() - begun))
        speeds.append(done.speeds)
        on_round(rows[-1])
        begun = perf_counter()
    return done, rows, tuple(speeds)


def mesh_of(net: Net, domain: Domain) -> Mesh:
    """The mesh of connected bubbles, with the domain's labels and regions."""
    boundary, bubbles, parts = domain.boundary, net.bubbles, domain.parts
    facets, piece = boundary.edges(bubbles.piece, bubbles.s)
    begin, end = boundary.arcs(facets, piece, bubbles.s)
    triangles = sorted_triangles(net.triangles)
    region = np.zeros(len(triangles), np.int64)
    if parts.regions:
        region = regions(triangles, facets, boundary.left[piece], boundary.right[piece])
    numbers, region = np.unique(parts.name_indices[region], return_inverse=True)
    labels, label = np.unique(boundary.label[piece], return_inverse=True)
    vertices = [_node_at(point, bubbles) for point, _ in parts.points]
    point_labels = tuple(dict.fromkeys(name for _, name in parts.points))
    return Mesh(
        bubbles.x,
        triangles,
        facets,
        label,
        tuple(boundary.labels[k] for k in labels),
        regions=tuple(parts.names[k] for k in numbers),
        triangle_regions=region,
        labelled_nodes=np.array(vertices, np.int64),
        node_labels=np.array([point_labels.index(name) for _, name in parts.points], np.int64),
        point_labels=point_labels,
        facet_middles=boundary.points(piece, boundary.wrapped(piece, (begin + end) / 2)),
        periodic=matching_edges(domain.periodic, piece),
    )


def _node_at(point: tuple[float, float], bubbles: Bubbles) -> int:
    """The corner that is an embedded point."""
    return int(np.hypot(*(bubbles.x[: bubbles.corners] - point).T).argmin())
