"""The page that compares the cases of a batch."""

from collections.abc import Mapping, Sequence
from typing import Any
from urllib.parse import quote

from bubblemesh.output.html.charts import quality_range
from bubblemesh.output.html.markup import Markup, filled, joined, tag
from bubblemesh.output.html.numbers import counted, whole
from bubblemesh.output.html.page import page
from bubblemesh.wording import duration

__all__ = ["index_page"]

DONE, MISSED = 0, 4  # exit codes of cases that have a mesh
STATES = {DONE: "done", MISSED: "misses a requirement", 6: "stopped at a limit", 130: "interrupted"}

Row = Mapping[str, Any]


def index_page(rows: Sequence[Row]) -> str:
    """The page that compares cases: one file of HTML that needs nothing else.

    Parameters
    ----------
    rows : sequence of mapping
        For each case ``case`` and ``exit_code``, and where they are known ``status``, ``message`` (or ``error``),
        ``nodes``, ``triangles``, ``quality_mean``, ``quality_p01``, ``quality_min``, ``spacing_std``, ``seconds``,
        ``warnings`` (their number or the texts), ``report`` (name of the case's page, relative to this one) and
        ``sweep`` (values by key). What is missing or None leaves its cell empty.
    """
    lowest = min((row["quality_min"] for row in rows if row.get("quality_min") is not None), default=0.0)
    low = min(int(10 * lowest) / 10, 0.9)
    swept = list(dict.fromkeys(key for row in rows for key in row.get("sweep") or {}))
    body = filled(
        "index.html",
        summary=_summary(rows),
        heads=_heads(swept, low),
        rows=joined(*(_row(row, swept, low) for row in rows)),
    )
    return page(f"{counted(len(rows), 'case')} - bubblemesh", body, ["tables.js"], wide=True)


def _summary(rows: Sequence[Row]) -> str:
    missed = sum(row["exit_code"] == MISSED for row in rows)
    failed = sum(row["exit_code"] not in (DONE, MISSED) for row in rows)
    parts = [f"{whole(len(rows) - missed - failed)} done"]
    parts += [f"{whole(missed)} without the quality that they require"] if missed else []
    parts += [f"{whole(failed)} failed"] if failed else []
    nodes = sum(row.get("nodes") or 0 for row in rows)
    seconds = sum(row.get("seconds") or 0.0 for row in rows)
    return f"{counted(len(rows), 'case')}: {', '.join(parts)}. {whole(nodes)} nodes in {duration(seconds)}."


def _heads(swept: Sequence[str], low: float) -> Markup:
    text = [("Case", "text"), ("Status", "text"), *((key, "text") for key in swept)]
    numbers = ["Mean q", "1 % of q below", "Least q", "Nodes", "Triangles", "Spread of l/d", "Time", "Warnings"]
    heads = [
        tag("th", tag("button", name, type="button"), scope="col", class_=kind, data_kind=kind)
        for name, kind in [*text, *((name, "number") for name in numbers)]
    ]
    scale = tag("th", f"q from {low:g} to 1", scope="col")
    return joined(*heads[: len(text)], scale, *heads[len(text) :])


def _row(row: Row, swept: Sequence[str], low: float) -> Markup:
    code, report = row["exit_code"], row.get("report")
    name = tag("a", row["case"], href=f"./{quote(report)}") if report else row["case"]
    sweep = row.get("sweep") or {}
    figures = [row[key] for key in ("quality_min", "quality_p01", "quality_mean") if row.get(key) is not None]
    picture = quality_range(figures, low) if len(figures) == 3 else None
    warnings = row.get("warnings") or 0
    cells = [
        tag("th", name, scope="row", class_="text", data_value=row["case"]),
        _status(row, code),
        *(_text(sweep.get(key)) for key in swept),
        tag("td", picture),
        _number(row.get("quality_mean"), ".4f"),
        _number(row.get("quality_p01"), ".3f"),
        _number(row.get("quality_min"), ".3f"),
        _number(row.get("nodes"), ",d"),
        _number(row.get("triangles"), ",d"),
        _number(row.get("spacing_std"), ".3f"),
        _number(row.get("seconds"), None),
        _number(warnings if isinstance(warnings, int) else len(warnings), "d"),
    ]
    return tag("tr", *cells, class_=None if code == DONE else "failed")


def _status(row: Row, code: int) -> Markup:
    status = row.get("status") or STATES.get(code, f"failed, exit code {code}")
    message = row.get("message") or row.get("error")
    mark = tag("span", "✓ " if code == DONE else "✗ ", aria_hidden="true")
    head = tag("span", mark, status, class_=f"status {'ok' if code == DONE else 'failed'}")
    text = tag("div", message, class_="note") if message else None
    return tag("td", head, text, class_="wide", data_value=f"{code:03d} {message or ''}")


def _text(value: Any) -> Markup:
    return tag("td", "" if value is None else str(value), class_="text", data_value="" if value is None else str(value))


def _number(value: Any, form: str | None) -> Markup:
    if value is None:
        return tag("td", data_value="")
    return tag("td", duration(value) if form is None else format(value, form), data_value=repr(value))
