"""Distances from what has labels in a domain."""

from collections.abc import Sequence

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError
from bubblemesh.geometry.distance.distances import ClosedForm, Distance
from bubblemesh.geometry.domain import Domain
from bubblemesh.messages import listed, place, unknown
from bubblemesh.records import record


def distance_to_labels(domain: Domain, labels: Sequence[str]) -> Distance:
    """Distance from everything with one of the labels; without labels, from the rings of the domain.

    CaseError, with the known labels, if a label is unknown.
    """
    require_labels(domain, labels)
    labels = [own for label in labels for own in domain.groups.get(label, (label,))]
    boundary = domain.boundary
    named = np.isin(boundary.labels, list(labels))[boundary.label]
    points = [point.at for point in domain.parts.points if point.label in labels]
    formula = ClosedForm.of(boundary, np.flatnonzero(named if labels else ~boundary.inner), points)
    return FromLabels(domain, tuple(labels)) if formula is None else formula


def free_ends(domain: Domain, labels: Sequence[str]) -> Floats:
    """Places (k, 2) where embedded lines with one of the labels end and nothing else is: no line, ring or region.

    CaseError, with the known labels, if a label is unknown, or if there is no such end.
    """
    require_labels(domain, labels)
    boundary, fans = domain.boundary, domain.corner_fans
    alone = fans.following == np.arange(len(fans.piece))
    named = np.isin(boundary.labels, list(labels))[boundary.label[fans.piece]]
    found = boundary.corners[fans.corner[alone & named]]
    if len(found) == 0:
        raise CaseError(
            f"no line with the label {listed(list(map(repr, labels)))} has a free end, where no other line, boundary "
            "or region is: leave it out, or give the place as point"
        )
    return found


def require_labels(domain: Domain, labels: Sequence[str]) -> None:
    """CaseError, with the known labels, if nothing in a domain has one of the given ones."""
    known = [*domain.labels, *(group for group, own in domain.groups.items() if own)]
    for label in labels:
        if label in known:
            continue
        if label in domain.groups:
            raise CaseError(
                f"no {label} lies in the box: correct the box or the file, or leave out what is measured from {label}"
            )
        if label in domain.lost:
            raise CaseError(f"the side {label!r} has no length, since both of its ends are one point: correct the ring")
        if label in domain.parts.left_out:
            raise CaseError(
                f"{label!r} lies outside of the domain, at {place(domain.parts.left_out[label])}, where outside: skip "
                "leaves it out: correct its coordinates, their units or the domain, or leave out what names it"
            )
        raise CaseError(unknown("label", label, known))


@record
class FromLabels:
    """Distance from the true curves and points with one of the labels; without labels, from the rings of the domain."""

    domain: Domain
    labels: tuple[str, ...]

    costly = True

    def __call__(self, points: Floats) -> Floats:
        """Distances (m,) of points (m, 2)."""
        return self.domain.distance_to(points, *self.labels) if self.labels else self.domain.distances(points)
