"""What a batch tells while it runs."""

from dataclasses import dataclass
from pathlib import Path

from bubblemesh.batch.jobs import Note
from bubblemesh.batch.plan import Entry
from bubblemesh.batch.rows import Row


@dataclass(frozen=True)
class Begun:
    """The batch begins: all its cases, how many of them are done already, and the file of the summary."""

    entries: tuple[Entry, ...]
    unchanged: int
    summary: Path


@dataclass(frozen=True)
class Waiting:
    """There are no workers now, as ``message`` says."""

    message: str


@dataclass(frozen=True)
class Finished:
    """A case has its row; ``unchanged`` if an earlier batch had done it."""

    number: int
    row: Row
    unchanged: bool = False


Event = Begun | Note | Waiting | Finished
