"""Packing in a metric in figures: ``python -m benchmarks.metric --mmg PYTHON --bamg EXE`` prints the table as Markdown.

The options name an interpreter that has NumPy and mmgpy, and the program bamg of FreeFEM; without them there is
bubblemesh alone, of which figures are means over several seeds. Times are medians of those of the processor: of the
packing, and of six passes of Mmg2D and of BAMG, the latter with the files that it reads and writes.
"""

import argparse
import os
import subprocess
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import fields
from pathlib import Path
from statistics import fmean, median

import numpy as np

from benchmarks.metric.problems import PROBLEMS, Array, Figures, Problem, figures
from benchmarks.metric.with_bamg import with_bamg
from bubblemesh.case.models import Case
from bubblemesh.problem.prepare import prepare
from bubblemesh.run.pipeline import mesh_problem

ROOT = Path(__file__).parents[2]
REPEATS = 3  # of the others, for their time
HEAD = "| metric | tool | nodes | of the ideal | mean q | 1 % q | least q | edges in [.71, 1.41] | processor time |"


def with_bubblemesh(problem: Problem, seed: int) -> tuple[Array, Array, float]:
    """Points, triangles and seconds of the packing."""
    prepared = prepare(Case.model_validate({**problem.case, "packing": {"seed": seed}}))
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


def rows(mmg: str | None, bamg: str | None, seeds: int) -> Iterator[str]:
    """Lines of the table; those of bubblemesh, which alone knows chance, have means over some seeds."""
    yield HEAD
    yield "|---" * HEAD.count(" | ") + "|---|"
    for number, problem in enumerate(PROBLEMS):
        tools = {"bubblemesh": [with_bubblemesh(problem, seed) for seed in range(seeds)]}
        if mmg is not None:
            tools["Mmg2D"] = [with_mmg(mmg, number) for _ in range(REPEATS)]
        if bamg is not None:
            tools["BAMG"] = [with_bamg(bamg, problem) for _ in range(REPEATS)]
        for tool, runs in tools.items():
            found = [figures(problem, points, triangles) for points, triangles, _ in runs]
            yield row(problem.name, tool, mean(found), median(seconds for _, _, seconds in runs))


def mean(several: Sequence[Figures]) -> Figures:
    """Each of the figures as its mean, but for the number of inverted triangles, which is that of all."""
    means = {field.name: fmean(getattr(one, field.name) for one in several) for field in fields(Figures)}
    return Figures(**means | {"inverted": sum(one.inverted for one in several)})


def row(name: str, tool: str, found: Figures, seconds: float) -> str:
    """A line of the table; inverted triangles, if there are any, are told."""
    inverted = f" ({found.inverted} inverted)" if found.inverted else ""
    return (
        f"| {name} | {tool} | {found.nodes:.0f} | {found.nodes / found.ideal:.3f} | {found.mean:.3f} | "
        f"{found.p01:.3f} | {found.least:.3f}{inverted} | {found.within:.1%} | {seconds:.2f} s |"
    )


def main() -> None:
    """Mesh all problems and print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.metric", description=__doc__)
    parser.add_argument("--mmg", metavar="PYTHON", help="interpreter that has mmgpy")
    parser.add_argument("--bamg", metavar="EXE", help="program bamg")
    parser.add_argument("--seeds", metavar="N", type=int, default=8, help="runs of bubblemesh for means [8]")
    options = parser.parse_args()
    for line in rows(options.mmg, options.bamg, options.seeds):
        print(line, flush=True)


if __name__ == "__main__":
    main()
