"""Adaptive against uniform meshes, by the Poisson equation on a domain with a re-entrant corner.

``python -m benchmarks.adaptivity`` renews the table of docs/adaptivity.md and its plot.
"""

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from skfem import Basis, ElementTriP1, MeshTri, condense, solve
from skfem.models.poisson import laplace

import bubblemesh
from benchmarks.ablation import renewed
from benchmarks.light import save
from bubblemesh.adaptivity.estimate import true_error
from bubblemesh.arrays import Floats

PAGE = Path(__file__).parents[1] / "docs" / "adaptivity.md"
PLOT = PAGE.parent / "figures" / "adaptivity.png"
BEGIN, END = "<!-- adaptivity: begin -->", "<!-- adaptivity: end -->"
CASE = """
name: l-shape
domain: {outer: {polygon: [[0, 0], [0, -1], [1, -1], [1, 1], [-1, 1], [-1, 0]]}}
spacing: 0.25
"""
INK, OURS = "#22303c", "#d1495b"


@dataclass(frozen=True)
class Step:
    """A mesh, the true error of the solution on it, and the estimated one in terms of it."""

    mesh: bubblemesh.Mesh
    error: float
    effectivity: float

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return len(self.mesh.points)


def main() -> None:
    """Run both series and renew the page."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.adaptivity", description=__doc__)
    parser.add_argument("--loops", type=int, default=8, help="adaptive meshes, each of twice as many nodes")
    loops = parser.parse_args().loops
    adapted = adaptive(loops)
    even = uniform([0.25 / 2**k for k in range((loops + 1) // 2 + 1)])
    PAGE.write_text(renewed(PAGE.read_text(), table(adapted, even), BEGIN, END))
    draw(adapted, even, PLOT)


def singular(x: Floats, y: Floats) -> Floats:
    """The solution r^(2/3) sin(2/3 phi), whose gradient is infinite in the corner; phi counts from one of its sides."""
    phi = np.arctan2(y, x) + np.pi / 2
    return np.hypot(x, y) ** (2 / 3) * np.sin(2 / 3 * np.where(phi < -1e-9, phi + 2 * np.pi, phi))


def solved(mesh: bubblemesh.Mesh) -> Floats:
    """Nodal values of the linear finite element solution with the exact values on the boundary."""
    basis = Basis(MeshTri(mesh.points.T.copy(), mesh.triangles.T.copy()), ElementTriP1())
    inner = basis.complement_dofs(basis.get_dofs())
    return solve(*condense(laplace.assemble(basis), x=singular(*mesh.points.T), I=inner))


def adaptive(loops: int) -> list[Step]:
    """Meshes adapted to the solution, each of twice as many nodes as the one before."""
    case = bubblemesh.load_case("-", text=CASE)
    mesh, steps = bubblemesh.mesh_case(case).mesh, []
    for _ in range(loops):
        solution = bubblemesh.Solution.of(mesh.points, mesh.triangles, solved(mesh))
        result = bubblemesh.adapt(case, solution, nodes=2 * len(mesh.points))
        error = true_error(mesh.points, mesh.triangles, solution.values[:, 0], singular)
        steps.append(Step(mesh, error, result.report["adaptation"]["error"] / error))
        print(f"adaptive: {steps[-1].nodes} nodes", file=sys.stderr)
        mesh = result.mesh
    return steps


def uniform(sizes: list[float]) -> list[Step]:
    """Meshes of one size everywhere."""
    steps = []
    for size in sizes:
        case = bubblemesh.load_case("-", text=CASE, overrides=[f"spacing={size}"])
        mesh = bubblemesh.mesh_case(case).mesh
        error = true_error(mesh.points, mesh.triangles, solved(mesh), singular)
        steps.append(Step(mesh, error, np.nan))
        print(f"uniform: {steps[-1].nodes} nodes", file=sys.stderr)
    return steps


def order(steps: list[Step]) -> float:
    """Observed power of the number of nodes with which the error falls, from the second half of the steps."""
    last = steps[len(steps) // 2 :]
    return float(np.polyfit(np.log([step.nodes for step in last]), np.log([step.error for step in last]), 1)[0])


def table(adapted: list[Step], even: list[Step]) -> str:
    """Both series, and their orders."""
    lines = ["| nodes, adaptive | error | estimated / true | nodes, uniform | error |", "|---|---|---|---|---|"]
    for k, step in enumerate(adapted):
        other = f"{even[k].nodes} | {even[k].error:.4f}" if k < len(even) else " | "
        lines.append(f"| {step.nodes} | {step.error:.4f} | {step.effectivity:.3f} | {other} |")
    lines.append(f"| order | {order(adapted):.2f} | | | {order(even):.2f} |")
    return "\n".join(lines) + "\n"


def draw(adapted: list[Step], even: list[Step], path: Path) -> None:
    """An adapted mesh, and the errors of both series against their numbers of nodes."""
    figure = Figure(figsize=(9, 4.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    shown = min(adapted, key=lambda step: abs(step.nodes - 600))
    left.triplot(*shown.mesh.points.T, shown.mesh.triangles, color=INK, linewidth=0.3)
    left.set_aspect("equal")
    left.set_axis_off()
    left.set_title(f"{shown.nodes} nodes", color=INK, fontsize=10)
    right.set(xscale="log", yscale="log", xlabel="nodes", ylabel="error of the gradient")
    for steps, color, marker, name in ((even, INK, "s", "uniform"), (adapted, OURS, "o", "adaptive")):
        nodes, errors = np.array([(step.nodes, step.error) for step in steps]).T
        right.plot(nodes, errors, color=color, marker=marker, markersize=4, label=f"{name}, order {order(steps):.2f}")
    ends = np.array([adapted[1].nodes, adapted[-1].nodes])
    for power, name, style in ((-1 / 3, "-1/3", ":"), (-1 / 2, "-1/2", "--")):
        right.plot(
            ends, 1.3 * adapted[1].error * (ends / ends[0]) ** power, color="#8a97a3", linestyle=style, label=name
        )
    right.legend(frameon=False, fontsize=9)
    save(figure, path)


if __name__ == "__main__":
    main()
