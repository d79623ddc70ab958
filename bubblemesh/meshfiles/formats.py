"""The table of mesh formats, and those that each solver gets; the writer of a format is loaded when it is used."""

from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from bubblemesh.errors import CaseError
from bubblemesh.messages import unknown
from bubblemesh.records import record

if TYPE_CHECKING:
    from bubblemesh.meshes.mesh import Mesh
    from bubblemesh.meshes.slices import SlicedMesh
    from bubblemesh.meshfiles.groups import Fields

BOTH = (1, 2)
PIECE, MOST_PIECES = "_{}.vtu", 10_000
XDMF_FILES = (".xdmf", ".h5", "_facets.xdmf", "_facets.h5")


class Beside(NamedTuple):
    """A file of text that some meshes need beside those of a format."""

    end: str  # of its name
    text: str  # function of a mesh that returns the text, or None if the mesh does not need it


@record
class Format:
    """A way to write a mesh.

    Functions are given as ``module.name`` within this package.

    Attributes
    ----------
    writer
        Takes a mesh, its fields and the path of the main file, and writes all files.
    slices
        Takes a `SlicedMesh` and the path, and writes the same; None if all of the mesh is needed at once.
    speller
        Returns the names of a mesh's groups as the files spell them; None if the files have ids only.
    alone
        Writes one file that needs no other; by default the ``writer``.
    beside
        A further file, which not all meshes need.
    """

    files: tuple[str, ...]  # ends of the files' names, the main one first, without the pieces of a partition
    writer: str
    speller: str | None
    orders: tuple[int, ...] = (1,)  # of the triangles that it can hold
    points: bool = False  # whether it holds labelled points
    periodic: bool = False  # whether it holds the matching nodes of periodic sides
    partition: bool = False  # whether it holds the parts of triangles or nodes
    quads: bool = False  # whether it holds quadrilaterals; else their halves are written
    sizes: bool = False  # whether it holds sizes, which are those in the plane in which a mesh is packed
    piece: str | None = None  # end of the name of each part's file, with {} for its number
    alone: str | None = None
    slices: str | None = None
    beside: Beside | None = None
    solvers: tuple[str, ...] = ()  # that get it; docs/solvers.md says why

    def ends(self, parts: int) -> tuple[str, ...]:
        """Ends of the names of all files of a mesh in so many parts: 1 without a partition.

        CaseError if a file for each part makes too many of them.
        """
        if self.piece is None:
            return self.files
        if parts > MOST_PIECES:
            raise CaseError(f"{self.files[0]} has a file for each part, {MOST_PIECES:,} at most: ask for fewer parts")
        return (*self.files, *map(self.piece.format, range(parts)))

    def text_beside(self, mesh: "Mesh") -> dict[str, str]:
        """Text of the file that a mesh needs beside those of the writer, by the end of its name, if it needs one."""
        text = None if self.beside is None else _loaded(self.beside.text)(mesh)
        return {} if self.beside is None or text is None else {self.beside.end: text}

    def load(self) -> None:
        """Load the writer now; by default it is loaded when it is used."""
        for function in (self.writer, self.slices):
            if function is not None:
                _loaded(function)

    def write(self, mesh: "Mesh", fields: "Fields", path: Path, *, alone: bool = False) -> None:
        """Write a mesh to the main file's path, and the other files beside it, or ``alone`` to one file only."""
        _loaded((alone and self.alone) or self.writer)(mesh if self.quads else mesh.in_triangles(), fields, path)

    def write_slices(self, mesh: "SlicedMesh", path: Path) -> None:
        """Write a mesh, slice by slice, to the main file's path, and the other files beside it."""
        assert self.slices is not None
        _loaded(self.slices)(mesh, path)

    def names(self, mesh: "Mesh") -> dict[str, str] | None:
        """Spelling of each group's name; None if the format holds no names."""
        return None if self.speller is None else _loaded(self.speller)(mesh)

    def holds_all_of(self, mesh: "Mesh") -> bool:
        """Whether it can hold the labelled points and periodic pairs of a mesh."""
        return (self.points or not len(mesh.labelled_nodes)) and (self.periodic or not len(mesh.periodic))


_FOR_MSH = ("fenicsx", "scikit-fem", "mfem", "firedrake", "getdp")
_AS_THEY_ARE = "groups.as_they_are"
FORMATS: Mapping[str, Format] = {
    "msh": Format(
        (".msh",),
        "write.gmsh.write_msh",
        _AS_THEY_ARE,
        BOTH,
        points=True,
        periodic=True,
        partition=True,
        quads=True,
        solvers=_FOR_MSH,
    ),
    "vtu": Format((".vtu",), "write.viewers.write_vtu", None, BOTH, partition=True, quads=True),
    "vtk": Format((".vtk",), "write.viewers.write_vtk", None, BOTH, partition=True, quads=True),
    "xdmf": Format(
        XDMF_FILES,
        "write.xdmf.write_xdmf",
        None,
        BOTH,
        partition=True,
        quads=True,
        alone="write.xdmf.write_inline_xdmf",
        slices="write.xdmf.write_sliced_xdmf",
        solvers=("fenicsx",),
    ),
    "pvtu": Format(
        (".pvtu",),
        "write.pieces.write_pvtu",
        None,
        BOTH,
        partition=True,
        quads=True,
        piece=PIECE,
        alone="write.viewers.write_vtu",
        slices="write.pieces.write_sliced_pvtu",
    ),
    "msh-ascii": Format(
        (".msh",),
        "write.gmsh.write_msh_ascii",
        _AS_THEY_ARE,
        BOTH,
        points=True,
        periodic=True,
        partition=True,
        quads=True,
        solvers=("moose", "elmer"),
    ),
    "msh4": Format(
        (".msh",),
        "write.msh4.write_msh4",
        _AS_THEY_ARE,
        BOTH,
        points=True,
        periodic=True,
        partition=True,
        quads=True,
        slices="write.sliced_msh4.write_sliced_msh4",
    ),
    "mesh": Format(
        (".mesh",),
        "write.fem.write_medit",
        None,
        points=True,
        quads=True,
        beside=Beside(".sol", "write.fem.medit_metric"),
        solvers=("freefem",),
    ),
    "pos": Format((".pos",), "write.pos.write_pos", None, sizes=True),
    "inp": Format(
        (".inp",),
        "write.fem.write_plane_stress",
        "write.fem.set_names",
        BOTH,
        points=True,
        quads=True,
        solvers=("calculix", "abaqus"),
    ),
    "inp-strain": Format(
        (".inp",), "write.fem.write_plane_strain", "write.fem.set_names", BOTH, points=True, quads=True
    ),
    "su2": Format((".su2",), "write.flow.write_su2", "write.flow.marker_names", quads=True, solvers=("su2",)),
    "med": Format(
        (".med",), "write.fem.write_med", "groups.plain_words", BOTH, points=True, quads=True, solvers=("code-aster",)
    ),
    "dat": Format((".dat",), "write.viewers.write_tecplot", None, partition=True, quads=True),
    "openfoam": Format(
        (".msh",), "write.flow.write_openfoam", "write.flow.patch_names", quads=True, solvers=("openfoam",)
    ),
    "nodes.csv": Format(
        (".nodes.csv",),
        "write.nodes.write_csv",
        _AS_THEY_ARE,
        points=True,
        partition=True,
        slices="write.nodes.write_sliced_csv",
    ),
    "nodes.npz": Format(
        (".nodes.npz",),
        "write.nodes.write_npz",
        _AS_THEY_ARE,
        points=True,
        periodic=True,
        partition=True,
        slices="write.nodes.write_sliced_npz",
    ),
    "skfem": Format((".vtu",), "write.python.write_skfem", "write.python.skfem_names", BOTH, solvers=("scikit-fem",)),
    "ngsolve": Format(
        (".msh",), "write.gmsh.write_words", "groups.plain_words", points=True, quads=True, solvers=("ngsolve",)
    ),
    "dealii": Format((".msh",), "write.gmsh.write_boundary", _AS_THEY_ARE, solvers=("dealii",)),
    "fort.14": Format((".14",), "write.coasts.write_adcirc", "write.coasts.edge_labels", solvers=("adcirc",)),
    "gr3": Format((".gr3",), "write.coasts.write_schism", "write.coasts.edge_labels", quads=True, solvers=("schism",)),
    "2dm": Format((".2dm",), "write.coasts.write_sms", None, quads=True),
    "slf": Format((".slf", ".cli"), "write.telemac.write_telemac", "write.coasts.edge_labels", solvers=("telemac",)),
    "ugrid": Format((".nc",), "write.ugrid.write_ugrid", "write.ugrid.words", quads=True, solvers=("delft3d",)),
    "sfepy": Format((".vtk",), "write.python.write_sfepy", None, points=True, solvers=("sfepy",)),
}
FORMATS_FOR: Mapping[str, tuple[str, ...]] = {
    solver: tuple(name for name, form in FORMATS.items() if solver in form.solvers)
    for solver in dict.fromkeys(solver for form in FORMATS.values() for solver in form.solvers)
}

if TYPE_CHECKING:
    FormatName = str
    Solver = str
else:
    FormatName = Literal[tuple(FORMATS)]
    Solver = Literal[tuple(FORMATS_FOR)]


def format_named(name: str) -> Format:
    """The format of a name; CaseError if it is unknown."""
    if name not in FORMATS:
        raise CaseError(unknown("format", name, FORMATS, len(FORMATS)))
    return FORMATS[name]


def formats_for(solvers: Iterable[str]) -> tuple[str, ...]:
    """Formats of all of the solvers, each once; KeyError if a solver is unknown."""
    return tuple(dict.fromkeys(name for solver in solvers for name in FORMATS_FOR[solver]))


def whole_only(formats: Iterable[str]) -> list[str]:
    """The formats, among these, that need all of a mesh at once."""
    return [name for name in formats if format_named(name).slices is None]


def without_partition(formats: Iterable[str]) -> list[str]:
    """The formats, among these, that cannot hold a partition."""
    return [name for name in formats if not format_named(name).partition]


def formats_by_ending(file: str) -> list[str]:
    """The formats with the ending of a file name, which must have a stem; endings may be in capital letters."""
    ends = {name: form.files[0] for name, form in FORMATS.items()}
    return [name for name, end in ends.items() if file.lower().endswith(end) and len(file) > len(end)]


def unknown_ending(file: str, advice: str = "") -> CaseError:
    """Error for a file whose name has the ending of no format; further advice follows that on endings."""
    ends = ", ".join(dict.fromkeys(form.files[0] for form in FORMATS.values()))
    return CaseError(f"{file}: unknown ending for a mesh file: choose one of {ends}{advice}")


def stem_of(file: str, name: str) -> str:
    """The name of a file without the ending of its format."""
    return file[: -len(FORMATS[name].files[0])]


def require_order(formats: Iterable[str], order: int) -> None:
    """Check that all formats can hold triangles of an order; CaseError if not."""
    for name in formats:
        if order not in format_named(name).orders:
            able = ", ".join(known for known, form in FORMATS.items() if order in form.orders)
            raise CaseError(f"{name} has no form for triangles of order {order}: choose among {able}, or order 1")


def require_no_sizes(formats: Iterable[str]) -> None:
    """Check that no format holds sizes, if coordinates are not those of the packing; CaseError if one does."""
    for name in formats:
        if format_named(name).sizes:
            raise CaseError(f"{name} holds sizes, which are no lengths in the system of crs.to: set crs.to: auto")


def _loaded(function: str) -> Callable[..., Any]:
    """The function of a name such as ``write.gmsh.write_msh`` in this package."""
    module, _, name = function.rpartition(".")
    loaded: Callable[..., Any] = getattr(import_module(f"{__package__}.{module}"), name)
    return loaded
