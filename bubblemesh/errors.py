"""Exception tree: one class for each exit code of the command line."""

from collections.abc import Iterator
from contextlib import contextmanager

__all__ = [
    "OUT_OF_MEMORY",
    "BubblemeshError",
    "CaseError",
    "FileError",
    "GeometryError",
    "LimitError",
    "RequirementError",
    "located",
    "outcome",
]

OUT_OF_MEMORY = "out of memory: coarsen the spacing, or lower limits.max_nodes to stop earlier"


class BubblemeshError(Exception):
    """Base class of every error a user can cause; its text says where it is and what to do."""

    exit_code = 1


class CaseError(BubblemeshError):
    """The case file, an option or the spacing is invalid."""

    exit_code = 2


class GeometryError(BubblemeshError):
    """The rings do not bound a domain."""

    exit_code = 3


class RequirementError(BubblemeshError):
    """The mesh was written, but misses a quality that the case requires."""

    exit_code = 4


class FileError(BubblemeshError):
    """A file cannot be read or written."""

    exit_code = 5


class LimitError(BubblemeshError):
    """The case needs more nodes or time than its limit allows."""

    exit_code = 6


def outcome(exit_code: int) -> str:
    """What has become of a case with this exit code, as batches count it."""
    return {0: "done", RequirementError.exit_code: "missed a requirement"}.get(exit_code, "failed")


@contextmanager
def located(source: str) -> Iterator[None]:
    """Put the place that errors of the case come from before their texts."""
    try:
        yield
    except BubblemeshError as error:
        key = "domain: " if isinstance(error, GeometryError) else ""
        error.args = (f"{source}: {key}{error}",)
        raise
