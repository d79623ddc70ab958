"""Distances of points from parts of a domain, and from lines and points of their own."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError
from bubblemesh.geometry.distance.chord_runs import ChordRuns
from bubblemesh.geometry.distance.closed_form import ClosedForm
from bubblemesh.geometry.distance.nearest_chord import nearest_chord
from bubblemesh.geometry.domain import Domain
from bubblemesh.messages import unknown


class Distance(Protocol):
    """Distance from something."""

    @property
    def costly(self) -> bool:
        """Whether it takes much longer than a formula."""

    def __call__(self, points: Floats) -> Floats:
        """Distances (m,) of points (m, 2)."""


def distance_to_labels(domain: Domain, labels: Sequence[str]) -> Distance:
    """Distance from all that has one of the labels; without any, from the rings of the domain.

    Raises
    ------
    CaseError
        If nothing has a label; the text names the known ones.
    """
    for label in labels:
        if label not in domain.labels:
            raise CaseError(unknown("label", label, domain.labels))
    boundary = domain.boundary
    named = np.isin(boundary.labels, list(labels))[boundary.label]
    points = [point.at for point in domain.parts.points if point.label in labels]
    formula = ClosedForm.of(boundary, np.flatnonzero(named if labels else ~boundary.inner), points)
    return FromLabels(domain, tuple(labels)) if formula is None else formula


def distance_to_line(points: Sequence[tuple[float, float]]) -> Distance:
    """Distance from the straight lines between consecutive points; from the point itself if there is only one."""
    formula = ClosedForm.through(points)
    if formula is not None:
        return formula
    places = np.array(points, float)
    return FromChords(ChordRuns.of(places[:-1], places[1:]))


@dataclass(frozen=True)
class FromLabels:
    """Distance from what has one of some labels, on the true curves; without any, from the rings of the domain."""

    domain: Domain
    labels: tuple[str, ...]

    costly = True

    def __call__(self, points: Floats) -> Floats:
        """Distances (m,) of points (m, 2)."""
        return self.domain.distance_to(points, *self.labels) if self.labels else self.domain.nearest(points).distance


@dataclass(frozen=True)
class FromChords:
    """Distance from straight lines."""

    chords: ChordRuns

    costly = True

    def __call__(self, points: Floats) -> Floats:
        """Distances (m,) of points (m, 2)."""
        _, foot = self.chords.feet(points, nearest_chord(self.chords, points))
        return np.hypot(*(points - foot).T)
