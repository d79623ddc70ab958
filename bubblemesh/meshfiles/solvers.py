"""The mesh formats by name, and which of them each solver is to get."""

from typing import Literal

FormatName = Literal[
    "msh",
    "vtu",
    "vtk",
    "xdmf",
    "msh-ascii",
    "mesh",
    "inp",
    "inp-strain",
    "su2",
    "med",
    "dat",
    "openfoam",
    "nodes.csv",
    "nodes.npz",
]

Solver = Literal["fenicsx", "scikit-fem", "mfem", "freefem", "su2", "calculix", "openfoam"]

# Why these is told in docs/solvers.md.
FORMATS_FOR: dict[str, tuple[FormatName, ...]] = {
    "fenicsx": ("msh", "xdmf"),
    "scikit-fem": ("msh",),
    "mfem": ("msh",),
    "freefem": ("mesh",),
    "su2": ("su2",),
    "calculix": ("inp",),
    "openfoam": ("openfoam",),
}
