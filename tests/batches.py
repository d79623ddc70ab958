"""Batches of small cases, in threads of the test's own process or as the command."""

import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from queue import SimpleQueue

from bubblemesh.batch import Finished, Settings, case_files, course, planned
from bubblemesh.batch.jobs import Outcome
from bubblemesh.batch.workers import Workers

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
schedule: {rounds: 1000000, tolerance: 0, iterations: 1000}
output: {formats: [msh]}
"""


def unexpected(error):
    """Workers of a test fail in no other way than the test says."""
    return Outcome(99, repr(error))


@contextmanager
def threads(count):
    """Workers that are threads."""
    notes = SimpleQueue()
    with ThreadPoolExecutor(min(count, 2)) as executor:
        yield Workers(executor, notes.put, notes, lambda: 4, unexpected, "lost")


def stream(*paths, workers=threads, shard=None, resume=False, **settings):
    """The events of a batch, as they happen."""
    common = Settings(**settings)
    entries = planned(case_files([str(path) for path in paths]), common)
    options = {} if shard is None else {"shard": shard}
    return course(entries, common, workers, resume=resume, **options)


def events_of(*paths, **options):
    """All events of a batch."""
    return list(stream(*paths, **options))


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
