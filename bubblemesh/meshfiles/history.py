"""The course of a run as CSV tables: one row for each round, one for each step."""

import csv
import io
from collections.abc import Iterable, Sequence
from typing import Any

from bubblemesh.arrays import Floats

HISTORY_FILES = (".rounds.csv", ".history.csv")


def history_tables(rounds: Sequence[dict[str, Any]], speeds: Sequence[Floats]) -> dict[str, str]:
    """Text of each table by the end of its file's name.

    Parameters
    ----------
    rounds : sequence of dict
        Figures of each round, all with the same keys; they become the columns.
    speeds : sequence of (iterations,)
        Mean speed of the bubbles after each step of each round.
    """
    per_round = _table(rounds[0].keys(), (row.values() for row in rounds))
    steps = ((number, speed) for number, course in enumerate(speeds, start=1) for speed in course.tolist())
    per_step = _table(
        ["step", "round", "mean_speed"], ([step, number, speed] for step, (number, speed) in enumerate(steps, start=1))
    )
    return dict(zip(HISTORY_FILES, (per_round, per_step), strict=True))


def _table(head: Iterable[str], rows: Iterable[Iterable[Any]]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)
    return text.getvalue()
