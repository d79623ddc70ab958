"""Packing in a metric in figures: ``python -m benchmarks.metric --mmg PYTHON --bamg EXE`` prints the table as Markdown.

The options name an interpreter that has NumPy and mmgpy, and the program bamg of FreeFEM; without them there is
bubblemesh alone. Times are those of the processor: of the packing, and of six passes of Mmg2D and of BAMG, the latter
with the files that it reads and writes.
"""

import argparse
import os
import subprocess
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.metric.problems import PROBLEMS, Array, Figures, Problem, figures
from benchmarks.metric.with_bamg import with_bamg
from bubblemesh.case.models import Case
from bubblemesh.problem.prepare import prepare
from bubblemesh.run.pipeline import mesh_problem

ROOT = Path(__file__).parents[2]
HEAD = "| metric | tool | nodes | of the ideal | mean q | 1 % q | least q | edges in [.71, 1.41] | processor time |"


def with_bubblemesh(problem: Problem) -> tuple[Array, Array, float]:
    """Points, triangles and seconds of the packing."""
    prepared = prepare(Case.model_validate(problem.case))
    begun = time.process_time()
    mesh = mesh_problem(prepared).mesh
    return mesh.points, mesh.triangles, time.process_time() - begun


def with_mmg(python: str, number: int) -> tuple[Array, Array, float]:
    """Points, triangles and seconds of Mmg2D, by another interpreter."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mesh.npz"
        command = [python, "-m", "benchmarks.metric.with_mmg", str(number), str(path)]
        subprocess.run(command, check=True, cwd=ROOT, env=os.environ | {"PYTHONPATH": str(ROOT)}, capture_output=True)
        with np.load(path) as data:
            return data["points"], data["triangles"], float(data["seconds"])


def rows(mmg: str | None, bamg: str | None) -> Iterator[str]:
    """Lines of the table."""
    yield HEAD
    yield "|---" * HEAD.count(" | ") + "|---|"
    for number, problem in enumerate(PROBLEMS):
        tools = {"bubblemesh": with_bubblemesh(problem)}
        if mmg is not None:
            tools["Mmg2D"] = with_mmg(mmg, number)
        if bamg is not None:
            tools["BAMG"] = with_bamg(bamg, problem)
        for tool, (points, triangles, seconds) in tools.items():
            yield row(problem.name, tool, figures(problem, points, triangles), seconds)


def row(name: str, tool: str, found: Figures, seconds: float) -> str:
    """A line of the table; inverted triangles, if there are any, are told."""
    inverted = f" ({found.inverted} inverted)" if found.inverted else ""
    return (
        f"| {name} | {tool} | {found.nodes} | {found.nodes / found.ideal:.3f} | {found.mean:.3f} | {found.p01:.3f} | "
        f"{found.least:.3f}{inverted} | {found.within:.1%} | {seconds:.2f} s |"
    )


def main() -> None:
    """Mesh all problems and print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.metric", description=__doc__)
    parser.add_argument("--mmg", metavar="PYTHON", help="interpreter that has mmgpy")
    parser.add_argument("--bamg", metavar="EXE", help="program bamg")
    options = parser.parse_args()
    for line in rows(options.mmg, options.bamg):
        print(line, flush=True)


if __name__ == "__main__":
    main()
