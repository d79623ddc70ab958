"""The table of mesh formats."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from bubblemesh.errors import CaseError
from bubblemesh.mesh import Mesh
from bubblemesh.output.cells import Fields
from bubblemesh.output.gmsh import write_msh
from bubblemesh.output.vtk import write_vtk, write_vtu
from bubblemesh.output.xdmf import write_inline_xdmf, write_xdmf

__all__ = ["FORMATS", "Format", "format_named"]

Writer = Callable[[Mesh, Fields, Path], None]


@dataclass(frozen=True)
class Format:
    """One way to write a mesh.

    Attributes
    ----------
    files : tuple of str
        Ends of the names of the files that ``write`` makes, the main one first.
    write : callable
        Writes the mesh to the main file's path, and the other files beside it.
    write_alone : callable
        Writes the mesh to one file that needs no other.
    """

    files: tuple[str, ...]
    write: Writer
    write_alone: Writer


FORMATS = {
    "msh": Format((".msh",), write_msh, write_msh),
    "vtu": Format((".vtu",), write_vtu, write_vtu),
    "vtk": Format((".vtk",), write_vtk, write_vtk),
    "xdmf": Format((".xdmf", ".h5", "_facets.xdmf", "_facets.h5"), write_xdmf, write_inline_xdmf),
}


def format_named(name: str) -> Format:
    """Look up a format by its ending, without the dot; an unknown one is a CaseError."""
    if name not in FORMATS:
        raise CaseError(f"unknown mesh format {name!r}: choose one of {', '.join(FORMATS)}")
    return FORMATS[name]
