"""The solvers: what they are run with, and what they print of the common problem."""

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

SCRIPTS = Path(__file__).parent / "scripts"
SECONDS = 300
BORE = 2 * np.pi * 0.4
RIM = 2 * np.pi
CONDUCTIVITY = 0.78086  # of a square cell of side 1 with a bore of radius 0.2, effective
CLOSE = 2e-3


class NotInstalledError(Exception):
    """A solver that is not on this machine."""


@dataclass(frozen=True)
class Found:
    """What a solver says of the common problem: numbers of edges, or lengths, of the rim and the bore, and so on."""

    mean: float  # of u on the bore
    labels: tuple[float, ...]  # of the rim and the bore
    regions: tuple[float, ...]  # outside and inside


@dataclass(frozen=True)
class Solver:
    """A row of the table; ``run`` solves in a folder with elements of an order, whose mesh is in ``out``."""

    name: str
    run: Callable[[Path, int], Found]
    curved: bool = True  # whether it takes triangles of second order
    periodic: "Periodic | None" = None


@dataclass(frozen=True)
class Periodic:
    """How a solver is told of periodic sides; ``run`` gives the conductivity of the cell in a folder's ``out``."""

    way: str
    run: Callable[[Path], float]


@cache
def python_with(*modules: str) -> str:
    """A Python that has the modules: this one, or another one on the path."""
    others = [str(Path(folder, "python3")) for folder in os.environ.get("PATH", "").split(os.pathsep)]
    for python in dict.fromkeys((sys.executable, *others, "/usr/bin/python3")):
        line = [python, "-c", "import " + ", ".join(modules)]
        if Path(python).exists() and subprocess.run(line, capture_output=True).returncode == 0:
            return python
    raise NotInstalledError(modules[0])


def program(*names: str) -> str:
    """Path of the first of some programs that is there."""
    for name in names:
        if shutil.which(name):
            return str(shutil.which(name))
    raise NotInstalledError(names[0])


def printed(line: list[str], folder: Path) -> str:
    """What a program prints, which has to succeed."""
    done = subprocess.run(line, cwd=folder, capture_output=True, text=True, timeout=SECONDS)
    if done.returncode != 0:
        raise RuntimeError(f"{line[0]} failed:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


def found(text: str) -> Found:
    """What the scripts print: a line for each figure."""
    numbers = {
        key: tuple(map(float, re.findall(rf"^{key} (.*)$", text, flags=re.M)[-1].split()))
        for key in ("mean", "labels", "regions")
    }
    return Found(numbers["mean"][0], numbers["labels"], numbers["regions"])


def in_python(script: str, *modules: str) -> Callable[[Path, int], Found]:
    """Run a script of this folder in a Python that has the modules."""

    def run(folder: Path, order: int) -> Found:
        shutil.copy(SCRIPTS / script, folder)
        return found(printed([python_with(*modules), script, str(order)], folder))

    return run


def freefem(folder: Path, order: int) -> Found:
    """FreeFEM; elements of second order are on straight triangles."""
    text = (SCRIPTS / "freefem.edp").read_text().replace("ELEMENT", f"P{order}")
    (folder / "ring.edp").write_text(text)
    return found(printed([program("FreeFem++-nw", "FreeFem++"), "-nw", "-v", "0", "ring.edp"], folder))


def getdp(folder: Path, order: int) -> Found:
    """GetDP, which prints integrals to files."""
    shutil.copy(SCRIPTS / "getdp.pro", folder)
    line = [program("getdp"), "getdp.pro", "-msh", "out/ring.msh", "-solve", "Solve", "-pos", "Check", "-v", "2"]
    printed(line, folder)
    names = ("total", "bore", "rim", "outside", "inside")
    total, bore, rim, *areas = (float((folder / f"{name}.txt").read_text().split()[-1]) for name in names)
    return Found(total / bore, (rim, bore), tuple(areas))


def calculix(folder: Path, order: int) -> Found:
    """CalculiX: conduction of heat, with temperatures at the nodes of the bore, whose mean is by length."""
    shutil.copy(SCRIPTS / "calculix.inp", folder)
    if "*ERROR" in printed([program("ccx"), "calculix"], folder):
        raise RuntimeError("ccx reports an error")
    rows = re.findall(r"^ +(\d+) +([-\d.E+]+)$", (folder / "calculix.dat").read_text(), flags=re.M)
    text = (folder / "out/ring.inp").read_text()
    sets = {
        name: len(re.findall(r"\d+", body))
        for name, body in re.findall(r"^\*NSET, NSET=(\w+)\n(.*?)(?=^\*)", text, flags=re.M | re.S)
    }
    cells = {
        name: len(body.splitlines())
        for name, body in re.findall(r"^\*ELEMENT, TYPE=\w+, ELSET=(\w+)\n(.*?)(?=^\*)", text, flags=re.M | re.S)
    }
    if len(rows) != sets["bore"]:
        raise RuntimeError(f"ccx prints {len(rows)} temperatures of {sets['bore']}")
    mean = np.mean([float(value) for _, value in rows])
    return Found(float(mean), (sets["rim"], sets["bore"]), (cells["outside"], cells["inside"]))


def conductivity(text: str) -> float:
    """What the scripts of the periodic cell print."""
    return float(re.findall(r"^conductivity (\S+)", text, flags=re.M)[-1])


def cell_in_python(script: str, *modules: str) -> Callable[[Path], float]:
    """Run a script of this folder on the periodic cell, in a Python that has the modules."""

    def run(folder: Path) -> float:
        shutil.copy(SCRIPTS / script, folder)
        return conductivity(printed([python_with(*modules), script], folder))

    return run


def freefem_cell(folder: Path) -> float:
    """FreeFEM, which is told the labels of sides that belong together."""
    shutil.copy(SCRIPTS / "cell.edp", folder)
    return conductivity(printed([program("FreeFem++-nw", "FreeFem++"), "-nw", "-v", "0", "cell.edp"], folder))


PAIRS = "by pairs of nodes"
SKFEM_CELL = Periodic(PAIRS, cell_in_python("cell_scikit_fem.py", "skfem", "bubblemesh"))
MFEM_CELL = Periodic(PAIRS, cell_in_python("cell_mfem.py", "mfem.ser"))
FREEFEM_CELL = Periodic("by labels", freefem_cell)
SOLVERS: Mapping[str, Solver] = {
    "scikit-fem": Solver("scikit-fem", in_python("scikit_fem.py", "skfem"), periodic=SKFEM_CELL),
    "fenicsx": Solver("FEniCSx", in_python("fenicsx.py", "dolfinx", "petsc4py")),
    "mfem": Solver("MFEM", in_python("mfem_poisson.py", "mfem.ser"), periodic=MFEM_CELL),
    "ngsolve": Solver("NGSolve", in_python("ngsolve_poisson.py", "ngsolve", "netgen.read_gmsh"), curved=False),
    "sfepy": Solver("SfePy", in_python("sfepy_poisson.py", "sfepy"), curved=False),
    "freefem": Solver("FreeFEM", freefem, curved=False, periodic=FREEFEM_CELL),
    "getdp": Solver("GetDP", getdp),
    "calculix": Solver("CalculiX", calculix),
}
