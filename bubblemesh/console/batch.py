"""A batch on the terminal: a bar for all and a line for each running case; plain lines elsewhere."""

from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from time import monotonic
from typing import Any

from rich.console import Group
from rich.progress import BarColumn, MofNCompleteColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.progress import Progress as Bar
from rich.text import Text

from bubblemesh import console
from bubblemesh.batch import BatchListener, Entry, Preview, Row
from bubblemesh.errors import DONE, BubblemeshError, RequirementError, outcome
from bubblemesh.messages import counted, duration

COLUMNS = (BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), "left", TimeRemainingColumn())
KINDS = (*map(outcome, (DONE, RequirementError.exit_code, BubblemeshError.exit_code)), "unchanged")


class BatchProgress(console.Display, BatchListener):
    """Shows how a batch goes on."""

    def __init__(self, quiet: bool, heed: Callable[[], None] = lambda: None) -> None:
        self.summary: Path | None = None
        self.names: dict[int, str] = {}
        self.running: dict[int, tuple[int, int, float]] = {}  # finished rounds, nodes, and when the case has begun
        self.over: set[int] = set()
        self.counts: Counter[str] = Counter()
        self.bar = Bar("cases", *COLUMNS, console=console.terminal)
        self.task = self.bar.add_task("", total=None)
        super().__init__(quiet, heed, transient=True)

    def __exit__(self, *error: object) -> None:
        super().__exit__(*error)
        if self.summary is not None and not self.quiet:
            console.terminal.print(Text(self._totals()))

    def begin(self, entries: list[Entry], summary: Path) -> None:
        self.summary = summary
        self.names = {entry.number: entry.row.case for entry in entries}
        self.bar.update(self.task, total=len(entries))

    def note(self, number: int, finished_rounds: int, nodes: int) -> None:
        if number not in self.over:  # a note may come after the end of its case
            *_, since = self.running.get(number, (monotonic(),))
            self.running[number] = finished_rounds, nodes, since

    def warn(self, message: str) -> None:
        console.warn([message])

    def finish(self, number: int, row: Row, *, unchanged: bool = False) -> None:
        """Count a case that has its row, and print its error, or its figures and warnings."""
        self.over.add(number)
        self.running.pop(number, None)
        self.bar.advance(self.task)
        # An unchanged case that missed a requirement counts as such again, as in the exit code.
        self.counts["unchanged" if unchanged and row.exit_code == DONE else outcome(row.exit_code)] += 1
        if row.error is not None:
            console.fail(f"{self._count} {_named(row)}")
        elif not self.quiet and self.live is None:
            figures = row.figures
            result = f"{figures['nodes']} nodes, q {figures['quality_mean']:.4f}, least {figures['quality_min']:.3f}"
            end = "unchanged" if unchanged else duration(figures["seconds"])
            console.terminal.print(Text(f"{self._count} {row.case}: {result}, {end}"))
        if not unchanged:
            console.warn([f"{row.case}: {warning}" for warning in row.warnings])
        self.heed()

    @property
    def _count(self) -> str:
        return f"[{len(self.over)}/{len(self.names)}]"

    def _totals(self) -> str:
        total = len(self.names)
        left = total - len(self.over)
        parts = [f"{self.counts[kind]} {kind}" for kind in KINDS if self.counts[kind]]
        parts += [f"{left} left for --resume"] if left else []
        return f"{counted(total, 'case')}: {', '.join(parts) or 'nothing to do'}; summary in {self.summary}"

    def picture(self) -> Group:
        """The running cases, the oldest first, above the bar."""
        table = console.new_table()
        table.add_column("case", overflow="ellipsis", no_wrap=True)
        for column in ("round", "nodes", "time"):
            table.add_column(column, justify="right", no_wrap=True)
        rows = list(self.running.items())
        for number, (finished_rounds, nodes, since) in rows[: max(console.terminal.height - 4, 1)]:
            shown = f"{nodes}" if finished_rounds else ""
            table.add_row(self.names[number], f"{finished_rounds}", shown, f"{monotonic() - since:.0f} s")
        return Group(table, self.bar) if rows else Group(self.bar)


def _named(row: Row) -> str:
    """Error of a case, which begins with the name of its file; all cases of a sweep have the same file."""
    return f"{row.case}: {row.error}" if row.sweep or not f"{row.error}".startswith(row.source) else f"{row.error}"


class PreviewLines:
    """Prints a line for each case of a batch that is only checked; equal errors are printed once."""

    def __init__(self, count: int, quiet: bool, to: console.Terminal) -> None:
        self.count = count
        self.quiet = quiet
        self.to = to
        self.told: Counter[str] = Counter()
        self.shown = 0

    def show(self, preview: Preview) -> None:
        """Print the next case."""
        self.shown += 1
        number = f"[{self.shown}/{self.count}]"
        row, figures = preview.row, preview.figures
        if figures is None:
            self.told[f"{row.error}"] += 1
            if self.told[f"{row.error}"] == 1:
                console.fail(f"{number} {_named(row)}")
            return
        if not self.quiet:
            spacing = figures["spacing"]
            sizes = f"spacing {spacing['minimum']:.4g} to {spacing['maximum']:.4g}"
            self.to.print(Text(f"{number} {row.case}: about {figures['expected_nodes']:,.0f} nodes, {sizes}"))
        for warning in figures["warnings"]:
            self.told[warning] += 1
            if self.told[warning] == 1:
                console.warn([f"{row.case}: {warning}"])

    def end(self, totals: Mapping[str, Any]) -> None:
        """Print the sums of all cases."""
        repeated = sum(self.told.values()) - len(self.told)
        if self.quiet:
            return
        fine = totals["cases"] - totals["failed"]
        parts = [f"{fine} can be meshed, with about {totals['expected_nodes']:,.0f} nodes in all"] if fine else []
        parts += [f"{totals['failed']} failed"] if totals["failed"] else []
        parts += [f"{counted(repeated, 'message')} like those above left out"] if repeated else []
        self.to.print(Text(f"{counted(totals['cases'], 'case')}: {', '.join(parts)}"))
