"""The next mesh of an adaptation as a problem, and what of it comes from the case and the solution in any way."""

from dataclasses import replace
from typing import Any

import numpy as np
import shapely

from bubblemesh.adaptivity.solution import Solution
from bubblemesh.arrays import Integers
from bubblemesh.case import Case
from bubblemesh.geometry.domain import Domain
from bubblemesh.problem.problem import Problem
from bubblemesh.problem.scale import SpacingAtScale
from bubblemesh.problem.spacing import SpacingRequest, held_request
from bubblemesh.records import record


@record(eq=False)
class NextMesh:
    """The next mesh as a problem."""

    problem: Problem
    start: dict[str, Any]  # how it starts, for the report
    step: float  # error that one step without the case's limits leads to


def held(case: Case, domain: Domain, at: SpacingAtScale, solution: Solution) -> SpacingRequest:
    """The request of `held_request`, with a warning of a solution that says nothing."""
    request = held_request(case, domain, at)
    if not solution.constant:
        return request
    note = (
        f"{solution.name} is the same at all nodes, so that nothing is known of its error: see whether it is the field "
        "that was meant, and whether the solver has found a solution"
    )
    return replace(request, warnings=(*request.warnings, note))


def parts(domain: Domain, solution: Solution) -> Integers | None:
    """Number of the region that each triangle (t,) lies in, if there are several."""
    polygons = sorted((region.polygon for region in domain.parts.regions), key=shapely.area, reverse=True)
    if not polygons:
        return None
    middles = shapely.points(solution.points[solution.triangles].mean(axis=1))
    region, triangle = shapely.STRtree(middles).query(polygons, predicate="contains")
    part = np.zeros(len(middles), np.int64)
    np.maximum.at(part, triangle, region + 1)  # of nested regions the innermost, which comes last
    return part
