"""Cases of batches for the tests."""

import csv
from concurrent.futures import CancelledError, Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager, nullcontext
from pathlib import Path

from batches import Threads


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
    """Workers for one case at a time that make a change when the first case has been submitted."""

    class Changing(Threads):
        def submit(self, function, /, *arguments):
            change()
            return super().submit(function, *arguments)

    @contextmanager
    def workers(count):
        with ThreadPoolExecutor(1) as executor:
            yield Changing(executor, capacity=1)

    return workers


class Failing(Executor):
    """Runs what it is given, but fails first: so many times, in this way, over the case of this name."""

    def __init__(self, times, error, name):
        self.left, self.error, self.name = times, error, name

    def submit(self, function, /, job, tell):
        future = Future()
        if job.destination.name == self.name and self.left:
            self.left -= 1
            if self.error is CancelledError:
                future.cancel()
                future.set_running_or_notify_cancel()
            else:
                future.set_exception(self.error)
        else:
            future.set_result(function(job, tell))
        return future


def failing(times, error):
    """Workers that fail so many times over the case b."""
    return lambda count: nullcontext(Threads(Failing(times, error, "b"), capacity=2))
