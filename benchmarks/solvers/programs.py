"""The solvers: what they are run with, and what they print of the common problem."""

import atexit
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

import bubblemesh

SCRIPTS = Path(__file__).parent / "scripts"
SECONDS = 300
BORE = 2 * np.pi * 0.4
RIM = 2 * np.pi
CONDUCTIVITY = 0.78086  # of a square cell of side 1 with a bore of radius 0.2, effective


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
    periodic: "Periodic"
    second: str = "yes"  # what it has of second order; triangles are curved where that is "yes"
    orders: tuple[int, ...] = (1, 2)  # of its elements
    close: float = 4e-3  # error of a right answer of first order, relative


@dataclass(frozen=True)
class Periodic:
    """How a solver is told of periodic sides; ``run`` gives the conductivity of the cell in a folder's ``out``."""

    way: str
    run: Callable[[Path], float]
    close: float = 2e-3  # error of a right answer, relative


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


def environment() -> dict[str, str]:
    """The environment of the programs; OpenFOAM's need a folder, for which Debian's is taken where none is given."""
    return {"WM_PROJECT_DIR": "/usr/share/openfoam", **os.environ}


def printed(line: list[str], folder: Path) -> str:
    """What a program prints, which has to succeed."""
    done = subprocess.run(line, cwd=folder, capture_output=True, text=True, timeout=SECONDS, env=environment())
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


@cache
def dealii_program() -> Path:
    """The folder of the program with deal.II, which is built once and goes when Python ends."""
    cmake, build = program("cmake"), Path(tempfile.mkdtemp())
    atexit.register(shutil.rmtree, build, ignore_errors=True)
    shutil.copytree(SCRIPTS / "dealii", build, dirs_exist_ok=True)
    try:
        printed([cmake, ".", "-DCMAKE_BUILD_TYPE=Release"], build)
    except RuntimeError as error:
        raise NotInstalledError("deal.II") if "deal.II" in str(error) else error from None
    return build


def dealii(folder: Path, order: str = "") -> str:
    """What the program with deal.II prints in a folder; CMake starts it, after it has built it."""
    cmake, build = program("cmake"), dealii_program()
    printed([cmake, ".", f"-DORDER={order}", f"-DFOLDER={folder}"], build)
    return printed([cmake, "--build", ".", "--target", "run"], build)


def openfoam(folder: Path, case: str, *prepare: list[str]) -> str:
    """What laplacianFoam prints of a case, after the steps of the page and those that prepare it."""
    for part in ("common", case):
        shutil.copytree(SCRIPTS / "openfoam" / part, folder, dirs_exist_ok=True)
    lines = [["gmshToFoam", f"out/{case}.msh"]]
    for patch in ("front", "back"):
        lines.append(
            ["foamDictionary", "-entry", f"entry0.{patch}.type", "-set", "empty", "constant/polyMesh/boundary"]
        )
    for name, *words in (*lines, *prepare):
        printed([program(name), *words], folder)
    return printed([program("laplacianFoam")], folder)


def openfoam_ring(folder: Path, order: int) -> Found:
    """OpenFOAM: finite volumes, with the conductivity as a field that is set by cell zones."""
    (mean,) = re.findall(r"areaAverage\(bore\) of T = (\S+)", openfoam(folder, "ring", ["setFields"]))
    mesh = folder / "constant/polyMesh"
    faces = dict(re.findall(r"(\S+)\s*\{[^}]*nFaces\s+(\d+);", (mesh / "boundary").read_text()))
    cells = dict(
        re.findall(r"(\S+)\s*\{\s*type cellZone;\s*cellLabels\s+\S+\s+(\d+)", (mesh / "cellZones").read_text())
    )
    labels, regions = (int(faces["rim"]), int(faces["bore"])), (int(cells["outside"]), int(cells["inside"]))
    return Found(float(mean), labels, regions)


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


def getdp_cell(folder: Path) -> float:
    """GetDP, which links each side to the one that it is a shift of."""
    shutil.copy(SCRIPTS / "cell.pro", folder)
    printed(
        [program("getdp"), "cell.pro", "-msh", "out/cell.msh", "-solve", "Solve", "-pos", "Check", "-v", "2"], folder
    )
    return float((folder / "conductivity.txt").read_text().split()[-1])


def calculix_cell(folder: Path) -> float:
    """CalculiX, by an equation for each pair of nodes: u rises by 1 from left to right; the flux is of its slopes."""
    shutil.copy(SCRIPTS / "cell_calculix.inp", folder)
    mesh = bubblemesh.mesh_case(bubblemesh.load_case(folder / "cell.yaml")).mesh
    (folder / "equations.inp").write_text("".join(equations(mesh)))
    if "*ERROR" in printed([program("ccx"), "cell_calculix"], folder):
        raise RuntimeError("ccx reports an error")
    rows = re.findall(r"^ +\d+ +([-\d.E+]+)$", (folder / "cell_calculix.dat").read_text(), flags=re.M)
    u, corners = np.array(rows, float)[mesh.triangles], mesh.points[mesh.triangles]
    heights = np.roll(corners, -1, axis=1)[:, :, 1] - np.roll(corners, 1, axis=1)[:, :, 1]
    return float((u * heights).sum() / 2)


def equations(mesh: bubblemesh.Mesh) -> list[str]:
    """Equations of CalculiX for pairs of nodes; node 1 is a corner with u = 0, and u at node 2 is the rise."""
    upwards, across = (sides.nodes + 1 for sides in mesh.periodic_sides)
    terms = [((b, 1), (a, -1), (2, -1)) for a, b in across if b != 2]
    terms += [((b, 1), (a, -1)) for a, b in upwards if a != 2]
    return [f"*EQUATION\n{len(each)}\n" + "".join(f"{node}, 11, {c}\n" for node, c in each) for each in terms]


def openfoam_cell(folder: Path) -> float:
    """OpenFOAM, by cyclic patches across which the temperature jumps by 1; the flux is of its mean slope."""
    text = openfoam(folder, "cell", ["createPatch", "-overwrite"])
    (slope,) = re.findall(r"volAverage\(\w+\) of grad\(T\) = \((\S+)", text)
    return float(slope) * json.loads((folder / "out/cell.report.json").read_text())["area"]


PAIRS, PLACES, LABELS, SHIFTED = "by pairs of nodes", "by places of nodes", "by labels", "by labels and shift"
SKFEM_CELL = Periodic(PAIRS, cell_in_python("cell_scikit_fem.py", "skfem", "bubblemesh"))
FENICSX_CELL = Periodic(PLACES, cell_in_python("cell_fenicsx.py", "dolfinx", "petsc4py"))
MFEM_CELL = Periodic(PAIRS, cell_in_python("cell_mfem.py", "mfem.ser"))
NGSOLVE_CELL = Periodic(PAIRS, cell_in_python("cell_ngsolve.py", "ngsolve", "netgen.read_gmsh"))
SFEPY_CELL = Periodic(PLACES, cell_in_python("cell_sfepy.py", "sfepy"))
DEALII_CELL = Periodic(PLACES, lambda folder: conductivity(dealii(folder)))
OPENFOAM_CELL = Periodic("cyclic patches", openfoam_cell, close=1e-2)
STRAIGHT = "straight sides"
SOLVERS: Mapping[str, Solver] = {
    "scikit-fem": Solver("scikit-fem", in_python("scikit_fem.py", "skfem"), SKFEM_CELL),
    "fenicsx": Solver("FEniCSx", in_python("fenicsx.py", "dolfinx", "petsc4py"), FENICSX_CELL),
    "mfem": Solver("MFEM", in_python("mfem_poisson.py", "mfem.ser"), MFEM_CELL),
    "ngsolve": Solver(
        "NGSolve", in_python("ngsolve_poisson.py", "ngsolve", "netgen.read_gmsh"), NGSOLVE_CELL, STRAIGHT
    ),
    "sfepy": Solver("SfePy", in_python("sfepy_poisson.py", "sfepy"), SFEPY_CELL, STRAIGHT),
    "freefem": Solver("FreeFEM", freefem, Periodic(LABELS, freefem_cell), STRAIGHT),
    "getdp": Solver("GetDP", getdp, Periodic(SHIFTED, getdp_cell)),
    "calculix": Solver("CalculiX", calculix, Periodic(PAIRS, calculix_cell)),
    "dealii": Solver("deal.II", lambda folder, order: found(dealii(folder, str(order))), DEALII_CELL, STRAIGHT),
    "openfoam": Solver("OpenFOAM", openfoam_ring, OPENFOAM_CELL, "no: finite volumes", orders=(1,), close=1e-2),
}
