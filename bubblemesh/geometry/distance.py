"""Distances of points from parts of a domain, and from lines and points of their own."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError
from bubblemesh.geometry.chord_runs import ChordRuns
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.nearest_chord import nearest_chord
from bubblemesh.wording import unknown

__all__ = ["FromLabels", "FromLines"]


@dataclass(frozen=True)
class FromLabels:
    """Distance from all that has one of some labels; without any, from the rings of the domain.

    Attributes
    ----------
    domain : Domain
    labels : tuple of str
    """

    domain: Domain
    labels: tuple[str, ...]

    @classmethod
    def of(cls, domain: Domain, labels: Sequence[str]) -> "FromLabels":
        """Distance from what is known to be there.

        Raises
        ------
        CaseError
            If nothing has a label; the text names the known ones.
        """
        for label in labels:
            if label not in domain.labels:
                raise CaseError(unknown("label", label, domain.labels))
        return cls(domain, tuple(labels))

    def __call__(self, points: Floats) -> Floats:
        """Distances (m,) of points (m, 2), on the true curves."""
        return self.domain.distance_to(points, *self.labels) if self.labels else self.domain.nearest(points).distance


@dataclass(frozen=True)
class FromLines:
    """Distance from straight lines."""

    chords: ChordRuns

    @classmethod
    def through(cls, points: Sequence[tuple[float, float]]) -> "FromLines":
        """Distance from the lines between consecutive points; a single one is a line without length."""
        places = np.array(points, float)
        ends = places if len(places) == 1 else places[1:]
        return cls(ChordRuns.of(places[: len(ends)], ends))

    def __call__(self, points: Floats) -> Floats:
        """Distances (m,) of points (m, 2)."""
        _, foot = self.chords.feet(points, nearest_chord(self.chords, points))
        return np.hypot(*(points - foot).T)
