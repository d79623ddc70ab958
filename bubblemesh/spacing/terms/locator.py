"""Triangle locator: the triangle of a mesh that holds a point, and the nearest place on the rim for points outside."""

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, members
from bubblemesh.geometry.distance.chord_runs import ChordRuns
from bubblemesh.geometry.distance.nearest_chord import nearest_chord
from bubblemesh.meshes.edges import directed_sides, one_sided
from bubblemesh.records import record
from bubblemesh.spacing.grid.quadtree import Quadtree


@record
class MeshRim:
    """Edges with triangles on one side only, also where the triangles beside each other have nodes of their own."""

    nodes: Integers  # (k, 2): nodes of the edges, in closed loops
    runs: ChordRuns  # the edges

    @classmethod
    def of(cls, points: Floats, triangles: Integers) -> "MeshRim":
        """Rim of triangles (t, 3) that turn either way and have an area."""
        _, places = np.unique(points, axis=0, return_inverse=True)
        a, b, c = np.moveaxis(points[triangles], 1, 0)
        clockwise = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) < (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
        turned = np.where(clockwise[:, None], triangles[:, ::-1], triangles)
        edges = directed_sides(turned)
        edges = edges[one_sided(places[edges], len(points))]
        nodes = edges[_along_loops(*places[edges].T)]
        return cls(nodes, ChordRuns.of(points[nodes[:, 0]], points[nodes[:, 1]]))

    def nearest(self, points: Floats) -> tuple[Integers, Floats]:
        """Nodes (m, 2) of the edges nearest to points (m, 2), and the shares (m,) of the ways along them."""
        edge = nearest_chord(self.runs, points)
        return self.nodes[edge], self.runs.feet(points, edge)[0]


def _along_loops(start: Integers, end: Integers) -> Integers:
    """Edges (k,) in the order of loops."""
    following = np.empty_like(start)
    following[np.argsort(end, kind="stable")] = np.argsort(start, kind="stable")
    follow, seen = following.tolist(), [False] * len(start)
    order: list[int] = []
    for edge in range(len(follow)):
        while not seen[edge]:
            seen[edge] = True
            order.append(edge)
            edge = follow[edge]
    return np.array(order)


IN_A_CELL = 12  # triangles: cells with more are split
LOCATOR_LEVELS = 25
PAIRS_PER_TRIANGLE = 16  # pairs of cells and triangles, per triangle: thin triangles would meet ever more cells
SLACK = 1e-6  # of a cell: points on its sides count for it
ROUNDING = 1e-9  # of a triangle's height: so far outside a point counts as inside
AT_A_TIME = 1 << 16  # points, so that the arrays stay in the processor's caches


@record
class TriangleLocator:
    """Triangles, and cells of a quadtree with the few of them that each one meets."""

    low: Floats  # (2,): origin of the coordinates of cells and maps
    maps: Floats  # (t, 6): first corner of each triangle, and the matrix that gives the weights of the other two
    grid: Quadtree
    begin: Integers  # (n + 1,): where the candidates of each cell begin
    candidates: Integers  # (k,): triangles that may meet the cells, the likeliest first

    @classmethod
    def of(cls, corners: Floats) -> "TriangleLocator":
        """Locator for triangles with ``corners`` (t, 3, 2), none of them without an area; they may turn either way."""
        low = corners.min(axis=(0, 1))
        corners = corners - low
        maps = _maps(corners)
        grid, cell, triangle = _candidates(corners, maps)
        second, third = _weights(maps[triangle], grid.centers[cell])
        likelihood = np.minimum(np.minimum(second, third), 1 - second - third)
        order = np.lexsort((-likelihood, cell))
        begin = np.searchsorted(cell[order], np.arange(len(grid) + 1))
        return cls(low, maps, grid, begin, triangle[order])

    def located(self, points: Floats) -> tuple[Integers, Floats]:
        """Triangles (m,) that hold the points (m, 2), -1 for none, and weights (2, m) of their last two corners."""
        triangle, weights = np.full(len(points), -1), np.zeros((2, len(points)))
        for k in range(0, len(points), AT_A_TIME):
            self._find(points[k : k + AT_A_TIME] - self.low, triangle[k:], weights[:, k:])
        return triangle, weights

    def _find(self, points: Floats, triangle: Integers, weights: Floats) -> None:
        cell = self.grid.located(points)
        left, at, end = np.arange(len(points)), self.begin[cell], self.begin[cell + 1]
        while True:
            more = at < end
            left, at, end = left[more], at[more], end[more]
            if len(left) == 0:
                return
            candidate = self.candidates[at]
            second, third = _weights(self.maps[candidate], points[left])
            inside = (second >= -ROUNDING) & (third >= -ROUNDING) & (second + third <= 1 + ROUNDING)
            found = left[inside]
            triangle[found], weights[0, found], weights[1, found] = candidate[inside], second[inside], third[inside]
            left, at, end = left[~inside], at[~inside] + 1, end[~inside]


def _maps(corners: Floats) -> Floats:
    """Rows (t, 6): first corner, and inverse of the matrix whose columns are the edges from there."""
    a = corners[:, 0]
    (ux, uy), (vx, vy) = (corners[:, 1] - a).T, (corners[:, 2] - a).T
    return np.column_stack([a, np.stack([vy, -vx, -uy, ux], axis=1) / (ux * vy - uy * vx)[:, None]])


def _weights(maps: Floats, points: Floats) -> tuple[Floats, Floats]:
    """Barycentric coordinates (m,) of points (m, 2) for the last two corners of the triangles of the maps (m, 6)."""
    x, y = points[:, 0] - maps[:, 0], points[:, 1] - maps[:, 1]
    return maps[:, 2] * x + maps[:, 3] * y, maps[:, 4] * x + maps[:, 5] * y


def _candidates(corners: Floats, maps: Floats) -> tuple[Quadtree, Integers, Integers]:
    """Cells, and pairs (k,) of cells and triangles that may meet; few triangles for each cell."""
    grid = Quadtree.around((0.0, 0.0, *corners.max(axis=(0, 1)).tolist()))
    low, high = corners.min(axis=1), corners.max(axis=1)
    boxes = np.column_stack([(low + high) / 2, (high - low) / 2])
    cell, triangle = np.zeros(len(maps), np.int64), np.arange(len(maps))
    while len(cell) <= PAIRS_PER_TRIANGLE * len(maps):
        crowded = np.bincount(cell, minlength=len(grid)) > IN_A_CELL
        split = crowded & (grid.level < LOCATOR_LEVELS)
        if not split.any():
            break
        grid, origin, _ = grid.split(split)
        # The quarters of a cell follow each other where it was.
        parts = np.where(split[cell], 4, 1)
        pair, rank = members(parts)
        first = np.searchsorted(origin, np.arange(len(split)))
        cell, triangle = first[cell][pair] + rank, triangle[pair]
        kept = (parts == 1)[pair]
        new = np.flatnonzero(~kept)
        kept[new] = _meeting(grid, cell[new], boxes[triangle[new]], maps[triangle[new]])
        cell, triangle = cell[kept], triangle[kept]
    return grid, cell, triangle


def _meeting(grid: Quadtree, cell: Integers, boxes: Floats, maps: Floats) -> Booleans:
    """Whether cells (k,) meet triangles with ``boxes`` and ``maps`` beside them: no side of either parts the two."""
    centers, half = grid.centers[cell], grid.sides[cell] / 2 * (1 + SLACK)
    meeting = np.abs(centers[:, 0] - boxes[:, 0]) <= half + boxes[:, 2]
    meeting &= np.abs(centers[:, 1] - boxes[:, 1]) <= half + boxes[:, 3]
    second, third = _weights(maps, centers)
    a, b, c, d = maps.T[2:]
    for weight, u, v in ((second, a, b), (third, c, d), (1 - second - third, a + c, b + d)):
        meeting &= weight >= -half * (np.abs(u) + np.abs(v)) - ROUNDING
    return meeting
