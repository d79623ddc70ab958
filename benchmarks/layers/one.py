"""One tool on one shape, in a process of its own: ``python -m benchmarks.layers.one SHAPE TOOL MESH``.

Writes the mesh to the file MESH and prints processor seconds with layers and without, of second runs, so that loading
modules does not count.
"""

import sys
from dataclasses import asdict

import numpy as np

from benchmarks.layers.made import Made
from benchmarks.layers.shapes import Keys, bare, shapes
from benchmarks.layers.tools import TOOLS
from benchmarks.peers.clock import Clock


def main(shape: str, tool: str, file: str) -> None:
    """Mesh, write."""
    keys = shapes()[shape]
    made, seconds = second_run(keys, tool)
    np.savez(file, **asdict(made))
    print(seconds, second_run(bare(keys), tool)[1])


def second_run(keys: Keys, tool: str) -> tuple[Made, float]:
    """The mesh of a case, and the processor seconds that it took when it was made once more."""
    clock = Clock()
    for _ in range(2):
        made = TOOLS[tool](keys, clock)
    return made, clock.seconds


if __name__ == "__main__":
    main(*sys.argv[1:])
