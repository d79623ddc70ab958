"""Cases of batches for the tests."""

import csv
from concurrent.futures import CancelledError, Executor, Future
from contextlib import contextmanager
from pathlib import Path
from queue import SimpleQueue

from batches import (
    threads,
    unexpected,
)

from bubblemesh.batch.workers import Workers


def write(folder, **texts):
    """Write case files by their stems; a stem may have folders, as in a__b."""
    for stem, text in texts.items():
        path = folder / (stem.replace("__", "/") + ".yaml")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def names(folder):
    return sorted(path.name for path in Path(folder).iterdir())


def table_in(folder):
    """The rows of a summary as CSV, each in one line."""
    lines = (folder / "summary.csv").read_text().splitlines()
    return list(csv.DictReader(lines))


def between(change):
    """Workers that make a change when the first case has been submitted."""

    @contextmanager
    def workers(count):
        with threads(count) as crew:

            def capacity():
                return 1

            submit = crew.executor.submit

            def submitted(*arguments):
                change()
                return submit(*arguments)

            crew.executor.submit = submitted
            yield Workers(crew.executor, crew.tell, crew.notes, capacity, crew.failure, crew.lost)

    return workers


class Failing(Executor):
    """Runs what it is given, but fails first: so many times, in this way, over the case of this name."""

    def __init__(self, times, error, name):
        self.left, self.error, self.name = times, error, name

    def submit(self, function, /, job, tell):
        future = Future()
        if job.place.name == self.name and self.left:
            self.left -= 1
            if self.error is CancelledError:
                future.cancel()
                future.set_running_or_notify_cancel()
            else:
                future.set_exception(self.error)
        else:
            future.set_result(function(job, tell))
        return future


def failing(times, error, failure=unexpected):
    @contextmanager
    def workers(count):
        notes = SimpleQueue()
        yield Workers(Failing(times, error, "b"), notes.put, notes, lambda: 2, failure, "out of reach")

    return workers
