"""Names for the array types in signatures, and what NumPy lacks: rows of records, ranks, groups, kinds of numbers."""

from collections.abc import Sequence
from functools import reduce
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
ShortIntegers = NDArray[np.int32]
Booleans = NDArray[np.bool_]
Rows = TypeVar("Rows", Floats, Integers, Booleans)
Numbers = TypeVar("Numbers", Floats, Integers)
Columns = TypeVar("Columns", bound=NamedTuple)  # a record of arrays of the same length

ROUNDING = 1e-9  # relative: values that differ by less are the same but for rounding
TINY = float(np.finfo(float).tiny)  # what is divided by in place of 0
LARGEST_NUMBER = 1e70  # of coordinates and lengths: their fourth powers, which predicates take, must stay finite
SMALLEST_EXTENT = 1e-70  # of a domain or a mesh: its fourth power is still a number
GAUSS = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3)  # places of the two-point Gauss rule on [0, 1], of equal weights


def members(counts: Integers) -> tuple[Integers, Integers]:
    """Groups (m,) and ranks (m,) within them, from 0, of all members of groups with ``counts`` (n,) members."""
    group = np.repeat(np.arange(len(counts)), counts)
    return group, np.arange(len(group)) - (np.cumsum(counts) - counts)[group]


def pairs_of_groups(group: Integers) -> tuple[Integers, Integers]:
    """Pairs, (m,) and (m,), of all things that are in the same group (n,), each of them with itself, too."""
    count = np.bincount(group)
    one, rank = members(count[group])
    first = np.cumsum(count) - count
    return one, np.argsort(group, kind="stable")[first[group[one]] + rank]


def components(pairs: Integers, count: int) -> Integers:
    """Number (n,) of the group of each of ``count`` things that pairs (m, 2) of them join, in the order of the first.

    It takes no library that would take longer to load than most files take to read.
    """
    least = np.arange(count)
    i, j = pairs.T
    for _ in range(count):
        before = least.copy()
        lower = np.minimum(least[i], least[j])
        np.minimum.at(least, i, lower)
        np.minimum.at(least, j, lower)
        np.minimum.at(least, before, least)  # all that were known to be of one group learn of it
        least = least[least]
        if (least == before).all():
            break
    return np.cumsum(least == np.arange(count))[least] - 1


def extent(points: Floats) -> float:
    """Longer side of the box around points (n, 2)."""
    # Column by column, which NumPy looks through several times faster than row by row.
    return max(float(np.ptp(column)) for column in np.ascontiguousarray(points.T))


def select(record: Columns, which: Integers | Booleans) -> Columns:
    """Record with the rows ``which`` (k,) of its columns."""
    numbers = which.nonzero()[0] if which.dtype == bool else which
    return record._make(column.take(numbers, axis=0) for column in record)


def taken(table: Rows, which: Integers | Booleans) -> Rows:
    """Rows (..., k) of a table (n, k) as ``table[which]`` gives them: much faster for few columns."""
    return table.take(which.nonzero()[0] if which.dtype == bool else which, axis=0)


def concatenated(records: Sequence[Columns]) -> Columns:
    """Record with the rows of all records, of which there is at least one."""
    return records[0]._make(np.concatenate(columns) for columns in zip(*records, strict=True))


def least_of_rows(table: Numbers) -> Numbers:
    """Least number (n,) of each row of a table (n, k) of few columns: much faster than NumPy's ``min``."""
    return reduce(np.minimum, table.T)


def largest_of_rows(table: Numbers) -> Numbers:
    """Largest number (n,) of each row of a table (n, k) of few columns: much faster than NumPy's ``max``."""
    return reduce(np.maximum, table.T)


def any_of_rows(table: Booleans) -> Booleans:
    """Whether any (n,) of each row of a table (n, k) of few columns is true: much faster than NumPy's ``any``."""
    return reduce(np.logical_or, table.T)


def all_of_rows(table: Booleans) -> Booleans:
    """Whether all (n,) of each row of a table (n, k) of few columns are true: much faster than NumPy's ``all``."""
    return reduce(np.logical_and, table.T)


def gathered(points: Floats, which: Integers) -> Floats:
    """Points (m, k, 2) of rows of numbers (m, k) as ``points[which]`` gives them, but in memory column after column.

    What takes all of a column then is several times faster.
    """
    return np.ascontiguousarray(points.T).take(which.T, axis=1).T


def median(numbers: Floats) -> float:
    """Median of numbers (n,), of which there is at least one: NumPy's would load its masked arrays."""
    middle = (len(numbers) - 1) // 2, len(numbers) // 2
    return float(np.sort(numbers)[np.array(middle)].mean())


def quantile(numbers: Floats, share: float) -> float:
    """Number below which a share of numbers (n,) lies, as NumPy's gives it, which would load its masked arrays."""
    place = share * (len(numbers) - 1)
    below = int(place)
    low, high = np.sort(numbers)[[below, min(below + 1, len(numbers) - 1)]].tolist()
    rest, step = place - below, high - low
    return float(high - step * (1 - rest) if rest >= 0.5 else low + step * rest)


def different_rows(rows: Rows) -> tuple[Rows, Integers]:
    """The different ones (k, m) of rows (n, m), ascending column by column, and the number (n,) of each among them.

    It is much faster than NumPy's ``unique`` along an axis, which compares rows as records.
    """
    order, fresh = _ascending(rows)
    number = np.empty(len(rows), np.int64)
    number[order] = np.cumsum(fresh) - 1
    return rows[order[fresh]], number


def first_rows(rows: Rows) -> Integers:
    """Numbers (k,) of those of rows (n, m) that equal none before them, ascending."""
    order, fresh = _ascending(rows)
    return np.sort(order[fresh])


def _ascending(rows: Rows) -> tuple[Integers, Booleans]:
    """Order (n,) of rows (n, m) by their columns, equal ones as they come, and which (n,) differ from those before."""
    order = np.lexsort(rows.T[::-1])
    ascending = rows[order]
    return order, np.append(True, (ascending[1:] != ascending[:-1]).any(axis=1))[: len(rows)]


def unmasked(values: Any) -> Any:
    """The values as they are, or an array with no numbers where those of a masked one are hidden."""
    if not (hasattr(values, "filled") and np.any(getattr(values, "mask", False))):
        return values
    return values.astype(complex if np.iscomplexobj(values) else float).filled(np.nan)


def is_whole(value: Any, least: float = -np.inf) -> bool:
    """Whether a value is a whole number, of Python or NumPy, that is not below ``least``."""
    return isinstance(value, int | np.integer) and not isinstance(value, bool) and bool(value >= least)


def is_real(value: Any) -> bool:
    """Whether a value is a number, of Python or NumPy, and no truth value."""
    return isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)


def complement(count: int, numbers: Integers) -> Integers:
    """Numbers (k,) from 0 up to ``count`` that are not among some (n,); NumPy's ``setdiff1d`` loads masked arrays."""
    free = np.ones(count, bool)
    free[numbers[(numbers >= 0) & (numbers < count)]] = False
    return np.flatnonzero(free)


def side_by_side(x: Floats, y: Floats) -> Floats:
    """Points (n, 2) of their coordinates x (n,) and y (n,): of few points much faster than NumPy's ``column_stack``."""
    points = np.empty((len(x), 2))
    points[:, 0], points[:, 1] = x, y
    return points


def cross(a: Floats, b: Floats) -> Floats:
    """Cross products (...) of vectors (..., 2)."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def turned_left(vectors: Floats) -> Floats:
    """Vectors (n, 2) turned to the left by a right angle."""
    return side_by_side(-vectors[:, 1], vectors[:, 0])


def ring_area(points: Floats) -> float:
    """Area within a ring of points (n, 2), negative where they go clockwise."""
    near = points - points[0]
    (x, y), (xx, yy) = near.T, np.concatenate([near[1:], near[:1]]).T
    return float(np.sum(x * yy - xx * y)) / 2


def each_once(numbers: Integers) -> Integers:
    """The different ones (k,) of numbers (n,), ascending: much faster than NumPy's ``unique``, which hashes them."""
    return different(np.sort(numbers))


def different(ascending: Integers) -> Integers:
    """The different ones (k,) of numbers (n,) that ascend."""
    return ascending[np.append(True, ascending[1:] != ascending[:-1])[: len(ascending)]]


def contained(numbers: Integers, some: Integers) -> Booleans:
    """Whether each of the numbers (n,) is among ``some`` (k,), which ascend; none is negative.

    NumPy's ``isin`` would load its masked arrays.
    """
    return np.append(some, -1)[np.searchsorted(some, numbers)] == numbers
