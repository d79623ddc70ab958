"""Netgen (J. Schoeberl): its spline geometry with true arcs, and the spacing as a limit at many points."""

from collections.abc import Iterable
from importlib.util import find_spec
from typing import Any

import numpy as np
import shapely

from benchmarks.peers.clock import Clock
from bubblemesh.arrays import Floats, Integers
from bubblemesh.case import Case
from bubblemesh.geometry.paths import Arc, Area, Line, Ring
from bubblemesh.problem.domain import domain_areas
from bubblemesh.problem.prepare import prepare
from bubblemesh.problem.problem import Problem

GRID = 300  # intervals of the points that tell the spacing, along each side of the domain's box
WIDEST_ARC = np.pi / 2  # of a quadratic spline, which Netgen's weights make a true arc


def installed() -> bool:
    """Whether there is its Python package."""
    return find_spec("netgen") is not None


def mesh(case: Case, clock: Clock) -> tuple[Floats, Integers]:
    """Points (n, 2) and triangles (t, 3) with the default optimization.

    A trial, not counted, tells by how much to lower the sizes for about the ideal number of nodes.
    """
    problem, shape = prepare(case), domain_areas(case.domain)
    trial, _ = _read(_geometry(shape).GenerateMesh(mp=_parameters(problem, 1.0)))
    geometry, parameters = _geometry(shape), _parameters(problem, np.sqrt(len(trial) / problem.survey.ideal_nodes))
    with clock:
        found = geometry.GenerateMesh(mp=parameters)
    return _read(found)


def _parameters(problem: Problem, factor: float) -> Any:
    """Netgen's parameters, with ``factor`` times the spacing as a limit at the points of a grid."""
    from netgen.meshing import MeshingParameters

    x0, y0, x1, y1 = problem.domain.bounds
    points = np.stack(np.meshgrid(np.linspace(x0, x1, GRID + 1), np.linspace(y0, y1, GRID + 1)), axis=-1).reshape(-1, 2)
    points = points[problem.domain.contains(points)]
    d = factor * problem.spacing(points)
    parameters = MeshingParameters(maxh=float(d.max()))
    for (x, y), size in zip(points.tolist(), d.tolist(), strict=True):
        parameters.RestrictH(x, y, 0.0, size)
    return parameters


def _read(mesh: Any) -> tuple[Floats, Integers]:
    """Points (n, 2) and triangles (t, 3) of a mesh, without nodes of no triangle."""
    points, triangles = mesh.Coordinates()[:, :2], mesh.Elements2D().NumPy()["nodes"][:, :3].astype(np.int64) - 1
    used, corners = np.unique(triangles, return_inverse=True)
    return points[used], corners.reshape(-1, 3)


def _geometry(areas: Iterable[Area]) -> Any:
    """Netgen's geometry of areas."""
    from netgen.geom2d import SplineGeometry

    geometry = SplineGeometry()
    for area in areas:
        for number, ring in enumerate(area.rings):
            on_left = shapely.LinearRing(ring.outline).is_ccw == (number == 0)
            _append(geometry, ring, (1, 0) if on_left else (0, 1))
    return geometry


def _append(geometry: Any, ring: Ring, sides: tuple[int, int]) -> None:
    """Append a ring with the numbers of what is on its left and right: 1 for the domain, 0 for nothing."""
    pieces: list[tuple[Floats, Floats | None]] = []  # start, and the middle control point of an arc
    for side in ring.sides:
        match side.curve:
            case Line(start=start):
                pieces.append((np.array(start), None))
            case Arc(center=center, radius=radius, angle=angle, sweep=sweep):
                parts = int(np.ceil(abs(sweep) / WIDEST_ARC * (1 - 1e-12)))
                half = sweep / parts / 2
                for begin in angle + sweep * np.arange(parts) / parts:
                    middle = begin + half
                    pieces.append(
                        (
                            center + radius * np.array([np.cos(begin), np.sin(begin)]),
                            center + radius / np.cos(half) * np.array([np.cos(middle), np.sin(middle)]),
                        )
                    )
            case _:
                raise ValueError(f"a side of the kind {type(side.curve).__name__} is not passed on to Netgen")
    numbers = [geometry.AppendPoint(*start) for start, _ in pieces]
    for first, last, (_, control) in zip(numbers, numbers[1:] + numbers[:1], pieces, strict=True):
        if control is None:
            geometry.Append(["line", first, last], *sides)
        else:
            geometry.Append(["spline3", first, geometry.AppendPoint(*control), last], *sides)
