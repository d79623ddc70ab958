"""Our own tool, beside the others."""

from importlib import import_module

from benchmarks.peers.clock import Clock
from bubblemesh.arrays import Floats, Integers
from bubblemesh.case import Case
from bubblemesh.process.resources import keep_freed_memory, seldom_look_for_garbage
from bubblemesh.run.pipeline import mesh_case


def mesh(case: Case, clock: Clock) -> tuple[Floats, Integers]:
    """Points (n, 2) and triangles (t, 3); the time is that from the case to the end of the last round."""
    seldom_look_for_garbage()  # as the command does, too
    keep_freed_memory()
    import_module("bubblemesh.packing.configure")  # the first case would; what loads the others is not counted either
    clock.start()
    result = mesh_case(case, lambda row: clock.stop())
    return result.mesh.points, result.mesh.triangles
