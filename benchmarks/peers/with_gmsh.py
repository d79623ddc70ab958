"""Gmsh: built-in geometry with true arcs, the spacing as a MathEval field, one thread."""

from collections.abc import Iterator

import numpy as np

from benchmarks.peers.clock import Clock
from benchmarks.peers.gmsh_settings import OPTIONS, TRIANGLE
from benchmarks.peers.matheval import matheval
from bubblemesh.arrays import Floats, Integers
from bubblemesh.case import Case
from bubblemesh.geometry.paths import Arc, Line, Point, Ring
from bubblemesh.problem.domain import domain_areas

WIDEST_ARC = 0.9 * np.pi  # of those that Gmsh's own kernel knows, which have to be less than half a circle


def mesh(case: Case, clock: Clock, algorithm: int, relocations: int = 0) -> tuple[Floats, Integers]:
    """Points (n, 2) and triangles (t, 3) by one of Gmsh's algorithms, and so many steps of Relocate2D."""
    import gmsh

    gmsh.initialize(readConfigFiles=False, interruptible=False)
    for option, value in (OPTIONS | {"Mesh.Algorithm": algorithm}).items():
        gmsh.option.setNumber(option, value)
    for area in domain_areas(case.domain):
        gmsh.model.geo.addPlaneSurface([_loop(gmsh.model.geo, ring) for ring in area.rings])
    gmsh.model.geo.synchronize()
    field = gmsh.model.mesh.field.add("MathEval")
    gmsh.model.mesh.field.setString(field, "F", matheval(str(case.spacing), case.parameters))
    gmsh.model.mesh.field.setAsBackgroundMesh(field)
    with clock:
        gmsh.model.mesh.generate(2)
        if relocations:
            gmsh.model.mesh.optimize("Relocate2D", niter=relocations)
    return _mesh(gmsh.model.mesh)


def _loop(kernel, ring: Ring) -> int:
    starts, centers = zip(*_segments(ring), strict=True)
    points = [kernel.addPoint(*start, 0) for start in starts]
    curves = [
        kernel.addLine(first, last) if center is None else kernel.addCircleArc(first, kernel.addPoint(*center, 0), last)
        for first, center, last in zip(points, centers, points[1:] + points[:1], strict=True)
    ]
    return kernel.addCurveLoop(curves)


def _segments(ring: Ring) -> Iterator[tuple[Point, Point | None]]:
    """Start of each line and arc of a ring, and the arc's center."""
    for side in ring.sides:
        match side.curve:
            case Line(start=start):
                yield start, None
            case Arc(center=(x, y), radius=radius, angle=angle, sweep=sweep):
                parts = int(abs(sweep) / WIDEST_ARC) + 1
                for a in angle + sweep * np.arange(parts) / parts:
                    yield (x + radius * np.cos(a), y + radius * np.sin(a)), (x, y)
            case _:
                raise ValueError(f"a side of the kind {type(side.curve).__name__} is not passed on to Gmsh")


def _mesh(model) -> tuple[Floats, Integers]:
    """What Gmsh holds, without the nodes of no triangle, such as the arcs' centers."""
    tags, coordinates, _ = model.getNodes()
    index = np.zeros(tags.max() + 1, int)
    index[tags] = np.arange(len(tags))
    used, triangles = np.unique(index[model.getElementsByType(TRIANGLE)[1]], return_inverse=True)
    return coordinates.reshape(-1, 3)[used, :2], triangles.reshape(-1, 3)
