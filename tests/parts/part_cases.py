"""Cases that are packed in parts, and what holds of their meshes."""

from functools import cache

import numpy as np
from invariants import check_area, check_arrays, check_edges, check_facets_do_not_cross, check_labels, check_nodes
from partitions import MOONS

from bubblemesh.case import load_case
from bubblemesh.run.pipeline import mesh_case

SQUARE = "{rectangle: [0, 0, 4, 3]}"
HOLES = f"""
domain:
  outer: {SQUARE}
  holes:
    - {{circle: {{center: [1, 1.5], radius: 0.4}}, label: bore}}
    - {{polygon: [[2.5, 0.5], [3.5, 0.5], [3.5, 1], [2.5, 1]], label: slot}}
spacing: 0.07
"""
REGIONS = f"""
domain:
  outer: {SQUARE}
  region: matrix
  regions:
    - {{name: core, ring: {{circle: {{center: [2, 1.5], radius: 0.8}}}}}}
    - {{name: bar, ring: {{rectangle: [0, 2.6, 4, 2.8]}}}}
  lines:
    - {{path: [[0.2, 0.3], [3.7, 0.5]], label: crack}}
  points:
    - {{at: [3.5, 1.5], label: well}}
spacing: {{value: 0.12, regions: {{core: 0.075}}}}
"""
DISC = """
domain:
  outer: {circle: {center: [0, 0], radius: 1}}
spacing: 0.04 + 0.05*hypot(x, y)
"""
AREAS = """
domain:
  outer:
    - {rectangle: [0, 0, 1, 1]}
    - {rectangle: [1.5, 0, 2.5, 1]}
spacing: 0.05
"""
PERIODIC = f"""
domain:
  {MOONS.strip()}
  periodic: [[left, right], [bottom, top]]
spacing: 0.04 + 0.02*sin(pi*x)**2
"""
SPLINE = """
domain:
  outer:
    path:
      - [0, 0]
      - {to: [2, 0], label: base}
      - {spline: {through: [[2.4, 0.8], [1.4, 1.6], [0.3, 1.2], [0, 0]]}, label: curve}
spacing: {value: 0.08, near: [{label: curve, size: 0.04, growth: 0.3}]}
"""
WAVES = np.linspace(0, 2 * np.pi, 150, endpoint=False)
RADII = 1 + 0.08 * np.sin(9 * WAVES) + 0.01 * np.cos(61 * WAVES)
SHORE = f"""
domain:
  outer: {{polygon: {np.column_stack([RADII * np.cos(WAVES), RADII * np.sin(WAVES)]).round(6).tolist()}}}
spacing: 0.055
"""
CASES = {
    "HOLES": HOLES,
    "REGIONS": REGIONS,
    "DISC": DISC,
    "AREAS": AREAS,
    "PERIODIC": PERIODIC,
    "SPLINE": SPLINE,
    "SHORE": SHORE,
}

CHECKS = check_nodes, check_arrays, check_edges, check_facets_do_not_cross, check_area, check_labels


def case(text, parts=None):
    """The case of a text, packed in so many parts."""
    return load_case("parts.yaml", text=f"{text}\nparts: {parts}\n" if parts else text)


@cache
def meshed(text, parts=None):
    """The result of such a case: several tests look at the same ones."""
    return mesh_case(case(text, parts))
