"""What became of a case, on the disk and as a row."""

from dataclasses import replace
from pathlib import Path

from bubblemesh import __version__
from bubblemesh.batch.dispatch import Ended
from bubblemesh.batch.jobs import Outcome
from bubblemesh.batch.resuming import place_in
from bubblemesh.batch.rows import Row, figures_of
from bubblemesh.batch.space import MAKE_ROOM, is_full
from bubblemesh.batch.staging import Staging
from bubblemesh.errors import FileError
from bubblemesh.meshfiles.transaction import transaction


def delivered(ended: Ended, staging: Staging) -> Row:
    """Write the files of a case, all or none, and give its row.

    Raises
    ------
    FileError
        If a disk is full: that of the results, or of a worker.
    """
    entry, outcome = ended.entry, ended.outcome
    if outcome.files and entry.place is not None and entry.place.folder is not None:
        try:
            with transaction(entry.place.folder, staging.prefix(entry.place.folder)) as folder:
                for name, content in outcome.files.items():
                    (folder / name).write_bytes(content)
        except FileError as error:
            problem = f"{entry.source}: {error}"
            outcome = Outcome(error.exit_code, problem, warnings=outcome.warnings, full=is_full(error))
    if outcome.full:
        raise FileError(f"{outcome.error}: {MAKE_ROOM}")
    return _row(replace(ended, outcome=outcome), staging.root)


def _row(ended: Ended, root: Path) -> Row:
    entry, outcome = ended.entry, ended.outcome
    return Row(
        case=entry.name,
        source=entry.source,
        sweep=dict(entry.variant.values),
        exit_code=outcome.exit_code,
        error=outcome.error,
        figures=figures_of(outcome.report),
        warnings=outcome.warnings,
        attempts=ended.attempts,
        folder=place_in(root, entry),
        version=__version__,
        inputs=ended.inputs,
        files=dict(outcome.digests),
        traceback=outcome.traceback,
    )
