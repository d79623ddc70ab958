"""The tools that make layers."""

from functools import partial

from benchmarks.layers import with_bubblemesh, with_gmsh

OURS = "bubblemesh"
FANS, PLAIN = "gmsh-fans", "gmsh"
TOOLS = {
    OURS: with_bubblemesh.mesh,
    FANS: partial(with_gmsh.mesh, fans=True),
    PLAIN: partial(with_gmsh.mesh, fans=False),
}
