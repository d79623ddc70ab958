"""JIGSAW (D. Engwirda), by its executable and its text files, where one is installed."""

import shutil
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.peers.clock import Clock
from bubblemesh.arrays import Floats, Integers
from bubblemesh.case import Case
from bubblemesh.problem.prepare import prepare
from bubblemesh.problem.problem import Problem

COMMAND = "jigsaw"
GRID = 500  # intervals of the grid that tells the spacing, along each side of the domain's box
SETTINGS = """\
GEOM_FILE = {folder}/outline.msh
HFUN_FILE = {folder}/spacing.msh
MESH_FILE = {folder}/mesh.msh
HFUN_SCAL = absolute
HFUN_HMAX = {largest:.17g}
HFUN_HMIN = 0
MESH_DIMS = 2
MESH_TOP1 = true
GEOM_FEAT = true
NUMTHREAD = 1
"""


def installed() -> bool:
    """Whether there is an executable on the PATH."""
    return shutil.which(COMMAND) is not None


def mesh(case: Case, clock: Clock) -> tuple[Floats, Integers]:
    """Points (n, 2) and triangles (t, 3) with the default settings; the time includes reading and writing files."""
    if not installed():
        raise FileNotFoundError(f"no executable {COMMAND} on the PATH")
    problem = prepare(case)
    with TemporaryDirectory() as name:
        folder = Path(name)
        largest = _write_spacing(problem, folder / "spacing.msh")
        _write_outline(problem, folder / "outline.msh")
        settings = folder / "settings.jig"
        settings.write_text(SETTINGS.format(folder=folder, largest=largest))
        with clock:
            subprocess.run([COMMAND, str(settings)], check=True, capture_output=True)
        return read_mesh(folder / "mesh.msh")


def _write_outline(problem: Problem, path: Path) -> None:
    line = problem.domain.polygonal_copy
    edges = np.column_stack([np.arange(len(line.points)), line.successor])
    with path.open("w") as file:
        file.write(f"MSHID=3;EUCLIDEAN-MESH\nNDIMS=2\nPOINT={len(line.points)}\n")
        np.savetxt(file, np.column_stack([line.points, np.zeros(len(edges))]), ["%.17g", "%.17g", "%d"], ";")
        file.write(f"EDGE2={len(edges)}\n")
        np.savetxt(file, np.column_stack([edges, np.zeros(len(edges), int)]), "%d", ";")


def _write_spacing(problem: Problem, path: Path) -> float:
    """Write the spacing on a grid, y running faster; return its largest value."""
    x0, y0, x1, y1 = problem.domain.bounds
    x, y = np.linspace(x0, x1, GRID + 1), np.linspace(y0, y1, GRID + 1)
    d = problem.spacing.extended(np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2))
    with path.open("w") as file:
        file.write("MSHID=3;EUCLIDEAN-GRID\nNDIMS=2\n")
        for number, column in ((1, x), (2, y)):
            file.write(f"COORD={number};{len(column)}\n")
            np.savetxt(file, column, "%.17g")
        file.write(f"VALUE={len(d)};1\n")
        np.savetxt(file, d, "%.9g")
    return float(d.max())


def read_mesh(path: Path) -> tuple[Floats, Integers]:
    """Points (n, 2) and triangles (t, 3) of a file of JIGSAW's, without nodes of no triangle."""
    sections: dict[str, list[str]] = {}
    lines = iter(path.read_text().splitlines())
    for line in lines:
        name, _, size = line.strip().upper().partition("=")
        if name in ("POINT", "TRIA3", "EDGE2"):
            sections[name] = [next(lines) for _ in range(int(size))]
    points, triangles = (np.loadtxt(sections[name], delimiter=";", ndmin=2) for name in ("POINT", "TRIA3"))
    used, corners = np.unique(triangles[:, :3].astype(int), return_inverse=True)
    return points[used, :2], corners.reshape(-1, 3)
