"""What the tables show of a tool on a case: a column for each figure, with its name and what counts as better."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from statistics import median
from typing import Any

from benchmarks.peers.runs import NAN, CaseRuns, Run
from benchmarks.peers.tools import OURS, REFERENCE


def _low(value: float) -> float:
    return value


def _high(value: float) -> float:
    return -value


def _close_to_one(value: float) -> float:
    return abs(value - 1)


@dataclass(frozen=True)
class Column:
    """A figure: its heading, its format, and what is to be small for it to be good (None: not compared)."""

    title: str
    form: str
    loss: Callable[[float], float] | None = None

    def shown(self, value: float) -> str:
        """The value as text; empty if there is none."""
        return "" if value != value else format(value, self.form)


COLUMNS = {
    "nodes": Column("nodes", ".0f"),
    "density": Column("N / N_id", ".3f", _close_to_one),
    "seconds": Column("CPU s", ".3g", _low),
    "to_reference": Column("/ Gmsh", ".2f"),
    "to_floor": Column("/ floor", ".1f"),
    "peak_mb": Column("peak MB", ".0f", _low),
    "mean": Column("mean q", ".4f", _high),
    "p01": Column("1 % q", ".3f", _high),
    "least": Column("least q", ".3f", _high),
    "irregular": Column("irregular", ".3f", _low),
    "edge": Column("l/d mean", ".3f", _close_to_one),
    "spread": Column("l/d spread", ".3f", _low),
}


@dataclass(frozen=True)
class Row:
    """Figures of a tool on a case by the keys of ``COLUMNS``, or why there are none."""

    values: Mapping[str, float]
    failure: str = ""

    def __getitem__(self, key: str) -> float:
        return self.values.get(key, NAN)


def row(case: CaseRuns, tool: str) -> Row:
    """The row of a tool: medians of the costs over the repeats; the figures of a mesh are the first one's."""
    runs = case.tools[tool]
    failures = [run.failure for run in runs if run.failure]
    if failures:
        return Row({}, failures[0])
    figures = runs[0].figures
    costs = {
        "seconds": median(run.seconds for run in runs),
        "to_reference": _ratio(runs, case.tools.get(REFERENCE, ()), lambda run: run.seconds),
        "to_floor": _ratio(runs, case.tools.get(OURS, ()), lambda run: run.floor),
        "peak_mb": max(run.peak_mb for run in runs),
        "density": figures.nodes / case.ideal_nodes,
    }
    return Row(vars(figures) | costs)


def _ratio(runs: tuple[Run, ...], others: tuple[Run, ...], cost: Callable[[Run], Any]) -> float:
    """Median of the ratios of a run's time to a cost of the other's in the same repeat."""
    if len(others) < len(runs) or any(other.failure for other in others):
        return NAN
    return median(run.seconds / cost(other) for run, other in zip(runs, others, strict=False))
