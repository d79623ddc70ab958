"""Whether a mesh may have a triangle for each part that a parallel solver gets, as far as that is known before it."""

from bubblemesh.errors import CaseError, at_key
from bubblemesh.problem.problem import Problem

FEW_NODES = 100  # below which the boundary decides the number
MOST_TRIANGLES = 4.0  # for each node that is expected, twice as many as there are


def require_triangles_for_parts(problem: Problem) -> None:
    """Check that the mesh may have a triangle for each part that a parallel solver gets; else it is a CaseError.

    Only what is surely too much is refused: how many triangles there are is known once the mesh is there, and demands
    on each triangle may add any number.
    """
    parts, expected = problem.task.partition, problem.expected_nodes
    if parts is None or problem.task.demanded or parts <= MOST_TRIANGLES * max(expected, FEW_NODES):
        return
    with at_key("output", "partition"):
        raise CaseError(
            f"a mesh of about {expected:.0f} nodes, with twice as many triangles, has none for each of {parts} parts: "
            "ask for fewer, or for a finer spacing"
        )
