"""Tables in Markdown, and how figures are written in them."""

from collections.abc import Iterable, Sequence
from statistics import median


def markdown(title: str, text: str, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A section with a table."""
    lines = [_line(columns), "|" + "---|" * len(columns), *map(_line, rows)]
    return "\n".join([f"## {title}\n", *([f"{text}\n"] if text else []), *lines]) + "\n"


def spread(values: Sequence[float], digits: int = 0) -> str:
    """The median, with the range of all values if they differ."""
    middle, least, most = (f"{value:.{digits}f}" for value in (median(values), min(values), max(values)))
    return middle if least == most else f"{middle} ({least} to {most})"


def printed(value: float | None) -> str:
    """What the paper prints, if anything."""
    return "" if value is None else f"{value}"


def ratio(value: float | None, reference: float | None) -> str:
    """A cost in units of another."""
    return "" if value is None or reference is None else f"{value / reference:.2f}"


def percent(share: float | None) -> str:
    """A share, if known."""
    return "" if share is None else f"{100 * share:.0f} %"


def _line(cells: Iterable[object]) -> str:
    return "| " + " | ".join(map(str, cells)) + " |"
