"""Table 4: the course of FNPBS on Example 3, and what it depends on."""

from collections.abc import Mapping
from itertools import pairwise
from statistics import median

from benchmarks.paper.markdown import markdown, ratio, spread
from benchmarks.paper.published import TABLE_4, VARIANTS
from benchmarks.paper.runs import Runs
from benchmarks.paper.verdicts import ON_THE_WAY, round_verdict

COLUMNS = (
    *("round", "nodes: paper", "ours", "difference", "N / N_id", "mean q: paper", "ours"),
    *("cost: paper", "evaluations", "seconds", "verdict"),
)
COURSE = """\
Mean q is measured after the population control of a round and before the next relaxation. Differences are those of the
median; costs are those of the round alone, seconds by the clock, as ratios to the first round's. The last round is
twice as long."""
DEPENDS = """\
The same case with one thing changed at a time: nodes and mean q after some of the rounds, medians of the seeds. The
paper's boundary nodes follow from its numbers of nodes and elements."""


def course(run: Runs) -> str:
    """Table 4, round by round."""
    nodes, quality = states(run)
    ideal = run.first.report["ideal_nodes"]
    costs = zip(*(_to_first(seconds) for seconds in (_paper_seconds(), *_our_costs(run))), strict=True)
    rows = []
    for number, (state, n, q, cost) in enumerate(zip(TABLE_4, nodes, quality, [("", "", ""), *costs], strict=True)):
        rows.append(
            [
                *(number, state.nodes, spread(n), f"{median(n) / state.nodes - 1:+.1%}", f"{median(n) / ideal:.3f}"),
                *(f"{state.quality:.4f}", spread(q, digits=4), *cost),
                round_verdict(state, median(n), median(q), ON_THE_WAY if number else 0),
            ]
        )
    return markdown("Table 4: FNPBS on Example 3, round by round", COURSE, COLUMNS, rows)


def variants(runs: Mapping[str, Runs]) -> str:
    """Nodes and mean q after the first rounds and the last one, for variants of the case."""
    shown = (1, 2, 3, len(TABLE_4) - 1)
    columns = ["", *(f"nodes: {n}" for n in shown), *(f"q: {n}" for n in shown), "boundary nodes at the end"]
    theirs = [TABLE_4[n] for n in shown]
    rows = [_cells("paper", [s.nodes for s in theirs], [s.quality for s in theirs], TABLE_4[-1].boundary_nodes)]
    for case, label in VARIANTS.items():
        nodes, quality = states(runs[case])
        on_boundary = median(runs[case].figures(lambda report: report["boundary_nodes"]))
        rows.append(_cells(label, [median(nodes[n]) for n in shown], [median(quality[n]) for n in shown], on_boundary))
    return markdown("What Table 4 depends on", DEPENDS, columns, rows)


def states(run: Runs) -> tuple[list[list[float]], list[list[float]]]:
    """Nodes and mean q at the start and after each round, for each seed."""
    initial = [result.report["initial"] for result in run.results]
    nodes = [[row["nodes"] for row in initial], *run.by_round("nodes_after")]
    return nodes, [[row["quality_mean"] for row in initial], *run.by_round("quality_mean")]


def _cells(label: str, nodes: list[float], quality: list[float], on_boundary: float) -> list[str]:
    return [label, *(f"{n:.0f}" for n in nodes), *(f"{q:.4f}" for q in quality), f"{on_boundary:.0f}"]


def _paper_seconds() -> list[float]:
    return [after.seconds - before.seconds for before, after in pairwise(TABLE_4)]


def _our_costs(run: Runs) -> tuple[list[float], list[float]]:
    """Median evaluations and seconds of each round."""
    evaluations, seconds = run.by_round("force_evaluations"), run.by_round("seconds")
    return [median(values) for values in evaluations], [median(values) for values in seconds]


def _to_first(costs: list[float]) -> list[str]:
    return [ratio(cost, costs[0]) for cost in costs]
