"""The product: a triangle mesh with labelled edges, regions and points."""

import warnings
from collections.abc import Callable, Mapping
from dataclasses import field, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, NamedTuple, Self

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, different_rows, unmasked
from bubblemesh.errors import CaseError, MeshWarning
from bubblemesh.meshes.edge_nodes import without_folds
from bubblemesh.meshes.edges import edge_keys, find_keys, find_sides, numbered_edges
from bubblemesh.meshes.metric import at_centroids, measures_of
from bubblemesh.meshes.partition import Partition
from bubblemesh.meshes.quads import Cells, cells_of, require_pairs
from bubblemesh.meshes.quality import Shape, shape_quality, signed_areas
from bubblemesh.records import record

ROUNDING = 1e-9  # of a shift: what is less in one direction is none


class PeriodicSides(NamedTuple):
    """Two sides, by their labels, of which the second is the first one moved to the right, or else upwards."""

    first: int
    second: int
    shift: Floats  # (2,) from the first side to the second
    nodes: Integers  # (k, 2) of the first side, and their counterparts on the second


@record(eq=False)
class Mesh:
    """A conforming triangle mesh of a plane domain.

    Attributes
    ----------
    points : (n, 2)
        Node coordinates, first those of the boundary, of inner lines and of embedded points; every node belongs to a
        triangle.
    triangles : (t, 3) or (t, 6)
        Counter-clockwise node indices; in a mesh of second order also the nodes on edges 0-1, 1-2 and 2-0.
    facets : (f, 2) or (f, 3)
        Node indices of labelled edges: all boundary edges, with the domain on their left, and inner ones (interfaces
        of regions, embedded lines); in a mesh of second order also the node on the edge.
    facet_labels : (f,)
        Index into ``labels`` for each facet.
    labels : tuple of str
        Names of the facets' labels; each is used by at least one facet.
    regions : tuple of str
        Names of the regions; each has at least one triangle.
    triangle_regions : (t,)
        Index into ``regions`` for each triangle; all 0 unless given.
    labelled_nodes : (v,)
        Nodes that have a label of their own; none unless given.
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
        an edge, the diagonal, and have one region. A triangle is in one pair at most; none is in any unless given.
    curved_edges : (c, 2)
        Edges beside the facets, by their nodes, that are curved in a mesh of second order; none unless given. The
        diagonals of quadrilaterals need not be among them: their curves follow from those of the sides.
    curved_middles : (c, 2)
        Point where the node on each of them is in a mesh of second order.
    depth : (n,)
        Depth of the bed below still water at each node, for formats of coasts; of no length unless given.
    metric : (n, 3)
        Entries m11, m12 and m22 of the metric at each node, for the file beside Medit's; of no length unless given.
    open_labels : tuple of str
        Labels of open water, for the same formats; unless given, ``open`` and what begins with ``open_``.
    geographic : bool
        Whether the coordinates are longitudes and latitudes, for formats that tell.
    fields : mapping of str to (t,)
        Data of the triangles as they were made, which `write` and `plot` use: ``quality`` and ``target_spacing``, of a
        mesh in a metric its tensors ``metric_11``, ``metric_12`` and ``metric_22``; none unless given. `write` finds
        the quality anew, of points where they are then.
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
    geographic: bool = False
    fields: Mapping[str, Floats] = field(default_factory=dict)

    def __post_init__(self) -> None:
        require_pairs(self.triangles, self.quads)
        if len(self.triangle_regions) == 0:
            object.__setattr__(self, "triangle_regions", np.zeros(len(self.triangles), np.int64))
        if len(self.facet_middles) == 0:
            object.__setattr__(self, "facet_middles", self.points[self.facets[:, :2]].mean(axis=1))

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
        """Cells as files have them: triangles that are no halves of quadrilaterals, then these; no block is empty.

        Quadrilaterals have four nodes, counter-clockwise, in a mesh of second order nine: the corners, the nodes on
        edges 0-1, 1-2, 2-3 and 3-0, and the one in the middle. The region of a cell is that of its first triangle,
        ``triangle_regions[cells.triangles[:, 0]]``.
        """
        return cells_of(self.triangles, self.quads)

    @cached_property
    def cell_numbers(self) -> Integers:
        """Number (t,) of the cell that each triangle is, or is half of, among all `cells` in their order."""
        number, before = np.zeros(len(self.triangles), np.int64), 0
        for nodes, triangles in self.cells:
            number[triangles] = before + np.arange(len(nodes))[:, None]
            before += len(nodes)
        return number

    @cached_property
    def sides(self) -> Integers:
        """Triangle and side (f, 2) on whose left each facet lies: side k goes from corner k to corner k + 1."""
        return np.column_stack(find_sides(self.triangles[:, :3], len(self.points), self.facets))

    @cached_property
    def cell_sides(self) -> Integers:
        """Number of the cell, as of `cell_numbers`, and side (f, 2) on whose left each facet lies, as of `sides`."""
        triangle, side = self.sides.T
        cell, side = np.where(triangle < 0, -1, self.cell_numbers[triangle]), side.copy()
        for nodes, triangles in self.cells:
            if triangles.shape[1] == 2:
                before = self.cell_numbers[triangles[0, 0]]
                here = np.flatnonzero((cell >= before) & (cell < before + len(nodes)))
                side[here] = np.argmax(nodes[cell[here] - before, :4] == self.facets[here, :1], axis=1)
        return np.column_stack([cell, side])

    @cached_property
    def outer(self) -> Booleans:
        """Mask (f,) of the facets that are boundary edges: those with a triangle on one side only."""
        ends, triangles, n = self.facets[:, :2], self.triangles[:, :3], len(self.points)
        forth, back = (find_sides(triangles, n, pairs)[0] for pairs in (ends, ends[:, ::-1]))
        return (forth < 0) != (back < 0)

    @cached_property
    def periodic_sides(self) -> tuple[PeriodicSides, ...]:
        """Pairs of sides whose nodes match, by their labels."""
        if len(self.periodic) == 0:
            return ()
        labels, which = np.unique(self.facet_labels[self.periodic], axis=0, return_inverse=True)
        return tuple(self._matching(a, b, self.periodic[which == k]) for k, (a, b) in enumerate(labels.tolist()))

    def _matching(self, first: int, second: int, pairs: Integers) -> PeriodicSides:
        """The sides that pairs (p, 2) of facets make up."""
        here, there = self.facets[pairs[:, 0]], self.facets[pairs[:, 1]].copy()
        there[:, :2] = there[:, 1::-1]
        nodes, _ = different_rows(np.column_stack([here.ravel(), there.ravel()]))
        shift = (self.points[nodes[:, 1]] - self.points[nodes[:, 0]]).mean(axis=0)
        shift[np.abs(shift) < ROUNDING * np.abs(shift).max()] = 0
        if tuple(shift) > (0, 0):
            return PeriodicSides(first, second, shift, nodes)
        # One order for all pairs: chains of counterparts, as at the corners of a hexagon, then end.
        return PeriodicSides(second, first, 0 - shift, nodes[:, ::-1])

    def second_order(self) -> tuple[Self, int]:
        """The mesh with a node on each edge, on the curves of facets and ``curved_edges``; and how many are not there.

        A curve may bulge farther than a flat cell can follow without folding over; its edge then stays straight. One of
        second order comes back as it is. CaseError if one of the ``curved_edges`` is no edge.
        """
        if self.order == 2:
            return self, 0
        corners, n = self.triangles[:, :3], len(self.points)
        edges, of_triangle = numbered_edges(corners)
        keys = edge_keys(edges, n)
        facets, others = (
            find_keys(keys, edge_keys(np.sort(pairs[:, :2], axis=1), n)) for pairs in (self.facets, self.curved_edges)
        )
        if (others < 0).any():
            raise CaseError(f"curved_edges: the nodes {self.curved_edges[np.argmin(others)].tolist()} have no edge")
        straight = self.points[edges].mean(axis=1)
        curved = straight.copy()
        curved[others] = self.curved_middles
        curved[facets] = self.facet_middles
        numbered = np.hstack([corners, of_triangle])
        middles, kept_straight = without_folds(self.points, numbered, self.quads, straight, curved)
        triangles = np.hstack([corners, n + of_triangle])
        result = replace(
            self,
            points=np.vstack([self.points, middles]),
            triangles=triangles,
            facets=np.column_stack([self.facets[:, :2], n + facets]),
            depth=np.append(self.depth, self.depth[edges].mean(axis=1)) if len(self.depth) else self.depth,
            metric=np.vstack([self.metric, at_centroids(edges, self.metric)]) if len(self.metric) else self.metric,
            partition=None if self.partition is None else self.partition.with_nodes(triangles),
        )
        return result, int(kept_straight.sum())

    def mapped(self, function: Callable[[Floats], Floats]) -> Self:
        """The mesh with all of its points (n, 2) where a function takes them, as another system of coordinates.

        Where that mirrors, triangles and facets are turned round. It has neither the ``metric`` nor the ``fields``,
        which belong to the places before. CaseError if the function does not give a finite place for each point, or
        turns some of the triangles only.
        """
        result = replace(
            self,
            points=_moved(self.points, function),
            facet_middles=_moved(self.facet_middles, function),
            curved_middles=_moved(self.curved_middles, function) if len(self.curved_middles) else self.curved_middles,
            metric=self.metric[:0],
            fields={},
        )
        turned = signed_areas(result.points, result.triangles) < 0
        if turned.any() and not turned.all():
            raise CaseError(f"function: turns {turned.sum()} of {len(turned)} triangles over: move all of them alike")
        return result._turned() if turned.any() else result

    def _turned(self) -> Self:
        """The mesh with triangles and facets the other way round."""
        order = self.triangles.shape[1] // 3
        triangles = self.triangles[:, [0, 2, 1, 5, 4, 3][: 3 * order]]
        partition = None if self.partition is None else self.partition.with_nodes(triangles)
        return replace(self, triangles=triangles, facets=self.facets[:, [1, 0, 2][: 1 + order]], partition=partition)

    def in_triangles(self) -> Self:
        """The mesh without quadrilaterals: their halves are triangles like others."""
        return replace(self, quads=self.quads[:0]) if len(self.quads) else self

    def partitioned(self, parts: int) -> Self:
        """The mesh with a partition of its triangles into so many parts, for a parallel solver.

        Its files tell the part of each triangle and node, if their formats have a place for that. METIS divides if it
        is installed, else geometry does; ``partition.by`` tells which. Matching nodes of periodic sides are different
        nodes here. Both halves of a quadrilateral come into one part. CaseError if there are fewer cells.
        """
        return replace(self, partition=Partition.of(self.points, self.triangles, parts, self.quads))

    def quality(self) -> Shape:
        """Mean, least and first percentile of the triangles' radius ratios, their histogram, and extreme angles.

        Radius ratios are those in the metric if the mesh has one for its triangles; angles are those in space. Boundary
        layers count, which reports leave out.
        """
        return shape_quality(measures_of(self.points, self.triangles[:, :3], self.fields))

    @classmethod
    def read(cls, path: Path | str) -> "Mesh":
        """Mesh of triangles from a file of any format that `bubblemesh quality` reads, with its labels and regions.

        Quadrilaterals are two triangles each, which are a pair of ``quads`` if they are convex. Triangles are turned
        counter-clockwise, edges of the boundary without a label are called ``boundary``, and a mesh without regions has
        the region ``domain``. Names that the file does not hold are taken from NAME.labels.json beside it. Of cells of
        higher order the corners are read. Of the data the mesh has a metric, in ``fields`` and ``metric``: that of the
        triangles, or of the nodes in a .sol beside a .mesh and in a .pos; the others have the mean of its logarithms.
        Labelled points and periodic sides are read from ``.msh`` files of Gmsh.

        Warns
        -----
        MeshWarning
            Of what the file holds and the mesh does not.

        Raises
        ------
        FileError
            If the file cannot be read, or holds no plane mesh of triangles.
        """
        from bubblemesh.meshfiles.whole import whole_mesh

        mesh, notes = whole_mesh(Path(path))
        for note in notes:
            warnings.warn(f"{path}: {note}", MeshWarning, stacklevel=2)
        return mesh

    def to_meshio(self, columns: Literal[2, 3] = 2) -> Any:
        """A `meshio.Mesh` of the `cells`, with labels, regions and labelled points as cell sets, and with Gmsh's ids.

        Points have two ``columns``, or three, the last of which is 0, as VTK's formats and Gmsh want them.
        """
        from bubblemesh.meshfiles.libraries import in_space
        from bubblemesh.meshfiles.write.gmsh import as_meshio

        if columns not in (2, 3):
            raise CaseError(f"columns: must be 2 or 3 (found {columns!r})")
        result = as_meshio(self)
        result.points = self.points if columns == 2 else in_space(self.points)
        ids = result.cell_data["gmsh:physical"]
        for name, (tag, _) in result.field_data.items():
            result.cell_sets[name] = [np.flatnonzero(of_block == tag) for of_block in ids]
        return result

    def to_pyvista(self) -> Any:
        """A `pyvista.UnstructuredGrid` of the `cells` and, after them, of the labelled edges.

        Its cells have ``group``, the number from 1 on of a label or region in ``field_data["groups"]``, and
        ``quality``. FileError if the library is missing, with the command that installs it.
        """
        from bubblemesh.meshfiles.libraries import to_pyvista

        return to_pyvista(self)

    def to_skfem(self) -> Any:
        """A `skfem.MeshTri`, or `MeshTri2`, whose boundaries and subdomains are the labels and the regions.

        FileError if the library is missing, with the command that installs it.
        """
        from bubblemesh.meshfiles.libraries import to_skfem

        return to_skfem(self)

    def to_dolfinx(self, comm: Any = None) -> tuple[Any, Any, Any]:
        """A `dolfinx.mesh.Mesh` with the tags of its cells and of its facets, which are the ids of the groups.

        The ids are those of mesh files: from 1 for the labels, then the regions. ``comm`` is the MPI communicator over
        which the mesh is spread, by default all processes. FileError if the library is missing, with the command that
        installs it.
        """
        from bubblemesh.meshfiles.libraries import to_dolfinx

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
            Axes to draw into, of a figure of one's own; without them a figure is made.
        color : str, optional
            ``quality``, ``size``, ``spacing``, ``label``, ``material``, ``none`` or the name of a field; by default
            the quality, or the size where there are too many triangles to see each. The quality is that in the metric
            if the mesh has one for its triangles.
        title, style
            Text above the picture; ``screen`` or ``paper``.
        fields : mapping of str to (t,) or (n,)
            More data of the triangles, or other data than the mesh's own ``fields``; data of as many values as there
            are nodes is that at the nodes. Of vectors, (t, k) or (n, k), the length is shown.
        **options
            ``colormap``, ``limits``, ``edges``, ``nodes``, ``ellipses``, ``labels``, ``view``, ``width`` and ``dpi``,
            as the options of ``bubblemesh plot``.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        CaseError
            If the ending, the colouring or an option is unknown, or data is neither of the triangles nor of the nodes.
        FileError
            If the picture cannot be written.
        """
        from bubblemesh.pictures.colouring import data_of
        from bubblemesh.pictures.plots import draw_into, draw_mesh, mesh_figure
        from bubblemesh.pictures.styles import plot_options

        shown = plot_options({"color": color, "title": title, "style": style, **options})
        data = data_of(self, fields)
        if ax is not None:
            if path is not None:
                raise CaseError("path: ax is drawn into a figure of your own: write that one by its savefig")
            draw_into(ax, self, shown, data)
            return ax.figure
        return mesh_figure(self, shown, data) if path is None else draw_mesh(self, Path(path), shown, data)

    def _repr_html_(self) -> str:
        """Picture of the mesh above its figures, as notebooks show it."""
        from bubblemesh.pictures.thumbnail import thumbnail

        return thumbnail(self)

    def write(self, path: Path | str, *, sidecars: bool = False) -> list[str]:
        """Write the mesh in the format of the path's ending, and return the names of the files: one in most formats.

        An ending may be in capital letters.

        Formats that hold data of triangles get the ``fields``, in any case the quality, and STEM.sol is written beside
        STEM.mesh for the metric at the nodes. Quadrilaterals are written as two triangles if the format does not hold
        them.

        With ``sidecars`` there are also STEM.report.json with the figures of the mesh, and STEM.labels.json with the
        names of all groups if the format has numbers or other words for them.

        Raises
        ------
        CaseError
            If the ending is unknown, or its format has no form for the order of the triangles.
        FileError
            If a file cannot be written; then none is.
        """
        from bubblemesh.meshfiles.writing import write_alone, write_file

        measures = measures_of(self.points, self.triangles[:, :3], self.fields)
        fields = {**self.fields, "quality": measures.radius_ratios}
        if not sidecars:
            return write_alone(self, fields, Path(path))
        figures = {"nodes": len(self.points), "triangles": len(self.triangles), "quality": self.quality()}
        return list(write_file(self, fields, figures, Path(path))["files"])


def _moved(points: Floats, function: Callable[[Floats], Floats]) -> Floats:
    """Points (n, 2) where a function takes them; CaseError if it gives no such array of finite numbers."""
    given = np.asarray(unmasked(function(points)))
    if given.dtype.kind not in "iuf" or given.shape != points.shape:
        found = f"an array of {given.dtype}, of the shape {given.shape}"
        raise CaseError(f"function: must give a place (n, 2) for each point, here {points.shape} (found {found})")
    bad = np.flatnonzero(~np.isfinite(given).all(axis=1))
    if len(bad):
        raise CaseError(f"function: gives no finite place for the point {points[bad[0]].tolist()}")
    return given.astype(float)
