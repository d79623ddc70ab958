"""Bounds of a function of x and y within boxes, and of its slopes: numbers that NumPy's functions take as such.

They are those of interval arithmetic (R. E. Moore, "Interval analysis", 1966), with slopes by the chain rule: as far
off as their box is large, and never too narrow but for rounding.
"""

from collections.abc import Callable, Sequence
from functools import reduce
from typing import Any, Protocol, Self, runtime_checkable

import numpy as np

from bubblemesh.arrays import Booleans, Floats
from bubblemesh.records import record

NONE = np.zeros((3, 1))  # slopes of a constant


class NoBoundsError(Exception):
    """There are no bounds of what a function does with its arguments."""


@record(eq=False)
class Bounds:
    """Bounds of a function within each of some boxes; what is not known is infinite.

    Functions of the table `RULES` take it, all others raise a `NoBoundsError`.
    """

    low: Floats  # (n,): least value
    high: Floats  # (n,): largest value
    slopes: Floats  # (3, n): largest sizes of the slope in the direction of x, in that of y, and in any

    @classmethod
    def of(cls, value: "Bounds | Any") -> "Bounds":
        """Bounds of bounds, or of a constant."""
        return value if isinstance(value, Bounds) else cls(value, value, NONE)

    @classmethod
    def of_coordinates(cls, low: Floats, high: Floats) -> tuple[Self, Self]:
        """Bounds of x and of y within boxes between corners low (n, 2) and high (n, 2)."""
        one, none = np.ones(len(low)), np.zeros(len(low))
        of_x, of_y = np.stack([one, none, one]), np.stack([none, one, one])
        return cls(low[:, 0], high[:, 0], of_x), cls(low[:, 1], high[:, 1], of_y)

    @classmethod
    def of_distance(cls, distance: Callable[[Floats], Floats], x: "Bounds", y: "Bounds") -> "Bounds":
        """Bounds of the distances (n,) of points (n, 2) from something, at x and y within boxes.

        From a point to another one a distance changes by no more than the way between them.
        """
        low, high = np.column_stack([x.low, y.low]), np.column_stack([x.high, y.high])
        middle, way = distance((low + high) / 2), np.hypot(*(high - low).T) / 2
        return cls(np.maximum(middle - way, 0.0), middle + way, np.ones((3, len(low))))

    @property
    def steepest(self) -> Floats:
        """Largest growth (n,) per length, in any direction."""
        along_x, along_y, along_any = self.slopes
        return np.asarray(np.minimum(np.hypot(along_x, along_y), along_any))

    @property
    def size(self) -> Floats:
        """Largest size (n,) of a value."""
        return np.asarray(np.maximum(np.abs(self.low), np.abs(self.high)))

    def only_where(self, known: Booleans) -> "Bounds":
        """The bounds in the boxes (n,) where they are known, and infinite ones elsewhere."""
        low, high = np.where(known, self.low, -np.inf), np.where(known, self.high, np.inf)
        return Bounds(low, high, np.where(known, self.slopes, np.inf))

    def mapped(self, low: Floats, high: Floats, slope: Floats | float) -> "Bounds":
        """Bounds of a function of this one, whose values are between two and whose slope has at most some size."""
        return Bounds(low, high, slope * self.slopes)

    def increasing(self, function: Callable[[Floats], Floats], slope: Floats | float) -> "Bounds":
        """Bounds of a function that increases with this one."""
        return self.mapped(function(self.low), function(self.high), slope)

    def __array_ufunc__(self, function: np.ufunc, method: str, *inputs: Any, **options: Any) -> "Bounds":
        rule = RULES.get(function, RULES.get(function.__name__))
        if method != "__call__" or options or rule is None:
            raise NoBoundsError(function.__name__)
        return rule(*map(Bounds.of, inputs))._known()

    def __array_function__(self, function: Callable[..., Any], *_: Any) -> Any:
        raise NoBoundsError(function.__name__)

    def __array__(self, *_: Any, **__: Any) -> Any:
        raise NoBoundsError("array")

    def _known(self) -> "Bounds":
        """The bounds with infinite ones where one is no number, so that no rule compares it."""
        if not np.isnan(self.low + self.high + self.slopes).any():
            return self
        slopes = np.where(np.isnan(self.slopes), np.inf, self.slopes)
        return Bounds(self.low, self.high, slopes).only_where(~(np.isnan(self.low) | np.isnan(self.high)))


@runtime_checkable
class Bounded(Protocol):
    """A function of x and y that may know its bounds."""

    def bounds_within(self, low: Floats, high: Floats) -> Bounds | None:
        """Bounds within boxes between corners low (n, 2) and high (n, 2); None if nothing is known."""


def bounds_of(function: object, low: Floats, high: Floats) -> Bounds | None:
    """Bounds of a function of x and y within boxes between corners low (n, 2) and high (n, 2), if any are known."""
    return function.bounds_within(low, high) if isinstance(function, Bounded) else None


def least_of(some: Sequence[Bounds]) -> Bounds:
    """Bounds of the least of several functions."""
    return reduce(_least, some)


def _sum(a: Bounds, b: Bounds) -> Bounds:
    return Bounds(a.low + b.low, a.high + b.high, a.slopes + b.slopes)


def _negative(a: Bounds) -> Bounds:
    return a.mapped(-a.high, -a.low, 1.0)


def _product(a: Bounds, b: Bounds) -> Bounds:
    ends = a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high
    low, high = reduce(np.minimum, ends), reduce(np.maximum, ends)
    return Bounds(low, high, b.size * a.slopes + a.size * b.slopes)


def _inverse(a: Bounds) -> Bounds:
    unknown = np.where((a.low > 0) | (a.high < 0), 0.0, np.inf)  # the slope there is infinite, too
    return a.mapped(1 / a.high - unknown, 1 / a.low + unknown, np.maximum(a.low**-2.0, a.high**-2.0) + unknown)


def _absolute(a: Bounds) -> Bounds:
    return a.mapped(np.maximum(np.maximum(a.low, -a.high), 0.0), a.size, 1.0)


def _least(a: Bounds, b: Bounds) -> Bounds:
    first, second = a.low <= b.high, b.low <= a.high  # whether each may be the smaller one
    slopes = np.maximum(np.where(first, a.slopes, 0.0), np.where(second, b.slopes, 0.0))
    return Bounds(np.minimum(a.low, b.low), np.minimum(a.high, b.high), slopes)


def _largest(a: Bounds, b: Bounds) -> Bounds:
    return _negative(_least(_negative(a), _negative(b)))


def _power(a: Bounds, b: Bounds) -> Bounds:
    """Powers of what is positive, and whole positive powers of anything, by a constant exponent."""
    exponent = b.low
    if np.ndim(exponent) or exponent != b.high:
        raise NoBoundsError("power of no constant")
    whole = exponent >= 1 and exponent % 1 == 0
    if whole and exponent % 2 == 0:
        a = _absolute(a)
    known = np.where((a.low > 0) | bool(whole), 1.0, np.nan)
    ends = a.low**exponent * known, a.high**exponent * known
    slope = np.abs(exponent) * np.maximum(np.abs(a.low) ** (exponent - 1), np.abs(a.high) ** (exponent - 1))
    return a.mapped(np.minimum(*ends), np.maximum(*ends), slope * known)


def _hypot(a: Bounds, b: Bounds) -> Bounds:
    a, b = _absolute(a), _absolute(b)
    low, high = np.hypot(a.low, b.low), np.hypot(a.high, b.high)
    # The parts of a unit vector, which are at most 1.
    first, second = (np.where(part.high < low, part.high / low, 1.0) for part in (a, b))
    return Bounds(low, high, first * a.slopes + second * b.slopes)


def _root(a: Bounds) -> Bounds:
    return a.increasing(np.sqrt, 0.5 / np.sqrt(a.low))


def _logarithm(a: Bounds) -> Bounds:
    return a.increasing(np.log, np.where(a.low > 0, 1 / a.low, np.inf))


def _wave(a: Bounds) -> Bounds:
    one = np.ones(np.shape(a.low))
    return a.mapped(-one, one, 1.0)


def _error_function(a: Bounds) -> Bounds:
    from scipy.special import erf  # which has been loaded by the function itself

    return a.increasing(erf, _bell(a))


def _rest_of_error_function(a: Bounds) -> Bounds:
    from scipy.special import erfc

    return a.mapped(erfc(a.high), erfc(a.low), _bell(a))


def _bell(a: Bounds) -> Floats:
    """The largest slope of the error function."""
    return np.asarray(2 / np.sqrt(np.pi) * np.exp(-(_absolute(a).low ** 2)))


def _area_tangent(a: Bounds) -> Bounds:
    return a.increasing(np.arctanh, np.where(a.size < 1, 1 / (1 - a.size**2), np.inf))


# Of each function the bounds of its value, by those of its arguments; SciPy's, which may not be loaded, by their names.
RULES: dict[np.ufunc | str, Callable[..., Bounds]] = {
    np.add: _sum,
    np.subtract: lambda a, b: _sum(a, _negative(b)),
    np.multiply: _product,
    np.divide: lambda a, b: _product(a, _inverse(b)),
    np.positive: lambda a: a,
    np.negative: _negative,
    np.absolute: _absolute,
    np.minimum: _least,
    np.maximum: _largest,
    np.power: _power,
    np.hypot: _hypot,
    np.sqrt: _root,
    np.exp: lambda a: a.increasing(np.exp, np.exp(a.high)),
    np.log: _logarithm,
    np.sin: _wave,
    np.cos: _wave,
    np.tanh: lambda a: a.increasing(np.tanh, np.cosh(_absolute(a).low) ** -2.0),
    np.cbrt: lambda a: a.increasing(np.cbrt, np.cbrt(_absolute(a).low) ** -2.0 / 3),
    np.arcsinh: lambda a: a.increasing(np.arcsinh, 1 / np.hypot(1, _absolute(a).low)),
    np.arccosh: lambda a: a.increasing(np.arccosh, 1 / np.sqrt(a.low**2 - 1)),
    np.arctanh: _area_tangent,
    "erf": _error_function,
    "erfc": _rest_of_error_function,
    np.arctan: lambda a: a.increasing(np.arctan, 1 / (1 + _absolute(a).low ** 2)),
}
