"""Costs of the methods, side by side."""

from collections.abc import Mapping

import numpy as np

from benchmarks.paper.markdown import markdown, percent
from benchmarks.paper.published import COMPARISONS, ROWS, TABLE_4, Comparison
from benchmarks.paper.runs import Runs
from benchmarks.paper.verdicts import claim_verdict

COLUMNS = (
    *("", "claim", "paper: reduced by", "ours, evaluations", "seconds", "reduced by the claim?"),
    *("paper: dearer by", "ours, evaluations", "seconds", "dearer by the claim?"),
)
TEXT = """\
A cost that falls from 100 to 30 is *reduced by* 70 %, and the former is *dearer by* 233 %. The paper's Table 5 prints
reductions; in its words costs decrease by roughly 80 %, except on Example 1. Each claim is tested as "at least", in
both readings and in force evaluations; seconds are given beside them. On Example 2 the paper's FNPBS ends after 1250
iterations, that is four rounds, before the population has settled; by its own rule it takes ten."""


def costs(runs: Mapping[str, Runs]) -> str:
    """The comparisons, each in two readings."""
    return markdown("Costs, side by side", TEXT, COLUMNS, [_cells(comparison, runs) for comparison in COMPARISONS])


def _cells(comparison: Comparison, runs: Mapping[str, Runs]) -> list[str]:
    dear, cheap = runs[comparison.dear], runs[comparison.cheap]
    pairs = (
        (ROWS[comparison.dear].seconds, ROWS[comparison.cheap].seconds),
        (dear.cost, cheap.cost),
        (dear.time, cheap.time),
    )
    cells = [comparison.label, percent(comparison.claim)]
    for reading in (reduction, excess):
        paper, evaluations, seconds = (reading(*pair) for pair in pairs)
        cells += [percent(paper), percent(evaluations), percent(seconds), claim_verdict(comparison, evaluations)]
    return cells


def reduction(dear: float | None, cheap: float | None) -> float | None:
    """By which part of the dear one the cheap one is less."""
    return None if dear is None or cheap is None else 1 - cheap / dear


def excess(dear: float | None, cheap: float | None) -> float | None:
    """By which part of the cheap one the dear one is more."""
    return None if dear is None or cheap is None else dear / cheap - 1


def priced(run: Runs) -> float:
    """Seconds that the paper's program would take for the rounds of the first run, as Table 4 has them."""
    iterations, seconds, nodes, *_ = np.array(TABLE_4).T
    a_step = np.diff(seconds) / np.diff(iterations)
    most_first = nodes[:-1]
    return sum(
        row["iterations"] * float(np.interp(row["nodes_before"], most_first[::-1], a_step[::-1]))
        for row in run.first.report["rounds"]
    )
