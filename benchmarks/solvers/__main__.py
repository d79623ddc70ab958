"""The table of docs/solvers.md: ``python -m benchmarks.solvers`` solves one problem in all solvers that are there.

``-o docs/solvers.md`` renews the table on that page; rows of solvers that are missing here are lost by that.

A ring with bore 0.4 and rim 1 is of two materials, which meet in a circle of radius 0.7: k = 1 inside, 10 outside. A
unit flux enters at the bore, and u = 0 at the rim, so that u at the bore is 0.4 (ln(0.7 / 0.4) + ln(1 / 0.7) / 10).
"""

import argparse
import tempfile
from collections.abc import Mapping, Sequence
from math import log
from pathlib import Path
from typing import Any

from benchmarks.ablation import renewed
from benchmarks.solvers.programs import BORE, CONDUCTIVITY, RIM, SOLVERS, Found, NotInstalledError, Solver
from bubblemesh.case import load_case
from bubblemesh.run.output import OutputOptions, destination
from bubblemesh.run.pipeline import mesh_case

BEGIN, END = "<!-- solvers: begin -->", "<!-- solvers: end -->"
EXACT = 0.4 * (log(0.7 / 0.4) + log(1 / 0.7) / 10)
CASE = """
name: ring
domain:
  outer: {circle: {center: [0, 0], radius: 1}, label: rim}
  holes: [{circle: {center: [0, 0], radius: 0.4}, label: bore}]
  region: outside
  regions: [{name: inside, ring: {circle: {center: [0, 0], radius: 0.7}}}]
spacing: {value: 0.08, nodes: 540}
"""
CELL = """
domain:
  outer: {rectangle: [0, 0, 1, 1], labels: [bottom, right, top, left]}
  holes: [{circle: {center: [0.5, 0.5], radius: 0.2}, label: bore}]
  periodic: [[left, right], [bottom, top]]
spacing: 0.05
"""
HEAD = """
| solver | reads | labels | regions | second order | periodic sides | mean of u on the bore, linear | quadratic |
|---|---|---|---|---|---|---|---|
"""


def main(arguments: Sequence[str] | None = None) -> None:
    """Solve the problem in each solver, print the table, and put it on a page if one is given."""
    parser = argparse.ArgumentParser("python -m benchmarks.solvers", description=__doc__)
    parser.add_argument(
        *("-o", "--output"), type=Path, metavar="FILE", help="page whose table is renewed, such as docs/solvers.md"
    )
    page = parser.parse_args(arguments).output
    rows = [row(name, solver) for name, solver in SOLVERS.items()]
    table = f"{HEAD.strip()}\n{''.join(rows)}\nThe exact mean is {EXACT:.6f}.\n"
    print(table)
    if page is not None:
        page.write_text(renewed(page.read_text(), table, BEGIN, END))


def row(name: str, solver: Solver) -> str:
    """A solver's row of the table; of one that is not installed, or fails, it says so."""
    try:
        answers = [solved(name, solver, order) for order in solver.orders]
    except NotInstalledError:
        return f"| {solver.name} | not installed here | | | | | | |\n"
    marks = ["yes" if right else "**no**" for right in answers[0][1:]]
    means = [f"{found.mean:.6f}" for found, *_ in answers] + ["-"] * (2 - len(answers))
    return f"| {' | '.join([solver.name, 'yes', *marks, solver.second, periodic_sides(name, solver), *means])} |\n"


def periodic_sides(name: str, solver: Solver) -> str:
    """How a solver is told of periodic sides, if it finds the conductivity of a periodic cell so."""
    with tempfile.TemporaryDirectory() as folder:
        text = f"{CELL}output: {{for: {name}}}\n"
        (Path(folder) / "cell.yaml").write_text(text)
        case = load_case("cell.yaml", text=text)
        destination(case, "-", OutputOptions(f"{folder}/out/")).write_result(mesh_case(case))
        found = solver.periodic.run(Path(folder))
    return solver.periodic.way if abs(found / CONDUCTIVITY - 1) < solver.periodic.close else "**no**"


def solved(name: str, solver: Solver, order: int) -> tuple[Found, bool, bool]:
    """What a solver finds with elements of an order, and whether labels and regions are those of the mesh."""
    form = order if solver.second == "yes" else 1
    with tempfile.TemporaryDirectory() as folder:
        text = f"{CASE}output: {{for: {name}, order: {form}}}\n"
        case = load_case("ring.yaml", text=text)
        result = mesh_case(case)
        report = destination(case, "-", OutputOptions(f"{folder}/out/")).write_result(result)
        found = solver.run(Path(folder), order)
    return found, *agreement(report, found)


def agreement(report: Mapping[str, Any], found: Found) -> tuple[bool, bool]:
    """Whether a solver found the labels and regions of the mesh, by counts or by measures."""
    triangles, edges = report["triangles"], report["boundary_nodes"]
    counts = sum(found.labels) in (edges, 2 * edges)  # of edges, or of nodes of second order
    lengths = all(abs(a / b - 1) < 0.01 for a, b in zip(found.labels, (RIM, BORE), strict=True))
    areas = abs(sum(found.regions) / report["area"] - 1) < 0.01
    return counts or lengths, sum(found.regions) == triangles or areas


if __name__ == "__main__":
    main()
