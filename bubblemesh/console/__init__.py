"""What the user sees on the terminal; all of it goes to the error stream, which leaves the output to data."""

from collections.abc import Mapping, Sequence
from time import monotonic
from types import TracebackType
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.live import Live
from rich.spinner import Spinner
from rich.table import Table
from rich.text import Text

if TYPE_CHECKING:  # an error must be shown even where NumPy cannot be loaded
    from bubblemesh.problem import Problem
    from bubblemesh.spacing.survey import Extremes, Survey
    from bubblemesh.summary import RoundRow

__all__ = ["Progress", "show_files", "show_problem", "show_quality", "warn"]

COLUMNS = ("round", "nodes", "deleted", "inserted", "mean q", "least q", "mean speed", "time")
WIDTHS = (5, 8, 8, 8, 7, 7, 10, 8)
REDRAWN, RETOLD = 0.2, 10.0  # seconds between two estimates, on a terminal and elsewhere
ROUNDING = 1e-9  # of a domain's size

terminal = Console(stderr=True, highlight=False, soft_wrap=True)


def duration(seconds: float) -> str:
    """A time in words that do not pretend to be exact."""
    if seconds < 100:
        return f"{seconds:.0f} s"
    if seconds < 6000:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"


class Progress:
    """Shows each round as it ends, and how far the packing is: a growing table on a terminal, plain lines elsewhere."""

    def __init__(self, title: str, quiet: bool) -> None:
        self.quiet = quiet
        self.rows: list[tuple[str, ...]] = []
        self.title = title
        self.begun = self.told = monotonic()
        self.spinner = Spinner("dots", Text(f" {title}"))
        self.live = Live(console=terminal, refresh_per_second=8, transient=False) if self.is_live else None

    @property
    def is_live(self) -> bool:
        """Whether there is a terminal to redraw."""
        return terminal.is_terminal and not self.quiet

    def __enter__(self) -> "Progress":
        if self.live is not None:
            self.live.start()
            self.live.update(self.spinner)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.live is not None:
            self.live.update(self._table() if self.rows else Text())
            self.live.stop()

    def show(self, row: "RoundRow") -> None:
        """Add a finished round."""
        cells = (
            f"{row.round}",
            f"{row.nodes_after}",
            f"{row.deleted}",
            f"{row.inserted}",
            f"{row.quality_mean:.4f}",
            f"{row.quality_min:.3f}",
            f"{row.mean_speed:.2e}",
            f"{row.seconds:.2f} s",
        )
        self.rows.append(cells)
        if self.live is not None:
            table = self._table()
            table.add_row(self.spinner)
            self.live.update(table)
        elif not self.quiet:
            if len(self.rows) == 1:
                _line(COLUMNS)
            _line(cells)

    def advance(self, share: float) -> None:
        """Tell what share of the packing is done, and about how long the rest takes."""
        now = monotonic()
        if share <= 0 or self.quiet or now - self.told < (REDRAWN if self.live is not None else RETOLD):
            return
        self.told = now
        left = (now - self.begun) * (1 - share) / share
        text = f"{self.title}: {share:.0%}, about {duration(left)} left"
        if self.live is not None:
            self.spinner.update(text=Text(f" {text}"))
        else:
            terminal.print(Text(text))

    def _table(self) -> Table:
        table = Table(box=None, header_style="bold", pad_edge=False)
        for column in COLUMNS:
            table.add_column(column, justify="right", no_wrap=True)
        for cells in self.rows:
            table.add_row(*cells)
        return table


def show_problem(problem: "Problem") -> None:
    """What a case asks for, before any packing."""
    domain, survey = problem.domain, problem.survey
    x0, y0, x1, y1 = domain.bounds
    rows = {
        "domain": f"[{x0:.6g}, {x1:.6g}] x [{y0:.6g}, {y1:.6g}], area {domain.polygon.area:.6g}, "
        f"{_counted(domain.hole_count, 'hole')}",
        "labels": ", ".join(domain.boundary.labels),
        "spacing": _extremes(survey, domain.size),
        **_rules(problem),
        **({"packed": _extremes(problem.packed, domain.size)} if problem.refined else {}),
        "nodes": f"about {problem.expected_nodes:.0f}" + _scale(problem),
        "method": problem.task.method_name,
    }
    _show(rows)


def _extremes(found: "Survey | Extremes", size: float) -> str:
    least, largest = _place(found.minimum_at, size), _place(found.maximum_at, size)
    return f"{found.minimum:.4g} at {least} to {found.maximum:.4g} at {largest}"


def _rules(problem: "Problem") -> dict[str, str]:
    """What the rules of the spacing and its periodic sides changed."""
    rows = {}
    for name, changed in problem.changes.items():
        than = "the terms" if name == "rules" else "one side alone"
        where = "" if changed.ratio_at is None else f" at {_place(changed.ratio_at, problem.domain.size)}"
        area = f"finer than {than} on {changed.share:.1%} of the area"
        rows[name] = f"{area}, at most {changed.ratio:.3g} times{where}"
    return rows


def _scale(problem: "Problem") -> str:
    return "" if problem.budget is None else f", with the spacing times {problem.budget.scale:.4g}"


def show_quality(figures: Mapping[str, Any]) -> None:
    """The quality of a mesh; ``figures`` are those of a report, with or without spacing and time."""
    quality = figures["quality"]
    ideal = figures.get("ideal_nodes")
    rows = {
        "nodes": f"{figures['nodes']}" + (f", {figures['nodes'] / ideal:.3f} of the ideal number" if ideal else ""),
        "triangles": f"{figures['triangles']}, area {figures['area']:.9g}",
        "quality q": f"mean {quality['mean']:.4f}, 1 % below {quality['p01']:.3f}, least {quality['min']:.3f}",
        "angles": f"{quality['angle_min']:.1f} to {quality['angle_max']:.1f} degrees",
        "worst q": ", ".join(f"{worst['quality']:.3f} at {_place(worst['at'])}" for worst in quality["worst"][:3]),
    }
    if quality["irregular_fraction"] is not None:
        rows["irregular"] = f"{quality['irregular_fraction']:.1%} of the inner nodes have not six neighbours"
    if "spacing" in figures:
        spacing = figures["spacing"]
        rows["edges l/d"] = f"{spacing['mean']:.3f} ± {spacing['std']:.3f}, 98 % in " + (
            f"[{spacing['p01']:.2f}, {spacing['p99']:.2f}]"
        )
    if "adaptation" in figures:
        rows |= _adaptation(figures["adaptation"])
    if "budget" in figures:
        budget = figures["budget"]
        meshes = _counted(len(budget["attempts"]), "attempt")
        rows["budget"] = f"{budget['nodes']} nodes, met by the spacing times {budget['scale']:.4g}, in {meshes}"
    if "stop_reason" in figures:
        rows["stopped"] = f"{figures['stop_reason']}"
        rows["time"] = f"{figures['seconds']['total']:.2f} s"
    _show(rows)


def _adaptation(figures: Mapping[str, Any]) -> dict[str, str]:
    """What is known of the error of a solution, before and after."""
    true = ""
    if figures.get("effectivity") is not None:
        true = f", {figures['effectivity']:.3f} times the true one of {figures['true_error']:.4g}"
    kept = f"{figures['unchanged']:.0%} of the nodes are where sizes stay"
    start = "they are the start" if figures["start"] == "present nodes" else "the start is a new one"
    return {
        "solution": f"{figures['field']} on {figures['nodes_before']} nodes, estimated error {figures['error']:.4g}, "
        f"{figures['relative_error']:.2%}{true}",
        "adapted": f"to an expected error of {figures['expected_relative_error']:.2%}; {kept}: {start}",
    }


def show_files(folder: str, files: Sequence[str]) -> None:
    """The files that were written."""
    _show({"files": ", ".join(files) + ("" if folder in (".", "") else f" in {folder}")})


def warn(messages: Sequence[str]) -> None:
    """Compromises that the user should know of."""
    for message in messages:
        terminal.print(Text.assemble(("warning: ", "yellow"), message))


def fail(message: str) -> None:
    """Why the command ends without what it was asked for."""
    terminal.print(Text.assemble(("error: ", "bold red"), message))


def _show(rows: Mapping[str, str]) -> None:
    for name, value in rows.items():
        terminal.print(Text.assemble((f"{name:11}", "bold"), value))


def _line(cells: Sequence[str]) -> None:
    terminal.print(Text(" ".join(f"{cell:>{width}}" for cell, width in zip(cells, WIDTHS, strict=True))))


def _place(point: Sequence[float], size: float = 0.0) -> str:
    """A point; what is nothing but rounding in a domain of some size is zero."""
    x, y = (0.0 if abs(value) < ROUNDING * size else value for value in point)
    return f"({x:.4g}, {y:.4g})"


def _counted(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number or 'no'} {noun}s"
