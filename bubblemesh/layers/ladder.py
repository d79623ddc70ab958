"""Heights of layers: what a case asks for on the walls of some labels."""

from dataclasses import field
from functools import cached_property

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import Key
from bubblemesh.records import record

MOST_LAYERS = 500  # that a case may ask for
LEAST_GROWTH, LARGEST_GROWTH = 0.5, 4.0  # that are looked for
RATIO_HALVINGS = 60


@record
class Ladder:
    """Layers on the walls of some labels, whose heights grow geometrically.

    Attributes
    ----------
    labels : tuple of str
        Names of sides and lines.
    first : float
        Height of the first layer.
    growth : float
        Ratio of the heights of successive layers.
    count : int
        Number of layers, at most.
    by_thickness : bool
        Whether their height in all is asked for.
    isotropic : bool
        Whether columns end where the height of their layers reaches the distance to their neighbours.
    fans : bool
        Whether columns fan out around convex corners.
    follow : bool
        Whether the last column follows a wall without layers where there is one.
    quads : bool
        Whether cells stay quadrilaterals in files that can hold them.
    region : str or None
        Region that has the layers, where both sides of a label's lines are in the domain.
    key : Key
        Key of the case that asks for them.
    """

    labels: tuple[str, ...]
    first: float
    growth: float
    count: int
    by_thickness: bool = False
    isotropic: bool = False
    fans: bool = True
    follow: bool = True
    quads: bool = False
    region: str | None = None
    key: Key = field(default_factory=Key)

    @cached_property
    def heights(self) -> Floats:
        """Heights (count,) of the layers, from the wall on."""
        return np.asarray(self.first * self.growth ** np.arange(self.count))

    @cached_property
    def tops(self) -> Floats:
        """Distances (count + 1,) from the wall at which layers end; the first one is 0."""
        return np.append(0.0, np.cumsum(self.heights))

    def thickness_below(self, spacing: Floats) -> Floats:
        """Height (n,) of all layers up to the first one that is higher itself than a spacing (n,)."""
        highest = np.maximum.accumulate(self.heights)  # they may fall where a thickness asks for that
        return np.asarray(self.tops[np.searchsorted(highest, spacing, side="right")])


def first_of(count: int, thickness: float, growth: float) -> float:
    """First height of so many layers with a thickness in all."""
    return thickness / float(np.sum(growth ** np.arange(count)))


def count_of(first: float, thickness: float, growth: float) -> int:
    """Number of layers that come nearest to a thickness, at least one."""
    ratio = thickness / first
    layers = ratio if growth == 1 else float(np.log1p(ratio * (growth - 1)) / np.log(growth))
    return max(round(layers), 1)


def growth_of(first: float, count: int, thickness: float) -> float:
    """Growth by which so many layers, more than one, have a thickness in all."""
    low, high = LEAST_GROWTH, LARGEST_GROWTH
    for _ in range(RATIO_HALVINGS):
        growth = (low + high) / 2
        low, high = (growth, high) if first * np.sum(growth ** np.arange(count)) < thickness else (low, growth)
    return (low + high) / 2
