"""The page docs/reproduction.md: the paper's figures beside ours, with a verdict for each row."""

import platform
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from statistics import median
from typing import NamedTuple

import numpy
import scipy

from benchmarks.paper.costs import costs, priced, reduction
from benchmarks.paper.course import course, states, variants
from benchmarks.paper.figures import Drawing
from benchmarks.paper.markdown import markdown, percent, printed, ratio, spread
from benchmarks.paper.published import COMPARISONS, REFERENCE, ROWS, TABLE_1, TABLES, VARIANTS, Table
from benchmarks.paper.runs import SEEDS, Runs
from benchmarks.paper.verdicts import ABOVE, FINAL, ON_THE_WAY, verdict

HEAD = """\
# Reproduction of the paper

The paper is N. Qi, Y. Nie, W. Zhang, "Acceleration strategies based on an improved bubble packing method",
Communications in Computational Physics 16 (2014) 115-135, identified by its abstract.

Made by `python -m benchmarks.paper`; the cases are in [configs/paper](../configs/paper), the examples there with the
methods' own parameters, each row of a table in a case that extends one of them. Each row was run with the seeds
{seeds}: all figures are medians, those of nodes, rounds and mean q with the range over the seeds in brackets where they
differ; drawings are of seed {first}. {versions}.

**Cost** is a ratio to the first row of its table, run beside it, in force evaluations (a bubble in one evaluation; a
second-order Euler step has two, a Runge-Kutta step four) and in seconds of processor time; the paper's seconds are
turned into the same ratio. **N / N_id** is the number of nodes over that of a perfect packing; a method that deletes
more has fewer nodes to do better with, so that quality is to be read beside it.

**Verdicts.** *Reproduced*: the initial count is exact, the final one within {final} (5 % on Example 2; {on_the_way}
after a round of Table 4), mean q not below the paper's. *Better*: the same with mean q higher by more than {above}.
Costs have [a table of their own](#costs-side-by-side).

## What reproduces and what does not

- **Initial counts** are exact in every row but one: the paper's 1432 nodes at w1 = 1.2 are 1444 by the rule that gives
  all others.
- **What the paper does not print** is the time step, the overlap ratio above which a bubble is deleted, how far apart
  the deletions of a round are, and in which order crowded bubbles are met. All cases here take the force as printed
  with a time step of 0.02, a ratio of 7.8, a distance of 1.21 spacings, and, for FNPBS, a random order: fitted to the
  course of Table 4 and the final counts of Table 3, they serve the other tables too. With their own force and time step
  (scaled, 0.2), which bring the bubbles nearer to rest within a round, the methods need no such choice and make better
  meshes, but mean q after round 2 of Table 4 is {own_step} then, below the paper's 0.8268. Of the rest the
  order of deletion matters most: in the order of placement, or of crowding, more deletions fit between the same
  distances. Insertion and the threshold play no part in the first rounds, nor does the displacement of the first
  bubbles beyond the spread of the seeds ([What Table 4 depends on](#what-table-4-depends-on)).
- **Table 4** reproduces in its first three rounds and at the end. In rounds 4 and 5 our population is ahead of the
  paper's by 2 %, and from there on its triangles are better: the bubbles settle sooner. More of them stay on the
  boundary; a lower threshold there would bring their number down, at the cost of the first rounds.
- **Mean q at the end** is higher than the paper's in all tables.
- **Table 2** does not reproduce for w1 = 0.8 and 0.9: the paper needs more than twice the time there and ends with 780
  and 752 nodes. Here these rows behave like w1 = 1, as their starts differ by 16 boundary nodes only. At w1 = 2 the
  paper ends with fewer nodes (694) than anywhere else; here the start does not matter to the end.
- **w2 = 0.57** does not fail here: the paper's run is the slowest of Table 3, ours the fastest.
- **Odd bubbles** change neither the cost nor the result: with a fixed number of rounds the steps are the same, and the
  few bubbles concerned do not move the mean. The paper's saving on the dense variant (19.6 s to 9.2 s) does not
  reproduce; its loss on Example 3 (4 %) comes from a search by coordinates that tracking by index makes needless.
- **The traditional method** is dearer than FNPBS as in the paper, because of the four force evaluations of a
  Runge-Kutta step; in seconds by less than in evaluations, as the search for neighbours takes the same time.
- **The accelerated method** is cheaper than FNPBS on all examples, least so on Example 1, as in the paper. By how much
  is read in two ways. That FNPBS is *dearer by* at least 70 % on Examples 2 to 4, and by 30 % on Example 1, reproduces.
  That the cost is *reduced by* 70 % on Examples 2 to 4 does not: the paper has 87, 84 and 74 %, ours is {reduced}.
  The difference is in the cost of a step: in Table 4 a round of the paper's program takes 57 s with 1420 bubbles and
  8 s with 712, seven times less for half the bubbles, while ours grows in proportion to their number. Whoever starts
  with fewer bubbles saves less then. At the paper's seconds for rounds with as many bubbles, our cost of Example 3
  would be reduced by {priced}, the paper's is by {paper_priced}.
- **FNPBS on Example 2** took 1250 iterations in the paper, which are four rounds and too few for its population to
  settle. Compared with these the accelerated method saves still less, and in neither reading 70 %.
"""
COLUMNS = (
    *("", "initial: paper", "ours", "final: paper", "ours", "N / N_id", "rounds: paper", "ours"),
    *("mean q: paper", "ours", "cost: paper", "evaluations", "seconds", "verdict"),
)
STAGES = """\
Shares in per cent, ours under Python's profiler. With whole arrays in place of loops over bubbles the forces dominate:
what the paper's program spends on new positions and on sorting is next to nothing."""


def table_text(table: Table, runs: Mapping[str, Runs]) -> str:
    """A table of the paper as Markdown, a line for each row."""
    first = table.rows[0]
    rows = []
    for row in table.rows:
        run = runs[row.case]
        report = run.first.report
        nodes = run.figures(lambda report: report["nodes"])
        rows.append(
            [
                row.label,
                *(printed(row.initial), report["initial"]["nodes"]),
                *(printed(row.final), spread(nodes), f"{median(nodes) / report['ideal_nodes']:.3f}"),
                *(printed(row.rounds), spread(run.figures(lambda report: len(report["rounds"])))),
                *(printed(row.quality), spread(run.figures(lambda report: report["quality"]["mean"]), digits=4)),
                *(ratio(row.seconds, first.seconds), ratio(run.cost, runs[first.case].cost)),
                ratio(run.time, runs[first.case].time),
                verdict(row, run, table.final_tolerance),
            ]
        )
    return markdown(table.title, "", COLUMNS, rows)


class Section(NamedTuple):
    """A section with a table: the table's name, the cases that it needs, and how it is made of their runs."""

    name: str
    cases: tuple[str, ...]
    text: Callable[[Mapping[str, Runs]], str]


SECTIONS = (  # in the order of the page, where that of the stages follows
    *(Section(table.name, tuple(row.case for row in table.rows), partial(table_text, table)) for table in TABLES),
    Section("4", (REFERENCE,), lambda runs: course(runs[REFERENCE])),
    Section("4", tuple(VARIANTS), variants),
    Section("costs", tuple(case for pair in COMPARISONS for case in (pair.dear, pair.cheap)), costs),
)
STAGES_NAME, STAGES_CASE = "1", "table-1"


def page(runs: Mapping[str, Runs], shares: Mapping[str, float], drawings: Iterable[Drawing]) -> str:
    """The whole page, from the runs of all cases and the shares of the stages of Table 1."""
    tables = [section.text(runs) for section in SECTIONS]
    pictures = [f"## {each.caption}\n\n![{each.caption}](figures/{each.file})\n" for each in drawings]
    return "\n".join([_head(runs), *tables, stages(shares), *pictures])


def _head(runs: Mapping[str, Runs]) -> str:
    versions = f"Python {platform.python_version()}, NumPy {numpy.__version__}, SciPy {scipy.__version__}"
    names = [(f"table-5/example-{number}-fnpbs", f"table-5/example-{number}-accelerated") for number in (2, 3, 4)]
    reduced = [f"{100 * reduction(runs[dear].cost, runs[cheap].cost):.0f}" for dear, cheap in names]
    dear, cheap = names[1]
    _, (_, _, second_round, *_) = states(runs["table-4/own-step"])
    return HEAD.format(
        seeds=", ".join(map(str, SEEDS)),
        first=SEEDS[0],
        versions=f"{versions}, {platform.system()} {platform.machine()}",
        final=percent(FINAL),
        on_the_way=percent(ON_THE_WAY),
        above=ABOVE,
        own_step=f"{median(second_round):.4f}",
        reduced=f"{reduced[0]}, {reduced[1]} and {reduced[2]} %",
        priced=percent(reduction(priced(runs[dear]), priced(runs[cheap]))),
        paper_priced=percent(reduction(ROWS[dear].seconds, ROWS[cheap].seconds)),
    )


def stages(shares: Mapping[str, float]) -> str:
    """Table 1 as Markdown: where the time of the traditional method goes."""
    rows = [[stage, f"{share:.1f}", f"{shares[stage]:.1f}"] for stage, share in TABLE_1.items()]
    title = "Table 1: time of the traditional method by stage (Example 3)"
    return markdown(title, STAGES, ("stage", "paper", "ours"), rows)
