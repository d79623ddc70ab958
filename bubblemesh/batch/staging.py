"""Folders in which the files of a case wait until all of them are there."""

import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from bubblemesh.batch.plan import Entry
from bubblemesh.batch.shards import Shard


@dataclass(frozen=True)
class Staging:
    """The staging folders of a batch, whose summary is in ``root``.

    Batches with different summaries may write into one folder at the same time. So the names tell the summary, which
    one batch at a time has: what an earlier one has left there is of no use to anybody.
    """

    root: Path
    shard: Shard

    def prefix(self, folder: Path) -> str:
        """How the names of staging folders in a folder of results begin."""
        try:
            way = os.path.relpath(os.path.realpath(self.root), os.path.realpath(folder))
        except ValueError:  # another drive of Windows
            way = os.path.realpath(self.root)
        return f".bubblemesh-batch-{sha256(os.fsencode(way)).hexdigest()[:12]}{self.shard.suffix}-"

    @contextmanager
    def tidied(self, entries: Iterable[Entry]) -> Iterator[None]:
        """Remove what a killed batch has left, and at the end what an interrupt leaves."""
        places = [entry.place for entry in entries if entry.place is not None]
        folders = {place.folder for place in places if place.folder is not None}
        self._remove(folders)
        try:
            yield
        finally:
            self._remove(folders)

    def _remove(self, folders: Iterable[Path]) -> None:
        for folder in folders:
            for leftover in folder.glob(f"{self.prefix(folder)}*"):
                shutil.rmtree(leftover, ignore_errors=True)
