"""A spacing given by a function of a program, which has to take and return arrays."""

from collections.abc import Callable
from inspect import signature
from math import inf
from typing import Any

import numpy as np

from bubblemesh.arrays import Floats, unmasked
from bubblemesh.errors import BubblemeshError, CaseError
from bubblemesh.records import record


@record(eq=False)
class CheckedFunction:
    """A function of x and y of a program, whose values are checked. Errors begin with the ``argument`` that has it."""

    function: Callable[..., Any]
    argument: str

    bounds = (-inf, -inf, inf, inf)
    spots = np.zeros((0, 2))  # where it is fine over a short distance: that is not known

    def __post_init__(self) -> None:
        try:
            signature(self.function).bind(0.0, 0.0)
        except TypeError as error:
            raise CaseError(f"{self.argument}: the function has to take x and y, two arrays ({error})") from None
        except ValueError:  # one of C that does not tell
            pass

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Values (n,) at x (n,) and y (n,); CaseError if the function fails or does not give one number for each."""
        if len(x) == 0:  # which many functions do not expect
            return np.zeros(0)
        try:
            values = self._values(x, y)
        except MemoryError:
            raise
        except BubblemeshError as error:
            error.prefix(self.argument)
            raise
        except Exception as error:
            raise self._failure(x, y, error) from error
        if values.dtype.kind not in "iuf":
            raise CaseError(f"{self.argument}: the function gives values of type {values.dtype}: give real numbers")
        if values.shape not in ((), x.shape):
            raise CaseError(
                f"{self.argument}: the function gives an array of shape {values.shape} for {len(x)} points: it has to "
                "give one value for each"
            )
        return np.broadcast_to(values, x.shape).astype(float)

    def _values(self, x: Any, y: Any) -> Any:
        """What the function gives."""
        with np.errstate(all="ignore"):
            return np.asarray(unmasked(self.function(x.copy(), y.copy())))  # it may change what it is given

    def _failure(self, x: Floats, y: Floats, error: Exception) -> CaseError:
        """What to tell of an error at some places: whether it is that of a single one, or of arrays as such."""
        some = [(x[k], y[k]) for k in (0, len(x) // 2, -1)]
        if any(self._fails(np.full(2, a), np.full(2, b)) and not self._fails(a, b) for a, b in some):
            return CaseError(
                f"{self.argument}: the function fails for arrays of coordinates ({error}): it has to take many points "
                "at once, by NumPy's functions, with np.where in place of if, or by np.vectorize, which is slow"
            )
        while len(x) > 1:
            half = slice(len(x) // 2)
            half = half if self._fails(x[half], y[half]) else slice(half.stop, None)
            x, y = x[half], y[half]
        at, told = f"({x[0]:.10g}, {y[0]:.10g})", f"{type(error).__name__}: {error}"  # places next to the domain differ
        return CaseError(
            f"{self.argument}: the function fails at {at} ({told}): it has to give a value in each place; outside of "
            "the domain, where it is called as well, NaN will do"
        )

    def _fails(self, x: Any, y: Any) -> bool:
        """Whether the function fails at some places, or at a single one."""
        try:
            self._values(x, y)
        except Exception:
            return True
        return False
