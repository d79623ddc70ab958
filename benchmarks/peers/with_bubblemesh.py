"""Our own tool, beside the others."""

from benchmarks.peers.clock import Clock
from bubblemesh.arrays import Floats, Integers
from bubblemesh.case import Case
from bubblemesh.run.pipeline import mesh_case


def mesh(case: Case, clock: Clock) -> tuple[Floats, Integers]:
    """Points (n, 2) and triangles (t, 3); the time is that from the case to the end of the last round."""
    clock.start()
    result = mesh_case(case, lambda row: clock.stop())
    return result.mesh.points, result.mesh.triangles
