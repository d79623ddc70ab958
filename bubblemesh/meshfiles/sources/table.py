"""The table of readers: one for each ending of mesh files; all others are left to meshio."""

from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path

from bubblemesh.errors import FileError
from bubblemesh.meshfiles.sources.source import Source

# Functions of a path, as ``module.name`` within this folder, each loaded when it is used.
READERS: Mapping[str, str] = {
    ".vtk": "vtk.read_vtk",
    ".vtu": "vtu.read_vtu",
    ".pvtu": "vtk_lists.read_pvtu",
    ".pvd": "vtk_lists.read_pvd",
    ".xdmf": "xdmf.read_xdmf",
    ".xmf": "xdmf.read_xdmf",
    ".frd": "frd.read_frd",
    ".mesh": "medit.read_medit",
    ".sol": "medit.read_solution",
    ".msh": "gmsh.read_msh",
    ".pos": "pos.read_pos",
    ".inp": "other.read_inp",
    ".med": "other.read_med",
    ".su2": "su2.read_su2",
    ".14": "coasts.read_grid",
    ".grd": "coasts.read_grid",
    ".gr3": "coasts.read_grid",
    ".2dm": "coasts.read_sms",
    ".slf": "serafin.read_serafin",
    ".nc": "ugrid.read_ugrid",
    ".node": "triangle.read_pair",
    ".ele": "triangle.read_pair",
}
# Files that a user may take for a mesh, and what to give in their place.
NO_MESHES: Mapping[str, str] = {
    ".h5": "holds the numbers of an XDMF file: give the .xdmf file beside it",
    ".gf": "holds the values of MFEM alone: write ParaView data (.vtu) by MFEM's ParaViewDataCollection",
    ".npz": "holds nodes without triangles",
    ".csv": "holds nodes without triangles",
}


def require_mesh(path: Path) -> None:
    """Check that a file is none of those that hold a part of a mesh only; else it is a FileError with advice."""
    advice = NO_MESHES.get(path.suffix.lower())
    if advice is not None:
        raise FileError(advice)


def read_source(path: Path) -> Source:
    """All that a mesh file holds; any error of its reader may come out, of which a FileError names no path yet."""
    module, _, name = READERS.get(path.suffix.lower(), "other.read_other").partition(".")
    reader: Callable[[Path], Source] = getattr(import_module(f"{__package__}.{module}"), name)
    return reader(path)
