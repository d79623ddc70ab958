"""Mmg2D in its own interpreter: ``PYTHON -m benchmarks.metric.with_mmg NUMBER FILE`` writes a mesh and its time.

It needs NumPy and mmgpy only. Mmg knows a metric at the nodes of a mesh: it starts from an even one, and goes on from
its own with the metric evaluated anew.
"""

import sys
import time
from pathlib import Path

import numpy as np

from benchmarks.metric.problems import LONGEST, PROBLEMS, Array, Problem

PASSES = 6


def even_mesh(problem: Problem) -> tuple[Array, Array]:
    """A fan of even triangles: points (n, 2) and triangles (t, 3) of a convex polygon."""
    corners = np.array(problem.corners)
    center, size = corners.mean(axis=0), np.ptp(corners, axis=0).max()
    rows = max(int(size / LONGEST / 1.5), 2)
    points, triangles, number = [center], [], {}

    def node(sector: int, ring: int, place: int) -> int:
        """The node at a place of a sector's ring, which the next sector may share."""
        key = (0, 0, 0) if ring == 0 else ((sector + (place == ring)) % len(corners), ring, place % ring)
        if key not in number:
            first, last = corners[key[0]], corners[(key[0] + 1) % len(corners)]
            number[key] = len(points) if ring else 0
            if ring:
                share = key[2] / ring
                points.append(center + ring / rows * ((1 - share) * first + share * last - center))
        return number[key]

    for sector in range(len(corners)):
        for ring in range(rows):
            for place in range(ring + 1):
                out, ahead = node(sector, ring + 1, place), node(sector, ring + 1, place + 1)
                triangles.append((node(sector, ring, place), out, ahead))
                if place < ring:
                    triangles.append((node(sector, ring, place), ahead, node(sector, ring, place + 1)))
    return np.array(points), np.array(triangles)


def main(number: int, path: Path) -> None:
    """Mesh a problem and write the result."""
    from mmgpy import MmgMesh2D

    problem = PROBLEMS[number]
    points, triangles = even_mesh(problem)
    begun = time.process_time()
    for _ in range(PASSES):
        mesh = MmgMesh2D(points, triangles.astype(np.int32))
        mesh["tensor"] = problem(points)
        mesh.remesh(verbose=-1, hgrad=-1.0)
        points, triangles = mesh.get_vertices(), mesh.get_triangles().astype(np.int64)
    np.savez(path, points=points, triangles=triangles, seconds=time.process_time() - begun)


if __name__ == "__main__":
    main(int(sys.argv[1]), Path(sys.argv[2]))
