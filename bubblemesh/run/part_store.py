"""Where the parts of a run are kept while it goes on, and after it was ended, for one that goes on with them."""

import shutil
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from glob import escape
from pathlib import Path

from bubblemesh import __version__
from bubblemesh.case import Case
from bubblemesh.errors import CaseError
from bubblemesh.files import locked, temporary_folder, unwritten
from bubblemesh.meshfiles.formats import whole_only
from bubblemesh.meshfiles.transaction import existing
from bubblemesh.parts.store import IN_MEMORY, InFolder, Keeping
from bubblemesh.problem.files import contents_of, inputs_digest
from bubblemesh.run.destination import Destination, StreamDestination

_PREFIX = ".bubblemesh-parts-"
DIGITS = 16  # of the hash in a folder's name


@contextmanager
def parts_kept(case: Case, place: Destination | StreamDestination, resume: bool, *, shared: bool) -> Iterator[Keeping]:
    """Keep the parts of a case beside its results until the block ends; ``shared`` is that of `InFolder`.

    To ``resume``, those of an earlier run with the same inputs are there, and if the block ends with an exception they
    stay. CaseError if that has no parts, or the results no folder.
    """
    if case.parts is None or not isinstance(place, Destination):
        if resume and case.parts is None:
            raise CaseError("--resume: a mesh in one piece has no parts to go on with: add --parts auto")
        if resume:
            raise CaseError("--resume: there is no place for the parts with -o -: name a folder or a file")
        yield IN_MEMORY
        return
    in_slices, kept = not whole_only(place.formats), f".{place.name}.parts-"
    with ExitStack() as until_end:
        try:
            until_end.enter_context(existing(place.folder, lasting=False))
            folder: Path | None = None
            if resume:
                digest = inputs_digest(case, contents_of(case, case.root), version=__version__, in_slices=in_slices)
                folder = until_end.enter_context(_remaining(place.folder / f"{kept}{digest[:DIGITS]}"))
            elif in_slices:
                folder = until_end.enter_context(temporary_folder(place.folder, _PREFIX))
        except OSError as error:
            raise unwritten(place.folder, error) from error
        yield IN_MEMORY if folder is None else Keeping(partial(_store, folder, shared), in_slices)
        # The mesh is there: what earlier runs have left for one that goes on is not needed any more.
        _remove_abandoned(place.folder.glob(escape(kept) + DIGITS * "[0-9a-f]"), but=folder)


@contextmanager
def _remaining(folder: Path) -> Iterator[Path]:
    """A folder that stays after an exception, and otherwise goes; CaseError if another run is at work there."""
    folder.mkdir(exist_ok=True)
    with locked(folder) as mine:
        if not (mine and folder.exists()):  # the other one may just have ended
            raise CaseError(f"--resume: another run is at work with the parts in {folder}: wait until it has ended")
        try:
            yield folder
        except BaseException:
            with suppress(OSError):
                folder.rmdir()  # if nothing was done
            raise
        shutil.rmtree(folder, ignore_errors=True)


def _remove_abandoned(folders: Iterable[Path], but: Path | None) -> None:
    """Remove folders with which no run is at work."""
    for folder in folders:
        if folder != but:
            with suppress(OSError), locked(folder) as abandoned:
                if abandoned:
                    shutil.rmtree(folder, ignore_errors=True)


def _store(folder: Path, shared: bool, name: str) -> InFolder:
    """Where the parts of the packing of some name are kept."""
    own = folder / name
    try:
        own.mkdir(exist_ok=True)
    except OSError as error:
        raise unwritten(own, error) from error
    return InFolder(own, shared=shared)
