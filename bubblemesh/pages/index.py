"""The page that compares the cases of a batch."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any
from urllib.parse import quote

from bubblemesh.errors import DONE, INTERRUPTED, LimitError, outcome
from bubblemesh.messages import counted, duration
from bubblemesh.pages.charts import quality_range
from bubblemesh.pages.markup import Markup, from_template, html, page, tag, whole

# For each column of numbers its head, its key in the row of a case, and the format of the numbers.
COLUMNS = (
    ("Mean q", "quality_mean", ".4f"),
    ("1 % of q below", "quality_p01", ".3f"),
    ("Least q", "quality_min", ".3f"),
    ("Nodes", "nodes", ",d"),
    ("Triangles", "triangles", ",d"),
    ("Spread of l/d", "spacing_std", ".3f"),
    ("Time", "seconds", None),
    ("Warnings", "warnings", "d"),
)
STATES = {LimitError.exit_code: "stopped at a limit", INTERRUPTED: "interrupted"}

Row = Mapping[str, Any]


def index_page(rows: Sequence[Row]) -> str:
    """The page that compares cases: one file of HTML that needs nothing else.

    The keys of the row of a case are as follows; all but the first two may be missing or None, which leaves their cells
    empty.

    - ``case`` and ``exit_code``,
    - ``status``, and ``message`` or ``error``,
    - those of ``COLUMNS``; ``warnings`` is their number or their texts,
    - ``report``: path of the case's page, relative to this one,
    - ``sweep``: values by key.
    """
    lowest = min((row["quality_min"] for row in rows if row.get("quality_min") is not None), default=0.0)
    low = min(int(10 * lowest) / 10, 0.9)
    swept = list(dict.fromkeys(key for row in rows for key in row.get("sweep") or {}))
    body = from_template(
        "index.html",
        summary=_summary(rows),
        heads=_heads(swept, low),
        cases=html(*(_case(row, swept, low) for row in rows)),
    )
    return page(f"{counted(len(rows), 'case')} - bubblemesh", body, ["tables.js"], wide=True)


def _summary(rows: Sequence[Row]) -> str:
    outcomes = Counter(outcome(row["exit_code"]) for row in rows)
    parts = [f"{whole(outcomes.pop(outcome(DONE), 0))} {outcome(DONE)}"]
    parts += [f"{whole(count)} {name}" for name, count in sorted(outcomes.items(), reverse=True)]
    nodes = sum(row.get("nodes") or 0 for row in rows)
    seconds = sum(row.get("seconds") or 0.0 for row in rows)
    return f"{counted(len(rows), 'case')}: {', '.join(parts)}. {whole(nodes)} nodes in {duration(seconds)}."


def _heads(swept: Sequence[str], low: float) -> Markup:
    text = [("Case", "text"), ("Status", "text"), *((key, "text") for key in swept)]
    heads = [
        tag("th", tag("button", _in_lines(name), type="button"), scope="col", class_=kind, data_kind=kind)
        for name, kind in [*text, *((name, "number") for name, _, _ in COLUMNS)]
    ]
    scale = tag("th", f"q from {low:g} to 1", scope="col", class_="scale-head")
    return html(*heads[: len(text)], scale, *heads[len(text) :])


def _in_lines(name: str) -> Markup:
    """A name, such as a key of a case, which browsers may break after each of its dots."""
    first, *others = name.split(".")
    return html(first, *(part for other in others for part in (".", tag("wbr"), other)))


def _case(row: Row, swept: Sequence[str], low: float) -> Markup:
    """The row of a case, and below it a row with its message across all columns."""
    cells, message = _cells(row, swept, low), row.get("message") or row.get("error")
    rows = [tag("tr", *cells)]
    if message:
        rows.append(tag("tr", tag("td", tag("div", message), colspan=len(cells)), class_="message"))
    return tag("tbody", *rows, class_=None if row["exit_code"] == DONE else "failed")


def _cells(row: Row, swept: Sequence[str], low: float) -> list[Markup]:
    """Cells of the row of a case: its name and status, the values of its sweep, its figures."""
    report = row.get("report")
    name = tag("a", row["case"], href=f"./{quote(report)}") if report else row["case"]
    sweep = row.get("sweep") or {}
    figures = [row[key] for key in ("quality_min", "quality_p01", "quality_mean") if row.get(key) is not None]
    picture = quality_range(figures, low) if len(figures) == 3 else None
    return [
        tag("th", name, scope="row", class_="text", data_value=row["case"]),
        _status(row),
        *(_text(sweep.get(key)) for key in swept),
        tag("td", picture),
        *(_number(_warnings(row) if key == "warnings" else row.get(key), form) for _, key, form in COLUMNS),
    ]


def _warnings(row: Row) -> int | None:
    """The number of warnings; None for a case that has failed before there could be any."""
    warnings = row.get("warnings") or 0
    count = warnings if isinstance(warnings, int) else len(warnings)
    return None if count == 0 and row.get("nodes") is None else count


def _status(row: Row) -> Markup:
    code = row["exit_code"]
    word = outcome(code)
    status = row.get("status") or STATES.get(code, f"{word}, exit code {code}" if word == "failed" else word)
    message = row.get("message") or row.get("error")
    mark = tag("span", "✓ " if code == DONE else "✗ ", aria_hidden="true")
    head = tag("span", mark, status, class_=f"status {'ok' if code == DONE else 'failed'}")
    return tag("td", head, class_="text", data_value=f"{code:03d} {message or ''}")


def _text(value: Any) -> Markup:
    return tag("td", "" if value is None else str(value), class_="text", data_value="" if value is None else str(value))


def _number(value: Any, form: str | None) -> Markup:
    if value is None:
        return tag("td", data_value="")
    return tag("td", duration(value) if form is None else format(value, form), data_value=repr(value))
