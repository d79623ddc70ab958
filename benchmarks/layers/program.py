"""Gmsh from start to end on one case, as a script of a user's: ``python -m benchmarks.layers.program CASE FILE``.

The case is JSON. Writes the mesh to the file, whose ending is one of Gmsh's formats. It loads NumPy, Gmsh and next to
nothing of bubblemesh, which would count as Gmsh's time.
"""

import json
import sys
from pathlib import Path

from benchmarks.layers.with_gmsh import mesh
from benchmarks.peers.clock import Clock


def main(case: str, file: str) -> None:
    """Mesh once, write."""
    import gmsh

    mesh(json.loads(Path(case).read_text()), Clock(), fans=True)
    gmsh.write(file)


if __name__ == "__main__":
    main(*sys.argv[1:])
