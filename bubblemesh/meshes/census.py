"""Figures of a mesh from those of its pieces, so that the whole mesh need not be in memory."""

from collections.abc import Sequence
from typing import Any, NamedTuple, Self

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.meshes.areas_and_lengths import RegionSums
from bubblemesh.meshes.quality import (
    REGULAR_VALENCE,
    SHOWN_BINS,
    WORST,
    Measures,
    Shape,
    SpacingBetween,
    SpacingFit,
    edge_ratios,
    figures,
    worst_triangles,
)

QUALITY_BINS = 10_000  # of radius ratios, from 0 to 1
OCTAVES, PER_OCTAVE = 4, 2_500  # of edge lengths over spacings, around 1


class Tally(NamedTuple):
    """Summary of many numbers, at least one: enough for mean, deviation, the least one and quantiles."""

    number: int
    total: float
    squares: float  # sum of the squared differences to 1
    least: float
    bins: Integers  # (b,): how many are in each bin

    @classmethod
    def of(cls, values: Floats, places: Floats, bins: int) -> Self:
        """Tally of values (n,), with ``places`` (n,) from 0 to 1 along the bins; places beyond count in the outer bins.

        Without values, the least one is infinity.
        """
        which = np.clip((places * bins).astype(np.int64), 0, bins - 1)
        counts = np.bincount(which, minlength=bins)
        least = float(values.min(initial=np.inf))
        return cls(len(values), float(values.sum()), float(((values - 1) ** 2).sum()), least, counts)

    @classmethod
    def together(cls, parts: "Sequence[Tally]") -> Self:
        """Tally of the numbers of all parts."""
        number, total, squares, least, bins = zip(*parts, strict=True)
        return cls(sum(number), sum(total), sum(squares), min(least), np.sum(bins, axis=0))

    @property
    def mean(self) -> float:
        """Mean of the numbers."""
        return self.total / self.number

    @property
    def deviation(self) -> float:
        """Standard deviation of the numbers."""
        return float(np.sqrt(max(self.squares / self.number - (self.mean - 1) ** 2, 0.0)))

    def quantile(self, share: float) -> float:
        """Place, from 0 to 1 along the bins, below which this share of the numbers is; exact to a bin."""
        below = np.append(0, np.cumsum(self.bins))
        return float(np.interp(share * (self.number - 1) + 0.5, below, np.linspace(0, 1, len(below))))


class Census(NamedTuple):
    """Figures of a piece of a mesh, in a form in which those of several pieces can be added up."""

    triangles: int
    area: float
    regions: RegionSums
    low: Floats  # (2,): corner of the box around its nodes
    high: Floats  # (2,)
    quality: Tally
    worst: Floats  # (w,): radius ratios of the worst triangles, the worst first
    worst_at: Floats  # (w, 2): their centroids
    angle_min: float
    angle_max: float
    spacing: Tally  # of edge length over target spacing, by the logarithm
    inner: int  # its own nodes within the domain
    irregular: int  # inner nodes whose valence is not six
    valence_max: int  # most edges at a node

    @classmethod
    def of(
        cls,
        measures: Measures,
        region: Integers,
        spacing_between: SpacingBetween,
        own_edges: Booleans,
        own_inner: Booleans,
        valence: Integers,
    ) -> Self:
        """Figures of a piece with at least one triangle.

        Parameters
        ----------
        measures
            Measures of its triangles.
        region
            Number (t,) of the region that each of them is in.
        spacing_between
            Function that returns the target spacing.
        own_edges
            Mask (e,) of the edges that no other piece counts.
        own_inner
            Mask (n,) of the nodes within the domain that no other piece counts.
        valence
            Number (n,) of edges at each node.
        """
        points, edges = measures.points, measures.edges[0][own_edges]
        ratios = edge_ratios(points, edges, spacing_between(points, edges))
        worst = worst_triangles(measures, WORST)
        used = np.zeros(len(points), bool)
        used[measures.triangles] = True
        return cls(
            triangles=len(measures.triangles),
            area=float(measures.signed_areas.sum()),
            regions=RegionSums.of(measures.signed_areas, region),
            low=points[used].min(axis=0),
            high=points[used].max(axis=0),
            quality=Tally.of(measures.radius_ratios, measures.radius_ratios, QUALITY_BINS),
            worst=np.array([q for q, _ in worst]),
            worst_at=np.array([at for _, at in worst]),
            angle_min=measures.angle_range[0],
            angle_max=measures.angle_range[1],
            spacing=Tally.of(ratios, np.log2(ratios) / (2 * OCTAVES) + 0.5, 2 * OCTAVES * PER_OCTAVE),
            inner=int(own_inner.sum()),
            irregular=int((valence[own_inner] != REGULAR_VALENCE).sum()),
            valence_max=int(valence.max()),
        )

    @classmethod
    def together(cls, parts: "Sequence[Census]") -> Self:
        """Figures of all pieces of a mesh."""
        worst = np.concatenate([part.worst for part in parts])
        order = np.argsort(worst, kind="stable")[:WORST]
        return cls(
            triangles=sum(part.triangles for part in parts),
            area=sum(part.area for part in parts),
            regions=RegionSums.together([part.regions for part in parts]),
            low=np.min([part.low for part in parts], axis=0),
            high=np.max([part.high for part in parts], axis=0),
            quality=Tally.together([part.quality for part in parts]),
            worst=worst[order],
            worst_at=np.concatenate([part.worst_at for part in parts])[order],
            angle_min=min(part.angle_min for part in parts),
            angle_max=max(part.angle_max for part in parts),
            spacing=Tally.together([part.spacing for part in parts]),
            inner=sum(part.inner for part in parts),
            irregular=sum(part.irregular for part in parts),
            valence_max=max(part.valence_max for part in parts),
        )

    def figures(self, nodes: int, boundary_nodes: int) -> dict[str, Any]:
        """Figures of a mesh with so many nodes, as in `mesh_figures`; quantiles are exact to a bin."""
        shown = self.quality.bins.reshape(SHOWN_BINS, -1).sum(axis=1)
        ends = [2.0 ** (2 * OCTAVES * (self.spacing.quantile(share) - 0.5)) for share in (0.01, 0.99)]
        return figures(
            nodes=nodes,
            triangles=self.triangles,
            boundary_nodes=boundary_nodes,
            bounds=(self.low, self.high),
            shape=Shape(
                mean=self.quality.mean,
                min=self.quality.least,
                p01=self.quality.quantile(0.01),
                histogram=tuple(shown.tolist()),
                irregular_fraction=self.irregular / self.inner if self.inner else None,
                valence_max=self.valence_max,
                angle_min=self.angle_min,
                angle_max=self.angle_max,
            ),
            worst=((float(q), (float(x), float(y))) for q, (x, y) in zip(self.worst, self.worst_at, strict=True)),
            area=self.area,
            fit=SpacingFit(self.spacing.mean, self.spacing.deviation, *ends),
        )
