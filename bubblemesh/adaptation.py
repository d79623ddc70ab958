"""What Python programs use to adapt a mesh to a solution."""

from collections.abc import Callable
from pathlib import Path

from bubblemesh import adapting
from bubblemesh.adaptivity.solution import Solution
from bubblemesh.api import Mesh, public
from bubblemesh.case import Case
from bubblemesh.errors import CaseError
from bubblemesh.output.solutions import read_nodal_field
from bubblemesh.pipeline import Result
from bubblemesh.summary import RoundRow

__all__ = ["Solution", "adapt"]


def adapt(
    case: Case,
    solution: Solution | Path | str,
    field: str | None = None,
    *,
    error: float | None = None,
    nodes: int | None = None,
    exact: str | None = None,
    on_round: Callable[[RoundRow], None] = lambda row: None,
) -> Result[Mesh]:
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
    return public(adapting.adapted(case, solution, adapting.Target(error, nodes), exact, on_round))
