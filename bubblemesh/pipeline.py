"""From a case to a mesh: the whole story on one screen."""

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from time import perf_counter
from typing import Any

from bubblemesh import __version__, compromises
from bubblemesh.arrays import Floats
from bubblemesh.case import Case
from bubblemesh.conformity import require_conforming
from bubblemesh.geometry.domain import Domain
from bubblemesh.mesh import Mesh
from bubblemesh.packing.connection import connected
from bubblemesh.packing.methods import Method
from bubblemesh.packing.options import configured
from bubblemesh.packing.rounds import Round, rounds
from bubblemesh.spacing.expression import Expression
from bubblemesh.spacing.refinement import coarse_curves, short_pieces
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.survey import Survey, surveyed
from bubblemesh.summary import RoundRow, initial_row, mesh_figures, resolved_case, round_row, triangle_fields

__all__ = ["Problem", "Result", "mesh_case", "prepared"]


@dataclass(frozen=True)
class Problem:
    """A case made ready for packing.

    Attributes
    ----------
    case : Case
    domain : Domain
    wanted, spacing : Spacing
        What the case asks for, and what the packing goes by: finer where the boundary is.
    survey : Survey
        Extremes of the wanted spacing and the ideal number of nodes.
    method : Method
    warnings : tuple of str
    seconds : dict
        Time taken, by stage.
    """

    case: Case
    domain: Domain
    wanted: Spacing
    spacing: Spacing
    survey: Survey
    method: Method
    warnings: tuple[str, ...]
    seconds: dict[str, float]


@dataclass(frozen=True)
class Result:
    """A mesh, data (t,) for its triangles, and the report of the run."""

    mesh: Mesh
    fields: dict[str, Floats]
    report: dict[str, Any]


def prepared(case: Case) -> Problem:
    """Check geometry and spacing of a case, and bind its method.

    Raises
    ------
    GeometryError, CaseError, LimitError
        With the place and what to do.
    """
    seconds: dict[str, float] = {}
    with timed(seconds, "geometry"):
        domain = Domain.of(case.domain.outer.ring(), [hole.ring() for hole in case.domain.holes])
    with timed(seconds, "spacing"):
        wanted = Spacing(Expression.parse(str(case.spacing), case.parameters))
        survey = surveyed(domain, wanted, case.limits.max_nodes)
        wanted = wanted.floored(survey.minimum / 2)
        short, coarse = short_pieces(domain, wanted), coarse_curves(domain, wanted)
        spacing = short.joined(coarse).limited(wanted)
        warnings = (
            *domain.notes,
            *compromises.sharp_angles(domain),
            *compromises.refined_boundary(short, coarse),
            *compromises.narrow_walls(domain, spacing),
        )
    method = configured(case.method, case.packing, case.schedule)
    return Problem(case, domain, wanted, spacing, survey, method, warnings, seconds)


def mesh_case(case: Case, on_round: Callable[[RoundRow], None] = lambda row: None) -> Result:
    """Mesh a case; ``on_round`` is told of each round as it ends.

    Raises
    ------
    BubblemeshError
        One of its subclasses for a mistake of the user's, with the place and what to do.
    """
    problem = prepared(case)
    domain, spacing, method, seconds = problem.domain, problem.spacing, problem.method, dict(problem.seconds)
    with timed(seconds, "placement"):
        start = method.placement(domain, spacing, case.limits.max_nodes)
        initial = initial_row(start, connected(start, domain)[2])
    with timed(seconds, "packing"):
        last, rows = _packed(rounds(method.perturbation(start), domain, spacing, method), on_round)
    with timed(seconds, "quality"):
        mesh = _mesh(last, domain)
        require_conforming(mesh)
        figures = mesh_figures(mesh, problem.wanted)
    report = {
        "case": case.name,
        "method": case.method,
        "version": __version__,
        "seed": method.perturbation.seed,
        "parameters": resolved_case(case, method),
        "initial": initial,
        "rounds": [asdict(row) for row in rows],
        "stop_reason": last.stop_reason,
        "ideal_nodes": problem.survey.ideal_nodes,
        "force_evaluations": sum(row.force_evaluations for row in rows),
        **figures,
        "seconds": seconds | {"total": sum(seconds.values())},
        "peak_memory_mb": peak_memory_mb(),
        "warnings": [*problem.warnings, *compromises.poor_result(figures, problem.survey.ideal_nodes)],
    }
    return Result(mesh, triangle_fields(mesh, problem.wanted), report)


def _packed(steps: Iterable[Round], on_round: Callable[[RoundRow], None]) -> tuple[Round, list[RoundRow]]:
    """Run the rounds; the last of them, and the figures of all."""
    rows = []
    begun = perf_counter()
    for done in steps:
        rows.append(round_row(done, perf_counter() - begun))
        on_round(rows[-1])
        begun = perf_counter()
    return done, rows


def _mesh(last: Round, domain: Domain) -> Mesh:
    """The mesh of the last round's bubbles."""
    boundary, bubbles = domain.boundary, last.bubbles
    facets, piece = boundary.edges(bubbles.piece, bubbles.s)
    return Mesh(bubbles.x, last.triangles, facets, boundary.label[piece], boundary.labels)


@contextmanager
def timed(seconds: dict[str, float], stage: str) -> Iterator[None]:
    """Note the time that the block takes."""
    begun = perf_counter()
    yield
    seconds[stage] = perf_counter() - begun


def peak_memory_mb() -> float | None:
    """Largest memory the process has held, in megabytes; None where the system does not tell."""
    try:
        import resource
    except ImportError:  # Windows
        return None
    unit = 2**20 if sys.platform == "darwin" else 2**10
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6
