"""A batch on the terminal: a bar for all and a line for each running case; plain lines elsewhere."""

from collections import Counter
from collections.abc import Iterable, Iterator
from time import monotonic

from rich.console import Group
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeElapsedColumn, TimeRemainingColumn
from rich.text import Text

from bubblemesh import console
from bubblemesh.batch import Begun, Event, Finished, Note, Waiting
from bubblemesh.batch.rows import Row
from bubblemesh.console.report import counted
from bubblemesh.errors import BubblemeshError, RequirementError, outcome

COLUMNS = (BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), "left", TimeRemainingColumn())
KINDS = (*map(outcome, (0, RequirementError.exit_code, BubblemeshError.exit_code)), "unchanged")


class BatchProgress(console.Display):
    """Shows the events of a batch."""

    def __init__(self, quiet: bool) -> None:
        self.begun: Begun | None = None
        self.names: dict[int, str] = {}
        self.running: dict[int, tuple[Note, float]] = {}
        self.over: set[int] = set()
        self.counts: Counter[str] = Counter()
        self.bar = Progress("cases", *COLUMNS, console=console.terminal)
        self.task = self.bar.add_task("", total=None)
        super().__init__(quiet, transient=True)

    def __exit__(self, *error: object) -> None:
        super().__exit__(*error)
        if self.begun is not None and not self.quiet:
            console.terminal.print(Text(self._totals(self.begun)))

    def shown(self, events: Iterable[Event]) -> Iterator[Event]:
        """The same events, each shown."""
        for event in events:
            self.show(event)
            yield event

    def show(self, event: Event) -> None:
        """Show one event."""
        match event:
            case Begun():
                self.begun = event
                self.names = {entry.number: entry.name for entry in event.entries}
                self.bar.update(self.task, total=len(event.entries))
            case Note():
                self._follow(event)
            case Waiting():
                console.warn([event.message])
            case Finished():
                self._finish(event)

    def _follow(self, note: Note) -> None:
        if note.number not in self.over:  # a note may be late
            _, since = self.running.get(note.number, (note, monotonic()))
            self.running[note.number] = note, since

    def _finish(self, event: Finished) -> None:
        row = event.row
        self.over.add(event.number)
        self.running.pop(event.number, None)
        self.bar.advance(self.task)
        self.counts["unchanged" if event.unchanged else outcome(row.exit_code)] += 1
        if row.error is not None:
            console.fail(f"{self._count} {_named(row)}")
        elif not self.quiet and self.live is None:
            console.terminal.print(Text(self._line(event)))
        if not event.unchanged:
            console.warn([f"{row.case}: {warning}" for warning in row.warnings])

    @property
    def _count(self) -> str:
        return f"[{len(self.over)}/{len(self.names)}]"

    def _line(self, event: Finished) -> str:
        figures = event.row.figures
        result = f"{figures['nodes']} nodes, q {figures['quality_mean']:.4f}, least {figures['quality_min']:.3f}"
        end = "unchanged" if event.unchanged else f"{figures['seconds']:.2f} s"
        return f"{self._count} {event.row.case}: {result}, {end}"

    def _totals(self, begun: Begun) -> str:
        total = len(begun.entries)
        left = total - len(self.over)
        parts = [f"{self.counts[kind]} {kind}" for kind in KINDS if self.counts[kind]]
        parts += [f"{left} left for --resume"] if left else []
        return f"{counted(total, 'case')}: {', '.join(parts) or 'nothing to do'}; summary in {begun.summary}"

    def picture(self) -> Group:
        """The running cases, the oldest first, above the bar."""
        table = console.new_table()
        table.add_column("case", overflow="ellipsis", no_wrap=True)
        for column in ("round", "nodes", "time"):
            table.add_column(column, justify="right", no_wrap=True)
        rows = list(self.running.values())
        for note, since in rows[: max(console.terminal.height - 4, 1)]:
            nodes = f"{note.nodes}" if note.round else ""
            table.add_row(self.names[note.number], f"{note.round}", nodes, f"{monotonic() - since:.0f} s")
        return Group(table, self.bar) if rows else Group(self.bar)


def _named(row: Row) -> str:
    """The error of a case, which begins with the file that it comes from; a sweep's cases share theirs."""
    return f"{row.case}: {row.error}" if row.sweep or not f"{row.error}".startswith(row.source) else f"{row.error}"
