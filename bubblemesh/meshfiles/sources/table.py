"""The table of readers by the endings of mesh files; files with other endings are read by meshio."""

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
    ".inp": "abaqus.read_inp",
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
# Endings of files that users may mistake for meshes, with advice on the right file.
NO_MESHES: Mapping[str, str] = {
    ".h5": "holds the numbers of an XDMF file: give the .xdmf file beside it",
    ".gf": "holds the values of MFEM alone: write ParaView data (.vtu) by MFEM's ParaViewDataCollection",
    ".npz": "holds nodes without triangles",
    ".csv": "holds nodes without triangles",
}


def require_mesh(path: Path) -> None:
    """Check that a file is not one that holds only a part of a mesh; FileError with advice if it is."""
    advice = NO_MESHES.get(path.suffix.lower())
    if advice is not None:
        raise FileError(advice)


def read_source(path: Path) -> Source:
    """Everything in a mesh file; raises any error of its reader, and FileErrors still without the path."""
    module, _, name = READERS.get(path.suffix.lower(), "other.read_other").partition(".")
    reader: Callable[[Path], Source] = getattr(import_module(f"{__package__}.{module}"), name)
    return reader(path)
