"""What this project wants to reach at its default settings, and whether it does."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from statistics import median

import numpy as np

from benchmarks.peers.rows import COLUMNS, Column, row
from benchmarks.peers.runs import NAN, WHOLE, CaseRuns
from benchmarks.peers.tools import OURS

ANY = float("inf")

# Least mean q, 1 % q and least q, largest spread of l/d, and bounds of N / N_id.
SHAPES = {
    "example-1": (0.993, 0.935, 0.86, 0.066, (0.97, 1.03)),
    "example-2": (0.986, 0.905, 0.84, 0.068, (0.97, 1.04)),
    "example-3": (0.980, 0.892, 0.84, 0.077, (0.97, 1.03)),
    "dense": (0.967, 0.870, 0.78, 0.083, (0.97, 1.03)),
    "example-4": (0.984, 0.890, 0.79, 0.074, (0.97, 1.05)),
    "example-3-9000": (0.9935, 0.950, 0.80, 0.066, (0.98, 1.02)),
    "example-3-87000": (0.9960, 0.968, 0.80, 0.060, (0.98, 1.02)),
}
# Largest value of a column, and what would be better still.
COSTS = (
    ("example-3-9000", "to_reference", 2.0, 1.0),
    ("example-3-87000", "to_reference", 0.8, 0.4),
    ("example-3-900000", "to_reference", 0.4, 0.2),
    ("example-3-87000", "to_floor", 10.0, NAN),
    ("example-3-900000", "to_floor", 10.0, NAN),
    ("example-3-900000", "peak_mb", 1500.0, NAN),
)
WHOLE_SECONDS = Column("start to end, s", ".2f"), 0.8
GROWTH = Column("CPU s per node", ".2f"), "example-3-900000", "example-3-87000", 1.3

Value = Callable[[str, str], float]


@dataclass(frozen=True)
class Goal:
    """A figure of a case with its bounds, and what would be better still; the value is NaN if it was not measured."""

    case: str
    column: Column
    value: float
    low: float = -ANY
    high: float = ANY
    aim: float = NAN

    @property
    def bounds(self) -> str:
        """The bounds as text."""
        low, high = self.column.shown(self.low), self.column.shown(self.high)
        if self.low == -ANY:
            return f"at most {high}"
        return f"at least {low}" if self.high == ANY else f"{low} to {high}"

    @property
    def verdict(self) -> str:
        """Whether the value is within the bounds, and how far from the nearer one."""
        if self.value != self.value:
            return "not measured"
        margin = min(self.value - self.low, self.high - self.value)
        return f"{'met' if margin >= 0 else '**missed**'} by {_two_digits(abs(margin))}"


def _two_digits(value: float) -> str:
    return np.format_float_positional(value, precision=2, fractional=False, trim="-")


def shapes(results: Mapping[str, CaseRuns]) -> Iterator[Goal]:
    """The goals of quality."""
    value = _ours(results)
    for case, (mean, p01, least, spread, (few, many)) in SHAPES.items():
        bounds = {"mean": (mean, ANY), "p01": (p01, ANY), "least": (least, ANY), "spread": (-ANY, spread)}
        for key, (low, high) in (bounds | {"density": (few, many)}).items():
            yield Goal(case, COLUMNS[key], value(case, key), low, high)


def costs(results: Mapping[str, CaseRuns]) -> Iterator[Goal]:
    """The goals of time and memory."""
    value = _ours(results)
    for case, key, high, aim in COSTS:
        yield Goal(case, COLUMNS[key], value(case, key), high=high, aim=aim)
    column, limit = WHOLE_SECONDS
    for case in WHOLE:
        times = results[case].whole if case in results else ()
        yield Goal(case, column, median(times) if times else NAN, high=limit)
    column, large, small, limit = GROWTH
    per_node = [value(case, "seconds") / value(case, "nodes") for case in (large, small)]
    yield Goal(f"{large} / {small}", column, per_node[0] / per_node[1], high=limit)


def _ours(results: Mapping[str, CaseRuns]) -> Value:
    """Figure of this project on a case, NaN where there is none."""
    rows = {name: row(case, OURS) for name, case in results.items() if OURS in case.tools}
    return lambda case, key: rows[case][key] if case in rows else NAN
