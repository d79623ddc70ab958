"""Where the parts of a run are kept while it goes on, and after it was ended, for one that goes on with them."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
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
    """Keep the parts of a case beside its results until the block ends; ``shared`` as of `InFolder`.

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
    in_slices = not whole_only(place.formats)
    try:
        with existing(place.folder, lasting=False):
            if resume:
                digest = inputs_digest(case, contents_of(case, case.root), version=__version__, in_slices=in_slices)
                with _remaining(place.folder, f".{place.name}.parts-", digest[:DIGITS]) as folder:
                    yield Keeping(lambda scale: InFolder(_within(folder, scale), shared=shared), in_slices)
            elif in_slices:
                with temporary_folder(place.folder, _PREFIX) as folder:
                    yield Keeping(lambda scale: InFolder(_within(folder, scale), shared=shared), in_slices)
            else:
                yield IN_MEMORY
    except OSError as error:
        raise unwritten(place.folder, error) from error


@contextmanager
def _remaining(parent: Path, prefix: str, digest: str) -> Iterator[Path]:
    """A folder that stays after an exception; otherwise it goes, and those of other inputs with it.

    CaseError if another run is at work there.
    """
    folder = parent / f"{prefix}{digest}"
    folder.mkdir(exist_ok=True)
    with locked(folder) as mine:
        if not mine:
            raise CaseError(f"--resume: another run is at work with the parts in {folder}: wait until it has ended")
        try:
            yield folder
        except BaseException:
            with suppress(OSError):
                folder.rmdir()  # if nothing was done
            raise
        for other in parent.glob(f"{escape(prefix)}*"):
            with suppress(OSError), nullcontext(True) if other == folder else locked(other) as abandoned:
                if abandoned:
                    shutil.rmtree(other, ignore_errors=True)


def _within(folder: Path, scale: float) -> Path:
    """Folder for the parts of a packing by the factor of its spacing."""
    own = folder / repr(scale)
    own.mkdir(exist_ok=True)
    return own
