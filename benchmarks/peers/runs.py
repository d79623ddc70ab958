"""Runs every tool on every case, each in a process of its own, and measures the meshes."""

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from textwrap import shorten
from time import perf_counter

import numpy as np

from benchmarks.peers.measures import Figures, FlawError, measured
from benchmarks.peers.tools import OURS, TOOLS
from bubblemesh.case import load_case
from bubblemesh.errors import BubblemeshError
from bubblemesh.problem.prepare import prepare
from bubblemesh.problem.problem import Problem

ROOT = Path(__file__).parents[2]
CONFIGS = ROOT / "configs" / "peers"
SIZES = ("example-3", *(f"example-3-{n}" for n in (1000, 2500, 9000, 28000, 87000, 280000, 900000)))
WHOLE = tuple(f"example-{number}" for number in (1, 2, 3, 4))  # also timed from start to end of the process
CASES = (*WHOLE, "dense", "even", "hole", *SIZES[1:])
TIMEOUT = 20 * 60  # seconds
LARGE = 1e5  # nodes, beyond which one run has to do
LONGEST_REASON = 100  # characters
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
NAN = float("nan")


@dataclass(frozen=True)
class Run:
    """One tool on one case, once: its costs and the mesh's figures, or why there are none.

    Attributes
    ----------
    seconds : float
        Processor time of meshing.
    ready_mb, peak_mb : float
        Largest memory of the process before and in the end.
    floor : float
        Processor seconds of one constrained triangulation of the nodes; of this project's runs only.
    """

    seconds: float = NAN
    ready_mb: float = NAN
    peak_mb: float = NAN
    floor: float = NAN
    figures: Figures | None = None
    failure: str = ""


@dataclass(frozen=True)
class CaseRuns:
    """All runs of a case.

    Attributes
    ----------
    ideal_nodes : float
    tools : mapping of str to tuple of Run
        For each tool one run for each repeat, fewer if one failed.
    whole : tuple of float
        Seconds from start to end of the command that meshes and writes files, where measured.
    """

    ideal_nodes: float
    tools: Mapping[str, tuple[Run, ...]]
    whole: tuple[float, ...] = ()


def problems(names: Collection[str], most_nodes: float) -> dict[str, Problem]:
    """The cases of these names that ask for at most so many nodes."""
    found = {name: prepare(load_case(CONFIGS / f"{name}.yaml")) for name in names}
    return {name: problem for name, problem in found.items() if problem.survey.ideal_nodes <= most_nodes}


def ran(problem: Problem, tools: Collection[str], method: str, repeats: int, tell: Callable[[str], None]) -> CaseRuns:
    """Run the tools on a case in turn, several times, a large one once; ``tell`` hears of each run."""
    name, ideal = str(problem.task.name), problem.survey.ideal_nodes
    repeats = repeats if ideal <= LARGE else 1
    found: dict[str, list[Run]] = {tool: [] for tool in tools if ideal <= TOOLS[tool].most_nodes}
    whole = []
    for repeat in range(1, repeats + 1):
        for tool, runs in found.items():
            if runs and runs[-1].failure:
                continue
            runs.append(_run(problem, tool, method))
            tell(f"{name} {repeat}/{repeats} {tool}: {runs[-1].failure or f'{runs[-1].seconds:.3g} s'}")
        if name in WHOLE and OURS in tools:
            whole.append(_whole(name, method))
    return CaseRuns(ideal, {tool: tuple(runs) for tool, runs in found.items()}, tuple(whole))


def _run(problem: Problem, tool: str, method: str) -> Run:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "mesh.npz"
        arguments = [_path(str(problem.task.name)), tool, method, str(file)]
        try:
            costs = _printed([sys.executable, "-m", "benchmarks.peers.one", *arguments])
            with np.load(file) as mesh:
                figures = measured(mesh["points"], mesh["triangles"], problem)
        except (subprocess.SubprocessError, FlawError, BubblemeshError) as error:
            return Run(failure=reason(error))
    return Run(**costs, figures=figures)


def _printed(command: list[str]) -> dict[str, float]:
    """What a process prints in its last line."""
    return json.loads(printed(command, TIMEOUT).splitlines()[-1])


def printed(command: list[str], timeout: float) -> str:
    """What a process with one thread prints; SubprocessError if it fails or takes longer."""
    environment = os.environ | ONE_THREAD
    return subprocess.run(
        command, cwd=ROOT, env=environment, check=True, capture_output=True, text=True, timeout=timeout
    ).stdout


def reason(error: Exception) -> str:
    """Why there is no mesh, in a few words."""
    match error:
        case subprocess.TimeoutExpired(timeout=seconds):
            return f"no mesh within {seconds:g} s"
        case subprocess.CalledProcessError(returncode=code) if code < 0:
            return f"ended by {signal.Signals(-code).name}"
        case subprocess.CalledProcessError(stderr=text, returncode=code):
            last = text.strip().splitlines()[-1] if text.strip() else f"exit code {code}"
            return shorten(last.removeprefix("Exception: "), LONGEST_REASON)
    return str(error)


def _whole(name: str, method: str) -> float:
    """Seconds from start to end of a run of the command line, with all files written; NaN if it fails."""
    command = [sys.executable, "-m", "bubblemesh", "run", _path(name), "--method", method, "--quiet", "-o"]
    with tempfile.TemporaryDirectory() as folder:
        begun = perf_counter()
        try:
            printed([*command, folder], TIMEOUT)
        except subprocess.SubprocessError:
            return NAN
        return perf_counter() - begun


def _path(name: str) -> str:
    return str(CONFIGS / f"{name}.yaml")
