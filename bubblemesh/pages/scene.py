"""Data from which the script of a report's page draws the mesh: arrays sorted by byte, compressed, in base64."""

import base64
import json
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.quads import diagonals
from bubblemesh.meshes.quality import LAYER
from bubblemesh.meshfiles.text import json_ready
from bubblemesh.pages.markup import Markup, html, tag
from bubblemesh.pictures.colouring import Colouring, MeshData, colouring_of
from bubblemesh.pictures.styles import REGION_COLOURS
from bubblemesh.records import record

STEPS = 256


@record
class Scene:
    """A mesh with its colourings: radius ratio, edge length, and edge length over target spacing."""

    mesh: Mesh
    quality: Colouring
    size: Colouring
    ratio: Colouring
    packed: Booleans  # (t,) the triangles whose shape is judged: all but the cells of boundary layers
    worst: Integers  # (w,) those of least quality among these, the worst first

    @classmethod
    def of(cls, mesh: Mesh, fields: Mapping[str, Floats], most_worst: int) -> "Scene":
        """Scene of a mesh with fields (t,): ``target_spacing``, and ``layer`` if the mesh has boundary layers."""
        data = MeshData(fields)
        quality = colouring_of(mesh, data, "quality")
        size = colouring_of(mesh, data, "size")
        ratio = colouring_of(mesh, data, "spacing")
        assert quality is not None
        assert size is not None
        assert ratio is not None
        packed = np.asarray(fields[LAYER] == 0) if LAYER in fields else np.ones(len(mesh.triangles), bool)
        judged = np.flatnonzero(packed)
        worst = judged[np.argsort(quality.values[judged], kind="stable")[:most_worst]]
        return cls(mesh, quality, size, ratio, packed, worst)

    @property
    def corners(self) -> Integers:
        """Nodes (t, 3) at the corners of the triangles."""
        return self.mesh.triangles[:, :3]

    def blocks(self) -> Markup:
        """The data for the page's script."""
        mesh, origin = self.mesh, self.mesh.points.min(axis=0)
        extent = float(np.ptp(mesh.points, axis=0).max())
        order = np.argsort(mesh.facet_labels, kind="stable")
        largest = float(self.ratio.values.max())
        return html(
            json_block("head", self._head(origin, extent, largest)),
            array_block("points", fixed_point(mesh.points - origin, 0, extent)),
            array_block("triangles", relative(self.corners)),
            array_block("diagonals", self._diagonals()),
            array_block("quality", fixed_point(self.quality.values, 0, 1, np.uint16)),
            array_block("size", fixed_point(np.asarray(self.size.norm(self.size.values)), 0, 1, np.uint8)),
            array_block("ratio", fixed_point(self.ratio.values, 0, largest, np.uint16)),
            array_block("region", mesh.triangle_regions.astype(np.uint16)),
            array_block("facets", mesh.facets[order, :2].astype(np.uint32)),
        )

    def _diagonals(self) -> NDArray[np.uint32]:
        """Sides (2 q,) of triangles that are diagonals of quadrilaterals, as 3 * triangle + side."""
        quads = self.mesh.quads
        return (3 * quads + diagonals(self.corners, quads)).ravel().astype(np.uint32)

    def _head(self, origin: Floats, extent: float, largest_ratio: float) -> dict[str, Any]:
        """Counts, names, scales and colour tables, by which the script reads and draws the arrays."""
        mesh = self.mesh
        counts = np.bincount(mesh.facet_labels, minlength=len(mesh.labels))
        starts = np.cumsum(counts) - counts
        return {
            "origin": origin,
            "extent": extent,
            "largestRatio": largest_ratio,
            "limits": {"quality": self.quality.limits, "size": (0, 1), "ratio": self.ratio.limits},
            "tables": {
                "quality": _table(self.quality),
                "size": _table(self.size),
                "ratio": _table(self.ratio),
                "region": "".join(color[1:] for color in REGION_COLOURS),
            },
            "labels": [
                {"name": name, "start": start, "count": count}
                for name, start, count in zip(mesh.labels, starts, counts, strict=True)
            ],
            "regions": [{"name": name, "at": self._middle_of(k)} for k, name in enumerate(mesh.regions)],
            "points": [
                {"name": mesh.point_labels[label], "node": node}
                for node, label in zip(mesh.labelled_nodes.tolist(), mesh.node_labels.tolist(), strict=True)
            ],
            "worst": self.worst,
        }

    def _middle_of(self, region: int) -> int:
        """The triangle of a region that is nearest to the region's centre."""
        mine = np.flatnonzero(self.mesh.triangle_regions == region)
        centroids = self.mesh.points[self.corners[mine]].mean(axis=1)
        return int(mine[np.hypot(*(centroids - centroids.mean(axis=0)).T).argmin()])


def _table(scale: Colouring) -> str:
    """Colours from one end of a scale to the other, six hexadecimal digits each."""
    levels = (255 * scale.colormap(np.linspace(0, 1, STEPS))[:, :3]).round().astype(np.uint8)
    return levels.tobytes().hex()


def array_block(name: str, columns: NDArray[Any]) -> Markup:
    """Embed an array of unsigned integers (n,) or (n, k), column by column.

    First come the lowest bytes of all numbers, then the next ones: similar bytes side by side compress far better.
    """
    flat = np.ascontiguousarray(columns.T).reshape(-1)
    planes = flat.astype(flat.dtype.newbyteorder("<")).view(np.uint8).reshape(-1, flat.dtype.itemsize).T
    text = base64.b64encode(zlib.compress(planes.tobytes(), 6)).decode()
    return tag("script", Markup(text), type="text/plain", id=name, data_width=flat.dtype.itemsize)


def json_block(name: str, data: Any) -> Markup:
    """Embed data as JSON; no text in it can end the element."""
    text = json.dumps(json_ready(data), ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return tag("script", Markup(text.replace("<", "\\u003c")), type="application/json", id=name)


def fixed_point(values: Floats, low: float, high: float, kind: type = np.uint32) -> NDArray[Any]:
    """Values as unsigned integers of a type, 0 for ``low`` and the largest of the type for ``high``."""
    largest = np.iinfo(kind).max
    return np.round(np.clip((values - low) / (high - low), 0, 1) * largest).astype(kind)


def relative(triangles: Integers) -> NDArray[np.uint32]:
    """Nodes of triangles (t, 3) as small numbers: differences of first nodes, and of the others to their first one.

    Signs are folded into the lowest bit: 0, -1, 1, -2, ... become 0, 1, 2, 3, ...
    """
    first = triangles[:, 0]
    steps = np.column_stack([np.diff(first, prepend=0), triangles[:, 1] - first, triangles[:, 2] - first])
    steps = steps.astype(np.int64)
    return np.where(steps < 0, -2 * steps - 1, 2 * steps).astype(np.uint32)
