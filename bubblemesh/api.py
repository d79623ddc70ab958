"""Interface for Python programs: cases, meshes, and meshing without a case file."""

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

from numpy.typing import ArrayLike

from bubblemesh.adaptivity.solution import Solution, read_solution
from bubblemesh.case import Case, load_case
from bubblemesh.errors import CaseError, Key, MeshWarning, in_call
from bubblemesh.files import with_home
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.messages import own_places, tell_places_of
from bubblemesh.problem.prepare import prepare_in
from bubblemesh.problem.problem import Problem
from bubblemesh.problem.python.domain import Geometry, Labels, ProgramRings
from bubblemesh.problem.python.inside import Lines, Points, ProgramParts, Regions
from bubblemesh.problem.python.progress import in_steps
from bubblemesh.problem.python.spacing import SpacingLike, spacing_of
from bubblemesh.problem.python.task import MAX_NODES, MeshOptions
from bubblemesh.problem.spacing import with_areas_below, with_metrics
from bubblemesh.problem.values import values_of
from bubblemesh.process.stopwatch import Stopwatch
from bubblemesh.run.limits import within_limits
from bubblemesh.run.packing import RunOptions
from bubblemesh.run.pipeline import Result, mesh_case, mesh_problem, require_case
from bubblemesh.run.report import RoundRow

__all__ = ["Case", "Domain", "Mesh", "MeshWarning", "Result", "Solution", "adapt", "load_case", "mesh", "mesh_case"]


def mesh(
    geometry: Geometry,
    spacing: SpacingLike,
    *,
    holes: Sequence[ArrayLike] = (),
    labels: Labels | None = None,
    regions: Regions | None = None,
    lines: Lines | None = None,
    points: Points | None = None,
    overlaps: Literal["refused", "later"] = "refused",
    periodic: Sequence[tuple[str, str]] = (),
    periodic_tolerance: float | None = None,
    corners: float | None = None,
    smooth: bool = False,
    tolerance: float | None = None,
    method: str | None = None,
    seed: int | None = None,
    effort: str | None = None,
    packing: Mapping[str, Any] | None = None,
    schedule: Mapping[str, Any] | None = None,
    max_nodes: int = MAX_NODES,
    nodes: int | None = None,
    angle_min: float = 0.0,
    largest: float | None = None,
    layers: Sequence[Mapping[str, Any]] = (),
    metric: Mapping[str, Any] | Sequence[Mapping[str, Any]] | None = None,
    progress: Callable[[float], object] = lambda share: None,
) -> Mesh:
    """Mesh a domain.

    Parameters
    ----------
    geometry : shapely.Polygon, shapely.MultiPolygon, Domain or array (n, 2)
        The holes of a polygon are kept, and each of its vertices becomes a node unless ``corners`` is given. Several
        polygons become separate pieces of one mesh. An array holds the points of the outer ring.
    spacing : float, str, mapping or callable
        Wanted edge length in the unit of the geometry: a number, an expression in x and y, a function of the
        coordinates x (n,) and y (n,) of many points that returns the (n,) values there, or a mapping of terms as in a
        case file (whose files are relative to the working directory), among them a ``function`` or a list of such:
        ``{"function": f, "growth": 0.2}``. Functions are called a little outside of the domain, too, and may give NaN
        there.
    holes : sequence of arrays (n, 2), optional
        Points of each hole, if the outer ring is an array too.
    labels : sequence or mapping of str, optional
        Names of the rings, those of all outer ones first, or names in place of the usual ones, which are ``outer``,
        ``outer-2``, ``hole-1`` and so on: ``{"hole-1": "bore"}``.
    regions : mapping of str, optional
        Parts of the domain by their names, as polygons or arrays (n, 2) of the points of a ring: ``{"core": disc}``,
        or as a shapely.Point or MultiPoint in what ``lines``, rings and other regions enclose. They may share sides,
        touch the rings and lie in each other, where the inner one counts; several polygons are one region. What they
        leave is the region ``domain``. The sides of polygons have labels as ``core-rim``.
    lines : mapping of str, optional
        Lines inside, by their labels, whose edges are edges of the mesh: a shapely.LineString, a MultiLineString, or
        an array (n, 2) of points. A line on the boundary labels that part of it, such as one side:
        ``{"inlet": [(0, 0), (0, 1)]}``.
    points : mapping of str, optional
        Points inside that are nodes, by their labels: (x, y), or several as an array (n, 2).
    overlaps : {"refused", "later"}
        Where regions overlap, but not by one being inside the other: an error, or they cover those before them in the
        mapping, as in a drawing.
    periodic : sequence of pairs of str, optional
        Labels of sides that are the same but for a shift or a turn, whose nodes match: ``[("left", "right")]``. Labels
        of single sides are those of ``lines`` along them.
    periodic_tolerance : float, optional
        Length by which these sides may differ: the second one of each pair becomes the first one moved.
    corners, smooth, tolerance
        As of a ring in a case file: only vertices that turn by more than ``corners`` degrees are nodes, what is between
        them is spaced anew, ``smooth`` along a spline, and at most the ``tolerance`` from the ring.
    method, packing, schedule
        As in a case file; ``seed`` and ``effort`` are short for those of ``packing``. The method is ``multilevel`` by
        default, and ``ellipses`` with a ``metric``, which no other one packs.
    max_nodes : int
    nodes : int, optional
        Number of nodes that the mesh gets, to 2 %, or to one node of fewer than 50: the spacing is scaled for it.
    angle_min : float
        Least angle of the triangles in degrees, up to 30: nodes are added for it, but not for sharper corners.
    largest : float, optional
        Largest area of a triangle.
    layers : sequence of mappings, optional
        Boundary layers, each as an entry of ``layers`` in a case file: ``{"on": "outer", "first": 1e-3, "count": 8}``.
    metric : mapping or sequence of mappings, optional
        Sizes that depend on the direction, as under ``metric`` in a case file, whose files are relative to the working
        directory: ``{"angle": 0.5, "across": 0.01}``. The spacing is the largest size in any direction.
    progress : callable, optional
        Called with the share done, about once per hundredth. It may jump to 1 when packing ends early; with ``nodes``
        it may start again from 0.

    Warns
    -----
    MeshWarning
        Of what the report of a case would warn of, such as vertices that take more nodes than the spacing asks for.

    Raises
    ------
    CaseError
        If the spacing or the metric is not positive and finite everywhere, or a term or another argument is wrong.
    FileError
        If a file that the spacing or the metric names cannot be read.
    GeometryError
        If the rings are empty or invalid, or overlap, or regions do.
    LimitError
        If the mesh would need more than ``max_nodes`` nodes, or ``nodes`` are too few for the rings.
    RequirementError
        If ``angle_min`` or ``largest`` cannot be reached.
    """
    inside = ProgramParts(
        regions=regions,
        lines=lines,
        points=points,
        overlaps=overlaps,
        periodic=periodic,
        periodic_tolerance=periodic_tolerance,
    )
    drawing = ProgramRings(
        geometry=geometry,
        holes=holes,
        labels=labels,
        corners=corners,
        smooth=smooth,
        tolerance=tolerance,
        inside=inside,
    )
    options = MeshOptions(
        method=method,
        packing=packing,
        schedule=schedule,
        seed=seed,
        effort=effort,
        max_nodes=max_nodes,
        nodes=nodes,
        angle_min=angle_min,
        largest=largest,
        layers=layers,
        metric=metric,
    )
    with in_call("mesh()", "geometry", "max_nodes"), own_places():
        told = in_steps(progress)
        result = mesh_problem(_problem(drawing, spacing, options), RunOptions(on_share=told))
        if result.verdict is not None:
            raise result.verdict
    told(1.0)
    for text in result.report.warnings:
        warnings.warn(text, MeshWarning, stacklevel=2)
    return result.mesh


def _problem(drawing: ProgramRings, spacing: SpacingLike, options: MeshOptions) -> Problem:
    """The problem that the arguments of `mesh` pose."""
    task, domain = options.task(), drawing.domain()
    tell_places_of(domain.size)
    task = replace(task, ladders=options.ladders(domain))
    metrics = options.metrics()
    request = with_areas_below(spacing_of(spacing, domain, values_of(metrics)), domain, options.largest, {})
    request = with_metrics(request, metrics, domain, None)
    if options.nodes is not None:
        if request.nodes is not None:
            raise CaseError("nodes: is given twice, also as spacing['nodes']: drop one of them")
        request = replace(request, nodes=int(options.nodes))
    return prepare_in(domain, replace(request, nodes_key=Key(["nodes"])), task, Stopwatch())


def adapt(
    case: Case,
    solution: Solution | Path | str,
    field: str | None = None,
    *,
    error: float | None = None,
    nodes: int | None = None,
    anisotropic: bool = False,
    exact: str | None = None,
    on_round: Callable[[RoundRow], None] = lambda row: None,
) -> Result:
    """Mesh a case anew as its solution asks for: finer where the estimated error is large, coarser where it is small.

    Parameters
    ----------
    case : Case
        Its domain, and the limits and rules of its spacing.
    solution : Solution or path
        A solution on a mesh of the case's domain, or a file that holds one at the nodes.
    field : str, optional
        Name of the solution in the file, needed if it has more data at its nodes.
    error : float, optional
        Wanted error of the gradient in terms of its norm, as 0.05 for 5 %.
    nodes : int, optional
        Wanted number of nodes. Without it and an error it is that of the case's spacing, or else that of the present
        mesh.
    anisotropic : bool
        Whether sizes depend on the direction: long triangles where the solution changes fast across only.
    exact : str, optional
        The exact solution as an expression in x and y: then the report tells how good the estimate is.
    on_round : callable
        Is told of each round as it ends.

    Warns
    -----
    MeshWarning
        Of what was chosen of the file, such as the last of several times.

    Returns
    -------
    Result
        ``mesh``, ``report`` with the estimated error under ``adaptation``, and data for each triangle in ``fields``.

    Raises
    ------
    BubblemeshError
        One of its subclasses for a mistake of the user's, with the place and what to do.
    """
    # Imported here since meshing alone needs no estimates of errors.
    from bubblemesh.adaptivity import adapt as adapting
    from bubblemesh.adaptivity.target import Target

    require_case(case)
    if not isinstance(solution, Path | str):
        if field is not None:
            raise CaseError(f"field: names data of a file, but the solution is given as arrays (found {field!r})")
        if not isinstance(solution, Solution):
            raise CaseError(f"solution: must be a Solution, or a file that holds one (found {type(solution).__name__})")

    def adapted() -> tuple[Result, list[str]]:
        given = (solution, []) if isinstance(solution, Solution) else read_solution(Path(with_home(solution)), field)
        target = Target(error, nodes, anisotropic)
        return adapting.adapted(case, given[0], target, exact, on_round), given[1]

    with own_places():
        result, notes = within_limits(case, adapted)
    for note in notes:
        warnings.warn(note, MeshWarning, stacklevel=2)
    return result
