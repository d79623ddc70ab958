"""Sides, lines and points by their labels, to be projected onto."""

from collections.abc import Collection

import numpy as np

from bubblemesh.errors import GeometryError
from bubblemesh.geometry.arrangement.regions import Parts
from bubblemesh.geometry.boundary import Boundary, Chords
from bubblemesh.geometry.distance.projection import Projection
from bubblemesh.messages import meant


def known_labels(boundary: Boundary, parts: Parts) -> tuple[str, ...]:
    """Names of the sides, lines and points of a domain, each once."""
    names = [boundary.labels[number] for number in np.unique(boundary.label)]
    return tuple(dict.fromkeys([*names, *(label for _, label in parts.points)]))


def onto(boundary: Boundary, parts: Parts, labels: Collection[str]) -> Projection:
    """Projection onto all sides, lines and points of a domain that have one of the labels.

    Raises
    ------
    GeometryError
        If there is no such label, or none is given.
    """
    known = known_labels(boundary, parts)
    unknown = next((label for label in labels if label not in known), None)
    if unknown is not None:
        raise GeometryError(f"there is no side, line or point {unknown!r}: {meant(unknown, known)}")
    if not labels:
        raise GeometryError(f"no side, line or point is named: give at least one of {', '.join(known)}")
    chords = boundary.chords()
    named = np.flatnonzero(np.isin(boundary.labels, list(labels))[boundary.label[chords.piece]])
    points = np.array([at for at, label in parts.points if label in labels], float).reshape(-1, 2)
    none, nowhere = np.full(len(points), -1), np.zeros(len(points))
    added = none, nowhere, nowhere, points, points
    both = zip((column[named] for column in chords), added, strict=True)
    return Projection(boundary, Chords(*(np.concatenate(columns) for columns in both)))
