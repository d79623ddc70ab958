"""The shallow-water equations in finite volumes on triangles, in NumPy: well balanced, and no volume is lost.

    d eta/dt + div q = 0,   dq/dt + div(q q/h + g h^2/2) = g h grad(depth) - drag |q| q / h^2 - f k x q

The level eta and the discharge q = h u are constant in each triangle, with h = eta + depth. Fluxes are those of HLL
between states with the lesser of both depths (Audusse et al. 2004, https://doi.org/10.1137/S1064827503431090), so that
water at rest stays so to the last bit. Walls let nothing pass; where the sea is open the level is prescribed, and the
velocity follows from the wave that leaves. Nothing falls dry: the depth is nowhere less than ``SHALLOWEST``.
"""

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.meshes.edges import SideTable
from bubblemesh.meshes.mesh import Mesh

GRAVITY = 9.81
SHALLOWEST = 5.0  # metres, more than the tide falls
DRAG = 2.5e-3
TURNING = 1.1e-4  # f, per second


class State(NamedTuple):
    """Level (t,) in metres above still water and discharge (t, 2) in square metres per second, in each triangle."""

    level: Floats
    discharge: Floats


@dataclass(frozen=True)
class Grid:
    """Triangles as finite volumes."""

    areas: Floats  # (t,)
    depth: Floats  # (t,) of still water
    middles: Floats  # (t, 2)
    left: Integers  # (e,) triangle on one side of each edge
    right: Integers  # (e,) triangle on its other side; the same one at the boundary
    normals: Floats  # (e, 2) of length 1, from left to right
    lengths: Floats  # (e,)
    outer: Booleans  # (e,) edges of the boundary
    opened: Booleans  # (e,) those to the open sea

    @classmethod
    def of(cls, mesh: Mesh, depth: Floats, label: str) -> Self:
        """Volumes of a mesh with depths (n,) at its nodes, which is open where facets have the label."""
        table = SideTable.of(mesh.triangles, len(mesh.points))
        opposite = table.opposite()
        once = np.flatnonzero(opposite < np.arange(len(opposite)))  # -1 at the boundary
        outer = opposite[once] < 0
        left, _ = table.owner(once)
        right = np.where(outer, left, table.owner(opposite[once])[0])
        facets = mesh.facets[mesh.facet_labels == mesh.labels.index(label)]
        opened = np.isin(once, np.concatenate([table.find(facets), table.find(facets[:, ::-1])])) & outer
        start, end = mesh.points[table.sides[once].T]
        normals = (end - start)[:, ::-1] * (1, -1)
        lengths = np.hypot(*normals.T)
        (x0, y0), (x1, y1), (x2, y2) = mesh.points[mesh.triangles].transpose(1, 2, 0)
        areas = ((x1 - x0) * (y2 - y0) - (y1 - y0) * (x2 - x0)) / 2
        still = np.maximum(depth[mesh.triangles].mean(axis=1), SHALLOWEST)
        middles = mesh.points[mesh.triangles].mean(axis=1)
        return cls(areas, still, middles, left, right, normals / lengths[:, None], lengths, outer, opened)

    def at_rest(self) -> State:
        """Still water."""
        return State(np.zeros(len(self.areas)), np.zeros((len(self.areas), 2)))

    def volume(self, state: State) -> float:
        """Volume above still water, in cubic metres."""
        return float(self.areas @ state.level)

    def courant(self, state: State, step: float) -> float:
        """Largest share of a triangle that waves pass in a step: the scheme is stable up to 1."""
        depth = self.depth + state.level
        speed = np.hypot(*state.discharge.T) / depth + np.sqrt(GRAVITY * depth)
        around = np.bincount(self.left, self.lengths, len(self.areas)) + np.bincount(
            self.right, self.lengths * ~self.outer, len(self.areas)
        )
        return float((speed * around * step / (2 * self.areas)).max())


def advanced(grid: Grid, state: State, step: float, tide: float | None) -> tuple[State, float]:
    """The state after a time step, and the volume that came in through the open boundary meanwhile.

    The ``tide`` is the level there; without it the open boundary is a wall too.
    """
    fluxes = _fluxes(grid, state, tide) * (grid.lengths * step)
    inner, count = ~grid.outer, len(grid.areas)
    gain = [
        np.bincount(grid.right[inner], into[inner], count) - np.bincount(grid.left, out, count)
        for out, into in zip(fluxes[:3], fluxes[[0, 3, 4]], strict=True)
    ]
    level = state.level + gain[0] / grid.areas
    discharge = state.discharge + np.column_stack(gain[1:]) / grid.areas[:, None]
    slowed = discharge / (1 + step * DRAG * np.hypot(*discharge.T) / (level + grid.depth) ** 2)[:, None]
    cos, sin = np.cos(TURNING * step), np.sin(TURNING * step)
    return State(level, slowed @ np.array([[cos, -sin], [sin, cos]])), -float(fluxes[0, grid.opened].sum())


def _fluxes(grid: Grid, state: State, tide: float | None) -> Floats:
    """Fluxes (5, e) of volume, of momentum out of the left triangle, and of momentum into the right one."""
    (nx, ny), sides = grid.normals.T, np.stack([grid.left, grid.right])
    lesser = grid.depth[sides].min(axis=0)
    h = state.level[sides] + lesser
    u, v = np.moveaxis((state.discharge / (grid.depth + state.level)[:, None])[sides], 2, 0)
    across, along = u * nx + v * ny, v * nx - u * ny
    volume, thrust = _hll(h, across)
    volume[grid.outer] = 0
    thrust[grid.outer] = GRAVITY / 2 * h[0, grid.outer] ** 2
    if tide is not None:
        sea = grid.opened
        ahead = tide + lesser[sea]
        speed = across[0, sea] + 2 * np.sqrt(GRAVITY) * (np.sqrt(h[0, sea]) - np.sqrt(ahead))  # u + 2 c leaves
        volume[sea] = ahead * speed
        thrust[sea] = ahead * speed**2 + GRAVITY / 2 * ahead**2
    drift = volume * np.where(volume > 0, *along)
    # The pressure of each side's own water has no resultant around a triangle: without it, rest is exact.
    out, into = thrust - GRAVITY / 2 * h**2
    return np.stack([volume, *(f for push in (out, into) for f in (push * nx - drift * ny, push * ny + drift * nx))])


def _hll(h: Floats, u: Floats) -> tuple[Floats, Floats]:
    """Fluxes (e,) of volume and momentum between states (2, e) of depth and velocity across each edge."""
    c = np.sqrt(GRAVITY * h)
    slow, fast = np.minimum((u - c).min(axis=0), 0), np.maximum((u + c).max(axis=0), 0)
    share = slow / (fast - slow)
    q = h * u
    thrust = q * u + GRAVITY / 2 * h**2
    return (
        q[0] + share * (q[0] - q[1] + fast * (h[1] - h[0])),
        thrust[0] + share * (thrust[0] - thrust[1] + fast * (q[1] - q[0])),
    )
