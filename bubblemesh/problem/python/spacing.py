"""Spacings of Python programs: numbers, expressions, mappings of terms, and functions of their own, checked."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from bubblemesh.arrays import Floats, unmasked
from bubblemesh.case.spacing import Value, checked_terms
from bubblemesh.errors import CaseError
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.label_distances import distance_to_labels
from bubblemesh.problem.python.numbers import plain_value
from bubblemesh.problem.spacing import SpacingRequest, spacing_request
from bubblemesh.spacing.expression import Expression
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.terms.combination import Combination, Term, costly
from bubblemesh.spacing.terms.function import CheckedFunction

SpacingLike = float | str | Mapping[str, Any] | Callable[[Floats, Floats], Any]


def spacing_of(spacing: SpacingLike, domain: Domain, others: Sequence[Value] = ()) -> SpacingRequest:
    """The spacing, whose values are checked, and its rules; CaseError if it is not a `SpacingLike`.

    ``others`` are values beside it that may name its rasters.
    """
    if isinstance(spacing, Mapping):
        return spacing_request(checked_terms(plain_value(spacing)), domain, others=others)
    term: Term = CheckedFunction(spacing, "spacing") if callable(spacing) else _expression(spacing, domain)
    return SpacingRequest(partial(_scaled, term))


def _scaled(term: Term, scale: float | None) -> Spacing:
    scaled = term if scale is None else Combination((Spacing(term),), scale)
    return Spacing(scaled, costly=costly(scaled))


def _expression(spacing: float | str, domain: Domain) -> Expression:
    """The expression of a text or a number; CaseError if it is another thing, or not finite."""
    if not isinstance(spacing, str):
        value = np.asarray(unmasked(spacing))
        if value.ndim > 0 or value.dtype.kind not in "iuf":
            raise CaseError(
                "spacing: must be a number, an expression in x and y, a mapping of terms, or a function of x and y"
            )
        if not np.isfinite(value):
            raise CaseError(f"spacing: is {value}: it has to be positive and finite")
        spacing = repr(float(value))
    try:
        return Expression.parse(spacing, distance_to=partial(distance_to_labels, domain))
    except CaseError as error:
        raise CaseError(f"spacing: {error}") from None
