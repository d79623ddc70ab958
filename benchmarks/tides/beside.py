"""One coast by several tools: ``python -m benchmarks.tides --peers``.

All of them get the same outline, with the detail that the spacing can show, and the same spacing, of the distance from
the shore and of the depth. JIGSAW's executable has to be on the PATH; tools that are not there are left out.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import shapely

from benchmarks.peers.measures import Figures, measured
from benchmarks.peers.tools import TOOLS
from benchmarks.tides.archipelago import draw
from bubblemesh.arrays import Floats, Integers
from bubblemesh.case import load_case
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.problem.prepare import prepare
from bubblemesh.problem.problem import Problem

SEED = 3
COMPARED = ("bubblemesh-fast", "bubblemesh", "bubblemesh-best", "jigsaw", "jigsaw-long")
MANY = 8  # neighbours, above which models of tides warn
ROWS = (
    "| | nodes | mean q | 1 % below | least q | edges l/d | most neighbours | nodes with more than 8 | shore off by | "
    "processor time |"
)


def table(text: str) -> str:
    """Rows of the tools on the case of a text, which names the files of a drawn archipelago."""
    lines = [ROWS, "|---" * (ROWS.count("|") - 1) + "|"]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        draw(folder, SEED)
        case = folder / "coast.yaml"
        case.write_text(text)
        problem = prepare(load_case(case))
        for tool in COMPARED:
            if TOOLS[tool].installed():
                points, triangles, seconds = _meshed(case, tool)
                figures, off = measured(points, triangles, problem), _off_shore(points, triangles, problem)
                lines.append(_row(TOOLS[tool].label, figures, triangles, off, seconds))
    return "\n".join(lines) + "\n"


def _meshed(case: Path, tool: str) -> tuple[Floats, Integers, float]:
    """Points, triangles and processor seconds of a tool, in a process of its own."""
    file = case.with_suffix(".npz")
    command = [sys.executable, "-m", "benchmarks.peers.one", str(case), tool, "multilevel", str(file)]
    costs = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    with np.load(file) as mesh:
        return mesh["points"], mesh["triangles"], costs["seconds"]


def _off_shore(points: Floats, triangles: Integers, problem: Problem) -> float:
    """Largest distance of a point of the outline from the mesh's boundary, in spacings there."""
    sides, count = unique_edges(triangles)
    outline = problem.domain.polygonal_copy.points
    tree = shapely.STRtree(shapely.linestrings(points[sides[count == 1]]))
    _, distance = tree.query_nearest(shapely.points(outline), return_distance=True, all_matches=False)
    return float((distance / problem.spacing.extended(outline)).max())


def _row(label: str, found: Figures, triangles: Integers, off: float, seconds: float) -> str:
    valence = np.bincount(unique_edges(triangles)[0].ravel())
    cells = (
        label,
        f"{found.nodes}",
        f"{found.mean:.4f}",
        f"{found.p01:.3f}",
        f"{found.least:.3f}",
        f"{found.edge:.3f} ± {found.spread:.3f}",
        f"{valence.max()}",
        f"{(valence > MANY).sum()}",
        f"{off:.2f} d",
        f"{seconds:.1f} s",
    )
    return f"| {' | '.join(cells)} |"
