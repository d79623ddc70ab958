"""A mesh that is too large to be held at once: what all of it has in common, and slices of nodes and triangles."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.meshes.edges import find_sides
from bubblemesh.meshes.mesh import Mesh


class Slice(NamedTuple):
    """Nodes and triangles, whose numbers follow those of the slices before."""

    points: Floats  # (n, 2)
    triangles: Integers  # (t, 3): numbers of nodes in the whole mesh
    regions: Integers  # (t,): index into the names of the regions
    fields: Mapping[str, Floats]  # of the triangles


@dataclass(frozen=True, eq=False)
class SlicedMesh:
    """A conforming triangle mesh of a plane domain, of which only a frame is held.

    Attributes
    ----------
    frame : Mesh
        All facets, labels and regions of the mesh; its points are the first ones of the mesh, which triangles of
        several slices may have. It has no triangles.
    outer : (f,)
        Mask of the facets that are boundary edges.
    sizes : (k, 2)
        Number of nodes and of triangles of each slice.
    fields : tuple of str
        Names of the fields of the triangles.
    read : callable
        Gives a slice by its number; the nodes of the first one follow those of the frame.
    """

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

    def slices(self) -> Iterator[Slice]:
        """All slices, one after the other."""
        return map(self.read, range(len(self.sizes)))

    def sample(self, count: int, field: str) -> tuple[Mesh, dict[str, Floats]]:
        """A mesh of the triangles around that of the least value of a field, at most ``count``, and their fields.

        They are all of one slice; labelled points and periodic pairs are left out.
        """
        number = min(range(len(self.sizes)), key=lambda number: float(self.read(number).fields[field].min()))
        part, frame, first = self.read(number), self.frame, int(self.first_nodes[number])
        used, corners = np.unique(part.triangles, return_inverse=True)
        shared = used < len(frame.points)
        points = np.concatenate([frame.points[used[shared]], part.points[used[~shared] - first]])
        triangles = corners.reshape(-1, 3)
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
