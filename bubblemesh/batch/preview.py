"""Preview of a batch: each case of a plan is checked and its nodes are estimated; nothing is written."""

from collections.abc import Mapping, Sequence
from typing import Any

from bubblemesh.batch.plan import Entry
from bubblemesh.batch.row import Row
from bubblemesh.errors import DONE
from bubblemesh.meshfiles.text import json_ready
from bubblemesh.records import record
from bubblemesh.run.preview import preview


@record
class Preview:
    """A case before it is meshed: its estimate, or a row with the error; and the files that it would write."""

    row: Row
    figures: Mapping[str, Any] | None  # None if the case has a fault
    files: Sequence[str]

    def data(self) -> dict[str, Any]:
        """Values for a program to read."""
        row = self.row
        own = {"case": row.case, "source": row.source, "sweep": row.sweep, "folder": row.folder, "files": self.files}
        return dict(json_ready({**(self.figures or {}), **own, "exit_code": row.exit_code, "error": row.error}))


def preview_of(entry: Entry) -> Preview:
    """Preview of an entry; any error is part of it, so that the other cases are still looked at."""
    case = entry.case
    if case is None:
        return Preview(entry.row, None, ())

    try:
        figures = preview(case, entry.row.source)
    except Exception as error:
        return Preview(entry.row.ended_by(error), None, entry.names)
    return Preview(entry.row, figures, entry.names)


def totals_of(previews: Sequence[Preview]) -> dict[str, Any]:
    """Counts and values of all previews; the exit code is the largest of theirs, or 0."""
    codes = [preview.row.exit_code for preview in previews]
    nodes = sum(preview.figures["expected_nodes"] for preview in previews if preview.figures is not None)
    return {
        "cases": len(previews),
        "failed": sum(code != DONE for code in codes),
        "expected_nodes": nodes,
        "exit_code": max(codes, default=DONE),
        "rows": [preview.data() for preview in previews],
    }
