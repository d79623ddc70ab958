"""Metrics of a case, bound to its domain."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bubblemesh.case.fields import several
from bubblemesh.case.metric import AnyMetric, DirectedMetric, FieldMetric, TensorMetric, WallMetric
from bubblemesh.errors import Key, at_key
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.label_distances import distance_to_labels, require_labels
from bubblemesh.problem.crs import bound_in
from bubblemesh.problem.ellipses import AlongWalls, AtGivenPlaces, Directed, Entries, NumberAt, OnTheGround, Scaled
from bubblemesh.problem.files import own_files
from bubblemesh.problem.metric_files import read_ellipses
from bubblemesh.spacing.expression import Expression, Rasters
from bubblemesh.spacing.metric.metric import EllipsesAt

FULL_TURN = 2 * np.pi


class MetricRequest(NamedTuple):
    """A metric of a case: its ellipses, and the largest aspect that they may have, with the key of the case."""

    ellipses: EllipsesAt  # no numbers where the metric is not positive
    aspect: float
    key: Key
    gradation: float = np.inf  # growth over a length of 1
    notes: tuple[str, ...] = ()  # what was chosen of its file
    numbers: Mapping[str, NumberAt] = {}  # of which it is made, by their keys

    def scaled(self, scale: float) -> "MetricRequest":
        """The metric with all sizes multiplied."""
        return self._replace(ellipses=Scaled(self.ellipses, scale))


def metric_requests(
    models: Sequence[AnyMetric], domain: Domain, root: Path | None, rasters: Rasters
) -> tuple[MetricRequest, ...]:
    """The metrics of a case in a domain; CaseError, with the key, for labels or rasters that it has not.

    Files are read below the ``root`` of an untrusted case only.
    """
    found = list[MetricRequest]()
    for number, model in enumerate(models):
        with own_files(model, root):
            found.append(_request(model, domain, Key(["metric", *([number] if len(models) > 1 else [])]), rasters))
    return tuple(found)


def _request(model: AnyMetric, domain: Domain, key: Key, rasters: Rasters) -> MetricRequest:
    """The metric of a model, with its expressions bound to the domain; errors name the ``key`` and the one within."""
    numbers = dict[str, NumberAt]()

    def number(name: str) -> NumberAt:
        value = getattr(model, name)
        with at_key(*key, name):
            expression = value if isinstance(value, Expression) else Expression.parse(repr(float(value)))
            numbers[name], _ = bound_in(domain.unprojection, expression, partial(distance_to_labels, domain), rasters)
        return numbers[name]

    plane = domain.plane
    along = None if getattr(model, "along", None) is None else number("along")
    notes: tuple[str, ...] = ()
    ellipses: EllipsesAt
    match model:
        case DirectedMetric():
            ellipses = Directed(number("angle"), number("across"), along)
            notes = _as_degrees(model.angle, Key([*key, "angle"]))
        case TensorMetric():
            ellipses = Entries(number("m11"), number("m12"), number("m22"))
        case WallMetric():
            labels = several(model.label)
            with at_key(*key, "label"):
                require_labels(domain, labels)
            ellipses = AlongWalls(domain, tuple(labels), model.across, model.growth, along)
        case FieldMetric():
            with at_key(*key):
                ellipses, notes = read_ellipses(model, domain)
                ellipses = ellipses if plane is None else AtGivenPlaces(ellipses, plane)
    if plane is not None:
        ellipses = OnTheGround(ellipses, plane, turned=not isinstance(model, WallMetric))
    return MetricRequest(ellipses, model.aspect, key, model.gradation or np.inf, notes, numbers)


def _as_degrees(angle: Expression | float, key: Key) -> tuple[str, ...]:
    """Note on an angle that is the same everywhere and beyond a full turn, as one in degrees is."""
    if isinstance(angle, Expression) and not angle.is_uniform:
        return ()
    radians = float(angle(np.zeros(1), np.zeros(1))[0] if isinstance(angle, Expression) else angle)
    if not np.isfinite(radians) or abs(radians) <= FULL_TURN:
        return ()
    return (
        f"{key}: {radians:g} is in radians, which are {radians / FULL_TURN:.3g} turns: {radians:g} degrees are "
        f"{np.radians(radians):.6g}, or {radians:g}*pi/180",
    )
