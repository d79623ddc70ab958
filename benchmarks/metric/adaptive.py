"""Adaptive meshes with and without direction: ``python -m benchmarks.metric.adaptive --mmg PYTHON`` prints the tables.

Two problems with known solutions are solved by linear elements on meshes that follow the solution, again and again: an
interior layer of the Poisson equation, and boundary layers of convection and diffusion. Mmg2D takes part with the same
metric, by an interpreter that has NumPy and mmgpy.
"""

import argparse
import os
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from skfem import Basis, BilinearForm, ElementTriP1, Functional, LinearForm, MeshTri, condense, solve
from skfem.helpers import dot, grad

import bubblemesh
from benchmarks.metric.problems import Array
from bubblemesh.adaptivity.in_metric import GROWTH_IN_METRIC, MOST_ASPECT
from bubblemesh.adaptivity.metric import best_metric, scaled_for
from bubblemesh.spacing.metric.gradation import graded

ROOT = Path(__file__).parents[2]
CASE = """
name: adaptive
domain: {outer: {rectangle: [0, 0, 1, 1]}}
spacing: {value: 0.07, minimum: 1.0e-5, maximum: 0.2}
"""
NODES = (300, 300, 450, 450, 700, 700, 1100, 1100, 1700, 1700)
MMG = """
import sys, numpy as np
from mmgpy import MmgMesh2D
data = np.load(sys.argv[1])
mesh = MmgMesh2D(data["points"], data["triangles"].astype(np.int32))
mesh["tensor"] = data["tensors"]
mesh.remesh(verbose=-1, hgrad=-1.0)
np.savez(sys.argv[1], points=mesh.get_vertices(), triangles=mesh.get_triangles())
"""


@dataclass(frozen=True)
class Equation:
    """The equation -diffusion * Laplacian of u + flow * gradient of u = source, with a known solution."""

    name: str
    diffusion: float
    flow: tuple[float, float]
    solution: Callable[[Any, Any], Any]
    gradient: Callable[[Any, Any], Any]
    source: Callable[[Any, Any], Any]


def interior(width: float = 0.02) -> Equation:
    """A layer along y = 0.5 + 0.2 sin 2 pi x."""

    def parts(x: Any, y: Any) -> tuple[Any, Any]:
        t = np.tanh((y - 0.5 - 0.2 * np.sin(2 * np.pi * x)) / width)
        return t, (1 - t * t) / width

    def gradient(x: Any, y: Any) -> Any:
        slope = parts(x, y)[1]
        return np.array([-0.4 * np.pi * np.cos(2 * np.pi * x) * slope, slope])

    def source(x: Any, y: Any) -> Any:
        t, slope = parts(x, y)
        sx, sxx = -0.4 * np.pi * np.cos(2 * np.pi * x), 0.8 * np.pi**2 * np.sin(2 * np.pi * x)
        return 2 * t * slope / width * (sx * sx + 1) - slope * sxx

    return Equation("interior layer", 1.0, (0.0, 0.0), lambda x, y: parts(x, y)[0], gradient, source)


def boundary(diffusion: float = 0.01) -> Equation:
    """Layers along two sides, towards which the flow goes."""

    def value(t: Any) -> Any:
        return t - (np.exp((t - 1) / diffusion) - np.exp(-1 / diffusion)) / (1 - np.exp(-1 / diffusion))

    def slope(t: Any) -> Any:
        return 1 - np.exp((t - 1) / diffusion) / (diffusion * (1 - np.exp(-1 / diffusion)))

    return Equation(
        "boundary layers",
        diffusion,
        (1.0, 1.0),
        lambda x, y: value(x) * value(y),
        lambda x, y: np.array([slope(x) * value(y), value(x) * slope(y)]),
        lambda x, y: value(x) + value(y),
    )


def solved(equation: Equation, points: Array, triangles: Array) -> tuple[Array, float, float]:
    """Nodal values of the linear elements' solution, and the norms of its error and of that of its gradient."""
    basis = Basis(MeshTri(points.T.copy(), triangles.T.copy()), ElementTriP1(), intorder=8)

    @BilinearForm
    def form(u: Any, v: Any, w: Any) -> Any:
        d = grad(u)
        return equation.diffusion * dot(d, grad(v)) + (equation.flow[0] * d[0] + equation.flow[1] * d[1]) * v

    load = LinearForm(lambda v, w: equation.source(*w.x) * v).assemble(basis)
    u = solve(*condense(form.assemble(basis), load, x=equation.solution(*points.T), D=basis.get_dofs()))
    field = basis.interpolate(u)
    error = Functional(lambda w: (w["u"] - equation.solution(*w.x)) ** 2).assemble(basis, u=field)
    slope = Functional(lambda w: ((w["u"].grad - equation.gradient(*w.x)) ** 2).sum(axis=0)).assemble(basis, u=field)
    return u, float(np.sqrt(error)), float(np.sqrt(slope))


def next_of_bubblemesh(points: Array, triangles: Array, u: Array, nodes: int, anisotropic: bool) -> tuple[Array, Array]:
    """The next mesh by bubblemesh."""
    case = bubblemesh.load_case("-", text=CASE)
    solution = bubblemesh.Solution.of(points, triangles, u)
    mesh = bubblemesh.adapt(case, solution, nodes=nodes, anisotropic=anisotropic).mesh
    return mesh.points, mesh.triangles


def next_of_mmg(python: str, points: Array, triangles: Array, u: Array, nodes: int) -> tuple[Array, Array]:
    """The next mesh by Mmg2D in the metric that bubblemesh would take."""
    best = best_metric(points, triangles, u[:, None])
    tensors = scaled_for(points, triangles, best, nodes, (1e-5, 0.2), MOST_ASPECT)
    tensors = graded(points, triangles, tensors, GROWTH_IN_METRIC)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mesh.npz"
        np.savez(path, points=points, triangles=triangles, tensors=tensors)
        subprocess.run([python, "-c", MMG, str(path)], check=True, capture_output=True, env=dict(os.environ))
        with np.load(path) as data:
            return data["points"], data["triangles"].astype(np.int64)


def rows(equation: Equation, mmg: str | None) -> Iterator[str]:
    """Lines of the table of an equation."""
    yield f"| {equation.name} | nodes | error | error of the gradient |"
    yield "|---|---|---|---|"
    tools: dict[str, Callable[..., tuple[Array, Array]]] = {
        "without direction": lambda p, t, u, n: next_of_bubblemesh(p, t, u, n, False),
        "`--anisotropic`": lambda p, t, u, n: next_of_bubblemesh(p, t, u, n, True),
    }
    if mmg is not None:
        tools["Mmg2D"] = lambda p, t, u, n: next_of_mmg(mmg, p, t, u, n)
    for name, step in tools.items():
        mesh = bubblemesh.mesh_case(bubblemesh.load_case("-", text=CASE)).mesh
        points, triangles = mesh.points, mesh.triangles
        for number, nodes in enumerate(NODES):
            points, triangles = step(points, triangles, solved(equation, points, triangles)[0], nodes)
            if number % 2:  # the first mesh for a number follows a solution on a much coarser one
                _, error, slope = solved(equation, points, triangles)
                yield f"| {name} | {len(points)} | {error:.2e} | {slope:.3g} |"


def main() -> None:
    """Solve both problems and print the tables."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.metric.adaptive", description=__doc__)
    parser.add_argument("--mmg", metavar="PYTHON", help="interpreter that has mmgpy")
    mmg = parser.parse_args().mmg
    for equation in (interior(), boundary()):
        for line in rows(equation, mmg):
            print(line, flush=True)
        print()


if __name__ == "__main__":
    main()
