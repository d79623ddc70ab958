"""The node spacing d(x, y), checked wherever it is used."""

from collections.abc import Callable, Sequence
from dataclasses import field
from functools import reduce
from typing import ClassVar

import numpy as np

from bubblemesh.arrays import LARGEST_NUMBER, Booleans, Floats, Integers, taken
from bubblemesh.errors import CaseError, Key, at_key
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.meshes.quality import Measures
from bubblemesh.messages import place
from bubblemesh.records import record
from bubblemesh.spacing.bounds import Bounds, bounds_of

STEEP = 0.1  # growth per length: around spots from which it is slower, samples see it
MOST_SPOTS = 2000  # more are noise
AT_A_TIME = 1 << 16  # places, where arrays of all would take much memory

Function = Callable[[Floats, Floats], Floats]  # values (n,) at the coordinates x (n,) and y (n,)


@record
class OneKey:
    """The key of a spacing that is set by the same one at any points."""

    key: Key

    def __call__(self, points: Floats) -> list[Key]:
        return [self.key] * len(points)


WHOLE = OneKey(Key(["spacing"]))


@record
class Spacing:
    """Desired distance between neighbouring nodes, in the domain's unit of length."""

    in_metric: ClassVar[bool] = False  # whether it depends on the direction
    noun: ClassVar[str] = "the spacing"  # for messages

    function: Function
    floor: float = 0.0  # stands for d outside the domain where the function has no positive value
    # Keys (n) of the case that set it at points (n, 2): a region may have its own.
    keys: Callable[[Floats], Sequence[Key]] = WHOLE
    costly: bool = False  # so much that a table of it is worth having
    # Places (k, 2) where it may be fine over so short a distance that samples would pass them by.
    spots: Floats = field(default_factory=lambda: np.zeros((0, 2)), compare=False)

    def __call__(self, points: Floats) -> Floats:
        """Spacing (n,) at points (n, 2) of the domain.

        CaseError where it is zero, negative, above 1e70 or no number; the text names the point.
        """
        d = self._values(points)
        usable = _usable(d)
        if not usable.all():
            k = usable.argmin()
            with at_key(*self.keys(points[k : k + 1])[0]):
                raise CaseError(
                    f"is {d[k]:g} at {place(points[k])}: it has to be positive and finite "
                    f"(at most {LARGEST_NUMBER:g}) in the whole domain"
                )
        return d

    def along(self, boundary: Boundary, piece: Integers, s: Floats) -> Floats:
        """Spacing (k,) of nodes on pieces (k,) of a boundary at arc lengths s (k,)."""
        return self(boundary.points(piece, s))

    def towards(self, points: Floats, directions: Floats) -> Floats:
        """Spacing (n,) at points (n, 2) of the domain in some directions (n, 2), in which it may differ."""
        return self(points)

    def anywhere(self, points: Floats) -> Floats:
        """Spacing (n,) at points (n, 2) anywhere: NaN where undefined."""
        d = self._values(points)
        return np.where(_usable(d), d, np.nan)

    def anywhere_towards(self, points: Floats, directions: Floats) -> Floats:
        """Spacing (n,) at points (n, 2) in some directions (n, 2), as `towards`, but anywhere: NaN where undefined."""
        return self.anywhere(points)

    def stretch(self, points: Floats, directions: Floats) -> Floats:
        """Spacing (n,) at points (n, 2) anywhere, in directions (n, 2), over that square to them; 1 where undefined."""
        return np.ones(len(points))

    def measures(self, points: Floats, triangles: Integers) -> Measures:
        """Measures of triangles (t, 3) between points (n, 2), in the metric if the spacing is one."""
        return Measures(points, triangles)

    def bounds_in(self, box: tuple[float, float, float, float]) -> Bounds | None:
        """Bounds in a box (x0, y0, x1, y1), if any are known."""
        low, high = np.array(box).reshape(2, 1, 2)
        return bounds_of(self.function, low, high)

    @property
    def is_uniform(self) -> bool:
        """Whether its function says that it is the same everywhere."""
        return bool(getattr(self.function, "is_uniform", False))

    def extended(self, points: Floats) -> Floats:
        """Spacing (n,) at points (n, 2) anywhere: not below the floor, nor undefined."""
        d = self._values(points)
        return np.where(_usable(d), np.maximum(d, self.floor), self.floor)

    def between(self, points: Floats, rows: Integers) -> Floats:
        """Spacing (m,) at the centroids of ``rows`` (m, k) of points (n, 2); where undefined there, the points' mean.

        The midpoint of two nodes on the rim of a hole lies inside the hole, where the function need not exist.
        """
        result = np.empty(len(rows))
        for begin in range(0, len(rows), AT_A_TIME):
            part = slice(begin, begin + AT_A_TIME)
            result[part] = self._between(taken(points, rows[part]))
        return result

    def _between(self, corners: Floats) -> Floats:
        """Spacing (m,) at the centroids of points (m, k, 2): see `between`."""
        d = self._values(reduce(np.add, np.moveaxis(corners, 1, 0)) / corners.shape[1])
        bad = np.flatnonzero(~_usable(d))
        if len(bad):
            d = d.copy()
            d[bad] = self(corners[bad].reshape(-1, 2)).reshape(len(bad), -1).mean(axis=1)
        return d

    def _values(self, points: Floats) -> Floats:
        return np.asarray(self.function(points[:, 0], points[:, 1]), float)


def _usable(d: Floats) -> Booleans:
    return (d > 0) & (d <= LARGEST_NUMBER)


def require_positive(values: Floats, where: Callable[[int], str]) -> None:
    """Refuse values (n,) that are no spacings; ``where`` returns the place of a value, by its number, for the message.

    CaseError with the first such value and its place.
    """
    _require(_usable(values), values, where, f"a spacing has to be positive and finite (at most {LARGEST_NUMBER:g})")


def require_finite(values: Floats, where: Callable[[int], str]) -> None:
    """Refuse values (n,) that are not finite; ``where`` and errors are as in `require_positive`."""
    _require(
        np.abs(values) <= LARGEST_NUMBER,
        values,
        where,
        f"it has to be finite (at most {LARGEST_NUMBER:g}): fill in what is missing",
    )


def _require(good: Booleans, values: Floats, where: Callable[[int], str], wanted: str) -> None:
    bad = np.flatnonzero(~good)
    if len(bad):
        more = len(bad) - 1
        several = f", and {more} more {'value is' if more == 1 else 'values are'} as bad" if more else ""
        raise CaseError(f"is {values[bad[0]]:g} {where(int(bad[0]))}{several}: {wanted}")


def spots(points: Floats, first: Integers, last: Integers, values: Floats) -> Floats:
    """Points (k, 2), among points (n, 2), from which the ``values`` (n,) rise steeply, and fall nowhere.

    Neighbours are the points ``first`` (e,) and ``last`` (e,). Of more than can be spots the finest are given.
    """
    rise = (values[last] - values[first]) / np.hypot(*(points[last] - points[first]).T)
    least, steepest = np.full(len(points), np.inf), np.full(len(points), -np.inf)
    for node, change in ((first, rise), (last, -rise)):
        np.minimum.at(least, node, change)
        np.maximum.at(steepest, node, change)
    return points[finest(np.flatnonzero(is_spot(least, steepest)), values)]


def is_spot(least: Floats, steepest: Floats) -> Booleans:
    """Whether values that rise from places by ``least`` to ``steepest`` per length do so steeply, and fall nowhere."""
    return (least >= 0) & (steepest > STEEP)


def finest(found: Integers, values: Floats) -> Integers:
    """The numbers (k,) of those places, of many, that have the smallest values: at most as many as can be spots."""
    return found[np.argsort(values[found], kind="stable")[:MOST_SPOTS]]
