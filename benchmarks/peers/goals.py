"""What this project wants to reach, and whether it does."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from statistics import median

import numpy as np

from benchmarks.peers.rows import COLUMNS, Column, row
from benchmarks.peers.runs import NAN, WHOLE, CaseRuns
from benchmarks.peers.tools import BEST, OURS

ANY = float("inf")

# Least mean q, 1 % q and least q, largest spread of l/d, and bounds of N / N_id.
SHAPES = {
    ("example-1", OURS): (0.9950, 0.952, 0.905, 0.045, (0.97, 1.03)),
    ("example-2", OURS): (0.986, 0.905, 0.84, 0.068, (0.97, 1.04)),
    ("example-3", OURS): (0.984, 0.911, 0.89, 0.066, (0.97, 1.03)),
    ("example-3", BEST): (0.986, 0.917, 0.89, 0.061, (0.97, 1.03)),
    ("example-4", OURS): (0.984, 0.890, 0.79, 0.074, (0.97, 1.05)),
    ("dense", OURS): (0.9715, 0.900, 0.85, 0.076, (0.97, 1.03)),
    ("example-3-9000", OURS): (0.9948, 0.955, 0.90, 0.052, (0.98, 1.02)),
    ("example-3-9000", BEST): (0.9961, 0.961, 0.90, 0.044, (0.98, 1.02)),
    ("example-3-87000", OURS): (0.9972, 0.971, 0.90, 0.040, (0.98, 1.02)),
    ("example-3-87000", BEST): (0.9982, 0.974, 0.90, 0.032, (0.98, 1.02)),
    ("example-3-900000", OURS): (0.9976, 0.982, 0.86, 0.031, (0.98, 1.02)),
    ("example-3-900000", BEST): (0.9987, 0.989, 0.89, 0.024, (0.98, 1.02)),
}
# Largest value of a column, and what would be better still.
COSTS = (
    ("example-3", OURS, "to_reference", 4.0, 2.0),
    ("example-3-1000", OURS, "to_reference", 4.0, 2.0),
    ("example-3-9000", OURS, "to_reference", 0.9, NAN),
    ("example-3-9000", BEST, "seconds", 2.5, NAN),
    ("example-3-28000", OURS, "to_reference", 0.45, NAN),
    ("example-3-87000", OURS, "to_reference", 0.3, NAN),
    ("example-3-900000", OURS, "to_reference", 0.25, NAN),
    ("example-3-900000", BEST, "to_reference", 0.6, NAN),
    ("example-3-87000", OURS, "to_floor", 10.0, NAN),
    ("example-3-900000", OURS, "to_floor", 10.0, NAN),
    ("example-3-900000", OURS, "peak_mb", 700.0, NAN),
)
WHOLE_SECONDS = Column("start to end, s", ".2f"), 0.8
GROWTH = Column("CPU s per node", ".2f"), "example-3-900000", "example-3-87000", 1.3

Value = Callable[[str, str, str], float]


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
    for (case, tool), (mean, p01, least, spread, (few, many)) in SHAPES.items():
        bounds = {"mean": (mean, ANY), "p01": (p01, ANY), "least": (least, ANY), "spread": (-ANY, spread)}
        for key, (low, high) in (bounds | {"density": (few, many)}).items():
            yield Goal(_name(case, tool), COLUMNS[key], value(case, tool, key), low, high)


def costs(results: Mapping[str, CaseRuns]) -> Iterator[Goal]:
    """The goals of time and memory."""
    value = _ours(results)
    for case, tool, key, high, aim in COSTS:
        yield Goal(_name(case, tool), COLUMNS[key], value(case, tool, key), high=high, aim=aim)
    column, limit = WHOLE_SECONDS
    for case in WHOLE:
        times = results[case].whole if case in results else ()
        yield Goal(case, column, median(times) if times else NAN, high=limit)
    column, large, small, limit = GROWTH
    per_node = [value(case, OURS, "seconds") / value(case, OURS, "nodes") for case in (large, small)]
    yield Goal(f"{large} / {small}", column, per_node[0] / per_node[1], high=limit)


def _name(case: str, tool: str) -> str:
    return case if tool == OURS else f"{case}, best"


def _ours(results: Mapping[str, CaseRuns]) -> Value:
    """Figure of this project on a case, at an effort, NaN where there is none."""
    rows = {
        (name, tool): row(case, tool) for name, case in results.items() for tool in (OURS, BEST) if tool in case.tools
    }
    return lambda case, tool, key: rows[case, tool][key] if (case, tool) in rows else NAN
