"""What is measured of a mesh, in the same way whoever made it."""

from dataclasses import dataclass

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.meshes.quality import Measures, shape_quality, spacing_fit
from bubblemesh.problem.problem import Problem


class FlawError(Exception):
    """The mesh is none of the domain; the text says why."""


@dataclass(frozen=True)
class Figures:
    """Nodes, quality and fit of the spacing.

    Attributes
    ----------
    nodes : int
    mean, p01, least : float
        Mean, first percentile and minimum of the triangles' radius ratios.
    irregular : float
        Share of inner nodes whose valence is not six.
    edge, spread : float
        Mean and standard deviation of edge length over target spacing.
    astray : float
        Largest distance of a boundary node from the true boundary, over the spacing there.
    """

    nodes: int
    mean: float
    p01: float
    least: float
    irregular: float
    edge: float
    spread: float
    astray: float


def measured(points: Floats, triangles: Integers, problem: Problem) -> Figures:
    """The figures of a mesh.

    Raises
    ------
    FlawError
        If triangles are inverted or flat, or do not join to a surface with the domain's numbers of pieces and holes.
    """
    measures = Measures(points, triangles)
    sides, count = measures.edges
    _require_surface(measures, problem.domain.euler_characteristic)
    shape = shape_quality(measures)
    fit = spacing_fit(points, sides, problem.spacing.between(points, sides))
    rim = points[np.unique(sides[count == 1])]
    astray = problem.domain.nearest(rim).distance / problem.spacing.extended(rim)
    return Figures(
        nodes=len(points),
        mean=shape.mean,
        p01=shape.p01,
        least=shape.min,
        irregular=float("nan") if shape.irregular_fraction is None else shape.irregular_fraction,
        edge=fit.mean,
        spread=fit.std,
        astray=float(astray.max()),
    )


def _require_surface(measures: Measures, euler: int) -> None:
    areas, (sides, count) = measures.signed_areas, measures.edges
    wrong = int((areas * np.sign(areas.sum()) <= 0).sum())
    if wrong:
        raise FlawError(f"{wrong} inverted or flat triangles")
    if count.max() > 2:
        raise FlawError("more than two triangles at an edge")
    if len(measures.points) - len(sides) + len(measures.triangles) != euler:
        raise FlawError("not a surface with the domain's numbers of pieces and holes")
