"""Gradients at walls that are known exactly: nodes that layers and isotropic meshes need for them."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from math import inf

import numpy as np
from skfem import Basis, BilinearForm, ElementTriP1, ElementTriP2, FacetBasis, LinearForm, MeshTri, condense, solve
from skfem.helpers import dot, grad

from benchmarks.layers.shapes import Keys
from bubblemesh.arrays import Floats
from bubblemesh.case import load_case
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.run.pipeline import mesh_case

CLOSE = 0.01  # relative error of the gradient, on the worst edge of the wall
FINER = 0.8  # size at the wall from one mesh to the next
MOST = 200_000  # nodes
DELTA = 0.01  # thickness of the plate's layer
ELEMENTS = {1: ElementTriP1, 2: ElementTriP2}


@dataclass(frozen=True)
class Flow:
    """A flow along walls at which the gradient of its velocity u is 1, in units of its own.

    Attributes
    ----------
    name : str
    length, height : float
        Of the rectangle; its lower side is a wall.
    walls : tuple of str
        Labels of the sides below, on the right, above and on the left.
    suction : float
        Velocity into the lower wall over the viscosity.
    source : float
        Pressure gradient over the viscosity.
    exact : callable
        u at heights above the lower wall.
    order : int
        Of the elements.
    coarse : float
        Spacing far from the wall.
    start : float
        Size at the wall to begin with.
    """

    name: str
    length: float
    height: float
    walls: tuple[str, str, str, str]
    suction: float
    source: float
    exact: Callable[[Floats], Floats]
    order: int
    coarse: float
    start: float


def _suction_profile(y: Floats) -> Floats:
    """The asymptotic suction profile: an exact solution of the equations of Navier and Stokes along a flat plate."""
    return DELTA * (1 - np.exp(-y / DELTA))


CHANNEL = ("wall", "outlet", "wall", "inlet")
PLATE = ("wall", "outlet", "top", "inlet")
FLOWS = (
    Flow("laminar channel, linear", 4, 1, CHANNEL, 0, 2, lambda y: y * (1 - y), 1, 0.2, 0.05),
    Flow("flat plate with suction, linear", 2, 1, PLATE, 1 / DELTA, 0, _suction_profile, 1, 0.1, DELTA),
    Flow("flat plate with suction, quadratic", 2, 1, PLATE, 1 / DELTA, 0, _suction_profile, 2, 0.1, DELTA),
)


@dataclass(frozen=True)
class Needed:
    """The coarsest mesh that has the gradient: its size at the wall, its nodes, and the error of the worst edge."""

    size: float
    nodes: int
    error: float


def with_layers(flow: Flow, size: float) -> Keys:
    """The case with layers of a first height."""
    layers = [{"on": "wall", "first": size, "growth": 1.2, "until": "isotropic"}]
    return {"domain": _rectangle(flow), "spacing": flow.coarse, "layers": layers}


def isotropic(flow: Flow, size: float) -> Keys:
    """The case with a spacing at the wall that grows by a fifth from row to row."""
    near = [{"label": "wall", "size": size, "growth": 0.2}]
    return {"domain": _rectangle(flow), "spacing": {"near": near, "maximum": flow.coarse}}


def needed(flow: Flow, made: Callable[[Flow, float], Keys], most: int = MOST) -> Needed:
    """The first mesh of a series of finer ones whose error is at most 1 %, or the last one of at most so many nodes."""
    size, found = flow.start, Needed(inf, 0, inf)
    while found.error > CLOSE and found.nodes < most:
        mesh = mesh_case(load_case("flow.yaml", text=json.dumps(made(flow, size)))).mesh
        found = Needed(size, len(mesh.points), error(flow, mesh))
        size *= FINER
    return found


def error(flow: Flow, mesh: Mesh) -> float:
    """Largest relative error of the gradient at the lower wall, of the means on its edges."""
    grid = MeshTri(mesh.points.T.copy(), mesh.triangles.T.copy())
    basis = Basis(grid, ELEMENTS[flow.order]())
    on = {
        label: basis.get_dofs(grid.facets_satisfying(lambda x, at=at: np.isclose(x[1], at))).flatten()
        for label, at in (("below", 0.0), ("above", flow.height))
    }
    u = np.zeros(basis.N)
    u[on["above"]] = flow.exact(np.array([flow.height]))
    matrix = BilinearForm(lambda u, v, _: dot(grad(u), grad(v)) - flow.suction * grad(u)[1] * v).assemble(basis)
    load = LinearForm(lambda v, _: flow.source * v).assemble(basis)
    u = solve(*condense(matrix, load, x=u, D=np.concatenate(list(on.values()))))
    wall = FacetBasis(grid, ELEMENTS[flow.order](), facets=grid.facets_satisfying(lambda x: np.isclose(x[1], 0)))
    means = (grad(wall.interpolate(u))[1] * wall.dx).sum(axis=1) / wall.dx.sum(axis=1)
    return float(np.abs(means - 1).max())


def _rectangle(flow: Flow) -> Keys:
    return {"outer": {"rectangle": [0, 0, flow.length, flow.height], "labels": list(flow.walls)}}
