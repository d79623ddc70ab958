"""The spacing in a metric: a size for each direction, checked wherever it is used."""

from collections.abc import Callable
from dataclasses import field
from typing import ClassVar

import numpy as np

from bubblemesh.arrays import Floats, Integers, turned_left
from bubblemesh.errors import Key, at_key
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.kernels.tensors import lengths, mean_lengths
from bubblemesh.meshes.metric import MeasuresInMetric
from bubblemesh.meshes.quality import Measures
from bubblemesh.meshes.tensors import Axes, axes, require_positive_definite
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing

EllipsesAt = Callable[[Floats, Floats], Axes]  # at the coordinates x (n,) and y (n,)

STRAIGHT = 1.2  # in the metric of its ends: the most that a straight edge along an ellipse may measure
ROUND = 1.2  # aspect up to which an ellipse is as good as a circle
CORRECTIONS = 2  # of the length of such an edge


# Functions with names travel to other processes.
@record
class AreaSizes:
    """Diameters of circles of the same area as ellipses; NaN where the metric is not positive and finite."""

    ellipses: EllipsesAt

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Diameters (n,) at x (n,) and y (n,)."""
        return self.ellipses(x, y).diameters


@record
class MetricSpacing(Spacing):
    """Desired distance between neighbouring nodes in each direction.

    As a spacing without direction it is the diameter of circles of the same area as its ellipses: of these as many
    nodes follow. Between the ends of an edge, and along a boundary, it is that in their direction.
    """

    in_metric: ClassVar[bool] = True
    noun: ClassVar[str] = "the metric"

    ellipses: EllipsesAt = field(kw_only=True)
    aspect: float = field(default=1.0, kw_only=True)  # of the longest ellipse in the domain
    bent: "MetricSpacing | None" = field(default=None, kw_only=True)  # the metric that this one straightens

    @classmethod
    def of(cls, ellipses: EllipsesAt, aspect: float = 1.0, bent: "MetricSpacing | None" = None) -> "MetricSpacing":
        """The spacing of a metric; ``aspect`` is that of its longest ellipse in a domain."""
        return cls(AreaSizes(ellipses), keys=_metric, ellipses=ellipses, aspect=aspect, bent=bent)

    def __call__(self, points: Floats) -> Floats:
        """Spacing (n,) at points (n, 2) of the domain; CaseError where the metric is not positive and finite."""
        d = self._values(points)
        _require_metric(points, d)
        return d

    def axes(self, points: Floats) -> Axes:
        """Axes of the ellipses at points (n, 2)."""
        return self.ellipses(points[:, 0], points[:, 1])

    def at(self, points: Floats) -> Floats:
        """Tensors (n, 3) at points (n, 2)."""
        return self.axes(points).tensors

    def checked(self, points: Floats) -> Floats:
        """Tensors (n, 3) at points (n, 2) of the domain; CaseError where the metric is not positive and finite."""
        found = self.axes(points)
        _require_metric(points, found.diameters)
        return found.tensors

    def along(self, boundary: Boundary, piece: Integers, s: Floats) -> Floats:
        points, tangents = boundary.tracks(piece).places(s)
        return 1 / lengths(self.checked(points), tangents)

    def towards(self, points: Floats, directions: Floats) -> Floats:
        return np.hypot(*directions.T) / lengths(self.checked(points), directions)

    def anywhere_towards(self, points: Floats, directions: Floats) -> Floats:
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.hypot(*directions.T) / lengths(self.at(points), directions)

    def stretch(self, points: Floats, directions: Floats) -> Floats:
        tensors, beside = self.at(points), turned_left(directions)
        with np.errstate(divide="ignore", invalid="ignore"):
            found = lengths(tensors, beside) / lengths(tensors, directions)
        return np.where(np.isnan(found), 1.0, found)

    def measures(self, points: Floats, triangles: Integers) -> Measures:
        return MeasuresInMetric(points, triangles, self.at(points[triangles].mean(axis=1)))

    def _between(self, corners: Floats) -> Floats:
        if corners.shape[1] != 2:
            return super()._between(corners)
        edges = corners[:, 1] - corners[:, 0]
        first, last = (lengths(self.at(corners[:, end]), edges) for end in (0, 1))
        return np.hypot(*edges.T) / mean_lengths(first, last)

    def straightened(self) -> "MetricSpacing":
        """The metric with the long axes of its ellipses shorter where straight edges cannot follow them.

        An edge along the long axis through its middle leaves a layer that bends: at its ends it is long in the metric
        there, by what it goes across. It is made shorter until this is at most `STRAIGHT`.
        """
        return MetricSpacing.of(self.straight, self.aspect, bent=self)

    def shares(self, points: Floats, tensors: Floats | None = None) -> Floats:
        """Shares (n,) of the long axes that are left of those that are asked for, relative to the short ones.

        Where the tensors (n, 3) at the points (n, 2) are known that takes less time.
        """
        if self.bent is None:
            return np.ones(len(points))
        left = self.axes(points) if tensors is None else axes(tensors)
        return left.aspects / self.bent.axes(points).aspects

    @property
    def unstraightened(self) -> "MetricSpacing":
        """The metric that this one straightens; itself if there is none."""
        return self.bent or self

    def straight(self, x: Floats, y: Floats) -> Axes:
        """Axes of the ellipses of the straightened metric at x (n,) and y (n,)."""
        whole = self.ellipses(x, y)
        return whole.shorter(self._straight(np.column_stack([x, y]), whole))

    def _straight(self, x: Floats, whole: Axes) -> Floats:
        """Shares (n,) of the long axes that straight edges can follow."""
        across, along, direction = whole
        share, looked = np.ones(len(x)), np.flatnonzero(along > ROUND * across)
        for _ in range(CORRECTIONS):
            if len(looked) == 0:
                break
            edge = (share[looked] * along[looked])[:, None] * direction[looked]
            ends = self.at(np.concatenate([x[looked] - edge / 2, x[looked] + edge / 2]))
            squared = np.split(lengths(ends, np.tile(edge, (2, 1))) ** 2, 2)
            # What it goes across is the rest of its length there, and grows with the square of its own.
            beyond = np.fmax(*squared) - share[looked] ** 2
            with np.errstate(divide="ignore", invalid="ignore"):
                factor = ((STRAIGHT**2 - 1) / np.fmax(beyond, 0.0)) ** 0.25
            corrected = np.clip(share[looked] * factor, (across / along)[looked], 1.0)
            share[looked] = np.where(np.isnan(corrected), share[looked], corrected)
            looked = looked[share[looked] < 1]
        return share


def _metric(points: Floats) -> list[Key]:
    return [Key(["metric"])] * len(points)


def _require_metric(points: Floats, d: Floats) -> None:
    with at_key("metric"):
        require_positive_definite(d, lambda k: points[k])
