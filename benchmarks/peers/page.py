"""The page docs/peers.md."""

from collections.abc import Iterable, Iterator, Mapping

from benchmarks.peers.figures import CAPTIONS
from benchmarks.peers.goals import Goal, costs, shapes
from benchmarks.peers.lead import lead
from benchmarks.peers.machine import machine, versions
from benchmarks.peers.rows import COLUMNS, Column, Row
from benchmarks.peers.runs import TIMEOUT, CaseRuns
from benchmarks.peers.tools import ITERATIONS, OURS, REFERENCE, RELOCATIONS, TOOLS, peers
from benchmarks.peers.with_distmesh import STEPS
from benchmarks.peers.with_jigsaw import TOLERANCE

ASTRAY = 1e-6  # of the spacing: boundary nodes that are closer are on the boundary
TITLE = "# Beside other mesh generators\n"
HEAD = """\
## How it was measured

Made by `{command}`; the cases are in [configs/peers](../configs/peers).
{machine}; {versions}.

Repeats of each run: {repeats}, of cases above 100,000 nodes 1.
The tools take turns, and every run has a process of its own with one thread. A
run that gives no mesh within {timeout} minutes has failed. bubblemesh ran with its method `{method}` and its
default settings (*fast* and *best* are its other two efforts), the peers with theirs but for what is said here.

**What is counted.** *CPU s* is the processor time of meshing, the median of the repeats, without imports; */ Gmsh* is
its ratio to that of {reference} in the same repeat, */ floor* that to one constrained Delaunay triangulation
of bubblemesh's own nodes (medians of the ratios). For bubblemesh this is all from the case to the end of packing:
checks of geometry and spacing, placement, rounds, and their figures. For Gmsh it is the generation of the mesh, without
setting up geometry and size field, as for Netgen; for Triangle, DistMesh and JIGSAW it is all but the survey of the
case, with JIGSAW's reading and writing of files. *Peak MB* is the largest memory of the whole process: {ready} are
Python, its packages and the case, before the meshing begins; bubblemesh's also has its quality report.

**What is measured.** All meshes by the same functions: radius ratio *q* of the triangles (mean, first percentile,
least), share of the inner nodes that do not have six neighbours (*irregular*), mean and standard deviation of edge
length over wanted spacing (*l/d*). A mesh with an inverted triangle or a gap counts as failed. {boundary}

**N / N_id** is the number of nodes over that which the spacing asks for. Who places more nodes has shorter edges and
pays for more unknowns: compare rows of nearly equal N / N_id. {density}

**How the peers were set.** Gmsh has the true arcs, the spacing as a MathEval field, and no sizes from points, curvature
or boundary; Relocate2D makes {relocations} steps. Triangle gets the boundary nodes at equal intervals of ds/d, 30
degrees, and largest areas by the spacing at the centroids, refined until they hold; a trial that is not counted sets
their factor for about N_id nodes. DistMesh is a version of ours, from its published description, with at most {steps}
steps and a first lattice that has about N_id nodes; it is tried on the smaller cases only. JIGSAW gets the boundary as
a fine polygon and the spacing on a grid; {iterations} iterations of its optimization go with a tolerance of
{tolerance:g}, without which they end after a few; its restarts are those of its Python package (tetris: coarse levels
first, irregular nodes left out and made anew). Netgen has the true arcs and the spacing as a limit on a grid of points,
lowered by a factor from a trial that is not counted.
"""


def page(
    results: Mapping[str, CaseRuns], rows: Mapping[str, Mapping[str, Row]], command: str, method: str, repeats: int
) -> str:
    """The whole page, from the runs and the rows of the tables by case and tool."""
    head = HEAD.format(
        command=command,
        machine=machine(),
        versions=versions(),
        repeats=repeats,
        timeout=TIMEOUT // 60,
        method=method,
        reference=TOOLS[REFERENCE].label,
        ready=_ready(results),
        relocations=RELOCATIONS,
        steps=STEPS,
        iterations=ITERATIONS,
        tolerance=TOLERANCE,
        boundary=_boundary(results),
        density=_density(rows),
    )
    first, *pictures = [f"![{caption}](figures/{name})\n\n{caption}.\n" for name, caption in CAPTIONS.items()]
    return "\n".join(
        [
            TITLE,
            first,
            lead(rows),
            head,
            "## Goals\n",
            _shapes(shapes(results)),
            _costs(costs(results)),
            "## Who is best\n",
            *_leaders(rows),
            "\n## Plots\n",
            *pictures,
            "## Cases\n",
            *(_table(name, results[name], tools) for name, tools in rows.items()),
        ]
    )


def _ready(results: Mapping[str, CaseRuns]) -> str:
    held = [run.ready_mb for case in results.values() for runs in case.tools.values() for run in runs if run.figures]
    return f"{min(held):.0f} to {max(held):.0f} MB of it" if held else "parts of it"


def _boundary(results: Mapping[str, CaseRuns]) -> str:
    """Whose boundary nodes are off the boundary, and how far."""
    astray: dict[str, float] = {}
    for case in results.values():
        for tool, runs in case.tools.items():
            distances = [run.figures.astray for run in runs if run.figures]
            astray[tool] = max([astray.get(tool, 0.0), *distances])
    off = [f"{TOOLS[tool].label} (up to {d:.1g} d)" for tool, d in astray.items() if d > ASTRAY]
    return f"All boundary nodes are on the boundary{', but for ' + ', '.join(off) if off else ''}."


def _density(rows: Mapping[str, Mapping[str, Row]]) -> str:
    ranges = []
    for tool in TOOLS:
        values = [found[tool]["density"] for found in rows.values() if tool in found and not found[tool].failure]
        if values:
            ranges.append(f"{TOOLS[tool].label} {min(values):.2f} to {max(values):.2f}")
    return f"Over all cases it is: {', '.join(ranges)}."


def _shapes(goals: Iterable[Goal]) -> str:
    """A line for each case, a column for each figure."""
    by_case: dict[str, list[Goal]] = {}
    for goal in goals:
        by_case.setdefault(goal.case, []).append(goal)
    titles = [goal.column.title for goal in next(iter(by_case.values()))]
    lines = [f"| | {' | '.join(titles)} |", "|---" * (len(titles) + 1) + "|"]
    for case, found in by_case.items():
        cells = [f"{goal.column.shown(goal.value)}<br>{goal.bounds}: {goal.verdict}" for goal in found]
        lines.append(f"| {case} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def _costs(goals: Iterable[Goal]) -> str:
    lines = ["| case | | goal | aim | measured | |", "|---|---|---|---|---|---|"]
    for goal in goals:
        title, value, aim = goal.column.title, goal.column.shown(goal.value), goal.column.shown(goal.aim)
        lines.append(f"| {goal.case} | {title} | {goal.bounds} | {aim} | {value} | {goal.verdict} |")
    return "\n".join(lines) + "\n"


def _leaders(rows: Mapping[str, Mapping[str, Row]]) -> Iterator[str]:
    """A sentence for each column that compares."""
    for key, column in COLUMNS.items():
        best = {case: found for case, tools in rows.items() if (found := _best(peers(tools), tools, key, column))}
        if column.loss and best:
            yield f"- **{column.title}**: {_sentence(rows, key, column, best)}"


def _best(names: Iterable[str], tools: Mapping[str, Row], key: str, column: Column) -> str | None:
    """Which of the tools has the best figure in a column that compares."""
    able = [name for name in names if not tools[name].failure]
    return min(able, key=lambda name: column.loss(tools[name][key]), default=None) if column.loss else None


def _sentence(rows: Mapping[str, Mapping[str, Row]], key: str, column: Column, best: Mapping[str, str]) -> str:
    led: dict[str, list[str]] = {}
    for case, tool in best.items():
        led.setdefault(TOOLS[tool].label, []).append(f"{case} ({column.shown(rows[case][tool][key])})")
    text = "the best peer is " + "; ".join(f"{label} on {', '.join(cases)}" for label, cases in led.items())
    ours = {case: rows[case][OURS] for case in best if OURS in rows[case] and not rows[case][OURS].failure}
    if not ours:
        return f"{text}."
    ahead = [case for case, row in ours.items() if column.loss(row[key]) < column.loss(rows[case][best[case]][key])]
    behind = [f"{case} ({column.shown(row[key])})" for case, row in ours.items() if case not in ahead]
    lag = f", not on {', '.join(behind)}" if behind else ""
    return f"{text}. bubblemesh is ahead on {len(ahead)} of {len(ours)}{lag}."


def _table(name: str, case: CaseRuns, tools: Mapping[str, Row]) -> str:
    titles = [column.title for column in COLUMNS.values()]
    lines = [
        f"### {name}: N_id = {case.ideal_nodes:.0f}\n",
        f"| | {' | '.join(titles)} |",
        "|---" * (len(titles) + 1) + "|",
    ]
    best = {key: _best(tools, tools, key, column) for key, column in COLUMNS.items()}
    for tool, row in tools.items():
        cells = [column.shown(row[key]) for key, column in COLUMNS.items()]
        cells = [f"**{cell}**" if best[key] == tool else cell for key, cell in zip(COLUMNS, cells, strict=True)]
        if row.failure:
            cells = [f"failed: {row.failure}", *[""] * (len(cells) - 1)]
        lines.append(f"| {TOOLS[tool].label} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"
