"""Triangle (J. R. Shewchuk): boundary nodes by equidistribution, then refined until no triangle is too large."""

import numpy as np
import shapely

from benchmarks.peers.clock import Clock
from bubblemesh.arrays import Floats, Integers
from bubblemesh.case import Case
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.problem.prepare import prepare
from bubblemesh.problem.problem import Problem
from bubblemesh.spacing.spacing import Spacing

LARGEST_AREA = 1.6  # of an equilateral triangle with edges d: gives about the ideal number of nodes if d is uniform
PASSES = 12
SAMPLES_PER_NODE = 8


def mesh(case: Case, clock: Clock) -> tuple[Floats, Integers]:
    """Points (n, 2) and triangles (t, 3) with angles above 30 degrees and areas by the spacing.

    A trial, not counted, tells by how much to enlarge the areas for about the ideal number of nodes.
    """
    problem = prepare(case)
    trial, _ = _refined(problem, LARGEST_AREA)
    with clock:
        return _refined(problem, LARGEST_AREA * len(trial) / problem.survey.ideal_nodes)


def _refined(problem: Problem, largest_area: float) -> tuple[Floats, Integers]:
    """Refine until no triangle is too large; the boundary is not split (switch Y), its nodes lie on the curves."""
    import triangle

    found = triangle.triangulate(_outline(problem), "pq30YQ")
    for _ in range(PASSES):
        count = len(found["vertices"])
        d = problem.spacing(found["vertices"][found["triangles"]].mean(axis=1))
        found["triangle_max_area"] = largest_area * np.sqrt(3) / 4 * d**2
        found = triangle.triangulate(found, "rpq30aYQ")
        if len(found["vertices"]) == count:
            break
    return found["vertices"], found["triangles"].astype(int)


def _outline(problem: Problem) -> dict[str, Floats | Integers]:
    points, edges = boundary_nodes(problem.domain.boundary, problem.spacing, problem.survey.extremes.minimum)
    holes = [point.coords[0] for point in _points_in_holes(problem.domain.polygon)]
    return {"vertices": points, "segments": edges} | ({"holes": np.array(holes)} if holes else {})


def _points_in_holes(domain: shapely.Polygon | shapely.MultiPolygon) -> list[shapely.Point]:
    """A point in each part of the holes that no piece of the domain covers."""
    holes = [shapely.Polygon(ring) for piece in shapely.get_parts(domain) for ring in piece.interiors]
    return [part.representative_point() for hole in holes for part in shapely.get_parts(hole - domain)]


def boundary_nodes(boundary: Boundary, spacing: Spacing, minimum: float) -> tuple[Floats, Integers]:
    """Points (n, 2) and edges (n, 2): each piece in intervals of the same integral of ds / d."""
    pieces, lengths = [], []
    for piece, length in enumerate(boundary.lengths):
        steps = int(SAMPLES_PER_NODE * (length / minimum + 1))
        middle = (np.arange(steps) + 0.5) * length / steps
        d = spacing(boundary.points(np.full(steps, piece), middle))
        nodes = np.concatenate([[0], np.cumsum(length / steps / d)])
        closed = bool(boundary.closed[piece])
        intervals = max(round(nodes[-1]), 3 if closed else 1)
        sought = np.arange(0 if closed else 1, intervals) * nodes[-1] / intervals
        lengths.append(np.interp(sought, nodes, np.linspace(0, length, steps + 1)))
        pieces.append(np.full(len(sought), piece))
    piece, s = np.concatenate(pieces), np.concatenate(lengths)
    return np.vstack([boundary.corners, boundary.points(piece, s)]), boundary.edges(piece, s)[0]
