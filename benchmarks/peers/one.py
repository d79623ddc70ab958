"""One tool on one case, in a process of its own: ``python -m benchmarks.peers.one CASE TOOL METHOD MESH``.

Writes points and triangles to the file MESH and prints what the meshing took, as JSON.
"""

import json
import sys
from statistics import median
from time import process_time

import numpy as np

from benchmarks.peers.clock import Clock, peak_mb
from benchmarks.peers.tools import TOOLS
from bubblemesh.arrays import Floats, Integers
from bubblemesh.case import load_case
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.triangulation import triangulated

TRIANGULATIONS = 3


def main(path: str, name: str, method: str, file: str) -> None:
    """Mesh, measure, write."""
    tool, clock = TOOLS[name], Clock()
    case = load_case(path, method=method if tool.ours else None, overrides=tool.settings)
    points, triangles = tool.mesh(case, clock)
    costs = {"seconds": clock.seconds, "ready_mb": clock.ready_mb, "peak_mb": peak_mb()}
    if tool.ours:
        costs["floor"] = _floor(points, triangles)
    np.savez(file, points=points, triangles=triangles)
    print(json.dumps(costs))


def _floor(points: Floats, triangles: Integers) -> float:
    """Processor seconds of one constrained triangulation of the same nodes."""
    sides, count = unique_edges(triangles)
    times = []
    for _ in range(TRIANGULATIONS):
        begun = process_time()
        triangulated(points, sides[count == 1])
        times.append(process_time() - begun)
    return median(times)


if __name__ == "__main__":
    main(*sys.argv[1:])
