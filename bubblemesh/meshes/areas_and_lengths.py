"""Areas of the regions of a mesh and lengths of its labels."""

from collections.abc import Sequence
from typing import Any, NamedTuple, Self

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.meshes.mesh import Mesh


class RegionArea(NamedTuple):
    """A region of a mesh: its name, the number of its triangles, and the sum of their areas."""

    name: str
    triangles: int
    area: float


class LabelLength(NamedTuple):
    """A label of a mesh: its name, the number of its edges, and the sum of their lengths."""

    name: str
    edges: int
    length: float


class RegionSums(NamedTuple):
    """Number and area of the triangles in each of r regions; those of several pieces of a mesh can be added up."""

    triangles: Integers  # (r,)
    areas: Floats  # (r,)

    @classmethod
    def of(cls, areas: Floats, region: Integers) -> Self:
        """Sums of triangles with these areas (t,) in these regions (t,)."""
        return cls(np.bincount(region), np.bincount(region, areas).astype(float))

    @classmethod
    def together(cls, parts: "Sequence[RegionSums]") -> Self:
        """Sums of all pieces, which may know different numbers of regions."""
        most = max(len(part.areas) for part in parts)
        triangles, areas = np.zeros(most, np.int64), np.zeros(most)
        for part in parts:
            triangles[: len(part.areas)] += part.triangles
            areas[: len(part.areas)] += part.areas
        return cls(triangles, areas)

    def named(self, names: Sequence[str], index: Integers) -> tuple[RegionArea, ...]:
        """Areas by name, of those that have triangles; ``index`` (r or more,) into the names tells each region's."""
        index = index[: len(self.areas)]
        triangles = np.bincount(index, self.triangles, len(names)).astype(np.int64).tolist()
        areas = np.bincount(index, self.areas, len(names)).tolist()
        rows = map(RegionArea, names, triangles, areas)
        return tuple(row for row in rows if row.triangles)


def areas_and_lengths(mesh: Mesh, areas: Floats) -> dict[str, Any]:
    """Figures of the regions and labels of a mesh whose triangles have these areas (t,), as a report holds them."""
    regions = RegionSums.of(areas, mesh.triangle_regions).named(mesh.regions, np.arange(len(mesh.regions)))
    return {"regions": regions, "labels": label_lengths(mesh)}


def label_lengths(mesh: Mesh) -> tuple[LabelLength, ...]:
    """Lengths of the labels of a mesh, or of a frame without triangles: those of straight edges between corners."""
    start, end = np.moveaxis(mesh.points[mesh.facets[:, :2]], 1, 0)
    count = len(mesh.labels)
    edges = np.bincount(mesh.facet_labels, minlength=count).tolist()
    lengths = np.bincount(mesh.facet_labels, np.hypot(*(end - start).T), count).tolist()
    return tuple(map(LabelLength, mesh.labels, edges, lengths))
