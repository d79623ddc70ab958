"""The rows of a batch's summary, as JSON and as CSV."""

import json
import traceback
from collections.abc import Mapping
from dataclasses import field, replace
from functools import cached_property, reduce
from operator import getitem
from typing import Any, Self

from bubblemesh.errors import OUT_OF_MEMORY, BubblemeshError, LimitError
from bubblemesh.files import outer_cause
from bubblemesh.meshfiles.text import csv_text, dumped, json_ready
from bubblemesh.messages import run_seconds
from bubblemesh.records import record

# Figures of reports that the summary has, and their names there.
FIGURES: Mapping[str, tuple[str, ...]] = {
    "method": ("method",),
    "seed": ("seed",),
    "nodes": ("nodes",),
    "triangles": ("triangles",),
    "ideal_nodes": ("ideal_nodes",),
    "quality_mean": ("quality", "mean"),
    "quality_p01": ("quality", "p01"),
    "quality_min": ("quality", "min"),
    "angle_min": ("quality", "angle_min"),
    "irregular_fraction": ("quality", "irregular_fraction"),
    "spacing_mean": ("spacing", "mean"),
    "spacing_std": ("spacing", "std"),
    "area_error": ("area_error",),
    "force_evaluations": ("force_evaluations",),
    "stop_reason": ("stop_reason",),
    "seconds": ("seconds", "total"),
    "peak_memory_mb": ("peak_memory_mb",),
}
# Types of the values in a line of JSON, in their order there.
COLUMN_KINDS: Mapping[str, Any] = {
    "case": str,
    "source": str,
    "sweep": dict,
    "exit_code": int,
    "error": str | None,
    **dict.fromkeys(FIGURES, int | float | None),  # not all meshes and systems have all of them
    **dict.fromkeys(("method", "stop_reason"), str),
    **dict.fromkeys(("seed", "nodes", "triangles", "force_evaluations"), int),
    **dict.fromkeys(("quality_mean", "quality_p01", "quality_min", "seconds"), int | float),
    "warnings": list,
    "attempts": int,
    "folder": str | None,
    "version": str,
    "inputs": str | None,
    "files": dict,
    "traceback": str | None,
}
COLUMNS = [name for name in COLUMN_KINDS if name not in ("inputs", "files", "traceback")]  # of the table


def figures_of(report: Mapping[str, Any]) -> dict[str, Any]:
    """The figures of a report that belong into a summary."""
    figures = {name: reduce(getitem, keys, report) for name, keys in FIGURES.items()}
    return figures | {"seconds": run_seconds(report["seconds"])}


@record
class Row:
    """Outcome of one case in figures; before it is meshed, only what is known then."""

    case: str  # its name
    source: str  # its file
    exit_code: int  # that ``bubblemesh run`` would have had
    sweep: Mapping[str, Any] = field(default_factory=dict)  # value of each key that its file sweeps
    error: str | None = None
    figures: Mapping[str, Any] = field(default_factory=dict)  # values of ``FIGURES``; empty if there is no mesh
    warnings: tuple[str, ...] = ()
    attempts: int = 0  # how often it was begun: more than once if worker processes died
    folder: str | None = None  # of its files, relative to the summary's; None if its case file could not be read
    version: str = ""
    inputs: str | None = None  # hash of everything that its results depend on
    files: Mapping[str, str] = field(default_factory=dict)  # SHA-256 hash of each of its files
    traceback: str | None = None  # if the error is one of the program

    @property
    def key(self) -> tuple[str | None, str]:
        """Folder and name, which no two cases of a batch share."""
        return self.folder, self.case

    def failed(self, exit_code: int, error: str) -> Self:
        """The row with an exit code and an error."""
        return replace(self, exit_code=exit_code, error=error)

    def ended_by(self, error: Exception) -> Self:
        """The row with the exception that has ended the case; with a traceback, if the error is one of the program."""
        match error:
            case BubblemeshError():
                return self.failed(error.exit_code, str(error))
            case MemoryError():
                return self.failed(LimitError.exit_code, f"{self.source}: {OUT_OF_MEMORY}")
        if outer := outer_cause(error):
            return self.failed(outer.exit_code, f"{self.source}: {outer}")
        problem = f"{self.source}: this is an error of bubblemesh, not of the case: {type(error).__name__}: {error}"
        trace = "".join(traceback.format_exception(error))
        return replace(self.failed(BubblemeshError.exit_code, problem), traceback=trace)

    @classmethod
    def parse(cls, line: bytes) -> Self | None:
        """Row of a line of JSON; None if the line is incomplete, or not one of a summary."""
        try:
            data = json.loads(line)
            figures = FIGURES if data["nodes"] is not None else ()
            values = {key: data[key] for key in COLUMN_KINDS if key in figures or key not in FIGURES}
        except (ValueError, KeyError, TypeError, RecursionError):
            return None
        if not all(isinstance(value, COLUMN_KINDS[key]) for key, value in values.items()):
            return None
        values["warnings"] = tuple(values["warnings"])
        return cls(figures={key: values.pop(key) for key in figures}, **values)

    def data(self) -> dict[str, Any]:
        """Values for the row's line of JSON."""
        return dict(self._values)

    @cached_property
    def _values(self) -> Mapping[str, Any]:
        values = {**vars(self), **dict.fromkeys(FIGURES), **self.figures}
        return dict(json_ready({key: values[key] for key in COLUMN_KINDS}))

    def line(self) -> str:
        """Line of JSON."""
        return dumped(self._values) + "\n"

    def cells(self) -> str:
        """Line of CSV: the sweep as JSON, errors in one line, warnings as their number."""
        data = self.data()
        data["sweep"] = dumped(data["sweep"])
        data["error"] = "; ".join((self.error or "").splitlines())
        data["warnings"] = len(self.warnings)
        return csv_text([[data[column] for column in COLUMNS]])
