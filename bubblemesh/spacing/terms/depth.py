"""Spacings that follow the depth of water: the length of waves, the slope of the bed, and the Courant number.

References
----------
M. E. Hagen, J. J. Westerink, R. L. Kolar and O. Horstmann, "Two-dimensional, unstructured mesh generation for tidal
models", International Journal for Numerical Methods in Fluids 35 (2001). K. J. Roberts, W. J. Pringle and
J. J. Westerink, "OceanMesh2D 1.0", Geoscientific Model Development 12 (2019).
"""

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import Key
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.terms.combination import Term

GRAVITY = 9.81  # m/s2
COURANT = Key(["spacing", "courant"])


def wave_speed(depth: Floats) -> Floats:
    """Speed of long waves in water of some depth, in metres per second."""
    return np.sqrt(GRAVITY * depth)


@record
class NodeDepth:
    """A depth that a mesh is written with."""

    function: Term
    over: float | None = None  # length between its values, if means over the cells of nodes are written


@record
class Deep:
    """Depth of water, that of the shallowest where it is less or none."""

    depth: Term
    shallowest: float  # metres

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Depths (n,) at x (n,) and y (n,), in metres."""
        return np.fmax(self.depth(x, y), self.shallowest)


@record
class Waves:
    """So many nodes in the length of a long wave: sqrt(g h) T / n."""

    depth: Deep
    period: float  # seconds
    per_length: float

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Spacing (n,) at x (n,) and y (n,)."""
        return wave_speed(self.depth(x, y)) * (self.period / self.per_length)


@record
class Slope:
    """So many nodes while the depth changes by 2 pi times itself: 2 pi h / (n |grad h|)."""

    depth: Deep
    per_slope: float
    across: float  # length over which the depth is compared

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Spacing (n,) at x (n,) and y (n,), infinite where the bed is level."""
        half = self.across / 2
        steep = np.hypot(
            self.depth(x + half, y) - self.depth(x - half, y), self.depth(x, y + half) - self.depth(x, y - half)
        )
        with np.errstate(divide="ignore"):
            return 2 * np.pi * self.across * self.depth(x, y) / (self.per_slope * steep)


@record
class NotBelow:
    """A spacing that is nowhere so fine that a wave passes more than a share of it in a time step."""

    spacing: Spacing
    depth: Deep
    dt: float  # seconds
    largest: float  # Courant number sqrt(g h) dt / d

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Spacing (n,) at x (n,) and y (n,)."""
        return np.maximum(self.spacing.function(x, y), self._least(x, y))

    def keys(self, points: Floats) -> list[Key]:
        """Keys (n) of what sets the spacing at points (n, 2)."""
        x, y = points.T
        over = self._least(x, y) > self.spacing.function(x, y)
        given = self.spacing.keys(points)
        return [COURANT if mine else key for mine, key in zip(over.tolist(), given, strict=True)]

    def _least(self, x: Floats, y: Floats) -> Floats:
        return wave_speed(self.depth(x, y)) * (self.dt / self.largest)
