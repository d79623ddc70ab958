"""The case file that ``bubblemesh init`` writes."""

TEMPLATE = """\
# A square plate with a round hole, meshed finer near the hole.
# Run it with: bubblemesh run FILE

# Stem of the output files; without it, that of this file.
name: plate

# Constants for expressions: for the spacing, and for lengths and coordinates such as `radius: 8*h`.
parameters:
  h: 0.05

domain:
  # Each ring is one of the shapes below and may turn either way.
  outer:
    polygon: [[-1, -1], [1, -1], [1, 1], [-1, 1]]
    # Boundary names, one per side; or one for the whole ring: `label: wall`.
    labels: [bottom, right, top, left]

    # rectangle: [-1, -1, 1, 1]          # the same ring; its sides are bottom, right, top, left

    # path:                              # a point, then lines and curves; it closes by itself
    #   - [1, 0]
    #   - {arc: {to: [-1, 0], center: [0, 0], turn: left}, label: rim}
    #   - {spline: {through: [[-0.5, -0.3], [0.2, -0.2], [0.8, -0.1]]}, label: keel}
    #   - {to: [1, 0], label: step}

  holes:
    - {circle: {center: [0, 0], radius: 0.4}, label: hole}
    # - {ellipse: {center: [0.6, 0.6], radii: [0.2, 0.1], angle: 45}, label: slot}     # angle in degrees

# Wanted edge length: a number, or an expression in x, y and the parameters. It may use
# + - * / ** % //, comparisons, `a if c else b`, pi, e and min, max, abs, sqrt, exp, log, sin, cos, tan,
# hypot, atan2, where, clip, sign, floor, ceil, round and their kin; distance("hole") is that from a boundary.
spacing: "h*(1 + 2*max(hypot(x, y) - 0.4, 0))"

# In place of it, terms of which the smallest counts, and limits of what comes out.
# spacing:
#   near: {label: hole, size: 0.05, growth: 0.1}   # or a list: of labels, points [x, y] and lines
#   labels: {left: 0.08}                 # short for the same with the usual growth
#   per_circle: 36                       # nodes on a full turn of curves
#   across: 3                            # spacings across narrow parts
#   maximum: 0.2
#   growth: 0.2                          # per length, at most

# The packing method.
method: multilevel

# Options of the method: the seed of its random numbers, and how long it improves the order of the bubbles.
packing:
  seed: 0
  effort: normal                         # fast, normal or best

# Options of the published methods, fnpbs for example: rounds, iterations, c0, c_in, c_out.
schedule: {}

output:
  formats: [msh, vtu, xdmf]              # any of msh, vtu, vtk, xdmf, mesh, inp, su2, med, nodes.csv and others
  # for: calculix                        # in place of formats: fenicsx, scikit-fem, mfem, freefem, su2, openfoam
  # order: 2                             # six-node triangles, on the true curves
  # report: true                         # NAME.html, a page to look at
  # directory: out                       # relative to this file

# With `bubblemesh batch`, a case for each combination of these values.
# sweep:
#   parameters.h: [0.02, 0.05]
#   packing.seed: [0, 1, 2]

# A case that would need more nodes is refused.
limits:
  max_nodes: 2000000

# Where the mesh misses one of these, it is written, but the run ends with exit code 4.
require:
  quality_min: 0.3                       # of the worst triangle; 1 is equilateral
  # quality_mean: 0.9
  # angle_min: 20                        # degrees
"""
