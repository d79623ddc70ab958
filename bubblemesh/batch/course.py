"""The course of a batch: cases go to the workers, files and rows come back."""

from collections.abc import Callable, Generator, Iterable
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path

from bubblemesh.batch.delivering import delivered
from bubblemesh.batch.dispatch import Ended, dispatched
from bubblemesh.batch.events import Begun, Event, Finished
from bubblemesh.batch.index import indexed, require_no_index
from bubblemesh.batch.locking import reserved
from bubblemesh.batch.plan import Entry, Settings
from bubblemesh.batch.resuming import key_of, of_others, unchanged
from bubblemesh.batch.rows import Row
from bubblemesh.batch.shards import WHOLE, Shard
from bubblemesh.batch.staging import Staging
from bubblemesh.batch.summary import recorded, summary
from bubblemesh.batch.workers import Workers


def course(
    entries: Iterable[Entry],
    settings: Settings,
    workers: Callable[[int], AbstractContextManager[Workers]],
    *,
    shard: Shard = WHOLE,
    resume: bool = False,
) -> Generator[Event, None, None]:
    """Mesh all cases, and tell of each as it ends.

    Parameters
    ----------
    entries : iterable of Entry
    settings : Settings
    workers : callable
        Gives the workers for a number of cases; not called if nothing is left to do.
    shard : Shard
        Part of the entries to mesh.
    resume : bool
        Whether cases that an earlier batch has done stay as they are, and its summary goes on.

    Raises
    ------
    CaseError
        If the page of a case would be that of the batch.
    FileError
        If the summary cannot be written, or the workers are out of reach; all rows until then are there.
    """
    everything = list(entries)
    own = tuple(shard.of(everything))
    root = Path(settings.folder or ".")
    if settings.page:
        require_no_index(everything, root, shard)
    with reserved(root, shard):
        done = unchanged(own, recorded(root), settings, root) if resume else {}
        kept = [*of_others(own, recorded(root, shard.suffix), root), *done.values()] if resume else []
        left = [entry for entry in own if entry.number not in done]
        # Only who has workers begins a summary: an old one is not given up for nothing.
        crews = workers(len(left)) if left else nullcontext()
        staging = Staging(root, shard)
        with (
            staging.tidied(own),
            crews as crew,
            summary(root, shard.suffix, kept) as rows,
            indexed(lambda: _in_order(rows.rows, own, root), root, shard) if settings.page else nullcontext(),
        ):
            yield Begun(own, len(done), rows.path)
            yield from (Finished(number, row, unchanged=True) for number, row in done.items())
            for event in dispatched(left, settings, crew) if crew else ():
                if isinstance(event, Ended):
                    row = delivered(event, staging)
                    rows.append(row)
                    yield Finished(event.entry.number, row)
                else:
                    yield event


def _in_order(rows: Iterable[Row], own: Iterable[Entry], root: Path) -> list[Row]:
    """The rows in the order of the cases, after those of cases outside the batch."""
    numbers = {key_of(entry, root): entry.number for entry in own}
    return sorted(rows, key=lambda row: (numbers.get(row.key, 0), row.source, row.case))
