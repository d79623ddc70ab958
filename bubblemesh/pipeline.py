"""From a case to a mesh: the whole story on one screen."""

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from time import perf_counter
from typing import Any

from bubblemesh import __version__, compromises
from bubblemesh.arrays import Floats
from bubblemesh.case import Case
from bubblemesh.conformity import area_error, require_conforming
from bubblemesh.geometry.deviation import deviation
from bubblemesh.geometry.domain import Domain
from bubblemesh.mesh import Mesh
from bubblemesh.packing.connection import connected
from bubblemesh.packing.rounds import Round, rounds
from bubblemesh.problem import prepared
from bubblemesh.resources import peak_memory_mb, timed
from bubblemesh.summary import RoundRow, initial_row, mesh_figures, resolved_case, round_row, triangle_fields
from bubblemesh.triangulation import sorted_triangles

__all__ = ["Result", "mesh_case"]


@dataclass(frozen=True)
class Result:
    """A mesh, data (t,) for its triangles, the report, and the mean speeds (iterations,) in each round."""

    mesh: Mesh
    fields: dict[str, Floats]
    report: dict[str, Any]
    speeds: tuple[Floats, ...]


def mesh_case(case: Case, on_round: Callable[[RoundRow], None] = lambda row: None) -> Result:
    """Mesh a case; ``on_round`` is told of each round as it ends.

    Raises
    ------
    BubblemeshError
        One of its subclasses for a mistake of the user's, with the place and what to do.
    """
    problem = prepared(case)
    domain, spacing, method, seconds = problem.domain, problem.spacing, problem.method, dict(problem.seconds)
    ideal_nodes = problem.survey.ideal_nodes
    with timed(seconds, "placement"):
        levels = method.levels(domain, spacing, problem.expected_nodes)
        start = method.placement(domain, levels[0], case.limits.max_nodes)
        initial = initial_row(start, connected(start, domain).triangles)
    with timed(seconds, "packing"):
        last, rows, speeds = _packed(rounds(start, domain, levels, method), on_round)
    with timed(seconds, "quality"):
        mesh = _mesh(last, domain)
        require_conforming(mesh)
        departure = deviation(domain, mesh.points, *domain.boundary.edges(last.bubbles.piece, last.bubbles.s))
        figures = mesh_figures(mesh.points, mesh.triangles, problem.wanted)
    report = {
        "case": case.name,
        "method": case.method,
        "version": __version__,
        "seed": method.perturbation.seed,
        "parameters": resolved_case(case, method),
        "initial": initial,
        "rounds": [asdict(row) for row in rows],
        "stop_reason": last.stop_reason,
        "ideal_nodes": ideal_nodes,
        "force_evaluations": sum(row.force_evaluations for row in rows),
        **figures,
        "area_error": area_error(mesh),
        **({} if departure is None else {"deviation": departure._asdict()}),
        "seconds": seconds | {"total": sum(seconds.values())},
        "peak_memory_mb": peak_memory_mb(),
        "warnings": [*problem.warnings, *compromises.poor_result(figures, None if problem.refined else ideal_nodes)],
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


def _mesh(last: Round, domain: Domain) -> Mesh:
    """The mesh of the last round's bubbles."""
    boundary, bubbles = domain.boundary, last.bubbles
    facets, piece = boundary.edges(bubbles.piece, bubbles.s)
    return Mesh(bubbles.x, sorted_triangles(last.triangles), facets, boundary.label[piece], boundary.labels)
