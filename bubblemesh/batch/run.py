"""The run of a batch: cases go to the workers, files and rows come back."""

from collections.abc import Sequence
from contextlib import closing, nullcontext
from itertools import chain
from typing import Any

from bubblemesh.batch.dispatch import BatchListener, dispatch
from bubblemesh.batch.folders import place_files, reserved, tidied
from bubblemesh.batch.plan import BatchOptions, Entry
from bubblemesh.batch.resume import OldSummary, recorded, replaced, rows_of_others, summaries_in, unchanged
from bubblemesh.batch.summary import Summary, indexed, require_no_index, totals
from bubblemesh.messages import counted
from bubblemesh.workers.hire import Hire


def run_batch(entries: Sequence[Entry], options: BatchOptions, hire: Hire, listener: BatchListener) -> dict[str, Any]:
    """Mesh all cases of a plan, or of its shard, and return the rows in their order with their `totals`.

    Workers are started only if a case is left to do.

    Raises
    ------
    CaseError
        If the page of a case would replace that of the batch.
    FileError
        If the summary cannot be written, a disk is full or the workers are out of reach; the summary then has all rows
        until that moment.
    """
    root, own = options.root, options.part_of(entries)
    require_no_index(entries, options)
    with reserved(options):
        known = recorded(summaries_in(root) if options.resume else [options.summary])
        old = known.get(options.summary, OldSummary())
        rows_before = chain.from_iterable(summary.rows for summary in known.values())
        done = unchanged(own, rows_before, root) if options.resume else {}
        staying = [*(rows_of_others(own, old.rows) if options.resume else ()), *done.values()]
        left = [entry for entry in own if entry.number not in done]
        with (
            tidied(own, options),
            # The summary begins when there are workers: until then an old one stays.
            hire(len(left)) if left else nullcontext() as workers,
            closing(Summary(options, staying, replaced(old.rows, staying))) as rows,
            indexed(rows, own, options, listener.warn),
        ):
            listener.begin(own, rows.path)
            if options.resume and old.damaged:
                listener.warn(f"{rows.path}: {counted(old.damaged, 'damaged row')} dropped")
            for number, row in done.items():
                listener.finish(number, row, unchanged=True)
            results = dict(done)
            for entry, outcome in dispatch(left, workers, listener) if workers else ():
                results[entry.number] = row = place_files(entry, outcome, options)
                rows.append(row)
                listener.finish(entry.number, row)
            rows.end()
    return totals([results[entry.number] for entry in own], len(done))
