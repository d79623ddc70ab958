"""The part of a batch that runs in worker processes, here or on a cluster."""

import traceback
from collections.abc import Mapping
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from bubblemesh import __version__
from bubblemesh.batch.jobs import Job, Note, Outcome, Tell
from bubblemesh.batch.space import is_full
from bubblemesh.errors import OUT_OF_MEMORY, BubblemeshError, FileError, LimitError, RequirementError, located
from bubblemesh.files import local_copies, reason
from bubblemesh.problem.problem import prepared
from bubblemesh.run.destination import require_finished, require_quality
from bubblemesh.run.pipeline import Result, meshed
from bubblemesh.run.resources import forget_peak_memory


def mesh_job(job: Job, tell: Tell) -> Outcome:
    """Mesh a case and make its files; an error is an outcome, too."""
    try:
        return _outcome(job, tell)
    except BubblemeshError as error:
        return Outcome(error.exit_code, str(error), full=is_full(error))
    except MemoryError:
        return Outcome(LimitError.exit_code, f"{job.source}: {OUT_OF_MEMORY}")
    except OSError as error:
        problem = f"{job.source}: no place for temporary files: {reason(error)}"
        return Outcome(FileError.exit_code, problem, full=is_full(error))
    except Exception as error:
        problem = f"{job.source}: this is an error of bubblemesh, not of the case: {type(error).__name__}: {error}"
        return Outcome(1, problem, traceback=traceback.format_exc())


def _outcome(job: Job, tell: Tell) -> Outcome:
    if job.version != __version__:
        raise FileError(
            f"a worker has bubblemesh {__version__}, the batch {job.version}: install the same version for both"
        )
    tell(Note(job.number))
    forget_peak_memory()
    with located(job.source, job.case.origin):
        with local_copies(job.files):
            problem = prepared(job.case)
        result = meshed(problem, lambda row: tell(Note(job.number, row.round, row.nodes_after)))
        report, files = _delivered(job, result)
    digests = {name: sha256(content).hexdigest() for name, content in files.items()}
    outcome = Outcome(report=report, warnings=tuple(report["warnings"]), files=files, digests=digests)
    try:
        require_finished(report)
        require_quality(job.case, report)
    except (LimitError, RequirementError) as error:
        return replace(outcome, exit_code=error.exit_code, error=f"{job.source}: {error}")
    return outcome


def _delivered(job: Job, result: Result) -> tuple[Mapping[str, Any], dict[str, bytes]]:
    """The report, and the contents of all files."""
    with TemporaryDirectory(prefix="bubblemesh-") as folder:
        report = replace(job.place, folder=Path(folder)).deliver(result)
        return report, {name: Path(folder, name).read_bytes() for name in report["files"]}
