"""A packing on the terminal: a table with a line for each round, and its progress; plain lines elsewhere."""

from collections.abc import Callable
from math import inf
from time import monotonic
from typing import TYPE_CHECKING

from rich.console import Group
from rich.spinner import Spinner
from rich.table import Table
from rich.text import Text

from bubblemesh import console
from bubblemesh.messages import duration, shown

if TYPE_CHECKING:
    from bubblemesh.run.report import RoundRow


COLUMNS = {  # width, and how a round fills it
    "round": (5, "{0.round}"),
    "nodes": (8, "{0.nodes_after}"),
    "deleted": (8, "{0.deleted}"),
    "inserted": (8, "{0.inserted}"),
    "mean q": (7, "{0.quality_mean:.4f}"),
    "least q": (7, "{0.quality_min:.3f}"),
    "mean speed": (10, "{0.mean_speed:.2e}"),
    "time": (8, "{0.seconds:.2f} s"),
}
DISPENSABLE = ("mean speed", "inserted", "deleted")  # left out, in this order, if the terminal is narrow
REDRAWN, RETOLD = 0.2, 10.0  # seconds between two estimates, on a terminal and elsewhere
TOLD_FROM = 0.02  # share of the packing after which its speed is known well enough


class PackingProgress(console.Display):
    """Shows each round as it ends, the share of the packing that is done, and an estimate of the time left."""

    def __init__(self, title: str, quiet: bool, heed: Callable[[], None] = lambda: None) -> None:
        self.rows: list[tuple[str, ...]] = []
        self.title = title
        self.told = monotonic()
        self.first = self.told, inf  # time and share when the packing began
        self.spinner = Spinner("dots", Text(title))
        super().__init__(quiet, heed, refresh_per_second=8)

    def show(self, row: "RoundRow") -> None:
        """Add a finished round."""
        cells = tuple(text.format(row) for _, text in COLUMNS.values())
        self.rows.append(cells)
        if self.live is None and not self.quiet:
            for line in [tuple(COLUMNS), cells] if len(self.rows) == 1 else [cells]:
                padded = (f"{cell:>{width}}" for cell, (width, _) in zip(line, COLUMNS.values(), strict=True))
                console.terminal.print(Text(" ".join(padded)))

    def advance(self, share: float) -> None:
        """Show what share of the packing is done, and an estimate of the time left."""
        self.heed()
        now = monotonic()
        if share <= self.first[1]:  # it begins, or begins anew: the time before was not spent on packing
            self.first = now, share
        if self.quiet or now - self.told < (REDRAWN if self.live is not None else RETOLD):
            return
        self.told = now
        rest = f"{share:.0%}{self._time_left(now, share)}"
        if self.live is None:
            console.terminal.print(Text(f"{self.title}: {rest}"))
            return
        room = max(console.terminal.width - len(rest) - len("* : "), 8)
        self.spinner.update(text=Text(f"{shown(self.title, room)}: {rest}"))

    def _time_left(self, now: float, share: float) -> str:
        begun, before = self.first
        if share - before < TOLD_FROM:
            return ""
        left = (now - begun) * (1 - share) / (share - before)
        return f", about {duration(max(float(f'{left:.2g}'), 1))} left"

    def picture(self) -> Group:
        """The latest rounds above a line with the progress; at the end all rounds."""
        most = len(self.rows) if self.ended else max(console.terminal.height - 3, 1)
        parts = [self._table(most)] if self.rows else []
        return Group(*parts) if self.ended else Group(*parts, self.spinner)

    def _table(self, most: int) -> Table:
        names = _fitting(console.terminal.width)
        table = console.new_table(padding=(0, 1, 0, 0))
        for name in names:
            table.add_column(name, justify="right", no_wrap=True, min_width=COLUMNS[name][0])
        for cells in self.rows[-most:]:
            table.add_row(*(cell for name, cell in zip(COLUMNS, cells, strict=True) if name in names))
        return table


def _fitting(width: int) -> list[str]:
    """The columns for which a terminal of this width has room."""
    names = list(COLUMNS)
    for name in DISPENSABLE:
        if sum(COLUMNS[kept][0] + 1 for kept in names) - 1 > width:
            names.remove(name)
    return names
