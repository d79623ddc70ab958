"""The table of formats of mesh files by their endings: how they are read, checked and kept together."""

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

from bubblemesh.errors import BubblemeshError, FileError
from bubblemesh.meshfiles import containment
from bubblemesh.meshfiles.sources import companions
from bubblemesh.meshfiles.sources.source import Source

BY_MESHIO = "other.read_other"


class SourceFormat(NamedTuple):
    """How files of a format are read; a row that leaves something out is taken for a format that may be hostile."""

    reader: str = BY_MESHIO  # function of a path, as ``module.name`` within this folder, loaded when it is used
    self_contained: bool = False  # whether the reader opens no other file, so that untrusted cases may name such files
    check: Callable[[Path], None] | None = containment.check_content  # before a file is read; None if the reader does
    beside: Callable[[Path], Iterable[Path]] | None = None  # files to which one refers
    has_tensors: bool = False  # whether the format has a kind of data for tensors
    data_ending: str | None = None  # of the file beside, with the same name, that has the data of a mesh


XDMF = SourceFormat("xdmf.read_xdmf", check=containment.check_xdmf, beside=containment.files_of_xdmf)
HDF = SourceFormat(check=containment.check_hdf)
GRID = SourceFormat("coasts.read_grid", self_contained=True)
SOLUTION = companions.same_name(".sol", ".mesh", ".meshb")
TRIANGLE = SourceFormat(
    "triangle.read_pair",
    check=containment.all_readable(companions.same_name(".node", ".ele")),
    beside=companions.same_name(".node", ".ele", ".edge", ".poly"),
)

# Formats with readers of our own have what meshio's lack: names of all kinds, notes on what is left out, errors with
# places, and no more memory than their data take. Files with other endings are read by meshio.
FORMATS: Mapping[str, SourceFormat] = {
    ".msh": SourceFormat("gmsh.read_msh", self_contained=True),
    ".pos": SourceFormat("pos.read_pos", self_contained=True, has_tensors=True),
    ".vtk": SourceFormat("vtk.read_vtk", self_contained=True),
    ".vtu": SourceFormat("vtu.read_vtu", self_contained=True),
    ".frd": SourceFormat("frd.read_frd", self_contained=True),
    ".su2": SourceFormat("su2.read_su2", self_contained=True),
    ".14": GRID,
    ".grd": GRID,
    ".gr3": GRID,
    ".2dm": SourceFormat("coasts.read_sms", self_contained=True),
    ".nc": SourceFormat("ugrid.read_ugrid", self_contained=True, check=None),  # checks as it reads
    ".inp": SourceFormat("abaqus.read_inp", check=containment.check_include),
    ".slf": SourceFormat("serafin.read_serafin", beside=companions.same_name(".cli")),
    ".mesh": SourceFormat("medit.read_medit", beside=SOLUTION, has_tensors=True, data_ending=".sol"),
    ".meshb": SourceFormat(beside=SOLUTION, has_tensors=True, data_ending=".sol"),
    ".sol": SourceFormat("medit.read_solution", beside=SOLUTION, has_tensors=True),
    ".node": TRIANGLE,
    ".ele": TRIANGLE,
    ".pvtu": SourceFormat("vtk_lists.read_pvtu", beside=companions.pieces),
    ".pvd": SourceFormat("vtk_lists.read_pvd", beside=companions.files_of_list),
    ".xdmf": XDMF,
    ".xmf": XDMF,
    ".med": HDF._replace(reader="med.read_med"),
    ".h5m": HDF,
    ".hmf": HDF,
    ".cgns": HDF,
    ".xml": SourceFormat(check=containment.all_readable(companions.functions), beside=companions.functions),
    ".gz": SourceFormat(check=containment.check_gzip),
}
UNKNOWN = SourceFormat()
SELF_CONTAINED = tuple(ending for ending, known in FORMATS.items() if known.self_contained)
# Endings of files that users may mistake for meshes, with advice on the right file.
NO_MESHES: Mapping[str, str] = {
    ".h5": "holds the numbers of an XDMF file: give the .xdmf file beside it",
    ".gf": "holds the values of MFEM alone: write ParaView data (.vtu) by MFEM's ParaViewDataCollection",
    ".poly": "holds segments without triangles: give the .ele file that Triangle writes with it",
    ".edge": "holds edges without triangles: give the .ele file that Triangle writes with it",
    ".npz": "holds nodes without triangles",
    ".csv": "holds nodes without triangles",
}


def source_format(path: Path) -> SourceFormat:
    """The format of a file, by its ending."""
    return FORMATS.get(path.suffix.lower(), UNKNOWN)


def files_beside(path: Path) -> list[Path]:
    """Existing files to which a mesh file refers, directly or through lists: they have to be copied with it.

    The result is empty for a file that cannot be read: its reader reports the error.
    """
    beside = source_format(path).beside
    if beside is None:
        return []
    with suppress(BubblemeshError, OSError, SyntaxError, ValueError):  # SyntaxError: broken XML
        return [other for other in dict.fromkeys(beside(path)) if other != path and other.exists()]
    return []


def read_source(path: Path) -> Source:
    """Everything in a mesh file; raises any error of its reader, and FileErrors still without the path.

    FileError, too, for a file that is no mesh, with advice, or refers to files that are not beside it; LimitError for
    one that unpacks to too much data.
    """
    advice = NO_MESHES.get(path.suffix.lower())
    if advice is not None:
        raise FileError(advice)
    known = source_format(path)
    if known.check is not None:
        known.check(path)
    module, _, name = known.reader.partition(".")
    reader: Callable[[Path], Source] = getattr(import_module(f"{__package__}.{module}"), name)
    return reader(path)
