"""Runs both tools on every shape in turns, each in a process of its own, and measures the meshes."""

import json
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median

import numpy as np

from benchmarks.layers.figures import Figures, measured, wrong
from benchmarks.layers.made import Made
from benchmarks.layers.shapes import shapes
from benchmarks.layers.tools import FANS, OURS, TOOLS
from benchmarks.peers.runs import NAN, printed, reason

TIMEOUT = 60  # seconds


@dataclass(frozen=True)
class Run:
    """One tool on one shape, or why there is no valid mesh.

    Attributes
    ----------
    seconds, bare : float
        Processor time with layers and without.
    program : float
        That of a whole program, from the case to a file; not of Gmsh without fans.
    figures : Figures or None
    failure : str
    """

    seconds: float = NAN
    bare: float = NAN
    program: float = NAN
    figures: Figures | None = None
    failure: str = ""


def run_all(names: Collection[str], repeats: int, tell: Callable[[str], None]) -> dict[str, dict[str, Run]]:
    """Each tool on each shape, whose seconds are medians; ``tell`` hears of each run."""
    found = dict[str, dict[str, Run]]()
    for name in names:
        runs: dict[str, list[Run]] = {tool: [] for tool in TOOLS}
        for _ in range(repeats):
            for tool, mine in runs.items():
                if not (mine and mine[-1].failure):
                    mine.append(run(name, tool))
                    tell(f"{name}, {tool}: {mine[-1].failure or f'{mine[-1].seconds:.3g} s'}")
        found[name] = {
            tool: replace(
                mine[-1],
                seconds=median(each.seconds for each in mine),
                bare=median(each.bare for each in mine),
                program=median(each.program for each in mine),
            )
            for tool, mine in runs.items()
        }
    return found


def run(name: str, tool: str) -> Run:
    """One tool on one shape."""
    keys = shapes()[name]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "mesh.npz"
        command = [sys.executable, "-m", "benchmarks.layers.one", name, tool, str(file)]
        try:
            seconds = map(float, printed(command, TIMEOUT).splitlines()[-1].split())
            program = _program(name, tool)
        except subprocess.SubprocessError as error:
            return Run(failure=reason(error))
        with np.load(file) as arrays:
            made = Made(**arrays)
    faults = wrong(made, keys)
    if faults:
        return Run(failure="; ".join(faults))
    return Run(*seconds, program, measured(made, keys))


def _program(name: str, tool: str) -> float:
    """Processor seconds of a tool as a program of its own, from its start to the file of the mesh."""
    with tempfile.TemporaryDirectory() as folder:
        case, file = Path(folder) / "shape.yaml", Path(folder) / "shape.msh"
        case.write_text(json.dumps(shapes()[name]))
        commands = {
            OURS: ["bubblemesh", "run", str(case), "-q", "-o", str(file)],
            FANS: ["benchmarks.layers.program", str(case), str(file)],
        }
        if tool not in commands:
            return NAN
        before = _of_children()
        printed([sys.executable, "-m", *commands[tool]], TIMEOUT)
        return _of_children() - before


def _of_children() -> float:
    """Processor seconds of all processes that have ended so far."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
