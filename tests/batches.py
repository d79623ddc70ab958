"""Batches of small cases, in threads of the test's own process or as the command."""

import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from bubblemesh.batch import BatchListener, BatchOptions, Row, case_files, plan_cases, run_batch
from bubblemesh.workers.workers import Workers

SMALL = """\
domain: {outer: {rectangle: [0, 0, 1, 1], label: wall}}
spacing: 0.4
method: accelerated
schedule: {rounds: 1, iterations: 5}
output: {formats: [msh]}
"""
BAD = "domain: {outer: {rectangle: [0, 0, 1, 0]}}\nspacing: 0.4\n"
# Seconds of work, however fast the machine: enough to be caught in the middle of.
LONG = """\
domain: {outer: {rectangle: [0, 0, 1, 1]}}
spacing: 0.015
method: accelerated
schedule: {rounds: 10000, tolerance: 0, iterations: 1000}
output: {formats: [msh]}
"""


class Threads(Workers):
    """Workers that are threads of an executor."""

    lost = "out of reach"

    def __init__(self, executor, capacity=4):
        super().__init__()
        self.executor, self.most, self.tell = executor, capacity, self.notes.put

    def submit(self, function, /, *arguments):
        return self.executor.submit(function, *arguments)

    def capacity(self):
        return self.most

    def failure(self, error):
        """Workers of a test fail in no other way than the test says."""
        return 99, repr(error)


@contextmanager
def threads(count):
    """Workers that are threads."""
    with ThreadPoolExecutor(min(count, 2)) as executor:
        yield Threads(executor)


class Begun(NamedTuple):
    """A batch has begun."""

    entries: list
    summary: Path


class Note(NamedTuple):
    """A case is so far."""

    number: int
    round: int = 0
    nodes: int = 0


class Warned(NamedTuple):
    """There are no workers, or one is left out."""

    message: str


class Finished(NamedTuple):
    """A case has its row."""

    number: int
    row: Row
    unchanged: bool = False


class Events(BatchListener):
    """Gives all that a batch tells to a function, one event after the other."""

    def __init__(self, hear):
        self.hear = hear

    def begin(self, entries, summary):
        self.hear(Begun(entries, summary))

    def note(self, number, finished_rounds, nodes):
        self.hear(Note(number, finished_rounds, nodes))

    def warn(self, message):
        self.hear(Warned(message))

    def finish(self, number, row, *, unchanged=False):
        self.hear(Finished(number, row, unchanged))


def follow(hear, *paths, workers=threads, **options):
    """Run a batch whose events go to a function as they happen; gives what the batch ends with."""
    common = BatchOptions(**options)
    entries = plan_cases(case_files([str(path) for path in paths]), common)
    return run_batch(entries, common, workers, Events(hear))


def events_of(*paths, **options):
    """All events of a batch."""
    events = []
    follow(events.append, *paths, **options)
    return events


def finished(*paths, **options):
    """The ends of all cases of a batch, in the order of the cases."""
    events = [event for event in events_of(*paths, **options) if isinstance(event, Finished)]
    return sorted(events, key=lambda event: event.number)


def rows_of(*paths, **options):
    """The rows of all cases of a batch, in the order of the cases."""
    return [event.row for event in finished(*paths, **options)]


def lines_of(path):
    """What the lines of a summary hold, every one of which has to be whole."""
    content = path.read_bytes()
    assert content.endswith(b"\n") or not content
    return [json.loads(line) for line in content.splitlines()]


def results_in(folder):
    """Bytes of all files but the summary's, and of reports only what does not change from run to run."""
    return {str(path.relative_to(folder)): _lasting(path) for path in sorted(folder.rglob("*")) if _counts(path)}


def _counts(path):
    return path.is_file() and not path.name.startswith("summary")


def _lasting(path):
    if not path.name.endswith(".report.json"):
        return path.read_bytes()
    report = json.loads(path.read_text())
    for row in report["rounds"]:
        del row["seconds"]
    return {key: value for key, value in report.items() if key not in ("seconds", "peak_memory_mb")}


def command(*arguments):
    """The batch command with these arguments."""
    return [sys.executable, "-m", "bubblemesh", "batch", *map(str, arguments)]


def batch(*arguments, folder, **options):
    """Run the batch command in ``folder`` and return the finished process, its streams as text."""
    environment = {**os.environ, "COLUMNS": "200"}
    return subprocess.run(
        command(*arguments), cwd=folder, capture_output=True, text=True, env=environment, timeout=120, **options
    )
