"""The triangle mesh with labelled edges, regions and points that bubblemesh makes."""

import warnings
from collections.abc import Callable, Mapping
from dataclasses import field, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, Self

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.errors import MeshWarning
from bubblemesh.files import with_home
from bubblemesh.meshes.checks import checked, require_edges, require_triangles
from bubblemesh.meshes.edge_nodes import in_second_order, with_diagonals
from bubblemesh.meshes.edges import find_sides
from bubblemesh.meshes.mapping import mapped
from bubblemesh.meshes.metric import measures_of
from bubblemesh.meshes.partition import Partition
from bubblemesh.meshes.periodic import PeriodicSides, periodic_sides
from bubblemesh.meshes.quads import Cells, cell_numbers, cell_sides, cells_of
from bubblemesh.meshes.quality import Shape, shape_quality
from bubblemesh.messages import unknown
from bubblemesh.records import record


@record(eq=False)
class Mesh:
    """A conforming triangle mesh of a plane domain.

    Arrays may be given as lists. CaseError, which names the argument, if one has another kind or shape than it must
    have, or holds indices of what is not there. That facets are edges, each once for a label and with a triangle on its
    left, is checked when the mesh is written or given to another library; whether triangles overlap or leave gaps is
    not checked.

    Attributes
    ----------
    points : (n, 2)
        Node coordinates, first those of the boundary, of inner lines and of embedded points; every node belongs to a
        triangle.
    triangles : (t, 3) or (t, 6)
        Counter-clockwise node indices; in a mesh of second order also the nodes on edges 0-1, 1-2 and 2-0.
    facets : (f, 2) or (f, 3)
        Node indices of labelled edges: all boundary edges, with the domain on their left, and inner ones (interfaces
        of regions, with the region on their left whose label they have, and embedded lines, as these are drawn); in a
        mesh of second order also the node on the edge.
    facet_labels : (f,)
        Index into ``labels`` for each facet.
    labels : tuple of str
        Names of the facets' labels; each is used by at least one facet.
    regions : tuple of str
        Names of the regions; each has at least one triangle.
    triangle_regions : (t,)
        Index into ``regions`` for each triangle; all 0 unless given.
    labelled_nodes : (v,)
        Nodes that have a label of their own; by default there are none.
    node_labels : (v,)
        Index into ``point_labels`` for each of them.
    point_labels : tuple of str
        Names of the labelled points.
    facet_middles : (f, 2)
        Point halfway along the true curve that each facet follows; the middle of the facet itself unless given.
    periodic : (p, 2)
        Facets that match: the second is the first one moved across the domain, and runs the other way.
    partition : Partition or None
        How the triangles are divided among the processes of a parallel solver, if they are: see `partitioned`.
    quads : (q, 2)
        Pairs of triangles that are one quadrilateral in files whose formats hold such cells, and in `cells`: they share
        an edge, the diagonal, and have one region. A triangle is in one pair at most; by default there are no pairs.
    curved_edges : (c, 2)
        Edges that are curved in a mesh of second order, by their nodes, in addition to the facets; by default there are
        none. Diagonals of quadrilaterals need not be among them: their curves follow from those of the sides.
    curved_middles : (c, 2)
        Point where the node on each of them is in a mesh of second order.
    depth : (n,)
        Depth of the bed below still water at each node, for formats of coasts, NaN where it is not known; empty by
        default.
    metric : (n, 3)
        Entries m11, m12 and m22 of the metric at each node, for the file beside Medit's; empty by default.
    open_labels : tuple of str
        Labels of open water, for formats of coasts; by default those that are named ``open``, or ``open`` with anything
        but a letter behind it, such as ``open_west``, ``open-2`` and ``open 3``.
    ids : mapping of str to int
        Ids of one's own that files give labels, regions and labelled points, by their names there; by default there are
        none, and all have their numbers from 1. Names of nothing in the mesh do not count: a MeshWarning tells of them
        when the mesh is written or given to another library.
    geographic : bool
        Whether the coordinates are longitudes and latitudes, for formats that record this.
    fields : mapping of str to (t,)
        Data of the triangles when they were made, which `write` and `plot` use: ``quality`` and ``target_spacing``,
        and for a mesh in a metric its tensors ``metric_11``, ``metric_12`` and ``metric_22``; empty by default. `write`
        computes the quality again, from the present points.
    """

    points: Floats
    triangles: Integers
    facets: Integers
    facet_labels: Integers
    labels: tuple[str, ...]
    regions: tuple[str, ...] = ("domain",)
    triangle_regions: Integers = field(default_factory=lambda: np.zeros(0, np.int64))
    labelled_nodes: Integers = field(default_factory=lambda: np.zeros(0, np.int64))
    node_labels: Integers = field(default_factory=lambda: np.zeros(0, np.int64))
    point_labels: tuple[str, ...] = ()
    facet_middles: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    periodic: Integers = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    partition: Partition | None = None
    quads: Integers = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    curved_edges: Integers = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    curved_middles: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    depth: Floats = field(default_factory=lambda: np.zeros(0))
    metric: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    open_labels: tuple[str, ...] = ()
    ids: Mapping[str, int] = field(default_factory=dict)
    geographic: bool = False
    fields: Mapping[str, Floats] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, value in checked(self).items():
            object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        quads = f" ({len(self.quads)} pairs are quadrilaterals)" if len(self.quads) else ""
        cells = f"{len(self.points)} nodes, {len(self.triangles)} triangles{quads}"
        return f"<Mesh: {cells}, labels {', '.join(self.labels)}>"

    @property
    def order(self) -> int:
        """1 for triangles with straight edges, 2 for those with a node on each edge."""
        return 1 if self.triangles.shape[1] == 3 else 2

    @cached_property
    def cells(self) -> tuple[Cells, ...]:
        """Cells as files have them: first triangles that are not halves of quadrilaterals, then the quadrilaterals.

        Blocks that would be empty are left out.

        Quadrilaterals have four nodes, counter-clockwise, in a mesh of second order nine: the corners, the nodes on
        edges 0-1, 1-2, 2-3 and 3-0, and the one in the middle. The region of a cell is that of its first triangle,
        ``triangle_regions[cells.triangles[:, 0]]``.
        """
        return cells_of(self.triangles, self.quads)

    @cached_property
    def cell_numbers(self) -> Integers:
        """Number (t,) of the cell that each triangle is, or is half of, among all `cells` in their order."""
        return cell_numbers(self.cells, len(self.triangles))

    @cached_property
    def sides(self) -> Integers:
        """Triangle and side (f, 2) on whose left each facet lies: side k goes from corner k to corner k + 1."""
        return np.column_stack(find_sides(self.triangles[:, :3], len(self.points), self.facets))

    @cached_property
    def cell_sides(self) -> Integers:
        """Cell (as in `cell_numbers`) and number of its side (as in `sides`), (f, 2), on whose left each facet lies."""
        return cell_sides(self.cells, self.cell_numbers, self.sides, self.facets)

    @cached_property
    def outer(self) -> Booleans:
        """Mask (f,) of the facets that are boundary edges, with a triangle on one side only."""
        ends, triangles, n = self.facets[:, :2], self.triangles[:, :3], len(self.points)
        forth, back = (find_sides(triangles, n, pairs)[0] for pairs in (ends, ends[:, ::-1]))
        return (forth < 0) != (back < 0)

    @cached_property
    def periodic_sides(self) -> tuple[PeriodicSides, ...]:
        """Pairs of sides whose nodes match, by their labels."""
        return periodic_sides(self.points, self.facets, self.facet_labels, self.periodic)

    def second_order(self) -> tuple[Self, int]:
        """The mesh of second order, with a node on each edge, and the number of curved edges that had to stay straight.

        The nodes of facets and ``curved_edges`` are on their curves. If a cell would fold over, as a curve may bulge
        farther than a flat cell can follow, the edge stays straight. A mesh of second order is returned as it is.
        CaseError if one of the facets or ``curved_edges`` is not an edge.
        """
        return in_second_order(self)

    def mapped(self, function: Callable[[Floats], Floats]) -> Self:
        """The mesh with all of its points (n, 2) mapped by a function, for instance to another coordinate system.

        If the map mirrors, triangles and facets are reversed. The result has neither the ``metric`` nor the ``fields``,
        which belong to the old places. CaseError if the function does not return a finite place for each point, or
        mirrors some of the triangles only.
        """
        return mapped(self, function)

    def in_triangles(self) -> Self:
        """The mesh without quadrilaterals: their halves are plain triangles.

        In a mesh of second order the node on a diagonal moves to where triangles need it: with straight sides to the
        middle of the diagonal, which is not the middle of the quadrilateral.
        """
        if not len(self.quads):
            return self
        points = self.points if self.order == 1 else with_diagonals(self.points, self.triangles, self.quads)
        return replace(self, points=points, quads=self.quads[:0])

    def partitioned(self, parts: int) -> Self:
        """The mesh with a partition of its triangles into so many parts, for a parallel solver.

        Its files then have the part of each triangle and node, if their formats have a place for that. The mesh is
        divided by METIS if that is installed, else by geometry; see ``partition.by``. Matching nodes of periodic sides
        count as different nodes. Both halves of a quadrilateral are in one part. CaseError if there are fewer cells
        than parts.
        """
        return replace(self, partition=Partition.of(self.points, self.triangles, parts, self.quads))

    def quality(self) -> Shape:
        """Mean, least and first percentile of the triangles' radius ratios, their histogram, and extreme angles.

        Radius ratios are those in the metric if the mesh has one for its triangles; angles are those in space. Boundary
        layers are included, unlike in reports. CaseError if there are no triangles.
        """
        require_triangles(self)
        return shape_quality(measures_of(self.points, self.triangles[:, :3], self.fields))

    @classmethod
    def read(cls, path: Path | str) -> "Mesh":
        """Mesh of triangles from a file of any format that `bubblemesh quality` reads, with its labels and regions.

        - Quadrilaterals become two triangles each, which are a pair of ``quads`` if they are convex.
        - Triangles are turned counter-clockwise.
        - Boundary edges without a label get the label ``boundary``; a mesh without regions has the region ``domain``.
        - Names that the file does not hold are taken from NAME.labels.json beside it.
        - Of cells of higher order only the corners are read.
        - Of the data only a metric is kept, in ``fields`` and ``metric``: that of the triangles, or that of the nodes
          in a .sol beside a .mesh and in a .pos. The missing one is made of the other by the mean of logarithms.
        - Labelled points and periodic sides are read from ``.msh`` files of Gmsh.

        Warns
        -----
        MeshWarning
            If the file holds something that the mesh does not.

        Raises
        ------
        FileError
            If the file cannot be read, or holds no plane mesh of triangles.
        """
        from bubblemesh.meshfiles.whole_mesh import whole_mesh

        mesh, notes = whole_mesh(Path(with_home(path)))
        for note in notes:
            warnings.warn(f"{path}: {note}", MeshWarning, stacklevel=2)
        return mesh

    def to_meshio(self, columns: Literal[2, 3] = 2) -> Any:
        """A `meshio.Mesh` of the `cells`, with labels, regions and labelled points as cell sets, and with Gmsh's ids.

        Points have two ``columns``, or three, the last of which is 0, as formats of VTK and Gmsh need them.
        """
        from bubblemesh.meshfiles.libraries import to_meshio

        self._require_sound()
        return to_meshio(self, columns)

    def to_pyvista(self) -> Any:
        """A `pyvista.UnstructuredGrid` of the `cells` and, after them, of the labelled edges.

        The data of its cells are ``quality`` and ``group``, the number, from 1 on, of a label or region in
        ``field_data["groups"]``. FileError if the library is missing, with the command that installs it.
        """
        from bubblemesh.meshfiles.libraries import to_pyvista

        self._require_sound()
        return to_pyvista(self)

    def to_skfem(self) -> Any:
        """A `skfem.MeshTri`, or `MeshTri2`, whose boundaries and subdomains are the labels and the regions.

        FileError if the library is missing, with the command that installs it.
        """
        from bubblemesh.meshfiles.libraries import to_skfem

        self._require_sound()
        return to_skfem(self)

    def to_dolfinx(self, comm: Any = None) -> tuple[Any, Any, Any]:
        """A `dolfinx.mesh.Mesh`, and the tags of its cells and of its facets.

        The tags are the ids of the groups, as in mesh files: from 1 on for the labels, then for the regions. ``comm``
        is the MPI communicator over which the mesh is distributed, by default all processes. FileError if the library
        is missing, with the command that installs it.
        """
        from bubblemesh.meshfiles.libraries import to_dolfinx

        self._require_sound()
        return to_dolfinx(self, comm)

    def plot(
        self,
        path: Path | str | None = None,
        *,
        ax: Any = None,
        color: str | None = None,
        title: str | None = None,
        style: str = "screen",
        fields: Mapping[str, Floats] = MappingProxyType({}),
        **options: Any,
    ) -> Any:
        """Draw the mesh, and write the picture if a path (.png, .svg, .pdf) is given.

        Parameters
        ----------
        path : Path or str, optional
        ax : matplotlib.axes.Axes, optional
            Axes of an existing figure to draw into; without them a figure is made.
        color : str, optional
            ``quality``, ``size``, ``spacing``, ``label``, ``material``, ``none`` or the name of a field; by default
            the quality, or the size where there are too many triangles to see each. The quality is that in the metric
            if the mesh has one for its triangles.
        title, style
            Text above the picture; ``screen`` or ``paper``.
        fields : mapping of str to (t,) or (n,)
            Data of triangles or of nodes, by their length, in addition to the mesh's own ``fields``, or in place of
            those of the same name. Of vectors, (t, k) or (n, k), the length is shown.
        **options
            ``colormap``, ``limits``, ``edges``, ``nodes``, ``ellipses``, ``labels``, ``axes``, ``view``, ``width`` and
            ``dpi``, as the options of ``bubblemesh plot``; ``limits`` is its ``--range``.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        CaseError
            If the ending, the colouring or an option is unknown, data fits neither the triangles nor the nodes, or the
            mesh has no triangles.
        FileError
            If the picture cannot be written.
        """
        from bubblemesh.pictures.python import plotted

        require_triangles(self)
        return plotted(self, path, ax, fields, {"color": color, "title": title, "style": style, **options})

    def _repr_html_(self) -> str:
        """HTML that notebooks show: a picture of the mesh above its figures."""
        from bubblemesh.pictures.python import thumbnail

        return thumbnail(self)

    def write(self, path: Path | str, *, sidecars: bool = False) -> list[str]:
        """Write the mesh in the format of the path's ending, and return the names of the files: one in most formats.

        The ending may be in capital letters. Formats that hold data of triangles get the quality and the other
        ``fields``; beside STEM.mesh, STEM.sol is written with the metric at the nodes. Quadrilaterals are written as
        two triangles if the format has no such cells.

        With ``sidecars``, STEM.report.json has the figures of the mesh, and STEM.labels.json the names of all groups if
        the format has numbers or other words for them.

        Raises
        ------
        CaseError
            If the ending is unknown, its format cannot hold triangles of this order, or facets are no edges.
        FileError
            If a file cannot be written; then nothing is written.
        """
        from bubblemesh.meshfiles.writing import write_mesh

        self._require_sound()
        return write_mesh(self, Path(with_home(path)), sidecars=sidecars)

    def _require_sound(self) -> None:
        """Check what files and libraries rely on: facets that are edges; ids of unknown names are a MeshWarning."""
        from bubblemesh.meshfiles.groups import group_names

        require_edges(self)
        known = group_names(self) if self.ids else {}
        for name in self.ids.keys() - known.keys():
            text = unknown("label, region or point", name, known)
            warnings.warn(f"ids: {text}", MeshWarning, stacklevel=3)
