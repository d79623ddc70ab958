"""The part of a batch that runs in worker processes, here or on a cluster: a job goes in, an outcome comes back."""

import errno
import re
from collections.abc import Mapping
from dataclasses import field, replace
from hashlib import sha256

from bubblemesh import __version__
from bubblemesh.batch.row import Row, figures_of
from bubblemesh.case import Case
from bubblemesh.errors import BubblemeshError, FileError, located
from bubblemesh.files import local_copies, no_place, temporary_folder
from bubblemesh.problem.files import inputs_digest
from bubblemesh.problem.prepare import prepare
from bubblemesh.process.resources import forget_peak_memory
from bubblemesh.records import record
from bubblemesh.run.destination import Destination
from bubblemesh.run.pipeline import mesh_problem
from bubblemesh.workers.workers import Tell

FULL = {errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC)}
APART = {"formats", "solver", "directory", "report"}  # keys of the output that do not tell what is in files
CUT_SHORT = re.compile(r"\d+ requested and \d+ written")  # what NumPy's tofile says, without a number


@record
class BatchJob:
    """A case with everything that meshing it takes, wherever that happens."""

    number: int  # the case's place in the batch
    row: Row  # what is known of the case before it is meshed
    case: Case
    destination: Destination
    files: Mapping[str, bytes | BubblemeshError]  # contents of those that the case names, errors of those not read
    version: str = __version__  # of bubblemesh, which has to mesh it

    def digest(self) -> str | None:
        """Hash of all that a finished mesh and its files depend on; None if one of them could not be read.

        Where files lie does not count, what is in them does. Nor does it count which files are written beside the mesh,
        and how much time and memory there was.
        """
        contents = {name: content for name, content in self.files.items() if isinstance(content, bytes)}
        if len(contents) < len(self.files):
            return None
        return inputs_digest(
            self.case,
            contents,
            version=self.version,
            formats=self.destination.formats,
            output=self.case.output.model_dump(mode="json", exclude=APART),
        )


@record
class Outcome:
    """Row and files that come back for a job."""

    row: Row
    files: Mapping[str, bytes] = field(default_factory=dict)  # contents of the files to write, all or none
    full: bool = False  # whether there was no space on a disk, which the cases to come would meet as well


def mesh_job(job: BatchJob, tell: Tell) -> Outcome:
    """Mesh a case and make its files; an error is an outcome, too."""
    row = job.row
    try:
        return _mesh(job, tell)
    except OSError as error:
        return Outcome(row.failed(FileError.exit_code, f"{row.source}: {no_place(error)}"), full=is_full(error))
    except Exception as error:
        return Outcome(row.ended_by(error), full=is_full(error))


def _mesh(job: BatchJob, tell: Tell) -> Outcome:
    if job.version != __version__:
        raise FileError(
            f"a worker has bubblemesh {__version__}, the batch {job.version}: install the same version for both"
        )
    tell((job.number, 0, 0))
    forget_peak_memory()
    with located(job.row.source, job.case.origin):
        return job.case.within_limits(lambda: _made(job, tell))


def _made(job: BatchJob, tell: Tell) -> Outcome:
    with local_copies(job.files):
        problem = prepare(job.case)
    result = mesh_problem(problem, lambda row: tell((job.number, row.round, row.nodes_after)))
    with temporary_folder() as folder:
        report = replace(job.destination, folder=folder, lasting=False).deliver(result)
        files = {name: (folder / name).read_bytes() for name in report["files"]}
    digests = {name: sha256(content).hexdigest() for name, content in files.items()}
    row = replace(job.row, figures=figures_of(report), warnings=tuple(report["warnings"]), files=digests)
    if result.verdict is not None:
        row = row.failed(result.verdict.exit_code, f"{row.source}: {result.verdict}")
    return Outcome(row, files)


def is_full(error: BaseException) -> bool:
    """Whether an error of the system, or the one behind an error of ours, is about a full disk or a used-up quota."""
    cause = error.__cause__ or error
    return isinstance(cause, OSError) and (cause.errno in FULL or CUT_SHORT.search(str(cause)) is not None)
