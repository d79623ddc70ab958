"""Values of keys of the spacing, bound to a domain, and the rasters that they name."""

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from bubblemesh.case.metric import AnyMetric
from bubblemesh.case.spacing import SpacingTerms, Value
from bubblemesh.errors import Key, at_key
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.label_distances import distance_to_labels
from bubblemesh.problem.crs import bound_in
from bubblemesh.spacing.expression import Expression, Rasters
from bubblemesh.spacing.spacing import OneKey, Spacing
from bubblemesh.spacing.terms.combination import costly

if TYPE_CHECKING:
    from bubblemesh.problem.data_terms import RasterNames


def bound_value(value: Value, domain: Domain, *path: str | int, rasters: Rasters) -> Spacing:
    """The value of a key: a number, or an expression that may measure distances in the domain, and name rasters."""
    with at_key(*path):
        bound = value if isinstance(value, Expression) else Expression.parse(str(value))
        distance_to = partial(distance_to_labels, domain)
        function, term = bound_in(domain.unprojection, bound, distance_to, rasters)
    return Spacing(function, keys=OneKey(Key(path)), costly=costly(term))


def values_of(metrics: Sequence[AnyMetric]) -> list[Value]:
    """Expressions in metrics, which may name rasters."""
    return [value for model in metrics for value in vars(model).values() if isinstance(value, Expression)]


def named_rasters(
    terms: SpacingTerms, domain: Domain, others: Sequence[Value | None]
) -> "tuple[RasterNames, tuple[str, ...]]":
    """The rasters that expressions name, and notes on them."""
    keys = [each.depth for each in (terms.waves, terms.slope, terms.courant) if each is not None]
    values = [terms.value, *terms.regions.values(), *keys, *others]
    names = {name for value in values if isinstance(value, Expression) for name in value.rasters}
    if not names:
        return {}, ()
    from bubblemesh.problem.data_terms import raster_variables

    return raster_variables(terms, domain, names)
