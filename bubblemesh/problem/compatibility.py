"""Whether what a task asks for goes together: a method, a metric, periodic sides, parts, layers and demands."""

from collections.abc import Callable

from bubblemesh.case.models import IN_METRIC
from bubblemesh.errors import CaseError, Key, about, at_key
from bubblemesh.geometry.domain import Domain
from bubblemesh.problem.problem import Problem, Task
from bubblemesh.problem.spacing import SpacingRequest

FEW_NODES = 100  # below which the boundary decides the number
MOST_TRIANGLES = 4.0  # for each node that is expected, twice as many as there are


def require_possible(domain: Domain, request: SpacingRequest, task: Task) -> None:
    """Check that what a task asks for in a domain goes together; a CaseError, about the key, if not."""
    if task.method_name == IN_METRIC:
        _require_possible_in_metric(task)
    elif request.metrics:
        with about(Key(["method"])):
            raise CaseError(f"method: {task.method_name} packs no metric: leave method out, or use {IN_METRIC}")
    _require_still_boundary(domain, task)


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


def _require_still_boundary(domain: Domain, task: Task) -> None:
    """Check that bubbles on the boundary stay where anything asks for it."""
    asked: dict[tuple[str, ...], tuple[Callable[[], bool], str]] = {
        ("domain", "periodic"): (lambda: len(domain.periodic) > 0, "the sides"),
        ("parts",): (lambda: task.parts != 1, "the cuts"),
        ("layers",): (lambda: len(task.ladders) > 0, "them"),
    }
    for keys, (given, where) in asked.items():
        with about(Key(list(keys))):  # where sides that are not there are reported, too
            if given() and not task.method.relaxation.boundary_stays:
                with at_key(*keys):
                    raise CaseError(f"bubbles would slide along {where}: use relaxation: connected, or multilevel")


def _require_possible_in_metric(task: Task) -> None:
    reasons = {
        "angle_min": "its triangles are long, and small angles in space are no fault",
        "overconstrained": "it adds nodes by circles, which do not fit long triangles",
        "largest": "it adds nodes by circles, which do not fit long triangles: bound the sizes",
    }
    for key, reason in reasons.items():
        if key in task.demanded:
            with about(Key([key])):
                raise CaseError(f"{key}: does not go with a metric: {reason}: leave it out")
