"""A mesh that is too large for memory: a frame that all of it has in common, and slices of nodes and triangles."""

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.meshes.division import GEOMETRY
from bubblemesh.meshes.edges import find_sides
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.partition import Partition
from bubblemesh.records import record

AT_ONCE = 2  # slices in use at the same time


class Slice(NamedTuple):
    """Nodes and triangles, whose numbers follow those of the slices before."""

    points: Floats  # (n, 2)
    triangles: Integers  # (t, 3): numbers of nodes in the whole mesh
    regions: Integers  # (t,): index into the names of the regions
    fields: Mapping[str, Floats]  # of the triangles


class Border(NamedTuple):
    """The triangles along facets, at labelled points, and at nodes of several slices, as a small mesh."""

    mesh: Mesh  # with these triangles, and all facets and labelled points
    partition: Partition  # of these triangles into the slices
    nodes: Integers  # (m,): numbers of its nodes in the whole mesh, ascending
    cells: Integers  # (b,): numbers of its triangles in the whole mesh, ascending
    fields: Mapping[str, Floats]  # of its triangles
    crowded: Booleans  # (n,): mask of the nodes of the frame at which these triangles are


@record(eq=False)
class SlicedMesh:
    """A conforming triangle mesh of a plane domain, of which only a frame is in memory.

    Attributes
    ----------
    frame : Mesh
        All facets, labels and regions of the mesh, and its first points, which triangles of several slices may use. It
        has no triangles.
    outer : (f,)
        Mask of the facets that are boundary edges.
    sizes : (k, 2)
        Number of nodes and of triangles of each slice.
    fields : tuple of str
        Names of the fields of the triangles.
    read : callable
        Function that returns a slice by its number; the nodes of the first one follow those of the frame.
    """

    partition: ClassVar[None] = None  # slices are no parts for a parallel solver

    frame: Mesh
    outer: Booleans
    sizes: Integers
    fields: tuple[str, ...]
    read: Callable[[int], Slice]

    @property
    def nodes(self) -> int:
        """Number of all nodes."""
        return len(self.frame.points) + int(self.sizes[:, 0].sum())

    @property
    def triangles(self) -> int:
        """Number of all triangles."""
        return int(self.sizes[:, 1].sum())

    @property
    def first_nodes(self) -> Integers:
        """Number (k,) of the first node of each slice."""
        return len(self.frame.points) + np.cumsum(self.sizes[:, 0]) - self.sizes[:, 0]

    @property
    def first_triangles(self) -> Integers:
        """Number (k,) of the first triangle of each slice."""
        return np.cumsum(self.sizes[:, 1]) - self.sizes[:, 1]

    def slices(self) -> Iterator[Slice]:
        """All slices, one after the other; each is read while the one before is in use."""
        with ThreadPoolExecutor(1, "reader") as reader:
            following = reader.submit(self.read, 0)
            for number in range(1, len(self.sizes) + 1):
                part = following.result()
                if number < len(self.sizes):
                    following = reader.submit(self.read, number)
                yield part

    def side_by_side(self, use: Callable[[int, Slice], None]) -> None:
        """Call a function with each slice and its number, in several threads and in any order."""
        with ThreadPoolExecutor(AT_ONCE, "slices") as threads:
            try:
                for _ in threads.map(lambda number: use(number, self.read(number)), range(len(self.sizes))):
                    pass
            except BaseException:
                threads.shutdown(wait=False, cancel_futures=True)
                raise

    def points(self, nodes: Integers, number: int, part: Slice) -> Floats:
        """Places (..., 2) of nodes (...) of the frame or of the given slice, whose number is ``number``."""
        in_frame = nodes < len(self.frame.points)
        places = self.frame.points[np.where(in_frame, nodes, 0)]
        places[~in_frame] = part.points[nodes[~in_frame] - self.first_nodes[number]]
        return places

    def sample(self, count: int, field: str) -> tuple[Mesh, dict[str, Floats]]:
        """A mesh of at most ``count`` triangles around the one with the least value of a field, and their fields.

        All of them are in one slice; labelled points and periodic pairs are left out.
        """
        number = min(range(len(self.sizes)), key=lambda number: float(self.read(number).fields[field].min()))
        part, frame = self.read(number), self.frame
        used, corners = np.unique(part.triangles, return_inverse=True)
        points, triangles = self.points(used, number, part), corners.reshape(-1, 3)
        centers = points[triangles].mean(axis=1)
        away = np.hypot(*(centers - centers[part.fields[field].argmin()]).T)
        near = np.sort(np.argsort(away, kind="stable")[:count])
        nodes, corners = np.unique(triangles[near], return_inverse=True)
        triangles, numbers = corners.reshape(-1, 3), used[nodes]
        known = np.isin(frame.facets, numbers).all(axis=1)
        facets = np.searchsorted(numbers, frame.facets)
        sides = (find_sides(triangles, len(nodes), ends[known])[0] for ends in (facets, facets[:, ::-1]))
        mine = np.flatnonzero(known)[np.maximum(*sides) >= 0]
        labels, label = np.unique(frame.facet_labels[mine], return_inverse=True)
        regions, region = np.unique(part.regions[near], return_inverse=True)
        mesh = Mesh(
            points[nodes],
            triangles,
            facets[mine],
            label,
            tuple(frame.labels[k] for k in labels),
            tuple(frame.regions[k] for k in regions),
            region,
            facet_middles=frame.facet_middles[mine],
        )
        return mesh, {name: values[near] for name, values in part.fields.items()}

    def border(self) -> Border:
        """The triangles along facets and where slices meet; all slices are read twice."""
        frame, slices_at = self.frame, np.zeros(len(self.frame.points), np.int64)
        for part in self.slices():
            slices_at[np.unique(part.triangles[part.triangles < len(slices_at)])] += 1
        crowded = slices_at > 1
        crowded[frame.facets.ravel()] = crowded[frame.labelled_nodes] = True
        found = [self._at(crowded, number, part) for number, part in enumerate(self.slices())]
        owner = np.repeat(np.arange(len(found)), [len(each[0]) for each in found])
        cells, triangles, points, regions, *fields = (np.concatenate(each) for each in zip(*found, strict=True))
        nodes, first, corners = np.unique(triangles, return_index=True, return_inverse=True)
        corners = corners.reshape(-1, 3)
        mesh = replace(
            frame,
            points=points.reshape(-1, 2)[first],
            triangles=corners,
            facets=np.searchsorted(nodes, frame.facets),
            triangle_regions=regions,
            labelled_nodes=np.searchsorted(nodes, frame.labelled_nodes),
        )
        partition = Partition(corners, owner, len(found), GEOMETRY)
        return Border(mesh, partition, nodes, cells, dict(zip(self.fields, fields, strict=True)), crowded)

    def _at(self, crowded: Booleans, number: int, part: Slice) -> tuple[NDArray[Any], ...]:
        """Numbers, nodes, places (b, 3, 2), regions and fields of a slice's triangles at some nodes of the frame."""
        mine = np.flatnonzero(among(crowded, part.triangles).any(axis=1))
        nodes = part.triangles[mine]
        fields = (part.fields[name][mine] for name in self.fields)
        return self.first_triangles[number] + mine, nodes, self.points(nodes, number, part), part.regions[mine], *fields


def among(mask: Booleans, numbers: Integers) -> Booleans:
    """Values of a mask (n,) at numbers (...); False for numbers from n on."""
    return np.append(mask, False)[np.minimum(numbers, len(mask))]
