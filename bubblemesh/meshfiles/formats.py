"""The table of mesh formats."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from bubblemesh.errors import CaseError
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.groups import Fields
from bubblemesh.meshfiles.names import as_they_are, plain_words
from bubblemesh.meshfiles.solvers import FormatName
from bubblemesh.meshfiles.write.abaqus import set_names, write_plane_strain, write_plane_stress
from bubblemesh.meshfiles.write.gmsh import write_msh, write_msh_ascii
from bubblemesh.meshfiles.write.medit import write_medit
from bubblemesh.meshfiles.write.nodes import write_csv, write_npz
from bubblemesh.meshfiles.write.openfoam import patch_names, write_openfoam
from bubblemesh.meshfiles.write.salome import write_med
from bubblemesh.meshfiles.write.su2 import marker_names, write_su2
from bubblemesh.meshfiles.write.tecplot import write_tecplot
from bubblemesh.meshfiles.write.vtk import write_vtk, write_vtu
from bubblemesh.meshfiles.write.xdmf import write_inline_xdmf, write_xdmf

Writer = Callable[[Mesh, Fields, Path], None]
BOTH = (1, 2)
XDMF_FILES = (".xdmf", ".h5", "_facets.xdmf", "_facets.h5")


@dataclass(frozen=True)
class Format:
    """One way to write a mesh.

    Attributes
    ----------
    files : tuple of str
        Ends of the names of the files that ``write`` makes, the main one first.
    write : callable
        Writes the mesh to the main file's path, and the other files beside it.
    names : callable or None
        Gives the names of the groups that it holds as the files spell them; None where solvers find ids only.
    orders : tuple of int
        Orders of the triangles that it has a form for.
    points : bool
        Whether it holds labelled points.
    periodic : bool
        Whether it holds which nodes of periodic sides match.
    write_alone : callable, optional
        Writes the mesh to one file that needs no other; as ``write`` unless given.
    """

    files: tuple[str, ...]
    write: Writer
    names: Callable[[Mesh], dict[str, str]] | None
    orders: tuple[int, ...] = (1,)
    points: bool = True
    periodic: bool = False
    write_alone: Writer | None = None

    def holds_all_of(self, mesh: Mesh) -> bool:
        """Whether the labelled points and periodic pairs of a mesh have a place in it."""
        return (self.points or not len(mesh.labelled_nodes)) and (self.periodic or not len(mesh.periodic))


FORMATS: dict[FormatName, Format] = {
    "msh": Format((".msh",), write_msh, as_they_are, BOTH, periodic=True),
    "vtu": Format((".vtu",), write_vtu, None, BOTH, points=False),
    "vtk": Format((".vtk",), write_vtk, None, BOTH, points=False),
    "xdmf": Format(XDMF_FILES, write_xdmf, None, BOTH, points=False, write_alone=write_inline_xdmf),
    "msh-ascii": Format((".msh",), write_msh_ascii, as_they_are, BOTH, periodic=True),
    "mesh": Format((".mesh",), write_medit, None),
    "inp": Format((".inp",), write_plane_stress, set_names, BOTH),
    "inp-strain": Format((".inp",), write_plane_strain, set_names, BOTH),
    "su2": Format((".su2",), write_su2, marker_names, points=False),
    "med": Format((".med",), write_med, plain_words, BOTH),
    "dat": Format((".dat",), write_tecplot, None, points=False),
    "openfoam": Format((".msh",), write_openfoam, patch_names, points=False),
    "nodes.csv": Format((".nodes.csv",), write_csv, as_they_are),
    "nodes.npz": Format((".nodes.npz",), write_npz, as_they_are, periodic=True),
}


def format_named(name: str) -> Format:
    """Look up a format by its name; an unknown one is a CaseError."""
    for known, form in FORMATS.items():
        if name == known:
            return form
    raise CaseError(f"unknown mesh format {name!r}: choose one of {', '.join(FORMATS)}")


def formats_by_ending(file: str) -> list[FormatName]:
    """Return the formats whose files end like the given file name, which has to have a stem before that."""
    return [name for name, form in FORMATS.items() if file.endswith(form.files[0]) and file != form.files[0]]


def require_order(formats: Iterable[str], order: int) -> None:
    """Check that all formats have a form for triangles of an order; else it is a CaseError."""
    for name in formats:
        if order not in format_named(name).orders:
            able = ", ".join(known for known, form in FORMATS.items() if order in form.orders)
            raise CaseError(f"{name} has no form for triangles of order {order}: choose among {able}, or order 1")
