"""JIGSAW (D. Engwirda), by its executable and its text files, where one is installed."""

import shutil
import subprocess
import sys
from contextlib import redirect_stdout
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from benchmarks.peers.clock import Clock
from bubblemesh.arrays import Floats, Integers
from bubblemesh.case import Case
from bubblemesh.problem.prepare import prepare
from bubblemesh.problem.problem import Problem

COMMAND, PACKAGE = "jigsaw", "jigsawpy"
GRID = 500  # intervals of the grid that tells the spacing, along each side of the domain's box
COARSEST = 1000  # nodes of the first of several levels
TOLERANCE = 1e-8  # of a run of many iterations, which would end after a few of them else


def installed() -> bool:
    """Whether there is an executable on the PATH."""
    return shutil.which(COMMAND) is not None


def restarts_installed() -> bool:
    """Whether there is the Python package too, which starts the executable again and again."""
    return installed() and find_spec(PACKAGE) is not None


def mesh(case: Case, clock: Clock, iterations: int | None = None) -> tuple[Floats, Integers]:
    """Points (n, 2) and triangles (t, 3) with the default settings, or up to that many iterations of its optimization.

    The time includes reading and writing files.
    """
    with TemporaryDirectory() as name:
        folder = Path(name)
        settings = _settings(prepare(case), folder) | (
            {"OPTM_ITER": iterations, "OPTM_QTOL": TOLERANCE} if iterations else {}
        )
        file = folder / "settings.jig"
        file.write_text(
            "".join(f"{key} = {str(value).lower() if value is True else value}\n" for key, value in settings.items())
        )
        with clock:
            subprocess.run([COMMAND, str(file)], check=True, capture_output=True)
        return read_mesh(folder / "mesh.msh")


def mesh_with_restarts(case: Case, clock: Clock) -> tuple[Floats, Integers]:
    """Points (n, 2) and triangles (t, 3) by the package's restarts without irregular nodes, from level to level."""
    import jigsawpy

    problem = prepare(case)
    levels = max(round(np.log(problem.survey.ideal_nodes / COARSEST) / np.log(4)), 0)
    with TemporaryDirectory() as name, redirect_stdout(sys.stderr):
        folder = Path(name)
        options = jigsawpy.jigsaw_jig_t()
        for key, value in (_settings(problem, folder) | {"JCFG_FILE": folder / "settings.jig"}).items():
            setattr(options, key.lower(), str(value) if isinstance(value, Path) else value)
        with clock:
            jigsawpy.cmd.tetris(options, levels)
        return read_mesh(folder / "mesh.msh")


def _settings(problem: Problem, folder: Path) -> dict[str, Any]:
    """Settings of a run in a folder, where the outline and the spacing are written."""
    largest = _write_spacing(problem, folder / "spacing.msh")
    _write_outline(problem, folder / "outline.msh")
    return {
        "GEOM_FILE": folder / "outline.msh",
        "HFUN_FILE": folder / "spacing.msh",
        "MESH_FILE": folder / "mesh.msh",
        "HFUN_SCAL": "absolute",
        "HFUN_HMAX": largest,
        "HFUN_HMIN": 0.0,
        "MESH_DIMS": 2,
        "MESH_TOP1": True,
        "GEOM_FEAT": True,
        "NUMTHREAD": 1,
    }


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
