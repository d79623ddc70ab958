"""Our own layers."""

import json

import numpy as np

from benchmarks.layers.made import Made
from benchmarks.layers.shapes import Keys
from benchmarks.peers.clock import Clock
from bubblemesh.case import load_case
from bubblemesh.process.resources import keep_freed_memory, seldom_look_for_garbage
from bubblemesh.run.pipeline import mesh_case


def mesh(keys: Keys, clock: Clock) -> Made:
    """The mesh of a case; the time is that from the case to the mesh with its report."""
    seldom_look_for_garbage()  # as the command does, too
    keep_freed_memory()
    case = load_case("shape.yaml", text=json.dumps(keys))
    with clock:
        found = mesh_case(case).mesh
    walls = np.isin(found.facet_labels, [found.labels.index(entry["on"]) for entry in keys.get("layers", ())])
    return Made(found.points, found.triangles, found.facets[found.outer], found.facets[walls])
