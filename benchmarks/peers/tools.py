"""The tools: a table of this project at its three efforts, and of the peers."""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import partial

from benchmarks.peers import with_bubblemesh, with_distmesh, with_gmsh, with_jigsaw, with_netgen, with_triangle
from benchmarks.peers.clock import Clock
from benchmarks.peers.gmsh_settings import DELAUNAY, FRONTAL
from bubblemesh.arrays import Floats, Integers
from bubblemesh.case import Case

OURS, BEST, REFERENCE = "bubblemesh", "bubblemesh-best", "gmsh-frontal"
RELOCATIONS = 10  # steps of Relocate2D; more hardly change the mesh
LARGE = 3e5  # nodes of the largest case of those that would take longer than the rest together
ITERATIONS = 200  # of JIGSAW's optimization; 16 are its default


@dataclass(frozen=True)
class Tool:
    """A mesh generator.

    Attributes
    ----------
    label : str
    mesh : callable
        From a case to points (n, 2) and triangles (t, 3); it starts and stops the clock.
    settings : tuple of str
        Overrides of the case.
    ours : bool
        Whether it is this project, which meshes by the method that the command names.
    most_nodes : float
        Ideal number of nodes of the largest case it is tried on.
    installed : callable
        Whether it is on this machine; where it is not, it is left out unless it is asked for.
    """

    label: str
    mesh: Callable[[Case, Clock], tuple[Floats, Integers]]
    settings: tuple[str, ...] = ()
    ours: bool = False
    most_nodes: float = float("inf")
    installed: Callable[[], bool] = lambda: True


TOOLS = {
    "bubblemesh-fast": Tool("bubblemesh, fast", with_bubblemesh.mesh, ("packing.effort=fast",), ours=True),
    OURS: Tool("bubblemesh", with_bubblemesh.mesh, ours=True),
    BEST: Tool("bubblemesh, best", with_bubblemesh.mesh, ("packing.effort=best",), ours=True),
    REFERENCE: Tool("Gmsh Frontal-Delaunay", partial(with_gmsh.mesh, algorithm=FRONTAL)),
    "gmsh-relocate": Tool(
        "Gmsh Frontal-Delaunay + Relocate2D",
        partial(with_gmsh.mesh, algorithm=FRONTAL, relocations=RELOCATIONS),
        most_nodes=LARGE,
    ),
    "gmsh-delaunay": Tool("Gmsh Delaunay", partial(with_gmsh.mesh, algorithm=DELAUNAY), most_nodes=LARGE),
    "jigsaw": Tool("JIGSAW", with_jigsaw.mesh, installed=with_jigsaw.installed),
    "jigsaw-long": Tool(
        f"JIGSAW, {ITERATIONS} iterations",
        partial(with_jigsaw.mesh, iterations=ITERATIONS),
        most_nodes=1e5,
        installed=with_jigsaw.installed,
    ),
    "jigsaw-restarts": Tool(
        "JIGSAW with restarts",
        with_jigsaw.mesh_with_restarts,
        most_nodes=1e4,
        installed=with_jigsaw.restarts_installed,
    ),
    "netgen": Tool("Netgen", with_netgen.mesh, most_nodes=LARGE, installed=with_netgen.installed),
    "triangle": Tool("Triangle", with_triangle.mesh),
    "distmesh": Tool("DistMesh", with_distmesh.mesh, most_nodes=2000),
}


def peers(names: Collection[str]) -> list[str]:
    """Those of the tools ``names`` that are not this project."""
    return [name for name in TOOLS if name in names and not TOOLS[name].ours]
