"""Spacings of Python programs: numbers, expressions, mappings of terms, and functions of their own, checked."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from bubblemesh.arrays import Floats, unmasked
from bubblemesh.case.spacing import Value, checked_terms
from bubblemesh.errors import BubblemeshError, CaseError
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.label_distances import distance_to_labels
from bubblemesh.problem.python.numbers import plain_value
from bubblemesh.problem.spacing import SpacingRequest, spacing_request
from bubblemesh.spacing.expression import Expression
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.terms.combination import Combination, Term, costly

SpacingLike = float | str | Mapping[str, Any] | Callable[[Floats, Floats], Any]


def spacing_of(spacing: SpacingLike, domain: Domain, others: Sequence[Value] = ()) -> SpacingRequest:
    """The spacing, whose values are checked, and its rules; CaseError if it is not a `SpacingLike`.

    ``others`` are values beside it that may name its rasters.
    """
    if isinstance(spacing, Mapping):
        return spacing_request(checked_terms(plain_value(spacing)), domain, others=others)
    term: Term = _CheckedFunction(spacing) if callable(spacing) else _expression(spacing, domain)
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


class _CheckedFunction:
    """A function of the user's that has to take and return arrays."""

    def __init__(self, function: Callable[[Floats, Floats], Any]) -> None:
        self.function = function

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Values (n,) at x (n,) and y (n,); CaseError if the function fails or does not give one number for each."""
        if len(x) == 0:  # which many functions do not expect
            return np.zeros(0)
        try:
            with np.errstate(all="ignore"):
                values = np.asarray(unmasked(self.function(x.copy(), y.copy())))  # it may change what it is given
        except (BubblemeshError, MemoryError):
            raise
        except (TypeError, ValueError) as error:
            raise CaseError(
                f"spacing: the function fails for arrays of coordinates ({error}): it has to take many points at once, "
                "by NumPy's functions, with np.where in place of if, or by np.vectorize, which is slow"
            ) from error
        except Exception as error:
            raise CaseError(f"spacing: the function fails ({type(error).__name__}: {error}): correct it") from error
        if values.dtype.kind not in "iuf":
            raise CaseError(f"spacing: the function gives values of type {values.dtype}: they have to be real numbers")
        if values.shape not in ((), x.shape):
            raise CaseError(
                f"spacing: the function gives an array of shape {values.shape} for {len(x)} points: it has to give one "
                "value for each"
            )
        return np.broadcast_to(values, x.shape).astype(float)
