"""Metrics to mesh in, as keys of a case and as functions of NumPy alone, and the measures of meshes in them.

What other tools run imports this, with nothing but NumPy.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

SQUARE = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
LONGEST = 0.06  # size along, and the largest one
SAMPLES = 1200  # points along each side of the box in which the ideal number is summed up
GOOD = 0.5**0.5, 2.0**0.5  # lengths of edges
# Names that expressions of cases know, for NumPy to evaluate them.
NAMES = {name: getattr(np, name) for name in ("sin", "cos", "hypot", "pi", "floor")}
NAMES |= {"abs": np.abs, "min": np.minimum, "max": np.maximum, "atan2": np.arctan2}


@dataclass(frozen=True)
class Directed:
    """A metric by expressions in x and y."""

    angle: str
    across: str

    @property
    def keys(self) -> dict[str, Any]:
        """Keys of a case."""
        return {"angle": self.angle, "across": self.across, "along": LONGEST}

    def __call__(self, points: Array) -> Array:
        """Tensors (n, 3) at points (n, 2)."""
        names = NAMES | {"x": points[:, 0], "y": points[:, 1]}
        angle, across = (
            np.broadcast_to(eval(text, {"__builtins__": {}}, names), len(points)) for text in (self.angle, self.across)
        )
        across = np.minimum(across, LONGEST)
        c, s, a, b = np.cos(angle), np.sin(angle), LONGEST**-2.0, across**-2.0
        return np.column_stack([a * c * c + b * s * s, (a - b) * c * s, a * s * s + b * c * c])


@dataclass(frozen=True)
class Problem:
    """A metric in a convex polygon."""

    name: str
    metrics: tuple[Directed, ...]  # the smallest size counts
    corners: tuple[tuple[float, float], ...] = SQUARE

    def __call__(self, points: Array) -> Array:
        """Tensors (n, 3) at points (n, 2)."""
        result = self.metrics[0](points)
        for metric in self.metrics[1:]:
            result = intersection(result, metric(points))
        return result

    @property
    def case(self) -> dict[str, Any]:
        """The case that meshes it."""
        return {
            "name": "metric",
            "domain": {"outer": {"polygon": [list(corner) for corner in self.corners]}},
            "spacing": LONGEST,
            "metric": [metric.keys for metric in self.metrics],
        }


def intersection(some: Array, others: Array) -> Array:
    """Tensors (n, 3) of which both of two (n, 3) are diagonal, with the larger entries."""
    full = [np.moveaxis(np.array([[m[:, 0], m[:, 1]], [m[:, 1], m[:, 2]]]), 2, 0) for m in (some, others)]
    _, basis = np.linalg.eig(np.linalg.solve(full[0], full[1]))
    entries = [np.einsum("nji,njk,nki->ni", basis, m, basis) for m in full]
    back = np.linalg.inv(basis)
    m = np.einsum("nji,nj,njk->nik", back, np.maximum(*entries), back)
    return np.column_stack([m[:, 0, 0], m[:, 0, 1], m[:, 1, 1]])


def layer(across: float) -> Problem:
    """A layer along y = 0.5 + 0.2 sin 2 pi x."""
    wide = "abs(y - 0.5 - 0.2*sin(2*pi*x))/hypot(1, 0.4*pi*cos(2*pi*x))"
    metric = Directed("atan2(0.4*pi*cos(2*pi*x), 1)", f"min({across} + 0.2*{wide}, {LONGEST})")
    return Problem(f"layer, aspect {LONGEST / across:.0f}", (metric,))


def leg(x: float, y: float) -> Directed:
    """A layer along the line from the middle of the square to a point, and on around its end."""
    length = np.hypot(x - 0.5, y - 0.5)
    c, s = (x - 0.5) / length, (y - 0.5) / length
    ahead, aside = f"({c:.9f}*(x - 0.5) + {s:.9f}*(y - 0.5))", f"({c:.9f}*(y - 0.5) - {s:.9f}*(x - 0.5))"
    return Directed(f"{np.arctan2(s, c):.9f}", f"min(0.004 + 0.2*hypot({aside}, min({ahead}, 0)), {LONGEST})")


def hexagon(side: int) -> Problem:
    """A hexagon that a lattice of equal ellipses fills."""
    across = LONGEST / 10
    turns = np.arange(6) * np.pi / 3
    x, y = side * LONGEST * np.cos(turns), side * across * np.sin(turns)
    corners = tuple((float(a), float(b)) for a, b in zip(x, y, strict=True))
    return Problem("uniform stretch, aspect 10", (Directed("0.0", f"{across}"),), corners)


TURN = "(10*hypot(x - 0.5, y - 0.5) - atan2(y - 0.5, x - 0.5)/(2*pi))"  # of the spiral, plus a whole number on it
PROBLEMS = (
    layer(0.02),
    layer(0.004),
    layer(0.001),
    Problem("shock with a corner, aspect 15", (leg(0.0, 0.3), leg(1.0, 0.2))),
    Problem(
        "circle, aspect 12",
        (
            Directed(
                "atan2(y - 0.5, x - 0.5) + pi/2",
                f"min(0.005 + 0.2*abs(hypot(x - 0.5, y - 0.5) - 0.3), {LONGEST})",
            ),
        ),
    ),
    Problem(
        "spiral, aspect 12",
        (
            Directed(
                "atan2(y - 0.5, x - 0.5) + pi/2 - atan2(0.1, 2*pi*hypot(x - 0.5, y - 0.5))",
                f"min(0.005 + 0.02*abs({TURN} - floor({TURN} + 0.5)) + 0.2*max(0.1 - hypot(x - 0.5, y - 0.5), 0), "
                f"{LONGEST})",
            ),
        ),
    ),
    Problem(
        "random smooth field, aspect 2 to 12",
        (Directed("1.3*sin(3*x + y) + cos(4*y - 2*x)", "0.0175 + 0.0125*sin(7*x - 2*y)*cos(5*y + x)"),),
    ),
    hexagon(6),
)


@dataclass(frozen=True)
class Figures:
    """Figures of a mesh in a metric: quality at the centroids, and lengths of edges by the metrics of both ends."""

    nodes: float
    ideal: float
    mean: float
    p01: float
    least: float
    within: float  # share of the edges between 0.71 and 1.41
    inverted: int


def figures(problem: Problem, points: Array, triangles: Array) -> Figures:
    """Figures of a mesh."""
    corners = points[triangles]
    tensors = problem(corners.mean(axis=1))
    a, b, c = (_lengths(tensors, corners[:, i] - corners[:, j]) for i, j in ((2, 1), (0, 2), (1, 0)))
    q = (b + c - a) * (c + a - b) * (a + b - c) / (a * b * c)
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    edges = np.unique(np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    along = points[edges[:, 1]] - points[edges[:, 0]]
    first, last = (_lengths(problem(points[edges[:, end]]), along) for end in (0, 1))
    same = np.abs(last / first - 1) < 1e-6
    length = np.where(same, first, (last - first) / np.log(np.where(same, np.e, last / first)))
    within = float(((length >= GOOD[0]) & (length <= GOOD[1])).mean())
    return Figures(
        len(points),
        ideal_nodes(problem),
        float(q.mean()),
        float(np.quantile(q, 0.01)),
        float(q.min()),
        within,
        int((areas <= 0).sum()),
    )


def ideal_nodes(problem: Problem) -> float:
    """Nodes of a perfect packing: by the area and the length of the boundary in the metric."""
    corners = np.array(problem.corners)
    low, high = corners.min(axis=0), corners.max(axis=0)
    steps = (np.arange(SAMPLES) + 0.5) / SAMPLES
    grid = low + np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2) * (high - low)
    sides = np.roll(corners, -1, axis=0) - corners
    offset = grid[:, None] - corners
    inside = (sides[:, 0] * offset[..., 1] - sides[:, 1] * offset[..., 0] > 0).all(axis=1)
    m11, m12, m22 = problem(grid[inside]).T
    area = np.sqrt(m11 * m22 - m12 * m12).sum() * np.prod((high - low) / SAMPLES)
    along = sum(
        _lengths(problem(corner + steps[:, None] * side), np.broadcast_to(side, (SAMPLES, 2))).mean()
        for corner, side in zip(corners, sides, strict=True)
    )
    return float(2 / np.sqrt(3) * area + along / 2 + 1)


def _lengths(tensors: Array, vectors: Array) -> Array:
    (m11, m12, m22), (x, y) = tensors.T, vectors.T
    return np.sqrt(m11 * x * x + 2 * m12 * x * y + m22 * y * y)
