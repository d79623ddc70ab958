"""Interface for Python programs: cases, meshes, and meshing without a case file."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from bubblemesh.adaptivity import adapt as adapting
from bubblemesh.adaptivity.solution import Solution
from bubblemesh.arrays import Floats
from bubblemesh.case import Case, load_case
from bubblemesh.case.models import Limits
from bubblemesh.errors import CaseError, Key
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.read import read_nodal_field
from bubblemesh.packing.configure import OptionError, configured, options
from bubblemesh.problem.prepare import prepare_in
from bubblemesh.problem.problem import Task
from bubblemesh.problem.python_input import polygon_domain, spacing_of
from bubblemesh.problem.spacing import with_areas_below
from bubblemesh.run.pipeline import Result, mesh_case, mesh_problem
from bubblemesh.run.report import RoundRow

__all__ = ["Case", "Domain", "Mesh", "Result", "Solution", "adapt", "load_case", "mesh", "mesh_case"]

MAX_NODES = Limits().max_nodes


def mesh(
    geometry: shapely.Polygon | shapely.MultiPolygon | Domain,
    spacing: float | str | Mapping[str, Any] | Callable[[Floats, Floats], Any],
    *,
    labels: Sequence[str] | None = None,
    method: str = "multilevel",
    packing: Mapping[str, Any] | None = None,
    schedule: Mapping[str, Any] | None = None,
    max_nodes: int = MAX_NODES,
    nodes: int | None = None,
    angle_min: float = 0.0,
    largest: float | None = None,
) -> Mesh:
    """Mesh a domain.

    Parameters
    ----------
    geometry : shapely.Polygon, shapely.MultiPolygon or Domain
        The holes of a polygon are kept, and each of its vertices becomes a node. Several polygons become separate
        pieces of one mesh.
    spacing : float, str, mapping or callable
        Wanted edge length in the unit of the geometry: a number, an expression in x and y, a mapping of terms as in a
        case file (whose files are relative to the working directory), or a function of the coordinates x (n,) and
        y (n,) of many points that returns the (n,) values there.
    labels : sequence of str, optional
        Names of the rings, those of all outer ones first; else ``outer``, ``outer-2``, ``hole-1`` and so on.
    method, packing, schedule
        As in a case file.
    max_nodes : int
    nodes : int, optional
        Number of nodes that the mesh gets, within 2 %: the spacing is scaled for it.
    angle_min : float
        Least angle of the triangles in degrees, up to 30: nodes are added for it, but not for sharper corners.
    largest : float, optional
        Largest area of a triangle.

    Raises
    ------
    CaseError
        If the spacing is not positive and finite everywhere, or a term of it or an option is wrong.
    FileError
        If a file that the spacing names cannot be read.
    GeometryError
        If the polygons are empty or invalid, or overlap.
    LimitError
        If the mesh would need more than ``max_nodes`` nodes, or ``nodes`` are too few for the polygon.
    RequirementError
        If ``angle_min`` or ``largest`` cannot be reached.
    """
    if nodes is not None and (isinstance(nodes, bool) or not isinstance(nodes, int | np.integer) or nodes < 3):
        raise CaseError(f"nodes: must be a whole number of at least 3 (found {nodes!r})")
    if not 0 <= angle_min <= 30:
        raise CaseError(f"angle_min: must be from 0 to 30 degrees (found {angle_min!r})")
    if largest is not None and not largest > 0:
        raise CaseError(f"largest: must be an area greater than 0 (found {largest!r})")
    try:
        bound = configured(method, dict(packing or {}), dict(schedule or {}))
    except OptionError as error:
        raise CaseError(".".join(filter(None, (error.section, error.key))) + f": {error.message}") from None
    domain = polygon_domain(geometry, labels)
    wanted = with_areas_below(spacing_of(spacing, domain), domain, largest, {})
    parameters = {"method": method, "limits": {"max_nodes": max_nodes}} | options(bound)
    task = Task(
        "mesh",
        method,
        bound,
        max_nodes,
        None,
        parameters,
        least_angle=angle_min,
        largest=np.inf if largest is None else largest,
    )
    problem = prepare_in(
        domain, wanted if nodes is None else replace(wanted, nodes=int(nodes)), task, {}, Key(["nodes"])
    )
    result = mesh_problem(problem)
    if result.verdict is not None:
        raise result.verdict
    return result.mesh


def adapt(
    case: Case,
    solution: Solution | Path | str,
    field: str | None = None,
    *,
    error: float | None = None,
    nodes: int | None = None,
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
    exact : str, optional
        The exact solution as an expression in x and y: then the report tells how good the estimate is.
    on_round : callable
        Is told of each round as it ends.

    Returns
    -------
    Result
        ``mesh``, ``report`` with the estimated error under ``adaptation``, and data for each triangle in ``fields``.

    Raises
    ------
    BubblemeshError
        One of its subclasses for a mistake of the user's, with the place and what to do.
    """
    if isinstance(solution, Path | str):
        read = read_nodal_field(Path(solution), field)
        solution = Solution.of(read.points, read.triangles, read.values, read.name)
    elif field is not None:
        raise CaseError(f"field: names data of a file, but the solution is given as arrays (found {field!r})")
    return adapting.adapted(case, solution, adapting.Target(error, nodes), exact, on_round)
