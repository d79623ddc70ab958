"""A profile with layers, written for SU2 and OpenFOAM, read back, and checked by OpenFOAM's own program."""

import json
import re
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.layers.shapes import around, naca, smooth_ring
from benchmarks.solvers.programs import SCRIPTS, NotInstalledError, printed, program
from bubblemesh.arrays import Floats
from bubblemesh.case import load_case
from bubblemesh.run.output import OutputOptions, destination
from bubblemesh.run.pipeline import mesh_case

NAME = "naca0012"
CORNERS = {5: 3, 9: 4}  # by SU2's numbers of triangles and quadrilaterals
CONTROL = """FoamFile { version 2.0; format ascii; class dictionary; object controlDict; }
startFrom startTime; startTime 0; stopAt endTime; endTime 1; deltaT 1; writeInterval 1; writePrecision 16;
"""


@dataclass(frozen=True)
class Written:
    """What a file holds: numbers of nodes, of cells, and of edges by their labels, and the area of the cells."""

    nodes: int
    cells: int
    markers: dict[str, int]
    area: float


@dataclass(frozen=True)
class Checked:
    """What OpenFOAM's checkMesh says.

    Attributes
    ----------
    verdict : str
    orthogonality, mean_orthogonality : float
        Largest and mean angle in degrees between a face's normal and the line between the cells on both sides.
    skewness, aspect : float
    """

    verdict: str
    orthogonality: float
    mean_orthogonality: float
    skewness: float
    aspect: float


@dataclass(frozen=True)
class Section:
    """A profile's mesh: its nodes and area, what the file for SU2 holds, what checkMesh says if it is installed."""

    nodes: int
    area: float
    su2: Written
    openfoam: Checked | None


def section(cells: str, size: float = 0.01, count: int = 36) -> Section:
    """NACA 0012 with a sharp trailing edge in a far field, its layers of ``cells``, in the files of both solvers."""
    keys = {"name": NAME} | around([smooth_ring(naca("0012", sharp=True), "wing")], 1e-5, count, size)
    keys["layers"][0]["cells"] = cells
    case = load_case("section.yaml", text=json.dumps(keys))
    result = mesh_case(case)
    with tempfile.TemporaryDirectory() as folder:
        for form in ("su2", "openfoam"):
            destination(case, "-", OutputOptions(f"{folder}/", solvers=(form,))).write_result(result)
        su2 = read_su2(Path(folder) / f"{NAME}.su2")
        try:
            checked = check_openfoam(Path(folder))
        except NotInstalledError:
            checked = None
    return Section(len(result.mesh.points), result.report["area"], su2, checked)


def read_su2(path: Path) -> Written:
    """What a file of SU2 holds, by its published description."""
    lines = iter(path.read_text().splitlines())
    cells, points, markers, label = list[list[int]](), np.zeros((0, 2)), dict[str, int](), ""
    for line in lines:
        key, _, value = (part.strip() for part in line.partition("="))
        match key:
            case "NELEM":
                rows = [list(map(int, next(lines).split())) for _ in range(int(value))]
                cells = [row[1 : 1 + CORNERS[row[0]]] for row in rows]
            case "NPOIN":
                points = np.array([next(lines).split()[:2] for _ in range(int(value.split()[0]))], float)
            case "MARKER_TAG":
                label = value
            case "MARKER_ELEMS":
                markers[label] = int(value)
    return Written(len(points), len(cells), markers, sum(_area(points[cell]) for cell in cells))


def check_openfoam(folder: Path) -> Checked:
    """What checkMesh says of the mesh for OpenFOAM in a folder; NotInstalledError where it is not there."""
    shutil.copytree(SCRIPTS / "openfoam" / "common", folder, dirs_exist_ok=True)
    (folder / "system" / "controlDict").write_text(CONTROL)
    printed([program("gmshToFoam"), f"{NAME}.msh"], folder)
    for patch in ("front", "back"):
        entry = f"entry0.{patch}.type"
        printed([program("foamDictionary"), "-entry", entry, "-set", "empty", "constant/polyMesh/boundary"], folder)
    text = printed([program("checkMesh")], folder)
    (verdict,) = re.findall(r"^(Mesh OK|Failed \d+ mesh checks)", text, flags=re.M)
    ((most, mean),) = re.findall(r"non-orthogonality Max: (\S+) average: (\S+)", text)
    (skewness,) = re.findall(r"skewness = ([-+.\de]+\d)", text)
    (aspect,) = re.findall(r"aspect ratio = ([-+.\de]+\d)", text)
    return Checked(verdict, *map(float, (most, mean, skewness, aspect)))


def _area(ring: Floats) -> float:
    x, y = (ring - ring[0]).T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
