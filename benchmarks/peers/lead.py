"""What the page on the peers says first: a few lines for who wants to choose, made of the rows of its tables."""

from collections.abc import Callable, Iterator, Mapping
from functools import partial

from benchmarks.peers.rows import COLUMNS, Row
from benchmarks.peers.runs import SIZES
from benchmarks.peers.tools import OURS, REFERENCE, TOOLS, peers

Rows = Mapping[str, Mapping[str, Row]]
SHAPES = {
    "mean": "**Mean quality** (1 is equilateral)",
    "least": "**The worst triangle**",
    "irregular": "**Inner nodes without six neighbours**",
    "spread": "**Spread of edge lengths** over the wanted ones",
}
FASTEST = "triangle"


def lead(rows: Rows) -> str:
    """Lines of a list: quality, number of nodes, time and memory, and when to choose another tool."""
    return "".join(f"- {line}\n" for line in _lines(_comparable(rows)))


def _comparable(rows: Rows) -> Rows:
    """Cases that this project and a peer have meshed, without the tools that failed."""
    meshed = {case: {tool: row for tool, row in tools.items() if not row.failure} for case, tools in rows.items()}
    return {case: tools for case, tools in meshed.items() if OURS in tools and peers(tools)}


def _lines(rows: Rows) -> Iterator[str]:
    if not rows:
        return
    for key, words in SHAPES.items():
        best = partial(_best, rows, key)
        ahead = sum(_loss(key, tools[OURS]) < _loss(key, tools[best(case)]) for case, tools in rows.items())
        ours, theirs = _range(rows, key, lambda case: OURS), _range(rows, key, best)
        yield f"{words}: {ours}; the best peers have {theirs}. bubblemesh is ahead on {ahead} of {len(rows)} cases."
    yield (
        f"**Number of nodes** over that which the spacing asks for: {_range(rows, 'density', lambda case: OURS)}; "
        f"{TOOLS[REFERENCE].label} has {_range(rows, 'density', lambda case: REFERENCE)}."
    )
    yield from _times({case: rows[case] for case in SIZES if case in rows})
    yield "**Choose another tool** for small meshes at once, and for volumes and surfaces."


def _times(sizes: Rows) -> Iterator[str]:
    """Time and memory from the smallest to the largest mesh of one domain."""
    both = [tools for tools in sizes.values() if REFERENCE in tools]
    if both:
        steps = (f"{tools[OURS]['to_reference']:.2g} times at {tools[OURS]['nodes']:,.0f} nodes" for tools in both)
        yield f"**Time** in terms of {TOOLS[REFERENCE].label}'s: {', '.join(steps)}."
    if fast := [tools for tools in sizes.values() if FASTEST in tools]:
        ours, theirs = fast[-1][OURS], fast[-1][FASTEST]
        yield (
            f"**The fastest** is {TOOLS[FASTEST].label}: {ours['seconds'] / theirs['seconds']:.1f} times as fast as "
            f"bubblemesh at {ours['nodes']:,.0f} nodes, with a mean quality of {theirs['mean']:.2f}."
        )
    if both:
        yield (
            f"**Memory** at {both[-1][OURS]['nodes']:,.0f} nodes: {both[-1][OURS]['peak_mb']:.0f} MB, "
            f"{TOOLS[REFERENCE].label} {both[-1][REFERENCE]['peak_mb']:.0f} MB."
        )


def _loss(key: str, row: Row) -> float:
    return COLUMNS[key].loss(row[key])


def _best(rows: Rows, key: str, case: str) -> str:
    """Which peer has the best figure of a case."""
    return min(peers(rows[case]), key=lambda tool: _loss(key, rows[case][tool]))


def _range(rows: Rows, key: str, choose: Callable[[str], str]) -> str:
    """Least and largest figure of a column, over the tool chosen for each case."""
    values = [tools[tool][key] for case, tools in rows.items() if (tool := choose(case)) in tools]
    column = COLUMNS[key]
    return f"{column.shown(min(values))} to {column.shown(max(values))}" if values else "no figures"
