"""Spacings near labels, ends of lines, points and lines, that grow from there."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np
import shapely

from bubblemesh.arrays import Floats
from bubblemesh.case.fields import several
from bubblemesh.case.spacing import NearEnds, NearLabel, NearLine, NearPoint, NearTerm, SpacingTerms
from bubblemesh.errors import Key, at_key
from bubblemesh.geometry.distance.distances import MOST_FORMULAS, FromPoints, distance_to_line
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.label_distances import distance_to_labels, free_ends, require_labels
from bubblemesh.spacing.spacing import OneKey, Spacing
from bubblemesh.spacing.terms.combination import Combination
from bubblemesh.spacing.terms.proximity import NEAR_GROWTH, Proximities, Proximity

MOST_TERMS = 64  # near something: of more of them, only those in question are evaluated
APART = 1 / 500  # of the domain's size: points of a line that are looked at


def near_spacings(terms: SpacingTerms, domain: Domain) -> Iterator[Spacing]:
    """Spacings that are fine near something, and grow from there: one term for all whose distance takes long."""
    found, key = tuple(_growing(terms, domain)), _key_near(terms, domain)
    fast = tuple(near for near in found if not near.costly)
    if len(fast) > MOST_TERMS:
        yield Spacing(Proximities(fast), keys=key)
    else:
        yield from (Spacing(near, keys=key) for near in fast)
    slow = tuple(near for near in found if near.costly)
    if slow:
        yield Spacing(slow[0] if len(slow) == 1 else Proximities(slow), keys=key, costly=True)


def _key_near(terms: SpacingTerms, domain: Domain) -> Callable[[Floats], Sequence[Key]]:
    """Keys of the `near` terms. Equal terms under two keys are evaluated once; their keys are kept apart here."""
    if not (terms.near and terms.labels):
        return OneKey(Key(["spacing", "near" if terms.near else "labels"]))
    near, labels = terms.model_copy(update={"labels": {}}), terms.model_copy(update={"near": None})
    return Combination((*near_spacings(near, domain), *near_spacings(labels, domain))).keys


def _growing(terms: SpacingTerms, domain: Domain) -> Iterator[Proximity]:
    """Sizes near labels, ends of lines, points and lines, which grow with the distance from these."""
    growth = NEAR_GROWTH if terms.growth is None else terms.growth
    models: tuple[NearTerm, ...] = several(terms.near)
    points = _alike(models)
    for size, own, until in points:
        nearest = FromPoints(np.array(points[size, own, until]))
        yield Proximity(nearest, size, growth if own is None else own, until)
    labels: dict[tuple[float, float, float], list[str]] = {}  # by size, growth and reach
    for number, near in enumerate(models):
        key = Key(["spacing", "near", *([number] if len(models) > 1 else [])])
        law = near.size, growth if near.growth is None else near.growth, near.until
        match near:
            case NearLabel():
                with at_key(*key, "label"):
                    require_labels(domain, several(near.label))
                labels.setdefault(law, []).extend(several(near.label))
            case NearEnds():
                with at_key(*key, "ends"):
                    yield Proximity(FromPoints(free_ends(domain, several(near.ends))), *law)
            case NearPoint():
                if (near.size, near.growth, near.until) not in points:
                    yield Proximity(distance_to_line([near.point]), *law)
            case NearLine():
                yield Proximity(distance_to_line(near.line), *law)
    for label, size in terms.labels.items():
        with at_key("spacing", "labels", label):
            require_labels(domain, [label])
        labels.setdefault((size, growth, 0.0), []).append(label)
    for law, alike in labels.items():  # the nearest of those that are alike takes one look, not one for each
        yield Proximity(distance_to_labels(domain, tuple(dict.fromkeys(alike))), *law)


def _alike(models: Sequence[NearTerm]) -> dict[tuple[float, float | None, float], list[tuple[float, float]]]:
    """Points with the same size, growth and reach, by these, where they are so many that the nearest is looked for."""
    found: dict[tuple[float, float | None, float], list[tuple[float, float]]] = {}
    for near in models:
        if isinstance(near, NearPoint):
            found.setdefault((near.size, near.growth, near.until), []).append(near.point)
    return {key: points for key, points in found.items() if len(points) > MOST_FORMULAS}


def near_spots(terms: SpacingTerms, domain: Domain) -> Iterator[Floats]:
    """Points (k, 2) near which the spacing is fine; the boundary and embedded lines are looked at anyhow."""
    labels, models = set(terms.labels), tuple[NearTerm, ...](several(terms.near))
    for near in models:
        match near:
            case NearLabel():
                labels.update(several(near.label))
            case NearPoint():
                yield np.array([near.point])
            case NearLine():
                line = shapely.segmentize(shapely.linestrings(near.line), APART * domain.size)
                yield shapely.get_coordinates(line)
    yield np.array([point.at for point in domain.parts.points if point.label in labels]).reshape(-1, 2)
