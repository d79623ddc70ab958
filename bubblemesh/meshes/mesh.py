"""The product: a triangle mesh with labelled edges, regions and points."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, Self

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.meshes.edges import SideTable, edge_keys, find_keys, numbered_edges
from bubblemesh.meshes.quality import Shape, radius_ratios, shape_quality

ROUNDING = 1e-9  # of a shift: what is less in one direction is none


class PeriodicSides(NamedTuple):
    """Two sides, by their labels, of which the second is the first one moved to the right, or else upwards."""

    first: int
    second: int
    shift: Floats  # (2,) from the first side to the second
    nodes: Integers  # (k, 2) of the first side, and their counterparts on the second


@dataclass(frozen=True, eq=False)
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

    def __post_init__(self) -> None:
        if len(self.triangle_regions) == 0:
            object.__setattr__(self, "triangle_regions", np.zeros(len(self.triangles), np.int64))
        if len(self.facet_middles) == 0:
            object.__setattr__(self, "facet_middles", self.points[self.facets[:, :2]].mean(axis=1))

    def __repr__(self) -> str:
        return f"<Mesh: {len(self.points)} nodes, {len(self.triangles)} triangles, labels {', '.join(self.labels)}>"

    @property
    def order(self) -> int:
        """1 for triangles with straight edges, 2 for those with a node on each edge."""
        return 1 if self.triangles.shape[1] == 3 else 2

    @cached_property
    def sides(self) -> Integers:
        """Triangle and side (f, 2) on whose left each facet lies: side k goes from corner k to corner k + 1."""
        return np.column_stack(self._side_table.owner(self._side_table.find(self.facets)))

    @cached_property
    def outer(self) -> Booleans:
        """Mask (f,) of the facets that are boundary edges: those with a triangle on one side only."""
        forth, back = (self._side_table.find(pairs) for pairs in (self.facets, self.facets[:, 1::-1]))
        return (forth < 0) != (back < 0)

    @cached_property
    def _side_table(self) -> SideTable:
        return SideTable.of(self.triangles[:, :3], len(self.points))

    @cached_property
    def periodic_sides(self) -> tuple[PeriodicSides, ...]:
        """Pairs of sides whose nodes match, by their labels."""
        labels, which = np.unique(self.facet_labels[self.periodic], axis=0, return_inverse=True)
        return tuple(self._matching(a, b, self.periodic[which == k]) for k, (a, b) in enumerate(labels.tolist()))

    def _matching(self, first: int, second: int, pairs: Integers) -> PeriodicSides:
        """The sides that pairs (p, 2) of facets make up."""
        here, there = self.facets[pairs[:, 0]], self.facets[pairs[:, 1]].copy()
        there[:, :2] = there[:, 1::-1]
        nodes = np.unique(np.column_stack([here.ravel(), there.ravel()]), axis=0)
        shift = (self.points[nodes[:, 1]] - self.points[nodes[:, 0]]).mean(axis=0)
        shift[np.abs(shift) < ROUNDING * np.abs(shift).max()] = 0
        if tuple(shift) > (0, 0):
            return PeriodicSides(first, second, shift, nodes)
        # One order for all pairs: chains of counterparts, as at the corners of a hexagon, then end.
        return PeriodicSides(second, first, 0 - shift, nodes[:, ::-1])

    def second_order(self) -> tuple[Self, int]:
        """The mesh with a node on each edge, those of the facets on the true curves; and how many of them are not.

        A curve may bulge farther than a flat triangle can follow without folding over; its facet then stays straight.
        """
        corners, n = self.triangles[:, :3], len(self.points)
        edges, of_triangle = numbered_edges(corners)
        middles = self.points[edges].mean(axis=1)
        mine = find_keys(edge_keys(edges, n), edge_keys(np.sort(self.facets[:, :2], axis=1), n))
        straight = middles[mine].copy()
        middles[mine] = self.facet_middles
        folded = np.zeros(len(edges), bool)
        folded[of_triangle[_folded(self.points[corners], middles[of_triangle])]] = True
        kept_straight = folded[mine]
        middles[mine[kept_straight]] = straight[kept_straight]
        curved = replace(
            self,
            points=np.vstack([self.points, middles]),
            triangles=np.hstack([corners, n + of_triangle]),
            facets=np.column_stack([self.facets[:, :2], n + mine]),
        )
        bulging = (self.facet_middles != straight).any(axis=1)
        return curved, int((kept_straight & bulging).sum())

    def quality(self) -> Shape:
        """Mean, least and first percentile of the triangles' radius ratios, their histogram, and extreme angles."""
        return shape_quality(self.points, self.triangles[:, :3])

    def to_meshio(self) -> Any:
        """A `meshio.Mesh` with labels, regions and labelled points as cell sets, and with Gmsh's ids."""
        from bubblemesh.meshfiles.write.gmsh import as_meshio

        result = as_meshio(self)
        ids = result.cell_data["gmsh:physical"]
        for name, (tag, _) in result.field_data.items():
            result.cell_sets[name] = [np.flatnonzero(of_block == tag) for of_block in ids]
        return result

    def plot(
        self,
        path: Path | str | None = None,
        *,
        color: str = "quality",
        title: str | None = None,
        style: str = "screen",
        fields: Mapping[str, Floats] = MappingProxyType({}),
        **options: Any,
    ) -> Any:
        """Draw the mesh, and write the picture if a path (.png, .svg, .pdf) is given.

        Parameters
        ----------
        path : Path or str, optional
        color : str
            ``quality``, ``spacing``, ``label``, ``material``, ``none`` or the name of a field.
        title, style
            Text above the picture; ``screen`` or ``paper``.
        fields : mapping of str to (t,)
            Data of the triangles, such as ``Result.fields``, which ``spacing`` needs.
        **options
            ``colormap``, ``limits``, ``edges``, ``nodes``, ``labels``, ``view``, ``width`` and ``dpi``, as the options
            of ``bubblemesh plot``.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        CaseError
            If the ending or the colouring is unknown.
        FileError
            If the picture cannot be written.
        """
        from bubblemesh.pictures.colouring import MeshData
        from bubblemesh.pictures.plots import draw_mesh, mesh_figure
        from bubblemesh.pictures.styles import PlotOptions

        shown = PlotOptions(color=color, title=title, style=style, **options)
        if path is not None:
            return draw_mesh(self, Path(path), shown, MeshData(fields))
        return mesh_figure(self, shown, MeshData(fields))

    def write(self, path: Path | str) -> list[str]:
        """Write the mesh in the format of the path's ending, with STEM.report.json, and return the files' names.

        Raises
        ------
        CaseError
            If the ending is unknown, or its format has no form for the order of the triangles.
        FileError
            If a file cannot be written; then none is.
        """
        from bubblemesh.meshfiles.writing import write_file

        ratios = radius_ratios(self.points, self.triangles[:, :3])
        figures = {"nodes": len(self.points), "triangles": len(self.triangles), "quality": self.quality()}
        return list(write_file(self, {"quality": ratios}, figures, Path(path))["files"])


def _folded(corners: Floats, middles: Floats) -> Booleans:
    """Mask (t,) of curved triangles, corners (t, 3, 2) and edge nodes (t, 3, 2), whose map is not one to one.

    The Jacobian determinant of the map is a quadratic polynomial: it is positive if its Bernstein coefficients are.
    """
    # Twice the derivatives along edges 0-1 and 0-2 as linear functions, by their values at the three corners.
    a, b, c = np.moveaxis(corners, 1, 0)
    ab, bc, ca = np.moveaxis(middles, 1, 0)
    u = np.stack([4 * ab - 3 * a - b, a + 3 * b - 4 * ab, 4 * bc - 4 * ca - b + a], axis=1)
    v = np.stack([4 * ca - 3 * a - c, 4 * bc - 4 * ab - c + a, a + 3 * c - 4 * ca], axis=1)
    product = u[:, :, None, 0] * v[:, None, :, 1] - u[:, :, None, 1] * v[:, None, :, 0]
    coefficients = (product + product.swapaxes(1, 2)) / 2
    return (coefficients <= 0).any(axis=(1, 2))
