"""A limit on the memory of the process, on systems that can set one."""

import errno
from pathlib import Path
from threading import Lock

from bubblemesh.errors import Key, LimitError

MEGABYTE = 1e6
MEMORY = Path("/proc/self/statm")  # of Linux: memory of the process, in pages
HELD, DATA = 1, 5  # positions in that file of the pages in memory, and of all pages for data


class MemoryLimit:
    """Limit on the memory of the process, on systems that can set one; of several limits the least one holds."""

    _lock = Lock()
    _before: tuple[int, int] | None = None  # the system's limits before ours
    _active: "list[MemoryLimit]" = []  # noqa: RUF012 - of the whole process

    def __init__(self, megabytes: float | None, place: str) -> None:
        self.megabytes, self._place = megabytes, place
        self._data = 0  # bytes that the process may have for data

    def begin(self) -> None:
        """Limit the memory from now on; LimitError if the process holds as much already."""
        if self.megabytes is None or not memory_can_be_limited():
            return
        import resource

        pages = [int(number) * resource.getpagesize() for number in MEMORY.read_text().split()]
        data, held = pages[DATA], pages[HELD]
        if held > self.megabytes * MEGABYTE:
            raise self._error(f"the program alone holds {held / MEGABYTE:.0f} MB: raise the limit")
        # The limit is on data, not on all that is mapped: the heap of each thread is mapped whole in advance.
        self._data = data + int(self.megabytes * MEGABYTE) - held
        with self._lock:
            if MemoryLimit._before is None:
                MemoryLimit._before = resource.getrlimit(resource.RLIMIT_DATA)
            self._active.append(self)
            self._apply()

    def end(self) -> None:
        """Lift the limit."""
        with self._lock:
            if self in self._active:
                self._active.remove(self)
                self._apply()

    def error(self, cause: BaseException) -> LimitError | None:
        """The LimitError of a run that was ended by ``cause``; None if the limit did not bring that about."""
        if self not in self._active or not _lacks_memory(cause):
            return None
        return self._error(f"more than the limit of {self.megabytes:g} MB is needed: coarsen the spacing or raise it")

    def _error(self, problem: str) -> LimitError:
        error = LimitError(f"{self._place}limits.max_memory_mb: {problem}")
        error.about = Key(["limits", "max_memory_mb"])
        return error

    def _apply(self) -> None:
        import resource

        assert MemoryLimit._before is not None
        soft, hard = MemoryLimit._before
        given = [value for value in (soft, hard) if value != resource.RLIM_INFINITY]
        least = min([*given, *(limit._data for limit in self._active)], default=soft)
        resource.setrlimit(resource.RLIMIT_DATA, (least if self._active else soft, hard))
        if not self._active:
            MemoryLimit._before = None


def memory_can_be_limited() -> bool:
    """Whether the system can limit the memory of a process, and shows how much it holds."""
    return MEMORY.exists()


def unlimited_memory(megabytes: float | None) -> list[str]:
    """Warning about a limit on memory if this system cannot set it."""
    if megabytes is None or memory_can_be_limited():
        return []
    return ["limits.max_memory_mb: this system cannot limit the memory of a process: watch it, or run on Linux"]


def _lacks_memory(error: BaseException) -> bool:
    """Whether an error of Python, the system, GEOS or the loader of libraries is about memory."""
    return any(
        isinstance(one, MemoryError)
        or (isinstance(one, OSError) and one.errno == errno.ENOMEM)
        # These two tell it by their texts alone.
        or (isinstance(one, ImportError) and "Cannot allocate memory" in str(one))
        or (type(one).__name__ == "GEOSException" and "bad_alloc" in str(one))
        for one in (error, error.__cause__)
    )
