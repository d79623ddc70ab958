"""DistMesh's algorithm, written anew from its description.

P.-O. Persson and G. Strang, "A simple mesh generator in MATLAB", SIAM Review 46 (2004).
"""

import numpy as np
from scipy.spatial import Delaunay

from benchmarks.peers.clock import Clock
from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.case import Case
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.problem.prepare import prepare
from bubblemesh.problem.problem import Problem
from bubblemesh.spacing.spacing import Spacing

# The values of the article, and a bound on the steps, which it does not have.
MOVE_TO_STOP, MOVE_TO_CONNECT, PRESSURE, STEP, MARGIN = 0.001, 0.1, 1.2, 0.2, 0.001
STEPS = 1000


def mesh(case: Case, clock: Clock) -> tuple[Floats, Integers]:
    """Points (n, 2) and triangles (t, 3)."""
    problem = prepare(case)
    with clock:
        h0 = _lattice_distance(problem)
        return distmesh(problem.domain, problem.spacing, h0, np.random.default_rng(0))


def _lattice_distance(problem: Problem) -> float:
    """The distance in the first lattice that gives about the ideal number of nodes, those of the boundary included."""
    minimum, ideal = problem.survey.extremes.minimum, problem.survey.ideal_nodes
    points = _lattice(problem.domain, minimum)
    d = problem.spacing(points[problem.domain.contains(points)])
    return float(minimum * np.sqrt(((minimum / d) ** 2).sum() / ideal))


def distmesh(domain: Domain, spacing: Spacing, h0: float, random: np.random.Generator) -> tuple[Floats, Integers]:
    """Points (n, 2) and triangles (t, 3), from a lattice with distances ``h0`` thinned out by the spacing."""
    fixed = len(domain.boundary.corners)
    points = np.vstack([domain.boundary.corners, _thinned(_lattice(domain, h0), domain, spacing, random)])
    connected_at = np.full_like(points, np.inf)
    for _ in range(STEPS):
        if _longest(points - connected_at) > MOVE_TO_CONNECT * h0:
            connected_at = points
            bars, _ = unique_edges(_connected(points, domain, h0))
        moves = STEP * _forces(points, bars, spacing)
        moves[:fixed] = 0
        points, projected = _kept_inside(points + moves, domain)
        if _longest(moves[~projected]) < MOVE_TO_STOP * h0:
            break
    return points, _connected(points, domain, h0)


def _lattice(domain: Domain, h0: float) -> Floats:
    x0, y0, x1, y1 = domain.bounds
    x, y = np.meshgrid(np.arange(x0, x1, h0), np.arange(y0, y1, h0 * np.sqrt(3) / 2))
    x[1::2] += h0 / 2
    return np.column_stack([x.ravel(), y.ravel()])


def _thinned(points: Floats, domain: Domain, spacing: Spacing, random: np.random.Generator) -> Floats:
    inside = points[domain.contains(points)]
    density = 1 / spacing(inside) ** 2
    return inside[random.random(len(inside)) < density / density.max()]


def _connected(points: Floats, domain: Domain, h0: float) -> Integers:
    """Delaunay triangles with their centroids inside, counter-clockwise."""
    triangles = Delaunay(points).simplices.astype(int)
    triangles = triangles[domain.signed_distance(points[triangles].mean(axis=1)) > MARGIN * h0]
    clockwise = signed_areas(points, triangles) < 0
    triangles[clockwise] = triangles[clockwise, ::-1]
    return triangles


def _forces(points: Floats, bars: Integers, spacing: Spacing) -> Floats:
    """Sum (n, 2) of the forces of the bars, which only push."""
    vectors = points[bars[:, 0]] - points[bars[:, 1]]
    lengths = np.hypot(*vectors.T)
    target = spacing.between(points, bars)
    target *= PRESSURE * np.sqrt((lengths**2).sum() / (target**2).sum())
    push = (np.maximum(target - lengths, 0) / lengths)[:, None] * vectors
    both = np.concatenate([push, -push])
    return np.column_stack([np.bincount(bars.T.ravel(), column, len(points)) for column in both.T])


def _kept_inside(points: Floats, domain: Domain) -> tuple[Floats, Booleans]:
    """The points, those outside moved to the boundary, and which these are."""
    outside = ~domain.contains(points)
    points[outside] = domain.nearest(points[outside]).foot
    return points, outside


def _longest(vectors: Floats) -> float:
    return float(np.hypot(*vectors.T).max(initial=0))
