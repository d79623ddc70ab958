"""Two meshes side by side on the terminal."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise

from rich.table import Table
from rich.text import Text

from bubblemesh import console
from bubblemesh.meshes.quality import Histogram

TITLES = {"quality": "q", "spacing": "edges l/d"}
BAR = 22  # characters, at most
BESIDE_BARS = 32  # characters of a line
EIGHTHS = " ▏▎▍▌▋▊▉█"  # of a character


def show_comparison(
    names: Sequence[str],
    rows: Iterable[tuple[str, str, str, str]],
    histograms: Mapping[str, Sequence[Histogram | None]],
) -> None:
    """Two meshes side by side: their figures and differences, and histograms as bars of text."""
    for letter, name in zip("AB", names, strict=True):
        console.terminal.print(Text.assemble((f"{letter:11}", "bold"), name))
    table = console.new_table()
    table.add_column("")
    for column in ("A", "B", "B - A"):
        table.add_column(column, justify="right", no_wrap=True)
    for cells in rows:
        table.add_row(*cells)
    console.terminal.print(table)
    for title, both in histograms.items():
        if any(histogram is not None for histogram in both):
            console.terminal.print()
            console.terminal.print(_bars(TITLES[title], both))


def _bars(title: str, both: Sequence[Histogram | None]) -> Table:
    """Shares of two histograms of the same bins, bin by bin."""
    known = [histogram for histogram in both if histogram is not None]
    edges = [f"{edge:.2f}" for edge in known[0].edges]
    bins = [f"below {edges[0]}", *(f"{low} to {high}" for low, high in pairwise(edges)), f"above {edges[-1]}"]
    shares = [None if h is None else [n / h.total for n in (h.below, *h.counts, h.above)] for h in both]
    largest = max(max(column) for column in shares if column is not None)
    length = min(BAR, max((console.terminal.width - BESIDE_BARS) // 2, 0))
    table = console.new_table()
    for column, side in ((title, "left"), ("A", "right"), ("", "left"), ("B", "right"), ("", "left")):
        table.add_column(column, justify="right" if side == "right" else "left", no_wrap=True)
    for k, name in enumerate(bins):
        cells = [(None if column is None else column[k]) for column in shares]
        if any(cells) or 0 < k < len(bins) - 1:
            table.add_row(name, *(text for share in cells for text in _bar(share, largest, length)))
    return table


def _bar(share: float | None, largest: float, length: int) -> tuple[str, str]:
    """A share in percent, and a bar in eighths of a character's width; that of the largest has the full length."""
    if share is None:
        return "-", ""
    full, part = divmod(round(8 * length * share / largest), 8)
    return f"{share:.1%}", EIGHTHS[-1] * full + EIGHTHS[part].strip()
