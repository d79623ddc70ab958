"""BAMG as a program: it starts as Mmg2D does, and goes on from its own mesh with the metric evaluated anew."""

import subprocess
import tempfile
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage

import numpy as np

from benchmarks.metric.problems import Array, Problem
from benchmarks.metric.with_mmg import PASSES, even_mesh
from bubblemesh.meshes.edges import directed_sides, one_sided

OPTIONS = ("-nbv", "1000000", "-ratio", "0", "-v", "0")  # no gradation, as of the others


def with_bamg(program: str, problem: Problem) -> tuple[Array, Array, float]:
    """Points, triangles and seconds of six passes, with the time for files."""
    points, triangles = even_mesh(problem)
    begun = _spent()
    with tempfile.TemporaryDirectory() as folder:
        for number in range(PASSES):
            given, metric, made = (Path(folder) / f"{number}.{end}" for end in ("msh", "mtr", "mesh"))
            _write(given, points, triangles)
            np.savetxt(metric, problem(points), header=f"{len(points)} 3", comments="")
            command = [program, "-b", str(given), "-M", str(metric), "-o", str(made), *OPTIONS]
            subprocess.run(command, check=True, capture_output=True)
            points, triangles = _read(made)
    return points, triangles, _spent() - begun


def _spent() -> float:
    used = getrusage(RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _write(path: Path, points: Array, triangles: Array) -> None:
    """Write points, triangles and the sides of the domain, all of one label each, in FreeFEM's format."""
    sides = directed_sides(triangles)
    rim = sides[one_sided(sides, len(points))]
    with path.open("w") as file:
        file.write(f"{len(points)} {len(triangles)} {len(rim)}\n")
        np.savetxt(file, np.column_stack([points, np.zeros(len(points))]), fmt="%.17g %.17g %d")
        for rows in (triangles, rim):
            np.savetxt(file, np.column_stack([rows + 1, np.ones(len(rows), int)]), fmt="%d")


def _read(path: Path) -> tuple[Array, Array]:
    words = path.read_text().split()
    points, triangles = (_rows(words, name, width) for name, width in (("Vertices", 3), ("Triangles", 4)))
    return points[:, :2], triangles[:, :3].astype(np.int64) - 1


def _rows(words: list[str], name: str, width: int) -> Array:
    """Rows (n, width) of numbers after a word and their count."""
    place = words.index(name)
    count = int(words[place + 1])
    return np.array(words[place + 2 : place + 2 + count * width], float).reshape(count, width)
