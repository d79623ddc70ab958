"""Gmsh from start to end on one shape, as a script of a user's: ``python -m benchmarks.layers.program SHAPE FILE``.

Writes the mesh to the file, whose ending is one of Gmsh's formats.
"""

import sys

from benchmarks.layers.shapes import shapes
from benchmarks.layers.with_gmsh import mesh
from benchmarks.peers.clock import Clock


def main(shape: str, file: str) -> None:
    """Mesh once, write."""
    import gmsh

    mesh(shapes()[shape], Clock(), fans=True)
    gmsh.write(file)


if __name__ == "__main__":
    main(*sys.argv[1:])
