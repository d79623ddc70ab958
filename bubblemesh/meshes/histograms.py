"""Histograms of the quality of meshes, for pages, pictures and the terminal."""

import numpy as np

from bubblemesh.arrays import Floats, Integers, quantile
from bubblemesh.records import record

_HIGHEST_START = 0.8  # highest beginning of a scale of qualities
_FEW = 0.01  # share of the values that may be below the beginning
_WIDE = 0.5  # a histogram of edge length over spacing goes so far to either side of 1


@record
class Histogram:
    """Counts (b,) of values in bins between edges (b + 1,), and the numbers of values below and above all bins."""

    edges: Floats
    counts: Integers
    below: int
    above: int

    @property
    def total(self) -> int:
        """Number of all values."""
        return int(self.counts.sum()) + self.below + self.above


def histogram(values: Floats, low: float, high: float, bins: int) -> Histogram:
    """Count values (n,) in equal bins from ``low`` to ``high``, which belongs to the last one."""
    counts, edges = np.histogram(values, bins=bins, range=(low, high))
    return Histogram(edges, counts, int((values < low).sum()), int((values > high).sum()))


def lowest_shown(ratios: Floats) -> float:
    """A round number below nearly all radius ratios (t,), at which a scale up to 1 may begin."""
    return float(np.clip(np.floor(10 * quantile(ratios, _FEW)) / 10, 0, _HIGHEST_START))


def quality_histogram(ratios: Floats, bins: int, low: float) -> Histogram:
    """Histogram of radius ratios (t,) from ``low`` to 1."""
    # An equilateral triangle's ratio may exceed 1 by rounding.
    return histogram(np.minimum(ratios, 1), low, 1.0, bins)


def spacing_histogram(ratios: Floats, bins: int) -> Histogram:
    """Histogram of edge lengths over the target spacing (e,), around 1."""
    return histogram(ratios, 1 - _WIDE, 1 + _WIDE, bins)
