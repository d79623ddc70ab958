"""The part of a batch that runs in worker processes, here or on a cluster: it takes a job and returns an outcome."""

import errno
from collections.abc import Mapping
from dataclasses import field, replace
from hashlib import sha256

from bubblemesh import __version__
from bubblemesh.batch.row import Row, figures_of
from bubblemesh.case import Case
from bubblemesh.errors import BubblemeshError, FileError, located
from bubblemesh.files import UnwrittenError, local_copies, no_place, temporary_folder
from bubblemesh.problem.files import inputs_digest
from bubblemesh.problem.prepare import prepare
from bubblemesh.process.resources import forget_peak_memory
from bubblemesh.records import record
from bubblemesh.run.destination import Destination
from bubblemesh.run.limits import within_limits
from bubblemesh.run.packing import RunOptions
from bubblemesh.run.pipeline import mesh_problem
from bubblemesh.workers.workers import Tell

FULL = {errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC)}
APART = {"formats", "solver", "directory", "report"}  # keys of the output on which the contents of files do not depend


@record
class BatchJob:
    """A case with everything that is needed to mesh it on any machine."""

    number: int  # the case's place in the batch
    row: Row  # what is known of the case before it is meshed
    case: Case
    destination: Destination
    files: Mapping[str, bytes | BubblemeshError]  # contents of the files that the case names; errors of unreadable ones
    version: str = __version__  # of bubblemesh, the only one that may mesh it

    def digest(self) -> str | None:
        """Hash of everything that a finished mesh and its files depend on; None if a file could not be read.

        The contents of files count, but not their folders. Limits on time and memory, and which files are written
        beside the mesh, do not count either.
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
    """Result of a job: the row of its case, and the contents of its files."""

    row: Row
    files: Mapping[str, bytes] = field(default_factory=dict)  # contents of the files to write, all or none
    full: bool = False  # whether a disk was full, which would stop the cases to come as well


def mesh_job(job: BatchJob, tell: Tell) -> Outcome:
    """Mesh a case and make its files; errors become part of the outcome."""
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
        return within_limits(job.case, lambda: _made(job, tell))


def _made(job: BatchJob, tell: Tell) -> Outcome:
    with local_copies(job.files):
        problem = prepare(job.case)
    result = mesh_problem(problem, RunOptions(lambda row: tell((job.number, row.round, row.nodes_after))))
    with temporary_folder() as folder:
        report = replace(job.destination, folder=folder, lasting=False).write_result(result)
        files = {name: (folder / name).read_bytes() for name in report["files"]}
    digests = {name: sha256(content).hexdigest() for name, content in files.items()}
    row = replace(job.row, figures=figures_of(report), warnings=tuple(report["warnings"]), files=digests)
    if result.verdict is not None:
        row = row.failed(result.verdict.exit_code, f"{row.source}: {result.verdict}")
    return Outcome(row, files)


def is_full(error: BaseException) -> bool:
    """Whether an error, or the error of the system behind it, is about a full disk or an exhausted quota."""
    cause = error.__cause__ or error
    # Errors of libraries that write arrays, such as NumPy, have no number.
    unnumbered = isinstance(error, UnwrittenError) and isinstance(cause, OSError) and cause.errno is None
    return unnumbered or (isinstance(cause, OSError) and cause.errno in FULL)
