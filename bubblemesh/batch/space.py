"""Whether an error is the want of space on a disk, which the cases to come would meet as well."""

import errno
import re

FULL = {errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC)}
CUT_SHORT = re.compile(r"\d+ requested and \d+ written")  # what NumPy's tofile says, without a number

MAKE_ROOM = "the batch ends, what is done stays: make room, and run it again with --resume"


def is_full(error: BaseException) -> bool:
    """Whether an error of the system, or the one behind an error of ours, is about a full disk or a used-up quota."""
    cause = error.__cause__ or error
    return isinstance(cause, OSError) and (cause.errno in FULL or CUT_SHORT.search(str(cause)) is not None)
